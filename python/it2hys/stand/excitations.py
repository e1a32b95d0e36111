"""Excitation and reference signals: the paper's, and the blocks that scenarios are made of.

Every signal is a function of a time array in s and returns an array of the same shape, a voltage
in V unless it says otherwise. The paper's signals, by equation number:

====  ==========================================  =============================
eq.   signal                                      function
====  ==========================================  =============================
(22)  identification, 50 Hz + 25 Hz               `identification`
(26)  validation, sine of 20 Hz and of 40 Hz      `validation_sine`
(27)  validation, triangle of 25 Hz               `triangle` with its defaults
--    validation, 100 Hz + 50 Hz                  `sum_100_50`
--    feedforward reference, 20 Hz                `tracking_reference` (in m)
====  ==========================================  =============================

All of them start at the lower end of their range, as a stage does that is switched on at rest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy  # its parts are loaded when used: most workers of a sweep need none
from numpy.typing import ArrayLike

from it2hys.errors import InputError

#: Upper end of the paper's voltage range, V.
PAPER_VOLTAGE = 105.0

#: Guard against 0.03 / 0.01 = 2.9999999999999996 where time is divided into intervals.
_ROUNDING = 1e-9


def time_grid(duration: float, sample_time: float) -> np.ndarray:
    """Return the ticks k * sample_time in [0, duration), counted as integers.

    Parameters
    ----------
    duration : float
        Length of the signal, s.
    sample_time : float
        Sample time Ts, s.

    Returns
    -------
    numpy.ndarray, shape (n,)
        Time in s; a duration that is a multiple n of the sample time gives n ticks.

    Raises
    ------
    InputError
        Where an argument is not positive and finite.
    """
    return np.arange(int(tick_count(duration, sample_time))) * sample_time


def tick_count(duration: ArrayLike, sample_time: ArrayLike) -> np.ndarray | np.int64:
    """Return the number of ticks k * sample_time in [0, duration).

    Parameters
    ----------
    duration : array_like
        Length of the signal, s.
    sample_time : array_like
        Sample time Ts, s.

    Returns
    -------
    numpy.int64, or numpy.ndarray of the arguments' shape

    Raises
    ------
    InputError
        Where an argument is not positive and finite.
    """
    _require_positive(duration=duration, sample_time=sample_time)
    return np.ceil(np.divide(duration, sample_time) - _ROUNDING).astype(np.int64)


# --- the paper's signals -------------------------------------------------------------------------


def identification(time: ArrayLike) -> np.ndarray:
    """Return the identification voltage, 50 Hz + 25 Hz, eq. (22); it spans 0 to 104.08 V.

    Parameters
    ----------
    time : array_like, shape (n,)
        Time, s.

    Returns
    -------
    numpy.ndarray, shape (n,)
        Voltage, V.
    """
    return _two_tones(time, frequency=25.0)


def validation_sine(time: ArrayLike, frequency: float) -> np.ndarray:
    """Return the validation sine over 0 to 105 V, eq. (26).

    Parameters
    ----------
    time : array_like, shape (n,)
        Time, s.
    frequency : float
        Frequency, Hz; the paper uses 20 and 40.

    Returns
    -------
    numpy.ndarray, shape (n,)
        Voltage, V.

    Raises
    ------
    InputError
        Where the frequency is not positive and finite.
    """
    return sine(time, frequency, low=0.0, high=PAPER_VOLTAGE)


def sum_100_50(time: ArrayLike) -> np.ndarray:
    """Return the validation voltage of 100 Hz + 50 Hz over 0 to 105 V.

    The paper does not print its amplitudes. Here it has the shape of (22) at twice the
    frequencies, scaled to reach 105 V.

    Parameters
    ----------
    time : array_like, shape (n,)
        Time, s.

    Returns
    -------
    numpy.ndarray, shape (n,)
        Voltage, V.
    """
    # With c = cos(2 pi 25 t), (22) is 102.5 - 22.5 c - 80 c^2: the peak is at c = -22.5 / 160.
    peak_of_22 = 102.5 + 22.5**2 / (4.0 * 80.0)
    return PAPER_VOLTAGE / peak_of_22 * _two_tones(time, frequency=50.0)


def tracking_reference(time: ArrayLike) -> np.ndarray:
    """Return the feedforward reference y_d = 7.0 sin(2 pi 20 t - pi/2) + 7.7 µm, in m.

    Parameters
    ----------
    time : array_like, shape (n,)
        Time, s.

    Returns
    -------
    numpy.ndarray, shape (n,)
        Desired displacement, m.
    """
    return sine(time, 20.0, low=0.7, high=14.7) * 1e-6


def _two_tones(time: ArrayLike, frequency: float) -> np.ndarray:
    phase = 2.0 * np.pi * frequency * np.asarray(time, dtype=float)
    return 40.0 * np.sin(2.0 * phase - np.pi / 2.0) + 22.5 * np.sin(phase - np.pi / 2.0) + 62.5


# --- general blocks ------------------------------------------------------------------------------


def sine(
    time: ArrayLike, frequency: float, low: float = 0.0, high: float = PAPER_VOLTAGE
) -> np.ndarray:
    """Return a sine that starts at its minimum; the general form of eq. (26).

    Parameters
    ----------
    time : array_like, shape (n,)
        Time, s.
    frequency : float
        Frequency, Hz.
    low, high : float
        Range, V.

    Returns
    -------
    numpy.ndarray, shape (n,)
        Voltage, V.

    Raises
    ------
    InputError
        Where the frequency is not positive and finite, or `low` is not below `high`.
    """
    _require_positive(frequency=frequency)
    angle = 2.0 * np.pi * frequency * np.asarray(time, dtype=float)
    return _scaled(np.sin(angle - np.pi / 2.0), low, high)


def triangle(
    time: ArrayLike, frequency: float = 25.0, low: float = 0.0, high: float = PAPER_VOLTAGE
) -> np.ndarray:
    """Return a symmetric triangle that starts at its minimum; the defaults are eq. (27).

    Parameters
    ----------
    time : array_like, shape (n,)
        Time, s.
    frequency : float
        Frequency, Hz.
    low, high : float
        Range, V.

    Returns
    -------
    numpy.ndarray, shape (n,)
        Voltage, V.

    Raises
    ------
    InputError
        Where the frequency is not positive and finite, or `low` is not below `high`.
    """
    _require_positive(frequency=frequency)
    angle = 2.0 * np.pi * frequency * np.asarray(time, dtype=float)
    return _scaled(scipy.signal.sawtooth(angle, width=0.5), low, high)


def steps(time: ArrayLike, levels: Sequence[float], hold: float) -> np.ndarray:
    """Return a staircase; the last level is held to the end (creep shows in the holds).

    Parameters
    ----------
    time : array_like, shape (n,)
        Time, s, from 0 on.
    levels : sequence of float
        Levels, V, in the order of time.
    hold : float
        Time at each level, s.

    Returns
    -------
    numpy.ndarray, shape (n,)
        Voltage, V.

    Raises
    ------
    InputError
        Where `hold` is not positive and finite, or there is no level.
    """
    _require_positive(hold=hold)
    if len(levels) == 0:
        raise InputError("steps need at least one level")
    index = np.floor(np.asarray(time, dtype=float) / hold + _ROUNDING).astype(int)
    return np.asarray(levels, dtype=float)[np.clip(index, 0, len(levels) - 1)]


def chirp(
    time: ArrayLike,
    start_frequency: float,
    stop_frequency: float,
    duration: float,
    low: float = 0.0,
    high: float = PAPER_VOLTAGE,
    method: str = "linear",
) -> np.ndarray:
    """Return a swept sine that starts at its minimum.

    Parameters
    ----------
    time : array_like, shape (n,)
        Time, s.
    start_frequency, stop_frequency : float
        Frequency at time 0 and at `duration`, Hz.
    duration : float
        Length of the sweep, s.
    low, high : float
        Range, V.
    method : {"linear", "quadratic", "logarithmic", "hyperbolic"}
        How the frequency goes from start to stop, as in `scipy.signal.chirp`.

    Returns
    -------
    numpy.ndarray, shape (n,)
        Voltage, V.

    Raises
    ------
    InputError
        Where a frequency or the duration is not positive and finite, `low` is not below `high`,
        or the method is unknown.
    """
    _require_positive(start_frequency=start_frequency, stop_frequency=stop_frequency, duration=duration)
    known = ("linear", "quadratic", "logarithmic", "hyperbolic")
    if method not in known:
        raise InputError(f"unknown chirp method '{method}'; known are {', '.join(known)}")
    sweep = scipy.signal.chirp(
        np.asarray(time, dtype=float),
        f0=start_frequency,
        t1=duration,
        f1=stop_frequency,
        method=method,
        phi=180.0,
    )
    return _scaled(sweep, low, high)


def multisine(
    time: ArrayLike,
    frequencies: Sequence[float],
    low: float = 0.0,
    high: float = PAPER_VOLTAGE,
    seed: int = 0,
) -> np.ndarray:
    """Return a sum of equal sines with random phases, scaled to span the range.

    The scale is taken from the samples asked for, so that the range is used fully whatever the
    phases: other times give another scale.

    Parameters
    ----------
    time : array_like, shape (n,)
        Time, s.
    frequencies : sequence of float
        Frequencies, Hz.
    low, high : float
        Range, V.
    seed : int
        Seed of the phases.

    Returns
    -------
    numpy.ndarray, shape (n,)
        Voltage, V.

    Raises
    ------
    InputError
        Where there is no frequency, one is not positive and finite, `low` is not below `high`, or
        the samples do not vary.
    """
    if len(frequencies) == 0:
        raise InputError("a multisine needs at least one frequency")
    for frequency in frequencies:
        _require_positive(frequency=frequency)
    time = np.asarray(time, dtype=float)
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(frequencies))
    total = np.zeros_like(time)
    for frequency, phase in zip(frequencies, phases, strict=True):
        total += np.sin(2.0 * np.pi * frequency * time + phase)
    if total.size == 0 or np.ptp(total) == 0.0:
        raise InputError("a multisine needs at least two samples that differ")
    return _scaled(2.0 * (total - total.min()) / np.ptp(total) - 1.0, low, high)


def decaying(
    time: ArrayLike,
    frequency: float,
    time_constant: float,
    low: float = 0.0,
    high: float = PAPER_VOLTAGE,
) -> np.ndarray:
    """Return a sine dying away to the middle of the range: nested minor loops.

    Parameters
    ----------
    time : array_like, shape (n,)
        Time, s, from 0 on.
    frequency : float
        Frequency, Hz.
    time_constant : float
        Time in which the amplitude falls to 1/e, s.
    low, high : float
        Range at the start, V.

    Returns
    -------
    numpy.ndarray, shape (n,)
        Voltage, V.

    Raises
    ------
    InputError
        Where the frequency or the time constant is not positive and finite, or `low` is not below
        `high`.
    """
    _require_positive(time_constant=time_constant)
    middle = 0.5 * (low + high)
    envelope = np.exp(-np.asarray(time, dtype=float) / time_constant)
    return middle + envelope * (sine(time, frequency, low, high) - middle)


def _scaled(unit_signal: np.ndarray, low: float, high: float) -> np.ndarray:
    """Map a signal over -1 .. 1 onto low .. high."""
    if not (np.isfinite(low) and np.isfinite(high) and low < high):
        raise InputError(f"the range must have low < high, got low = {low}, high = {high}")
    return 0.5 * (high + low) + 0.5 * (high - low) * unit_signal


def _require_positive(**values: ArrayLike) -> None:
    for name, value in values.items():
        if not np.all(np.isfinite(value) & np.greater(value, 0.0)):
            raise InputError(f"{name} must be positive and finite, got {value!s}")


#: Signals by the names that scenarios use.
SIGNALS = {
    function.__name__: function
    for function in (
        identification,
        validation_sine,
        sum_100_50,
        tracking_reference,
        sine,
        triangle,
        steps,
        chirp,
        multisine,
        decaying,
    )
}
