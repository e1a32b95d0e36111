"""The effects: the C chain and CasADi's are one model, off is Table 1, the inverse undoes the plant."""

import numpy as np
import pytest
from conftest import TS, UM, make_set
from effects import (
    INVERTIBLE,
    effect_sets,
    gentle_reference,
    moved,
    rough_reference,
    signals,
    surroundings,
    with_effects,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from it2hys.errors import InputError
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS, Chain, active_effects
from it2hys.model.effects import nonlinearity, play
from it2hys.model.parameters import ParameterSet, format_ssv, read_ssv, table_1, write_ssv
from it2hys.model.variables import load_table
from it2hys.records.clues import Extent

SAMPLES = 300
EXTENT = Extent(TS, 0.5, (0.0, 120.0), (0.0, 15 * UM), (-10.0, 10.0), (288.0, 298.0))


def assert_casadi_is_c(parameters: ParameterSet) -> None:
    voltage, (force, temperature) = signals(SAMPLES, -5.0, 115.0), surroundings(SAMPLES)
    in_c = compiled.chain_free_run(parameters, voltage, force, temperature)
    in_casadi = Chain(parameters).free_run(voltage, force, temperature)
    for ours, theirs in zip(in_c, in_casadi, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.ptp(theirs))


# --- one model ---------------------------------------------------------------------------------


@pytest.mark.parametrize("effect", EFFECTS)
def test_each_effect_is_the_same_in_casadi_and_c_and_shows(effect):
    for seed in range(5):
        parameters = with_effects((effect,), seed)
        assert active_effects(parameters) == [effect]
        assert_casadi_is_c(parameters)
        voltage, around = signals(SAMPLES, -5.0, 115.0), surroundings(SAMPLES)
        plain = compiled.chain_free_run(with_effects((), 0), voltage)[1]
        assert np.max(np.abs(compiled.chain_free_run(parameters, voltage, *around)[1] - plain)) > 1e-9


@settings(max_examples=25)
@given(effect_sets())
def test_casadi_and_c_chains_agree(parameters):
    assert_casadi_is_c(parameters)


@given(st.integers(0, 2**32 - 1), st.integers(1, 16))
def test_without_effects_the_chain_is_the_core_but_for_rounding(seed, count):
    # the zero is that of effects, of which there are none
    scalars = {"voltageMin": -2000.0, "voltageMax": 2000.0, "displacementZero": 2 * UM}
    parameters = make_set(seed, count, initialDisplacement=5 * UM, **scalars)
    voltage, around = signals(SAMPLES, 0.0, 100.0), surroundings(SAMPLES)
    displacement, measured = compiled.chain_free_run(parameters, voltage, *around, first_tick=12345)
    limits = parameters.displacement_range
    alone = compiled.free_run(parameters.rules, voltage, 5 * UM, limits)
    # a table is looked up, within 1e-15 of the range in a tick; a run adds up what it does not forget
    assert displacement.tobytes() == measured.tobytes()
    np.testing.assert_allclose(displacement, alone, rtol=0, atol=1e-13 * (limits[1] - limits[0]))
    reference = gentle_reference(SAMPLES)
    inverse, saturated = compiled.chain_inverse_run(parameters, reference, *around)
    previous = np.concatenate([[5 * UM], reference[:-1]])
    assert not saturated.any()
    expected = compiled.solve(parameters.rules, previous, reference)
    np.testing.assert_allclose(inverse, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


@settings(max_examples=50)
@given(effect_sets(INVERTIBLE))
def test_the_plant_follows_its_inverse(parameters):
    reference, around = gentle_reference(SAMPLES), surroundings(SAMPLES)
    voltage, saturated = compiled.chain_inverse_run(parameters, reference, *around)
    displacement, measured = compiled.chain_free_run(parameters, voltage, *around)
    # a weakly damped resonance or a slow lag may ask for more than the voltages
    followed = ~saturated
    np.testing.assert_allclose(displacement[followed], reference[followed], rtol=1e-9, atol=0)
    if not {"resonance", "lag"} & set(active_effects(parameters)):
        assert followed.all()
    if "hum" in active_effects(parameters):
        assert np.any(displacement != measured)
    else:
        assert displacement.tobytes() == measured.tobytes()


@settings(max_examples=50)
@given(effect_sets(), st.integers(0, 2**32 - 1), st.booleans())
def test_the_inverse_keeps_to_its_limits_says_so_and_comes_back(parameters, seed, narrow):
    rng = np.random.default_rng(seed)
    own = {"saturation.minimum": 5.0, "saturation.maximum": 85.0}
    own |= {"voltageMin": 8.0, "voltageMax": 80.0} if narrow else {}
    parameters = parameters.replace(**own) if "saturation" in active_effects(parameters) else parameters
    # a delay of broken ticks smooths, which no inverse undoes, and creep goes on while it lasts; drift
    # and a resonance that hardly decays do not come to rest in time
    ticks = round(parameters["delay.time"] / TS)
    damping = max(parameters["resonance.damping"], 0.05)
    quiet = {"delay.time": ticks * TS, "resonance.damping": damping, "drift.rate": 0.0}
    quiet |= {"initialCreep": 0.0} if ticks else {}
    quiet["resonance.samplingDelay"] = 0.0
    parameters = parameters.replace(**quiet).validate()
    rough, calm = rough_reference(rng, 1000), np.full(20000, rng.uniform(6.0, 8.0)) * UM
    reference = np.concatenate([rough, calm])
    force = np.concatenate([rng.uniform(-10.0, 10.0, 1000), np.zeros(len(calm))])
    voltage, saturated = compiled.chain_inverse_run(parameters, reference, force)
    assert parameters["voltageMin"] <= voltage.min() and voltage.max() <= parameters["voltageMax"]
    if "saturation" in active_effects(parameters):
        assert np.all(voltage >= 5.0 - 1e-9) and np.all(voltage <= 85.0 + 1e-9)
    if "slew" in active_effects(parameters):
        most = parameters["slew.rate"] * TS
        assert np.max(np.abs(np.diff(voltage))) <= most * (1 + 1e-9) + 1e-9
    beyond = (reference < parameters["displacementMin"]) | (reference > parameters["displacementMax"])
    assert saturated[beyond].all()
    # the force acts when the voltage arrives
    later = np.concatenate([np.zeros(ticks), force])[: len(force)]
    displacement, _ = compiled.chain_free_run(parameters, voltage, later)
    followed = np.flatnonzero(~saturated[: len(reference) - ticks])
    travel = parameters["displacementMax"] - parameters["displacementMin"]
    off = np.abs(displacement[followed + ticks] - reference[followed])
    assert np.max(off, initial=0.0) < 1e-9 * travel
    assert not saturated[-100:].any()  # neither wound up nor in a limit cycle


@settings(max_examples=25)
@given(effect_sets(), st.floats(-100 * UM, 100 * UM))
def test_another_zero_of_the_sensor_moves_what_it_reads_and_nothing_else(parameters, distance):
    voltage, around = signals(SAMPLES, 0.0, 80.0), surroundings(SAMPLES)
    other = moved(parameters, distance)
    ours = compiled.chain_free_run(parameters, voltage, *around)
    for here, there in zip(ours, compiled.chain_free_run(other, voltage, *around), strict=True):
        np.testing.assert_allclose(there - distance, here, rtol=0, atol=1e-11 * UM)
    reference = gentle_reference(SAMPLES)
    here, limited = compiled.chain_inverse_run(parameters, reference, *around)
    there, limited_there = compiled.chain_inverse_run(other, reference + distance, *around)
    np.testing.assert_allclose(there, here, rtol=0, atol=1e-6)
    assert np.array_equal(limited, limited_there)


@pytest.mark.parametrize("effect", ["play", "load", "creep", "drift", "nonlinearity"])
def test_nothing_saturates_on_a_gentle_reference(effect):
    for seed in range(20):
        parameters = with_effects((effect,), seed)
        assert not compiled.chain_inverse_run(parameters, gentle_reference(SAMPLES))[1].any()


@pytest.mark.parametrize("ticks", [1, 7, 64])
def test_a_reference_handed_over_a_delay_early_is_followed_on_time(ticks):
    parameters = with_effects(("play", "creep"), 3, initialCreep=0.0, **{"delay.time": ticks * TS})
    reference = gentle_reference(SAMPLES)
    voltage, saturated = compiled.chain_inverse_run(parameters, reference)
    assert not saturated.any()
    displacement, _ = compiled.chain_free_run(parameters, voltage)
    np.testing.assert_allclose(displacement[ticks:], reference[:-ticks], rtol=1e-9)


def test_time_is_that_of_the_tick():
    parameters = with_effects(("drift", "hum"), 5)
    voltage = np.full(100, 50.0)
    for first in (0, 1000, -50):
        displacement, measured = compiled.chain_free_run(parameters, voltage, first_tick=first)
        plain, _ = compiled.chain_free_run(with_effects((), 0), voltage)
        t = (first + np.arange(100)) * TS
        by_temperature = parameters["drift.temperatureCoefficient"] * (293.15 - 293.15)
        expected = plain + by_temperature + parameters["drift.rate"] * t
        np.testing.assert_allclose(displacement, expected, rtol=1e-12)
        angle = 2 * np.pi * parameters["hum.frequency"] * t + parameters["hum.phase"]
        line = parameters["hum.amplitude"] * np.sin(angle)
        np.testing.assert_allclose(measured, expected + line, rtol=1e-12)


@pytest.mark.parametrize("effect", EFFECTS)
def test_casadi_derives_by_every_parameter_of_an_effect(effect):
    parameters = with_effects((effect,), 8)
    chain = Chain(parameters)
    voltage, (force, temperature) = signals(SAMPLES, -5.0, 115.0), surroundings(SAMPLES)
    p, state = chain.vector(), chain.rest(chain.vector())
    jacobian = chain.step.jacobian()
    for k in range(5):
        inputs = voltage[k], force[k], temperature[k], k * TS
        assert np.all(np.isfinite(jacobian(p, state, *inputs, 0, 0, 0)[0].full()))
        state = chain.step(p, state, *inputs)[0]


def test_casadi_derives_the_rest_behind_a_static_curve():
    chain = Chain(with_effects(("play", "creep", "nonlinearity"), 4))
    p = chain.vector()
    jacobian = chain.rest.jacobian()(p, 0).full()
    ends = ["nonlinearity.minimum", "nonlinearity.maximum", "displacementZero", "initialDisplacement"]
    history = ["initialDemagnetisation", "initialExcursion", "initialCreep", "initialCreepAge"]
    for name in [*ends, *history, "nonlinearity.quadratic", "nonlinearity.cubic", "play[1].weight"]:
        place = chain.names.index(name)
        step = np.zeros(len(p))
        step[place] = 1e-4 * max(abs(p[place]), UM)
        above, below = chain.rest(p + step).full(), chain.rest(p - step).full()
        slope = (above - below)[:, 0] / (2 * step[place])
        np.testing.assert_allclose(jacobian[:, place], slope, rtol=1e-5, atol=1e-6 * abs(slope).max())
        assert slope.any() or name == "initialExcursion"


@pytest.mark.parametrize("effect", EFFECTS)
def test_starts_lie_within_their_bounds_and_make_a_usable_set(effect):
    starts = EFFECTS[effect].starts(EXTENT)
    known = load_table().parameters()
    assert starts and all(known[name].type.base == "Real" for name in starts)
    for name, start in starts.items():
        assert start.low <= start.value <= start.high, name
        assert start.low < start.high
        if name in known:
            assert known[name].type.min <= start.value <= known[name].type.max
    values = {n: v for n, v in table_1().items() if n not in ("playCount", "creepCount")}
    values |= play.thresholds(EXTENT) if effect == "play" else {}  # held, so no start
    ParameterSet({**values, **{name: s.value for name, s in starts.items()}}).validate()


# --- parameter sets ----------------------------------------------------------------------------


@given(effect_sets())
def test_a_set_with_effects_survives_the_file(tmp_path_factory, parameters):
    path = tmp_path_factory.getbasetemp() / "effects.ssv"
    write_ssv(parameters, path)
    again = read_ssv(path)
    assert dict(again) == dict(parameters)
    assert format_ssv(again) == format_ssv(parameters)


def test_counts_follow_from_the_elements_given():
    parameters = with_effects(("play", "creep"), 1)
    counts = parameters.counts
    assert counts["play"] == parameters["playCount"] > 0
    assert f"play[{counts['play']}].weight" in parameters
    assert f"play[{counts['play'] + 1}].weight" not in parameters
    plain = table_1()
    assert plain.counts == {"rule": 3, "play": 0, "creep": 0}
    assert not any(name.startswith(("play[", "creep[")) for name in plain)
    assert active_effects(plain) == []


@pytest.mark.parametrize("waves", [1, 2, 3])
def test_a_curve_of_a_few_waves_is_within_the_bounds_of_a_fit(waves):
    """Its powers cancel each other in part: they are larger than the curve is high."""
    height, z = 0.04 * EXTENT.displacement_span, np.linspace(-1.0, 1.0, 401)
    curve = height * np.sin(0.5 * np.pi * waves * (z + 1.0))
    powers = (1.0 - z**2)[:, None] * z[:, None] ** np.arange(len(nonlinearity.COEFFICIENTS))
    found = np.linalg.lstsq(powers, curve, rcond=None)[0]
    starts = EFFECTS["nonlinearity"].starts(EXTENT)
    bounds = [starts[f"nonlinearity.{name}"].high for name in nonlinearity.COEFFICIENTS]
    fitted = np.clip(found, np.negative(bounds), bounds)
    assert np.sqrt(np.mean((powers @ fitted - curve) ** 2)) < 0.03 * height


@pytest.mark.parametrize(
    ("changes", "phrase"),
    [
        ({"play[1].weight": 0.1}, "parameter 'play[1].threshold' is missing"),
        ({"playCount": 33}, "playCount is 33; it must be 0 to 32"),
        ({"lag.timeConstant": -1e-3}, "lag.timeConstant is -0.001 s; it must be 0 to 1e+06 s"),
        ({"lag.time": 1e-3}, "unknown parameter 'lag.time'; did you mean"),
        ({"resonance.frequency": 5e3, "resonance.damping": 0.1}, "(Nyquist)"),
        ({"resonance.frequency": 500.0}, "resonance.damping is 0; it must be above 0"),
        ({"delay.time": 65 * TS}, "delay.time is 0.0065 s; at a sampleTime of 0.0001 s"),
        ({"play[1].threshold": 1.0, "play[1].weight": -1.5}, "play[1].weight is -0.5"),
        ({"creep[1].gain": 0.1, "creep[1].timeConstant": 0.0}, "creep[1].timeConstant is 0 s"),
        ({"saturation.minimum": 50.0}, "saturation.minimum, 50 V, must be below saturation.maximum"),
        ({"nonlinearity.cubic": 9 * UM}, "nonlinearity.quadratic to nonlinearity.sextic"),
        ({"hum.amplitude": 1e-8}, "hum.frequency is 0 Hz"),
    ],
)
def test_effects_that_cannot_be_are_refused_by_name(changes, phrase):
    values = {n: v for n, v in table_1().items() if n not in ("playCount", "creepCount")}
    with pytest.raises(InputError) as refusal:
        ParameterSet({**values, **changes}).validate()
    assert phrase in str(refusal.value)
