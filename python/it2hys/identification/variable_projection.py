"""The one-step criterion by variable projection (Golub and Pereyra).

For given centres and deviations, (10) is linear in the consequents q1, q2, q3 of all rules. They
are eliminated by linear least squares, and only the 3 L antecedent coordinates are searched: far
fewer poor optima, and no guess of the consequents needed.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import qr, solve_triangular
from scipy.optimize import lsq_linear

from it2hys.identification import rule_coordinates
from it2hys.identification.levenberg_marquardt import Linearisation, Minimum, levenberg_marquardt
from it2hys.identification.one_step import normalised_memberships, one_step_gradient

_ANTECEDENT = slice(0, 3)
_CONSEQUENT = slice(3, 6)
#: Ridge on the consequents relative to the regressors' norm: enough where rules coincide and the
#: regressors are dependent, far below the noise elsewhere.
_RIDGE = 1e-9


class ProjectedOneStep:
    """The one-step criterion with the consequents eliminated.

    Parameters
    ----------
    y_previous, x, y : ndarray, shape (N,)
        Pairs (y(k-1), x(k)) and what followed, y(k), in scaled units.
    weight : ndarray, shape (N,)
        Weight of each pair.
    group : ndarray of int, shape (N,)
        Which offset a pair has; -1 for none.
    offset_count : int
        Number of offsets O.
    rule_count : int
        Number of rules L.

    Notes
    -----
    The coordinates are log s1, log(s2 / s1), c of every rule, then the offsets: (3 L + O,). An
    offset o enters as y(k) - o = F(y(k-1) - o, x(k)), so that records of different sittings are
    told apart from the start.
    """

    def __init__(
        self,
        y_previous: np.ndarray,
        x: np.ndarray,
        y: np.ndarray,
        weight: np.ndarray,
        group: np.ndarray,
        offset_count: int,
        rule_count: int,
    ):
        self.y_previous, self.x, self.y, self.weight = y_previous, x, y, weight
        self.rule_count = rule_count
        self._members = group[:, None] == np.arange(offset_count)
        lower, upper = rule_coordinates.rule_bounds(rule_count)
        offsets = np.full(self._members.shape[1], 3.0)
        self.lower = np.concatenate([lower.reshape(-1, 6)[:, _ANTECEDENT].ravel(), -offsets])
        self.upper = np.concatenate([upper.reshape(-1, 6)[:, _ANTECEDENT].ravel(), offsets])

    def rules(self, point: np.ndarray) -> np.ndarray:
        """Return all rules, shape (L, 6): these antecedents and the best consequents in bounds."""
        rules = self._project(point)[0]
        bounds = rule_coordinates.rule_bounds(self.rule_count)
        lower, upper = (bound.reshape(-1, 6)[:, _CONSEQUENT] for bound in bounds)
        if np.any((rules[:, _CONSEQUENT] < lower) | (rules[:, _CONSEQUENT] > upper)):
            matrix, target = self._regression(rules, self._shift(point))
            found = lsq_linear(matrix, target, (lower.ravel(), upper.ravel()))
            rules[:, _CONSEQUENT] = found.x.reshape(-1, 3)
        return rules

    def offsets(self, point: np.ndarray) -> np.ndarray:
        """Return the offsets, shape (O,)."""
        return point[3 * self.rule_count :]

    def residual(self, point: np.ndarray) -> np.ndarray:
        """Return the residuals of the projected problem, shape (N + 3 L,), ridge included."""
        return self._project(point)[1]

    def linearise(self, point: np.ndarray) -> Linearisation:
        """Return the projected problem linearised at a point.

        Kaufman's approximation: the derivative of the residual at fixed consequents, projected on
        the complement of the regressors. The term left out is of the order of the residual.
        """
        jacobian, residual = self.jacobian(point)
        return Linearisation(
            jacobian.T @ jacobian, jacobian.T @ residual, lambda values: jacobian.T @ values
        )

    def jacobian(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return Kaufman's Jacobian, shape (N + 3 L, 3 L + O), and the residual."""
        rules, residual, basis = self._project(point)
        y_previous = self.y_previous - self._shift(point)
        _, by_rules, by_previous = one_step_gradient(rules, y_previous, self.x)
        by_rules = rule_coordinates.chain_rule(by_rules, rules)
        antecedent = by_rules.reshape(len(self.x), self.rule_count, 6)[:, :, _ANTECEDENT]
        by_offset = self._members * (1.0 - by_previous)[:, None]
        jacobian = np.zeros((len(residual), len(point)))
        jacobian[: len(self.x)] = self.weight[:, None] * np.hstack(
            [antecedent.reshape(len(self.x), -1), by_offset]
        )
        jacobian -= basis @ (basis.T @ jacobian)
        return jacobian, residual

    def _shift(self, point: np.ndarray) -> np.ndarray:
        """Return the offset of every pair, shape (N,)."""
        return self._members @ self.offsets(point)

    def _antecedents(self, point: np.ndarray) -> np.ndarray:
        rules = np.zeros((self.rule_count, 6))
        rules[:, _ANTECEDENT] = point[: 3 * self.rule_count].reshape(-1, 3)
        return rule_coordinates.to_rules(rules)

    def _project(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return rules with the best consequents, residual, and a basis of the regressors."""
        rules = self._antecedents(point)
        matrix, target = self._regression(rules, self._shift(point))
        basis, factor = qr(matrix, mode="economic", check_finite=False)
        projected = basis.T @ target
        rules[:, _CONSEQUENT] = solve_triangular(factor, projected).reshape(-1, 3)
        return rules, basis @ projected - target, basis

    def _regression(self, rules: np.ndarray, shift: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the problem for the consequents, matrix (N + 3 L, 3 L) and target, with ridge."""
        y_previous = self.y_previous - shift
        lower, upper, total = normalised_memberships(rules, y_previous)
        share = (lower + upper) / total * self.weight[:, None]
        regressors = np.stack(
            [share * y_previous[:, None], share * self.x[:, None], share], axis=2
        ).reshape(len(self.x), -1)
        columns = regressors.shape[1]
        ridge = _RIDGE * np.linalg.norm(regressors) * np.eye(columns)
        target = np.concatenate([self.weight * (self.y - shift), np.zeros(columns)])
        return np.vstack([regressors, ridge]), target


def antecedent_starts(
    y: np.ndarray, rule_count: int, generator: np.random.Generator
) -> Iterator[np.ndarray]:
    """Yield starts for the antecedents without end: rules spread over the data, then variations.

    Upper memberships much wider than the lower ones are drawn on purpose: they blend every rule
    into every other, and from narrow ones the search ends in poor optima (measured on data made
    by Table 1: none of 80 starts with s2 < 4 s1 found it, 7 of 40 with 6 s1 < s2 < 30 s1 did).

    Parameters
    ----------
    y : ndarray
        Measured displacements in scaled units.
    rule_count : int
        Number of rules L.
    generator : numpy.random.Generator
        Source of the random starts.

    Yields
    ------
    ndarray, shape (3 L,)
        Coordinates log s1, log(s2 / s1), c of each rule.
    """
    low, high = np.min(y), np.max(y)
    spacing = (high - low) / rule_count
    even = np.linspace(low, high, rule_count) if rule_count > 1 else np.array([(low + high) / 2])
    spread = 0.0
    while True:
        centres = even + spread * generator.standard_normal(rule_count)
        widths = np.log(spacing) + generator.uniform(np.log(0.35), np.log(1.2), rule_count)
        ratios = generator.uniform(np.log(2.0), np.log(30.0), rule_count)
        yield np.column_stack([widths, ratios, centres]).ravel()
        spread = 0.3 * spacing


def fit_projected(problem: ProjectedOneStep, start: np.ndarray, max_iterations: int) -> Minimum:
    """Minimise the projected criterion from one start of its coordinates, shape (3 L + O,)."""
    return levenberg_marquardt(
        problem.residual,
        problem.linearise,
        start,
        problem.lower,
        problem.upper,
        tolerance=1e-7,
        max_iterations=max_iterations,
    )
