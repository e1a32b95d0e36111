"""Tables of input and output signals: CSV files as `it2hys simulate` reads and writes them.

They follow the rules of measured records (units in the header, a uniform time base, one-line
errors), but any of the quantities may be absent and nothing is asked of their values.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from it2hys.records.columns import ColumnChoice, listed
from it2hys.records.table import read_table
from it2hys.records.text import HEADER
from it2hys.records.time_base import check_rising, fit_time_base, time_base_fault
from it2hys.records.units import UNITS
from it2hys.records.writing import write_signals

__all__ = ["Signals", "read_signals", "write_signals"]


@dataclass(frozen=True, eq=False)
class Signals:
    """Uniformly sampled signals in SI units.

    Attributes
    ----------
    time : numpy.ndarray, shape (n,)
        Time stamps, s; may start anywhere.
    sample_time : float
        Sample time, s.
    values : dict of str to numpy.ndarray, shape (n,)
        Signal by quantity, of those that the file has.
    notes : tuple of str
        What was assumed in reading, as sentences.
    """

    time: np.ndarray
    sample_time: float
    values: dict[str, np.ndarray]
    notes: tuple[str, ...] = ()


def read_signals(
    path: str | Path,
    quantities: Collection[str],
    columns: Mapping[str, ColumnChoice] | None = None,
) -> Signals:
    """Read the signals of some quantities from a CSV file and convert them to SI units.

    Parameters
    ----------
    path : str or pathlib.Path
        The file: ``time_s`` and at least one of the quantities, as ``voltage_V`` or
        ``voltage [V]``; other columns are ignored.
    quantities : collection of str
        Any of ``voltage``, ``displacement``, ``force``, ``temperature`` and ``reference``.
    columns : mapping, optional
        Column by quantity where the header uses other names, as for `read_record`.

    Returns
    -------
    Signals
        The signals that the file has.

    Raises
    ------
    InputError
        Where the file cannot be read, holds none of the quantities, or is not uniformly sampled
        in at least two samples.
    """
    table = read_table(path, ("time",), quantities, columns)
    if len(table.values) == 1:
        wanted = [f"{quantity}_{next(iter(UNITS[quantity]))}" for quantity in quantities]
        raise table.fault(
            f"no column for {' or '.join(quantities)}; the header has {listed(table.header)}. "
            f"Name it {' or '.join(wanted)}, or map it by --column QUANTITY=NAME:UNIT",
            HEADER,
        )
    if len(table) < 2:
        raise table.fault("the file has one sample; at least 2 are needed")
    check_rising(table)
    time = table.values["time"]
    base = fit_time_base(time)
    fault = time_base_fault(table, base, mend="these signals must be sampled uniformly")
    if fault is not None:
        raise fault
    values = {name: signal for name, signal in table.values.items() if name != "time"}
    return Signals(time, base.sample_time, values, tuple(table.notes))
