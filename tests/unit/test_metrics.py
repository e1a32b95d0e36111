"""Figures of merit (24) and (25)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from it2hys.errors import InputError
from it2hys.records.figures_of_merit import max_relative_error, rms_error


def test_values_worked_out_by_hand():
    y, y_hat = [0.0, 1.0, 4.0, 2.0], [0.0, 1.0, 3.0, 4.0]
    assert max_relative_error(y, y_hat) == 0.5
    assert rms_error(y, y_hat) == pytest.approx(np.sqrt(5.0 / 4.0), rel=1e-15)


@given(st.floats(-1e3, 1e3), st.floats(1e-3, 1e3))
def test_relative_error_keeps_under_a_change_of_unit_and_rms_scales(offset, scale):
    rng = np.random.default_rng(1)
    y, y_hat = rng.normal(size=(2, 40))
    moved, moved_hat = offset + scale * y, offset + scale * y_hat
    assert max_relative_error(moved, moved_hat) == pytest.approx(max_relative_error(y, y_hat), rel=1e-6)
    assert rms_error(moved, moved_hat) == pytest.approx(scale * rms_error(y, y_hat), rel=1e-6)


@pytest.mark.parametrize("metric", [max_relative_error, rms_error])
@pytest.mark.parametrize(
    ("y", "y_hat", "phrase"),
    [
        ([1.0, 2.0], [1.0, 2.0, 3.0], r"shape \(2,\), the model output \(3,\)"),
        ([[1.0], [2.0]], [1.0, 2.0], r"shape \(2, 1\), the model output \(2,\)"),
        ([], [], "no samples to compare"),
        ([1.0, np.nan], [1.0, 2.0], "the measured output is not finite, first at sample 1"),
        ([1.0, 2.0], [-np.inf, 2.0], "the model output is not finite, first at sample 0"),
    ],
)
def test_what_cannot_be_compared_is_refused(metric, y, y_hat, phrase):
    with pytest.raises(InputError, match=phrase):
        metric(y, y_hat)


def test_relative_error_of_a_constant_measurement_is_undefined():
    with pytest.raises(InputError, match="e_mr is undefined"):
        max_relative_error([2.0, 2.0], [1.0, 2.0])
    assert rms_error([2.0, 2.0], [1.0, 1.0]) == 1.0
