"""The start-up transient: leading samples that belong to no state the drive can bring about.

A stage that was at rest elsewhere when the recording began first comes in from outside its loops,
then travels a first loading curve that it never visits again. Both ends when the drive has passed
both of its extremes: that wipes out what went before.
"""

from __future__ import annotations

import numpy as np

_BINS = 40
#: Share of the displacement's range by which a sample must lie outside the later loops.
_OUTSIDE = 0.03
#: Share of the voltage's range within which an extreme counts as reached.
_REACHED = 0.05
#: Share of it that the voltage still travels after both extremes: what stays at one of them, as after a
#: single step, shows no loops.
_TRAVELLED = 0.5


def transient_length(x: np.ndarray, y: np.ndarray, used: np.ndarray | None = None) -> int:
    """Return the number of leading samples to leave out of the fit.

    Parameters
    ----------
    x, y : ndarray, shape (N,)
        Voltage and displacement, any units.
    used : ndarray of bool, shape (N,), optional
        Samples whose displacement can be trusted; all if not given.

    Returns
    -------
    int
        0 unless the record starts outside the band of displacements that are met at the same
        voltage after the drive has passed both of its extremes, and goes on to travel.
    """
    wiped = _extremes_passed(x)
    if wiped > len(x) // 2 or np.ptp(x[wiped:]) < _TRAVELLED * np.ptp(x):
        return 0
    edges = np.linspace(x.min(), x.max(), _BINS + 1)
    bins = np.clip(np.digitize(x, edges) - 1, 0, _BINS - 1)
    lowest, highest = np.full(_BINS, np.inf), np.full(_BINS, -np.inf)
    used = np.ones(len(y), dtype=bool) if used is None else used
    later = wiped + np.flatnonzero(used[wiped:])
    np.minimum.at(lowest, bins[later], y[later])
    np.maximum.at(highest, bins[later], y[later])
    lead = bins[:wiped]
    slack = _OUTSIDE * np.ptp(y[later])
    outside = (y[:wiped] < lowest[lead] - slack) | (y[:wiped] > highest[lead] + slack)
    return wiped if np.any(outside & used[:wiped]) else 0


def _extremes_passed(x: np.ndarray) -> int:
    slack = _REACHED * np.ptp(x)
    return int(max(np.argmax(x <= x.min() + slack), np.argmax(x >= x.max() - slack)))
