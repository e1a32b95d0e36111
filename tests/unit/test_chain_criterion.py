"""The free-run criterion of the whole chain: derivatives, coordinates, effects at zero strength."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from conftest import TS, UM
from effects import signals, surroundings, with_effects
from hypothesis import given, settings
from hypothesis import strategies as st

from it2hys.diagnosis.variants import with_effect, without_effect
from it2hys.identification.casadi_problem import casadi_problem
from it2hys.identification.criterion import ChainCriterion, Model, Trace, minimise, paper_model
from it2hys.identification.effect_coordinates import by_record
from it2hys.identification.inverse import References
from it2hys.identification.scaling import Scaling
from it2hys.identification.starts import fitted_coordinates
from it2hys.identification.usability import Band, largest_contraction
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS, active_effects
from it2hys.model.effects import nonlinearity
from it2hys.model.parameters import table_1
from it2hys.model.variables import load_table, off_values
from it2hys.policy import CORE
from it2hys.records.clues import Extent
from it2hys.support.processes import parallel_map

SAMPLES = 400
NOISE = 0.006 * UM
ALL = tuple(EFFECTS)
SCALING = Scaling(8 * UM, 8 * UM, 50.0, 50.0)
EXTENT = Extent(TS, SAMPLES * TS, (0.0, 100.0), (0.0, 16 * UM), (-10.0, 10.0), (288.0, 298.0))


def model_with(effects: tuple[str, ...], seed: int, records: int) -> Model:
    """Return a model with effects of random parameters, and what differs from record to record."""
    rng = np.random.default_rng(seed)
    parameters = dict(with_effects(effects, seed))
    for name, value in parameters.items():
        if name.startswith("play[") and name.endswith("weight"):
            parameters[name] = abs(value)  # a fit's are not negative
    if "delay" in effects and "play" in effects:
        # a whole number of ticks is a corner, and so is rest for operators: no derivative at both
        parameters["delay.time"] = (int(parameters["delay.time"] / TS) - 0.7) * TS
    if "saturation" in effects:
        # the records go beyond
        parameters.update({"saturation.minimum": 20.0, "saturation.maximum": 80.0})
    spans = {
        "initialDisplacement": (5.0 * UM, 10.0 * UM),
        "initialDemagnetisation": (-30.0, 30.0),
        "initialExcursion": (-20.0, 40.0),
        "initialCreep": (-UM, UM),
        "initialCreepAge": (0.0, 0.1),
        "hum.phase": (-3.0, 3.0),
    }
    known = load_table().parameters()
    assert set(spans) == set(by_record())
    own = {
        n: rng.uniform(*spans[n], records) for n in by_record() if known[n].effect in (None, *effects)
    }
    offsets = np.array([0.0, *rng.uniform(-0.1, 0.1, records - 1)]) * UM
    return Model(parameters, tuple(active_effects(parameters)), offsets, own)


def traces_of(count: int, seed: int = 0) -> list[Trace]:
    """Return records of different lengths and weights; the first has no constant of its own."""
    rng = np.random.default_rng(seed)
    traces = []
    for i in range(count):
        samples = SAMPLES - 50 * i
        voltage = signals(samples, 5.0 + 5 * i, 95.0 - 10 * i)
        y = 0.15 * UM * voltage + NOISE * rng.standard_normal(samples)
        weight = np.full(samples, 1.0 / (i + 1))
        weight[: 20 * i] = 0.0
        drive = compiled.Drive.of(voltage, *surroundings(samples))
        references = References(y, weight > 0, NOISE, TS)
        traces.append(
            Trace(f"record {i}", "train", drive, y, weight, weight > 0, 40, NOISE, references, i > 0)
        )
    return traces


def criterion_of(model: Model, traces: list[Trace]) -> ChainCriterion:
    return ChainCriterion(traces, model, fitted_coordinates(model, EXTENT), SCALING)


def within(criterion: ChainCriterion, point: np.ndarray) -> np.ndarray:
    """Return the point, moved well inside the bounds so that steps stay within them."""
    lower, upper = (np.clip(b, -1e6, 1e6) for b in (criterion.lower, criterion.upper))
    margin = 1e-4 * (upper - lower)
    return np.clip(point, lower + margin, upper - margin)


# --- derivatives ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "effects", [(), *((e,) for e in ALL), ALL], ids=lambda e: "+".join(e) or "none"
)
def test_the_jacobian_is_that_of_the_residuals(effects):
    traces = traces_of(3)
    criterion = criterion_of(model_with(effects, 7, len(traces)), traces)
    point = within(criterion, criterion.pack(criterion.model))
    jacobian, residual = criterion.jacobian(point)
    rows = slice(0, len(residual))  # what follows in `residual` are the priors
    np.testing.assert_allclose(criterion.residual(point)[rows], residual, rtol=0, atol=1e-12)
    moving = 0
    for column in range(len(point)):
        step = np.zeros_like(point)
        step[column] = 1e-6
        ahead, behind = (criterion.residual(p)[rows] for p in (point + step, point - step))
        expected = (ahead - behind) / 2e-6
        size = np.max(np.abs(expected))
        moving += bool(size > 0.0)
        # at a bend (a slew limit that sets in, a turning point) both quotients are right and differ
        off = np.abs(jacobian[:, column] - expected) > 1e-4 * size + 1e-6
        assert np.mean(off) < 0.02, (column, np.mean(off))
    # a history that moves no play operator, and what the amplifier hides of it, are idle
    assert moving >= 0.8 * len(point)


def test_a_whole_chain_is_a_casadi_problem_and_a_rising_curve_its_constraint():
    traces = traces_of(2)
    criterion = criterion_of(model_with(ALL, 3, 2), traces)
    point = within(criterion, criterion.pack(criterion.model))
    stated = casadi_problem(criterion)
    x, f, g = (stated.problem[name] for name in ("x", "f", "g"))
    value = ca.Function("value", [x], [f, ca.gradient(f, x), g])
    at, slope, _ = value(point)
    jacobian, residual = criterion.unconstrained().full_jacobian(point)
    assert float(at) == pytest.approx(0.5 * residual @ residual, rel=1e-12)
    exact = jacobian.T @ residual
    np.testing.assert_allclose(slope.full().ravel(), exact, atol=1e-12 * np.abs(exact).max())
    # the penalties of a least-squares fit, the last residuals, are 0 where the constraint holds
    bent = next(i for i, c in enumerate(criterion.common) if c.name == "nonlinearity.quadratic")
    falling = 0
    for share in (-9.0, -3.0, 0.0, 3.0, 9.0):
        moved = point.copy()
        moved[criterion.rule_size + bent] = share
        slopes = value(moved)[2].full().ravel()
        penalties = criterion.residual(moved)[-len(slopes) :]
        held = (stated.lbg <= slopes) & (slopes <= stated.ubg)
        np.testing.assert_array_equal(held, penalties == 0.0)
        falling += np.count_nonzero(~held)
    assert falling > 0


@pytest.mark.parametrize("share", [0.5, 0.99, 1.5, 4.0])
def test_creep_slower_than_the_records_costs(share):
    """They do not show it: a larger gain goes with a larger time constant."""
    criterion = criterion_of(model_with(("creep",), 3, 2), traces_of(2))
    point = criterion.pack(criterion.model)
    names = [c.name for c in criterion.common]
    place = criterion.rule_size + names.index("creep[1].timeConstant")
    point[place] = np.log(share * EXTENT.duration)
    jacobian, residual = criterion.full_jacobian(point)
    np.testing.assert_allclose(criterion.residual(point), residual, rtol=0, atol=1e-12)
    assert len(criterion.residual_or_nan(point)) == len(residual)
    step = np.zeros_like(point)
    step[place] = 1e-6
    ahead, behind = (criterion.residual(p) for p in (point + step, point - step))
    by_place = (ahead - behind) / 2e-6
    np.testing.assert_allclose(jacobian[:, place], by_place, atol=1e-6)
    of_records = criterion.jacobian(point)[1]
    beyond = np.flatnonzero(jacobian[len(of_records) :, place] > 2e-3)  # more than holds any of them
    assert len(beyond) == (share > 1.0)


def test_linearisation_agrees_with_residual_and_jacobian():
    traces = traces_of(2)
    criterion = criterion_of(model_with(ALL, 3, 2), traces).guarded(1.0)
    rng = np.random.default_rng(0)
    point = within(criterion, criterion.pack(criterion.model))
    point = within(criterion, point + 1e-3 * rng.standard_normal(point.shape))
    linear = criterion.linearise(point)
    residual = criterion.residual(point)
    jacobian = np.array([linear.transposed(row) for row in np.eye(len(residual))])
    np.testing.assert_allclose(linear.hessian, jacobian.T @ jacobian, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(linear.gradient, jacobian.T @ residual, rtol=1e-9, atol=1e-9)


def test_a_rule_that_hides_between_points_of_the_grid_costs_once_penalties_are_stronger():
    """A paper's model ended at |dF/dy| = 1.001 there, and the diagnosis of a good record with it."""
    band = Band(np.linspace(-1.2, 1.2, 193), np.full(193, -1.1), np.full(193, 1.1))
    rules = np.array(
        [
            [0.1, 0.1688, 0.443, 0.3436, 0.1133, 0.0304],
            [0.1, 0.1389, 0.0507, 0.4953, 0.1649, -0.0522],
            [0.1, 0.1135, -0.3795, 0.5121, 0.1046, -0.0349],
        ]
    )
    rules[:, 3:] *= 1.0002 * CORE.contraction / largest_contraction(rules, band)[0]
    traces = traces_of(1)
    criterion = criterion_of(paper_model(traces, SCALING, rules), traces)
    point = criterion.pack(criterion.model)
    assert not criterion.guarded_over(band, 1.0).penalised(point)
    assert criterion.guarded_over(band, 10.0).penalised(point)


