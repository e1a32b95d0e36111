"""The two criteria of (23): one step ahead, and the free run, on several records at once.

Both are sums of squares over the same coordinates (see `coordinates`), so every estimator works on
either. Residuals are model minus measurement in scaled units, times the sample's weight.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from it2hys.identification import rule_coordinates
from it2hys.identification.levenberg_marquardt import Block, Linearisation, joined
from it2hys.model import compiled

if TYPE_CHECKING:
    from it2hys.identification.usability import Guard

#: Beyond so many half ranges a run is on its way to infinity; products would overflow.
_DIVERGED = 1e3
#: Weight of the guess of an initial state, in samples. Where the leading samples are discarded,
#: the data do not determine the state before them; elsewhere this is negligible.
_STATE_PRIOR = 1e-3


@dataclass(frozen=True, eq=False)
class Series:
    """One record in scaled units, as the criteria need it.

    Parameters
    ----------
    x, y : ndarray, shape (N,)
        Voltage and measured displacement.
    weight : ndarray, shape (N,)
        Weight of each residual; 0 for samples that are not to be fitted.
    state : float
        Guess of the displacement before the first sample.
    has_offset : bool
        Whether the record differs from the model by a constant of its own.
    offset : float
        Guess of that constant.
    """

    x: np.ndarray
    y: np.ndarray
    weight: np.ndarray
    state: float
    has_offset: bool = False
    offset: float = 0.0


class FreeRun:
    """The free-run criterion: the model gets the voltage alone and its own past output.

    Parameters
    ----------
    series : sequence of Series
        The records.
    rule_count : int
        Number of rules L.
    limits : (float, float), optional
        Scaled range of displacement that given rules hold for, see `compiled.free_run`. A fit of rules
        does not know it yet.
    """

    def __init__(
        self,
        series: Sequence[Series],
        rule_count: int,
        limits: tuple[float, float] | None = None,
    ):
        self.series = list(series)
        self._limits = limits
        self.rule_count = rule_count
        self.rule_size = rule_coordinates.RULE_SIZE * rule_count
        self._with_offset = [i for i, s in enumerate(self.series) if s.has_offset]
        lower, upper = rule_coordinates.rule_bounds(rule_count)
        tail = len(self.series) + len(self._with_offset)
        self.lower = np.concatenate([lower, np.full(tail, -3.0)])
        self.upper = np.concatenate([upper, np.full(tail, 3.0)])
        self._guard = None
        self.samples = sum(int(np.count_nonzero(s.weight)) for s in self.series)

    def pack(
        self,
        rules: np.ndarray,
        states: np.ndarray | None = None,
        offsets: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return rules, states and offsets (or their guesses) as coordinates, shape (P,)."""
        if offsets is None:
            offsets = [s.offset for s in self.series]
        if states is None:
            states = [s.state - o for s, o in zip(self.series, offsets, strict=True)]
        offsets = np.asarray(offsets)[self._with_offset]
        return np.concatenate([rule_coordinates.to_coordinates(rules), states, offsets])

    def with_guard(self, guard: Guard) -> FreeRun:
        """Return the criterion with penalties for an unusable model added."""
        guarded = copy(self)
        guarded._guard = guard
        return guarded

    def with_fixed_rules(self, rules: np.ndarray) -> FreeRun:
        """Return the criterion over initial states and offsets alone: the bounds hold the rules."""
        fixed = copy(self)
        fixed.lower, fixed.upper = self.lower.copy(), self.upper.copy()
        held = rule_coordinates.to_coordinates(rules)
        fixed.lower[: self.rule_size] = fixed.upper[: self.rule_size] = held
        return fixed

    def rules(self, point: np.ndarray) -> np.ndarray:
        """Return the scaled rules, shape (L, 6), of the coordinates."""
        return rule_coordinates.to_rules(point[: self.rule_size])

    def rule_coordinates(self, point: np.ndarray) -> np.ndarray:
        """Return the coordinates of the rules, shape (L, 6)."""
        return point[: self.rule_size].reshape(-1, rule_coordinates.RULE_SIZE)

    def states(self, point: np.ndarray) -> np.ndarray:
        """Return the initial state of every record."""
        return point[self.rule_size : self.rule_size + len(self.series)]

    def offsets(self, point: np.ndarray) -> np.ndarray:
        """Return the offset of every record, 0 for those without one."""
        offsets = np.zeros(len(self.series))
        offsets[self._with_offset] = point[self.rule_size + len(self.series) :]
        return offsets

    def residual(self, point: np.ndarray) -> np.ndarray | None:
        """Return the weighted residuals, or None where a run is no longer finite."""
        rules, states, offsets = self.rules(point), self.states(point), self.offsets(point)
        parts = []
        for series, state, offset in zip(self.series, states, offsets, strict=True):
            run = self._run(rules, series, state, offset)
            if not np.all(np.abs(run) < _DIVERGED):
                return None
            parts.append((series.weight * (run + offset - series.y))[series.weight > 0])
        parts.append(self._state_residual(states, offsets))
        if self._guard is not None:
            parts.append(self._guard.residual(rules))
        return np.concatenate(parts)

    def _state_residual(self, states: np.ndarray, offsets: np.ndarray) -> np.ndarray:
        return _STATE_PRIOR * (states + offsets - [s.state for s in self.series])

    @np.errstate(over="ignore", invalid="ignore")  # of sensitivities on their way to infinity
    def linearise(self, point: np.ndarray) -> Linearisation | None:
        """Return the problem linearised at a point, or None where a run is no longer finite."""
        return Linearisation.of_blocks(self._blocks(point), len(point))

    def jacobian(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the whole Jacobian, shape (M, P), and the residuals, shape (M,), or None."""
        return joined(self._blocks(point))

    def _blocks(self, point: np.ndarray) -> Iterator[Block | None]:
        """Yield records, guesses of the states and penalties; None where a run is no longer finite."""
        rules, states, offsets = self.rules(point), self.states(point), self.offsets(point)
        by_coordinates = rule_coordinates.chain_rule(np.eye(self.rule_size), rules)
        for i, series in enumerate(self.series):
            run, sensitivity, by_offset = self._sensitivity(rules, series, states[i], offsets[i])
            if not (np.all(np.abs(run) < _DIVERGED) and np.all(np.isfinite(sensitivity[-1]))):
                yield None
                return
            columns = [self.rule_size + i]
            if i in self._with_offset:
                sensitivity = np.column_stack([sensitivity, by_offset])
                columns.append(self.rule_size + len(self.series) + self._with_offset.index(i))
            residual = run + offsets[i] - series.y
            used = series.weight > 0
            if not np.all(used):
                sensitivity, residual = sensitivity[used], residual[used]
            sensitivity *= series.weight[used, None]
            residual *= series.weight[used]
            to_point = np.zeros((sensitivity.shape[1], len(point)))
            to_point[: self.rule_size, : self.rule_size] = by_coordinates
            to_point[self.rule_size + np.arange(len(columns)), columns] = 1.0
            yield sensitivity, residual, to_point
        yield self._state_block(point)
        if self._guard is not None:
            by_rules, penalties = self._guard.linearise(rules)
            yield by_rules, penalties, np.eye(self.rule_size, len(point))

    def _state_block(self, point: np.ndarray) -> Block:
        states, offsets = self.states(point), self.offsets(point)
        count = len(states)
        to_point = np.zeros((count, len(point)))
        to_point[:, self.rule_size : self.rule_size + count] = np.eye(count)
        columns = self.rule_size + count + np.arange(len(self._with_offset))
        to_point[self._with_offset, columns] = 1.0
        return _STATE_PRIOR * np.eye(count), self._state_residual(states, offsets), to_point

    def _run(self, rules: np.ndarray, series: Series, state: float, offset: float) -> np.ndarray:
        return compiled.free_run(rules, series.x, state, self._limits)

    def _sensitivity(
        self, rules: np.ndarray, series: Series, state: float, offset: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the run and its derivatives by rules and initial state, (N, 6 L + 1), and offset.

        The offset is added to the run, so that its column starts from 1.
        """
        run, sensitivity = compiled.free_run_sensitivity(rules, series.x, state, self._limits)
        return run, sensitivity, np.ones(len(run))


class OneStep(FreeRun):
    """The one-step-ahead criterion: the model gets the measured y(k-1) at every sample."""

    def _run(self, rules: np.ndarray, series: Series, state: float, offset: float) -> np.ndarray:
        return compiled.one_step(rules, self._previous(series, state, offset), series.x)

    def _sensitivity(
        self, rules: np.ndarray, series: Series, state: float, offset: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        previous = self._previous(series, state, offset)
        run, by_rules, by_previous = one_step_gradient(rules, previous, series.x)
        by_state, by_offset = np.zeros(len(run)), 1.0 - by_previous
        by_state[0], by_offset[0] = by_previous[0], 1.0
        return run, np.column_stack([by_rules, by_state]), by_offset

    @staticmethod
    def _previous(series: Series, state: float, offset: float) -> np.ndarray:
        return np.concatenate([[state], series.y[:-1] - offset])


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
