"""A record that begins while the stage rings from before: no start at rest can follow that."""

import numpy as np
import pytest
from scipy.signal import lfilter, lfiltic

from it2hys.diagnosis import diagnose
from it2hys.identification import Options
from it2hys.identification.preparation import prepare
from it2hys.identification.ringing import ringing_out
from it2hys.model.chain import EFFECTS
from it2hys.records import Record

SAMPLES, TS, NOISE = 3000, 1e-4, 5e-9
FREQUENCY, DAMPING = 800.0, 0.02
T = TS * np.arange(SAMPLES)


def ringing(x: np.ndarray, before: float, seed: int = 0) -> np.ndarray:
    """Return what a mass on a spring makes of x, (N,), m, that was `before`, m, until the record."""
    angle = 2.0 * np.pi * FREQUENCY * TS
    radius = np.exp(-DAMPING * angle)
    poles = [1.0, -2.0 * radius * np.cos(angle * np.sqrt(1.0 - DAMPING**2)), radius**2]
    y = lfilter([sum(poles)], poles, x, zi=lfiltic([1.0], poles, [before, before]))[0]
    return y + NOISE * np.random.default_rng(seed).standard_normal(len(x))


def steps(seed: int) -> np.ndarray:
    """Return a voltage of steps, V, the first of which is late."""
    levels = np.random.default_rng(seed).uniform(22.0, 78.0, 8)
    return levels[np.minimum((T / 0.04).astype(int), 7)]


def curve(voltage: np.ndarray) -> np.ndarray:
    """Return a displacement, m."""
    return 1e-7 * voltage * (1.0 + 5e-4 * voltage)


def test_a_record_is_left_out_until_what_rings_has_sunk_into_the_noise():
    voltage = 50.0 - 30.0 * np.cos(2.0 * np.pi * 6.0 * T)
    x = curve(voltage)
    left_out = ringing_out(voltage, ringing(x, x[0] + 1e-6), NOISE)
    constant = 1.0 / (2.0 * np.pi * FREQUENCY * DAMPING * TS)
    assert left_out == pytest.approx(np.log(1e-6 / NOISE) * constant, rel=0.2)


@pytest.mark.parametrize("seed", range(5))
def test_what_the_record_itself_makes_ring_is_fitted(seed: int):
    """From rest, the first step within a few samples: a model follows that."""
    voltage = np.concatenate([[50.0] * (seed + 1), steps(seed)[: -seed - 1]])
    x = curve(voltage)
    assert ringing_out(voltage, ringing(x, x[0]), NOISE) == 0
    # a triangle sets off at once, which makes it ring a little
    triangle = 80.0 * np.abs((T / 0.05 + 1.0) % 2.0 - 1.0)
    assert ringing_out(triangle, ringing(curve(triangle), 0.0, seed), NOISE) == 0


def test_a_step_ends_what_is_left_out():
    voltage = steps(3)
    x = curve(voltage)
    left_out = ringing_out(voltage, ringing(x, x[0] + 3e-6), NOISE)
    assert 300 < left_out <= 400


@pytest.mark.parametrize("frequency", [50.0, 333.0, 1200.0])
def test_a_line_goes_on_and_is_no_ringing(frequency: float):
    voltage = 50.0 - 30.0 * np.cos(2.0 * np.pi * 6.0 * T)
    line = 20.0 * NOISE * np.sin(2.0 * np.pi * frequency * T + 1.0)
    y = curve(voltage) + line + NOISE * np.random.default_rng(1).standard_normal(SAMPLES)
    assert ringing_out(voltage, y, NOISE) == 0


def test_spikes_and_a_clipped_sensor_do_not_hide_ringing():
    voltage = 50.0 - 30.0 * np.cos(2.0 * np.pi * 6.0 * T)
    x = curve(voltage)
    y = ringing(x, x[0] + 1e-6)
    clean = prepare(Record("clean", T, voltage, y, TS)).skip
    odd = np.zeros(SAMPLES, dtype=bool)
    odd[[7, 60, 61, 200]] = True
    spoilt = Record("spoilt", T, voltage, np.where(odd, y + 5e-6, y), TS, outliers=odd)
    assert prepare(spoilt).skip == pytest.approx(clean, rel=0.2)


def test_a_stage_of_which_most_records_begin_ringing_is_identified():
    """Fitted, the first samples would outweigh all others: they are 200 times the noise."""
    records = []
    for seed, before in enumerate((2e-6, -1e-6, 0.0, 1e-6, 1.5e-6)):
        voltage = steps(seed) if seed % 2 else 50.0 - 30.0 * np.cos(2.0 * np.pi * (5.0 + seed) * T)
        x = curve(voltage)
        records.append(Record(f"{seed}", T, voltage, ringing(x, x[0] + before, seed), TS))
    assert [prepare(r).skip > 0 for r in records] == [True, True, False, True, True]
    others = [e for e in EFFECTS if e not in ("resonance", "delay")]
    found = diagnose(
        records[:3], [records[3]], [records[4]], declared=["resonance"], excluded=others,
        options=Options(starts=12),
    )  # fmt: skip
    assert found.parameters["resonance.frequency"] == pytest.approx(FREQUENCY, rel=1e-3)
    assert found.parameters["resonance.damping"] == pytest.approx(DAMPING, rel=0.02)
    assert not found.unexplained, found.left_over
    for judged in found.after:
        assert judged.e_rms < 1.2 * NOISE
    told = [w for w in found.warnings if "rings from before it" in w]
    assert [w.split("'")[1] for w in told] == ["0", "1", "3", "4"]
