"""A line is seen however clear it is, and whatever is missing between."""

import numpy as np
import pytest

from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.records.clues import Clue, Clues, Extent

SAMPLE_TIME, SAMPLES = 1e-3, 4000


def clues(amplitude, frequency, held_out, seed=1):
    rng = np.random.default_rng(seed)
    voltage = np.cumsum(rng.standard_normal(SAMPLES))
    time, used = SAMPLE_TIME * np.arange(SAMPLES), np.ones(SAMPLES, dtype=bool)
    if held_out:  # as where parts of a record decide
        used[np.isin(np.arange(SAMPLES) * 10 // SAMPLES, (2, 5, 8))] = False
    residual = 1e-8 * rng.standard_normal(SAMPLES) + amplitude * np.sin(2.0 * np.pi * frequency * time)
    zero = np.zeros(SAMPLES)
    clue = Clue(voltage, zero, zero, 1e-7 * voltage + residual, residual, used)
    extent = Extent(SAMPLE_TIME, SAMPLES * SAMPLE_TIME, (-50.0, 50.0), (-5e-6, 5e-6))
    return Clues(extent, [clue])


@pytest.mark.parametrize("held_out", [False, True])
@pytest.mark.parametrize("frequency", [50.0, 49.94, 16.67])
@pytest.mark.parametrize("amplitude", [1e-8, 1e-7, 1e-6])
def test_a_clear_line_is_not_hidden_by_what_it_spreads(amplitude, frequency, held_out):
    """Of 14 times the noise, on a record of which parts decided, it had a p-value of 0.25."""
    found = EVIDENCE["hum"].signature(clues(amplitude, frequency, held_out))
    assert found.p_value < 1e-4
    assert float(found.text.split(" at ")[1].split()[0]) == pytest.approx(frequency, rel=2e-3)


@pytest.mark.parametrize("held_out", [False, True])
def test_noise_has_no_line(held_out):
    p_values = [
        EVIDENCE["hum"].signature(clues(0.0, 1.0, held_out, seed)).p_value for seed in range(20)
    ]
    assert np.mean(np.array(p_values) < 0.05) <= 0.15
