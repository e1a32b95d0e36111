"""(10) one step ahead of measured pairs (y(k-1), x(k)), and its derivatives, at many pairs at once."""

from __future__ import annotations

import numpy as np


def normalised_memberships(
    rules: np.ndarray, y_previous: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return f, F and their sum over the rules, (8) to (12), up to a factor common to all rules.

    Parameters
    ----------
    rules : ndarray, shape (L, 6)
    y_previous : ndarray, shape (N,)

    Returns
    -------
    lower, upper : ndarray, shape (N, L)
    total : ndarray, shape (N, 1)
    """
    squared = (y_previous[:, None] - rules[:, 2]) ** 2
    exponents = squared[:, :, None] * (-0.5 / rules[:, :2] ** 2)
    exponents -= exponents.max(axis=(1, 2), keepdims=True)
    memberships = np.exp(exponents)
    return memberships[..., 0], memberships[..., 1], memberships.sum(axis=(1, 2))[:, None]


def one_step_gradient(
    rules: np.ndarray, y_previous: np.ndarray, x: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Evaluate (10) and (13) to (18) at many pairs at once.

    Parameters
    ----------
    rules : ndarray, shape (L, 6)
    y_previous, x : ndarray, shape (N,)

    Returns
    -------
    y : ndarray, shape (N,)
    by_rules : ndarray, shape (N, 6 L)
        Derivatives with respect to the rules, row by row.
    by_previous : ndarray, shape (N,)
        Derivative with respect to y(k-1).
    """
    lower, upper, total = normalised_memberships(rules, y_previous)
    s1, s2, centre, q1, q2, q3 = rules.T
    weight = (lower + upper) / total
    consequent = y_previous[:, None] * q1 + x[:, None] * q2 + q3
    y = np.sum(weight * consequent, axis=1)
    excess = (consequent - y[:, None]) / total
    distance = y_previous[:, None] - centre
    by_centre = (lower / s1**2 + upper / s2**2) * distance * excess
    gradient = np.stack(
        [
            lower * distance**2 / s1**3 * excess,
            upper * distance**2 / s2**3 * excess,
            by_centre,
            y_previous[:, None] * weight,
            x[:, None] * weight,
            weight,
        ],
        axis=2,
    )
    by_previous = np.sum(weight * q1 - by_centre, axis=1)
    return y, gradient.reshape(len(y), -1), by_previous
