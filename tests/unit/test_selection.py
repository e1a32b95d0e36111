"""What a better inverse may cost, and which of two models that predict alike is one."""

from types import SimpleNamespace

import numpy as np
import pytest

from it2hys.diagnosis.fitting import Errors
from it2hys.diagnosis.selection import Gains, Node, _follows_noise

GENERATOR = np.random.default_rng(8)


def errors(free, inverse):
    free, inverse = ([scale * GENERATOR.standard_normal(4000)] for scale in (free, inverse))
    return Errors(free, inverse, inverse)


def node(effect, parameters, errors_of):
    common = [SimpleNamespace(name=f"{effect}.{p}") for p in parameters]
    fit = SimpleNamespace(criterion=SimpleNamespace(common=common))
    return Node(frozenset({effect}), fit, errors_of)


@pytest.mark.parametrize(
    ("free", "inverse", "calms"),
    [(1.02, 0.7, True), (1.06, 0.7, False), (1.06, 0.2, True), (1.12, 0.2, False), (0.9, 0.9, False)],
)
def test_the_free_run_may_lose_a_little_each_time_the_inverse_errs_half_as_much(free, inverse, calms):
    state = GENERATOR.bit_generator.state
    before = errors(1.0, 1.0)
    GENERATOR.bit_generator.state = state
    assert Gains.of(before, errors(free, inverse)).calms == calms


def test_a_damped_resonance_that_waits_as_a_delay_does_is_no_rival_of_it():
    delay = node("delay", ["time"], errors(1.0, 1.0))
    resonance = node("resonance", ["frequency", "damping"], errors(1.0, 5.0))
    assert _follows_noise(resonance, delay) and not _follows_noise(delay, resonance)


def test_a_lag_whose_inverse_enlarges_noise_stays_a_rival_of_a_delay():
    """It needs no more parameters: that alone does not make it wrong."""
    delay, lag = (
        node(e, [p], errors(1.0, i)) for e, p, i in (("delay", "time", 1), ("lag", "timeConstant", 5))
    )
    assert not _follows_noise(lag, delay) and not _follows_noise(delay, lag)


def test_a_resonance_with_as_good_an_inverse_stays_a_rival():
    delay = node("delay", ["time"], errors(1.0, 1.0))
    resonance = node("resonance", ["frequency", "damping"], errors(1.0, 1.1))
    assert not _follows_noise(resonance, delay)
