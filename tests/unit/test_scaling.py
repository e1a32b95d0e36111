"""Maps of rules that keep what a core does."""

import numpy as np
import pytest
from conftest import UM
from hypothesis import given
from hypothesis import strategies as st

from it2hys.identification.scaling import relaxed
from it2hys.identification.usability import Band, share_of_way
from it2hys.model import compiled
from it2hys.model.parameters import table_1

LIMITS = (-np.inf, np.inf)


@given(share=st.floats(0.01, 8.0), y=st.floats(0.0, 16.0), x=st.floats(0.0, 105.0))
def test_a_core_that_goes_a_share_of_the_way_rests_where_it_did(share, y, x):
    rules, last, voltage = table_1().rules, np.array([y * UM]), np.array([x])
    whole = compiled.one_step(rules, last, voltage, LIMITS) - last
    part = compiled.one_step(relaxed(rules, share), last, voltage, LIMITS) - last
    np.testing.assert_allclose(part, share * whole, rtol=1e-9, atol=1e-12 * UM)


@pytest.mark.parametrize("ratio", [2, 3, 8])
@pytest.mark.parametrize("slope", [0.0, 0.3, 0.9, 0.998])
def test_one_rule_goes_in_a_long_sample_where_it_goes_in_short_ones(slope, ratio):
    rule = np.array([[0.4, 0.8, 0.1, slope, 0.5 * (1.0 - slope), 0.2 * (1.0 - slope)]])
    grid = np.linspace(-1.0, 1.0, 193)
    band = Band(grid, np.full(193, -1.0), np.full(193, 1.0))
    share = share_of_way(rule, band, ratio)
    short = np.array([-0.7])
    long = compiled.one_step(relaxed(rule, share), short, np.array([0.6]), LIMITS)
    for _ in range(ratio):
        short = compiled.one_step(rule, short, np.array([0.6]), LIMITS)
    np.testing.assert_allclose(long, short, rtol=1e-9)
    back = share_of_way(relaxed(rule, share), band, 1.0 / ratio)
    if slope:  # what answers at once tells nothing of how fast
        np.testing.assert_allclose(relaxed(relaxed(rule, share), back), rule, rtol=1e-6)


def test_a_core_with_slopes_of_all_kinds_does_not_alternate_in_long_samples():
    parameters = table_1()
    rules = parameters.rules
    y = np.linspace(0.0, 16.0, 193) * UM
    band = Band(y, np.zeros(193), np.full(193, 105.0))
    assert 1.0 < share_of_way(rules, band, 4.0) <= 4.0
