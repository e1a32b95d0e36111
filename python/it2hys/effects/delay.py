"""Delay of the voltage, straight between ticks.

For it speaks a residual that is the displacement's rate times one constant, at every frequency and
amplitude: a phase that falls linearly with frequency at a gain that stays. A lag also lowers the gain,
and the core itself is a lag; so the gain at the highest frequencies of the record has to decide.
"""

import math

from it2hys.effects import Clues, Extent, Scalar, Signature, Start, Surroundings, Values
from it2hys.effects.statistics import StepResponse, readable

MAX_TICKS = 64
ROUNDING = 1e-9

#: What the effect is, in plain words.
MEANING = "the stage follows the voltage late by a constant time"
#: What would show the effect apart from others.
EXPERIMENT = (
    "a chirp or multisine up to the highest frequency of interest (a delay's phase falls in "
    "proportion to the frequency, its amplitude does not fall)"
)


def is_on(parameters: Values) -> bool:
    """Return whether there is a delay."""
    return parameters["delay.time"] > 0.0


def size(parameters: Values) -> int:
    """Return the number of voltages kept: the whole ticks and one more."""
    return math.floor(parameters["delay.time"] / parameters["sampleTime"] + ROUNDING) + 1


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the voltage at rest and the voltages kept; `size` of them are used."""
    return y, [y] * (MAX_TICKS + 1)


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the voltage a delay ago, and the voltages kept. The whole ticks are those of `state`."""
    ticks = len(state) - 1
    newer = state[ticks - 1] if ticks else x
    fraction = values["delay.time"] / values["sampleTime"] - ticks
    return newer + fraction * (state[ticks] - newer), [x, *state[:-1]]


def starts(extent: Extent) -> dict[str, Start]:
    """Start at one tick; whole ticks are the structure of the chain, so that a fit tries several."""
    return {"delay.time": Start(extent.sample_time, 0.0, MAX_TICKS * extent.sample_time)}


def guesses(clues: Clues) -> list[dict[str, float]]:
    """Return delays from a part of a tick to many."""
    ticks = (0.4, 0.9, 1.6, 2.5, 3.5, 5.5, 8.0, 12.0, 20.0, 40.0)
    return [{"delay.time": t * clues.extent.sample_time} for t in ticks]


def signature(clues: Clues) -> Signature | None:
    """Return whether the displacement answers a step of the voltage late, but then at its full rate.

    The response to steps is estimated for model and residual together and compared with those of
    cores behind a delay, a lag and a resonance; errors are spectral (HAC), the p-value an F test of
    what a delay explains beyond the others. The statistic is the share of the residual's power that
    it explains.
    """
    seen = readable(clues)
    if seen is None:
        return None
    found = StepResponse(seen).dynamics("delay")
    text = (
        "After a step of the voltage the displacement stands still for about "
        f"{found.parameter * clues.extent.sample_time * 1e3:.3g} ms ({found.parameter:g} samples) "
        "and then "
        f"moves at its full rate at once: {100 * found.share:.0f} % of the residual's power."
    )
    return Signature(found.share, found.p_value, text)
