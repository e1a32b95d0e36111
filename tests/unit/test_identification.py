"""The identifier: scaling, gradients, estimators, recovery of Table 1, honesty."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from it2hys import core, excitations
from it2hys.errors import InputError
from it2hys.identification import Identification, Options, identify
from it2hys.identification.coordinates import to_coordinates, to_rules
from it2hys.identification.criteria import FreeRun, OneStep, Series
from it2hys.identification.estimators import METHODS, CostCallback, cost, gradient, minimise
from it2hys.identification.noise import estimate_noise, find_period
from it2hys.identification.scaling import Scaling
from it2hys.identification.transient import transient_length
from it2hys.identification.uncertainty import correlation_time
from it2hys.identification.usability import Guard
from it2hys.identification.variable_projection import ProjectedOneStep
from it2hys.parameters import table_1
from it2hys.records import Record

TABLE_1 = table_1().rules
TS = 1e-4
NOISE = 6e-9


def time(samples: int) -> np.ndarray:
    """Return the ticks' times in s."""
    return np.arange(samples) * TS


def record(name: str, voltage: np.ndarray, noise: float = 0.0, seed: int = 0, **changes) -> Record:
    """Return a record made by Table 1 from rest."""
    y = core.free_run(TABLE_1, voltage, 0.0)
    y = y + noise * np.random.default_rng(seed).standard_normal(len(y))
    return Record(name, time(len(y)), voltage, y, TS, **changes)


def training_voltages(samples: int) -> list[np.ndarray]:
    """Return four drives of different amplitude and frequency."""
    t = time(samples)
    return [
        excitations.identification(t),
        excitations.validation_sine(t, 20.0),
        0.6 * excitations.validation_sine(t, 40.0) + 20.0,
        52.5 + 105.0 / np.pi * np.arcsin(np.sin(2 * np.pi * 25 * t - np.pi / 2)),
    ]


def test_voltages(samples: int) -> list[np.ndarray]:
    """Return two drives that no record is trained on."""
    t = time(samples)
    walk = np.cumsum(np.random.default_rng(5).standard_normal(samples)) * 3.0 + 50.0
    return [excitations.sum_100_50(t), np.clip(walk, 0.0, 105.0)]


test_voltages.__test__ = False


def small_series(samples: int = 300, noise: float = 0.0) -> tuple[list[Series], Scaling]:
    """Return two scaled series of different length, the second with an offset."""
    records = [
        record("a", training_voltages(samples)[0], noise),
        record("b", training_voltages(samples - 50)[1], noise, seed=1),
    ]
    scaling = Scaling.of_data(
        np.concatenate([r.displacement for r in records]),
        np.concatenate([r.voltage for r in records]),
    )
    series = []
    for r in records:
        weight = np.ones(len(r))
        weight[20:25] = 0.0
        y = scaling.y(r.displacement)
        series.append(Series(scaling.x(r.voltage), y, weight, float(y[0])))
    series[1] = replace(series[1], y=series[1].y + 0.1, has_offset=True, offset=0.08)
    return series, scaling


def perturbed(criterion: FreeRun, scaling: Scaling, size: float = 0.02) -> np.ndarray:
    """Return coordinates near the truth."""
    point = criterion.pack(scaling.rules(TABLE_1))
    return point + size * np.random.default_rng(2).standard_normal(len(point))


def criteria(series: list[Series]) -> list[FreeRun]:
    """Return every kind of criterion."""
    return [FreeRun(series, 3), OneStep(series, 3), FreeRun(series, 3, horizon=40)]


# --- scaling -------------------------------------------------------------------------------------


@settings(max_examples=30, deadline=None)
@given(
    y_centre=st.floats(-1e-4, 1e-4),
    y_unit=st.floats(1e-6, 1e-4),
    x_centre=st.floats(-100.0, 100.0),
    x_unit=st.floats(1.0, 100.0),
)
def test_scaled_and_unscaled_free_runs_agree(y_centre, y_unit, x_centre, x_unit):
    scaling = Scaling(y_centre, y_unit, x_centre, x_unit)
    voltage = training_voltages(400)[0]
    expected = core.free_run(TABLE_1, voltage, 1e-6)
    scaled = core.free_run(scaling.rules(TABLE_1), scaling.x(voltage), scaling.y(1e-6))
    tolerance = 1e-12 * (abs(y_centre) + y_unit + np.abs(expected).max())
    # the recursion amplifies rounding by 1 / (1 - contraction)
    np.testing.assert_allclose(scaling.displacement(scaled), expected, rtol=0, atol=50 * tolerance)


