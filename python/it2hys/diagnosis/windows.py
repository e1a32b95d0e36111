"""Windows of long records, on which a search among models works."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from it2hys.identification.coverage import turns_of
from it2hys.identification.preparation import Prepared

#: Training samples that are searched whole: a fit takes as much time as it has samples, and a search
#: makes hundreds of them. Windows cost the search what was before each of them.
_WHOLE = 25_000
#: Fewest and most samples of windows, and the turning points of the voltage that they are to have.
_FEWEST, _MOST, _TURNS = 10_000, 60_000, 50
#: Windows, in all records together, and their least length.
_WINDOWS, _SHORTEST = 8, 1000
#: Share of a window that may lie before the place that it is to show.
_BEFORE = 0.8
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
    """

    record: int
    first: int
    prepared: Prepared

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.prepared.record)


def windows_of(prepared: Sequence[Prepared]) -> list[Window]:
    """Return what a search works on: the records themselves unless they are long in all.

    Parameters
    ----------
    prepared : sequence of Prepared
        The training records.

    Returns
    -------
    list of Window
        In the order of the records, at least one of each, none that overlap.
    """
    total = sum(len(p.record) for p in prepared)
    searched = _searched(prepared, total)
    if total <= max(_WHOLE, searched):
        return [Window(i, 0, p) for i, p in enumerate(prepared)]
    windows = []
    for i, p in enumerate(prepared):
        share = len(p.record) / total
        count = max(1, round(_WINDOWS * share))
        length = min(len(p.record), max(_SHORTEST, int(searched * share / count)))
        windows += [Window(i, first, _part(p, first, length)) for first in _firsts(p, count, length)]
    return windows


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


def _part(prepared: Prepared, first: int, length: int) -> Prepared:
    record = prepared.record.slice(first, first + length)
    return replace(prepared, record=record, skip=max(0, prepared.skip - first))


def searched_text(windows: Sequence[Window], whole: Sequence[Window]) -> str:
    """Return in words what a search works on, of the whole records; empty if it is all of them."""
    used, samples = (sum(map(len, parts)) for parts in (windows, whole))
    if used == samples:
        return ""
    return (
        f"Effects were sought on {len(windows)} windows of the training records, {used} of their "
        f"{samples} samples; the final fit and all errors are those of the whole records."
    )
