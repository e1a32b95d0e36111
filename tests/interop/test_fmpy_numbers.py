"""The FMUs run by FMPy: the model's numbers at every tick, forwards, backwards and both."""

import casadi_core
import numpy as np
import pytest
from conftest import (
    UM,
    Master,
    package_models,
    parameter_sets,
    ticks,
)
from fmpy import fmi2
from hypothesis import given, settings
from hypothesis import strategies as st

from it2hys.model import compiled
from it2hys.model.parameters import table_1
from it2hys.stand.excitations import identification, tracking_reference

WARNING = fmi2.fmi2Warning


def relative(values: np.ndarray, expected: np.ndarray) -> float:
    """Return the largest relative error."""
    return float(np.max(np.abs(values / expected - 1)))


# --- equality of the three models under (22) ---------------------------------------------------


@pytest.fixture(scope="module")
def under_22() -> tuple[np.ndarray, np.ndarray]:
    """x_k of (22) for k = 1..3999 and the C core's y_k from y_0 = 0."""
    x = identification(ticks(4000))[1:]
    return x, compiled.free_run(table_1().rules, x, 0.0)


def test_the_c_core_under_22_gives_the_published_numbers(under_22):
    _, y = under_22
    assert y[0] == pytest.approx(0.0545671 * UM, rel=1e-6)
    assert y[-800:].min() == pytest.approx(0.842742 * UM, rel=1e-6)
    assert y[-800:].max() == pytest.approx(15.310268 * UM, rel=1e-7)


def test_the_fmu_under_22_is_the_c_core_at_every_tick(models, under_22):
    x, y = under_22
    with Master(models["plant"], first_tick=1) as plant:
        assert relative(plant.run(x), y) <= 1e-12
        assert plant.instance.get("measured") == plant.instance.get("displacement")
        assert not plant.instance.said(WARNING)


def test_casadi_under_22_is_the_c_core_at_every_tick(under_22):
    x, y = under_22
    rules = table_1().rules
    step = casadi_core.step_function(len(rules))
    values = [0.0]
    for voltage in x:
        values.append(float(step(rules, values[-1], voltage)))
    assert relative(np.array(values[1:]), y) <= 1e-12


@given(parameter_sets())
@settings(max_examples=15)
def test_a_packaged_set_runs_as_the_c_core(tmp_path_factory, parameters):
    plant = package_models(parameters, tmp_path_factory.mktemp("set"))["plant"]
    x = 30.0 - 30.0 * np.cos(2 * np.pi * np.arange(200) / 100)
    with Master(plant) as master:
        y = master.run(x)
    start, limits = parameters["initialDisplacement"], parameters.displacement_range
    expected = compiled.free_run(parameters.rules, x, start, limits)
    np.testing.assert_allclose(y, expected, rtol=1e-12, atol=1e-12 * np.ptp(expected))


# --- plant and inverse undo each other ---------------------------------------------------------


def test_plant_of_inverse_is_the_identity_on_the_papers_reference(models):
    reference = tracking_reference(ticks(1000))
    with Master(models["inverse"]) as inverse, Master(models["plant"]) as plant:
        reached = []
        for desired in reference:
            reached.append(plant.advance(inverse.advance(desired)))
            assert not inverse.instance.get("saturated")
    assert relative(np.array(reached), reference) <= 1e-9


def test_inverse_of_plant_is_the_identity_on_the_papers_voltages(models):
    reference = tracking_reference(ticks(1000))
    with Master(models["inverse"], {"initialDisplacement": reference[0]}) as inverse:
        voltage = inverse.run(reference)
    start = {"initialDisplacement": reference[0]}
    with Master(models["inverse"], start) as inverse, Master(models["plant"], start) as plant:
        recovered = inverse.run(plant.run(voltage))
    assert relative(recovered, voltage) <= 1e-9


@given(
    parameters=parameter_sets(),
    middle=st.floats(5.0, 11.0),
    swing=st.floats(0.1, 4.5),
    period=st.integers(40, 400),
)
@settings(max_examples=60)
def test_plant_and_inverse_undo_each_other_for_any_usable_set(
    packaged, parameters, middle, swing, period
):
    _, models = packaged["sixteen_rules"]  # the most that an FMU can have, and any number below
    reference = (middle - swing * np.cos(2 * np.pi * np.arange(300) / period)) * UM
    # all of it through FMI; a quick reference asks for much
    wide = {"voltageMin": -2000.0, "voltageMax": 2000.0}
    start = {**parameters, **wide, "initialDisplacement": reference[0]}
    with Master(models["inverse"], start) as inverse:
        voltage = inverse.run(reference)
        assert not inverse.instance.get("saturated")
    with Master(models["plant"], start) as plant:
        reached = plant.run(voltage)
    with Master(models["inverse"], start) as inverse:
        recovered = inverse.run(reached)
    assert relative(reached, reference) <= 1e-9
    np.testing.assert_allclose(recovered, voltage, rtol=1e-9, atol=1e-9 * np.ptp(voltage))


def test_a_reference_out_of_reach_is_clamped_said_and_left_without_wind_up(models):
    reference = np.array([15.0, 15.9, 17.0, 30.0, 17.0, 15.9, 15.0, 15.0]) * UM
    aimed = np.minimum(reference, 16 * UM)
    start = {"initialDisplacement": 15 * UM, "voltageMin": -100.0, "voltageMax": 300.0}
    with Master(models["inverse"], start) as inverse, Master(models["plant"], start) as plant:
        for desired, aim in zip(reference, aimed, strict=True):
            reached = plant.advance(inverse.advance(desired))
            assert bool(inverse.instance.get("saturated")) == (aim != desired)
            assert reached == pytest.approx(aim, rel=1e-9)
        (warning,) = [m for m in inverse.instance.said(WARNING) if "reference" in m]
        assert "saturated" in warning


def test_the_voltage_stays_within_its_range_and_the_plant_follows_where_nothing_else_is_said(models):
    steps = np.repeat([5.0, 15.0, 5.0, 12.0, 2.0], 60) * UM
    start = {"initialDisplacement": 5 * UM, "voltageMin": 1.0, "voltageMax": 95.0}
    limited = 0
    with Master(models["inverse"], start) as inverse, Master(models["plant"], start) as plant:
        for desired in steps:
            voltage = inverse.advance(desired)
            reached = plant.advance(voltage)
            assert 1.0 <= voltage <= 95.0
            limited += inverse.instance.get("saturated")
            if not inverse.instance.get("saturated"):
                assert reached == pytest.approx(desired, rel=1e-12)
        (warning,) = inverse.instance.said(WARNING)
    assert "a voltage outside voltageMin..voltageMax, 1 to 95 V" in warning
    assert 20 < limited < 200


def test_before_the_first_tick_the_inverse_holds_the_plant_where_it_is(models):
    start = {"initialDisplacement": 6 * UM}
    with Master(models["inverse"], start) as inverse, Master(models["plant"], start) as plant:
        assert plant.instance.get("displacement") == 6 * UM
        voltage = inverse.instance.get("voltage")
        np.testing.assert_allclose(plant.run([voltage] * 50), 6 * UM, rtol=1e-12)
