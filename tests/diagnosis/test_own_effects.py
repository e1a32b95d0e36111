"""Effects of the user's own in a diagnosis, on records of an independent simulator.

The worked examples on many seeds are `benchmarks/own_effects.py`; here are a few, with few rivals.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from diagnosis.cases import Case, short
from diagnosis.own_cases import FILES, LOOKED_AT, PHYSICS, TRAINING, OwnCase, run, with_physics
from diagnosis.own_physics import Mount
from diagnosis.simulator import Grid, Surroundings

from it2hys.diagnosis import Diagnosis, diagnose
from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.errors import InputError
from it2hys.fmu.own_library import use_effects
from it2hys.identification import Options
from it2hys.model.own_loading import load_effect
from it2hys.model.stages import EFFECTS, own_effects

#: A third of the starts of the paper's model, which is no more than where these diagnoses begin.
FEW_STARTS = Options(starts=12)
#: The built-in lag, written again as a user would.
SLOW = '''"""An amplifier that follows slowly."""
import casadi as ca
from it2hys import OwnEffect, OwnParameter

class Slow(OwnEffect):
    name, side, states, sampled = "slow_amplifier", "before", 1, True
    description, experiment = "an amplifier that follows slowly", "a chirp to the amplifier's corner"
    parameters = (OwnParameter("time", "s", 5e-6, 1e-2, (5e-5, 2e-4, 8e-4, 3e-3)),)

    def step(self, values, state, x, around):
        part = -ca.expm1(-values["sampleTime"] / values["slow_amplifier.time"])
        y = state[0] + part * (x - state[0])
        return y, [y]

    def rest(self, values, y):
        return y, [y]

EFFECT = Slow()
'''


@pytest.fixture
def given():
    """Return what puts files of effects into the chain, which is as before afterwards."""
    yield use_effects
    use_effects([])


def diagnosed(case: Case, rivals: Sequence[str], declared: Sequence[str] = ()) -> Diagnosis:
    """Return a diagnosis in which only these effects are tried."""
    others = [e for e in EFFECTS if e not in (*rivals, *declared)]
    train = case.train[:TRAINING]
    return diagnose(
        train, case.validation, case.test, declared=declared, excluded=others, options=FEW_STARTS
    )


def unseen_over_noise(found: Diagnosis, case: Case) -> float:
    errors = [j.e_rms for j in found.after if j.role == "test"]
    return float(np.sqrt(np.mean(np.square(errors)))) / case.noise_rms


@pytest.mark.parametrize("straight", [False, True], ids=["held", "straight"])
def test_the_second_resonance_is_exact_for_what_is_held_and_what_runs_straight(straight):
    effect = load_effect(FILES / "second_resonance.py")
    grid = Grid(1e-4, straight=straight)
    walk = np.random.default_rng(1).standard_normal((1, 300)).cumsum(axis=1)
    physics = Mount(ratio=0.2, frequency=400.0, damping=0.03)
    truth = grid.sample(physics.apply(grid.refine(walk), Surroundings(grid, np.zeros_like(walk))))[0]
    own = {"gain": 0.2, "frequency": 400.0, "damping": 0.03, "straight": float(straight)}
    values = {"sampleTime": 1e-4, **{f"second_resonance.{n}": v for n, v in own.items()}}
    _, state = effect.rest(values, walk[0, 0])
    for x, wanted in zip(walk[0], truth, strict=True):
        y, state = effect.step(values, state, x, None)
        assert float(y) == pytest.approx(wanted, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    "declared",
    # `test_own_effect_commands.py` finds it, too
    [pytest.param(False, id="found", marks=pytest.mark.gate), pytest.param(True, id="declared")],
)
def test_a_second_resonance_is_named_and_measured(given, declared):
    """Beside the built-in resonance, with the values of the simulated mount within a hundredth."""
    given([FILES / "second_resonance.py"])
    case = with_physics("second_resonance", LOOKED_AT + 1000)
    own = ["second_resonance"]
    found = diagnosed(case, *(([], own) if declared else ([*own, "resonance"],)))
    assert {*found.effects, *found.declared} == {*own}
    assert not found.unexplained, found.left_over
    assert unseen_over_noise(found, case) < 1.3
    mount = case.plant.effects[PHYSICS["second_resonance"]]
    truth = {"gain": mount.ratio, "frequency": mount.frequency, "damping": mount.damping}
    for name, value in truth.items():
        name = f"second_resonance.{name}"
        assert found.parameters[name] == pytest.approx(value, rel=0.01), name
        low, high = found.intervals[name]
        assert low < found.parameters[name] < high and high - low < 0.1 * abs(value)
    (row,) = [e for e in found.evidence if e.effect == "second_resonance"]
    assert row.accepted != declared and "'second_resonance'" in row.signature
    inverse = [[j.inverse.e_rms for j in js if j.role == "test"] for js in (found.before, found.after)]
    assert np.mean(inverse[1]) < 0.2 * np.mean(inverse[0])


@pytest.mark.gate
def test_two_resonances_close_together_are_told_apart(given):
    """317 Hz and the user's 337 Hz; with their roles exchanged a fit ends at 17 times the noise."""
    given([FILES / "second_resonance.py"])
    case = with_physics("second_resonance", LOOKED_AT + 1005, ("resonance",))
    found = diagnosed(case, ["resonance", "second_resonance"])
    assert {*found.effects} == {"resonance", "second_resonance"}
    assert found.stages[0].label == "before" and found.stages[-1].label == " + ".join(found.effects)
    for name, physics in (("resonance", "resonance"), ("second_resonance", "second resonance")):
        frequency = found.parameters[f"{name}.frequency"]
        assert frequency == pytest.approx(case.plant.effects[physics].frequency, rel=0.001), name
    assert not found.unexplained, found.left_over
    assert unseen_over_noise(found, case) < 1.3


