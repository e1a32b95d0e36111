"""Parts of training records that decide on effects which the validation records do not excite."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from it2hys.identification.criterion import Trace
from it2hys.policy import SEARCH

#: Of the steps of all training records the second, and each third one from there, decide.
_SECOND, _EVERY = 1, 3


def steps_aside(traces: Sequence[Trace], deciding: Sequence[Trace]) -> tuple[list[Trace], list[Trace]]:
    """Return the training and the deciding traces, with some of the former's steps in the latter.

    Steps alone show ringing, dead time and a slew limit. Where no record that decides has any, what
    those explain of the training records would count for nothing: then a third of the steps of the
    training records, each with what follows it, is not fitted and decides as well.

    Parameters
    ----------
    traces, deciding : sequence of Trace
        Of the training records, and of others that decide.
    """
    low = min(float(t.drive.voltage.min()) for t in traces)
    high = max(float(t.drive.voltage.max()) for t in traces)
    least = SEARCH.step * (high - low)
    if any(_has_steps(t, least) for t in deciding):
        return list(traces), list(deciding)
    held = [(i, part) for i, t in enumerate(traces) for part in _after_steps(t, least)]
    fitted, aside = list(traces), []
    for i in sorted({i for i, _ in held[_SECOND::_EVERY]}):
        trace, mask = traces[i], np.zeros(len(traces[i].y), bool)
        for _, part in (h for h in held[_SECOND::_EVERY] if h[0] == i):
            mask[part] = True
        fitted[i] = replace(trace, weight=np.where(mask, 0.0, trace.weight))
        aside.append(replace(fitted[i], judged=trace.judged & mask))
    return fitted, [*deciding, *aside]


def _has_steps(trace: Trace, least: float) -> bool:
    return bool(np.any(np.abs(np.diff(trace.drive.voltage)) > least))


def _after_steps(trace: Trace, least: float) -> list[slice]:
    """Return the samples from each step to the next one, behind the lead-in."""
    voltage = trace.drive.voltage
    steps = np.flatnonzero(np.abs(np.diff(voltage)) > least) + 1
    ends = np.append(steps, len(voltage))[1:]
    return [slice(a, b) for a, b in zip(steps, ends, strict=True) if a >= trace.lead]
