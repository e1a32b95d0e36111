"""Figures of the Modelica library's examples, drawn from their simulations in rumoca.

    PYTHONPATH=tests python tests/modelica/figures.py [EXAMPLE...]

Run it when an example changes, and look at what it draws. A picture has the curves of the figures
that the class itself declares, for Modelica tools to draw: test_figures compares. rumoca does not call
external C: where an example compares with an FMU, the FMU's C core is run over the same inputs.
"""

import sys
from dataclasses import dataclass

import numpy as np
from library import LIBRARY
from matplotlib import rc_context
from matplotlib.figure import Figure
from test_components import simulate

from it2hys.model import compiled
from it2hys.model.parameters import table_1
from it2hys.reports.figures import MEASURED, MODEL, STYLE, png
from it2hys.support.files import write_atomically

MICROMETRES, VOLTS = "displacement in µm", "voltage in V"
STYLES = (MEASURED, MODEL, {"color": "tab:green", "lw": 1.0})
SCALES = {"µm": 1e6, "mA": 1e3}


@dataclass(frozen=True)
class Panel:
    """A label with its unit, legends by variable (none where there is one), x axis, where y is 0."""

    label: str
    curves: dict[str, str]
    x: str = "time"
    x_label: str = "time in s"
    zero: float = 0.0


def loop(voltage: str, displacement: str) -> Panel:
    """Return a panel of a displacement over a voltage."""
    return Panel(MICROMETRES, {displacement: ""}, voltage, VOLTS)


def scaled(values: np.ndarray, label: str) -> np.ndarray:
    """Return values in the unit that a label ends with."""
    return np.asarray(values) * SCALES.get(label.rsplit(" ", 1)[-1], 1.0)


def at_ticks(time: np.ndarray, sample_time: float = 1e-4) -> np.ndarray:
    """Return the rows of a result that hold after the event of each tick."""
    ticks = round(time[-1] / sample_time)
    # events of what compares an example with its stored result follow 0.05 of a tick later
    return np.searchsorted(time, (np.arange(ticks) + 0.02) * sample_time) - 1


