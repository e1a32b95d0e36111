"""Whether a record was taken in closed loop: whether its voltage answers the displacement.

Under a controller the sensor's noise, and whatever disturbs the stage, enters the voltage. In open loop
it does not: nothing in the displacement helps to predict a voltage that was chosen beforehand. So the
voltage is predicted from its own past, and what that leaves, its surprise, from the surprises of the
displacement (what neither its past nor the voltage's tells). That is Granger's test, with four things
added:

- a controller answers a displacement that is too large with less voltage, so that the first of the
  answers has to be negative. A displacement that tells of a badly measured voltage what its noise
  hides, or that was read after the voltage of the same sample had acted, has the other sign;
- the share of the surprise that is explained has to be large: with enough samples any imperfection of a
  linear prediction is significant;
- the answer has to be there all along: a drive of several kinds is told badly by its own past where it
  has corners, and anything may help there;
- samples at which either signal jumps do not count: a step or a corner of the drive is no answer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from it2hys.policy import RESPONSE
from it2hys.records.record import Record

#: Past samples of the voltage, and of the displacement, that the next voltage is predicted from.
_PAST, _ANSWERS = 32, 10
#: Samples that are looked at, and the fewest that say anything.
_MOST, _FEWEST = 20_000, 300
#: A voltage that its own past tells to this share of its deviation is known beforehand: what is left is
#: the rounding of the numbers in a file.
_ROUNDING = 1e-6
#: Parts of a record that have to show the same answer.
_PARTS = 10
#: Share of a power that is rounding, and rounds of leaving out steps and corners.
_NOTHING_LEFT, _ROUNDS = 1e-12, 2


@dataclass(frozen=True)
class Feedback:
    """How the voltage answers the displacement.

    Parameters
    ----------
    share : float
        Of the voltage's surprise, the share that the displacement's earlier surprises explain.
    samples : int
        How many samples later the first answer comes.
    errors : float
        By how many standard errors it is below zero.
    """

    share: float
    samples: int
    errors: float


def find_feedback(record: Record) -> Feedback | None:
    """Return how the voltage of a record answers its displacement; None where it does not.

    Returns
    -------
    Feedback or None
        None also where the voltage, its jumps apart, follows from its own past, or the record is too
        short to tell.
    """
    count = min(len(record), _MOST)
    if count < _FEWEST + _PAST or np.ptp(record.voltage[:count]) == 0.0:
        return None
    trusted = ~record.outliers[:count]
    if np.ptp(record.displacement[:count][trusted]) == 0.0:
        return None
    voltage, displacement = (
        (x - x.mean()) / x.std() for x in (record.voltage[:count], record.displacement[:count])
    )
    # a sensor may be read before the voltage of the same sample is set, or after it has acted
    found = [_first_answer(voltage, displacement, trusted, first) for first in (1, 0)]
    return next((answer for answer in found if answer is not None), None)


def _first_answer(
    voltage: np.ndarray, displacement: np.ndarray, trusted: np.ndarray, first: int
) -> Feedback | None:
    """Return the first answer to surprises of `first` samples ago or more, if it is a controller's."""
    lags = range(_ANSWERS, first - 1, -1)  # the latest comes last
    rows = np.flatnonzero(_past(trusted, lags).all(axis=1))
    own, past = _past(voltage, range(1, _PAST + 1)), _past(displacement, lags)
    columns = np.hstack([np.ones((len(own), 1)), own, past])
    seen = _Seen.of(voltage[_PAST:], columns, rows)
    for _ in range(_ROUNDS):
        if seen.scale <= _ROUNDING or seen.latest_scale <= RESPONSE.no_surprise:
            return None
        rows = rows[seen.quiet]
        if len(rows) < _FEWEST:
            return None
        seen = _Seen.of(voltage[_PAST:], columns, rows)
    return _judged(seen, first)


@dataclass(frozen=True, eq=False)
class _Seen:
    """The surprises of both signals on some rows.

    Parameters
    ----------
    surprise : ndarray, shape (n,)
        What the voltage's own past does not tell of it.
    latest : ndarray, shape (n,)
        What neither its own past nor the voltage's tells of the latest displacement.
    earlier : ndarray, shape (n, K)
        The displacement's surprises, each of size 1, the oldest first.
    answers : ndarray, shape (K,)
        What the voltage's surprise has of them.
    moving : ndarray of int
        The rows at which the voltage changed: one that is held, or limited, answers nothing.
    """

    surprise: np.ndarray
    latest: np.ndarray
    earlier: np.ndarray
    answers: np.ndarray
    moving: np.ndarray

    @classmethod
    def of(cls, now: np.ndarray, columns: np.ndarray, rows: np.ndarray) -> _Seen:
        # columns of which the earlier ones tell all add a direction of rounding: it does no harm
        basis, triangle = np.linalg.qr(columns[rows])
        size, parts = np.diag(triangle), basis.T @ now[rows]
        own = 1 + _PAST
        return cls(
            now[rows] - basis[:, :own] @ parts[:own],
            size[-1] * basis[:, -1],
            np.sign(size[own:]) * basis[:, own:],
            np.sign(size[own:]) * parts[own:],
            np.flatnonzero(now[rows] != columns[rows, 1]),
        )

    @property
    def scale(self) -> float:
        """Deviation of the voltage's surprise, its jumps apart."""
        return _scale(self.surprise)

    @property
    def latest_scale(self) -> float:
        """Deviation of the displacement's surprise, its jumps apart."""
        return _scale(self.latest)

    def is_steady(self, index: int) -> bool:
        """Return whether an answer is there in all parts of the record, or all but one."""
        answer, lacking = self.answers[index], 0
        for part in np.array_split(self.moving, _PARTS):
            surprise, earlier = self.surprise[part], self.earlier[part, index]
            size, found = earlier @ earlier, np.sign(answer) * (surprise @ earlier)
            error = np.sqrt(surprise @ surprise * size / max(len(part), 1))
            lacking += found < 0.5 * abs(answer) * size - RESPONSE.lacking * error
        return lacking <= 1

    @property
    def quiet(self) -> np.ndarray:
        """Mask of the rows at which neither jumps, shape (n,)."""
        quiet = np.abs(self.surprise) <= RESPONSE.jump * self.scale
        return quiet & (np.abs(self.latest) <= RESPONSE.jump * self.latest_scale)


def _judged(seen: _Seen, first: int) -> Feedback | None:
    """Return the first sure answer if it is negative and large."""
    power = float(seen.surprise @ seen.surprise)
    left = max(power - float(seen.answers @ seen.answers), _NOTHING_LEFT * power)
    error = np.sqrt(left / (len(seen.surprise) - 1 - _PAST - len(seen.answers)))
    for samples, answer in enumerate(seen.answers[::-1], start=first):
        if abs(answer) > RESPONSE.sure * error:
            large = answer < 0.0 and answer**2 > RESPONSE.answered * power
            large = large and seen.is_steady(len(seen.answers) - 1 + first - samples)
            return Feedback(1.0 - left / power, samples, float(-answer / error)) if large else None
        if samples == 0:
            return None  # what comes later is asked for without this sample's
    return None


def _past(values: np.ndarray, lags: range) -> np.ndarray:
    """Return earlier values, a column for each lag, from the first sample on that has them all."""
    return np.column_stack([values[_PAST - past : len(values) - past] for past in lags])


def _scale(values: np.ndarray) -> float:
    """Return the deviation of values from the median of their sizes: few large ones do not count."""
    return 1.4826 * float(np.median(np.abs(values)))
