"""The noise floor of a record: what no model can predict."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import signal

from it2hys.policy import NOISE

_FEWEST_PERIODS = 3
_DIFFERENCE_ORDER = 4
#: Standard deviation of the fourth difference of white noise of unit deviation: sqrt(C(8, 4)).
_DIFFERENCE_GAIN = np.sqrt(70.0)
_MAD_TO_DEVIATION = 1.4826
#: Segment of the spectrum, in samples, and the bands of its upper half.
_SEGMENT, _BANDS = 1024, 16
#: Fewest steps between values that tell how finely the numbers are written.
_FEWEST_STEPS = 10


@dataclass(frozen=True)
class NoiseEstimate:
    """The noise of a record.

    Parameters
    ----------
    rms : float
        Its root mean square, in the unit of the displacement.
    method : str
        How it was estimated, as half a sentence.
    certain : bool
        Whether it is known. It is not where the response reaches up to the highest frequencies, so that
        nothing of the record is noise alone.
    """

    rms: float
    method: str
    certain: bool = True


def estimate_noise(x: np.ndarray, y: np.ndarray, used: np.ndarray | None = None) -> NoiseEstimate:
    """Estimate the noise of a displacement record.

    Parameters
    ----------
    x, y : ndarray, shape (N,)
        Voltage and displacement, without the leading transient.
    used : ndarray of bool, shape (N,), optional
        Samples whose displacement can be trusted; all if not given.

    Returns
    -------
    NoiseEstimate
        From the differences of repeated periods where the drive is periodic. Otherwise the least of two
        that see only what is fast: from fourth differences, in which a smooth motion cancels, and from
        the quietest band of the upper half of the spectrum. Where the second is far below the first,
        the stage moves at those frequencies: the noise is at most that, and not known. Never below what
        the step of the numbers makes, or a ten-millionth of the travel.
    """
    floor = noise_floor(y if used is None else y[used])
    estimate = _estimate(x, y if used is None else np.where(used, y, np.nan))
    if estimate.rms > floor:
        return estimate
    return NoiseEstimate(floor, "the resolution of the numbers (no noise is visible)", estimate.certain)


def noise_floor(y: np.ndarray) -> float:
    """Return the least noise that a record can be said to have.

    It is the deviation that the step of its numbers makes, and no less than what the best of sensors
    resolve.
    """
    return max(number_step(y) / np.sqrt(12.0), NOISE.finest * float(np.ptp(y)), np.finfo(float).tiny)


def number_step(y: np.ndarray) -> float:
    """Return the step of which all values are multiples, from the first; 0 where there is none.

    By Euclid's algorithm on the distances of neighbouring values. Fewer than ten of them may be far
    apart for another reason.
    """
    distances = np.diff(np.unique(y))
    if len(distances) < _FEWEST_STEPS:
        return 0.0
    rounding = 8.0 * np.finfo(float).eps * float(np.max(np.abs(y)))
    step = float(distances.min())
    while step > 1e3 * rounding:
        # of many steps the rounding of one would add up
        near = distances[distances < 1e4 * step]
        left = np.abs(near - step * np.rint(near / step))
        left = left[left > np.maximum(0.01 * step, rounding)]
        if len(left) == 0:
            return step
        step = float(left.min())
    return 0.0


def _estimate(x: np.ndarray, y: np.ndarray) -> NoiseEstimate:
    """Return the estimate from differences; samples that are not to be used are NaN."""
    period = find_period(x)
    if period is not None:
        rms = _between_periods(y, period)
        if np.isfinite(rms):
            return NoiseEstimate(rms, f"differences of periods of {period} samples")
    difference = np.diff(y, _DIFFERENCE_ORDER)
    deviation = _MAD_TO_DEVIATION * np.nanmedian(np.abs(difference - np.nanmedian(difference)))
    fast = float(deviation / _DIFFERENCE_GAIN)
    quiet = _quietest_band(_straight(y))
    if fast <= NOISE.motion * quiet:
        return NoiseEstimate(fast, "fourth differences (fast noise only)")
    return NoiseEstimate(
        quiet,
        "the quietest band of the spectrum, an upper bound: the stage moves at all other frequencies",
        certain=False,
    )


def _straight(y: np.ndarray) -> np.ndarray:
    """Return the series, straight across what is not known."""
    places = np.flatnonzero(np.isfinite(y))
    return np.interp(np.arange(len(y)), places, y[places])


def _quietest_band(y: np.ndarray) -> float:
    """Return the noise, were it everywhere as strong as in the quietest band of the upper half."""
    length = min(_SEGMENT, len(y))
    _, density = signal.welch(y, nperseg=length)
    upper = density[len(density) // 2 : -1]
    bands = np.array_split(upper, min(_BANDS, len(upper)))
    return float(np.sqrt(0.5 * min(np.mean(band) for band in bands)))


def find_period(x: np.ndarray) -> int | None:
    """Return the period of the voltage in samples, or None unless it repeats three times."""
    x = x - np.mean(x)
    count = len(x)
    longest = count // _FEWEST_PERIODS
    power = np.mean(x**2)
    if longest < 4 or power == 0.0:
        return None
    spectrum = np.fft.rfft(x, 2 * count)
    correlation = np.fft.irfft(np.abs(spectrum) ** 2)[: longest + 1]
    squares = np.concatenate([[0.0], np.cumsum(x**2)])
    lags = np.arange(longest + 1)
    # mean of (x[k + lag] - x[k])^2 over the overlap
    distance = squares[count - lags] + squares[count] - squares[lags] - 2 * correlation
    distance /= count - lags
    left = np.flatnonzero(distance > 0.5 * power)
    if len(left) == 0:
        return None
    candidates = lags[left[0] :][distance[left[0] :] < 1e-5 * power]
    if len(candidates) == 0:
        return None
    near = candidates[candidates <= candidates[0] + 2]
    return int(near[np.argmin(distance[near])])


def _between_periods(y: np.ndarray, period: int) -> float:
    """Return the noise from successive periods; a shift between them (drift) is not noise.

    The first of them is left out: in it, a stage that begins at rest comes into its loop.

    NaN where no two of them have enough samples in common.
    """
    periods = y[: len(y) // period * period].reshape(-1, period)
    periods = periods[1:] if len(periods) >= _FEWEST_PERIODS else periods
    difference = np.diff(periods, axis=0)
    known = np.isfinite(difference)
    # pairs of periods that have less than half of their samples in common say little
    difference = difference[known.mean(axis=1) > 0.5]
    if len(difference) == 0:
        return np.nan
    difference -= np.nanmean(difference, axis=1, keepdims=True)
    return float(np.sqrt(np.median(np.nanmean(difference**2, axis=1)) / 2.0))
