"""First-order lag of the amplifier, exact pole and no zero.

For it speaks a residual whose transfer from the voltage turns by less than 90 degrees and falls by
20 dB per decade above one corner, the same at every amplitude. Below the corner it is a delay.
"""

import casadi as ca
import numpy as np

from it2hys.effects import Clues, Extent, Scalar, Start, Surroundings, Values

#: What would show the effect apart from others.
EXPERIMENT = (
    "a chirp or multisine up to the highest frequency of interest (behind a lag the amplitude "
    "falls by 20 dB per decade above one corner)"
)


def is_on(parameters: Values) -> bool:
    """Return whether there is a lag."""
    return parameters["lag.timeConstant"] > 0.0


def size(parameters: Values) -> int:
    """Return the number of states: the last output."""
    return 1


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input at rest and the state."""
    return y, [y]


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the lagging voltage and the state."""
    y = state[0] + -ca.expm1(-values["sampleTime"] / values["lag.timeConstant"]) * (x - state[0])
    return y, [y]


def starts(extent: Extent) -> dict[str, Start]:
    """Start at two ticks; slower than a tenth of the record is creep or drift."""
    slowest = max(0.1 * extent.duration, 10.0 * extent.sample_time)
    ts = extent.sample_time
    return {"lag.timeConstant": Start(2.0 * ts, 0.05 * ts, slowest)}


def guesses(clues: Clues) -> list[dict[str, float]]:
    """Return time constants from a tick to a tenth of the records."""
    start = starts(clues.extent)["lag.timeConstant"]
    shortest = 0.5 * clues.extent.sample_time
    return [{"lag.timeConstant": t} for t in np.geomspace(shortest, 0.5 * start.high, 10)]