def test_rules_survive_scaling_and_coordinates():
    scaling = Scaling(-9e-5, 2.2e-5, 1.8, 1.8)
    back = scaling.physical_rules(scaling.rules(TABLE_1))
    np.testing.assert_allclose(back, TABLE_1, rtol=1e-12, atol=1e-18)
    scaled = Scaling(8e-6, 8e-6, 52.5, 52.5).rules(TABLE_1)
    np.testing.assert_allclose(to_rules(to_coordinates(scaled)), scaled, rtol=1e-14)


def test_jacobian_of_the_scaling_is_its_derivative():
    scaling = Scaling(-9e-5, 2.2e-5, 1.8, 1.8)
    scaled = np.arange(1.0, 13.0).reshape(2, 6)
    change = np.cos(np.arange(12.0))
    moved = scaling.physical_rules(scaled + change.reshape(2, 6)) - scaling.physical_rules(scaled)
    np.testing.assert_allclose(scaling.rule_jacobian(scaled) @ change, moved.ravel(), rtol=1e-9)


# --- gradients -----------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", range(3), ids=["free run", "one step", "horizon"])
def test_gradient_of_each_criterion_agrees_with_finite_differences(kind):
    series, scaling = small_series()
    criterion = criteria(series)[kind].with_guard(Guard(3, -1.2, 2.0, 3.0))
    point = perturbed(criterion, scaling)
    assert np.any(Guard(3, -1.2, 2.0, 3.0).residual(criterion.rules(point)) > 0.0)
    exact = gradient(criterion, point)
    h = 1e-6
    numeric = [
        (cost(criterion, point + h * e) - cost(criterion, point - h * e)) / (2 * h)
        for e in np.eye(len(point))
    ]
    np.testing.assert_allclose(exact, numeric, atol=2e-6 * np.abs(exact).max())
    jacobian, residual = criterion.jacobian(point)
    np.testing.assert_allclose(jacobian.T @ residual, exact, atol=1e-10 * np.abs(exact).max())


def test_one_step_is_the_free_run_with_a_horizon_of_one():
    series, scaling = small_series()
    one, run = OneStep(series, 3), FreeRun(series, 3, horizon=1)
    point = perturbed(one, scaling)
    np.testing.assert_allclose(one.residual(point), run.residual(point), rtol=0, atol=1e-12)


def test_projected_gradient_agrees_with_finite_differences():
    series, _ = small_series(noise=NOISE)
    s = series[0]
    group = np.where(np.arange(len(s.x) - 1) < 100, 0, -1)
    problem = ProjectedOneStep(s.y[:-1], s.x[1:], s.y[1:], np.ones(len(s.x) - 1), group, 2)
    point = np.array([-0.5, 1.0, -0.6, -0.4, 0.7, 0.5, 0.05])

    def value(at: np.ndarray) -> float:
        residual = problem.residual(at)
        return 0.5 * residual @ residual

    # Kaufman's Jacobian gives the exact gradient: what it leaves out is orthogonal to the residual.
    factor, target = problem.linearise(point)
    exact = factor.T @ target
    numeric = [(value(point + 1e-6 * e) - value(point - 1e-6 * e)) / 2e-6 for e in np.eye(7)]
    np.testing.assert_allclose(exact, numeric, atol=1e-5 * np.abs(exact).max())


def test_casadi_callback_gives_the_cost_and_gradient_of_the_c_core():
    series, scaling = small_series()
    criterion = FreeRun(series, 3)
    point = perturbed(criterion, scaling)
    function = CostCallback(criterion)
    assert float(function(point)) == cost(criterion, point)
    jacobian = function.jacobian()(point, 0.0).full().ravel()
    np.testing.assert_array_equal(jacobian, gradient(criterion, point))


# --- estimators ----------------------------------------------------------------------------------