def falling_model(traces: list[Trace]) -> Model:
    """Return a model with a static curve that falls at its lower end."""
    model = model_with(("nonlinearity",), 3, len(traces))
    span = model.values["displacementMax"] - model.values["displacementMin"]
    bend = {"nonlinearity.quadratic": -0.15 * span, "nonlinearity.cubic": 0.15 * span}
    return replace(model, values={**model.values, **bend})


def test_a_curve_that_falls_costs_by_how_much_it_does():
    traces = traces_of(2)
    criterion = criterion_of(falling_model(traces), traces)
    point = criterion.pack(criterion.model)
    residual, linear = criterion.residual(point), criterion.linearise(point)
    jacobian = np.array([linear.transposed(row) for row in np.eye(len(residual))])
    falling = slice(len(residual) - len(nonlinearity.slopes(0.0, 1.0)), len(residual))
    assert np.count_nonzero(residual[falling]) > 10
    place = criterion.rule_size  # of the first coefficient
    step = 1e-6 * np.eye(len(point))[place]
    expected = (criterion.residual(point + step) - criterion.residual(point - step))[falling] / 2e-6
    np.testing.assert_allclose(jacobian[falling, place], expected, rtol=1e-6, atol=1e-6)


def test_a_fit_to_a_curve_that_falls_ends_at_one_that_rises():
    traces = traces_of(2)
    model = falling_model(traces)
    assert "falls" in compiled.chain_check(model.values)
    bent = [replace(t, y=model.predict(t, i)) for i, t in enumerate(traces)]
    fitted = minimise(criterion_of(model, bent), 40).model
    assert compiled.chain_check(fitted.values) is None


