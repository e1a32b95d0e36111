"""Writing signals as CSV, the file whole or not at all."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from it2hys.records.record import Record
from it2hys.records.units import DIMENSIONLESS, from_si
from it2hys.support.files import write_atomically

#: Unit in which a record's quantity is written.
_WRITTEN_UNITS = {
    "voltage": "V",
    "displacement": "um",
    "force": "N",
    "temperature": "degC",
    "reference": "um",
}


def write_signals(
    path: str | Path, time: np.ndarray, columns: Mapping[str, tuple[np.ndarray, str]]
) -> None:
    """Write signals of one time base as CSV with units in the header.

    The numbers have as many digits as it takes to read the same ones back; but the time stamps
    are cut to 15, so that 0.1 + 0.2 is written as 0.3.

    Parameters
    ----------
    path : str or pathlib.Path
        The file; an existing one is replaced.
    time : numpy.ndarray, shape (n,)
        Time stamps, s.
    columns : mapping of str to (numpy.ndarray, str)
        By the name in the header: the signal of shape (n,) in SI units, and the unit to write it
        in, which is appended to the name unless it is "1".

    Raises
    ------
    InputError
        Where the file cannot be written.
    """
    names = [name if unit == DIMENSIONLESS else f"{name}_{unit}" for name, (_, unit) in columns.items()]
    texts = [[f"{stamp:.15g}" for stamp in np.asarray(time, dtype=float).tolist()]]
    for values, unit in columns.values():
        numbers = from_si(np.asarray(values, dtype=float), unit)
        texts.append([repr(number) for number in numbers.tolist()])
    lines = [",".join(["time_s", *names]), *map(",".join, zip(*texts, strict=True))]
    write_atomically(path, ("\n".join(lines) + "\n").encode())


def write_record(path: str | Path, record: Record) -> None:
    """Write a record as CSV, lengths in um.

    Parameters
    ----------
    path : str or pathlib.Path
        The file; an existing one is replaced.
    record : Record
        The record; its notes and its outlier mask are not written.

    Raises
    ------
    InputError
        Where the file cannot be written.
    """
    signals = {name: (getattr(record, name), unit) for name, unit in _WRITTEN_UNITS.items()}
    present = {name: signal for name, signal in signals.items() if signal[0] is not None}
    write_signals(path, record.time, present)
