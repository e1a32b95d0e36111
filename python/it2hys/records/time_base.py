"""The time base of a file: time stamps that rise on a uniform grid, or what is wrong with them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from it2hys.errors import InputError
from it2hys.policy import READING
from it2hys.records.table import Table


@dataclass(frozen=True)
class TimeBase:
    """A uniform grid fitted to time stamps.

    Attributes
    ----------
    sample_time : float
        Ts, s.
    steps : numpy.ndarray of int, shape (n - 1,)
        Ticks from each stamp to the next; 1 but for gaps.
    jitter : float
        Largest distance of a stamp from its tick, s.
    worst : int
        Row of that stamp.
    tolerance : float
        What is let pass as jitter, s.
    """

    sample_time: float
    steps: np.ndarray
    jitter: float
    worst: int
    tolerance: float

    @property
    def missing(self) -> int:
        """Number of ticks without a sample."""
        return int(np.sum(self.steps - 1))


def check_rising(table: Table) -> None:
    """Refuse time stamps that repeat or fall."""
    time, name = table.values["time"], table.columns["time"].name
    differences = np.diff(time)
    if np.all(differences > 0.0):
        return
    row = int(np.argmax(differences <= 0.0)) + 1
    # A few bad stamps beside a voltage ramp are no exchange of columns.
    often = np.mean(differences <= 0.0) > 0.1
    for quantity, values in table.values.items():
        if often and quantity != "time" and _looks_like_time(values):
            raise table.fault(
                f"column '{name}' does not rise, but '{table.columns[quantity].name}' rises "
                "evenly: the columns look swapped; correct the header or use --column",
                row,
            )
    if time[row] == time[row - 1]:
        raise table.fault(
            f"column '{name}' repeats the time stamp {time[row]:.9g} s of the line before; "
            "remove one of the two, or write the time with more digits",
            row,
        )
    raise table.fault(
        f"column '{name}' falls from {time[row - 1]:.9g} s to {time[row]:.9g} s; "
        "sort the file, or split it into records",
        row,
    )


def fit_time_base(time: np.ndarray) -> TimeBase:
    """Fit a uniform grid to at least two rising time stamps."""
    # Spans of ten samples: rounding of the stamps shrinks tenfold, and a gap spoils only ten of
    # them, which the median does not see. Short files have shorter ones.
    span = max(1, min(10, len(time) // 5))
    rough = np.median(time[span:] - time[:-span]) / span
    # A leap of centuries must not overflow the integers.
    steps = np.rint(np.minimum(np.diff(time) / rough, 1e9)).astype(int)
    if np.any(steps == 0):
        # Stamps this uneven make steps of two by themselves: only longer ones are gaps.
        steps[steps <= 2] = 1
    ticks = np.concatenate(([0], np.cumsum(steps)))
    centred_ticks, centred_time = ticks - ticks.mean(), time - time.mean()
    slope = centred_ticks @ centred_time / (centred_ticks @ centred_ticks)
    residual = centred_time - slope * centred_ticks

    resolution = _print_resolution(time)
    rounding = 4.0 * np.spacing(np.max(np.abs(time)))
    slack = (resolution + residual.std() + rounding) / ticks[-1]
    worst = int(np.argmax(np.abs(residual)))
    return TimeBase(
        sample_time=_simplest_within(slope, slack),
        steps=steps,
        jitter=float(abs(residual[worst])),
        worst=worst,
        # The last printed digit comes on top: half for its rounding, the rest for the bias of the fit.
        tolerance=READING.jitter * slope + 0.6 * resolution + rounding,
    )


def time_base_fault(table: Table, base: TimeBase, mend: str | None = None) -> InputError | None:
    """Return what forbids to use the stamps as they are, or None.

    Parameters
    ----------
    table : Table
        The file.
    base : TimeBase
        The grid fitted to its stamps.
    mend : str, optional
        What the message advises, where that is not ``--resample``.
    """
    time = table.values["time"]
    if base.missing:
        row = int(np.argmax(base.steps > 1)) + 1
        return table.fault(
            f"a gap in time: {base.steps[row - 1] - 1} samples are missing between "
            f"{time[row - 1]:.9g} s and {time[row]:.9g} s (in the whole file {base.missing}); "
            f"{mend or '--resample fills short gaps by interpolation'}",
            row,
        )
    if base.jitter > base.tolerance:
        return table.fault(
            f"the time base jitters: the stamp {time[base.worst]:.9g} s is "
            f"{100.0 * base.jitter / base.sample_time:.2g} % of the sample time "
            f"{base.sample_time:.6g} s away from a uniform grid; "
            f"{mend or '--resample interpolates'}",
            base.worst,
        )
    return None


def sample_time_fault(table: Table, base: TimeBase, wanted: float) -> InputError | None:
    """Return what a wanted sample time asks for beyond reading, or None.

    Raises
    ------
    InputError
        Where not even resampling leads there.
    """
    if not (np.isfinite(wanted) and 0.01 <= wanted / base.sample_time <= 100.0):
        raise table.fault(
            f"a sample time of {wanted:g} s was asked for, but the record has "
            f"{base.sample_time:.6g} s; a factor from 0.01 to 100 can be bridged"
        )
    if abs(wanted - base.sample_time) > 1e-6 * base.sample_time:
        return table.fault(
            f"the sample time is {base.sample_time:.6g} s, not {wanted:.6g} s; --resample interpolates"
        )
    return None


def _looks_like_time(values: np.ndarray) -> bool:
    differences = np.diff(values)
    return bool(np.all(differences > 0.0) and differences.std() < 0.1 * differences.mean())


def _print_resolution(time: np.ndarray) -> float:
    """Return the step of the last digit that the time stamps are printed with, s.

    The last stamps have the most digits before the point and hence, where all are printed with a
    number of significant digits, the coarsest step.
    """
    last = time[-1000:]
    largest = np.max(np.abs(last))
    for digits in range(1, 16):
        if all(float(f"{stamp:.{digits - 1}e}") == stamp for stamp in last):
            return 10.0 ** (np.floor(np.log10(largest)) - digits + 1)
    return 0.0


def _simplest_within(value: float, slack: float) -> float:
    """Return the number of fewest decimal digits within `slack` of `value`."""
    for digits in range(1, 17):
        candidate = float(f"{value:.{digits - 1}e}")
        if abs(candidate - value) <= slack:
            return candidate
    return float(value)
