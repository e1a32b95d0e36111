"""First-order lag of the amplifier, exact pole and no zero.

For it speaks a residual whose transfer from the voltage turns by less than 90 degrees and falls by
20 dB per decade above one corner, the same at every amplitude. Below the corner it is a delay.
"""

import casadi as ca
import numpy as np

from it2hys.effects import Clues, Extent, Scalar, Signature, Start, Surroundings, Values
from it2hys.effects.statistics import StepResponse, readable

#: What the effect is, in plain words.
MEANING = "the amplifier follows the voltage as a low-pass filter does"
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


def signature(clues: Clues) -> Signature | None:
    """Return whether the displacement answers a step of the voltage at once, but flat at first.

    The response to steps is estimated for model and residual together and compared with those of
    cores behind a delay, a lag and a resonance; errors are spectral (HAC), the p-value an F test of
    what a lag explains beyond the others. The statistic is the share of the residual's power that
    it explains.
    """
    seen = readable(clues)
    if seen is None:
        return None
    found = StepResponse(seen).dynamics("lag")
    constant = found.parameter * clues.extent.sample_time
    text = (
        "After a step of the voltage the displacement begins to move at once but slowly, as behind a "
        f"first-order lag of about {constant * 1e3:.2g} ms (corner at {0.159 / constant:.3g} Hz): "
        f"{100 * found.share:.0f} % of the residual's power."
    )
    return Signature(found.share, found.p_value, text)
