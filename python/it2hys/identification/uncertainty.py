"""How well the data determine the parameters: intervals, condition, and what stays open."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from it2hys.identification import rule_coordinates
from it2hys.model.parameters import RULE_FIELDS

if TYPE_CHECKING:
    from it2hys.identification.criterion import ChainCriterion, ChainFit

NORMAL_95 = 1.959964
_RANK_TOLERANCE = 1e-9
#: Share of a coordinate in a direction that the records do not show, from which on it is lost with it.
_LOST = 0.1
#: The same of a figure's gradient: less of it is rounding.
_UNSEEN = 0.01
#: Half widths of the 95 % interval beyond which a rule's coordinate counts as undetermined: a
#: factor of e in a deviation, half the range for a centre or q3, half the usual size of q1 and q2.
_PLAUSIBLE = {"sigmaLower": 1.0, "sigmaUpper": 1.0, "centre": 1.0, "q1": 0.5, "q2": 0.5, "q3": 1.0}
#: A parameter belongs to a direction if it moves by this share of the one that moves most.
_MEMBER = 0.3


@dataclass(frozen=True)
class Uncertainty:
    """Result of `assess`.

    Parameters
    ----------
    intervals : dict of str to (float, float)
        95 % intervals of rules and effects by FMU parameter name, SI units; NaN for a parameter at a
        bound or that the records do not determine, none of one that the fit held.
    starts : dict of str to (float, float)
        The same of what belongs to the first record alone.
    condition : float
        Condition number of the Jacobian by what the records share, in units of a plausible interval.
    undetermined : tuple of str
        Parameters of rules that the data do not determine.
    groups : tuple of tuple of str
        The undetermined parameters, those together that can change together without changing the
        fit.
    spreads : ndarray, shape (P, K)
        A root of the coordinates' covariance; rows of 0 for those at a bound.
    unseen : ndarray, shape (P, U)
        Directions of the coordinates that the records do not show.
    units : ndarray, shape (P,)
        Change of every coordinate that is as large as a plausible interval.
    """

    intervals: dict[str, tuple[float, float]]
    starts: dict[str, tuple[float, float]]
    condition: float
    undetermined: tuple[str, ...]
    groups: tuple[tuple[str, ...], ...]
    spreads: np.ndarray
    unseen: np.ndarray
    units: np.ndarray

    def deviation(self, gradient: np.ndarray) -> float:
        """Return the standard deviation of a figure by its gradient by the coordinates, (P,).

        NaN where it depends on what the records do not show.
        """
        if np.linalg.norm(gradient @ self.unseen) > _UNSEEN * np.linalg.norm(gradient * self.units):
            return float("nan")
        return float(np.linalg.norm(gradient @ self.spreads))

    def sentences(self) -> list[str]:
        """Return what is not determined, in words."""
        single = [group[0] for group in self.groups if len(group) == 1]
        texts = [f"The data do not determine {', '.join(single)}."] if single else []
        return texts + [
            f"The data determine {', '.join(group[:-1])} and {group[-1]} only together: some "
            "combinations of them can change without changing the fit."
            for group in self.groups
            if len(group) > 1
        ]


def assess(fit: ChainFit) -> Uncertainty:
    """Return intervals and determinacy of the parameters at a free-run optimum.

    Parameters
    ----------
    fit : ChainFit

    Notes
    -----
    Residuals of a free run are correlated in time, so that the usual covariance s^2 (J^T J)^-1 is
    far too small. The sandwich H^-1 M H^-1 is used, H = J^T J, with M estimated from sums of
    J^T r over blocks longer than the residuals' correlation (batch means). It also covers a model
    that does not contain the truth: the spread is that of the best model over such records.

    All is computed in the basis of H's eigenvectors in plausible units. Those whose eigenvalue is
    so small that the interval along them is wider than a plausible one are undetermined
    directions; the parameters that such a direction moves form a group.
    """
    criterion, point = fit.criterion, fit.minimum.coordinates
    jacobian, residual = criterion.jacobian(point)
    free = np.flatnonzero((point > criterion.lower) & (point < criterion.upper))
    every_unit = _plausible_units(criterion, point)
    units = every_unit[free]
    scaled = jacobian[:, free] * units
    factor = np.linalg.qr(scaled, mode="r")
    _, singular, directions = np.linalg.svd(factor, full_matrices=False)
    kept = singular > _RANK_TOLERANCE * singular[0]
    # scores in the singular basis: well scaled, whatever the condition
    meat = batch_covariance((scaled * residual[:, None]) @ directions[kept].T, residual)
    transform = units[:, None] * directions[kept].T / singular[kept] ** 2
    covariance = np.full((len(point), len(point)), np.nan)
    # by a root of the middle one: a variance is then no difference of large numbers
    values, vectors = np.linalg.eigh(meat)
    spreads = transform @ (vectors * np.sqrt(np.maximum(values, 0.0)))
    covariance[np.ix_(free, free)] = spreads @ spreads.T
    root, unseen = np.zeros((len(point), len(values))), np.zeros((len(point), sum(~kept)))
    root[free], unseen[free] = spreads, units[:, None] * directions[~kept].T
    lost = free[np.any(np.abs(directions[~kept]) > _LOST, axis=0)]
    covariance[lost, lost] = np.nan
    rules = _of_rules(criterion, point, covariance)
    undetermined = _undetermined(rules, criterion, point, covariance)
    spread = np.full(len(singular), np.inf)
    spread[kept] = NORMAL_95 * np.sqrt(np.diag(meat)) / singular[kept] ** 2
    weak = np.zeros((np.count_nonzero(spread > 1.0), len(point)))
    weak[:, free] = directions[spread > 1.0]
    return Uncertainty(
        {**rules, **_of_effects(criterion, point, covariance)},
        _of_starts(criterion, point, covariance),
        _condition(factor[:, free < criterion.rule_size + len(criterion.common)]),
        undetermined,
        _groups(weak[:, : criterion.rule_size], undetermined),
        root,
        unseen,
        every_unit,
    )


def _condition(factor: np.ndarray) -> float:
    """Return the ratio of the largest to the least singular value."""
    singular = np.linalg.svd(factor, compute_uv=False)
    return float(singular[0] / singular[-1]) if singular[-1] > 0.0 else np.inf


def _plausible_units(criterion: ChainCriterion, point: np.ndarray) -> np.ndarray:
    """Return the change of every coordinate that is as large as a plausible interval, (P,)."""
    q2 = point[: criterion.rule_size].reshape(criterion.rule_count, -1)[:, 4]
    gain = max(float(np.mean(np.abs(q2))), 1e-12)
    units = np.ones(len(point))
    rule = np.array([_PLAUSIBLE[name] * (gain if name == "q2" else 1.0) for name in RULE_FIELDS])
    units[: criterion.rule_size] = np.tile(rule, criterion.rule_count)
    return units


Intervals = dict[str, tuple[float, float]]


def _of_rules(criterion: ChainCriterion, point: np.ndarray, covariance: np.ndarray) -> Intervals:
    """Return the intervals of the rules; NaN where one depends on a coordinate that has none."""
    size = criterion.rule_size
    rules = criterion.rules(point)
    # d(scaled rules) / d(coordinates), then to SI units
    to_scaled = rule_coordinates.chain_rule(np.eye(size), rules)
    to_physical = criterion.scaling.rule_jacobian(rules) @ to_scaled
    block = covariance[:size, :size]
    held = np.isnan(np.diag(block))
    variance = np.diag(to_physical @ np.nan_to_num(block) @ to_physical.T)
    spread = np.sqrt(np.maximum(variance, 0.0))  # rounding may leave it below zero
    spread[np.any((to_physical != 0.0) & held, axis=1)] = np.nan
    values = criterion.scaling.physical_rules(rules).ravel()
    return {
        parameter_name(i): (float(v - NORMAL_95 * s), float(v + NORMAL_95 * s))
        for i, (v, s) in enumerate(zip(values, spread, strict=True))
    }


def _undetermined(
    rules: Intervals, criterion: ChainCriterion, point: np.ndarray, covariance: np.ndarray
) -> tuple[str, ...]:
    """Return the rules' parameters without an interval, or with one that is wider than plausible."""
    half = NORMAL_95 * np.sqrt(np.diag(covariance))
    units = _plausible_units(criterion, point)
    return tuple(n for i, n in enumerate(rules) if not half[i] <= units[i])


