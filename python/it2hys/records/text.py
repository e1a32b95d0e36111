"""The text of a CSV file: its header, its delimiter and its numbers; faults by line."""

from __future__ import annotations

import csv
import gzip
import io
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from it2hys.errors import InputError
from it2hys.records.units import is_unit, plain_unit
from it2hys.support.numerals import parse_number

#: Row that stands for the header, in faults.
HEADER = -1


#: First bytes of files that are not text, and their kind.
_BINARY = {
    b"PK\x03\x04": "an Excel workbook (.xlsx) or another ZIP archive",
    b"\xd0\xcf\x11\xe0": "an old Excel workbook (.xls)",
    b"\x89HDF": "an HDF5 or MATLAB file",
    b"MATLAB": "a MATLAB file",
    b"PAR1": "a Parquet file",
}
_GZIP = b"\x1f\x8b"


@dataclass(frozen=True)
class Source:
    """The text of a file, cut into the header's names and the body.

    `units` are those of a row of its own below the header, by the names there; empty without one.
    """

    path: Path
    names: tuple[str, ...]
    delimiter: str
    header_line: int
    body: str
    units: Mapping[str, str] = field(default_factory=dict)

    def line(self, row: int) -> int:
        """Return the line number, counted from 1, of a row of the body; of the header too."""
        return self.header_line + 1 + int(row) + (bool(self.units) and row != HEADER)

    def fault(self, message: str, row: int | None = None) -> InputError:
        """Return the error that names this file and, where given, the line of a row."""
        place = f"{self.path}" if row is None else f"{self.path}, line {self.line(row)}"
        return InputError(f"{place}: {message}")


def open_source(path: Path) -> Source:
    """Read a file, skip blank lines and comments before the header, and check the header."""
    header_line, header, body = 1, *_cut_line(_read_text(path))
    while _is_preamble(header):
        if not body:
            raise InputError(f"{path}: there is no header, only blank lines and comments")
        header_line, header, body = header_line + 1, *_cut_line(body)
    # A comma may be part of a name or a number; a semicolon or a tab in a header separates.
    delimiter = next((mark for mark in ";\t" if mark in header), ",")
    names = tuple(name.strip() for name in next(csv.reader([header], delimiter=delimiter)))
    source = Source(path, names, delimiter, header_line, body.rstrip("\n "))
    _check_header(source)
    if delimiter != "," and "," in body and "." not in body:  # decimal commas
        source = replace(source, body=source.body.replace(",", "."))
    source = _without_units(source)
    if not source.body:
        raise source.fault("there is only a header, no samples")
    return source


def read_numbers(source: Source, indices: list[int]) -> np.ndarray:
    """Return the columns asked for, finite numbers all, shape (rows, len(indices)).

    NumPy's reader is fast but vague about faults, and it wants numbers in every column; where it
    fails, a line-by-line pass names the place or gets by.
    """
    try:
        table = np.loadtxt(
            io.StringIO(source.body),
            delimiter=source.delimiter,
            comments=None,
            quotechar='"',
            ndmin=2,
        )
    except ValueError:
        table = None
    # NumPy skips blank lines; the count tells, and keeps rows and line numbers in step.
    if table is not None and table.shape == (source.body.count("\n") + 1, len(source.names)):
        numbers = table[:, indices]
    else:
        numbers = _read_numbers_by_line(source, indices)
    _check_finite(source, indices, numbers)
    return numbers


def record_name(path: Path) -> str:
    """Return what a record is called: its file without ``.csv`` and ``.gz``."""
    return Path(path.stem).stem if path.suffix == ".gz" else path.stem


