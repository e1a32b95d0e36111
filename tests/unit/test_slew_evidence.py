"""Slew limits that records show: also those that all of their steps exceed."""

import numpy as np
import pytest

from it2hys.diagnosis.evidence.slew import EVIDENCE
from it2hys.records.clues import Clue, Clues, Extent

TS, GAIN, NOISE = 1e-4, 0.15e-6, 0.01e-6


def limited(voltage: np.ndarray, most: float) -> np.ndarray:
    """Return the voltage as far as it may change from sample to sample."""
    result = voltage.copy()
    for k in range(1, len(voltage)):
        result[k] = result[k - 1] + np.clip(voltage[k] - result[k - 1], -most, most)
    return result


def clues(voltage: np.ndarray, most: float) -> Clues:
    """Return those of a record whose model knows no limit."""
    rng, model = np.random.default_rng(3), GAIN * voltage
    residual = GAIN * limited(voltage, most) - model + NOISE * rng.standard_normal(len(voltage))
    extent = Extent(TS, TS * len(voltage), (0.0, 100.0), (0.0, 15e-6))
    zero, used = np.zeros(len(voltage)), np.ones(len(voltage), bool)
    return Clues(extent, [Clue(voltage, zero, zero, model, residual, used)])


def steps(held: int) -> np.ndarray:
    return np.repeat(np.random.default_rng(2).uniform(0.0, 100.0, 1200 // held), held)


@pytest.mark.parametrize("held", [4, 12, 60])
def test_a_limit_far_below_all_steps_is_tried_and_seen(held):
    """At 47 kV/s a step of 30 V is not through after the four samples that it was held."""
    found = clues(steps(held), 4.7)
    rates = np.array([g["slew.rate"] for g in EVIDENCE.guesses(found)])
    assert np.min(np.abs(np.log(rates / 47e3))) < 0.2
    signature = EVIDENCE.signature(found)
    assert signature.p_value < 1e-3 and signature.statistic > 0.5


def test_no_limit_is_tried_that_lets_hardly_anything_through():
    voltage = 50.0 * (1.0 - np.cos(np.linspace(0.0, 40.0 * np.pi, 1200)))
    rates = np.array([g["slew.rate"] for g in EVIDENCE.guesses(clues(voltage, 4.7))])
    passed = limited(voltage, TS * rates.min())
    assert np.std(passed) > 0.05 * np.std(voltage)
