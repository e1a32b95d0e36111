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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pair", "seed"),
    [
        pytest.param(("delay", "lag"), 95_000, id="a delay beside which another effect does nothing"),
        pytest.param(("delay", "lag"), 95_001, id="a model that diverges on the new record"),
        pytest.param(("nonlinearity", "play"), 95_005, id="a fit that its penalties led astray"),
        pytest.param(("lag", "resonance"), 95_009, id="a stage that rings over four times its travel"),
    ],
)
def test_a_designed_record_names_what_is_there(pair, seed):
    loop = run_loop(pair, seed, length=1200, compared=False)
    assert loop.failure == ""
    assert loop.designed == (loop.truth,)


def test_a_loop_is_read_as_it_was_written(loop):
    assert Loop.read(loop.line) == loop
