"""Excerpts of long records, on which initial guesses are sought."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from it2hys.identification.criterion import Trace

#: Length of a window in samples: many times the memory of the model, so that its free initial
#: state costs little.
_WINDOW = 1000
#: Records that are longer in total than this many windows are cut.
_WINDOWS = 8


def excerpt(traces: Sequence[Trace]) -> tuple[list[Trace], np.ndarray]:
    """Return windows spread over the records, and the number of each window's record.

    Parameters
    ----------
    traces : sequence of Trace

    Returns
    -------
    windows : list of Trace
        The records themselves unless they are long; otherwise at least one window of each, to be
        fitted with a constant and a start of its own. No window begins before the first sample that is
        fitted, and half of a window's samples are, as far as the record has such windows.
    records : ndarray of int, shape (W,)
    """
    lengths = np.array([len(t.y) for t in traces])
    if lengths.sum() <= _WINDOWS * _WINDOW:
        return list(traces), np.arange(len(traces))
    counts = np.maximum(1, np.rint(_WINDOWS * lengths / lengths.sum())).astype(int)
    windows, records = [], []
    for i, (t, count) in enumerate(zip(traces, counts, strict=True)):
        for start in _starts(t, count):
            windows.append(t.part(slice(start, start + _WINDOW)))
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


def _starts(trace: Trace, count: int) -> np.ndarray:
    """Return where so many windows begin, or fewer, spread over those that are mostly fitted."""
    fitted = trace.weight > 0
    first = int(np.argmax(fitted))
    before = np.concatenate([[0], np.cumsum(fitted)])
    candidates = np.arange(first, max(len(fitted) - _WINDOW, first) + 1)
    inside = before[np.minimum(candidates + _WINDOW, len(fitted))] - before[candidates]
    allowed = candidates[inside >= min(_WINDOW // 2, inside.max())]
    return np.unique(allowed[np.linspace(0, len(allowed) - 1, count).astype(int)])
