"""How much of a displacement its voltage explains, how wide its loop is, and what rings after steps."""

import numpy as np
import pytest
from diagnosis import simulator as sim
from diagnosis import voltages

from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.evidence.resonance import _after_steps
from it2hys.identification.explained import explained_by_model, explained_by_voltage
from it2hys.identification.findings import sensor_step
from it2hys.records import Record
from it2hys.records.clues import Clue, Clues, Extent
from it2hys.records.loop_width import wide_loop

TS, SAMPLES = 1e-4, 2000
TIME = np.arange(SAMPLES) * TS
ALL = np.ones(SAMPLES, bool)


def stage(voltage, **effects):
    """Return what a simulated stage reads, um."""
    around = sim.Surroundings(sim.Grid(TS, 10), TIME[None])
    return sim.Plant(sim.TABLE_1, effects).run(voltage[None], around)[0]


@pytest.mark.parametrize(
    "draw", [voltages.two_sines, voltages.staircase, voltages.chirp, voltages.multisine]
)
def test_a_stage_s_voltage_explains_nearly_all(draw):
    voltage = draw(np.random.default_rng(1), TIME, 105.0)
    reading = stage(
        voltage,
        play=sim.Play("exponential", 20.0, 0.6, 105.0),
        creep=sim.Creep.logarithmic(0.1, 5e-3, 1.0),
        resonance=sim.Resonance(900.0, 0.05),
    )
    assert explained_by_voltage(voltage, reading, ALL) > 0.9


@pytest.mark.parametrize("seed", range(4))
def test_of_three_inputs_one_explains_its_share(seed):
    rng = np.random.default_rng(seed)
    inputs = rng.standard_normal((3, SAMPLES))
    size = rng.uniform(0.5, 2.0, 3)
    truth = size[0] ** 2 / np.sum(size**2)
    assert explained_by_voltage(inputs[0], size @ inputs, ALL) == pytest.approx(truth, abs=0.06)


def test_noise_is_not_explained_and_what_is_constant_has_no_share():
    rng = np.random.default_rng(2)
    voltage = voltages.multisine(rng, TIME, 105.0)
    assert explained_by_voltage(voltage, rng.standard_normal(SAMPLES), ALL) < 0.02
    assert np.isnan(explained_by_voltage(voltage, np.ones(SAMPLES), ALL))
    assert np.isnan(explained_by_voltage(np.ones(SAMPLES), voltage, ALL))


def test_samples_that_do_not_count_do_not_count():
    rng = np.random.default_rng(3)
    voltage = voltages.multisine(rng, TIME, 105.0)
    reading, used = stage(voltage), TIME > 0.02
    spoilt = np.where(used, reading, 100.0 * rng.standard_normal(SAMPLES))
    assert explained_by_voltage(voltage, spoilt, used) > 0.95
    assert explained_by_model(spoilt, reading, used) == 1.0
    assert explained_by_model(reading, np.full(SAMPLES, np.inf), used) != 1.0
    assert explained_by_model(reading, -reading, used) == 0.0


def test_a_loop_of_a_stage_is_not_too_wide_and_one_of_half_the_travel_is():
    voltage = voltages.slow_sine(np.random.default_rng(4), TIME, 105.0)
    reading = stage(voltage, play=sim.Play("uniform", 52.5, 0.5, 105.0))
    record = Record("a", TIME, voltage, 1e-6 * reading, TS)
    assert wide_loop(record) == ""
    late = np.roll(reading, int(0.2 / 8.0 / TS))
    assert "on the way up" in wide_loop(Record("a", TIME, voltage, 1e-6 * late, TS))


@pytest.mark.parametrize(("step", "found"), [(0.05, 0.05), (1e-6, None), (0.0, None)])
def test_the_step_of_a_sensor_is_read_off_its_values(step, found):
    reading = stage(voltages.two_sines(np.random.default_rng(5), TIME, 105.0))
    coarse = step * np.round(reading / step) if step else reading
    seen = sensor_step(Record("a", TIME, np.sin(TIME), 1e-6 * coarse, TS))
    assert seen == (None if found is None else pytest.approx(1e-6 * found, rel=1e-6))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("damping", [0.005, 0.02, 0.08])
def test_a_ring_after_steps_is_guessed_and_seen(seed, damping):
    rng = np.random.default_rng(seed)
    frequency = rng.uniform(300.0, 2000.0)
    records = []
    for draw in (voltages.staircase, voltages.slow_sine):
        voltage = draw(rng, TIME, 105.0)
        rigid = stage(voltage)
        reading = stage(voltage, resonance=sim.Resonance(frequency, damping))
        reading += 0.006 * rng.standard_normal(SAMPLES)
        heat = np.full(SAMPLES, 293.15)
        records.append(
            Clue(voltage, 0.0 * voltage, heat, 1e-6 * reading, 1e-6 * (reading - rigid), ALL)
        )
    clues = Clues(Extent(TS, SAMPLES * TS, (0.0, 105.0), (0.0, 16e-6)), records)
    last = EVIDENCE["resonance"].guesses(clues)[-2:]
    best = min(last, key=lambda g: abs(g["resonance.frequency"] - frequency))
    assert best["resonance.frequency"] == pytest.approx(frequency, rel=0.02)
    assert 0.5 < best["resonance.damping"] / damping < 2.0
    seen = EVIDENCE["resonance"].signature(clues)
    assert seen.p_value < 0.05
    # noise does not ring
    quiet = [
        Clue(
            c.voltage, c.force, c.temperature, c.displacement, 6e-9 * rng.standard_normal(SAMPLES), ALL
        )
        for c in records
    ]
    assert EVIDENCE["resonance"].signature(Clues(clues.extent, quiet)).p_value > 1e-3


def test_a_ring_after_the_only_step_is_seen_and_a_pulse_there_is_none():
    """A single event decides nothing where errors are counted by blocks."""
    rng = np.random.default_rng(7)
    voltage = np.where(TIME < 0.05, 0.0, 50.0 + 40.0 * np.sin(2 * np.pi * 5.0 * (TIME - 0.05)))
    first = int(np.argmax(voltage > 0.0))
    after = np.arange(SAMPLES - first)
    ring = np.exp(-0.03 * after) * np.cos(1.1 * after)
    pulse = np.exp(-0.7 * after)
    # what else is left changes slowly
    rest = 0.02 * np.convolve(rng.standard_normal(SAMPLES + 99), np.ones(100) / 10.0, "valid")
    chances = []
    for shape in (ring, pulse):
        left = rest + 0.006 * rng.standard_normal(SAMPLES)
        left[first:] += shape
        record = Clue(
            voltage, 0.0 * voltage, np.full(SAMPLES, 293.15), 1e-7 * voltage, 1e-6 * left, ALL
        )
        clues = Clues(Extent(TS, SAMPLES * TS, (0.0, 105.0), (0.0, 16e-6)), [record])
        chances.append(min((chance for _, _, chance in _after_steps(clues)), default=1.0))
    assert chances == [pytest.approx(0.0, abs=1e-12), 1.0]