def one_rule_problem(kind: type[FreeRun]) -> tuple[FreeRun, np.ndarray]:
    """Return a problem that is linear in all it determines, and a start: L = 1 has one optimum."""
    rules = np.array([[0.8, 1.6, 0.2, 0.7, 0.25, 0.05]])
    x = np.sin(np.arange(250) * 0.1) + 0.3 * np.sin(np.arange(250) * 0.31)
    y = core.free_run(rules, x, 0.1) + 0.003 * np.random.default_rng(0).standard_normal(250)
    criterion = kind([Series(x, y, np.ones(250), 0.1)], 1)
    start = criterion.pack(rules * [1, 1, 1, 0.97, 1.04, 0.9])
    return criterion, start


@pytest.mark.parametrize("kind", [FreeRun, OneStep])
@pytest.mark.parametrize("method", METHODS)
def test_every_estimator_finds_the_optimum_of_a_second_method(kind, method):
    criterion, start = one_rule_problem(kind)
    other = "levenberg-marquardt" if method == "trust-region" else "trust-region"
    expected = minimise(criterion, start, other).cost
    iterations = {"gradient-descent": 5000, "evolution": 400}.get(method, 300)
    found = minimise(criterion, start, method, max_iterations=iterations, tolerance=1e-8)
    assert found.cost == pytest.approx(expected, rel=0.02 if method == "evolution" else 1e-3)
    assert found.cost == pytest.approx(cost(criterion, found.coordinates))


def test_an_unknown_estimator_is_refused():
    criterion, start = one_rule_problem(FreeRun)
    with pytest.raises(InputError, match="unknown estimator 'magic'"):
        minimise(criterion, start, "magic")


def test_a_diverging_start_is_told_and_not_fatal():
    criterion, start = one_rule_problem(FreeRun)
    start[3] = 3.0  # q1
    found = minimise(criterion, start)
    assert not found.converged
    assert "diverges" in found.message


# --- recovery of Table 1 -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def noisy() -> Identification:
    """Return the identification of four records with 6 nm noise, L given."""
    train = [record(f"r{i}", x, NOISE, i) for i, x in enumerate(training_voltages(1500))]
    test = [record(f"t{i}", x, NOISE, 9 + i) for i, x in enumerate(test_voltages(1500))]
    return identify(train, test=test, rules=3)


def test_noise_free_data_of_table_1_are_reproduced_on_records_not_fitted():
    train = [record(f"r{i}", x) for i, x in enumerate(training_voltages(900))]
    found = identify(train, rules=3)
    assert found.converged
    for voltage in test_voltages(1500):
        run = core.free_run(found.parameters.rules, voltage, 0.0)
        np.testing.assert_allclose(run, core.free_run(TABLE_1, voltage, 0.0), rtol=0, atol=1e-12)


def test_held_out_error_with_noise_is_within_five_per_cent_of_the_noise(noisy):
    assert noisy.converged
    for result in noisy.by_role("test"):
        assert result.e_rms < 1.05 * NOISE
    assert noisy.error_over_noise == pytest.approx(1.0, abs=0.1)
    assert not any("lacks something" in text for text in noisy.warnings)


def test_offsets_are_not_invented_and_every_result_can_be_simulated_again(noisy):
    voltages = [*training_voltages(1500), *test_voltages(1500)]
    for result, voltage in zip(noisy.records, voltages, strict=True):
        assert result.offset == 0.0
        run = core.free_run(noisy.parameters.rules, voltage, result.initial_displacement)
        np.testing.assert_array_equal(run, result.y_free)


def test_the_model_is_usable_over_the_data_and_a_margin(noisy):
    noisy.parameters.validate()
    low, high = noisy.parameters.displacement_range
    assert low < 0.0
    assert high > 15.3e-6
    assert noisy.contraction < 1.0


def test_intervals_cover_and_undetermined_parameters_are_named(noisy):
    assert set(noisy.intervals) == {
        "initialDisplacement",
        *(n for n in noisy.parameters if n.startswith("rule[")),
    }
    low, high = noisy.intervals["initialDisplacement"]
    assert low < noisy.parameters["initialDisplacement"] < high
    assert high - low < 20 * NOISE
    assert noisy.condition > 1.0
    assert set(noisy.undetermined) <= set(noisy.intervals)


def test_several_starts_are_reported_with_their_errors(noisy):
    errors = [start.free_run_rms for start in noisy.starts]
    assert len(errors) >= 3
    assert errors == sorted(errors)


