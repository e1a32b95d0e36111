"""Linear interpolation of a file's signals onto a uniform grid."""

from __future__ import annotations

import numpy as np

from it2hys.policy import READING
from it2hys.records.table import Table
from it2hys.records.time_base import TimeBase


def resample(
    table: Table, outliers: np.ndarray, base: TimeBase, sample_time: float
) -> tuple[dict[str, np.ndarray], np.ndarray, str]:
    """Interpolate every signal onto a uniform grid; no filter is applied.

    Parameters
    ----------
    table : Table
        The file.
    outliers : numpy.ndarray of bool, shape (n,)
        The samples not to be trusted.
    base : TimeBase
        The grid fitted to the file's time stamps.
    sample_time : float
        Sample time of the new grid, s.

    Returns
    -------
    tuple of (dict of str to numpy.ndarray, numpy.ndarray of bool, str)
        The signals, the samples of theirs not to be trusted, and a note.

    Raises
    ------
    InputError
        Where too much is missing.
    """
    time = table.values["time"]
    _check_gaps(table, base)
    count = int(np.floor((time[-1] - time[0]) / sample_time + 0.01)) + 1
    grid = time[0] + np.arange(count) * sample_time
    signals = {name: np.interp(grid, time, values) for name, values in table.values.items()}
    signals["time"] = grid
    # Whatever an outlier has a share in is one, and so is what was filled into a gap.
    tainted = np.interp(grid, time, outliers.astype(float)) > 1e-6
    tainted |= _inside_gap(grid, time, base)
    note = (
        f"Resampled by linear interpolation from {len(time)} to {count} samples of "
        f"{sample_time:.6g} s: {base.missing} were missing, and the time stamps were up to "
        f"{100.0 * base.jitter / base.sample_time:.2g} % of a sample off."
    )
    return signals, tainted, note


def _check_gaps(table: Table, base: TimeBase) -> None:
    longest = int(np.argmax(base.steps))
    if base.steps[longest] - 1 > READING.longest_gap:
        raise table.fault(
            f"a gap in time of {base.steps[longest] - 1} samples is too long to fill "
            f"(at most {READING.longest_gap}); split the file into records",
            longest + 1,
        )
    share = base.missing / (len(table) + base.missing)
    if share > READING.missing:
        raise table.fault(
            f"{100.0 * share:.2g} % of the samples are missing, at most "
            f"{100.0 * READING.missing:g} % can be filled by interpolation"
        )


def _inside_gap(grid: np.ndarray, time: np.ndarray, base: TimeBase) -> np.ndarray:
    """Return the mask of grid points in a gap that no time stamp is near to."""
    before = np.clip(np.searchsorted(time, grid, side="right") - 1, 0, len(base.steps) - 1)
    distance = np.minimum(grid - time[before], np.abs(time[before + 1] - grid))
    return (base.steps[before] > 1) & (distance > 0.5 * base.sample_time)
