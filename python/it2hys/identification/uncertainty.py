"""How well the data determine the parameters: intervals, condition, and what stays open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from it2hys.identification import rule_coordinates
from it2hys.identification.criteria import FreeRun
from it2hys.identification.scaling import Scaling
from it2hys.model.parameters import RULE_FIELDS

NORMAL_95 = 1.959964
_RANK_TOLERANCE = 1e-9
#: Half widths of the 95 % interval beyond which a rule's coordinate counts as undetermined: a
#: factor of e in a deviation, half the range for a centre or q3, half the usual size of q1 and q2.
_PLAUSIBLE = {"sigmaLower": 1.0, "sigmaUpper": 1.0, "centre": 1.0, "q1": 0.5, "q2": 0.5, "q3": 1.0}
#: A parameter belongs to a direction if it moves by this share of the one that moves most.
_MEMBER = 0.3


@dataclass(frozen=True)
class Uncertainty:
    """Result of `assess`; see `Identification` for the first three fields.

    Parameters
    ----------
    intervals : dict of str to (float, float)
    condition : float
    undetermined : tuple of str
    groups : tuple of tuple of str
        The undetermined parameters, those together that can change together without changing the
        fit.
    """

    intervals: dict[str, tuple[float, float]]
    condition: float
    undetermined: tuple[str, ...]
    groups: tuple[tuple[str, ...], ...]

    def sentences(self) -> list[str]:
        """Return what is not determined, in words."""
        single = [group[0] for group in self.groups if len(group) == 1]
        texts = [f"The data do not determine {', '.join(single)}."] if single else []
        return texts + [
            f"The data determine {', '.join(group[:-1])} and {group[-1]} only together: some of "
            "their combinations may change without changing the fit."
            for group in self.groups
            if len(group) > 1
        ]


def assess(criterion: FreeRun, point: np.ndarray, scaling: Scaling) -> Uncertainty:
    """Return intervals and determinacy of the rules at a free-run optimum.

    Parameters
    ----------
    criterion : FreeRun
        Without penalties.
    point : ndarray, shape (P,)
        The optimum's coordinates.
    scaling : Scaling

    Returns
    -------
    Uncertainty

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
    jacobian, residual = criterion.jacobian(point)
    free = np.flatnonzero((point > criterion.lower) & (point < criterion.upper))
    units = _plausible_units(criterion, point)[free]
    scaled = jacobian[:, free] * units
    _, singular, directions = np.linalg.svd(np.linalg.qr(scaled, mode="r"), full_matrices=False)
    kept = singular > _RANK_TOLERANCE * singular[0]
    # scores in the singular basis: well scaled, whatever the condition
    meat = batch_covariance((scaled * residual[:, None]) @ directions[kept].T, residual)
    transform = units[:, None] * directions[kept].T / singular[kept] ** 2
    covariance = np.zeros((len(point), len(point)))
    covariance[np.ix_(free, free)] = transform @ meat @ transform.T
    deviations = np.full(len(point), np.nan)
    deviations[free] = np.sqrt(np.diag(covariance)[free])
    lost = np.any(np.abs(directions[~kept]) > 0.1, axis=0)
    deviations[free[lost]] = np.inf
    intervals, undetermined = _by_name(criterion, point, scaling, covariance, deviations)
    spread = np.full(len(singular), np.inf)
    spread[kept] = NORMAL_95 * np.sqrt(np.diag(meat)) / singular[kept] ** 2
    weak = np.zeros((np.count_nonzero(spread > 1.0), len(point)))
    weak[:, free] = directions[spread > 1.0]
    groups = _groups(weak[:, : criterion.rule_size], undetermined)
    condition = float(singular[0] / singular[-1]) if singular[-1] > 0.0 else np.inf
    return Uncertainty(intervals, condition, undetermined, groups)


def _plausible_units(criterion: FreeRun, point: np.ndarray) -> np.ndarray:
    """Return the change of every coordinate that is as large as a plausible interval, (P,)."""
    gain = max(float(np.mean(np.abs(criterion.rule_coordinates(point)[:, 4]))), 1e-12)
    units = np.ones(len(point))
    rule = np.array([_PLAUSIBLE[name] * (gain if name == "q2" else 1.0) for name in RULE_FIELDS])
    units[: criterion.rule_size] = np.tile(rule, criterion.rule_count)
    return units


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


def _by_name(
    criterion: FreeRun,
    point: np.ndarray,
    scaling: Scaling,
    covariance: np.ndarray,
    deviations: np.ndarray,
) -> tuple[dict[str, tuple[float, float]], tuple[str, ...]]:
    """Return intervals in SI units and undetermined parameters, by FMU parameter name."""
    rules = criterion.rules(point)
    size = criterion.rule_size
    # d(scaled rules) / d(coordinates), then to SI units
    to_scaled = rule_coordinates.chain_rule(np.eye(size), rules)
    to_physical = scaling.rule_jacobian(rules) @ to_scaled
    variance = np.diag(to_physical @ covariance[:size, :size] @ to_physical.T)
    spread = np.sqrt(np.maximum(variance, 0.0))  # rounding may leave it below zero
    values = scaling.physical_rules(rules).ravel()
    units = _plausible_units(criterion, point)
    intervals, undetermined = {}, []
    for i, value in enumerate(values):
        name = parameter_name(i)
        held = not np.isfinite(deviations[i])
        half = np.nan if held else NORMAL_95 * spread[i]
        intervals[name] = (float(value - half), float(value + half))
        if held or NORMAL_95 * deviations[i] > units[i]:
            undetermined.append(name)
    state = float(scaling.displacement(point[size]))
    half = NORMAL_95 * deviations[size] * scaling.y_unit
    intervals["initialDisplacement"] = (state - half, state + half)
    return intervals, tuple(undetermined)