# --- coordinates ---------------------------------------------------------------------------------


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.lists(st.sampled_from(ALL), unique=True))
def test_unpack_undoes_pack(seed, chosen):
    effects = tuple(e for e in ALL if e in chosen)
    criterion = criterion_of(model_with(effects, seed, 2), traces_of(2))
    rng = np.random.default_rng(seed)
    point = within(criterion, criterion.pack(criterion.model))
    point = within(criterion, point + 1e-2 * rng.standard_normal(point.shape))
    model = criterion.unpack(point)
    np.testing.assert_allclose(criterion.pack(model), point, rtol=1e-9, atol=1e-9)
    again = criterion.unpack(criterion.pack(model))
    for name, value in model.values.items():
        assert again.values[name] == pytest.approx(value, rel=1e-9, abs=1e-15), name
    np.testing.assert_allclose(again.offsets, model.offsets, rtol=1e-9)
    for name, values in model.own.items():
        np.testing.assert_allclose(again.own[name], values, rtol=1e-9, atol=1e-15)
    assert again.effects == model.effects


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.lists(st.sampled_from(ALL), unique=True))
def test_residuals_are_those_of_the_unpacked_model(seed, chosen):
    """Whose runs are made record by record."""
    traces = traces_of(3)
    criterion = criterion_of(model_with(tuple(e for e in ALL if e in chosen), seed, 3), traces)
    rng = np.random.default_rng(seed)
    point = criterion.pack(criterion.model)
    point = within(criterion, point + 1e-3 * rng.standard_normal(len(point)))
    model, expected = criterion.unpack(point), []
    for i, trace in enumerate(traces):
        error = (model.predict(trace, i) - trace.y) / SCALING.y_unit
        expected.append((trace.weight * error)[trace.weight > 0.0])
    expected = np.concatenate(expected)
    assert np.array_equal(criterion.residual(point)[: len(expected)], expected)


def test_a_run_that_is_not_finite_has_no_residuals():
    traces = traces_of(3)
    criterion = criterion_of(model_with((), 7, 3), traces)
    point = criterion.pack(criterion.model)
    point[3 : criterion.rule_size : 6] = 40.0  # q1 of every rule: the core grows
    assert not np.isfinite(criterion.unpack(point).predict(traces[0], 0)).all()
    assert criterion.residual(point) is None and criterion.linearise(point) is None


