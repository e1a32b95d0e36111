"""A voltage that answers the displacement is noticed, and no voltage that was chosen beforehand is."""

import numpy as np
import pytest
from conftest import YAN9A, needs_measured_records
from diagnosis import simulator as sim
from diagnosis import voltages
from diagnosis.closed_loop import regulate
from scipy import signal

from it2hys.designs.families import FAMILIES
from it2hys.designs.limits import Wanted, limits_of
from it2hys.records import Record, read_record
from it2hys.records.feedback import find_feedback
from it2hys.stand import Stand, excitations

TS, SAMPLES = 1e-4, 1500
TIME = np.arange(SAMPLES) * TS
DRIVES = (
    voltages.two_sines, voltages.sine, voltages.slow_sine, voltages.triangle, voltages.staircase,
    voltages.multisine, voltages.chirp, voltages.decaying, voltages.long_hold,
)  # fmt: skip
SIGNALS = {
    "identification": excitations.identification,
    "validation sine": lambda t: excitations.validation_sine(t, 20.0),
    "100 and 50 Hz": excitations.sum_100_50,
    "sine": lambda t: excitations.sine(t, 30.0),
    "triangle": excitations.triangle,
    "steps": lambda t: excitations.steps(t, [0.0, 40.0, 105.0, 20.0], 0.03),
    "chirp": lambda t: excitations.chirp(t, 5.0, 500.0, t[-1]),
    "multisine": lambda t: excitations.multisine(t, [13.0, 47.0, 91.0, 210.0, 480.0, 1300.0]),
    "decaying": lambda t: excitations.decaying(t, 40.0, 0.05),
}
#: What becomes of a voltage before it stands in a file.
WRITTEN = {
    "as played": lambda v, rng: v,
    "measured with noise": lambda v, rng: v + 0.02 * rng.standard_normal(len(v)),
    "converted": lambda v, rng: 0.0032 * np.round(v / 0.0032),
    "six digits": lambda v, rng: np.round(v, 6),
}


def record(voltage, displacement):
    """Return a record of signals in V and um."""
    return Record("stage", np.arange(len(voltage)) * TS, voltage, 1e-6 * displacement, TS)


def answers(voltage, displacement):
    """Return what is found, read after the voltage of a sample acted and just before it is set."""
    found = [record(voltage, displacement), record(voltage[1:], displacement[:-1])]
    return [find_feedback(r) for r in found]


@pytest.mark.parametrize("draw", DRIVES, ids=lambda draw: draw.__name__)
@pytest.mark.parametrize("seed", range(2))
def test_no_drive_is_taken_for_a_controller_s(draw, seed):
    rng = np.random.default_rng(seed)
    voltage = draw(rng, TIME, 105.0)
    effects = {
        "play": sim.Play("exponential", 20.0, 0.6, 105.0),
        "creep": sim.Creep.logarithmic(0.1, 5e-3, 1.0),
        "resonance": sim.Resonance(rng.uniform(300.0, 2000.0), 0.02),
        "delay": sim.Delay(rng.integers(0, 5) * TS),
        "wander": sim.Wander(0.2, seed),
        "hum": sim.Hum(0.05, 50.0, seed),
    }
    chosen = {name: effect for name, effect in effects.items() if rng.random() < 0.5}
    around = sim.Surroundings(sim.Grid(TS, 4, bool(rng.integers(2))), TIME[None])
    clean = sim.Plant(sim.TABLE_1, chosen).run(voltage[None], around)[0]
    for noise in (0.0, 0.001, 0.006, 0.1):
        reading = clean + noise * rng.standard_normal(SAMPLES)
        for write in WRITTEN.values():
            assert answers(write(voltage, rng), reading) == [None, None]


@pytest.mark.parametrize("name", SIGNALS)
def test_no_excitation_of_the_stand_is_taken_for_a_controller_s(name):
    voltage = SIGNALS[name](TIME)
    displacement = 1e6 * Stand().record(voltage, "stand", seed=3).displacement
    assert answers(voltage, displacement) == [None, None]


