"""What makes a fitted model usable: invertible by (30), and a free run that cannot diverge.

The same two conditions as `core.check`, as smooth penalties that a least-squares fit can hold, with
exact derivatives from CasADi, and the search for the range over which they are met.
"""

from __future__ import annotations

import numpy as np

from it2hys import core
from it2hys.identification import coordinates
from it2hys.it2 import usability_function

#: Points of the grid: several within the narrowest membership, or rules would hide between them.
_GRID = 193
#: The penalties begin here, so that the finer grid of the final check is passed too.
LARGEST_CONTRACTION = 0.998
#: Smallest dy/dx as a share of its mean over the range.
SMALLEST_SLOPE = 0.05
#: Margin beyond the range of the data in which the conditions are asked for, as a share of it.
MARGIN = 0.1


class Guard:
    """Penalties for a model that does not contract or cannot be inverted over a range.

    Parameters
    ----------
    rule_count : int
        Number of rules L.
    low, high : float
        Range of displacement in scaled units.
    strength : float
        Factor of the penalties.
    """

    def __init__(self, rule_count: int, low: float, high: float, strength: float):
        self._y = np.linspace(low, high, _GRID)
        self._function = usability_function(rule_count, _GRID)
        self._strength = strength

    def residual(self, rules: np.ndarray) -> np.ndarray:
        """Return the penalties, shape (2 G,): 0 where the conditions hold."""
        return self._penalties(self._function(rules, self._y)[0].full())[0]

    def linearise(self, rules: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the penalties' derivatives by the coordinates, (2 G, 6 L), and themselves."""
        values, by_rules = (output.full() for output in self._function(rules, self._y))
        residual, slopes = self._penalties(values)
        # CasADi lays out a point's rules column by column, the coordinates are row by row
        by_rules = by_rules.reshape(2, _GRID, coordinates.RULE_SIZE, len(rules))
        by_rules = by_rules.transpose(0, 1, 3, 2).reshape(2 * _GRID, -1) * slopes[:, None]
        return coordinates.chain_rule(by_rules, rules), residual

    def _penalties(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return penalties and their derivatives by contraction and slope, contractions first."""
        contraction, slope = values
        excess = np.maximum(np.abs(contraction) - LARGEST_CONTRACTION, 0.0)
        # relative to dy/dx of order (1 - contraction): a scaled loop has unit height and width
        lack = np.maximum(_smallest_slope(contraction, slope) - slope, 0.0)
        residual = self._strength * np.concatenate([excess, lack])
        slopes = self._strength * np.concatenate(
            [np.where(excess > 0, np.sign(contraction), 0.0), np.where(lack > 0, -1.0, 0.0)]
        )
        return residual, slopes


def _smallest_slope(contraction: np.ndarray, slope: np.ndarray) -> float:
    return SMALLEST_SLOPE * max(float(np.median(np.abs(slope))), 1e-6)


def find_fault(rules: np.ndarray, low: float, high: float) -> str | None:
    """Return what makes the rules unusable over a displacement range, or None; units as given."""
    return core.check(rules, low, high)


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
    if find_fault(rules, low, high):
        return None
    margin = MARGIN * (high - low)
    for share in np.linspace(1.0, 0.0, 21):
        below = low - share * margin
        if not find_fault(rules, below, high):
            break
    for share in np.linspace(1.0, 0.0, 21):
        above = high + share * margin
        if not find_fault(rules, below, above):
            break
    return below, above


def data_contraction(rules: np.ndarray, y_previous: np.ndarray, x: np.ndarray) -> float:
    """Return the largest |dy(k)/dy(k-1)| at the record's own pairs (y(k-1), x(k))."""
    from it2hys.identification.criteria import one_step_gradient

    return float(np.max(np.abs(one_step_gradient(rules, y_previous, x)[2])))
