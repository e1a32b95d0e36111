"""Saturation of the amplifier.

For it speaks a residual that is confined to |u| beyond one level, where the displacement no longer
answers to the voltage at all; the tops of large cycles are flat.
"""

import casadi as ca

from it2hys.effects import Clues, Extent, Scalar, Start, Surroundings, Values

#: What would show the effect apart from others.
EXPERIMENT = "slow sines of rising amplitude (beyond a limit the displacement stays where it is)"


def is_on(parameters: Values) -> bool:
    """Return whether there are limits."""
    return parameters["saturation.minimum"] < parameters["saturation.maximum"]


def size(parameters: Values) -> int:
    """Return the number of states: none."""
    return 0


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input at rest, taken to be within the limits."""
    return y, []


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the voltage within the limits."""
    return ca.fmin(ca.fmax(x, values["saturation.minimum"]), values["saturation.maximum"]), []


def starts(extent: Extent) -> dict[str, Start]:
    """Start a tenth of the range within its ends; limits beyond the range cannot be seen."""
    low, high = extent.voltage
    middle, tenth = 0.5 * (low + high), 0.1 * extent.voltage_span
    return {
        "saturation.minimum": Start(low + tenth, low - tenth, middle),
        "saturation.maximum": Start(high - tenth, middle, high + tenth),
    }


def guesses(clues: Clues) -> list[dict[str, float]]:
    """Return limits at the upper end, at the lower end and at both."""
    low, high = clues.extent.voltage
    span, bounds = high - low, starts(clues.extent)
    none = bounds["saturation.minimum"].low, bounds["saturation.maximum"].high
    shares = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4)
    limits = [(none[0], high - s * span) for s in shares]
    limits += [(low + s * span, none[1]) for s in shares]
    limits += [(low + s * span, high - t * span) for s in shares[1::2] for t in shares[1::2]]
    return [{"saturation.minimum": a, "saturation.maximum": b} for a, b in limits]
