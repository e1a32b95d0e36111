"""A CSV file as columns in SI units that know where they came from."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from it2hys.errors import InputError
from it2hys.records.columns import Column, ColumnChoice, choose_columns, no_columns
from it2hys.records.text import Source, open_source, read_numbers
from it2hys.records.units import to_si


@dataclass(frozen=True)
class Table:
    """The columns of a file that were asked for.

    Attributes
    ----------
    values : dict of str to numpy.ndarray
        The signals in SI units by quantity, all of one length.
    columns : dict of str to Column
        Where each of them stands in the file.
    """

    values: dict[str, np.ndarray]
    columns: dict[str, Column]
    _source: Source

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.values["time"])

    @property
    def header(self) -> tuple[str, ...]:
        """The names of all columns of the file."""
        return self._source.names

    @property
    def unused(self) -> tuple[str, ...]:
        """The names of the columns that were not asked for; a nameless one is none."""
        used = {column.name for column in self.columns.values()}
        return tuple(name for name in self.header if name and name not in used)

    @property
    def notes(self) -> list[str]:
        """What was assumed in reading, as sentences."""
        return [column.note for column in self.columns.values() if column.note]

    def line(self, row: int) -> int:
        """Return the line number of a sample."""
        return self._source.line(row)

    def fault(self, message: str, row: int | None = None) -> InputError:
        """Return the error that names the file and, where given, the line of a sample."""
        return self._source.fault(message, row)


def read_table(
    path: str | Path,
    required: Collection[str],
    optional: Collection[str] = (),
    choices: Mapping[str, ColumnChoice] | None = None,
) -> Table:
    """Read the columns of some quantities.

    Parameters
    ----------
    path : str or pathlib.Path
        The CSV file.
    required, optional : collection of str
        The quantities that must and that may be there, keys of `UNITS`; time is a required one.
    choices : mapping, optional
        Column by quantity where the header uses other names.

    Raises
    ------
    InputError
        Where the file cannot be read or lacks a required quantity.
    """
    source = open_source(Path(path))
    columns = choose_columns(source, [*required, *optional], choices or {})
    missing = [quantity for quantity in required if quantity not in columns]
    if missing:
        raise no_columns(source, missing, {column.name for column in columns.values()})
    numbers = read_numbers(source, [column.index for column in columns.values()])
    values = {
        quantity: to_si(numbers[:, i], column.unit)
        for i, (quantity, column) in enumerate(columns.items())
    }
    return Table(values, columns, source)