@pytest.mark.gate
def test_heat_of_the_power_at_the_actuator_is_measured(given):
    """It is voltage times current, which no signal of the displacement alone has: 1.5 to 2 times."""
    given([FILES / "thermal_path.py"])
    case = with_physics("thermal_path", LOOKED_AT + 1038)
    found = diagnosed(case, [], ["thermal_path"])
    assert not found.unexplained, found.left_over
    assert unseen_over_noise(found, case) < 1.2
    low, high = found.intervals["thermal_path.time"]
    assert low < case.plant.effects[PHYSICS["thermal_path"]].time < high


@pytest.mark.gate
def test_how_the_first_resonance_is_sampled_does_not_keep_the_second_out(given):
    """Its zero rests on a bound when the second comes in, and is fitted anew behind it."""
    given([FILES / "second_resonance.py"])
    case = with_physics("second_resonance", LOOKED_AT + 1106, ("resonance",))
    found = diagnosed(case, ["resonance", "second_resonance"])
    assert {*found.effects} == {"resonance", "second_resonance"}
    assert not found.unexplained, found.left_over
    assert unseen_over_noise(found, case) < 1.3


@pytest.mark.gate
def test_a_guess_of_another_size_and_a_tenth_off_is_the_one_that_is_followed(given):
    """Of 0.07 and 111 Hz, at 120 Hz: there 0.1 rings out of step, and is worse than at 600 Hz."""
    given([FILES / "second_resonance.py"])
    case = with_physics("second_resonance", LOOKED_AT + 1091, ("resonance",))
    found = diagnosed(case, ["second_resonance"])
    assert found.effects == ("second_resonance",)
    mount = case.plant.effects[PHYSICS["second_resonance"]]
    assert found.parameters["second_resonance.frequency"] == pytest.approx(mount.frequency, rel=0.01)


@pytest.mark.gate
def test_without_its_file_it_is_unexplained_and_described(given):
    case = with_physics("second_resonance", LOOKED_AT + 1000)
    found = diagnosed(case, ["resonance"])
    assert found.unexplained and "is not noise" in found.left_over[0]
    assert "correlated with the voltage" in " ".join(found.left_over)


@pytest.mark.gate
def test_an_effect_that_is_not_there_is_not_named(given):
    given([FILES / "friction.py", FILES / "thermal_path.py"])
    case = Case(LOOKED_AT, "none", sample_time=1e-4, length=1200)
    found = diagnosed(case, [*own_effects()])
    assert found.effects == () and found.indistinguishable == ()
    rows = {e.effect: e for e in found.evidence if e.effect in own_effects()}
    reasons = [e.why for e in rows.values()]
    assert len(rows) == 2 and all("not significant at the level of a search" in why for why in reasons)


@pytest.mark.gate
def test_one_that_explains_the_same_as_a_built_in_one_is_said_to(given, tmp_path):
    path = tmp_path / "slow_amplifier.py"
    path.write_text(SLOW)
    given([path])
    case = next(c for c in short() if c.truth == ("lag",))
    found = diagnosed(case, ["lag", "slow_amplifier"])
    assert found.effects == () and found.indistinguishable == (("lag", "slow_amplifier"),)
    (experiment,) = found.experiments
    assert "a chirp to the amplifier's corner" in experiment
    why = {e.effect: e.why for e in found.evidence}
    assert why["slow_amplifier"].endswith("these records cannot tell it from lag")


def test_the_evidence_comes_and_goes_with_the_effect(given):
    built_in = list(EVIDENCE)
    assert "thermal_path" not in EVIDENCE
    given([FILES / "thermal_path.py"])
    assert EVIDENCE["thermal_path"].meaning == EFFECTS["thermal_path"].description
    assert list(EVIDENCE) == list(EFFECTS) and len(EVIDENCE) == len(built_in) + 1
    given([])
    assert list(EVIDENCE) == built_in


def test_a_channel_that_no_record_has_is_asked_for(given, tmp_path):
    path = tmp_path / "slow_amplifier.py"
    path.write_text(SLOW.replace('"before", 1, True\n', '"before", 1, True\n    channel = "force_N"\n'))
    given([path])
    case = next(short())
    with pytest.raises(InputError, match=r"--declared slow_amplifier: .*force_N"):
        diagnose(case.train, declared=["slow_amplifier"])


def test_a_case_that_fails_is_an_outcome():
    broken = OwnCase("given", "no such example", with_physics("friction", LOOKED_AT))
    outcome = run(broken)
    assert not outcome.is_right and "no such file" in outcome.failure
    assert own_effects() == {} and Path(FILES).is_dir()
