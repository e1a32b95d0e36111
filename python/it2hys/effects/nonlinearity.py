"""Static curve between displacement and reading.

For it speaks a residual that is a function of the displacement alone: the same in rising and falling
branches, at every frequency and in every record. Data cannot tell a sensor's curve from an actuator's.
"""

import casadi as ca

from it2hys.effects import Clues, Extent, Scalar, Start, Surroundings, Values

COEFFICIENTS = ("quadratic", "cubic", "quartic")

#: What would show the effect apart from others.
EXPERIMENT = (
    "slow full-range loops beside small ones at several bias voltages (a static curve is the "
    "same in all)"
)


def is_on(parameters: Values) -> bool:
    """Return whether the curve is bent."""
    return any(parameters[f"nonlinearity.{name}"] != 0.0 for name in COEFFICIENTS)


def size(parameters: Values) -> int:
    """Return the number of states: none."""
    return 0


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input at rest. The reading is not part of the state of rest."""
    return y, []


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the reading of the displacement."""
    low, high = values["displacementMin"], values["displacementMax"]
    z = ca.fmin(ca.fmax((x - 0.5 * (low + high)) / (0.5 * (high - low)), -1.0), 1.0)
    quadratic, cubic, quartic = (values[f"nonlinearity.{name}"] for name in COEFFICIENTS)
    return x + (1.0 - z * z) * (quadratic + z * (cubic + z * quartic)), []


def starts(extent: Extent) -> dict[str, Start]:
    """Start straight; bounds keep each term by itself monotone."""
    bound = 0.2 * extent.displacement_span
    return {f"nonlinearity.{name}": Start(0.0, -bound, bound) for name in COEFFICIENTS}


def guesses(clues: Clues) -> list[dict[str, float]]:
    """Return a curve that is hardly bent: the model is linear in its coefficients."""
    small = 1e-4 * clues.extent.displacement_span
    return [{f"nonlinearity.{name}": small for name in COEFFICIENTS}]
