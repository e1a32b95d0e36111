"""Limits of a rig, as they are given and as they follow from the model and the records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from it2hys.errors import InputError
from it2hys.policy import DESIGN, STARTS
from it2hys.support.numerals import plain

#: Rise time of a first-order amplifier from 10 to 90 %, times its bandwidth.
_RISE = 0.35
#: Samples of a record at most: a search computes it hundreds of times.
MOST_SAMPLES = 100_000
#: Share by which rounding of a difference may exceed the slew rate.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Wanted:
    """Limits as a user gives them; None where the model and the records imply them.

    Parameters
    ----------
    voltage : tuple of float
        Lowest and highest voltage, V.
    rate : float
        Fastest change, V/s.
    bandwidth : float
        Of the amplifier, Hz.
    current, capacitance : float
        Largest current of the amplifier, A, and capacitance of the actuator, F.
    sample_time, duration : float
        In s.
    periods : int
        Equal periods of the record, for averaging.
    band : tuple of float
        Of the reference that the model will be used for, Hz.
    """

    voltage: tuple[float, float] | None = None
    rate: float | None = None
    bandwidth: float | None = None
    current: float | None = None
    capacitance: float | None = None
    sample_time: float | None = None
    duration: float | None = None
    periods: int = 1
    band: tuple[float, float] | None = None


@dataclass(frozen=True)
class Limits:
    """Limits that a record keeps to rounding.

    Parameters
    ----------
    low, high : float
        Voltages, V.
    rate : float
        Fastest change, V/s.
    sample_time : float
        In s.
    samples : int
        Of a period.
    periods : int
    lowest, highest : float
        Frequencies of sines and of loops, Hz.
    said : tuple of str
        Sentences on the source of each limit.
    """

    low: float
    high: float
    rate: float
    sample_time: float
    samples: int
    periods: int
    lowest: float
    highest: float
    said: tuple[str, ...] = ()

    @property
    def rest(self) -> float:
        """Voltage at which a record begins and ends: 0, or as near to it as the range goes."""
        return float(np.clip(0.0, self.low, self.high))

    @property
    def span(self) -> float:
        """Highest minus lowest voltage, V."""
        return self.high - self.low

    @property
    def duration(self) -> float:
        """Of the whole record, s."""
        return self.periods * self.samples * self.sample_time

    @property
    def step(self) -> float:
        """Largest change from one sample to the next, V."""
        return self.rate * self.sample_time

    def kept(self, target: np.ndarray) -> np.ndarray:
        """Return the voltage nearest to a target, (N,), that keeps the limits, from rest to rest.

        It is cut to what can be reached from rest and be left for it in time, and then follows no
        faster than the slew rate.
        """
        count = len(target)
        reach = self.step * np.minimum(np.arange(count), np.arange(count)[::-1])
        low, high = np.maximum(self.low, self.rest - reach), np.minimum(self.high, self.rest + reach)
        cut = np.clip(target, low, high)
        if np.all(np.abs(np.diff(cut)) <= self.step):
            return cut
        followed, last, step = np.empty(count), self.rest, self.step
        for k, value in enumerate(cut.tolist()):
            last = min(max(value, last - step), last + step)
            followed[k] = last
        return np.clip(followed, low, high)

    def holds(self, voltage: np.ndarray) -> bool:
        """Return whether a voltage, (N,), keeps the limits to rounding."""
        slack = _ROUNDING * max(self.span, abs(self.low), abs(self.high))
        return bool(
            np.all(voltage >= self.low)
            and np.all(voltage <= self.high)
            and np.all(np.abs(np.diff(voltage)) <= self.step + slack)
            and abs(voltage[0] - self.rest) <= slack
            and abs(voltage[-1] - self.rest) <= slack
        )


def limits_of(
    wanted: Wanted,
    voltage_range: tuple[float, float],
    sample_time: float,
    duration: float | None = None,
    rate: float | None = None,
) -> Limits:
    """Return the limits of a rig, those that are not given as the model and the records imply them.

    Parameters
    ----------
    wanted : Wanted
    voltage_range : tuple of float
        That the model holds for, V.
    sample_time : float
        Of the model, s.
    duration, rate : float, optional
        Of the longest record, s, and the fastest change of the voltage in the records, V/s.

    Raises
    ------
    InputError
        If they exclude each other, or leave nothing to play.
    """
    said = []
    low, high = wanted.voltage or voltage_range
    said.append(_said("voltage", f"{low:g} to {high:g} V", wanted.voltage, "the range of the model"))
    _check_voltage(low, high, voltage_range)
    if wanted.sample_time is not None and not np.isclose(wanted.sample_time, sample_time, rtol=1e-3):
        raise InputError(
            f"--sample-time {wanted.sample_time:g}: the model's sample time is {sample_time:g} s; play "
            "and record at that rate, or identify a model at yours"
        )
    count, told = _samples(wanted, sample_time, duration)
    said.append(told)
    if wanted.periods > 1:
        said.append(f"periods: {wanted.periods}, all equal, as given")
    lowest, highest, told = _band(wanted, sample_time, count * sample_time)
    said.append(told)
    fastest, told = _fastest(wanted, high - low, sample_time, highest, rate)
    said.append(told)
    found = Limits(low, high, fastest, sample_time, count, wanted.periods, lowest, highest, tuple(said))
    _check_reach(found)
    return found


def _said(name: str, value: str, given: object, implied: str) -> str:
    return f"{name}: {value}, {'as given' if given is not None else implied}"


def _check_voltage(low: float, high: float, model: tuple[float, float]) -> None:
    if not (np.isfinite(low) and np.isfinite(high) and low < high):
        raise InputError(f"--voltage {low:g},{high:g}: the lowest must be below the highest")
    slack = 1e-9 * (model[1] - model[0])
    if low < model[0] - slack or high > model[1] + slack:
        raise InputError(
            f"--voltage {low:g},{high:g}: the model holds for {model[0]:g} to {model[1]:g} V only; "
            "keep the voltage within that range"
        )


def _check_positive(name: str, value: float | None) -> None:
    if value is not None and not (np.isfinite(value) and value > 0.0):
        raise InputError(f"the {name} must be positive, not {value:g}")


def _samples(wanted: Wanted, sample_time: float, duration: float | None) -> tuple[int, str]:
    """Return the samples of a period, and where the duration is from."""
    _check_positive("duration", wanted.duration)
    _check_positive("number of periods", wanted.periods)
    # on a longer one the search takes many minutes, and the usual one decides where it can
    usual = DESIGN.duration_samples * sample_time
    whole = wanted.duration or min(usual, duration or usual)
    samples = round(whole / sample_time)
    fewest = 4 * STARTS.fewest_deciding
    if samples > MOST_SAMPLES:
        raise InputError(
            f"--duration {whole:g}: {samples} samples every {sample_time:g} s; at most {MOST_SAMPLES} "
            "can be designed"
        )
    if samples < fewest:
        raise InputError(
            f"--duration {whole:g}: {samples} samples every {sample_time:g} s; a diagnosis needs at "
            f"least {fewest}, {fewest * sample_time:g} s"
        )
    is_usual = duration is None or duration > usual
    source = "the usual length" if is_usual else "as long as the longest record"
    return samples // wanted.periods, _said("duration", f"{whole:g} s", wanted.duration, source)


def _band(wanted: Wanted, sample_time: float, period: float) -> tuple[float, float, str]:
    """Return the lowest and highest frequency that is played, and where they are from."""
    _check_positive("bandwidth", wanted.bandwidth)
    nyquist, slowest = 0.5 / sample_time, 1.0 / period
    most = min(DESIGN.highest_share * nyquist, wanted.bandwidth or np.inf)
    why = (
        "the amplifier's bandwidth"
        if wanted.bandwidth == most
        else f"{DESIGN.highest_share:g} of the Nyquist frequency"
    )
    if wanted.band is None:
        low, high = slowest, most
        source = f"from one loop a period up to {why}"
    else:
        low, high = wanted.band
        if not (0.0 <= low < high and np.isfinite(high)):
            raise InputError(f"--band {low:g},{high:g}: the lowest must be below the highest frequency")
        if low >= most:
            raise InputError(f"--band {low:g},{high:g}: it must begin below {most:g} Hz, {why}")
        low, high, source = max(low, slowest), min(high, most), "as given"
    if low >= high:
        raise InputError(
            f"a period of {period:g} s holds nothing slower than {slowest:g} Hz, but nothing faster "
            f"than {high:g} Hz may be played: give a longer --duration, fewer --periods "
            "or a wider --band"
        )
    return low, high, f"band: {plain(low, 4)} to {plain(high, 4)} Hz, {source}"


def _fastest(
    wanted: Wanted, span: float, sample_time: float, highest: float, records: float | None
) -> tuple[float, str]:
    """Return the fastest change in V/s, the least of all that limit it, and where it is from."""
    if (wanted.current is None) != (wanted.capacitance is None):
        given, other = ("current", "capacitance")[:: 1 if wanted.capacitance is None else -1]
        raise InputError(
            f"--{given} limits the slew rate only together with --{other}: give both or neither"
        )
    _check_positive("slew rate", wanted.rate)
    _check_positive("current", wanted.current)
    _check_positive("capacitance", wanted.capacitance)
    rates = {"as given": wanted.rate}
    if wanted.current is not None and wanted.capacitance is not None:
        rates["the current divided by the capacitance"] = wanted.current / wanted.capacitance
    if wanted.bandwidth is not None:
        rates["a rise time of 0.35 / bandwidth over the range"] = span * wanted.bandwidth / _RISE
    if wanted.band is not None:
        rates["a rise time of 0.35 / highest frequency of the band"] = span * highest / _RISE
    known: Mapping[str, float] = {why: rate for why, rate in rates.items() if rate is not None}
    if not known:
        known = (
            {"the fastest change in the records": records}
            if records
            else {"the whole range within a sample, because no limit is known": span / sample_time}
        )
    why = min(known, key=lambda name: known[name])
    return known[why], f"slew rate: {plain(known[why], 4)} V/s, {why}"


def _check_reach(limits: Limits) -> None:
    """Refuse limits under which a period ends before the range has been gone through a few times."""
    swings = limits.rate * limits.samples * limits.sample_time / (2.0 * limits.span)
    if swings < DESIGN.fewest_swings:
        raise InputError(
            f"the limits exclude each other: at {plain(limits.rate)} V/s a swing through "
            f"{limits.low:g} to {limits.high:g} V and back takes "
            f"{2 * limits.span / limits.rate:.4g} s, and a period lasts "
            f"{limits.samples * limits.sample_time:.4g} s; give a faster --slew, a smaller --voltage, "
            "a longer --duration or fewer --periods"
        )
