"""What of long records a search among models works on: every n-th sample, or windows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import uniform_filter1d
from scipy.signal import periodogram

from it2hys.identification.coverage import turns_of
from it2hys.identification.noise import find_period
from it2hys.identification.preparation import Prepared
from it2hys.policy import SEARCH, STARTS

#: Training samples that are searched whole: a fit takes as much time as it has samples, and a search
#: makes hundreds of them. Windows cost the search what was before each of them.
_WHOLE = 25_000
#: Fewest and most samples of windows, and the turning points of the voltage that they are to have.
_FEWEST, _MOST, _TURNS = 10_000, 60_000, 50
#: Windows, in all records together, and their least length.
_WINDOWS, _SHORTEST = 8, 1000
#: Share of a window that may lie before the place that it is to show.
_BEFORE = 0.8
#: Samples that a search needs at least where every n-th of a record tells what is between them.
_ENOUGH = 12_500
#: Share of the rate of samples above which a spline through them has no more of their noise.
_ABOVE = 0.7
#: Samples of a wait that stay, as a share of those behind it: a few more than the lead-in.
_LEAD = 1.2 * STARTS.lead / (1.0 - STARTS.lead)
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


@dataclass(frozen=True, eq=False)
class Window:
    """A part of a training record, or all of it.

    Parameters
    ----------
    record : int
        Number of the training record.
    first : int
        Its sample with which the window begins.
    prepared : Prepared
        The part.
    step : int
        Distance of the part's samples in the record.
    """

    record: int
    first: int
    prepared: Prepared
    step: int = 1

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.prepared.record)


def step_of(train: Sequence[Prepared], others: Sequence[Prepared] = ()) -> int:
    """Return n where every n-th sample of long training records tells as much as all of them, or 1.

    What is between those samples must follow from them, and from half of them, in all records: then
    nothing in the records is too fast for n times the sample time. Unlike windows, they keep what was
    before.
    """
    total = sum(len(p.record) for p in train)
    step = total // _ENOUGH if total > _WHOLE else 1
    while step > 1 and not all(_tells_between(p, 2 * step) for p in (*train, *others)):
        step //= 2
    return max(1, step)


def _tells_between(prepared: Prepared, step: int) -> bool:
    """Return whether every n-th sample tells voltage and displacement between them, but for noise."""
    record, noise = prepared.record, prepared.noise.rms
    kept = np.flatnonzero(~record.outliers)[::step]
    if len(kept) < _SHORTEST:
        return False
    travel, span = np.ptp(record.displacement[kept]), np.ptp(record.voltage[kept])
    gain = travel / span if span else 0.0
    between = np.arange(kept[0], kept[-1])
    moved, applied = (
        np.where(
            record.outliers[between], 0.0, CubicSpline(kept, signal[kept])(between) - signal[between]
        )
        for signal in (record.displacement, record.voltage)
    )
    told = max(np.max(np.abs(moved)), gain * np.max(np.abs(applied))) <= SEARCH.told * noise
    frequency, power = periodogram(moved)
    # below half the kept rate, 0.5 / step, is the noise of the kept samples, interpolated
    power = power[frequency > _ABOVE / step]
    return bool(told and power.max() <= SEARCH.line * power.mean())


def every(prepared: Prepared, step: int) -> Prepared:
    """Return every n-th sample of a record; its noise is what all samples told."""
    if step == 1:
        return prepared
    return replace(prepared, record=prepared.record.slice(step=step), skip=-(-prepared.skip // step))


def windows_of(prepared: Sequence[Prepared], step: int = 1) -> list[Window]:
    """Return what a search works on: the records themselves unless they are long in all.

    Parameters
    ----------
    prepared : sequence of Prepared
        The training records.
    step : int
        Of whose samples every n-th is used.

    Returns
    -------
    list of Window
        In the order of the records, at least one of each, none that overlap.
    """
    prepared = [every(p, step) for p in prepared]
    if sum(len(p.record) for p in prepared) <= _WHOLE:
        return [Window(i, 0, p, step) for i, p in enumerate(prepared)]
    begins, prepared = _with_what_is_new(prepared)
    total = sum(len(p.record) for p in prepared)
    searched = _searched(prepared, total)
    if total <= max(_WHOLE, searched):
        return [Window(i, step * begins[i], p, step) for i, p in enumerate(prepared)]
    windows = []
    for i, p in enumerate(prepared):
        share = len(p.record) / total
        count = max(1, round(_WINDOWS * share))
        length = min(len(p.record), max(_SHORTEST, int(searched * share / count)))
        windows += [
            Window(i, step * (begins[i] + first), _part(p, first, first + length), step)
            for first in _firsts(p, count, length)
        ]
    return windows


def _with_what_is_new(prepared: Sequence[Prepared]) -> tuple[list[int], list[Prepared]]:
    """Return records without what they wait at first and repeat in the end, and where they begin.

    Where that is less than half of them, they stay as they are.
    """
    ends = [_repeats_from(p) for p in prepared]
    begins = [_waits(p, end) for p, end in zip(prepared, ends, strict=True)]
    if 2 * (sum(ends) - sum(begins)) > sum(len(p.record) for p in prepared):
        return [0] * len(prepared), list(prepared)
    return begins, [_part(p, *places) for p, *places in zip(prepared, begins, ends, strict=True)]


def _waits(prepared: Prepared, end: int) -> int:
    """Return how many samples a record may begin later, because nothing happens until then.

    As much of that stays as its lead-in takes: what comes first is not to lie in it.
    """
    record, noise = prepared.record, prepared.noise.rms
    apart = np.abs(record.voltage - record.voltage[0])
    holds = int(np.argmax(apart > SEARCH.same_voltage * np.ptp(record.voltage)))
    blocks = holds // _SHORTEST
    means = record.displacement[: blocks * _SHORTEST].reshape(blocks, _SHORTEST).mean(axis=1)
    if blocks == 0 or np.ptp(means) > SEARCH.same * noise:
        return 0
    return max(0, holds - max(_SHORTEST, int(_LEAD * (end - holds))))


def _repeats_from(prepared: Prepared) -> int:
    """Return from which sample on a record does what it has done; its length where it does not.

    What it does in the end it has then done for two periods at least. What creeps or drifts by more
    than noise is another thing.
    """
    record, noise = prepared.record, prepared.noise.rms
    count = len(record)
    period = find_period(record.voltage[count // 2 :])
    if period is None:
        return count
    # the place in the last period at which the voltage is the same
    last = count - period + (np.arange(count) - count) % period
    apart = np.abs(record.voltage - record.voltage[last])
    moved = record.displacement - record.displacement[last]
    length = max(1, period // 10)
    mean, square = (uniform_filter1d(c, length, mode="nearest") for c in (moved, moved**2))
    # both have noise
    is_other = (np.abs(mean) > SEARCH.same * noise) | (square > 2.0 * (SEARCH.same * noise) ** 2)
    is_other |= apart > SEARCH.same_voltage * np.ptp(record.voltage)
    others = np.flatnonzero(is_other)
    begin = int(others[-1]) + 1 if len(others) else 0
    return min(count, max(begin + 2 * period, _FEWEST))


def _searched(prepared: Sequence[Prepared], total: int) -> int:
    """Return how many samples windows have: memory shows where the voltage turns."""
    turns = max(1, sum(len(turns_of(p)) for p in prepared))
    return int(np.clip(total * _TURNS / turns, _FEWEST, _MOST))


def _firsts(prepared: Prepared, count: int, length: int) -> list[int]:
    """Return where windows begin, spread in turn over the travel of the voltage and over time.

    Steps that are far apart in time are found by the travel, holds by the time. The first window begins
    where the record does, of whose start the most is known.
    """
    begin, last = prepared.skip, len(prepared.record) - length
    voltage = prepared.record.voltage[begin:]
    travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(voltage)))])
    share = (np.arange(count) + 0.5) / count
    shown = begin + (share * len(voltage)).astype(int)
    shown[::2] = begin + np.searchsorted(travel, share[::2] * travel[-1])
    # what is shown stands at another place in each: parts of windows are kept from fits
    ahead = _BEFORE * (_GOLDEN * np.arange(count) % 1.0) * length
    firsts = [begin]
    for first in np.sort(shown - ahead).astype(int)[1:]:
        first = min(max(int(first), firsts[-1] + length), last)
        if first >= firsts[-1] + length:
            firsts.append(first)
    return firsts


def _part(prepared: Prepared, first: int, end: int) -> Prepared:
    record = prepared.record.slice(first, end)
    return replace(prepared, record=record, skip=max(0, prepared.skip - first))


def searched_text(windows: Sequence[Window], whole: Sequence[Window]) -> str:
    """Return in words what a search works on, of the whole records; empty if it is all of them."""
    used, samples = (sum(map(len, parts)) for parts in (windows, whole))
    if used == samples:
        return ""
    step = windows[0].step
    is_cut = any(step * len(w) < len(whole[w.record]) for w in windows)
    part = "a part" if len(windows) == len(whole) else f"{len(windows)} windows"
    parts = [*([f"one sample in {step}"] if step > 1 else []), *([part] if is_cut else [])]
    return (
        f"Effects were sought on {' in '.join(parts)} of the training records, {used} of their "
        f"{samples} samples; the final fit and all errors are those of the whole records."
    )
