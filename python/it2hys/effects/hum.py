"""A line on the reading that is not in the voltage.

For it speaks one narrow line in the residual's spectrum, of the same frequency and amplitude in every
record, where the voltage has none: incoherent with it, there in rest as in motion.
"""

import math

import casadi as ca

from it2hys.effects import Extent, Scalar, Start, Surroundings, Values


def is_on(parameters: Values) -> bool:
    """Return whether there is a hum."""
    return parameters["hum.amplitude"] > 0.0


def size(parameters: Values) -> int:
    """Return the number of states: none."""
    return 0


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input at rest. The reading is not part of the state of rest."""
    return y, []


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the reading with the line; time is the tick's own."""
    angle = 2.0 * math.pi * values["hum.frequency"] * around.time + values["hum.phase"]
    return x + values["hum.amplitude"] * ca.sin(angle), []


def starts(extent: Extent) -> dict[str, Start]:
    """Start at the mains' frequency; the line of the residual's spectrum is better."""
    nyquist = 0.5 / extent.sample_time
    return {
        "hum.amplitude": Start(0.001 * extent.displacement_span, 0.0, 0.1 * extent.displacement_span),
        "hum.frequency": Start(min(50.0, 0.5 * nyquist), 0.1 / extent.duration, nyquist),
        "hum.phase": Start(0.0, -math.pi, math.pi),
    }
