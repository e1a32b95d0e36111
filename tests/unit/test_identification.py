"""The identifier: scaling, gradients, solvers, recovery of Table 1, honesty."""

import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal
from scipy.optimize import lsq_linear

from it2hys.errors import InputError
from it2hys.identification import SOLVERS, Identification, Options, identify
from it2hys.identification.casadi_problem import casadi_problem
from it2hys.identification.coverage import driven_up_to, holds_one_tone
from it2hys.identification.criterion import (
    ChainCriterion,
    ChainFit,
    Trace,
    minimise_from,
    paper_model,
    paper_problem,
)
from it2hys.identification.excerpts import excerpt
from it2hys.identification.inverse import References
from it2hys.identification.levenberg_marquardt import Linearisation, Minimum, levenberg_marquardt
from it2hys.identification.noise import estimate_noise, find_period
from it2hys.identification.one_step import one_step_gradient
from it2hys.identification.order import split
from it2hys.identification.preparation import prepare
from it2hys.identification.rule_coordinates import to_coordinates, to_rules
from it2hys.identification.scaling import Scaling
from it2hys.identification.solvers import cost, gradient, solve
from it2hys.identification.uncertainty import assess, correlation_time
from it2hys.identification.usability import Band, Guard, largest_contraction, usability_values
from it2hys.identification.variable_projection import ProjectedOneStep
from it2hys.model import compiled
from it2hys.model.it2 import usability_function
from it2hys.model.parameters import table_1
from it2hys.records import Record
from it2hys.reports.pair_report import write_report
from it2hys.stand import Stand, excitations

TABLE_1 = table_1().rules
TS = 1e-4
NOISE = 6e-9
#: For tests in which any good optimum will do.
QUICK = Options(starts=6)


def time(samples: int) -> np.ndarray:
    """Return the ticks' times in s."""
    return np.arange(samples) * TS


def record(name: str, voltage: np.ndarray, noise: float = 0.0, seed: int = 0, **changes) -> Record:
    """Return a record made by Table 1 from rest."""
    y = compiled.free_run(TABLE_1, voltage, 0.0)
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


def trace(
    x: np.ndarray, y: np.ndarray, weight: np.ndarray | None = None, has_offset: bool = False
) -> Trace:
    """Return a record as the criterion sees it."""
    weight = np.ones(len(x)) if weight is None else weight
    references = References(y, weight > 0, NOISE, TS)
    drive = compiled.Drive.of(x)
    return Trace("r", "train", drive, y, weight, weight > 0, 0, NOISE, references, has_offset)


def small_problem(samples: int = 300, noise: float = 0.0) -> ChainCriterion:
    """Return the problem of two records of different length, the second with a constant, at Table 1."""
    records = [
        record("a", training_voltages(samples)[0], noise),
        record("b", training_voltages(samples - 50)[1], noise, seed=1),
    ]
    scaling = Scaling.of_data(
        np.concatenate([r.displacement for r in records]),
        np.concatenate([r.voltage for r in records]),
    )
    traces = []
    for i, r in enumerate(records):
        weight = np.ones(len(r))
        weight[20:25] = 0.0
        traces.append(trace(r.voltage, r.displacement + 0.1e-5 * i, weight, has_offset=i > 0))
    model = paper_model(traces, scaling, scaling.rules(TABLE_1), [0.0, 0.8e-6])
    return paper_problem(traces, model, scaling)


def perturbed(criterion: ChainCriterion, size: float = 0.02) -> np.ndarray:
    """Return coordinates near the truth."""
    point = criterion.pack(criterion.model)
    return point + size * np.random.default_rng(2).standard_normal(len(point))


def wide_band() -> Band:
    """Return a band that reaches far beyond the data, so that contraction is violated."""
    y = np.linspace(-1.2, 2.0, 193)
    return Band(y, y - 1.0, y + 1.0)


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
    expected = compiled.free_run(TABLE_1, voltage, 1e-6)
    scaled = compiled.free_run(scaling.rules(TABLE_1), scaling.x(voltage), scaling.y(1e-6))
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