def _of_effects(criterion: ChainCriterion, point: np.ndarray, covariance: np.ndarray) -> Intervals:
    result = {}
    for i, coordinate in enumerate(criterion.common, start=criterion.rule_size):
        if coordinate.name in criterion.held:
            continue
        half = NORMAL_95 * np.sqrt(covariance[i, i])
        with np.errstate(over="ignore"):  # of what the records hardly determine
            ends = (coordinate.value(point[i] - half), coordinate.value(point[i] + half))
        result[coordinate.name] = tuple(float(e) for e in ends) if np.isfinite(half) else (np.nan,) * 2
    return result


def _of_starts(criterion: ChainCriterion, point: np.ndarray, covariance: np.ndarray) -> Intervals:
    result = {}
    for name, unit, i in criterion.first_start:
        half = NORMAL_95 * np.sqrt(covariance[i, i])
        result[name] = (float(unit * (point[i] - half)), float(unit * (point[i] + half)))
    return result


def _groups(directions: np.ndarray, undetermined: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
    """Return the undetermined parameters, joined where a direction moves several of them.

    Parameters
    ----------
    directions : ndarray, shape (K, 6 L)
        Undetermined directions of the rules' coordinates, in plausible units.
    undetermined : tuple of str
    """
    count = directions.shape[1] // rule_coordinates.RULE_SIZE
    table = directions.reshape(len(directions), count, rule_coordinates.RULE_SIZE).copy()
    # from log(s2 / s1) to log s2
    table[:, :, 1] += table[:, :, 0]
    groups = [{name} for name in undetermined]
    for direction in np.abs(table.reshape(directions.shape)):
        moved = np.flatnonzero(direction > _MEMBER * direction.max())
        names = {parameter_name(i) for i in moved}
        joined = [group for group in groups if group & names]
        groups = [group for group in groups if not group & names]
        if joined:
            groups.append(set().union(*joined))
    groups.sort(key=lambda group: min(map(undetermined.index, group)))
    return tuple(tuple(n for n in undetermined if n in group) for group in groups)


def parameter_name(index: int) -> str:
    """Return the FMU's name of the i-th number of the rules, counted row by row."""
    rule, column = divmod(index, rule_coordinates.RULE_SIZE)
    return f"rule[{rule + 1}].{RULE_FIELDS[column]}"


def correlation_time(residual: np.ndarray) -> float:
    """Return the integrated autocorrelation time of a series in samples, at least 1.

    The sum of autocorrelations, taken until the first that is not positive.
    """
    centred = residual - np.mean(residual)
    count = len(centred)
    spectrum = np.fft.rfft(centred, 2 * count)
    correlation = np.fft.irfft(np.abs(spectrum) ** 2)[:count]
    if correlation[0] <= 0.0:
        return 1.0
    correlation = correlation / correlation[0]
    negative = np.flatnonzero(correlation <= 0.0)
    end = negative[0] if len(negative) else count
    return float(max(1.0, 1.0 + 2.0 * correlation[1:end].sum()))


def batch_covariance(scores: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Return the covariance of the sum of scores, (N, P), correlated as the residuals are, (N,)."""
    count, parameters = scores.shape
    longest = max(1, count // (4 * max(parameters, 1)))
    length = int(np.clip(2.0 * correlation_time(residual), 1, longest))
    sums = np.add.reduceat(scores, np.arange(0, count, length), axis=0)
    return sums.T @ sums
