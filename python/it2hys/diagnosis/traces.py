"""From records to the traces that the fits work on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from it2hys.diagnosis.criterion import Trace
from it2hys.diagnosis.inverse import References
from it2hys.errors import InputError
from it2hys.identification.preparation import Prepared
from it2hys.identification.weights import repetitions
from it2hys.model.compiled import Drive
from it2hys.records import Record
from it2hys.records.clues import Extent

#: Least and largest share of a record that is its lead-in while models are searched for, and the share
#: of its voltage's range that it goes through, where that is between them: what was before is then
#: forgotten, however the stage was driven.
_LEAD, _LONGEST_LEAD, _SWING = 0.1, 0.4, 0.9
#: Weight of a training record's samples before that swing, a tenth of it at most: how a stack leaves
#: the state that it was in before, its first curve above all, is no hysteresis of its loops.
_VIRGIN = 0.2
#: Where there are no validation records: parts of every training record, and those that decide.
_PARTS, _DECIDING = 10, (2, 5, 8)
#: Share of the range of the voltage by which a sample may be beyond it and decide.
_SLACK = 0.01
#: Fewest samples that may decide between two models.
_FEWEST_DECIDING = 200


def to_trace(prepared: Prepared, role: str, has_offset: bool) -> Trace:
    """Return a record as a trace.

    All trusted samples of a training record are fitted and judged, those before its first swing with a
    small weight; of another record those behind the lead-in are judged.

    A model's own error is the same in each of n equal periods, so that they tell less than n different
    ones: with an error of the noise's size the weight is that of `identification.weights`.
    """
    record, used = prepared.record, prepared.used
    weight = float(1.0 / np.sqrt(1.0 + repetitions(prepared)))
    begin, swing = int(np.flatnonzero(used)[0]), _swing(record.voltage)
    lead = begin + int(_LEAD * len(record))
    judged, weights = used.copy(), weight * used
    if role == "train":
        weights[: min(swing, lead)] *= _VIRGIN
    else:
        lead = max(lead, min(swing, int(_LONGEST_LEAD * len(record))))
        judged[:lead] = False
    return Trace(
        record.name,
        role,
        Drive.of(record.voltage, record.force, record.temperature),
        record.displacement,
        weights,
        judged,
        lead,
        prepared.noise.rms,
        References(record.displacement, ~record.outliers, prepared.noise.rms, record.sample_time),
        has_offset,
        weight,
    )


def _swing(voltage: np.ndarray) -> int:
    """Return the sample up to which the voltage has gone through most of its range."""
    gone = np.maximum.accumulate(voltage) - np.minimum.accumulate(voltage)
    return int(np.argmax(gone >= _SWING * gone[-1]))


def extent_of(records: Sequence[Record]) -> Extent:
    """Return what the training records span."""

    def span(channel: str) -> tuple[float, float] | None:
        values = [getattr(r, channel) for r in records if getattr(r, channel) is not None]
        if not values:
            return None
        return float(min(v.min() for v in values)), float(max(v.max() for v in values))

    sample_time = records[0].sample_time
    return Extent(
        sample_time,
        max(len(r) for r in records) * sample_time,
        span("voltage"),
        span("displacement"),
        span("force"),
        span("temperature"),
    )


def set_aside(traces: Sequence[Trace]) -> tuple[list[Trace], list[Trace]]:
    """Return traces without some of their parts, and traces of which only those parts are judged.

    The parts are spread over the record: its end alone may be a rest, or at another amplitude.
    """
    fitted, deciding = [], []
    for t in traces:
        part = np.arange(len(t.y)) * _PARTS // len(t.y)
        aside = np.isin(part, _DECIDING)
        kept = replace(t, weight=np.where(aside, 0.0, t.weight))
        fitted.append(kept)
        deciding.append(replace(kept, judged=t.judged & aside))
    return fitted, deciding


def within(trace: Trace, voltage: tuple[float, float]) -> Trace:
    """Return the trace used and judged only where the voltage is within a range.

    Beyond what the models were fitted to they extrapolate, each in its own way: how they do there tells
    nothing of which effect is missing. A trace that is hardly ever within it stays as it is.
    """
    low, high = voltage
    slack = _SLACK * (high - low)
    inside = (trace.drive.voltage >= low - slack) & (trace.drive.voltage <= high + slack)
    judged = trace.judged & inside
    if np.count_nonzero(judged) < _FEWEST_DECIDING:
        return trace
    return replace(trace, judged=judged, weight=np.where(inside, trace.weight, 0.0))


def check_deciding(deciding: Sequence[Trace]) -> None:
    """Refuse records on which no decision could rest.

    Raises
    ------
    InputError
        If there are too few samples to tell a gain from chance.
    """
    samples = sum(int(np.count_nonzero(t.judged)) for t in deciding)
    if samples < _FEWEST_DECIDING:
        names = ", ".join(f"'{t.name}'" for t in deciding)
        raise InputError(
            f"record(s) {names}: {samples} samples are left to decide between models, and at least "
            f"{_FEWEST_DECIDING} are needed; give longer records, or more of them with --validate"
        )
