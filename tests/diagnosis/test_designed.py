"""The loop closed on stages of the independent simulator; `make design` closes it on many.

On the stand's it is closed by `end_to_end/test_next_experiment.py`.
"""

import pytest
from diagnosis.designed import Loop, run_loop


@pytest.mark.gate
def test_what_the_first_record_left_open_is_named_on_the_designed_one():
    loop = run_loop(("delay", "lag"), 90_001, length=1200, compared=False, families=("steps",))
    assert loop.failure == ""
    assert loop.was_open and {"delay", "lag"} <= {*loop.first_open}
    assert loop.promised >= 0.9
    assert loop.designed == (loop.truth,) == ("lag",)
    assert Loop.read(loop.line) == loop


@pytest.mark.gate
def test_a_model_that_diverges_on_the_designed_record_is_no_end_of_it():
    loop = run_loop(("delay", "lag"), 95_001, length=1200, compared=False)
    assert loop.failure == ""
    assert loop.designed == (loop.truth,)
