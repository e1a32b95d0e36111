"""The IT2 core: CasADi, the C core and finite or complex steps give the same numbers."""

import casadi_core
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from it2hys.model import compiled, it2
from it2hys.model.parameters import table_1
from it2hys.stand import excitations

MICRO = np.array([1e6, 1e6, 1e6, 1.0, 1e6, 1e6])
#: Table 1 in um and V, as printed.
TABLE_1 = table_1().rules * MICRO
SAMPLES = 4000


def identification_voltage() -> np.ndarray:
    """Return the voltage (22) at the ticks 0 .. 3999 of 0.1 ms."""
    return excitations.identification(np.arange(SAMPLES) * 1e-4)


def complex_step(rules: np.ndarray, y_previous: complex, x: complex) -> complex:
    """Evaluate (10) as printed, without scaling, for complex arguments."""
    s1, s2, c, q1, q2, q3 = rules.T
    weight = np.exp(-((y_previous - c) ** 2) / (2 * s1**2))
    weight = weight + np.exp(-((y_previous - c) ** 2) / (2 * s2**2))
    return np.sum((q1 * y_previous + q2 * x + q3) * weight) / np.sum(weight)


def test_table_1_under_the_identification_signal_gives_the_published_range():
    y = compiled.free_run(TABLE_1, identification_voltage()[1:], 0.0)
    assert y[0] == pytest.approx(0.0545671, abs=1e-7)
    assert y[-800:].min() == pytest.approx(0.842742, abs=5e-7)
    assert y[-800:].max() == pytest.approx(15.310268, abs=5e-7)


def test_casadi_and_c_free_runs_agree_at_every_tick():
    x = identification_voltage()[1:]
    by_casadi = casadi_core.free_run_function(3, len(x))(0.0, x, TABLE_1).full().ravel()
    np.testing.assert_allclose(by_casadi, compiled.free_run(TABLE_1, x, 0.0), rtol=1e-12)


@pytest.mark.parametrize("y_previous", [-1e4, -300.0, -40.0, 0.0, 3.7, 16.0, 60.0, 500.0, 1e5])
def test_casadi_and_c_agree_near_and_far_from_the_centres(y_previous):
    step, inverse = casadi_core.step_function(3), casadi_core.inverse_function(3)
    for x in (-20.0, 0.0, 61.3, 150.0):
        expected = compiled.one_step(TABLE_1, y_previous, x)
        assert np.isfinite(expected)
        assert float(step(TABLE_1, y_previous, x)) == pytest.approx(float(expected), rel=1e-12)
    expected = compiled.solve(TABLE_1, y_previous, 5.0)
    assert float(inverse(TABLE_1, y_previous, 5.0)) == pytest.approx(float(expected), rel=1e-12)


def test_gradients_of_c_casadi_and_complex_step_agree():
    y_previous, x, h = 7.3, 48.0, 1e-30
    _, by_rules, (by_x, by_y, _) = compiled.gradient(TABLE_1, y_previous, x)
    casadi = casadi_core.gradient_function(3)(TABLE_1, y_previous, x)
    np.testing.assert_allclose(casadi[0].full(), by_rules, rtol=1e-11, atol=1e-15)
    np.testing.assert_allclose([float(casadi[1]), float(casadi[2])], [by_x, by_y], rtol=1e-11)
    for index in np.ndindex(3, 6):
        moved = TABLE_1.astype(complex)
        moved[index] += 1j * h
        derivative = complex_step(moved, y_previous, x).imag / h
        assert by_rules[index] == pytest.approx(derivative, rel=1e-11, abs=1e-15)
    assert by_x == pytest.approx(complex_step(TABLE_1, y_previous, x + 1j * h).imag / h, rel=1e-12)
    assert by_y == pytest.approx(complex_step(TABLE_1, y_previous + 1j * h, x).imag / h, rel=1e-11)


def test_usability_values_are_the_partial_derivatives_at_the_band_and_at_equilibrium():
    y = np.linspace(0.0, 16.0, 257)
    band = (y, 5.0 * y - 10.0, 5.0 * y + 20.0)
    values = it2.usability_function(3, 257)(TABLE_1, *(part[None] for part in band)).full()
    assert np.max(values[0]) == pytest.approx(compiled.contraction(TABLE_1, 0.0, 16.0), rel=1e-12)
    for i in (0, 100, 256):
        for row, x in ((1, band[1][i]), (2, band[2][i])):
            by_x, by_y, _ = compiled.gradient(TABLE_1, y[i], x)[2]
            np.testing.assert_allclose(values[[row, 3], i], [by_y, by_x], rtol=1e-11)


def test_usability_derivatives_agree_with_finite_differences():
    y = np.linspace(0.0, 16.0, 5)[None]
    grid = (y, 5.0 * y - 10.0, 5.0 * y + 20.0)
    function = it2.usability_function(3, 5)
    by_rules = it2.usability_jacobian(3, 5)(TABLE_1, *grid).full().reshape(4, 5, 6, 3)
    for rule, column in np.ndindex(3, 6):
        step = np.zeros((3, 6))
        step[rule, column] = 1e-5
        above, below = (function(TABLE_1 + s, *grid).full() for s in (step, -step))
        np.testing.assert_allclose(by_rules[:, :, column, rule], (above - below) / 2e-5, atol=1e-6)


@settings(max_examples=50, deadline=None)
@given(
    y_previous=st.floats(-30.0, 40.0),
    x=st.floats(-50.0, 150.0),
    scale=st.floats(0.2, 5.0),
    shift=st.floats(-100.0, 100.0),
)
def test_inverse_undoes_the_step_for_varied_rules(y_previous, x, scale, shift):
    rules = TABLE_1 * [scale, scale, scale, 1.0, 1.0, 1.0] + [0, 0, shift, 0, 0, 0]
    y = casadi_core.step_function(3)(rules, y_previous, x)
    # y is much larger than q2 x, so that x comes back with fewer digits than y holds
    assert float(casadi_core.inverse_function(3)(rules, y_previous, y)) == pytest.approx(x, abs=1e-9)
