"""How much of a displacement its voltage explains, whatever the model.

A displacement that other inputs move too (a second axis, a force, heat, a neighbour's machine) cannot
be explained by its voltage, and no model is to blame for that. So a generous predictor is fitted that
knows no physics: past voltages, slow answers to them, play of many widths, powers and branches, all
linear in their coefficients. What it explains of parts of the record that it was not fitted to is a
lower bound of what the voltage explains.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from it2hys.policy import NOISE

#: Samples that are looked at, in the middle of a longer record.
_MOST = 20_000
#: Past voltages, and time constants of slow answers to them, in samples.
_LAGS = (*range(9), 12, 16, 24, 32, 48, 64)
_SLOW = (10.0, 30.0, 100.0, 300.0, 1000.0)
#: Half widths of play, as shares of half the voltage's range.
_PLAYS = (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7)
#: Parts of a record, and sets of them that are predicted from the others. With fewer parts, or less
#: weight below, a record of a cycle or two is a little less explained (seeds 960 to 963: 0.90 instead
#: of 0.95 at the least, of six drives of 0.2 s); noise alone stays unexplained.
_PARTS, _FOLDS = 100, 10
#: Weight of the prior that all coefficients are zero, as a share of the samples.
_NOTHING = 1e-3


def explained_by_voltage(voltage: np.ndarray, displacement: np.ndarray, used: np.ndarray) -> float:
    """Return the share of a displacement's variance that its voltage predicts on parts not fitted.

    Parameters
    ----------
    voltage, displacement : ndarray, shape (N,)
    used : ndarray of bool, shape (N,)
        Samples that count.

    Returns
    -------
    float
        0 to 1; NaN where nothing varies.
    """
    middle = slice(max(0, (len(voltage) - _MOST) // 2), (len(voltage) + _MOST) // 2)
    voltage, y, used = voltage[middle], displacement[middle], used[middle]
    if np.ptp(voltage) == 0.0 or np.count_nonzero(used) < 2 * _PARTS or np.ptp(y[used]) == 0.0:
        return float("nan")
    features = _features(voltage)
    y = y - np.mean(y[used])
    fold = np.arange(len(y)) * _PARTS // len(y) % _FOLDS
    held = [(features[used & (fold == k)], y[used & (fold == k)]) for k in range(_FOLDS)]
    normals, products = [x.T @ x for x, _ in held], [x.T @ z for x, z in held]
    nothing = _NOTHING * np.count_nonzero(used) * np.eye(features.shape[1])
    squares = 0.0
    for (x, z), normal, product in zip(held, normals, products, strict=True):
        fit = np.linalg.solve(sum(normals) - normal + nothing, sum(products) - product)
        squares += np.sum((z - x @ fit) ** 2)
    return float(np.clip(1.0 - squares / np.sum(y[used] ** 2), 0.0, 1.0))


def _features(voltage: np.ndarray) -> np.ndarray:
    """Return what a voltage's past can make, each of unit size, (N, K)."""
    x = 2.0 * (voltage - voltage.min()) / np.ptp(voltage) - 1.0
    branch = np.sign(np.gradient(x))
    columns = [np.concatenate([np.full(k, x[0]), x[: len(x) - k]]) for k in _LAGS if k < len(x)]
    for ticks in _SLOW:
        pole = np.exp(-1.0 / ticks)
        columns.append(lfilter([1.0 - pole], [1.0, -pole], x, zi=[pole * x[0]])[0])
    columns += [_play(x, width) for width in _PLAYS]
    columns += [x**2, x**3, x**4, branch, branch * x, branch * x**2]
    stacked = np.column_stack([np.ones(len(x)), *columns])
    return stacked / np.maximum(np.sqrt(np.mean(stacked**2, axis=0)), np.finfo(float).tiny)


def _play(x: np.ndarray, width: float) -> np.ndarray:
    result, state = np.empty(len(x)), x[0]
    for k, value in enumerate(x.tolist()):
        state = min(max(state, value - width), value + width)
        result[k] = state
    return result


def explained_by_model(displacement: np.ndarray, reading: np.ndarray, used: np.ndarray) -> float:
    """Return the share of a displacement's variance that a model's reading explains; 0 at least."""
    power = np.var(displacement[used])
    error = np.mean((displacement - reading)[used] ** 2)
    if not (power > 0.0 and np.isfinite(error)):
        return float("nan")
    return float(max(0.0, 1.0 - error / power))


def low_share(name: str, *shares: float) -> list[str]:
    """Return a sentence on a record of which the voltage explains little, or nothing.

    Parameters
    ----------
    name : str
        Of the record.
    *shares : float
        That a model and a generous predictor explain.
    """
    if not all(share < NOISE.explained for share in shares):
        return []
    return [
        f"The voltage explains {100 * max(shares):.2g} % of the displacement of record '{name}', "
        "whatever its lag, memory or curve: the rest is noise, or something else moves the stage, "
        "which no model of the voltage alone can predict. If another axis, a force or heat was at "
        "work, hold it still or record it (force_N, temperature_degC)."
    ]
