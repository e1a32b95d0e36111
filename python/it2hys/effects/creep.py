"""Creep: first-order terms, driven by the displacement and added to it.

For it speaks a residual that, after a step, grows with the logarithm of the time held, and slow
cycles whose loops are wider than fast ones'. A drift with time grows without any step.
"""

import casadi as ca
import numpy as np

from it2hys.effects import Extent, Scalar, Start, Surroundings, Values

MAX_COUNT = 16


def is_on(parameters: Values) -> bool:
    """Return whether there are creep terms."""
    return parameters["creepCount"] > 0


def size(parameters: Values) -> int:
    """Return the number of states: one per term."""
    return int(parameters["creepCount"])


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input and the states after long rest."""
    count = int(values["creepCount"])
    slope = 1.0
    for i in range(1, count + 1):
        slope = slope + values[f"creep[{i}].gain"]
    return y / slope, [y / slope] * count


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the displacement with creep and the states; a state at a tick includes its input."""
    y, states = x, []
    for i, last in enumerate(state, start=1):
        rate = -ca.expm1(-values["sampleTime"] / values[f"creep[{i}].timeConstant"])
        states.append(last + rate * (x - last))
        y = y + values[f"creep[{i}].gain"] * states[-1]
    return y, states


def starts(extent: Extent, count: int = 2) -> dict[str, Start]:
    """Start at 2 % per term, time constants spread evenly in their logarithm over the record."""
    fastest, slowest = 2.0 * extent.sample_time, max(extent.duration, 20.0 * extent.sample_time)
    spread = np.geomspace(fastest, slowest, count + 2)[1:-1]
    result = {}
    for i, time_constant in enumerate(spread, start=1):
        result[f"creep[{i}].gain"] = Start(0.02, -0.2 / count, 2.0)
        bounds = (0.5 * fastest, 10.0 * slowest)
        result[f"creep[{i}].timeConstant"] = Start(float(time_constant), *bounds)
    return result