def test_gradient_agrees_with_finite_differences_penalties_included():
    guard = Guard(wide_band(), 3.0)
    criterion = small_problem()
    criterion = criterion.guarded_over(wide_band(), 3.0 / np.sqrt(criterion.samples))
    point = perturbed(criterion)
    assert np.all(np.any(guard.residual(criterion.rules(point)).reshape(4, -1)[:3] > 0.0, axis=1))
    exact = gradient(criterion, point)
    h = 1e-6
    numeric = [
        (cost(criterion, point + h * e) - cost(criterion, point - h * e)) / (2 * h)
        for e in np.eye(len(point))
    ]
    np.testing.assert_allclose(exact, numeric, atol=2e-6 * np.abs(exact).max())
    jacobian, residual = criterion.full_jacobian(point)
    np.testing.assert_allclose(jacobian.T @ residual, exact, atol=1e-10 * np.abs(exact).max())


def test_the_paper_s_model_is_the_chain_with_no_effect_on():
    criterion = small_problem()
    point = perturbed(criterion)
    model = criterion.unpack(point)
    for i, t in enumerate(criterion.traces):
        begin, voltage = model.own["initialDisplacement"][i], t.drive.voltage
        run = compiled.free_run(model.rules, voltage, begin)
        np.testing.assert_array_equal(model.run(t, i)[0], run)
        # alone, the core has a way of its own through the record
        alone, among = (
            compiled.chain_sensitivity(model.packed(i), t.drive, names)[1]
            for names in (["initialDisplacement"], ["initialDisplacement", "hum.phase"])
        )
        np.testing.assert_allclose(among[:, :-1], alone, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("penalty", [-0.2, 0.3])
def test_penalties_of_contraction_and_slope_have_exact_derivatives(penalty):
    rules = np.array([[0.5, 1.0, -0.6, 1.1, penalty, 0.1], [0.4, 0.9, 0.7, 0.7, 0.1, -0.2]])
    guard = Guard(wide_band(), 2.0)
    by_coordinates, residual = guard.linearise(rules)
    assert np.any(residual > 0.0)
    point = to_coordinates(rules)
    numeric = [
        (guard.residual(to_rules(point + h)) - guard.residual(to_rules(point - h))) / 2e-7
        for h in 1e-7 * np.eye(12)
    ]
    # the share of the mean slope below which the slope is penalised is held in the derivative
    contraction = slice(0, 3 * len(wide_band().y))
    np.testing.assert_allclose(
        by_coordinates[contraction],
        np.transpose(numeric)[contraction],
        atol=1e-5 * np.abs(by_coordinates).max(),
    )


def test_threads_that_fit_side_by_side_do_not_disturb_each_other():
    first = np.array([[0.5, 1.0, -0.6, 1.1, 0.3, 0.1], [0.4, 0.9, 0.7, 0.7, 0.1, -0.2]])
    several = [first + np.array([0.0, 0.0, 0.0, 0.02 * i, 0.0, 0.0]) for i in range(4)]
    guard = Guard(wide_band(), 2.0)
    alone = [guard.linearise(rules)[0] for rules in several]

    def disturbed(i):
        return [k for k in range(40) if not np.array_equal(guard.linearise(several[i])[0], alone[i])]

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            assert list(pool.map(disturbed, range(4))) == [[]] * 4
    finally:
        sys.setswitchinterval(interval)


def test_fast_usability_values_are_those_of_casadi():
    rules = Scaling(8e-6, 8e-6, 52.5, 52.5).rules(TABLE_1)
    band = wide_band()
    expected = usability_function(3, len(band.y))(rules, *band.rows).full()
    np.testing.assert_allclose(usability_values(rules, band), expected, rtol=1e-11, atol=1e-13)


def test_bent_steps_follow_a_curved_valley():
    def residual(p: np.ndarray) -> np.ndarray:
        return np.array([100.0 * (p[1] - p[0] ** 2), 1.0 - p[0]])

    def linearise(p: np.ndarray) -> Linearisation:
        jacobian = np.array([[-200.0 * p[0], 100.0], [-1.0, 0.0]])
        return Linearisation(jacobian.T @ jacobian, jacobian.T @ residual(p), lambda v: jacobian.T @ v)

    bound = np.full(2, 5.0)
    found = levenberg_marquardt(residual, linearise, np.array([-1.2, 1.0]), -bound, bound)
    np.testing.assert_allclose(found.coordinates, 1.0, atol=1e-5)
    assert found.iterations < 30


@pytest.mark.parametrize("seed", range(12))
def test_steps_along_bounds_are_as_long_as_the_bounds_allow(seed):
    """A linear problem with bounds, in 12 steps: those that are only cut off there took up to 21.

    When it then ends is a matter of the last digits.
    """
    rng = np.random.default_rng(seed)
    mixed = np.linalg.qr(rng.standard_normal((8, 8)))[0]
    jacobian = rng.standard_normal((40, 8)) @ np.diag(np.geomspace(1.0, 1e-3, 8)) @ mixed
    measured = jacobian @ rng.uniform(-3.0, 3.0, 8) + 0.01 * rng.standard_normal(40)
    bound = np.ones(8)

    def residual(p: np.ndarray) -> np.ndarray:
        return jacobian @ p - measured

    def linearise(p: np.ndarray) -> Linearisation:
        return Linearisation(jacobian.T @ jacobian, jacobian.T @ residual(p), lambda v: jacobian.T @ v)

    found = levenberg_marquardt(residual, linearise, 0.0 * bound, -bound, bound, max_iterations=12)
    best = lsq_linear(jacobian, measured, (-bound, bound), tol=1e-14)
    assert np.all(np.abs(found.coordinates) <= 1.0)
    assert found.cost == pytest.approx(best.cost, rel=1e-9)


def test_projected_gradient_agrees_with_finite_differences():
    x, y, _ = small_problem(noise=NOISE).data_courses(np.zeros(2))[0]
    group = np.where(np.arange(len(x) - 1) < 100, 0, -1)
    problem = ProjectedOneStep(y[:-1], x[1:], y[1:], np.ones(len(x) - 1), group, 1, 2)
    point = np.array([-0.5, 1.0, -0.6, -0.4, 0.7, 0.5, 0.05])

    def value(at: np.ndarray) -> float:
        residual = problem.residual(at)
        return 0.5 * residual @ residual

    # Kaufman's Jacobian gives the exact gradient: what it leaves out is orthogonal to the residual.
    exact = problem.linearise(point).gradient
    numeric = [(value(point + 1e-6 * e) - value(point - 1e-6 * e)) / 2e-6 for e in np.eye(7)]
    np.testing.assert_allclose(exact, numeric, atol=1e-5 * np.abs(exact).max())


# --- the problem in CasADi -----------------------------------------------------------------------


def test_the_casadi_problem_has_the_cost_and_the_exact_gradient_of_the_compiled_chain():
    criterion = small_problem()
    point = perturbed(criterion)
    stated = casadi_problem(criterion.guarded_by_data(1.0, criterion.model.offsets))
    x, f = stated.problem["x"], stated.problem["f"]
    value = ca.Function("value", [x], [f, ca.gradient(f, x)])
    at, slope = value(point)
    assert float(at) == pytest.approx(cost(criterion, point), rel=1e-13)
    expected = gradient(criterion, point)
    np.testing.assert_allclose(
        slope.full().ravel(), expected, rtol=0, atol=1e-12 * np.abs(expected).max()
    )
    hessian = stated.hessian(point, [], 2.0, np.zeros(stated.problem["g"].numel())).full()
    np.testing.assert_allclose(
        hessian, 2.0 * criterion.linearise(point).hessian, atol=1e-9 * np.abs(hessian).max()
    )


def test_its_constraints_are_contraction_and_invertibility_over_the_band():
    criterion = small_problem().guarded_over(wide_band(), 1.0)
    point = perturbed(criterion)
    stated = casadi_problem(criterion)
    g = ca.Function("g", [stated.problem["x"]], [stated.problem["g"]])(point).full().ravel()
    expected = usability_values(criterion.rules(point), wide_band())
    np.testing.assert_allclose(g, expected.ravel(), rtol=1e-11, atol=1e-13)
    held = (stated.lbg <= g) & (g <= stated.ubg)
    # where the penalties of the least-squares fits are 0, the constraints hold
    slopes = np.arange(len(g)) >= 3 * len(wide_band().y)
    penalties = Guard(wide_band(), 1.0).residual(criterion.rules(point))
    np.testing.assert_array_equal(held[~slopes], penalties[~slopes] == 0.0)
    assert not np.all(held)


def test_any_casadi_solver_takes_the_problem():
    criterion, start = one_rule_problem()
    stated = casadi_problem(criterion)
    solver = ca.nlpsol(
        "fit",
        "sqpmethod",
        stated.problem,
        {
            "hess_lag": stated.hessian,
            "qpsol": "qrqp",
            "qpsol_options": {"print_iter": False, "print_header": False},
            "print_header": False,
            "print_iteration": False,
            "print_time": False,
            "print_status": False,
        },
    )
    end = solver(x0=start, **stated.bounds)["x"].full().ravel()
    expected = minimise_from(criterion, start, 100, 1e-9)
    assert cost(criterion, end) == pytest.approx(expected.cost, rel=1e-4)


# --- solvers -------------------------------------------------------------------------------------


def one_rule_problem() -> tuple[ChainCriterion, np.ndarray]:
    """Return a problem that is linear in all it determines, and a start: L = 1 has one optimum."""
    rules = np.array([[0.8, 1.6, 0.2, 0.7, 0.25, 0.05]])
    x = np.sin(np.arange(250) * 0.1) + 0.3 * np.sin(np.arange(250) * 0.31)
    y = compiled.free_run(rules, x, 0.1) + 0.003 * np.random.default_rng(0).standard_normal(250)
    traces, scaling = [trace(x, 1e-6 * y)], Scaling(0.0, 1e-6, 0.0, 1.0)
    start = rules * [1, 1, 1, 0.97, 1.04, 0.9]
    model = paper_model(traces, scaling, start, begins=[0.1e-6])
    criterion = paper_problem(traces, model, scaling)
    return criterion.guarded_by_data(1.0, model.offsets), criterion.pack(model)


@pytest.mark.parametrize("solver", SOLVERS)
def test_every_solver_finds_the_optimum_of_a_second_one(solver):
    criterion, start = one_rule_problem()
    other = "levenberg-marquardt" if solver == "trust-region" else "trust-region"
    expected = solve(criterion, start, Options(solver=other), 1e-8).cost
    iterations = {"gradient-descent": 5000, "evolution": 400}.get(solver, 300)
    found = solve(criterion, start, Options(max_iterations=iterations, solver=solver), 1e-8)
    assert found.cost == pytest.approx(expected, rel=0.02 if solver == "evolution" else 1e-3)
    assert found.cost == pytest.approx(cost(criterion, found.coordinates))


@pytest.fixture(scope="module")
def of_the_stand() -> tuple[Record, Identification]:
    """Return a record of the simulated stand, which has what the paper's model lacks, and its fit."""
    measured = Stand().record(excitations.identification(time(800)), "rig", seed=1)
    return measured, identify([measured], rules=3, options=QUICK)


#: Which take longest; `tests/end_to_end/test_cli.py` has each of them find a model.
LONG = ("ipopt", "evolution")


@pytest.mark.parametrize(
    "solver", [pytest.param(s, marks=[pytest.mark.gate] * (s in LONG)) for s in SOLVERS[1:]]
)
def test_every_solver_fits_a_record_of_the_stand_as_well_as_the_default(of_the_stand, solver):
    measured, expected = of_the_stand
    found = identify([measured], rules=3, options=replace(QUICK, solver=solver))
    assert found.converged
    assert found.records[0].e_rms < 1.02 * expected.records[0].e_rms


def test_an_unknown_solver_is_refused_with_the_names():
    with pytest.raises(InputError, match="unknown solver 'magic'; known are levenberg-marquardt, "):
        Options(solver="magic")


def test_a_diverging_start_is_told_and_not_fatal():
    criterion, start = one_rule_problem()
    start[3] = 3.0  # q1
    found = minimise_from(criterion, start, 100)
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
        run = compiled.free_run(found.parameters.rules, voltage, 0.0)
        np.testing.assert_allclose(run, compiled.free_run(TABLE_1, voltage, 0.0), rtol=0, atol=1e-12)


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
        run = compiled.free_run(noisy.parameters.rules, voltage, result.start["initialDisplacement"])
        # a record is run by the table of the core, this by its rules
        np.testing.assert_allclose(run, result.y, rtol=0.0, atol=1e-13 * np.ptp(result.y))


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
        y = compiled.free_run(two, x, 0.0) + NOISE * np.random.default_rng(i).standard_normal(800)
        records.append(Record(f"r{i}", time(800), x, y, TS))
    found = identify(records, options=QUICK)
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
    found = identify([first, second], rules=3, options=QUICK)
    assert found.by_role("train")[1].offset == pytest.approx(2e-6, abs=2e-8)
    assert found.by_role("train")[1].e_rms < 1.1 * NOISE


def test_only_a_record_that_begins_in_motion_is_given_time_to_fall_in():
    t = time(2000)
    moving = record("moving", 52.5 + 52.5 * np.sin(2 * np.pi * 50 * t))
    resting = record("resting", 52.5 - 52.5 * np.cos(2 * np.pi * 20 * t))
    assert [prepare(r).skip for r in (moving, resting)] == [100, 0]


# --- honesty -------------------------------------------------------------------------------------


def test_one_amplitude_at_one_frequency_is_warned_of():
    single = record("single", excitations.validation_sine(time(1000), 20.0), NOISE)
    found = identify([single], rules=1)
    assert any("one amplitude at one frequency" in text for text in found.warnings)
    assert any("lacks something" in text for text in found.warnings)


@pytest.mark.parametrize(
    ("envelope", "expected"),
    [
        (lambda t: np.ones_like(t), True),
        (lambda t: np.minimum(t / 0.05, 1.0), True),  # let in over one period
        (lambda t: np.minimum((1.0 - t) / 0.3, 1.0), False),  # dies away: nested minor loops
        (lambda t: np.where(t < 0.5, 1.0, 0.6), False),
    ],
)
def test_one_tone_is_one_amplitude_but_for_a_few_turns(envelope, expected):
    t = np.arange(10_000) * 1e-4
    voltage = 50.0 + 50.0 * envelope(t) * np.sin(2 * np.pi * 20.0 * t)
    noise = 0.05 * np.random.default_rng(0).standard_normal(len(t))
    single = Record("a", t, voltage + noise, 1e-7 * voltage, 1e-4)
    assert holds_one_tone([prepare(single)]) is expected


def test_steps_are_no_tone():
    t = np.arange(10_000) * 1e-4
    square = Record("a", t, 50.0 + 50.0 * np.sign(np.sin(2 * np.pi * 20.0 * t + 0.1)), 1e-6 * t, 1e-4)
    assert not holds_one_tone([prepare(square)])


@pytest.mark.parametrize("count", [8, 14])
def test_levels_held_one_after_the_other_are_no_tone(count):
    """Of few turns nearly all might be of another kind: play stayed, at 20 times the noise."""
    levels = np.random.default_rng(count).uniform(0.0, 100.0, count)
    voltage = np.convolve(np.repeat(levels, 400), np.ones(30) / 30, "valid")
    clock = np.arange(len(voltage)) * 1e-4
    assert not holds_one_tone([prepare(Record("a", clock, voltage, 1e-7 * voltage, 1e-4))])


def test_a_record_is_driven_up_to_its_fastest_sine_and_by_steps_up_to_any_frequency():
    t = np.arange(10_000) * 1e-3
    slow, fast = 50.0 - 50.0 * np.cos(2 * np.pi * t), 10.0 * np.sin(2 * np.pi * 40.0 * t)
    held = np.full(len(t), 50.0)

    def driven(voltage):
        return driven_up_to(Record("a", t, voltage, 1e-7 * voltage, 1e-3))

    assert driven(slow) == pytest.approx(1.0, abs=0.2)
    assert driven(slow + fast) == pytest.approx(40.0, abs=0.2)
    assert driven(held) == 0.0
    assert driven(np.where(t < 5.0, 0.0, 50.0)) is None


def test_a_test_record_beyond_the_training_range_is_warned_of():
    t = time(600)
    train = record("train", 0.5 * excitations.identification(t), NOISE)
    test = record("wide", excitations.identification(t), NOISE)
    found = identify([train], test=[test], rules=1)
    assert any("'wide' spans" in text for text in found.warnings)


def test_records_of_different_sample_times_are_refused():
    first = record("a", training_voltages(200)[0])
    second = replace(first, name="b", sample_time=2e-4)
    with pytest.raises(InputError, match=r"'b' is sampled every 0\.0002 s"):
        identify([first, second], rules=1)


def test_no_records_are_refused():
    with pytest.raises(InputError, match="no training record"):
        identify([])


def test_a_fit_that_is_stopped_says_so_and_writes_nothing(tmp_path):
    train = record("a", training_voltages(600)[0], NOISE)
    found = identify([train], rules=3, options=Options(starts=2, max_iterations=2))
    assert not found.converged
    assert "limit of iterations" in found.message
    with pytest.raises(InputError, match="did not converge"):
        write_report(found, [train], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_contraction_holds_over_the_band_of_the_data_and_not_only_at_equilibrium():
    # Preisach-like memory: the unguarded optimum exceeds 1 off the equilibrium curve
    t = time(1200)
    train = Stand().record(excitations.identification(t), "rig", seed=1)
    found = identify([train], rules=3, options=QUICK)
    assert found.contraction < 1.0
    assert not any("drift apart" in text for text in found.warnings)
    kept = slice(found.records[0].lead, None)
    y, x = train.displacement[kept], train.voltage[kept]
    _, _, by_previous = one_step_gradient(found.parameters.rules, y[:-1], x[1:])
    assert np.abs(by_previous).max() <= found.contraction + 1e-6


def test_largest_contraction_says_where_it_is():
    rules = np.array([[0.5, 1.0, -0.6, 1.1, 0.2, 0.1], [0.4, 0.9, 0.7, 0.7, 0.1, -0.2]])
    value, y, x = largest_contraction(rules, wide_band())
    assert abs(compiled.gradient(rules, y, x)[2][1]) == pytest.approx(value, rel=1e-9)
    assert value > np.abs(usability_values(rules, wide_band())[:3]).max() - 1e-9


# --- bad input -----------------------------------------------------------------------------------


def test_a_clipped_stretch_has_no_weight():
    clean = [record(f"r{i}", x, NOISE, i) for i, x in enumerate(training_voltages(800)[:2])]
    limit = 14e-6
    mask = clean[0].displacement > limit
    clipped = replace(clean[0], displacement=np.minimum(clean[0].displacement, limit), outliers=mask)
    assert 0.02 < mask.mean() < 0.3
    found = identify([clipped, clean[1]], rules=3, options=QUICK)
    run = found.records[0].y
    assert np.sqrt(np.mean((run - clean[0].displacement)[mask] ** 2)) < 3 * NOISE
    assert found.records[0].noise == pytest.approx(NOISE, rel=0.3)


def test_a_mostly_clipped_record_is_refused():
    whole = record("stuck", training_voltages(400)[0])
    with pytest.raises(InputError, match=r"'stuck': 300 of 400 samples are clipped"):
        identify([replace(whole, outliers=np.arange(400) < 300)], rules=1)


def test_a_masked_outlier_changes_nothing():
    whole = record("a", training_voltages(600)[0], NOISE)
    mask = np.arange(600) == 3
    results = [
        identify(
            [replace(whole, displacement=whole.displacement + size * mask, outliers=mask)],
            rules=2,
            options=QUICK,
        )
        for size in (0.0, 50e-6)
    ]
    rules = [result.parameters.rules for result in results]
    np.testing.assert_allclose(rules[0], rules[1], rtol=1e-9)
    assert results[0].records[0].e_rms == pytest.approx(results[1].records[0].e_rms)


def test_records_too_short_for_the_rules_are_refused_with_numbers():
    short = record("a", training_voltages(90)[0], NOISE)
    with pytest.raises(InputError, match=r"L = 3 has 19 parameters .* 95 samples; .* have 90 "):
        identify([short], rules=3)
    with pytest.raises(InputError, match=r"L = 1 has 7 parameters .* 35 samples; .* have 29 "):
        identify([short.slice(0, 30)])


# --- uncertainty ---------------------------------------------------------------------------------


def test_parameters_that_only_act_together_are_named_as_a_group():
    # one rule: its membership cancels in (10), and nothing depends on s1, s2 and c
    criterion, start = one_rule_problem()
    minimum = minimise_from(criterion, start, 100)
    found = assess(ChainFit(criterion, minimum))
    assert set(found.undetermined) == {"rule[1].sigmaLower", "rule[1].sigmaUpper", "rule[1].centre"}
    # twins: only the sum of their consequents counts
    rules, scaling = criterion.rules(minimum.coordinates), criterion.scaling
    model = paper_model(criterion.traces, scaling, np.vstack([rules, rules]))
    twin = paper_problem(criterion.traces, model, scaling)
    end = Minimum(twin.pack(model), 0.0, True, 0, 0, "")
    found = assess(ChainFit(twin, end))
    group = next(g for g in found.groups if "rule[1].q1" in g)
    assert "rule[2].q1" in group
    assert any("rule[2].q1" in text and "only together" in text for text in found.sentences())


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


def test_noise_is_not_known_where_the_stage_moves_at_all_frequencies():
    """Three inputs at once, of which the record holds one: what the others do is no noise."""
    rng = np.random.default_rng(1)
    lines = np.arange(5.0, 3000.0, 1.37)
    t = np.arange(20_000) / 6400.0
    voltage, other, third = (
        np.sum(np.cos(2 * np.pi * lines[:, None] * t + rng.uniform(0, 6.28, (len(lines), 1))), axis=0)
        / np.sqrt(len(lines))
        for _ in range(3)
    )
    noise = 0.023 * rng.standard_normal(len(t))
    estimate = estimate_noise(voltage, 3.0 * voltage + 6.0 * other + 5.0 * third + noise)
    assert not estimate.certain
    assert estimate.rms == pytest.approx(0.023, rel=0.2)


def test_steps_and_a_little_colour_leave_the_noise_known():
    rng = np.random.default_rng(2)
    steps = np.repeat(rng.uniform(0.0, 100.0, 20), 250)
    y = signal.lfilter([0.1], [1.0, -0.9], 0.1 * steps)
    coloured = signal.lfilter([0.8], [1.0, -0.6], rng.standard_normal(5000))
    for noise in (rng.standard_normal(5000), coloured):
        assert estimate_noise(steps, y + 0.006 * noise).certain


def test_correlation_time_of_white_noise_and_of_a_first_order_process():
    rng = np.random.default_rng(0)
    white = rng.standard_normal(20_000)
    assert correlation_time(white) == pytest.approx(1.0, abs=0.1)
    coloured = np.zeros_like(white)
    for k in range(1, len(white)):
        coloured[k] = 0.9 * coloured[k - 1] + white[k]
    assert correlation_time(coloured) == pytest.approx(19.0, rel=0.3)


def test_an_excerpt_of_long_records_is_short_and_holds_every_record():
    rng = np.random.default_rng(0)
    traces = [trace(rng.standard_normal(n), rng.standard_normal(n)) for n in (90_000, 300, 9_000)]
    windows, records = excerpt(traces)
    assert set(records) == {0, 1, 2}
    assert sum(len(w.y) for w in windows) < 12_000
    last = windows[np.flatnonzero(records == 0)[-1]]
    np.testing.assert_array_equal(last.y, traces[0].y[-1000:])
    np.testing.assert_array_equal(last.drive.voltage, traces[0].drive.voltage[-1000:])
    assert excerpt(traces[1:2])[0] == traces[1:2]


@pytest.mark.parametrize("count", [12_000, 15_001, 18_000, 45_000, 150_000, 300_000, 1_000_000])
@pytest.mark.parametrize("lead", [0, 2_000])
def test_no_window_falls_into_what_is_set_aside(count, lead):
    weight = np.ones(count)
    weight[np.isin(np.arange(count) * 10 // count, (2, 5, 8))] = 0.0
    weight[:lead] = 0.0
    windows, _ = excerpt([trace(np.arange(float(count)), np.zeros(count), weight)])
    assert len(windows) >= 6
    assert all(np.count_nonzero(w.weight) >= 500 for w in windows)
    assert windows[0].drive.voltage[0] >= lead
    assert windows[-1].drive.voltage[-1] > 0.8 * count


def test_an_excerpt_of_what_is_hardly_fitted_shows_that():
    weight = np.zeros(20_000)
    weight[12_000:12_100] = 1.0
    windows, _ = excerpt([trace(np.zeros(20_000), np.zeros(20_000), weight)])
    assert all(np.count_nonzero(w.weight) == 100 for w in windows)


def test_what_is_set_aside_leaves_a_part_that_moves():
    late = np.where(np.arange(1000) < 800, 0.0, np.sin(np.arange(1000)))
    for x, fitted_begin in ((np.sin(np.arange(1000)), 0), (late, 300)):
        fitted, decisive = split([trace(x, x.copy())])
        kept = slice(fitted_begin, fitted_begin + 700)
        np.testing.assert_array_equal(fitted[0].drive.voltage, x[kept])
        np.testing.assert_array_equal(fitted[0].y, x[kept])
        assert np.count_nonzero(decisive[0].weight) == 300
        assert not np.any(decisive[0].weight[fitted_begin : fitted_begin + 700])


def test_a_single_step_is_no_start_up():
    x = np.where(np.arange(1000) < 200, 0.0, 1.0)
    y = x + 0.2 * (np.arange(1000) < 5)
    record = Record("step", np.arange(1000) * 1e-4, x, y, 1e-4)
    assert prepare(record).skip == 0


def test_a_record_that_cannot_move_where_it_is_trusted_is_refused():
    time, outliers = np.arange(100) * 1e-4, np.arange(100) < 40
    x = np.where(outliers, np.arange(100) % 7, 0.0)
    flat = Record("flat", time, x, 1e-6 * np.arange(100.0), 1e-4, outliers=outliers)
    with pytest.raises(InputError, match="'flat': the voltage is 0 in all usable samples"):
        identify([flat])


@pytest.mark.parametrize(("rules", "seed"), [(0, 0), (17, 0), (2.5, 0), ("two", 0), (None, -1)])
def test_numbers_that_no_model_takes_are_refused(rules, seed):
    with pytest.raises(InputError, match="must be a whole number from"):
        identify([record("a", training_voltages(300)[0])], rules=rules, options=Options(seed=seed))


def test_noise_is_no_less_than_the_numbers_can_show():
    x = np.sin(2 * np.pi * np.arange(3000) / 150)
    y = np.sin(2 * np.pi * np.arange(3000) / 150 - 0.2)
    for step in (1e-2, 1e-4):
        written = estimate_noise(x, step * np.round(y / step))
        assert written.rms == pytest.approx(step / np.sqrt(12), rel=0.01)
        assert "no noise is visible" in written.method
    exact = estimate_noise(x, y)
    assert 1e-8 < exact.rms < 1e-6
    noisy = estimate_noise(x, 1e-4 * np.round((y + 0.01 * np.sin(7.7 * np.arange(3000))) / 1e-4))
    assert noisy.rms > 1e-3 and "no noise" not in noisy.method
