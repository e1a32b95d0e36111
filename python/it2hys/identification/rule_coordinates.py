"""The coordinates in which the estimators work, and their bounds.

A scaled rule (s1, s2, c, q1, q2, q3) becomes (log s1, log(s2 / s1), c, q1, q2, q3): deviations stay
positive, and 0 < s1 <= s2 is a bound on one coordinate. After the rules follow the initial state of
every record and the offsets of those that have one.
"""

from __future__ import annotations

import numpy as np

RULE_SIZE = 6

#: Bounds of a rule's coordinates. Scaled displacements lie in [-1, 1]. A membership narrower than
#: 5 % of the range would follow noise, one far wider than the range is constant; a centre more than
#: a range beyond the data describes nothing that was seen. Consequents beyond these cancel between
#: rules, and q1 would leave the bounds of the parameter.
_RULE_BOUNDS = np.array(
    [
        [np.log(0.1), np.log(4.0)],
        [0.0, np.log(30.0)],
        [-3.0, 3.0],
        [-9.99, 9.99],
        [-10.0, 10.0],
        [-20.0, 20.0],
    ]
)


def rule_bounds(rule_count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return lower and upper bounds of the coordinates of L rules, each of shape (6 L,)."""
    lower, upper = np.tile(_RULE_BOUNDS, (rule_count, 1)).T
    return lower.copy(), upper.copy()


def to_coordinates(rules: np.ndarray) -> np.ndarray:
    """Return scaled rules of shape (L, 6) as coordinates of shape (6 L,), moved into the bounds."""
    coordinates = np.array(rules, dtype=float)
    coordinates[:, 1] = np.log(rules[:, 1] / rules[:, 0])
    coordinates[:, 0] = np.log(rules[:, 0])
    return np.clip(coordinates.ravel(), *rule_bounds(len(rules)))


def to_rules(coordinates: np.ndarray) -> np.ndarray:
    """Return the scaled rules, shape (L, 6), of the coordinates, shape (6 L,)."""
    rules = np.array(coordinates, dtype=float).reshape(-1, RULE_SIZE)
    rules[:, 0] = np.exp(rules[:, 0])
    rules[:, 1] = rules[:, 0] * np.exp(rules[:, 1])
    return rules


def chain_rule(by_rules: np.ndarray, rules: np.ndarray) -> np.ndarray:
    """Turn derivatives with respect to scaled rules into ones with respect to the coordinates.

    Parameters
    ----------
    by_rules : ndarray, shape (N, 6 L)
        Derivatives with respect to the rules, row by row; changed in place.
    rules : ndarray, shape (L, 6)
        Where they were taken.

    Returns
    -------
    ndarray, shape (N, 6 L)
        The array `by_rules`.
    """
    for column, (lower, upper) in enumerate(rules[:, :2]):
        first = by_rules[:, RULE_SIZE * column]
        second = by_rules[:, RULE_SIZE * column + 1]
        second *= upper
        first *= lower
        first += second
    return by_rules
