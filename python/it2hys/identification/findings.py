"""Findings on records that hold for any model: unused columns, closed loop, coarse readings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from it2hys.identification.noise import number_step
from it2hys.policy import NOISE
from it2hys.records import Record
from it2hys.records.feedback import find_feedback
from it2hys.records.loop_width import wide_loop
from it2hys.records.unused import unused_columns
from it2hys.support.numerals import counted

UM = 1e6
#: A reading is coarse if its step is this many times the noise: rounding alone, step / sqrt(12) rms,
#: then makes more than half of its power ...
_COARSE = np.sqrt(6.0)
#: Rms of rounding to a step of 1.
_ROUNDING = 1.0 / np.sqrt(12.0)


class Judged(Protocol):
    """How a model does on one record."""

    name: str
    e_rms: float


def record_findings(records: Sequence[Record]) -> list[str]:
    """Return sentences on unused columns, closed loops, and loops that are too wide for a piezo."""
    said = [text for r in records for text in (_feedback_sentence(r), wide_loop(r)) if text]
    return [*unused_columns(records), *said]


def _feedback_sentence(record: Record) -> str:
    found = find_feedback(record)
    if found is None:
        return ""
    when = f"{counted(found.samples, 'sample')} later"
    when = "in the same sample" if found.samples == 0 else when
    return (
        f"Record '{record.name}' was taken in closed loop: its voltage answers the displacement, with "
        f"less voltage where that is larger than expected, {when}. The displacement's noise explains "
        f"{100 * found.share:.2g} % of the part of the voltage that its own past does not predict "
        f"({found.errors:.0f} standard errors from zero). What disturbs the stage or the sensor then "
        "drives the voltage too, so that cause and effect cannot be told apart there, and a slow "
        "correction by the controller looks like creep. Record the stage with the controller off, with "
        "a voltage that was chosen beforehand: a copy of this record's, played again, will do."
    )


def sensor_step(record: Record) -> float | None:
    """Return the step of the displacement's values, m, or None where none shows in its travel."""
    displacement = record.displacement[~record.outliers]
    step = number_step(displacement)
    return step if step > NOISE.least_step * np.ptp(displacement) else None


def coarse_readings(
    records: Sequence[Record], noises: Sequence[float], results: Sequence[Judged]
) -> list[str]:
    """Return a sentence for each record whose noise is mostly the rounding of its reading.

    Parameters
    ----------
    records : sequence of Record
    noises : sequence of float
        Rms noise of each, m.
    results : sequence of Judged
        How the model does on each.
    """
    return [
        _coarse_sentence(record, step, noise, result.e_rms)
        for record, noise, result in zip(records, noises, results, strict=True)
        if (step := sensor_step(record)) is not None and step > _COARSE * noise
    ]


def _coarse_sentence(record: Record, step: float, noise: float, error: float) -> str:
    steps = np.ptp(record.displacement) / step
    return (
        f"The displacement of record '{record.name}' is quantised: it goes in steps of "
        f"{UM * step:.3g} µm, {steps:.0f} of them over its travel. Rounding makes "
        f"{UM * _ROUNDING * step:.2g} µm rms of the {UM * noise:.2g} µm rms that count as noise; the "
        f"model's error is {UM * error:.2g} µm rms. Motion smaller than a step can "
        "hardly be seen: a narrower range of the sensor, or more bits, would show it."
    )
