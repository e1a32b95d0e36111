"""What makes a fitted model usable: invertible by (30), and contracting.

|dy(k)/dy(k-1)| of (10) is affine in x(k) for given y(k-1): below 1 at the two ends of a band of
voltages it is below 1 in all of it, and two runs inside the band under the same voltage approach
each other. On the equilibrium curve, its ends included, it must be below 1 for another reason: beyond
the ends of its range the core goes on with the contraction that it has there, and it is that which
keeps a free run from diverging, whatever the voltage. The conditions are smooth penalties that a
least-squares fit can hold, with exact derivatives from CasADi; the fitted model is verified on a finer
grid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from threading import Lock

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from it2hys.identification import rule_coordinates
from it2hys.model import compiled
from it2hys.model.it2 import usability_jacobian
from it2hys.policy import CORE

#: Input and output of a core over a record, scaled, and which samples are used, each of shape (N,).
Course = tuple[np.ndarray, np.ndarray, np.ndarray]

#: Points of the grid: several within the narrowest membership, or rules would hide between them.
_GRID = 193
#: Points of the grid on which the fitted model is verified.
_FINE_GRID = 1537
#: Strengths of the penalties for a model that is not usable, one after the other until it is.
STRENGTHS = (1.0, 1e1, 1e2, 1e3)


@dataclass(frozen=True, eq=False)
class Band:
    """The pairs (y(k-1), x(k)) in which a model is to contract: a range of x for every y.

    Parameters
    ----------
    y : ndarray, shape (G,)
        Even grid of displacements, scaled: the range of the data and 10 % of it at either end.
    x_low, x_high : ndarray, shape (G,)
        Least and greatest voltage that the data have near each y, and 10 % of their range beyond.
    """

    y: np.ndarray
    x_low: np.ndarray
    x_high: np.ndarray

    @property
    def rows(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The three arrays with the shape (1, G) that CasADi's functions of a grid take."""
        return self.y[None], self.x_low[None], self.x_high[None]

    @property
    def verified(self) -> Band:
        """The band on the finer grid on which a fitted model is verified."""
        y = np.linspace(self.y[0], self.y[-1], _FINE_GRID)
        return Band(y, *(np.interp(y, self.y, x) for x in (self.x_low, self.x_high)))

    @classmethod
    def of_data(cls, courses: Sequence[Course]) -> Band:
        """Return the band of the samples of records that are used."""
        low, high = data_range(courses)
        y = np.concatenate([y[:-1][used[:-1]] for _, y, used in courses])
        x = np.concatenate([x[1:][used[:-1]] for x, _, used in courses])
        margin, reserve = CORE.margin * (high - low), CORE.margin * np.ptp(x)
        grid = np.linspace(low - margin, high + margin, _GRID)
        nearest = np.rint((y - grid[0]) / (grid[1] - grid[0])).astype(int)
        x_low, x_high = np.full(_GRID, np.inf), np.full(_GRID, -np.inf)
        np.minimum.at(x_low, nearest, x)
        np.maximum.at(x_high, nearest, x)
        seen = np.flatnonzero(np.isfinite(x_low))
        # beyond and between the data as at the nearest of them, then also as at the neighbours
        x_low, x_high = (np.interp(grid, grid[seen], v[seen]) for v in (x_low, x_high))
        return cls(grid, minimum_filter1d(x_low, 3) - reserve, maximum_filter1d(x_high, 3) + reserve)


