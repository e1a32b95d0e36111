"""The loop closed on one stage of the independent simulator; `make design` closes it on many."""

import pytest
from diagnosis.designed import Loop, run_loop


@pytest.fixture(scope="module")
def loop():
    return run_loop(("delay", "lag"), 90_001, length=1200, compared=False, families=("steps",))


def test_what_the_first_record_left_open_is_named_on_the_designed_one(loop):
    assert loop.failure == ""
    assert loop.was_open and {"delay", "lag"} <= {*loop.first_open}
    assert loop.promised >= 0.9
    assert loop.designed == (loop.truth,) == ("lag",)


def test_a_loop_is_read_as_it_was_written(loop):
    assert Loop.read(loop.line) == loop
