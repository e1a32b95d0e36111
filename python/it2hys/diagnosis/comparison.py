"""Whether one model's free run is better than another's by more than chance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from it2hys.identification.uncertainty import correlation_time
from it2hys.policy import SEARCH

#: Largest number of blocks of a record: more take time and change nothing.
_MOST_BLOCKS = 250
#: Draws of signs: the least p-value is one over this. Draws of the bootstrap.
_SIGNS, _RESAMPLES = 10_000, 1000


@dataclass(frozen=True)
class Comparison:
    """Errors of two models on the same samples, and how sure their difference is.

    Parameters
    ----------
    before, after : float
        Root mean square errors.
    p_value : float
        One-sided: probability of such a gain by chance if the models were equally good.
    interval : tuple of float
        95 % bootstrap interval of `gain`.
    """

    before: float
    after: float
    p_value: float
    interval: tuple[float, float]

    @property
    def gain(self) -> float:
        """Share by which the root mean square error falls."""
        if self.before == 0.0:  # an inverse that is held at one voltage, which was applied
            return 0.0 if self.after == 0.0 else -np.inf
        return 1.0 - self.after / self.before

    @property
    def refines(self) -> bool:
        """Whether a model with the same effects predicts better, most likely not by chance."""
        return self.gain >= SEARCH.equal and self.p_value <= SEARCH.likely


def compare(before: Sequence[np.ndarray], after: Sequence[np.ndarray], seed: int = 0) -> Comparison:
    """Compare the errors of two models by blocks of samples.

    Errors of free runs are correlated in time: not samples but blocks, longer than the correlation,
    count as independent. If the models were equally good, the difference of their squared errors would
    have either sign in each of them: the p-value is the share of draws of signs that give as much. Of
    few blocks no signs are rare enough, and a t-test tells by how much their errors differ, in their
    logarithm. Both hold their level, where a bootstrap is too sure of few blocks. The interval is that
    of blocks that are drawn with replacement, record by record (block bootstrap).

    Parameters
    ----------
    before, after : sequence of ndarray
        Errors on each record, both of the same shapes.
    seed : int
        Of the bootstrap.

    Returns
    -------
    Comparison
    """
    squares = [np.column_stack([b**2, a**2]) for b, a in zip(before, after, strict=True)]
    blocks = [_block_means(s) for s in squares]
    generator = np.random.default_rng(seed)
    lengths = np.array([len(s) for s in squares])
    drawn = sum(n * _drawn_means(b, generator) for n, b in zip(lengths, blocks, strict=True))
    gains = 1.0 - np.sqrt(drawn[1] / np.maximum(drawn[0], np.finfo(float).tiny))
    total = np.sqrt(np.sum([s.sum(axis=0) for s in squares], axis=0) / lengths.sum())
    low, high = np.quantile(gains, [0.025, 0.975])
    differences = [n / len(b) * (b[:, 0] - b[:, 1]) for n, b in zip(lengths, blocks, strict=True)]
    if sum(map(len, blocks)) > SEARCH.few_blocks:
        p_value = _chance_of_signs(differences, generator)
    else:
        p_value = max(float(chance_of_sizes(np.concatenate(blocks))), 1.0 / _SIGNS)
    return Comparison(float(total[0]), float(total[1]), p_value, (float(low), float(high)))


def _chance_of_signs(differences: Sequence[np.ndarray], generator: np.random.Generator) -> float:
    """Return how often differences of random sign, of each record's blocks, sum up to as much."""
    total, turned = 0.0, np.zeros(_SIGNS - 1)
    for own in differences:
        total += own.sum()
        turned += generator.integers(2, size=(_SIGNS - 1, len(own)), dtype=np.int8).astype(float) @ own
    # one draw is the one that was found; rounding must not tell equal sums apart
    rounding = 1e-9 * sum(np.abs(own).sum() for own in differences)
    return float((1 + np.count_nonzero(2.0 * turned <= rounding)) / _SIGNS)


def chance_of_sizes(blocks: np.ndarray) -> np.ndarray:
    """Return the p-value of a t-test on the logarithms of ratios of mean squares.

    Parameters
    ----------
    blocks : ndarray, shape (..., B, 2)
        Mean squares of two models' errors in B blocks.

    Returns
    -------
    ndarray, shape (...)
        One-sided: small where the second model's are smaller.
    """
    before, after = np.moveaxis(np.log(np.maximum(blocks, np.finfo(float).tiny)), -1, 0)
    ratios, count = before - after, blocks.shape[-2]
    spread = np.maximum(np.std(ratios, axis=-1, ddof=1), np.finfo(float).eps)
    return student.sf(np.sqrt(count) * np.mean(ratios, axis=-1) / spread, count - 1)


def is_worse(comparison: Comparison, share: float) -> bool:
    """Return whether an error rises by more than a share, and by more than chance."""
    return comparison.gain < -share and comparison.interval[1] < 0.0


def _drawn_means(blocks: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Return means of blocks, (B, 2), drawn with replacement, shape (2, number of draws)."""
    draws = generator.integers(len(blocks), size=(_RESAMPLES, len(blocks)))
    # one model at a time: rows of two are gathered and added several times as slowly
    return np.stack([model[draws].mean(axis=1) for model in np.ascontiguousarray(blocks.T)])


def _block_means(squares: np.ndarray) -> np.ndarray:
    """Return means over blocks of the squared errors of one record, shape (B, 2)."""
    length = block_length(squares[:, 0] - squares[:, 1])
    whole = squares[: len(squares) // length * length]
    return whole.reshape(-1, length, 2).mean(axis=1)


def block_length(differences: np.ndarray) -> int:
    """Return how many samples a block has, by the differences of squared errors, shape (N,)."""
    count = len(differences)
    length = int(SEARCH.block * correlation_time(differences))
    return int(np.clip(length, -(-count // _MOST_BLOCKS), max(1, count // SEARCH.fewest_blocks)))
