"""Whether the signals of a file can be a stage's: what is refused, marked and noted."""

from __future__ import annotations

import shlex

import numpy as np

from it2hys.policy import READING
from it2hys.records.lead import samples_ahead
from it2hys.records.table import Table
from it2hys.records.text import HEADER
from it2hys.support.numerals import counted


def check_ranges(table: Table) -> None:
    """Refuse signals that do not move, or not as a piezo stage's in the units given."""
    voltage, displacement = table.values["voltage"], table.values["displacement"]
    for quantity in ("voltage", "displacement"):
        values = table.values[quantity]
        # A millionth of the level: what rounding leaves of a constant is no excitation.
        if np.ptp(values) <= 1e-6 * np.max(np.abs(values)):
            raise table.fault(
                f"column '{table.columns[quantity].name}' is constant: nothing can be identified "
                f"from a {quantity} that does not change"
            )
    row = int(np.argmax(np.abs(voltage)))
    largest = abs(voltage[row])
    if largest > READING.largest_voltage:
        raise table.fault(_wrong_unit(table, "voltage", f"{largest:.4g} V"), row)
    row = int(np.argmax(np.abs(displacement)))
    if abs(displacement[row]) > READING.farthest:
        raise table.fault(
            f"column '{table.columns['displacement'].name}' has {1e6 * displacement[row]:.4g} µm, and "
            f"FMUs take no more than {1e6 * READING.farthest:g} µm on either side of zero: subtract a "
            "constant",
            row,
        )
    stroke = np.ptp(displacement)
    if not READING.smallest_stroke <= stroke <= READING.largest_stroke:
        raise table.fault(_wrong_unit(table, "displacement", f"a range of {1e6 * stroke:.4g} µm"))


def check_order(table: Table, refuse: bool = True) -> list[str]:
    """Refuse, or note, a displacement that leads its voltage."""
    ahead = samples_ahead(table.values["voltage"], table.values["displacement"])
    if ahead == 0:
        return []
    if not refuse:
        return [
            f"The displacement leads the voltage by about {ahead} samples, which is not causal: "
            "the columns look swapped, or a channel is delayed."
        ]
    voltage, displacement = table.columns["voltage"], table.columns["displacement"]
    exchanged = (
        shlex.quote(f"voltage={displacement.name}:{voltage.unit}"),
        shlex.quote(f"displacement={voltage.name}:{displacement.unit}"),
    )
    raise table.fault(
        f"the displacement leads the voltage by about {ahead} samples: the columns look swapped; "
        f"map them with --column {exchanged[0]} --column {exchanged[1]} (or pass --allow-lead if a "
        "slow voltage channel makes it so)",
        HEADER,
    )


def inspect(table: Table) -> tuple[np.ndarray, list[str]]:
    """Return the mask of displacements not to be trusted, and the findings as sentences."""
    voltage, displacement = table.values["voltage"], table.values["displacement"]
    spikes = _spikes(displacement) & ~_spikes(voltage)
    stuck = _stuck(displacement, voltage)
    notes = []
    start = table.values["time"][0]
    if start != 0.0:
        notes.append(f"The time starts at {start:.9g} s.")
    if np.any(spikes):
        rows = np.flatnonzero(spikes)
        notes.append(
            f"The displacement has {counted(rows.size, 'single-sample outlier')}, the first in line "
            f"{table.line(rows[0])}; kept, but given no weight."
        )
    notes += _stuck_notes(table, _runs(stuck))
    notes += _saturation_notes(table)
    notes += _shape_notes(voltage, displacement)
    return spikes | stuck, notes


def _wrong_unit(table: Table, quantity: str, extent: str) -> str:
    name, unit = table.columns[quantity].name, table.columns[quantity].unit
    return (
        f"column '{name}' has {extent} when read in {unit}, which no piezo stage has: the unit "
        f"looks wrong; give the right one with --column {quantity}={name}:UNIT"
    )


