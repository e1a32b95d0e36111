"""Slew limit of the amplifier.

For it speaks a residual that is confined to spells in which |du/dt| was above one level, grows while
they last and, in large signals of high frequency only, turns sines into triangles.
"""

import casadi as ca
import numpy as np

from it2hys.effects import Clues, Extent, Scalar, Start, Surroundings, Values

#: What would show the effect apart from others.
EXPERIMENT = (
    "sines of one frequency and rising amplitude (beyond a slew limit they turn into triangles)"
)


def is_on(parameters: Values) -> bool:
    """Return whether there is a limit."""
    return parameters["slew.rate"] > 0.0


def size(parameters: Values) -> int:
    """Return the number of states: the last output."""
    return 1


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input at rest and the state."""
    return y, [y]


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the voltage, changed by the rate times the sample time at most, and the state."""
    most = values["slew.rate"] * values["sampleTime"]
    y = ca.fmin(ca.fmax(x, state[0] - most), state[0] + most)
    return y, [y]


def starts(extent: Extent) -> dict[str, Start]:
    """Start at the span in ten milliseconds; a tick for the span is no limit at all."""
    fastest = extent.voltage_span / extent.sample_time
    start = min(extent.voltage_span / 1e-2, 0.5 * fastest)
    return {"slew.rate": Start(start, 1e-6 * fastest, fastest)}


def guesses(clues: Clues) -> list[dict[str, float]]:
    """Return rates below those that the voltages ask for."""
    rates = np.concatenate([np.abs(np.diff(c.voltage)) for c in clues.records])
    rates = rates[rates > 1e-9 * clues.extent.voltage_span] / clues.extent.sample_time
    fastest = starts(clues.extent)["slew.rate"].high
    slowest = np.quantile(rates, 0.3)
    return [{"slew.rate": r} for r in np.geomspace(slowest, min(rates.max(), fastest), 24)[:-1]]
