"""Beyond the ends of its range the core is its linearisation there, in C as in CasADi."""

import casadi as ca
import casadi_core
import numpy as np
import pytest
from conftest import UM, make_set
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from it2hys.errors import InputError
from it2hys.model import compiled, it2
from it2hys.model.chain import Chain
from it2hys.model.parameters import ParameterSet, table_1

MICRO = np.array([1e6, 1e6, 1e6, 1.0, 1e6, 1e6])
#: Table 1 in um and V, as printed, and its range.
TABLE_1, LIMITS = table_1().rules * MICRO, (0.0, 16.0)
BEYOND = [-64.0, -10.0, -1e-9, 0.0, 5.0, 16.0, 16.0 + 1e-9, 20.0, 80.0]
VOLTAGES = [-2000.0, -20.0, 61.3, 110.38, 150.0, 2000.0]


@pytest.mark.parametrize("rules", [TABLE_1, make_set(4, 6).rules * MICRO], ids=["table_1", "six_rules"])
@pytest.mark.parametrize("y_previous", BEYOND)
def test_casadi_and_c_agree_beyond_both_ends(rules, y_previous):
    step, inverse = (
        casadi_core.step_function(len(rules), LIMITS),
        casadi_core.inverse_function(len(rules), LIMITS),
    )
    by_casadi = casadi_core.gradient_function(len(rules), LIMITS)
    for x in VOLTAGES:
        y, by_rules, (by_x, by_y, _) = compiled.gradient(rules, y_previous, x, LIMITS)
        assert y == compiled.one_step(rules, y_previous, x, LIMITS)
        # of terms as large as 0.03 um/V times the voltage
        assert float(step(rules, y_previous, x)) == pytest.approx(y, rel=1e-12, abs=1e-12)
        expected = [derivative.full() for derivative in by_casadi(rules, y_previous, x)]
        np.testing.assert_allclose(
            by_rules, expected[0], rtol=1e-10, atol=1e-12 * np.abs(by_rules).max()
        )
        assert [by_x, by_y] == pytest.approx([v.item() for v in expected[1:]], rel=1e-12)
        back = float(compiled.solve(rules, y_previous, y, LIMITS))
        assert back == pytest.approx(x, rel=1e-11, abs=1e-9)
        assert float(inverse(rules, y_previous, y)) == pytest.approx(back, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("y_previous", [-30.0, 50.0])
def test_derivative_by_the_end_of_the_range_is_casadis(y_previous):
    end, x = ca.SX.sym("end"), 170.0
    limits = (end, LIMITS[1]) if y_previous < 0 else (LIMITS[0], end)
    y = it2.step_expression(ca.DM(TABLE_1), ca.SX(y_previous), ca.SX(x), limits)
    expected = float(ca.Function("by_end", [end], [ca.gradient(y, end)])(LIMITS[y_previous > 0]))
    assert compiled.gradient(TABLE_1, y_previous, x, LIMITS)[2][2] == pytest.approx(expected, rel=1e-10)


def test_within_the_range_limits_change_no_bit():
    y, x = np.random.default_rng(0).uniform([[0.0], [-500.0]], [[16.0], [500.0]], (2, 1000))
    assert (
        compiled.one_step(TABLE_1, y, x, LIMITS).tobytes() == compiled.one_step(TABLE_1, y, x).tobytes()
    )
    assert compiled.solve(TABLE_1, y, x, LIMITS).tobytes() == compiled.solve(TABLE_1, y, x).tobytes()


def test_constant_voltage_beyond_what_table_1_holds_for_settles():
    """(10) itself runs away above 122.22 V, which is below what the amplifier can give."""
    assert abs(compiled.free_run(TABLE_1, np.full(3000, 125.0), 0.0)[-1]) > 1e6
    for voltage, y in ((130.0, 18.02), (150.0, 20.08), (2000.0, 210.61), (-2000.0, -395.9)):
        run = compiled.free_run(TABLE_1, np.full(3000, voltage), 0.0, LIMITS)
        assert run[-1] == pytest.approx(y, rel=1e-3)
        assert run[-1] == pytest.approx(run[-2], abs=1e-12)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.booleans())
