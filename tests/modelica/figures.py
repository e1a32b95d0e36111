"""Figures of the Modelica library's examples, drawn from their simulations in rumoca.

    PYTHONPATH=tests python tests/modelica/figures.py

Run it when an example changes, and look at what it draws. rumoca does not call external C, so what
is drawn of FMUAgainstPureModelica is the pure Modelica.
"""

import numpy as np
import rumoca
from library import LIBRARY, PREAMBLE
from matplotlib import rc_context
from matplotlib.figure import Figure
from test_simulation import compile_model

from it2hys.reports.figures import MEASURED, MODEL, STYLE, UM, png
from it2hys.support.files import write_atomically

TIME, MICROMETRES, VOLTS = "time in s", "displacement in µm", "voltage in V"
EXAMPLES = "IT2Hysteresis.Examples"


def simulate(example: str, stop: float, step: float = 1e-4) -> rumoca.Result:
    """Simulate an example."""
    source = f"model M {PREAMBLE} extends {EXAMPLES}.{example}; end M;"
    return compile_model(source).simulate(
        t=(0.0, stop), dt=step, config=rumoca.SimConfig(solver="rk-like")
    )


def draw(panels: list[tuple], example: str, height: float = 4.6, columns: int = 1) -> None:
    """Draw panels: x label, y label, curves of (x, y, legend or None)."""
    with rc_context(STYLE):
        figure = Figure(figsize=(6.4 if columns == 1 else 7.2, height))
        axes = figure.subplots(-(-len(panels) // columns), columns, squeeze=False).ravel()
        for axis, (x_label, y_label, curves) in zip(axes, panels, strict=True):
            for (x, y, legend), style in zip(curves, (MEASURED, MODEL), strict=False):
                axis.plot(x, y, label=legend, **style)
            axis.set(xlabel=x_label, ylabel=y_label)
            if any(legend for _, _, legend in curves):
                axis.legend(ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1)
        write_atomically(LIBRARY / f"Resources/Images/Examples/{example}.png", png(figure))
        print(example)


def feedforward_feedback() -> None:
    """Errors with and without feedback, and the correction."""
    r = simulate("FeedforwardFeedback", 0.2)
    t = np.asarray(r.time)
    errors = [
        (t, r["errorFeedforward.y"] * UM, "feedforward"),
        (t, r["errorClosed.y"] * UM, "feedforward and PI"),
    ]
    correction = [(t, r["controller.y"], None)]
    draw([(TIME, "error in µm", errors), (TIME, "correction in V", correction)], "FeedforwardFeedback")


def flexure_stage() -> None:
    """Displacement, voltage and current over time, and the loop."""
    r = simulate("FlexureStage", 0.12, 1e-5)
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
    r = simulate("DisturbanceForce", 0.25, 1e-5)
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


def fmu_against_pure_modelica() -> None:
    """Draw what both realisations compute."""
    r = simulate("FMUAgainstPureModelica", 0.1)
    t = np.asarray(r.time)
    plant = [(t, r["plantPure.displacement"] * UM, None)]
    draw(
        [
            (TIME, MICROMETRES, plant),
            (TIME, "voltage of the inverse in V", [(t, r["inversePure.voltage"], None)]),
        ],
        "FMUAgainstPureModelica",
    )


if __name__ == "__main__":
    feedforward_feedback()
    flexure_stage()
    disturbance_force()
    fmu_against_pure_modelica()
