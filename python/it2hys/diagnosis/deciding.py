"""Which records decide what only the training records show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from it2hys.diagnosis.criterion import Trace
from it2hys.diagnosis.records import set_aside

#: A step is a change from one sample to the next of this share of the range of the training voltages.
_STEP = 0.05


def steps_aside(traces: Sequence[Trace], deciding: Sequence[Trace]) -> tuple[list[Trace], list[Trace]]:
    """Return the training and the deciding traces, with parts of the former's steps in the latter.

    Steps alone show ringing, dead time and a slew limit. Where no record that decides has any, what
    those explain of the training records would count for nothing: then parts of the training records
    that step are not fitted, and decide as well.

    Parameters
    ----------
    traces, deciding : sequence of Trace
        Of the training records, and of others that decide.
    """
    low = min(float(t.drive.voltage.min()) for t in traces)
    high = max(float(t.drive.voltage.max()) for t in traces)
    least = _STEP * (high - low)
    if any(_has_steps(t, least) for t in deciding):
        return list(traces), list(deciding)
    fitted, aside = [], []
    for trace in traces:
        parts = set_aside([trace]) if _has_steps(trace, least) else ([trace], [])
        fitted += parts[0]
        aside += [part for part in parts[1] if _steps_where_judged(part, least)]
    return fitted, [*deciding, *aside]


def _has_steps(trace: Trace, least: float) -> bool:
    return bool(np.any(np.abs(np.diff(trace.drive.voltage)) > least))


def _steps_where_judged(trace: Trace, least: float) -> bool:
    return bool(np.any((np.abs(np.diff(trace.drive.voltage)) > least) & trace.judged[1:]))
