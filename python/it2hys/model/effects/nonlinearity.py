"""Static curve, the stack's or the sensor's: the last stage before the displacement."""

from collections.abc import Mapping

import numpy as np

from it2hys.model.effect import Effect, Scalar, Start, Surroundings, Values
from it2hys.policy import PHYSICS
from it2hys.records.clues import Extent
from it2hys.support.lazy import Lazy

ca = Lazy("casadi")

#: Coefficients of the powers 0 to 4 of z, after the factor that vanishes at both ends.
COEFFICIENTS = ("quadratic", "cubic", "quartic", "quintic", "sextic")

#: Bisection and Newton steps of the inverse.
_HALVINGS, _NEWTON_STEPS = 40, 2


class Nonlinearity(Effect):
    """Static curve of the stage or its sensor, bent between two ends, beyond which its slope stays."""

    is_static = True

    def is_on(self, parameters: Values) -> bool:
        """Return whether the curve is bent."""
        return any(parameters[f"nonlinearity.{name}"] != 0.0 for name in COEFFICIENTS)

    def rest(self, values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
        """Return the input at rest."""
        return _solved(values, y), []

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the displacement."""
        middle, half = _curve(values)
        z = (x - middle) / half
        end = _nearest(z)
        return x + _bow(values, end) + _bend(values, end) * (z - end), []

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the displacement before the curve."""
        return _solved(values, y), []

    def over_range(self, low: float, high: float) -> dict[str, float]:
        """Return the ends of the curve: it goes over the whole range."""
        return {"nonlinearity.minimum": low, "nonlinearity.maximum": high}

    def starts(self, extent: Extent) -> dict[str, Start]:
        """Start straight; higher powers, which cancel each other in part, may be larger.

        What keeps the curve from falling is its `steepness`.
        """
        shares = [PHYSICS.curve_bow] * 2 + [PHYSICS.curve_shape] * (len(COEFFICIENTS) - 2)
        bounds = [share * extent.displacement_span for share in shares]
        return {
            f"nonlinearity.{name}": Start(0.0, -bound, bound)
            for name, bound in zip(COEFFICIENTS, bounds, strict=True)
        }

    def steepness(self, values: Mapping, units: Mapping[str, float]) -> np.ndarray:
        """Return what the coefficients add to the slope, from end to end."""
        own = [f"nonlinearity.{name}" for name in COEFFICIENTS]
        if own[0] not in units:
            return super().steepness(values, units)
        by_coefficient = slopes(*(values[f"nonlinearity.{end}"] for end in ("minimum", "maximum")))
        rows = np.zeros((len(by_coefficient), len(units)))
        names = list(units)
        for name, column in zip(own, by_coefficient.T, strict=True):
            rows[:, names.index(name)] = units[name] * column
        return rows


def _solved(values: Values, y: Scalar) -> Scalar:
    """Return where the curve is y.

    Halving brings it near; Newton's steps after it give the last digits, and the derivatives.
    """
    middle, half = _curve(values)
    aim = (y - middle) / half
    low, high = -1.0, 1.0
    for _ in range(_HALVINGS):
        z = 0.5 * (low + high)
        above = z + _bow(values, z) / half > aim
        low, high = ca.if_else(above, low, z), ca.if_else(above, z, high)
    z = 0.5 * (low + high)
    for _ in range(_NEWTON_STEPS):
        z = z - (z + _bow(values, z) / half - aim) / (1.0 + _bend(values, z) / half)
    end = _nearest(aim)
    beyond = end + (aim - end) / (1.0 + _bend(values, end) / half)
    return middle + half * ca.if_else(ca.fabs(aim) < 1.0, z, beyond)


def _nearest(z: Scalar) -> Scalar:
    """Return the place on the curve that is nearest."""
    return ca.fmin(ca.fmax(z, -1.0), 1.0)


def _curve(values: Values) -> tuple[Scalar, Scalar]:
    """Return middle and half range of the curve."""
    low, high = values["nonlinearity.minimum"], values["nonlinearity.maximum"]
    return values["displacementZero"] + 0.5 * (low + high), 0.5 * (high - low)


def _bow(values: Values, z: Scalar) -> Scalar:
    return (1.0 - z * z) * _inner(values, z)


def _bend(values: Values, z: Scalar) -> Scalar:
    """Return the derivative of the bow by z."""
    _, *others = (values[f"nonlinearity.{name}"] for name in COEFFICIENTS)
    by_z = 0.0
    for power, coefficient in reversed(list(enumerate(others, start=1))):
        by_z = power * coefficient + z * by_z
    return -2.0 * z * _inner(values, z) + (1.0 - z * z) * by_z


def _inner(values: Values, z: Scalar) -> Scalar:
    """Return the polynomial behind the factor that vanishes at both ends."""
    inner = 0.0
    for name in reversed(COEFFICIENTS):
        inner = values[f"nonlinearity.{name}"] + z * inner
    return inner


def slopes(low: float, high: float, points: int = 257) -> np.ndarray:
    """Return what a unit of each coefficient adds to the curve's slope between two displacements.

    Parameters
    ----------
    low, high : float
        `nonlinearity.minimum` and `nonlinearity.maximum`, m.
    points : int
        Displacements from end to end, both included.

    Returns
    -------
    ndarray, shape (points, 5)
        1/m.
    """
    z = np.linspace(-1.0, 1.0, points)
    fixed_ends = np.polynomial.Polynomial([1.0, 0.0, -1.0])
    by_z = [fixed_ends * np.polynomial.Polynomial.basis(k) for k in range(len(COEFFICIENTS))]
    return np.column_stack([curve.deriv()(z) for curve in by_z]) / (0.5 * (high - low))


EFFECT = Nonlinearity()
