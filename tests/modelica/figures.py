"""Figures of the Modelica library's examples, drawn from their simulations in rumoca.

    PYTHONPATH=tests python tests/modelica/figures.py [EXAMPLE...]

Run it when an example changes, and look at what it draws; first `reference.py`, whose stored results
some are drawn from. rumoca does not call external C: where an example compares with an FMU, the FMU's C
core is run over the same inputs.
"""

import sys
from functools import partial

import numpy as np
from library import LIBRARY, stored_result
from matplotlib import rc_context
from matplotlib.figure import Figure
from test_components import simulate

from it2hys.model import compiled
from it2hys.model.parameters import table_1
from it2hys.reports.figures import MEASURED, MODEL, STYLE, UM, png
from it2hys.support.files import write_atomically

TIME, MICROMETRES, VOLTS = "time in s", "displacement in µm", "voltage in V"
EXAMPLES = "IT2Hysteresis.Examples"
THIRD = {"color": "tab:green", "lw": 1.0}


def draw(panels: list[tuple], example: str, height: float = 4.6, columns: int = 1) -> None:
    """Draw panels: x label, y label, curves of (x, y, legend or None)."""
    with rc_context(STYLE):
        figure = Figure(figsize=(6.4 if columns == 1 else 7.2, height))
        axes = figure.subplots(-(-len(panels) // columns), columns, squeeze=False).ravel()
        for axis, (x_label, y_label, curves) in zip(axes, panels, strict=True):
            for (x, y, legend), style in zip(curves, (MEASURED, MODEL, THIRD), strict=False):
                axis.plot(x, y, label=legend, **style)
            axis.set(xlabel=x_label, ylabel=y_label)
            if any(legend for _, _, legend in curves):
                axis.legend(ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1)
        write_atomically(LIBRARY / f"Resources/Images/Examples/{example}.png", png(figure))
        print(example)


def feedforward_feedback() -> None:
    """Errors with and without feedback, and the correction."""
    r = simulate("FeedforwardFeedback")
    t = np.asarray(r.time)
    errors = [
        (t, r["errorFeedforward.y"] * UM, "feedforward"),
        (t, r["errorClosed.y"] * UM, "feedforward and PI"),
    ]
    correction = [(t, r["controller.y"], None)]
    draw([(TIME, "error in µm", errors), (TIME, "correction in V", correction)], "FeedforwardFeedback")


def flexure_stage() -> None:
    """Displacement, voltage and current over time, and the loop."""
    r = simulate("FlexureStage")
    t = np.asarray(r.time)
    moved = (r["platform.s"] - 18e-3) * UM
    draw(
        [
            (TIME, MICROMETRES, [(t, r["actuator.s_rel"] * UM, "stack"), (t, moved, "platform")]),
            (VOLTS, MICROMETRES, [(r["actuator.v"], r["actuator.s_rel"] * UM, None)]),
            (TIME, VOLTS, [(t, r["actuator.v"], None)]),
            (TIME, "current in mA", [(t, r["actuator.i"] * 1e3, None)]),
        ],
        "FlexureStage",
        height=5.2,
        columns=2,
    )


def disturbance_force() -> None:
    """Draw reference and displacement, correction and force."""
    r = simulate("DisturbanceForce")
    t = np.asarray(r.time)
    tracked = [(t, r["reference.y"] * UM, "reference"), (t, r["actuator.s_rel"] * UM, "displacement")]
    draw(
        [
            (TIME, MICROMETRES, tracked),
            (TIME, "correction in V", [(t, r["controller.y"], None)]),
            (TIME, "force in N", [(t, r["pulse.y"], None)]),
        ],
        "DisturbanceForce",
        height=5.6,
    )


def at_ticks(result, sample_time: float = 1e-4) -> np.ndarray:
    """Return the rows of a result that hold after the event of each tick."""
    time = np.asarray(result.time)
    ticks = round(time[-1] / sample_time)
    return np.searchsorted(time, (np.arange(ticks) + 0.1) * sample_time) - 1


def hysteresis_loop() -> None:
    """Draw the loop at the ticks: held in between, it would have stairs."""
    r = simulate("HysteresisLoop")
    rows = at_ticks(r)
    loop = [(np.asarray(r["held.y"])[rows], np.asarray(r["plant.displacement"])[rows] * UM, None)]
    draw([(VOLTS, MICROMETRES, loop)], "HysteresisLoop", height=4.0)


def fmu_against_pure_modelica() -> None:
    """Draw both realisations, and how far they are apart."""
    r = simulate("FMUAgainstPureModelica")
    rows = at_ticks(r)
    t = np.asarray(r.time)[rows]
    voltage, force, pure, inverse = (
        np.asarray(r[n])[rows]
        for n in ("voltage.y", "force.y", "plantPure.displacement", "inversePure.voltage")
    )
    stage = table_1().replace(**ALL_EFFECTS)
    fmu, _ = compiled.chain_free_run(stage, voltage, force)
    fmu_inverse, _ = compiled.chain_inverse_run(stage, np.asarray(r["reference.y"])[rows], force)
    draw(
        [
            (TIME, MICROMETRES, [(t, fmu * UM, "FMU"), (t, pure * UM, "pure Modelica")]),
            (TIME, "difference in µm", [(t, (pure - fmu) * UM, None)]),
            (TIME, VOLTS, [(t, fmu_inverse, "FMU"), (t, inverse, "pure Modelica")]),
            (TIME, "difference in V", [(t, inverse - fmu_inverse, None)]),
        ],
        "FMUAgainstPureModelica",
        height=5.2,
        columns=2,
    )


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


def integral_feedback() -> None:
    """Draw both loops."""
    r = simulate("IntegralFeedback")
    t = np.asarray(r.time)
    first = [
        (t, r["reference.y"] * UM, "reference"),
        (t, r["ringing.displacement"] * UM, "proportional and integral"),
    ]
    second = [(t, r["reference.y"] * UM, "reference"), (t, r["plant.displacement"] * UM, "integral")]
    draw([(TIME, MICROMETRES, first), (TIME, MICROMETRES, second)], "IntegralFeedback")


def stored(example: str, *panels: tuple[str, dict[str, str]]) -> None:
    """Draw signals of a stored result: a label with its factor, and legends by signal."""
    t, signals = stored_result(f"{EXAMPLES}.{example}")
    drawn = [
        (
            TIME,
            label,
            [(t, signals[s] * (UM if "µm" in label else 1.0), text) for s, text in of.items()],
        )
        for label, of in panels
    ]
    draw(drawn, example)


FIGURES = {
    "HysteresisLoop": hysteresis_loop,
    "FeedforwardFeedback": feedforward_feedback,
    "IntegralFeedback": integral_feedback,
    "FlexureStage": flexure_stage,
    "DisturbanceForce": disturbance_force,
    "FMUAgainstPureModelica": fmu_against_pure_modelica,
    "SlowCreep": partial(
        stored,
        "SlowCreep",
        (
            MICROMETRES,
            {
                "reference.y": "reference",
                "creeping.displacement": "without creep",
                "plant.displacement": "with creep",
            },
        ),
        ("voltage with creep in V", {"inverse.voltage": None}),
    ),
    "TemperatureDrift": partial(
        stored,
        "TemperatureDrift",
        (
            MICROMETRES,
            {
                "drifting.displacement": "temperature not known",
                "plant.displacement": "temperature known",
            },
        ),
        ("temperature in K", {"frame.T": None}),
    ),
    "FMUStage": partial(
        stored,
        "FMUStage",
        (
            MICROMETRES,
            {"reference.y": "reference", "actuator.s_rel": "stack", "sensor.y": "platform"},
        ),
        (VOLTS, {"inverse.voltage": None}),
    ),
    "MeasuredRecord": partial(
        stored,
        "MeasuredRecord",
        (MICROMETRES, {"before.displacement": "before", "after.displacement": "after"}),
        ("error in µm", {"errorBefore.y": "before", "errorAfter.y": "after"}),
    ),
    "TwoStages": partial(
        stored,
        "TwoStages",
        (MICROMETRES, {"sensor.y": "tip", "coarse.s_rel": "coarse stack", "fine.s_rel": "fine stack"}),
        ("current of the fine stack in A", {"fine.i": None}),
    ),
}

if __name__ == "__main__":
    for name in sys.argv[1:] or FIGURES:
        FIGURES[name]()
