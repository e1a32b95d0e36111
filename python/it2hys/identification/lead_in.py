"""The lead-in: the first part of a record, on which its start is fitted and which no error counts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from it2hys.identification.uncertainty import correlation_time
from it2hys.policy import STARTS

#: Lengths that are tried, as shares of a record, and the shortest in samples.
_SHARES, _SHORTEST = (0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4), 20


@dataclass(frozen=True)
class Misfit:
    """What a model misses of the records that it was fitted to.

    Parameters
    ----------
    power : float
        Mean square beyond the noise, in the unit of the displacement squared.
    correlated : float
        Samples over which it hangs together, see `correlation_time`.
    """

    power: float = 0.0
    correlated: float = 1.0

    @classmethod
    def of(cls, residuals: list[np.ndarray], noises: list[float]) -> Misfit:
        """Return what residuals hold beyond noise of these sizes."""
        power = np.mean([np.mean(r**2) for r in residuals]) - np.mean(np.square(noises))
        times = [correlation_time(r) for r in residuals]
        return cls(max(float(power), 0.0), float(np.mean(times)))


def lead_in_length(
    rows: np.ndarray,
    used: np.ndarray,
    noise: float,
    misfit: Misfit,
    agrees: Callable[[int], bool] = lambda lead: True,
) -> int:
    """Return how many samples of a record its start needs.

    The error of a start that was fitted on them, propagated to the samples behind by the sensitivities,
    is no more than a small part of the noise. What the model misses counts as noise too, and as much as
    its correlation in time makes of it.

    Parameters
    ----------
    rows : ndarray, shape (M, P)
        Displacement by the coordinates of the start, on the samples that are used.
    used : ndarray of bool, shape (N,)
        M of them are true.
    noise : float
        In the unit of the displacement.
    misfit : Misfit
    agrees : callable, optional
        Told a length, whether it will do for other reasons too.
    """
    samples = np.flatnonzero(used)
    missed = misfit.power / noise**2
    rows = rows / noise
    for lead in _lengths(len(used), int(samples[0])):
        first = samples < lead
        information = rows[first].T @ rows[first] / (1.0 + missed * misfit.correlated)
        information += STARTS.prior**2 * np.eye(rows.shape[1])
        behind = rows[~first]
        variance = np.mean(np.sum((behind @ np.linalg.pinv(information)) * behind, axis=1))
        if variance <= STARTS.left**2 * (1.0 + missed) and agrees(lead):
            break
    return lead


def _lengths(count: int, begin: int) -> Iterator[int]:
    for share in _SHARES:
        yield begin + max(int(share * (count - begin)), _SHORTEST)
