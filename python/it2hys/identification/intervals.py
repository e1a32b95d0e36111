"""How well the records determine the parameters of a chain."""

from __future__ import annotations

import numpy as np

from it2hys.identification import rule_coordinates
from it2hys.identification.criterion import ChainFit
from it2hys.identification.uncertainty import NORMAL_95, batch_covariance, parameter_name

_RANK_TOLERANCE = 1e-9


def intervals_of(fit: ChainFit) -> dict[str, tuple[float, float]]:
    """Return 95 % intervals of rules and effects by FMU parameter name, SI units.

    By the sandwich of `identification.uncertainty.assess`, whose notes say why: residuals of a free run
    are correlated in time. NaN for a parameter at a bound or that the records do not determine.
    """
    criterion, point = fit.criterion, fit.minimum.coordinates
    jacobian, residual = criterion.jacobian(point)
    free = np.flatnonzero((point > criterion.lower) & (point < criterion.upper))
    columns = jacobian[:, free]
    norms = np.linalg.norm(columns, axis=0)
    norms[norms == 0.0] = 1.0
    scaled = columns / norms
    _, singular, directions = np.linalg.svd(np.linalg.qr(scaled, mode="r"), full_matrices=False)
    kept = singular > _RANK_TOLERANCE * singular[0]
    meat = batch_covariance((scaled * residual[:, None]) @ directions[kept].T, residual)
    transform = directions[kept].T / norms[:, None] / singular[kept] ** 2
    covariance = np.full((len(point), len(point)), np.nan)
    covariance[np.ix_(free, free)] = transform @ meat @ transform.T
    return {**_of_rules(fit, covariance), **_of_effects(fit, covariance)}


def _of_rules(fit: ChainFit, covariance: np.ndarray) -> dict[str, tuple[float, float]]:
    criterion, point = fit.criterion, fit.minimum.coordinates
    size = criterion.rule_size
    rules = rule_coordinates.to_rules(point[:size])
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


def _of_effects(fit: ChainFit, covariance: np.ndarray) -> dict[str, tuple[float, float]]:
    criterion, point = fit.criterion, fit.minimum.coordinates
    result = {}
    for i, coordinate in enumerate(criterion.common, start=criterion.rule_size):
        half = NORMAL_95 * np.sqrt(covariance[i, i])
        with np.errstate(over="ignore"):  # of what the records hardly determine
            ends = (coordinate.value(point[i] - half), coordinate.value(point[i] + half))
        result[coordinate.name] = tuple(float(e) for e in ends) if np.isfinite(half) else (np.nan,) * 2
    return result
