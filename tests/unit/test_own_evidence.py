"""Evidence on an effect of the user's own: what follows from its declaration, without building it."""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from it2hys.diagnosis.evidence.own import OwnEvidence
from it2hys.model.own_loading import load_effect
from it2hys.records.clues import Clue, Clues, Extent

EXAMPLES = Path(__file__).parents[2] / "examples" / "own_effects"
TS, COUNT, NOISE = 1e-4, 700, 5e-9
FORCED = '''"""A stage that force bends."""
from it2hys import OwnEffect, OwnParameter

class Bending(OwnEffect):
    name, side, channel = "bending", "behind", "force_N"
    parameters = (OwnParameter("compliance", "m/N", 0.0, 1e-6, (1e-9,)),)

    def step(self, values, state, x, around):
        return x - values["bending.compliance"] * around.force, []

EFFECT = Bending()
'''


def clues(residual, force: float = 0.0, channel: bool = False) -> Clues:
    """Return three records of a stage that follows its voltage; `residual` is told a displacement."""
    records, t = [], np.arange(COUNT) * TS
    for i in range(3):
        rng = np.random.default_rng(i)
        steps = np.repeat(rng.uniform(0.0, 60.0, COUNT // 70), 70)
        voltage = steps + 20.0 - 20.0 * np.cos(2.0 * np.pi * rng.uniform(20.0, 60.0) * t)
        model = 1.4e-7 * lfilter([0.1], [1.0, -0.9], voltage, zi=[0.9 * voltage[0]])[0]
        own = force * np.sin(2.0 * np.pi * 35.0 * t)
        left = residual(model, own)
        temperature = 293.15 + 3.0 * np.sin(2.0 * np.pi * 11.0 * t)
        used = np.ones(COUNT, bool)
        records.append(Clue(voltage, own, temperature, model + left, left, used))
    channels = ((-force, force), (290.15, 296.15)) if channel else (None, None)
    return Clues(Extent(TS, COUNT * TS, (0.0, 100.0), (0.0, 14e-6), *channels), records)


def evidence(example: str) -> OwnEvidence:
    return OwnEvidence(load_effect(EXAMPLES / f"{example}.py"))


def coloured(rng: np.random.Generator) -> np.ndarray:
    return lfilter([NOISE], [1.0, -0.5], rng.standard_normal(COUNT))


@pytest.mark.parametrize("example", ["second_resonance", "friction", "thermal_path", "neural"])
def test_noise_has_a_small_p_value_as_seldom_as_it_says(example):
    """As often as a p-value says, or less: it is corrected for the guesses that were tried."""
    own, p = evidence(example), []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        p.append(own.signature(clues(lambda model, force, rng=rng: coloured(rng))).p_value)
    # 40 draws: 2 below 0.05 and 10 below 0.25 are expected of uniform ones; more by chance in 1e-3
    assert np.mean(np.array(p) < 0.05) <= 0.175 and np.mean(np.array(p) < 0.25) <= 0.475, np.sort(p)
    assert max(p) > 0.5


def test_what_the_effect_adds_is_told_from_noise():
    def ringing(model, force):
        """Ring at 190 Hz, which is none of the guesses, about the displacement."""
        rng = np.random.default_rng(1)
        angle, radius = 2.0 * np.pi * 190.0 * TS, 0.996
        a = [1.0, -2.0 * radius * np.cos(angle), radius**2]
        moved = model - model[0]
        return 0.01 * (lfilter([sum(a)], a, moved) - moved) + coloured(rng)

    found = evidence("second_resonance").signature(clues(ringing))
    assert found.p_value < 1e-3 and found.statistic > 0.3, found
    assert "'second_resonance'" in found.text and "frequency = 180 Hz" in found.text


@pytest.mark.parametrize(
    "path", sorted((Path(__file__).parent / "own").glob("*.py")), ids=lambda p: p.stem
)
def test_every_kind_of_effect_has_a_signature(path):
    """Before and behind the core and in the reading, with and without states, a channel, a rest."""
    rng = np.random.default_rng(0)
    found = OwnEvidence(load_effect(path)).signature(
        clues(lambda model, force: coloured(rng), 20.0, True)
    )
    assert 1e-3 < found.p_value <= 1.0 and 0.0 <= found.statistic < 0.1


def test_guesses_are_all_combinations():
    guesses = evidence("second_resonance").guesses(clues(lambda model, force: 0.0 * model))
    assert len(guesses) == 6 and all(g["second_resonance.gain"] == 0.1 for g in guesses)
    assert len({g["second_resonance.frequency"] for g in guesses}) == 6
    assert len(evidence("friction").guesses(clues(lambda model, force: 0.0 * model))) == 2


def test_an_effect_that_needs_a_channel_waits_for_it(tmp_path):
    path = tmp_path / "bending.py"
    path.write_text(FORCED)
    own = OwnEvidence(load_effect(path))
    assert own.channel == "force" and not own.of_any_loop
    rng = np.random.default_rng(0)

    def left(model, force):
        return -2e-9 * force + coloured(rng)

    missing = clues(left, force=20.0)
    assert own.guesses(missing) == [] and own.signature(missing) is None
    told = clues(left, force=20.0, channel=True)
    assert own.guesses(told) == [{"bending.compliance": 1e-9}]
    assert own.signature(told).p_value < 1e-6
