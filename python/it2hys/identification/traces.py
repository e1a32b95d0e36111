"""From records to the traces that the fits work on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from it2hys.errors import InputError
from it2hys.identification.criterion import Trace
from it2hys.identification.inverse import References
from it2hys.identification.preparation import Prepared
from it2hys.identification.scaling import Scaling
from it2hys.identification.weights import repetitions
from it2hys.model.compiled import Drive
from it2hys.policy import COVERAGE, STARTS
from it2hys.records import Record
from it2hys.records.clues import Extent

#: Without validation records: number of parts of a training record, and the parts that decide.
_PARTS, _DECIDING = 10, (2, 5, 8)


def plain_trace(prepared: Prepared, role: str, has_offset: bool = False) -> Trace:
    """Return a record as a trace with equal weights of all trusted samples, all of them judged."""
    record, used = prepared.record, prepared.used
    references = References(
        record.displacement, ~record.outliers, prepared.noise.rms, record.sample_time
    )
    return Trace(
        record.name,
        role,
        Drive.of(record.voltage, record.force, record.temperature),
        references.whole,
        1.0 * used,
        used,
        prepared.skip,
        prepared.noise.rms,
        references,
        has_offset,
        noise_method=prepared.noise.method,
    )


def to_trace(prepared: Prepared, role: str, has_offset: bool) -> Trace:
    """Return a record as a search for effects sees it.

    All trusted samples of a training record are fitted and judged, those before its first swing with a
    small weight; of another record those behind the lead-in are judged.

    A model's own error is the same in each of n equal periods, so that they tell less than n different
    ones: with an error of the noise's size the weight is that of `identification.weights`.
    """
    record, used = prepared.record, prepared.used
    weight = float(1.0 / np.sqrt(1.0 + repetitions(prepared)))
    begin, swing = int(np.flatnonzero(used)[0]), _swing(record.voltage)
    lead = begin + int(STARTS.lead * len(record))
    judged, weights = used.copy(), weight * used
    if role == "train":
        weights[: min(swing, lead)] *= STARTS.virgin
    else:
        lead = max(lead, min(swing, int(STARTS.longest_lead * len(record))))
        judged[:lead] = False
    trace = plain_trace(prepared, role, has_offset)
    return replace(trace, weight=weights, judged=judged, lead=lead, importance=weight)


def guess_offsets(traces: Sequence[Trace], scaling: Scaling) -> np.ndarray:
    """Return constants of the records beside the first one's, from a static regression, m, (R,).

    The regressors are powers of the voltage, those times the sign of its rate (the two branches of
    a loop), and one constant per record.
    """
    blocks, targets = [], []
    for i, t in enumerate(traces):
        x = scaling.x(t.drive.voltage)
        branch = np.sign(np.gradient(x))
        constants = np.zeros((len(x), len(traces)))
        constants[:, i] = 1.0
        powers = np.column_stack([x, x**2, x**3, branch, branch * x, branch * x**2, constants])
        used = t.weight > 0
        blocks.append(powers[used])
        targets.append(t.y[used])
    constants = np.linalg.lstsq(np.vstack(blocks), np.concatenate(targets))[0][-len(traces) :]
    return constants - constants[0]


def _swing(voltage: np.ndarray) -> int:
    """Return the sample up to which the voltage has gone through most of its range."""
    gone = np.maximum.accumulate(voltage) - np.minimum.accumulate(voltage)
    return int(np.argmax(gone >= STARTS.swing * gone[-1]))


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


def stays(trace: Trace, voltage: tuple[float, float]) -> np.ndarray:
    """Return where the voltage of a trace is within a range, or hardly beyond it, shape (N,)."""
    low, high = voltage
    slack = STARTS.beyond * (high - low)
    return (trace.drive.voltage >= low - slack) & (trace.drive.voltage <= high + slack)


def within(trace: Trace, voltage: tuple[float, float]) -> Trace:
    """Return the trace used and judged only where the voltage is within a range.

    Beyond what the models were fitted to they extrapolate, each in its own way: how they do there tells
    nothing of which effect is missing. A trace that is hardly ever within it stays as it is, and so
    does a lead-in of which half is not: nothing else tells how the record begins.
    """
    inside = stays(trace, voltage)
    judged = trace.judged & inside
    if np.count_nonzero(judged) < STARTS.fewest_deciding:
        return trace
    begin = trace.weight[: trace.lead] > 0.0
    if np.count_nonzero(begin & inside[: trace.lead]) < COVERAGE.trusted * np.count_nonzero(begin):
        inside[: trace.lead] = True
    return replace(trace, judged=judged, weight=np.where(inside, trace.weight, 0.0))


def check_deciding(deciding: Sequence[Trace]) -> None:
    """Refuse records on which no decision could rest.

    Raises
    ------
    InputError
        If there are too few samples to tell a gain from chance.
    """
    samples = sum(int(np.count_nonzero(t.judged)) for t in deciding)
    if samples < STARTS.fewest_deciding:
        names = ", ".join(f"'{t.name}'" for t in deciding)
        raise InputError(
            f"record{'s' * (len(deciding) > 1)} {names}: {samples} usable samples to decide between "
            f"models; at least {STARTS.fewest_deciding} are needed: "
            "give longer records, or more of them with --validate"
        )