class Guard:
    """Penalties for a model that does not contract or cannot be inverted over a band.

    Parameters
    ----------
    band : Band
        On an even grid.
    strength : float
        Factor of the penalties.
    contraction : float
        Largest |dF/dy| without one.
    """

    def __init__(self, band: Band, strength: float, contraction: float = CORE.contraction):
        self.band = band
        self._strength, self._contraction = strength, contraction

    def residual(self, rules: np.ndarray) -> np.ndarray:
        """Return the penalties, shape (4 G,): 0 where the conditions hold."""
        return self._strength * self._excess(usability_values(rules, self.band)).ravel()

    def linearise(self, rules: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the penalties' derivatives by the coordinates, (4 G, 6 L), and themselves."""
        values = usability_values(rules, self.band)
        excess = self._excess(values)
        signs = np.sign(values) * (excess > 0.0)
        signs[3] = -1.0 * (excess[3] > 0.0)
        slopes = self._strength * signs.ravel()
        derivatives = np.zeros((4, len(self.band.y), rules.size))
        active = np.flatnonzero(np.any(slopes.reshape(4, -1), axis=0))
        if len(active):
            derivatives[:, active] = self._derivatives(rules, active)
        by_rules = derivatives.reshape(4 * len(self.band.y), -1) * slopes[:, None]
        return rule_coordinates.chain_rule(by_rules, rules), self._strength * excess.ravel()

    def _derivatives(self, rules: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return the derivatives of the values at K points by the rules, (4, K, 6 L)."""
        # repeated up to a power of two: few sizes for CasADi to make a function of
        size = 1 << (len(points) - 1).bit_length()
        repeated = np.resize(points, size)
        by_rules = _Derivatives.of(len(rules), size)(rules, self.band, repeated)
        return by_rules.reshape(4, size, -1)[:, : len(points)]

    def _excess(self, values: np.ndarray) -> np.ndarray:
        """Return by how much the values of the grid, (4, G), are beyond what they may be."""
        excess = np.abs(values)
        excess[:3] -= self._contraction
        # relative to dy/dx of order (1 - contraction): a scaled loop has unit height and width
        np.subtract(_smallest_slope(values[3]), values[3], out=excess[3])
        return np.maximum(excess, 0.0, out=excess)


class _Derivatives:
    """`usability_jacobian` with its arguments in place: CasADi takes longer to make its own."""

    def __init__(self, rule_count: int, points: int):
        # CasADi lays out columns one after another
        rules = np.empty((rule_coordinates.RULE_SIZE, rule_count))
        self._arguments = (rules, *np.empty((3, points)))
        self._result = np.empty((points, rule_coordinates.RULE_SIZE, rule_count, 4))
        self._buffer, self._evaluate = usability_jacobian(rule_count, points).buffer()
        for i, argument in enumerate(self._arguments):
            self._buffer.set_arg(i, memoryview(argument))
        self._buffer.set_res(0, memoryview(self._result))
        self._lock = Lock()  # a user's threads that fit side by side share the arrays

    @classmethod
    @cache
    def of(cls, rule_count: int, points: int) -> _Derivatives:
        """Return the one for so many rules and points."""
        return cls(rule_count, points)

    def __call__(self, rules: np.ndarray, band: Band, points: np.ndarray) -> np.ndarray:
        """Return the derivatives at points of a band, (4, points, L, 6)."""
        values = (rules.T, band.y[points], band.x_low[points], band.x_high[points])
        with self._lock:
            for argument, value in zip(self._arguments, values, strict=True):
                argument[:] = value
            self._evaluate()
            return self._result.transpose(3, 0, 2, 1).copy()


def usability_values(rules: np.ndarray, band: Band) -> np.ndarray:
    """Return the numbers of `it2.usability_function` over a band, (4, G), by the compiled core."""
    return compiled.usability(rules, band.y, band.x_low, band.x_high)


def _smallest_slope(slope: np.ndarray) -> float:
    return CORE.slope * max(abs(float(np.add.reduce(slope)) / len(slope)), 1e-6)


def data_range(courses: Sequence[Course]) -> tuple[float, float]:
    """Return the range of the displacements that are used, scaled."""
    parts = [y[used] for _, y, used in courses]
    return min(p.min() for p in parts), max(p.max() for p in parts)


def largest_contraction(rules: np.ndarray, band: Band) -> tuple[float, float, float]:
    """Return the largest |dy(k)/dy(k-1)| over a band, verified on a fine grid, and where it is.

    Parameters
    ----------
    rules : ndarray, shape (L, 6)
        Scaled rules.
    band : Band

    Returns
    -------
    contraction, y, x : float
        The largest value, over the band and the equilibrium curve, and its place, scaled.
    """
    fine = band.verified
    magnitude = np.abs(usability_values(rules, fine)[:3])
    place = np.unravel_index(np.argmax(magnitude), magnitude.shape)
    x = [compiled.solve(rules, fine.y, fine.y), fine.x_low, fine.x_high][place[0]]
    return float(magnitude[place]), float(fine.y[place[1]]), float(x[place[1]])


def share_of_way(rules: np.ndarray, band: Band, ratio: float) -> float:
    """Return which share of a core's way in a sample it goes in a sample that is longer by a ratio.

    With the slope dy(k)/dy(k-1) on the equilibrium curve it would be (1 - slope^ratio) / (1 - slope);
    one share serves all of it, that of the mean. No slope becomes negative that was not.
    """
    slope = usability_values(rules, band)[0]
    mean, least = np.clip([slope.mean(), slope.min()], 0.0, 1.0 - 1e-6)
    return float(min((1.0 - mean**ratio) / (1.0 - mean), 1.0 / (1.0 - least)))


def is_usable(rules: np.ndarray, band: Band) -> bool:
    """Return whether scaled rules are invertible and contract over a band."""
    return compiled.check(rules, band.y[0], band.y[-1]) is None and (
        largest_contraction(rules, band)[0] < 1.0
    )


def widest_range(rules: np.ndarray, low: float, high: float) -> tuple[float, float] | None:
    """Return the widest usable range around that of the data.

    Parameters
    ----------
    rules : ndarray, shape (L, 6)
    low, high : float
        Range of the data, in the rules' unit.

    Returns
    -------
    tuple of float, or None
        The range with a margin of up to 10 % at either end, shrunk only as far as needed; None
        where the rules are unusable within the data themselves.
    """
    if compiled.check(rules, low, high):
        return None
    margin = CORE.margin * (high - low)
    for share in np.linspace(1.0, 0.0, 21):
        below = low - share * margin
        if not compiled.check(rules, below, high):
            break
    for share in np.linspace(1.0, 0.0, 21):
        above = high + share * margin
        if not compiled.check(rules, below, above):
            break
    return below, above
