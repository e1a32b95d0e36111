"""Warnings about what the training records do not show and the model therefore cannot know."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from it2hys.identification.preparation import Prepared

#: Share of the training range by which another record may exceed it.
_RANGE_SLACK = 0.02
#: Share of the drive's power below which its spectrum ends.
_POWER_TAIL = 0.01


def coverage_warnings(train: Sequence[Prepared], others: Sequence[Prepared]) -> list[str]:
    """Return sentences on the training records' lack of amplitudes, frequencies and range."""
    warnings = []
    if holds_one_tone(train):
        warnings.append(
            "The training records hold one amplitude at one frequency: memory of turning points, "
            "phase lag and dead time cannot be told apart, and other amplitudes or frequencies are "
            "extrapolated. Add a record with minor loops or another frequency."
        )
    low, high = _voltage_range(train)
    slack = _RANGE_SLACK * (high - low)
    fastest = max(_highest_frequency(p) for p in train)
    for p in others:
        below, above = _voltage_range([p])
        if below < low - slack or above > high + slack:
            warnings.append(
                f"Record '{p.record.name}' spans {below:.4g} to {above:.4g} V, the training "
                f"records {low:.4g} to {high:.4g} V: beyond that the model extrapolates."
            )
        if _highest_frequency(p) > 1.5 * fastest:
            warnings.append(
                f"Record '{p.record.name}' is driven up to {_highest_frequency(p):.4g} Hz, the "
                f"training records up to {fastest:.4g} Hz: the phase lag is not known there."
            )
    return warnings


def holds_one_tone(prepared: Sequence[Prepared]) -> bool:
    """Return whether all records are driven at one amplitude and one frequency."""
    return len({tone for p in prepared for tone in _tones(p)}) == 1


def _voltage_range(prepared: Sequence[Prepared]) -> tuple[float, float]:
    voltages = [p.record.voltage[p.skip :] for p in prepared]
    return min(v.min() for v in voltages), max(v.max() for v in voltages)


def _tones(prepared: Prepared) -> set[tuple]:
    """Return what turns the drive makes: (low, high, half period), coarsely rounded."""
    x = prepared.record.voltage[prepared.skip :]
    moving = np.flatnonzero(np.diff(x) != 0)
    turns = moving[np.flatnonzero(np.diff(np.sign(np.diff(x)[moving])) != 0)] + 1
    if len(turns) < 2:
        return {(float(x.min()), float(x.max()), len(x))}
    unit = 0.05 * np.ptp(x)
    lows = np.minimum(x[turns[:-1]], x[turns[1:]])
    highs = np.maximum(x[turns[:-1]], x[turns[1:]])
    spans = np.diff(turns) * prepared.record.sample_time
    kinds = zip(
        np.round(lows / unit), np.round(highs / unit), np.round(np.log(spans) / 0.2), strict=True
    )
    counted: dict[tuple, int] = {}
    for kind in kinds:
        counted[kind] = counted.get(kind, 0) + 1
    return {kind for kind, count in counted.items() if count > 0.05 * len(spans)}


def _highest_frequency(prepared: Prepared) -> float:
    """Return the frequency in Hz below which 99 % of the drive's power lie."""
    x = prepared.record.voltage[prepared.skip :]
    power = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x)))) ** 2
    share = np.cumsum(power) / np.sum(power)
    frequencies = np.fft.rfftfreq(len(x), prepared.record.sample_time)
    return float(frequencies[np.searchsorted(share, 1.0 - _POWER_TAIL)])
