"""How well the data determine the parameters: intervals, condition, and what stays open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from it2hys.identification import coordinates
from it2hys.identification.criteria import FreeRun
from it2hys.identification.scaling import Scaling
from it2hys.parameters import RULE_FIELDS

_NORMAL_95 = 1.959964
_RANK_TOLERANCE = 1e-9
#: Half widths of the 95 % interval beyond which a rule's coordinate counts as undetermined: a
#: factor of e in a deviation, half the range for a centre or q3, half the usual size of q1 and q2.
_PLAUSIBLE = {"sigmaLower": 1.0, "sigmaUpper": 1.0, "centre": 1.0, "q1": 0.5, "q2": 0.5, "q3": 1.0}


@dataclass(frozen=True)
class Uncertainty:
    """Result of `assess`; see `Identification` for the fields."""

    intervals: dict[str, tuple[float, float]]
    condition: float
    undetermined: tuple[str, ...]


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
    """
    jacobian, residual = criterion.jacobian(point)
    free = np.flatnonzero((point > criterion.lower) & (point < criterion.upper))
    norms = np.linalg.norm(jacobian[:, free], axis=0)
    norms[norms == 0.0] = 1.0
    _, singular, directions = np.linalg.svd(
        np.linalg.qr(jacobian[:, free] / norms, mode="r"), full_matrices=False
    )
    kept = singular > _RANK_TOLERANCE * singular[0]
    # scores in the singular basis: well scaled, whatever the condition
    transform = (directions[kept].T / singular[kept] ** 2) / norms[:, None]
    scores = (jacobian[:, free] / norms * residual[:, None]) @ directions[kept].T
    covariance = np.zeros((len(point), len(point)))
    meat = _batch_covariance(scores, residual)
    covariance[np.ix_(free, free)] = transform @ meat @ transform.T
    deviations = np.full(len(point), np.nan)
    deviations[free] = np.sqrt(np.diag(covariance)[free])
    lost = np.any(np.abs(directions[~kept]) > 0.1, axis=0)
    deviations[free[lost]] = np.inf
    intervals, undetermined = _by_name(criterion, point, scaling, covariance, deviations)
    return Uncertainty(intervals, float(singular[0] / singular[-1]), undetermined)


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


def _batch_covariance(scores: np.ndarray, residual: np.ndarray) -> np.ndarray:
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
    to_scaled = coordinates.chain_rule(np.eye(size), rules)
    to_physical = scaling.rule_jacobian(rules) @ to_scaled
    spread = np.sqrt(np.diag(to_physical @ covariance[:size, :size] @ to_physical.T))
    values = scaling.physical_rules(rules).ravel()
    gain = max(float(np.mean(np.abs(rules[:, 4]))), 1e-12)
    intervals, undetermined = {}, []
    for i, value in enumerate(values):
        rule, column = divmod(i, coordinates.RULE_SIZE)
        name = f"rule[{rule + 1}].{RULE_FIELDS[column]}"
        held = not np.isfinite(deviations[i])
        half = np.nan if held else _NORMAL_95 * spread[i]
        intervals[name] = (float(value - half), float(value + half))
        plausible = _PLAUSIBLE[RULE_FIELDS[column]] * (gain if column == 4 else 1.0)
        if held or _NORMAL_95 * deviations[i] > plausible:
            undetermined.append(name)
    state = float(scaling.displacement(point[size]))
    half = _NORMAL_95 * deviations[size] * scaling.y_unit
    intervals["initialDisplacement"] = (state - half, state + half)
    return intervals, tuple(undetermined)
