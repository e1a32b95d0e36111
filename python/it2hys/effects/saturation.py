"""Saturation of the amplifier.

For it speaks a residual that is confined to |u| beyond one level, where the displacement no longer
answers to the voltage at all; the tops of large cycles are flat.
"""

import casadi as ca

from it2hys.effects import Extent, Scalar, Start, Surroundings, Values


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