@pytest.mark.parametrize("seed", [59, 108])
def test_a_drive_that_changes_its_kind_is_none(seed):
    """Its own past tells its corners worse than its sines: there anything may seem to help."""
    rng = np.random.default_rng(seed)
    rig = limits_of(Wanted(duration=0.12, rate=105.0 / (10 * TS)), (0.0, 105.0), TS)
    family = FAMILIES["steps and multisine"]
    voltage = family.voltage(rng.uniform(size=family.size), rig)
    clock = np.arange(len(voltage)) * TS
    effects = {"creep": sim.Creep.logarithmic(0.1, 5e-3, 1.0)} if seed % 2 else {}
    around = sim.Surroundings(sim.Grid(TS, 4, True), clock[None])
    clean = sim.Plant(sim.TABLE_1, effects).run(voltage[None], around)[0]
    reading = clean + 0.006 * rng.standard_normal(len(voltage))
    assert find_feedback(record(voltage, reading)) is None


@pytest.mark.parametrize("band", [0.02, 0.2, 0.6])
def test_a_random_voltage_is_none(band):
    rng = np.random.default_rng(5)
    voltage = signal.lfilter(*signal.butter(2, band), rng.standard_normal(SAMPLES))
    voltage = 50.0 + 15.0 * voltage / voltage.std()
    reading = sim.run_base(sim.TABLE_1, voltage[None])[0] + 0.006 * rng.standard_normal(SAMPLES)
    assert answers(voltage, reading) == [None, None]


@needs_measured_records
@pytest.mark.parametrize("name", ["train", "minor_loops", "test"])
def test_the_measured_stage_was_in_open_loop(name):
    assert find_feedback(read_record(YAN9A / f"{name}.csv")) is None


@pytest.mark.parametrize("draw", DRIVES, ids=lambda draw: draw.__name__)
@pytest.mark.parametrize(("proportional", "integral", "late"), [(0.5, 0.5, 1), (0.0, 0.2, 1)])
def test_a_controller_is_noticed_whatever_it_follows(draw, proportional, integral, late):
    rng = np.random.default_rng(7)
    reference = 1.0 + 0.12 * draw(rng, TIME, 105.0)
    pair = regulate(reference, rng, proportional, integral, ticks_late=late)
    after, before = answers(*pair)
    assert after.samples == late and before.samples == late - 1
    for found in (after, before):
        assert 0.05 < found.share <= 1.0 and found.errors > 6.0


@pytest.mark.parametrize("late", [2, 5])
def test_a_controller_that_computes_for_long_is_noticed(late):
    rng = np.random.default_rng(8)
    voltage, reading = regulate(5.0 + 0.0 * TIME, rng, 0.1, 0.1, ticks_late=late)
    assert find_feedback(record(voltage, reading)).samples == late


def test_a_regulated_test_stand_is_noticed():
    running, rng = Stand().start(4), np.random.default_rng(4)
    voltage, displacement = np.zeros((2, SAMPLES))
    reference = 1e-6 * (7.0 - 6.0 * np.cos(2.0 * np.pi * 25.0 * TIME))
    push = np.convolve(rng.normal(0.0, 40.0, SAMPLES + 49), np.ones(50) / 7.0, "valid")
    for k in range(1, SAMPLES):
        voltage[k] = voltage[k - 1] + 2e6 * (reference[k] - displacement[k - 1])
        displacement[k] = running.step(voltage[k], force=push[k])
    assert find_feedback(record(voltage, 1e6 * displacement)) is not None


def test_a_short_or_a_constant_record_says_nothing():
    voltage, reading = regulate(5.0 + 0.0 * TIME, np.random.default_rng(9), 0.5, 0.5)
    assert find_feedback(record(voltage[:200], reading[:200])) is None
    assert find_feedback(record(np.full(SAMPLES, 5.0), reading)) is None
    assert find_feedback(record(voltage, np.full(SAMPLES, 5.0))) is None
