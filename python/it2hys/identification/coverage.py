"""Warnings about amplitudes, frequencies, ranges and starts at rest that the records lack."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.signal import find_peaks

from it2hys.identification.preparation import Prepared
from it2hys.policy import COVERAGE
from it2hys.records import Record

#: Begins the warning of records that hold one loop at one frequency.
ONE_TONE = "The training records hold one amplitude at one frequency"


def coverage_warnings(train: Sequence[Prepared], others: Sequence[Prepared]) -> list[str]:
    """Return sentences on what the records lack: amplitudes, frequencies, range, a start at rest."""
    warnings = [_ringing(p) for p in [*train, *others] if p.rings and p.skip]
    if holds_one_tone(train):
        warnings.append(
            f"{ONE_TONE}: memory of turning points, phase lag and dead time cannot be told apart, "
            "and other amplitudes or frequencies are extrapolated. Add a record with minor loops or "
            "another frequency."
        )
    low, high = _voltage_range(train)
    slack = COVERAGE.range_slack * (high - low)
    fastest = max(_highest_frequency(p.record.voltage[p.skip :], p.record.sample_time) for p in train)
    for p in others:
        below, above = _voltage_range([p])
        if below < low - slack or above > high + slack:
            warnings.append(
                f"Record '{p.record.name}' spans {below:.4g} to {above:.4g} V, the training "
                f"records {low:.4g} to {high:.4g} V: beyond that the model extrapolates."
            )
        highest = _highest_frequency(p.record.voltage[p.skip :], p.record.sample_time)
        if highest > 1.5 * fastest:
            warnings.append(
                f"Record '{p.record.name}' is driven up to {highest:.4g} Hz, the "
                f"training records up to {fastest:.4g} Hz: the phase lag is not known there."
            )
    return warnings


def _ringing(prepared: Prepared) -> str:
    record = prepared.record
    return (
        f"Record '{record.name}' begins while the stage rings from before it: its first "
        f"{1e3 * record.sample_time * prepared.skip:.3g} ms are neither fitted nor judged. Begin "
        "records with the stage at rest."
    )


def holds_one_tone(prepared: Sequence[Prepared]) -> bool:
    """Return whether all records are driven at one amplitude and one frequency.

    A few turns are of another kind in any such record: it begins somewhere, and its amplitude may be
    let in. Steps are no tone, whatever their amplitude: they hold all frequencies.
    """
    if any(_has_steps(p.record.voltage) for p in prepared):
        return False
    return _is_one_swing(np.vstack([turns_of(p) for p in prepared]))


def is_one_tone(voltage: np.ndarray, sample_time: float) -> bool:
    """Return whether a voltage, (N,), alone has one amplitude and one frequency."""
    return not _has_steps(voltage) and _is_one_swing(_turns(voltage, sample_time))


def _is_one_swing(turns: np.ndarray) -> bool:
    if len(turns) == 0:
        return True
    tolerance = np.array([COVERAGE.same_end, COVERAGE.same_end, np.log(COVERAGE.same_period)])
    commonest = np.median(turns, axis=0)
    others = np.count_nonzero(np.any(np.abs(turns - commonest) > tolerance, axis=1))
    few = max(COVERAGE.few_turns, COVERAGE.share_of_turns * len(turns))
    # most are alike: of a handful between levels of any height, few would be all
    return bool(others <= min(few, (len(turns) - 1) // 2))


def _voltage_range(prepared: Sequence[Prepared]) -> tuple[float, float]:
    voltages = [p.record.voltage[p.skip :] for p in prepared]
    return min(v.min() for v in voltages), max(v.max() for v in voltages)


def _has_steps(x: np.ndarray) -> bool:
    return bool(np.any(np.abs(np.diff(x)) > COVERAGE.step * np.ptp(x)))


def turns_of(prepared: Prepared) -> np.ndarray:
    """Return the ways from turn to turn of a drive, shape (N, 3).

    Columns are the lower and the upper end, in V over the span of the drive, and the logarithm of the
    time between.
    """
    return _turns(prepared.record.voltage[prepared.skip :], prepared.record.sample_time)


def _turns(x: np.ndarray, sample_time: float) -> np.ndarray:
    span = np.ptp(x)
    turns = np.sort(
        np.concatenate([find_peaks(sign * x, prominence=COVERAGE.turn * span)[0] for sign in (1, -1)])
    )
    ends = np.column_stack([x[turns[:-1]], x[turns[1:]]]) / span
    duration = np.diff(turns) * sample_time
    return np.column_stack([ends.min(axis=1), ends.max(axis=1), np.log(duration)])


def driven_up_to(record: Record) -> float | None:
    """Return up to which frequency in Hz a record is driven; None where it steps, which holds all."""
    if _has_steps(record.voltage):
        return None
    return _highest_frequency(record.voltage, record.sample_time)


def _highest_frequency(x: np.ndarray, sample_time: float) -> float:
    """Return the frequency in Hz below which 99 % of a drive's power lie."""
    power = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x)))) ** 2
    if not power.any():  # a voltage that is held
        return 0.0
    share = np.cumsum(power) / np.sum(power)
    frequencies = np.fft.rfftfreq(len(x), sample_time)
    return float(frequencies[np.searchsorted(share, 1.0 - COVERAGE.power_tail)])