def test_the_number_of_rules_is_chosen_by_prediction():
    two = TABLE_1[[0, 2]]
    records = []
    for i, x in enumerate(training_voltages(800)[:2]):
        y = core.free_run(two, x, 0.0) + NOISE * np.random.default_rng(i).standard_normal(800)
        records.append(Record(f"r{i}", time(800), x, y, TS))
    found = identify(records, options=Options(max_rules=3, starts=24))
    assert found.parameters["ruleCount"] == 2
    assert [trial.rules for trial in found.orders][:3] == [1, 2, 3]


def test_an_offset_between_sittings_is_found_and_an_outlier_does_no_harm():
    voltages = training_voltages(1000)
    first, second = record("a", voltages[0], NOISE), record("b", voltages[1], NOISE, 1)
    spoilt = second.displacement + 2e-6
    spoilt[400] += 5e-6
    mask = np.zeros(1000, dtype=bool)
    mask[400] = True
    second = replace(second, displacement=spoilt, outliers=mask)
    found = identify([first, second], rules=3)
    assert found.by_role("train")[1].offset == pytest.approx(2e-6, abs=2e-8)
    assert found.by_role("train")[1].e_rms < 1.1 * NOISE


def test_a_start_up_transient_is_left_out():
    t = time(2000)
    first = record("a", 52.5 + 52.5 * np.sin(2 * np.pi * 50 * t), NOISE)
    lead = 20e-6 * np.exp(-np.arange(2000) / 20.0)
    found = identify([replace(first, displacement=first.displacement + lead)], rules=2)
    result = found.records[0]
    assert 100 <= result.skip <= 250
    assert result.e_rms < 5 * NOISE


# --- honesty -------------------------------------------------------------------------------------


def test_one_amplitude_at_one_frequency_is_warned_of():
    single = record("single", excitations.validation_sine(time(1000), 20.0), NOISE)
    found = identify([single], rules=1)
    assert any("one amplitude at one frequency" in text for text in found.warnings)
    assert any("lacks something" in text for text in found.warnings)


def test_a_test_record_beyond_the_training_range_is_warned_of():
    t = time(600)
    train = record("train", 0.5 * excitations.identification(t), NOISE)
    test = record("wide", excitations.identification(t), NOISE)
    found = identify([train], test=[test], rules=2)
    assert any("'wide' spans" in text for text in found.warnings)


def test_records_of_different_sample_times_are_refused():
    first = record("a", training_voltages(200)[0])
    second = replace(first, name="b", sample_time=2e-4)
    with pytest.raises(InputError, match=r"'b' is sampled every 0\.0002 s"):
        identify([first, second], rules=1)


def test_no_records_are_refused():
    with pytest.raises(InputError, match="no training record"):
        identify([])


def test_a_fit_that_is_stopped_says_that_it_has_not_converged():
    train = record("a", training_voltages(600)[0], NOISE)
    found = identify([train], rules=3, options=Options(starts=4, refined=1, max_iterations=2))
    assert not found.converged
    assert "limit of iterations" in found.message


# --- parts ---------------------------------------------------------------------------------------


def test_noise_from_periods_ignores_drift_and_from_differences_ignores_motion():
    rng = np.random.default_rng(0)
    x = np.sin(2 * np.pi * np.arange(4000) / 200)
    noise = 0.01 * rng.standard_normal(4000)
    by_periods = estimate_noise(x, x + 1e-4 * np.arange(4000) + noise)
    assert by_periods.rms == pytest.approx(0.01, rel=0.1)
    assert "200 samples" in by_periods.method
    chirp = np.sin(1e-5 * np.arange(4000) ** 2)
    assert find_period(chirp) is None
    assert estimate_noise(chirp, chirp + noise).rms == pytest.approx(0.01, rel=0.1)


def test_a_transient_is_seen_only_where_the_start_lies_off_the_loops():
    x = np.sin(2 * np.pi * np.arange(2000) / 200)
    y = x.copy()
    assert transient_length(x, y) == 0
    y[:5] -= 1.0
    assert 130 <= transient_length(x, y) <= 150


def test_correlation_time_of_white_noise_and_of_a_first_order_process():
    rng = np.random.default_rng(0)
    white = rng.standard_normal(20_000)
    assert correlation_time(white) == pytest.approx(1.0, abs=0.1)
    coloured = np.zeros_like(white)
    for k in range(1, len(white)):
        coloured[k] = 0.9 * coloured[k - 1] + white[k]
    assert correlation_time(coloured) == pytest.approx(19.0, rel=0.3)
