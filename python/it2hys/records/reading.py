"""Reading a record: the gates in their order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from it2hys.errors import InputError
from it2hys.policy import READING
from it2hys.records.columns import ColumnChoice
from it2hys.records.plausibility import check_order, check_ranges, inspect
from it2hys.records.record import INVERTED, SIGNED, Record
from it2hys.records.resampling import resample as resampled
from it2hys.records.response import check_response
from it2hys.records.table import Table, read_table
from it2hys.records.text import record_name
from it2hys.records.time_base import check_rising, fit_time_base, sample_time_fault, time_base_fault
from it2hys.support.numerals import counted

REQUIRED = ("time", "voltage", "displacement")
OPTIONAL = ("force", "temperature", "reference")


def read_record(
    path: str | Path,
    columns: Mapping[str, ColumnChoice] | None = None,
    resample: bool = False,
    sample_time: float | None = None,
    check_swapped: bool = True,
    invert_displacement: bool = False,
) -> Record:
    """Read a CSV file, convert it to SI units and check it.

    Parameters
    ----------
    path : str or pathlib.Path
        The file: a header such as ``time_s,voltage_V,displacement_um`` (or ``voltage [V]``), then
        numbers separated by comma, semicolon or tab. Optional columns are ``force_N``,
        ``temperature_degC`` and ``reference_um``; the names of others are kept in `unused`.
    columns : mapping of str to str or (str, str or None), optional
        Column by quantity where the header uses other names: ``{"voltage": "Vin"}``,
        ``{"voltage": "Vin:mV"}`` or ``{"voltage": ("Vin", "mV")}``.
    resample : bool
        Interpolate linearly onto a uniform grid where samples are missing or the time base
        jitters, instead of refusing the file. No filter is applied.
    sample_time : float, optional
        Sample time that the record must have, or with `resample` shall get, s.
    check_swapped : bool
        Refuse a displacement that leads its voltage; otherwise only note it. Turn it off for a
        voltage that was measured behind a filter slower than the stage.
    invert_displacement : bool
        Flip the sign of the displacement about zero: that of a sensor which counts the other way.

    Returns
    -------
    Record
        The record in SI units, named after the file.

    Raises
    ------
    InputError
        Where the file cannot be read or the record cannot be used; the message names the culprit
        and the mend.
    """
    path = Path(path)
    table = read_table(path, REQUIRED, OPTIONAL, columns)
    if invert_displacement:
        table = _inverted(table)
    if len(table) < READING.fewest_samples:
        raise _too_few(table, f"the record has {counted(len(table), 'sample')}")
    check_rising(table)
    check_ranges(table)
    order_notes = check_order(table, refuse=check_swapped)
    outliers, findings = inspect(table)
    notes = [*table.notes, *([INVERTED] if invert_displacement else []), *findings, *order_notes]

    signals = table.values
    base = fit_time_base(signals["time"])
    if sample_time is None:
        sample_time = base.sample_time
    wanted_fault = sample_time_fault(table, base, sample_time)  # raises what no mend can bridge
    fault = time_base_fault(table, base) or wanted_fault
    if fault is not None:
        if not resample:
            raise fault
        signals, outliers, note = resampled(table, outliers, base, sample_time)
        notes.append(note)
        if len(outliers) < READING.fewest_samples:
            raise _too_few(table, f"{counted(len(outliers), 'sample')} left after resampling")
    record = Record(
        name=record_name(path),
        sample_time=sample_time,
        path=path,
        notes=tuple(notes),
        outliers=outliers,
        inverted=invert_displacement,
        unused=table.unused,
        **signals,
    )
    check_response(record)
    return record


def _inverted(table: Table) -> Table:
    return replace(table, values={q: -v if q in SIGNED else v for q, v in table.values.items()})


def _too_few(table: Table, complaint: str) -> InputError:
    return table.fault(f"{complaint}, at least {READING.fewest_samples} are needed")
