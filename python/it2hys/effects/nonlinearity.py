"""Static curve, the stack's or the sensor's: the last stage before the displacement.

For it speaks a residual that is a function of the displacement alone: the same in rising and falling
branches, at every frequency and in every record. Data cannot tell a sensor's curve from an actuator's.
"""

import casadi as ca
import numpy as np

from it2hys.effects import Clues, Extent, Scalar, Signature, Start, Surroundings, Values
from it2hys.effects.statistics import UM, Ground, branches, modelled, readable, scaled

COEFFICIENTS = ("quadratic", "cubic", "quartic")

#: Share of the range of the model's readings by which the curve goes beyond it.
_MARGIN = 0.1
#: Of the inverse at rest.
_HALVINGS, _NEWTON_STEPS = 40, 2

#: What the effect is, in plain words.
MEANING = "a bent static curve of the stage or its sensor"
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
    """Return the input at rest.

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
    return ca.if_else(ca.fabs(aim) < 1.0, middle + half * z, y), []


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the displacement."""
    middle, half = _curve(values)
    z = ca.fmin(ca.fmax((x - middle) / half, -1.0), 1.0)
    return x + _bow(values, z), []


def _curve(values: Values) -> tuple[Scalar, Scalar]:
    """Return middle and half range of the curve."""
    low, high = values["nonlinearity.minimum"], values["nonlinearity.maximum"]
    return values["displacementZero"] + 0.5 * (low + high), 0.5 * (high - low)


def _bow(values: Values, z: Scalar) -> Scalar:
    quadratic, cubic, quartic = (values[f"nonlinearity.{name}"] for name in COEFFICIENTS)
    return (1.0 - z * z) * (quadratic + z * (cubic + z * quartic))


def _bend(values: Values, z: Scalar) -> Scalar:
    """Return the derivative of the bow by z."""
    quadratic, cubic, quartic = (values[f"nonlinearity.{name}"] for name in COEFFICIENTS)
    inner = quadratic + z * (cubic + z * quartic)
    return -2.0 * z * inner + (1.0 - z * z) * (cubic + 2.0 * z * quartic)


def starts(extent: Extent) -> dict[str, Start]:
    """Start straight; bounds keep each term by itself monotone."""
    bound = 0.2 * extent.displacement_span
    return {f"nonlinearity.{name}": Start(0.0, -bound, bound) for name in COEFFICIENTS}


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
    ndarray, shape (points, 3)
        1/m.
    """
    z = np.linspace(-1.0, 1.0, points)
    fixed_ends = np.polynomial.Polynomial([1.0, 0.0, -1.0])
    by_z = [fixed_ends * np.polynomial.Polynomial.basis(k) for k in range(3)]
    return np.column_stack([curve.deriv()(z) for curve in by_z]) / (0.5 * (high - low))


def guesses(clues: Clues) -> list[dict[str, float]]:
    """Return a curve that is hardly bent, and ones with one, two and three waves.

    The curve is over the model's readings, and stays there: other ends are another curve.
    """
    span = clues.extent.displacement_span
    # Chebyshev polynomials of degree 2, 3 and 4, less what is linear: 1 % of the travel high, or 2 %
    waves = [(0.02, 0, 0), (0, 0.04, 0), (0, 0, 0.08)]
    heights = (2.0, 1.0, -1.0, -2.0)
    shapes = [(1e-4, 1e-4, 1e-4), *(tuple(h * c for c in wave) for wave in waves for h in heights)]
    strokes = np.concatenate([modelled(c)[c.used] for c in clues.records]) - clues.extent.zero
    if np.ptp(strokes) == 0.0:  # of a model that stands still there is no curve
        return []
    margin = _MARGIN * np.ptp(strokes)
    ends = {
        "nonlinearity.minimum": float(strokes.min() - margin),
        "nonlinearity.maximum": float(strokes.max() + margin),
    }
    return [
        {**{f"nonlinearity.{n}": c * span for n, c in zip(COEFFICIENTS, s, strict=True)}, **ends}
        for s in shapes
    ]


def signature(clues: Clues) -> Signature | None:
    """Return whether the residual is a function of the displacement alone, the same on both branches.

    The residual is regressed on Chebyshev polynomials 2 to 8 of the model's reading, in all records
    by the same coefficients; errors are spectral and by blocks (HAC) and enlarged where records
    disagree. The statistic is the share of the residual's power that they explain. The text
    compares both branches. What the core bends to by itself is not in the residual any more.
    """
    seen = readable(clues)
    if seen is None or clues.extent.displacement_span <= 0.0:
        return None
    trial = Ground(seen, [modelled]).test(
        lambda c: np.polynomial.chebyshev.chebvander(np.clip(scaled(clues, c), -1.2, 1.2), 8)[:, 2:]
    )
    share = 100 * trial.share
    text = f"A function of the displacement alone explains {share:.0f} % of the residual's power"
    if (means := branches(seen)) is not None:
        rising, falling = means
        text += (
            f"; on average the residual is up to {np.max(np.abs(rising)) * UM:.2g} µm on rising and "
            f"{np.max(np.abs(falling)) * UM:.2g} µm on falling branches, with a correlation of "
            f"{np.corrcoef(rising, falling)[0, 1]:.2f} between them"
        )
    return Signature(trial.share, trial.p_value, text + ".")