def test_what_is_held_does_not_move():
    criterion = criterion_of(model_with(("play", "creep"), 5, 2), traces_of(2)).holding(["rules"])
    rules = slice(0, criterion.rule_size)
    assert np.array_equal(criterion.lower[rules], criterion.upper[rules])
    assert np.all(criterion.lower[criterion.rule_size :] < criterion.upper[criterion.rule_size :])


# --- effects at zero strength --------------------------------------------------------------------

#: Guesses at which an effect does nothing; a resonance is never nothing.
ZERO = {
    "delay": {"delay.time": 0.0},
    "slew": {"slew.rate": 1e9},
    "saturation": {"saturation.minimum": -1e4, "saturation.maximum": 1e4},
    "play": {
        "playCount": 2, "play[1].threshold": 5.0, "play[1].weight": 0.0,
        "play[2].threshold": 10.0, "play[2].weight": 0.0,
    },
    "load": {"load.compliance": 0.0},
    "creep": {"creepCount": 1, "creep[1].gain": 0.0, "creep[1].timeConstant": 0.1},
    "drift": {"drift.temperatureCoefficient": 0.0, "drift.rate": 0.0},
    "nonlinearity": {f"nonlinearity.{n}": 0.0 for n in nonlinearity.COEFFICIENTS},
    "hum": {"hum.amplitude": 0.0, "hum.frequency": 50.0},
    "lag": {"lag.timeConstant": 1e-3 * TS},
}  # fmt: skip


@settings(max_examples=40)
@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.sampled_from(ALL), unique=True),
    st.sampled_from(list(ZERO)),
)
def test_an_effect_at_zero_strength_changes_nothing(seed, chosen, added):
    base = tuple(e for e in ALL if e in chosen and e != added)
    model, traces = model_with(base, seed, 2), traces_of(2)
    # beside a lag, a slew limit or a resonance a delay of a part of a sample belongs to the model
    # without it being an effect: here it is the added effect that is looked at
    grown = with_effect(model, added, ZERO[added], EXTENT)
    grown = replace(grown, values={**grown.values, "delay.time": model.values["delay.time"]})
    for i, trace in enumerate(traces):
        before, after = model.predict(trace, i), grown.predict(trace, i)
        np.testing.assert_allclose(after, before, rtol=0, atol=1e-12 * 16 * UM)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.sampled_from(ALL))
def test_adding_an_effect_and_taking_it_out_gives_the_model_back(seed, effect):
    model = Model({**off_values(EFFECTS), **table_1()}, (), np.array([0.0, 0.02 * UM]), {})
    full = model_with((effect,), seed, 2)
    known = load_table().parameters()
    guess = {n: v for n, v in full.values.items() if known[n].effect == effect and n not in by_record()}
    grown = with_effect(model, effect, guess, EXTENT)
    assert grown.effects == (effect,)
    back = without_effect(grown, effect)
    assert back.effects == () and back.own == {}
    for i, trace in enumerate(traces_of(2)):
        assert back.predict(trace, i).tobytes() == model.predict(trace, i).tobytes()


def test_threads_change_no_bit(monkeypatch):
    monkeypatch.setattr(compiled, "LONG", 1)
    model = model_with(ALL, 1, 3)
    criterion = ChainCriterion(traces_of(3), model, fitted_coordinates(model, EXTENT), SCALING)
    point = criterion.pack(model)
    residual, (jacobian, _) = criterion.residual(point), criterion.jacobian(point)
    with parallel_map(2):
        np.testing.assert_array_equal(criterion.residual(point), residual)
        np.testing.assert_array_equal(criterion.jacobian(point)[0], jacobian)


@pytest.mark.parametrize("groups", [["rules"], ["effects"], ["rules", "effects"]])
def test_what_is_held_has_no_derivatives_and_changes_none(groups):
    model = model_with(ALL, 1, 2)
    criterion = ChainCriterion(traces_of(2), model, fitted_coordinates(model, EXTENT), SCALING)
    point = criterion.pack(model)
    whole, residual = criterion.jacobian(point)
    held = criterion.holding(groups)
    jacobian, same = held.jacobian(point)
    np.testing.assert_array_equal(same, residual)
    moves = held.lower < held.upper
    assert 0 < np.count_nonzero(moves) < len(moves) and not jacobian[:, ~moves].any()
    np.testing.assert_allclose(jacobian[:, moves], whole[:, moves], rtol=1e-12, atol=1e-14)
