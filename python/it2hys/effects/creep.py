"""Creep: first-order terms, driven by the displacement above the sensor's zero and added to it.

For it speaks a residual that, after a step, grows with the logarithm of the time held, and slow
cycles whose loops are wider than fast ones'. A drift with time grows without any step.
"""

import casadi as ca
import numpy as np

from it2hys.effects import Clues, Extent, Scalar, Signature, Start, Surroundings, Values
from it2hys.effects.statistics import Ground, absorbed, after_steps, lagged, modelled, readable

MAX_COUNT = 16
#: Terms that a fit begins with.
COUNT = 3
#: Samples that a time constant has at least: what is faster is no creep but dynamics.
FASTEST = 20.0
#: Largest gain of one term. Stacks creep by 1 to 2 % of a step per decade of time (as their makers
#: state), up to 5 % without preload; a term of a time constant of its own takes up some two decades.
LARGEST_GAIN = 0.05

#: What the effect is, in plain words.
MEANING = "the stage goes on moving when the voltage has stopped"
#: What would show the effect apart from others.
EXPERIMENT = "steps held over several decades of time (creep goes on with the logarithm of time)"


def is_on(parameters: Values) -> bool:
    """Return whether there are creep terms."""
    return parameters["creepCount"] > 0


def size(parameters: Values) -> int:
    """Return the number of states: one per term."""
    return int(parameters["creepCount"])


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input and the states, `initialCreep` above it: at 0 those after long rest."""
    count, ahead, zero = int(values["creepCount"]), values["initialCreep"], values["displacementZero"]
    gains = 0.0
    for i in range(1, count + 1):
        gains = gains + values[f"creep[{i}].gain"]
    x = (y - zero - gains * ahead) / (1.0 + gains)
    return zero + x, [x + ahead] * count


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the displacement with creep and the states; a state at a tick includes its input."""
    zero, states = values["displacementZero"], []
    x = x - zero
    y = x
    for i, last in enumerate(state, start=1):
        rate = -ca.expm1(-values["sampleTime"] / values[f"creep[{i}].timeConstant"])
        states.append(last + rate * (x - last))
        y = y + values[f"creep[{i}].gain"] * states[-1]
    return zero + y, states


def starts(extent: Extent, count: int = COUNT) -> dict[str, Start]:
    """Start at 2 % per term, time constants spread evenly in their logarithm over the record."""
    fastest = FASTEST * extent.sample_time
    slowest = max(extent.duration, 10.0 * fastest)
    spread = np.geomspace(fastest, slowest, count + 2)[1:-1]
    result = {}
    for i, time_constant in enumerate(spread, start=1):
        result[f"creep[{i}].gain"] = Start(0.02, 0.0, LARGEST_GAIN)
        bounds = (fastest, 10.0 * slowest)
        result[f"creep[{i}].timeConstant"] = Start(float(time_constant), *bounds)
    result["initialCreep"] = Start(0.0, -extent.displacement_span, extent.displacement_span)
    return result


def guesses(clues: Clues, count: int = COUNT) -> list[dict[str, float]]:
    """Return no, small and large gains at time constants spread over the records' decades."""
    values = starts(clues.extent, count)
    constants = {name: start.value for name, start in values.items() if "timeConstant" in name}
    gains = [name for name in values if "gain" in name]
    return [
        {"creepCount": count, **constants, **dict.fromkeys(gains, total / count)}
        for total in (1e-3, 0.02, 0.1)
    ]


def signature(clues: Clues) -> Signature | None:
    """Return whether the residual goes on after the displacement has moved, over decades of time.

    The residual is regressed on slow lags of the model's reading, three over the decades that the
    records see, once the model's own means are taken out; errors are spectral and by blocks (HAC).
    The statistic is the share of the residual's power that they explain. The text gives the growth
    by decade of hold time.
    """
    seen = readable(clues)
    duration = clues.extent.duration / clues.extent.sample_time
    if seen is None or duration < 1000:
        return None
    ticks = np.geomspace(20.0, duration, 6)[::2]
    trial = Ground(seen, [absorbed(seen)]).test(
        lambda c: np.column_stack([lagged(modelled(c), t) for t in ticks])
    )
    slope = after_steps(seen)
    text = f"Slow answers to the displacement explain {100 * trial.share:.0f} % of the residual's power"
    if slope is not None:
        text += (
            f"; after a step it goes on by {100 * slope:.2g} % of the step per decade of the time held"
        )
    return Signature(trial.share, trial.p_value, text + ".")