def draw(example: str, panels: tuple[Panel, ...]) -> None:
    """Simulate an example and draw its panels: loops at the ticks, between which they have stairs."""
    result = simulate(example)
    signals = {name: np.asarray(result[name]) for p in panels for name in p.curves}
    signals |= {p.x: np.asarray(result[p.x]) for p in panels if p.x != "time"}
    signals["time"] = np.asarray(result.time)
    ticks = at_ticks(signals["time"])
    if example == "FMUAgainstPureModelica":
        signals = {name: values[ticks] for name, values in signals.items()} | by_the_fmus(result, ticks)
        ticks = np.arange(len(ticks))
    columns = 2 if len(panels) > 3 else 1
    rows = -(-len(panels) // columns)
    with rc_context(STYLE):
        figure = Figure(figsize=(6.4 if columns == 1 else 7.2, 1.9 + 1.9 * rows if rows > 1 else 4.0))
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for axis, panel in zip(axes, panels, strict=False):
            chosen = slice(None) if panel.x == "time" else ticks
            x = scaled(signals[panel.x][chosen], panel.x_label)
            for (name, legend), style in zip(panel.curves.items(), STYLES, strict=False):
                axis.plot(
                    x,
                    scaled(signals[name][chosen] - panel.zero, panel.label),
                    label=legend or None,
                    **style,
                )
            axis.set(xlabel=panel.x_label, ylabel=panel.label)
            if any(panel.curves.values()):
                axis.legend(ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1)
        for axis in axes[len(panels) :]:
            axis.set_axis_off()
        write_atomically(LIBRARY / f"Resources/Images/Examples/{example}.png", png(figure))
    print(example)


def by_the_fmus(result, ticks: np.ndarray) -> dict[str, np.ndarray]:
    """Return what the FMUs give at the ticks of FMUAgainstPureModelica, and the differences."""
    at = {n: np.asarray(result[f"{n}.y"])[ticks] for n in ("voltage", "force", "reference")}
    stage = table_1().replace(**ALL_EFFECTS)
    plant, _ = compiled.chain_free_run(stage, at["voltage"], at["force"])
    inverse, _ = compiled.chain_inverse_run(stage, at["reference"], at["force"])
    pure, voltage = (
        np.asarray(result[n])[ticks] for n in ("plantPure.displacement", "inversePure.voltage")
    )
    return {
        "plantFMU.displacement": plant,
        "plantDifference.y": plant - pure,
        "inverseFMU.voltage": inverse,
        "inverseDifference.y": inverse - voltage,
    }


#: What FMUAgainstPureModelica.stage changes in Table 1.
ALL_EFFECTS = {
    "initialDisplacement": 5e-6,
    "delay.time": 1.5e-4,
    "slew.rate": 1e4,
    "saturation.minimum": 5.0,
    "saturation.maximum": 90.0,
    "lag.timeConstant": 2e-4,
    "playCount": 2,
    "play[1].threshold": 2.0,
    "play[2].threshold": 8.0,
    "play[1].weight": 0.04,
    "play[2].weight": 0.06,
    "load.compliance": 1e-8,
    "creepCount": 2,
    "creep[1].gain": 0.02,
    "creep[2].gain": 0.01,
    "creep[1].timeConstant": 5e-3,
    "creep[2].timeConstant": 0.5,
    "resonance.frequency": 2500.0,
    "resonance.damping": 0.1,
    "drift.temperatureCoefficient": 1e-8,
    "drift.rate": 1e-7,
    "nonlinearity.quadratic": 1e-7,
    "nonlinearity.cubic": 5e-8,
    "nonlinearity.quartic": -5e-8,
    "hum.amplitude": 2e-8,
    "hum.frequency": 50.0,
    "hum.phase": 0.5,
}


FIGURES = {
    "HysteresisLoop": (loop("held.y", "plant.displacement"),),
    "FeedforwardTracking": (
        Panel(MICROMETRES, {"inverse.reference": "reference", "plant.displacement": "displacement"}),
        Panel(VOLTS, {"inverse.voltage": ""}),
        loop("plant.voltage", "plant.displacement"),
    ),
    "FeedforwardFeedback": (
        Panel(
            "error in µm",
            {"errorFeedforward.y": "feedforward", "errorClosed.y": "feedforward and PI"},
        ),
        Panel("correction in V", {"controller.y": ""}),
    ),
    "IntegralFeedback": (
        Panel(
            MICROMETRES,
            {"reference.y": "reference", "ringing.displacement": "with a proportional part"},
        ),
        Panel(MICROMETRES, {"reference.y": "reference", "plant.displacement": "integral part alone"}),
        Panel(VOLTS, {"first.y": "with a proportional part", "second.y": "integral part alone"}),
    ),
    "FlexureStage": (
        Panel(MICROMETRES, {"gauge.y": "gauge", "actuator.s_rel": "stack"}),
        loop("actuator.v", "actuator.s_rel"),
        Panel("platform above 18 mm in µm", {"platform.s": ""}, zero=18e-3),
        Panel("current in mA", {"actuator.i": ""}),
        Panel(VOLTS, {"actuator.v": ""}),
    ),
    "DisturbanceForce": (
        Panel(MICROMETRES, {"reference.y": "reference", "actuator.s_rel": "displacement"}),
        Panel("correction in V", {"controller.y": ""}),
        Panel("force in N", {"pulse.y": ""}),
    ),
    "FMUAgainstPureModelica": (
        Panel(MICROMETRES, {"plantFMU.displacement": "FMU", "plantPure.displacement": "pure Modelica"}),
        Panel("difference in µm", {"plantDifference.y": ""}),
        Panel(VOLTS, {"inverseFMU.voltage": "FMU", "inversePure.voltage": "pure Modelica"}),
        Panel("difference in V", {"inverseDifference.y": ""}),
    ),
    "SlowCreep": (
        Panel(
            MICROMETRES,
            {
                "reference.y": "reference",
                "creeping.displacement": "without creep",
                "plant.displacement": "with creep",
            },
        ),
        Panel(VOLTS, {"without.voltage": "without creep", "inverse.voltage": "with creep"}),
    ),
    "TemperatureDrift": (
        Panel(
            MICROMETRES,
            {
                "reference.y": "reference",
                "drifting.displacement": "temperature not known",
                "plant.displacement": "temperature known",
            },
        ),
        Panel("temperature in K", {"frame.T": ""}),
    ),
    "FMUStage": (
        Panel(MICROMETRES, {"reference.y": "reference", "gauge.y": "strain gauge"}),
        Panel("platform in µm", {"sensor.y": ""}),
        Panel(VOLTS, {"amplifier.v": ""}),
    ),
    "MeasuredRecord": (
        Panel(
            MICROMETRES,
            {
                "measurement.y[2]": "measured",
                "before.displacement": "before",
                "after.displacement": "after",
            },
        ),
        Panel("error in µm", {"errorBefore.y": "before", "errorAfter.y": "after"}),
    ),
    "TwoStages": (
        Panel(
            MICROMETRES, {"sensor.y": "tip", "coarse.s_rel": "coarse stack", "fine.s_rel": "fine stack"}
        ),
        Panel(VOLTS, {"coarse.v": "coarse stack", "fine.v": "fine stack"}),
    ),
}

if __name__ == "__main__":
    for name in sys.argv[1:] or FIGURES:
        draw(name, FIGURES[name])
