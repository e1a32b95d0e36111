"""Records of one loop, gone through again and again: what opens it has many imitations."""

import numpy as np
import pytest
from diagnosis.designed import measured, stage
from scipy.signal import sawtooth

from it2hys.diagnosis import Diagnosis, diagnose

LENGTH, CYCLES = 2000, 5


def diagnosed(pair: tuple[str, str], seed: int, form: str, excluded: str = "") -> Diagnosis:
    """Diagnose a record of the whole range of a stage of `designed`, from rest."""
    case = stage(pair, seed, LENGTH)
    turns = CYCLES * np.arange(LENGTH) / (LENGTH - 1)
    sine, triangle = 1.0 - np.cos(2.0 * np.pi * turns), 1.0 + sawtooth(2.0 * np.pi * turns, 0.5)
    greatest = max(float(r.voltage.max()) for r in case.train)
    voltage = 0.5 * greatest * {"sine": sine, "triangle": triangle}[form]
    record = measured(case, voltage, form, 3, case.noise_rms)
    return diagnose([record], excluded=[excluded] if excluded else [])


@pytest.mark.parametrize(
    ("pair", "form", "excluded"),
    [
        pytest.param(("delay", "lag"), "sine", "", marks=pytest.mark.gate),
        (("play", "creep"), "sine", "delay"),
        pytest.param(("play", "creep"), "triangle", "", marks=pytest.mark.gate),
        pytest.param(("delay", "lag"), "triangle", "", marks=pytest.mark.gate),
    ],
)
def test_what_opens_the_loop_is_not_told_apart_and_nothing_is_named_in_its_place(pair, form, excluded):
    """A static curve and creep stood in for play, a resonance for a delay.

    What the user has excluded is no open question.
    """
    found = diagnosed(pair, 98_000, form, excluded)
    assert found.effects == ()
    assert found.indistinguishable == (tuple(e for e in ("delay", "lag", "play") if e != excluded),)


@pytest.mark.gate
def test_what_changes_from_loop_to_loop_is_named():
    assert diagnosed(("creep", "drift"), 98_001, "triangle").effects == ("drift",)
