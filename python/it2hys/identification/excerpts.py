"""Excerpts of long records: what a search for a start needs to see of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from it2hys.identification.criteria import Series

#: Length of a window in samples: many times the memory of the model, so that its free initial
#: state costs little.
_WINDOW = 1000
#: Records that are longer in total than this many windows are cut.
_WINDOWS = 8


def excerpt(series: Sequence[Series]) -> tuple[list[Series], np.ndarray]:
    """Return windows spread over the records, and the number of each window's record.

    Parameters
    ----------
    series : sequence of Series

    Returns
    -------
    windows : list of Series
        The series themselves unless they are long; otherwise at least one window of each, with an
        offset and an initial state of its own. No window begins before the first sample that is
        fitted, and half of a window's samples are, as far as the series has such windows.
    records : ndarray of int, shape (W,)
    """
    lengths = np.array([len(s.x) for s in series])
    if lengths.sum() <= _WINDOWS * _WINDOW:
        return list(series), np.arange(len(series))
    counts = np.maximum(1, np.rint(_WINDOWS * lengths / lengths.sum())).astype(int)
    windows, records = [], []
    for i, (s, count) in enumerate(zip(series, counts, strict=True)):
        for start in _starts(s, count):
            windows.append(_window(s, start))
            records.append(i)
    return windows, np.array(records)


def searched_text(samples: int) -> str:
    """Return in words what a search sees of so many samples; empty if it sees all."""
    if samples <= _WINDOWS * _WINDOW:
        return ""
    return (
        f"Starts were sought on windows of {_WINDOW} samples, about {_WINDOWS * _WINDOW} of {samples}; "
        "the final fits and all errors are those of the whole records."
    )


def _starts(series: Series, count: int) -> np.ndarray:
    """Return where so many windows begin, or fewer, spread over those that are mostly fitted."""
    fitted = series.weight > 0
    first = int(np.argmax(fitted))
    before = np.concatenate([[0], np.cumsum(fitted)])
    candidates = np.arange(first, max(len(fitted) - _WINDOW, first) + 1)
    inside = before[np.minimum(candidates + _WINDOW, len(fitted))] - before[candidates]
    allowed = candidates[inside >= min(_WINDOW // 2, inside.max())]
    return np.unique(allowed[np.linspace(0, len(allowed) - 1, count).astype(int)])


def _window(series: Series, start: int) -> Series:
    part = slice(start, start + _WINDOW)
    return replace(
        series,
        x=series.x[part],
        y=series.y[part],
        weight=series.weight[part],
        state=series.state if start == 0 else float(series.y[start - 1]),
    )
