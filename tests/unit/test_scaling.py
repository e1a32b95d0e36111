"""Maps of rules that keep what a core does."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from it2hys.identification.scaling import resampled
from it2hys.model import compiled

CENTRE = [4e-6, 8e-6, 5e-6]
LIMITS = (-np.inf, np.inf)


@given(
    slope=st.floats(0.01, 0.999) | st.floats(1.001, 1.2) | st.just(1.0),
    ratio=st.sampled_from([2, 3, 8]),
    x=st.floats(-100.0, 100.0),
)
def test_a_rule_goes_in_one_long_sample_where_it_goes_in_short_ones(slope, ratio, x):
    rule = np.array([[*CENTRE, slope, 1e-7, 1e-6]])
    short = long = np.array([2e-6])
    for _ in range(ratio):
        short = compiled.one_step(rule, short, np.array([x]), LIMITS)
    long = compiled.one_step(resampled(rule, ratio), long, np.array([x]), LIMITS)
    np.testing.assert_allclose(long, short, rtol=1e-9, atol=1e-16)
    np.testing.assert_allclose(resampled(resampled(rule, ratio), 1.0 / ratio), rule, rtol=1e-9)


@pytest.mark.parametrize("slope", [0.0, -0.4])
def test_a_rule_that_alternates_answers_at_once(slope):
    rule = np.array([[*CENTRE, slope, 1e-7, 1e-6]])
    (found,) = resampled(rule, 2.0)
    assert found[3] == pytest.approx(0.0, abs=1e-300)
    np.testing.assert_allclose(found[4:], rule[0, 4:])