def _spikes(values: np.ndarray) -> np.ndarray:
    """Return the mask of samples that stand out alone from both neighbours.

    One sample off by a gives the second difference (a, -2 a, a); corners and steps of the signal
    itself have other patterns. The scale is the median absolute deviation of the second
    difference, with a floor of a thousandth of the range for signals without noise.
    """
    second = np.diff(values, 2)
    deviation = 1.4826 * np.median(np.abs(second - np.median(second)))
    threshold = max(READING.stands_out * deviation, READING.least_outlier * np.ptp(values))
    before, middle, after = second[:-2], second[1:-1], second[2:]
    alone = np.abs(middle) > threshold
    for neighbour in (before, after):
        alone &= np.abs(neighbour + 0.5 * middle) < 0.25 * np.abs(middle)
    mask = np.zeros(values.shape, dtype=bool)
    mask[2:-2] = alone
    return mask


def _stuck(displacement: np.ndarray, voltage: np.ndarray) -> np.ndarray:
    """Return the mask of displacements that stand still while the voltage moves."""
    mask = np.zeros(displacement.shape, dtype=bool)
    for start, stop in _constant_runs(displacement):
        if np.ptp(voltage[start:stop]) > READING.stuck * np.ptp(voltage):
            mask[start:stop] = True
    return mask


def _stuck_notes(table: Table, runs: list[tuple[int, int]]) -> list[str]:
    """Tell of the stretches at either end of the range, and of those between."""
    displacement = table.values["displacement"]
    kinds = {
        displacement.max(): "at its maximum: the sensor looks clipped",
        displacement.min(): "at its minimum: the sensor looks clipped",
    }
    found: dict[str, list] = {}
    for run in runs:
        kind = kinds.get(displacement[run[0]], "at one value: the reading looks stuck")
        found.setdefault(kind, []).append(run)
    return [
        f"The displacement stays {kind}; {counted(len(stretches), 'stretch')} while the voltage moves, "
        f"the first of {stretches[0][1] - stretches[0][0]} samples from line "
        f"{table.line(stretches[0][0])}; kept, but given no weight."
        for kind, stretches in found.items()
    ]


def _saturation_notes(table: Table) -> list[str]:
    """Tell where the voltage runs into an end of its range and stays there.

    A step to a level is no such case: there the voltage jumps, here it was on its way.
    """
    voltage = table.values["voltage"]
    found = []
    for start, stop in _constant_runs(voltage):
        at_end = voltage[start] in (voltage.min(), voltage.max())
        if not at_end or start < 2:
            continue
        earlier, last = np.abs(np.diff(voltage[start - 2 : start + 1]))
        if earlier > 0.0 and last <= 2.0 * earlier:
            found.append((start, stop))
    if not found:
        return []
    start, stop = found[0]
    return [
        f"The voltage runs into {voltage[start]:.6g} V, an end of its range, and stays there for "
        f"{stop - start} samples from line {table.line(start)} "
        f"({counted(len(found), 'such stretch')}): the drive is saturated, or holds its value."
    ]


def _shape_notes(voltage: np.ndarray, displacement: np.ndarray) -> list[str]:
    notes = []
    stroke = np.ptp(displacement)
    if not READING.usual_from <= stroke <= READING.usual_to:
        notes.append(
            f"The range of {1e6 * stroke:.4g} µm is unusual for a piezo stage: check the unit."
        )
    if np.corrcoef(voltage, displacement)[0, 1] < -READING.falling:
        notes.append("The displacement falls where the voltage rises: check the sensor's sign.")
    return notes


def _constant_runs(values: np.ndarray) -> list[tuple[int, int]]:
    """Return (start, stop) of each stretch of enough equal samples."""
    equal = np.concatenate((np.diff(values) == 0.0, [False]))
    runs = [(start, stop + 1) for start, stop in _runs(equal)]
    return [(start, stop) for start, stop in runs if stop - start >= READING.standing]


def _runs(mask: np.ndarray) -> list[tuple[int, int]]:
    """Return (start, stop) of each stretch of True."""
    edges = np.flatnonzero(np.diff(mask.astype(int), prepend=0, append=0))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
