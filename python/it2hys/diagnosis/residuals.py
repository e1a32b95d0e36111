"""Whether the residual of a model is more than noise, and what it looks like."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy import signal, stats

from it2hys.diagnosis.evidence.statistics import (
    FEWEST,
    UM,
    coherence_with_voltage,
    rms,
    spectral_variance,
)
from it2hys.errors import InputError
from it2hys.identification.noise import noise_floor
from it2hys.identification.uncertainty import correlation_time
from it2hys.policy import NOISE
from it2hys.records.clues import Clue, Clues
from it2hys.records.figures_of_merit import noise_size, times_the_noise
from it2hys.support.numerals import plain

_LJUNG_BOX_LAGS = 20
#: Lags of residual behind voltage, in samples, both ways.
_CROSS_LAGS = 100
_BLOCKS = 16
_FOURTH_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
#: Share of the values, in the middle, from which a deviation is estimated, and that of a Gaussian's.
_MIDDLE, _MIDDLE_DEVIATION = 0.8, 0.6616


@dataclass(frozen=True)
class RecordNumbers:
    """The residual of one record.

    Parameters
    ----------
    rms, noise : float
        m; the noise is corrected for its colour.
    correlation_time : float
        Integrated autocorrelation time, samples.
    p_white, p_white_squares : float
        Ljung-Box tests of the residual and of its squares, less noise of one pole.
    p_steady : float
        That its power varies so much from block to block by chance.
    busiest : tuple of float
        Begin and end of the block of greatest power, s from the start of the record.
    peak : float
        Frequency at which its spectrum is greatest, Hz.
    jumps : int
        Changes from one sample to the next that noise does not make.
    """

    rms: float
    noise: float
    correlation_time: float
    p_white: float
    p_white_squares: float
    p_steady: float
    busiest: tuple[float, float]
    peak: float
    jumps: int

    @property
    def size(self) -> float:
        """Residual over noise."""
        return self.rms / self.noise


@dataclass(frozen=True)
class LeftOver:
    """The residual of a model, and whether it is more than noise.

    Parameters
    ----------
    significant : bool
        Whether it is.
    size : float
        Residual over noise, rms of all records.
    p_value : float
        Of the least likely property, corrected for their number: white, white squares, steady,
        independent of the voltage and of its rate.
    records : tuple of RecordNumbers
    p_independent : dict of str to float
        By "voltage" and "rate": that the greatest of the cross-correlations is so great by chance,
        corrected for the number of lags.
    lags : dict of str to float
        Lag of that correlation, s; positive where the residual follows.
    coherence : tuple of (float, float, float)
        Lowest and highest frequency, Hz, of each band, and mean coherence with the voltage there.
    sentences : list of str
        The verdict and a description, for a reader.
    """

    significant: bool
    size: float
    p_value: float
    records: tuple[RecordNumbers, ...]
    p_independent: dict[str, float]
    lags: dict[str, float]
    coherence: tuple[tuple[float, float, float], ...]
    sentences: list[str] = field(default_factory=list)


def left_over(clues: Clues, noise: Sequence[float]) -> LeftOver:
    """Judge whether residuals are noise, and describe them if they are not.

    They are more than noise if they are larger than the noise, a little misfit allowed, and are not
    white, not steady or not independent of the voltage. The noise given is corrected where the residual
    shows that it is coloured: what is estimated from fourth differences is too small then.

    Parameters
    ----------
    clues : Clues
        With at least 64 used samples in every record.
    noise : sequence of float
        Rms of the noise of each record, m; 0 where it is not known.

    Returns
    -------
    LeftOver

    Raises
    ------
    InputError
        If a record has fewer samples.
    """
    for i, clue in enumerate(clues.records, start=1):
        if (count := np.count_nonzero(clue.used)) < FEWEST:
            raise InputError(
                f"record {i} has {count} samples to judge a residual by, {FEWEST} are needed"
            )
    numbers = tuple(
        _numbers(c, n, clues.extent.sample_time) for c, n in zip(clues.records, noise, strict=True)
    )
    inputs = {
        "voltage": lambda c: c.voltage,
        "rate": lambda c: np.diff(c.voltage, prepend=c.voltage[:1]),
    }
    cross = {name: _cross_correlation(clues, take) for name, take in inputs.items()}
    counts = np.array([np.count_nonzero(c.used) for c in clues.records])
    size = np.sqrt(
        np.sum(counts * [n.rms**2 for n in numbers]) / np.sum(counts * [n.noise**2 for n in numbers])
    )
    large = size > NOISE.little or max(n.size for n in numbers) > NOISE.little_alone
    by_record = [p for n in numbers for p in (n.p_white, n.p_white_squares, n.p_steady)]
    p_values = [len(by_record) * min(by_record), *(p for p, _ in cross.values())]
    p_value = float(min(1.0, 3.0 * min(p_values)))
    result = LeftOver(
        significant=bool(large and p_value < NOISE.level),
        size=float(size),
        p_value=p_value,
        records=numbers,
        p_independent={name: p for name, (p, _) in cross.items()},
        lags={name: ticks * clues.extent.sample_time for name, (_, ticks) in cross.items()},
        coherence=_coherence(clues),
    )
    result.sentences.append(_verdict(result, large))
    if result.significant:
        result.sentences.extend(_description(clues, result))
    return result


# --- numbers -------------------------------------------------------------------------------------


def _numbers(clue: Clue, noise: float, sample_time: float) -> RecordNumbers:
    # samples that are left out are no quiet part of the record: the others are joined
    inside = np.flatnonzero(clue.used)
    residual = clue.residual[inside] - np.mean(clue.residual[inside])
    pole = short_pole(residual)
    # a line or bursts may have passed for noise in what was given; in differences a line that is fast
    own, given = _short_noise(residual, pole), max(noise, 0.0) * _colour_correction(pole)
    floor = noise_floor(clue.displacement[clue.used])
    corrected = max(min(own, given) if own * given > 0.0 else max(own, given), floor)
    rest = residual[1:] - pole * residual[:-1]
    p_steady, busiest = _steadiness(residual)
    frequency, power = signal.periodogram(residual, 1.0 / sample_time, "hann")
    return RecordNumbers(
        rms=rms(clue.residual[clue.used]),
        noise=corrected,
        correlation_time=correlation_time(residual),
        p_white=ljung_box(rest),
        p_white_squares=ljung_box(rest**2),
        p_steady=p_steady,
        busiest=(inside[busiest[0]] * sample_time, (inside[busiest[1] - 1] + 1) * sample_time),
        peak=float(frequency[1:][np.argmax(power[1:])]),
        jumps=_jumps(residual, clue.voltage[inside], corrected),
    )


def _jumps(residual: np.ndarray, voltage: np.ndarray, noise: float) -> int:
    """Count the changes that noise does not make, where the voltage did not step a little before."""
    steps = np.abs(np.diff(voltage)) > NOISE.step * np.ptp(voltage)
    quiet = np.convolve(steps, np.ones(NOISE.after_step))[: len(steps)] < 0.5
    change = np.abs(np.diff(residual))
    jumped = quiet & (change > NOISE.jump * max(_deviation(np.diff(residual)), noise))
    return int(np.count_nonzero(np.diff(np.flatnonzero(jumped), prepend=-9) > 1))


def ljung_box(x: np.ndarray) -> float:
    """Return the p-value of the Ljung-Box test, that a series, (N,), is white."""
    lags = np.arange(1, _LJUNG_BOX_LAGS + 1)
    x, count = x - np.mean(x), len(x)
    power = float(x @ x)
    if power == 0.0:
        return 1.0
    correlations = np.array([x[k:] @ x[:-k] for k in lags]) / power
    statistic = count * (count + 2) * np.sum(correlations**2 / (count - lags))
    return float(stats.chi2.sf(statistic, _LJUNG_BOX_LAGS))


def short_pole(x: np.ndarray) -> float:
    """Return the pole, 0 to 0.6, of the noise in a series: of what is left by differences.

    The mean squares of differences over one and over two samples are 2 s^2 (1 - p) and
    2 s^2 (1 - p^2); slow parts of the series cancel in both.
    """
    one, two = _deviation(x[1:] - x[:-1]), _deviation(x[2:] - x[:-2])
    return float(np.clip(two**2 / one**2 - 1.0, 0.0, NOISE.short_memory)) if one > 0.0 else 0.0


def _deviation(x: np.ndarray) -> float:
    """Return the standard deviation from the middle of the values: few large ones do not count."""
    low, high = np.quantile(x, [0.5 - 0.5 * _MIDDLE, 0.5 + 0.5 * _MIDDLE])
    return float(np.std(x[(x >= low) & (x <= high)])) / _MIDDLE_DEVIATION


def _colour_correction(pole: float) -> float:
    """Return noise over its estimate from fourth differences, for noise of one pole."""
    places = np.arange(len(_FOURTH_DIFFERENCE))
    correlation = pole ** np.abs(places[:, None] - places)
    white = _FOURTH_DIFFERENCE @ _FOURTH_DIFFERENCE
    return float(np.sqrt(white / (_FOURTH_DIFFERENCE @ correlation @ _FOURTH_DIFFERENCE)))


def _short_noise(x: np.ndarray, pole: float) -> float:
    """Return the noise, of one pole, that is in the differences of a series."""
    return _deviation(np.diff(x)) / float(np.sqrt(2.0 * (1.0 - pole)))


def _steadiness(x: np.ndarray) -> tuple[float, tuple[int, int]]:
    """Return the p-value of steady power, and the block of greatest power (samples).

    Mean squares of blocks are compared as by Bartlett's test; a block is worth its samples over the
    correlation time of the squares.
    """
    ends = np.linspace(0, len(x), _BLOCKS + 1).astype(int)
    length = len(x) / _BLOCKS
    power = np.array([np.mean(x[a:b] ** 2) for a, b in pairwise(ends)])
    busiest = int(np.argmax(power))
    where = (int(ends[busiest]), int(ends[busiest + 1]))
    freedom = length / correlation_time(x)
    if np.mean(power) == 0.0 or freedom < 2.0:
        return 1.0, where
    spread = np.log(np.mean(power)) - np.mean(np.log(np.maximum(power, 1e-12 * power.max())))
    statistic = _BLOCKS * freedom * spread / (1.0 + (_BLOCKS + 1) / (3.0 * _BLOCKS * freedom))
    return float(stats.chi2.sf(statistic, _BLOCKS - 1)), where


def _cross_correlation(clues: Clues, take: Callable[[Clue], np.ndarray]) -> tuple[float, int]:
    """Return the p-value of independence, and the lag of the greatest correlation in samples.

    The variance of a sum of products is the sum over lags of the products of both autocovariances,
    computed from both spectra, that of the residual smoothed.
    """
    lags = np.arange(-_CROSS_LAGS, _CROSS_LAGS + 1)
    total, variance = np.zeros(len(lags)), 0.0
    for clue in clues.records:
        x = take(clue) - np.mean(take(clue))
        z = np.where(clue.used, clue.residual - np.mean(clue.residual[clue.used]), 0.0)
        unit = max(rms(x) * rms(z), np.sqrt(np.finfo(float).tiny))
        size = 2 * len(x)
        cross = np.fft.irfft(np.fft.rfft(z, size) * np.conj(np.fft.rfft(x, size)), size)
        total += cross[lags] / unit
        variance += spectral_variance(x, z) / unit**2
    if variance == 0.0:
        return 1.0, 0
    chosen = int(np.argmax(np.abs(total)))
    p_value = 2.0 * len(lags) * stats.norm.sf(np.abs(total[chosen]) / np.sqrt(variance))
    return float(min(1.0, p_value)), int(lags[chosen])


def _coherence(clues: Clues) -> tuple[tuple[float, float, float], ...]:
    """Return the mean coherence of residual and voltage by octave."""
    frequency, values = coherence_with_voltage(clues)
    mean, bands = values.mean(axis=0), []
    for low, high in pairwise(frequency[-1] / 2.0 ** np.arange(8, -1, -1)):
        inside = (frequency > low) & (frequency <= high)
        if np.any(inside):
            bands.append((float(low), float(high), float(np.mean(mean[inside]))))
    return tuple(bands)


# --- words ---------------------------------------------------------------------------------------


def _verdict(found: LeftOver, large: bool) -> str:
    greatest = max(found.records, key=lambda n: n.size)
    noise = rms(np.array([n.noise for n in found.records]))
    head = f"The residual is {times_the_noise(found.size)} ({noise_size(noise)})"
    chance = f"p = {found.p_value:.1g}" if found.p_value > 1e-12 else "p < 1e-12"
    if found.significant:
        return f"{head} and is not noise ({chance})."
    if large:
        return (
            f"{head} ({greatest.size:.2g} in the worst record), but white, steady and independent of "
            "the voltage: the noise is larger than estimated."
        )
    if found.p_value < NOISE.level:
        return f"{head}. A misfit or coloured noise is in it, too ({chance}), smaller than the noise."
    return f"{head}: indistinguishable from noise."


def _description(clues: Clues, found: LeftOver) -> list[str]:
    return [
        _spectrum_text(clues),
        _input_text(found),
        _place_text(clues),
        _time_text(found),
    ]


def _spectrum_text(clues: Clues) -> str:
    """Say where the power lies."""
    frequency, power = clues.spectrum(4000)
    frequency, power = frequency[1:], power[1:] / np.sum(power[1:])
    peak = int(np.argmax(power))
    near = np.abs(frequency - frequency[peak]) <= max(
        0.05 * frequency[peak], 2.0 / clues.extent.duration
    )
    share = float(np.sum(power[near]))
    low, high = (frequency[np.searchsorted(np.cumsum(power), q)] for q in (0.05, 0.95))
    if share > 0.5 and frequency[peak] > 4.0 / clues.extent.duration:
        where = f"{frequency[peak]:.4g} Hz"
        return f"{100 * share:.0f} % of its power is within a line or narrow band at {where}."
    if high < 0.02 * frequency[-1]:
        return f"95 % of its power lies below {plain(high)} Hz: it is slow."
    most = f"{plain(frequency[peak])} Hz"
    return f"90 % of its power lies between {plain(low)} and {plain(high)} Hz, the most at {most}."


def _input_text(found: LeftOver) -> str:
    """Say whether it follows the voltage."""
    name, p_value = min(found.p_independent.items(), key=lambda item: item[1])
    low, high, value = max(found.coherence, key=lambda band: band[2])
    what = {"voltage": "the voltage", "rate": "the voltage's rate of change"}[name]
    if p_value >= 1e-4:
        return (
            "It is not correlated with the voltage or its rate of change; the coherence with the "
            "voltage is at "
            f"most {value:.2f} ({plain(low)} to {plain(high)} Hz)."
        )
    # a residual does not come before its cause: such a lag is that of another period
    later = f", most strongly {found.lags[name] * 1e3:.3g} ms later" if found.lags[name] >= 0.0 else ""
    return (
        f"It is correlated with {what}{later}; the coherence with the voltage is at most {value:.2f} "
        f"({plain(low)} to {plain(high)} Hz)."
    )


def _place_text(clues: Clues) -> str:
    """Say where on the loop it is."""
    power = np.concatenate(
        [
            np.where(c.used, (c.residual - np.mean(c.residual[c.used])) ** 2, np.nan)
            for c in clues.records
        ]
    )
    places = [_places(clues, c) for c in clues.records]
    found = {}
    for name in places[0]:
        mask = np.concatenate([p[name] for p in places]) & np.isfinite(power)
        # what is nearly nowhere or nearly everywhere is no place
        if 0.02 * len(power) < np.count_nonzero(mask) < 0.8 * len(power):
            found[name] = float(np.sqrt(np.mean(power[mask]) / np.nanmean(power)))
    strong = sorted((n for n in found if found[n] > NOISE.stronger), key=lambda n: -found[n])
    if not strong:
        return "It is spread evenly over the loop: over voltages, branches, holds and turning points."
    return "It is stronger " + ", ".join(f"{n} ({found[n]:.2g} times its rms)" for n in strong) + "."


def _places(clues: Clues, clue: Clue) -> dict[str, np.ndarray]:
    """Return masks (N,) of the places on the loop."""
    low, span = clues.extent.voltage[0], max(clues.extent.voltage_span, np.finfo(float).tiny)
    level, rate = (clue.voltage - low) / span, np.gradient(clue.voltage)
    moving = np.flatnonzero(np.abs(rate) > 1e-6 * span)
    turns = np.zeros(len(rate))
    turns[moving[1:][np.diff(np.sign(rate[moving])) != 0]] = 1.0
    close = max(3, int(NOISE.close * len(rate)))
    held = np.abs(rate) <= 1e-6 * span
    return {
        "at low voltage": level < 1 / 3,
        "at middle voltage": (level >= 1 / 3) & (level < 2 / 3),
        "at high voltage": level >= 2 / 3,
        "on rising branches": ~held & (rate > 0.0),
        "on falling branches": ~held & (rate < 0.0),
        "while the voltage is held": held,
        "after turning points": np.convolve(turns, np.ones(close))[: len(rate)] > 0.5,
    }


def _time_text(found: LeftOver) -> str:
    """Say in which records and when it is, and whether it jumps."""
    numbers = found.records
    sizes = [n.rms * UM for n in numbers]
    worst, least = int(np.argmax(sizes)), int(np.argmin(sizes))
    parts = [f"It is {sizes[0]:.2g} µm rms"]
    if len(sizes) > 1:
        parts = [
            f"It is largest in record {worst + 1} ({sizes[worst]:.2g} µm rms) and smallest in record "
            f"{least + 1} ({sizes[least]:.2g} µm rms)"
        ]
    unsteady = [n for n in numbers if n.p_steady < NOISE.level]
    if unsteady:
        begin, end = numbers[worst].busiest
        parts.append(
            f"its power varies within {len(unsteady)} of {len(numbers)} records; in record "
            f"{worst + 1} it is greatest from {begin:.3g} to {end:.3g} s"
        )
    else:
        parts.append("its power is steady within the records")
    jumps = sum(n.jumps for n in numbers)
    if jumps:
        parts.append(f"it jumps {jumps} times between steps of the voltage")
    return "; ".join(parts) + "."
