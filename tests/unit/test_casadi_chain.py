"""The public CasADi chain: plant and inverse are those of the compiled chain, tick for tick."""

import doctest

import casadi as ca
import numpy as np
import pytest
from casadi_runs import NAMES, SAMPLES, around, assert_same, run
from conftest import UM
from effects import (
    effect_sets,
    gentle_reference,
    rough_reference,
    signals,
    with_effects,
)
from hypothesis import given, settings
from hypothesis import strategies as st

import it2hys
from it2hys.model import casadi_chain as module
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet
from it2hys.model.stages import EFFECTS


def assert_plant_is_compiled(parameters: ParameterSet) -> None:
    chain, voltage, others = it2hys.casadi_chain(parameters), signals(SAMPLES, -5.0, 115.0), around()
    found = run(chain.step, chain.rest()["state"], voltage=voltage, **others)
    theirs = compiled.chain_free_run(parameters, voltage, others["force"], others["temperature"])
    assert_same(found["displacement"], theirs[0])
    assert_same(found["measured"], theirs[1])


def assert_inverse_is_compiled(parameters: ParameterSet, reference: np.ndarray) -> int:
    """Check it, and return at how many ticks it is saturated."""
    chain, others = it2hys.casadi_chain(parameters), around(len(reference))
    found = run(chain.inverse, chain.rest()["inverse_state"], reference=reference, **others)
    voltage, saturated = compiled.chain_inverse_run(
        parameters, reference, others["force"], others["temperature"]
    )
    assert_same(found["voltage"], voltage)
    assert np.array_equal(found["saturated"] != 0.0, saturated)
    return int(np.count_nonzero(saturated))


@pytest.mark.parametrize("effects", [(), *((e,) for e in EFFECTS), tuple(EFFECTS)], ids="+".join)
def test_plant_and_inverse_are_the_compiled_ones(effects):
    for seed in range(2):
        parameters = with_effects(effects, seed)
        assert_plant_is_compiled(parameters)
        assert_inverse_is_compiled(parameters, gentle_reference(SAMPLES))
        # beyond the range, and with steps that nothing follows: it clamps, is followed and comes back
        rough = rough_reference(np.random.default_rng(seed), SAMPLES)
        back = np.concatenate([rough, np.full(SAMPLES, 7 * UM)])
        assert assert_inverse_is_compiled(parameters, back) > 0


@settings(max_examples=15)
@given(effect_sets(), st.integers(0, 2**32 - 1))
def test_of_any_set_they_are_the_compiled_ones(parameters, seed):
    assert_plant_is_compiled(parameters)
    assert_inverse_is_compiled(parameters, rough_reference(np.random.default_rng(seed), SAMPLES))


@pytest.mark.parametrize("effect", EFFECTS)
def test_it_rests_at_any_displacement(effect):
    parameters = with_effects((effect,), 1, initialDisplacement=5 * UM)
    chain, elsewhere = it2hys.casadi_chain(parameters), parameters.replace(initialDisplacement=7 * UM)
    voltage, reference = signals(20, 10.0, 60.0), np.full(20, 7 * UM)
    rest, quiet = chain.rest(displacement=7 * UM), {**around(20), "force": np.zeros(20)}
    quiet["temperature"] = np.full(20, 293.15)
    found = run(chain.step, rest["state"], voltage=voltage, **quiet)
    assert_same(found["displacement"], compiled.chain_free_run(elsewhere, voltage)[0])
    back = run(chain.inverse, rest["inverse_state"], reference=reference, **quiet)
    theirs = compiled.chain_inverse_run(elsewhere, reference)[0]
    np.testing.assert_allclose(back["voltage"], theirs, rtol=1e-12, atol=1e-12)


def test_inputs_and_outputs_have_names_and_defaults():
    chain = it2hys.casadi_chain(with_effects(("load", "drift"), 1))
    assert chain.step.name_in() == ["state", "voltage", *NAMES]
    assert chain.step.name_out() == ["next_state", "displacement", "measured"]
    assert chain.inverse.name_in() == ["state", "reference", *NAMES]
    assert chain.inverse.name_out() == ["next_state", "voltage", "saturated"]
    assert chain.rest.name_in() == ["displacement"]
    assert chain.rest.name_out() == ["state", "inverse_state"]
    state = chain.rest()["state"]
    plain = chain.step(state=state, voltage=40.0)["displacement"]
    told = chain.step(state=state, voltage=40.0, force=0.0, temperature=293.15, time=0.0)
    assert plain == told["displacement"]
    assert plain != chain.step(state=state, voltage=40.0, force=5.0)["displacement"]


def test_it_has_exact_derivatives():
    chain = it2hys.casadi_chain(with_effects(("lag", "play", "creep", "resonance", "nonlinearity"), 2))
    rest = chain.rest()
    cases = (
        (chain.step, rest["state"], "voltage", 40.0, 1e-3, "displacement"),
        (chain.inverse, rest["inverse_state"], "reference", 5.001 * UM, 1e-6 * UM, "voltage"),
    )
    for function, at, name, value, step, output in cases:
        state, x = ca.MX.sym("state", at.numel()), ca.MX.sym(name)
        y = function(**{"state": state, name: x})[output]
        slope = ca.Function("slope", [state, x], [ca.gradient(y, x)])
        ends = [function(**{"state": at, name: value + h})[output] for h in (-step, step)]
        expected = float(ends[1] - ends[0]) / (2.0 * step)
        assert float(slope(at, value)) == pytest.approx(expected, rel=1e-6) != 0.0


def test_the_example_in_the_docstring_runs():
    result = doctest.testmod(module)
    assert result.failed == 0 and result.attempted >= 4