def test_chains_in_casadi_and_c_agree_beyond(seed, count, above):
    parameters = make_set(seed, count, initialDisplacement=40 * UM if above else -30 * UM)
    voltage = np.random.default_rng(seed).uniform(-300.0, 300.0, 60)
    in_c = compiled.chain_free_run(parameters, voltage)
    for ours, theirs in zip(in_c, Chain(parameters).free_run(voltage), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-12 * np.ptp(theirs))


#: Voltages in V: within the type's limits, or twice voltageMax.
MODEST = st.floats(-2 * 110.0, 2 * 110.0)
ANY = st.floats(-2000.0, 2000.0)


def accepted(start: float) -> ParameterSet:
    parameters = table_1().replace(initialDisplacement=start)
    try:
        return parameters.validate()
    except InputError as refused:
        assert "initialDisplacement" in str(refused)
        assert not -64 * UM <= start <= 80 * UM
        assume(False)


@settings(max_examples=40)
@given(
    start=st.floats(-0.1, 0.1) | st.floats(-64 * UM, 80 * UM),
    seed=st.integers(0, 2**32 - 1),
    held=st.sampled_from([1, 500]),
    constant=st.booleans(),
    modest=st.booleans(),
    data=st.data(),
)
def test_the_plant_stays_put_whatever_is_asked_of_it(start, seed, held, constant, modest, data):
    """Ten seconds from any start that is accepted."""
    parameters, ticks = accepted(start), 100_000
    drawn = data.draw(MODEST if modest else ANY)
    limit = abs(drawn)
    steps = np.random.default_rng(seed).uniform(-limit, limit, ticks // held)
    voltage = np.full(ticks, drawn) if constant else np.repeat(steps, held)
    displacement, measured = compiled.chain_free_run(parameters, voltage)
    assert np.isfinite(displacement).all()
    ranges = np.abs(displacement).max() / (16 * UM)
    assert ranges < (5.0 + 1e-9 if modest else 25.0)
    assert displacement.tobytes() == measured.tobytes()
    outside = compiled.chain_out_of_range(parameters, voltage)
    assert outside[(voltage < -1e-6) | (voltage > 110.0 + 1e-6)].all()


@settings(max_examples=60)
@given(
    start=st.floats(-64 * UM, 80 * UM),
    references=st.lists(
        st.floats(0.0, 16 * UM) | st.sampled_from([0.0, 16 * UM, -1 * UM, 17 * UM]),
        min_size=20,
        max_size=60,
    ),
    pause=st.integers(1, 5),
)
def test_the_plant_follows_wherever_the_inverse_is_not_saturated(start, references, pause):
    parameters = table_1().replace(initialDisplacement=start).validate()
    reference = np.repeat(references, pause)
    beyond = (reference < 0.0) | (reference > 16 * UM)
    voltage, saturated = compiled.chain_inverse_run(parameters, reference)
    displacement, _ = compiled.chain_free_run(parameters, voltage)
    assert saturated[beyond].all()
    assert (voltage >= 0.0).all() and (voltage <= 110.0).all()
    met = ~saturated
    # where it is not met, the reference is beyond its range or the voltage at an end of its own
    assert (met | beyond | np.isin(voltage, (0.0, 110.0))).all()
    np.testing.assert_allclose(displacement[met], reference[met], rtol=0, atol=1e-15)
    # with as much voltage as it asks for, it is saturated nowhere else, and there at the nearest end
    parameters = {**parameters, "voltageMin": -1e9, "voltageMax": 1e9}
    voltage, saturated = compiled.chain_inverse_run(parameters, reference)
    displacement, _ = compiled.chain_free_run(parameters, voltage)
    assert (saturated == beyond).all()
    np.testing.assert_allclose(displacement, np.clip(reference, 0.0, 16 * UM), rtol=0, atol=1e-15)


def test_a_start_in_another_unit_is_refused():
    for start in (50.0, 0.05, 1e-4):
        parameters = {**table_1(), "initialDisplacement": start}
        assert "initialDisplacement" in compiled.chain_check(parameters)
    assert compiled.chain_check({**table_1(), "initialDisplacement": 50e-6}) is None
