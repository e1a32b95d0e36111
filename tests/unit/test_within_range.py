"""Records that go beyond the voltages that were fitted: where they are judged, and how they begin."""

import numpy as np
import pytest
from conftest import TS

from it2hys.identification.preparation import prepare
from it2hys.identification.traces import to_trace, within
from it2hys.records import Record

FITTED = (0.0, 100.0)


def trace_of(below: int, high: float):
    """Return a record of a line through the origin as a validation trace; it begins below 0 V."""
    voltage = np.concatenate([np.linspace(-30.0, -10.0, below), np.linspace(5.0, high, 1000 - below)])
    displacement = 0.1e-6 * voltage + 1e-9 * np.random.default_rng(3).standard_normal(1000)
    record = Record("own", np.arange(1000) * TS, voltage, displacement, TS)
    return to_trace(prepare(record), "validation", False)


def test_what_is_beyond_is_neither_used_nor_judged():
    trace = trace_of(0, 140.0)
    part = within(trace, FITTED)
    beyond = trace.drive.voltage > 101.0
    assert beyond.any() and not part.weight[beyond].any() and not part.judged[beyond].any()
    assert (part.weight[~beyond] == trace.weight[~beyond]).all()


@pytest.mark.parametrize(("below", "kept"), [(380, True), (120, False)])
def test_a_lead_in_that_is_mostly_beyond_still_tells_how_the_record_begins(below, kept):
    """A line of the mains kept phase 0 on such a record, which was called unexplained for it."""
    trace = trace_of(below, 90.0)
    part = within(trace, FITTED)
    begin = np.arange(1000) < trace.lead
    beyond = begin & (trace.drive.voltage < -1.0) & (trace.weight > 0.0)
    assert beyond.any()
    assert (part.weight[beyond] > 0.0).all() == kept
    assert not part.judged[trace.drive.voltage < -1.0].any()