def _without_units(source: Source) -> Source:
    """Return a source whose row of units below the header, if there is one, is in `units`."""
    line, rest = _cut_line(source.body)
    texts = [
        text.strip().strip("[]()") for text in next(csv.reader([line], delimiter=source.delimiter), [])
    ]
    if len(texts) != len(source.names) or not any(texts):
        return source
    if any(text and _is_number(text) and not is_unit(text) for text in texts):
        return source
    if all(map(_is_number, filter(None, texts))):  # ones
        return source
    unknown = next((text for text in texts if text and not is_unit(text)), None)
    if unknown is not None:
        raise source.fault(
            f"'{unknown}' is neither a number nor a unit that is known; in a row of units, "
            "leave those of other columns empty, or remove the row and put units into the header",
            0,
        )
    units = {name: plain_unit(text) for name, text in zip(source.names, texts, strict=True)}
    return replace(source, body=rest, units=units)


def _cut_line(text: str) -> tuple[str, str]:
    line, _, rest = text.partition("\n")
    return line, rest


def _read_text(path: Path) -> str:
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except IsADirectoryError:
        raise InputError(f"{path}: this is a directory, a CSV file is needed") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    if content.startswith(_GZIP):
        try:
            content = gzip.decompress(content)
        except (OSError, EOFError, zlib.error) as error:
            raise InputError(f"{path}: cannot be unpacked as gzip ({error})") from None
    if not content:
        raise InputError(f"{path}: the file is empty (zero bytes)")
    # as reading a text file does it: all ends of lines are one
    return _decoded(path, content).replace("\r\n", "\n").replace("\r", "\n")


def _decoded(path: Path, content: bytes) -> str:
    """Return text in UTF-8, with or without its mark, or in what Windows writes in its place."""
    for begin, kind in _BINARY.items():
        if content.startswith(begin):
            raise InputError(f"{path}: this is {kind}, no CSV file; export the table as CSV")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if b"\0" in content:
            line = content[: error.start].count(b"\n") + 1
            raise InputError(
                f"{path}, line {line}: this is not UTF-8 text; save the file as CSV in UTF-8"
            ) from None
        return content.decode("cp1252", errors="replace")  # where µ and ° are one byte


def _is_preamble(line: str) -> bool:
    return not line.strip() or line.lstrip().startswith("#")


def _check_header(source: Source) -> None:
    if all(_is_number(name) for name in source.names):
        raise source.fault(
            "a header is needed before the numbers, such as time_s,voltage_V,displacement_um "
            "(without a leading #)",
            HEADER,
        )
    for name in source.names:
        if name and source.names.count(name) > 1:
            raise source.fault(
                f"the header names column '{name}' more than once; rename one of them", HEADER
            )


def _read_numbers_by_line(source: Source, indices: list[int]) -> np.ndarray:
    lines = source.body.split("\n")
    numbers = np.empty((len(lines), len(indices)))
    for row, line in enumerate(lines):
        texts = _split_line(source, row, line)
        for column, index in enumerate(indices):
            text, name = texts[index].strip(), source.names[index]
            if not text:
                raise source.fault(f"column '{name}' is empty, a number is needed", row)
            if not _is_number(text):
                raise source.fault(f"column '{name}' has '{text}' where a number belongs", row)
            numbers[row, column] = parse_number(text)
    return numbers


def _split_line(source: Source, row: int, line: str) -> list[str]:
    if not line.strip():
        raise source.fault("the line is blank, but more samples follow; remove it", row)
    try:
        texts = next(csv.reader([line], delimiter=source.delimiter))
    except csv.Error as error:
        raise source.fault(f"the line is not CSV ({error})", row) from None
    if len(texts) != len(source.names):
        hint = ""
        if source.delimiter == "," and len(texts) > len(source.names):
            hint = "; for a decimal comma, separate the columns by semicolons"
        raise source.fault(
            f"the line has {len(texts)} fields, the header has {len(source.names)}{hint}", row
        )
    return texts


def _is_number(text: str) -> bool:
    try:
        parse_number(text)
    except ValueError:
        return False
    return True


def _check_finite(source: Source, indices: list[int], numbers: np.ndarray) -> None:
    rows, columns = np.nonzero(~np.isfinite(numbers))
    if rows.size:
        raise source.fault(
            f"column '{source.names[indices[columns[0]]]}' has {numbers[rows[0], columns[0]]:g} "
            f"where a finite number belongs ({rows.size} such values in all); "
            "correct these lines or remove them",
            rows[0],
        )
