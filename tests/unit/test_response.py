"""Records that no stage gave are refused in the user's words; whatever a stage gives passes."""

import re

import numpy as np
import pytest
from conftest import YAN9A, needs_measured_records
from diagnosis import simulator as sim
from diagnosis import voltages
from scipy import signal

from it2hys import identify
from it2hys.errors import InputError
from it2hys.records import Record, check_response, read_record, write_record
from it2hys.stand import Stand

TS = 1e-4
DRIVES = (
    voltages.two_sines, voltages.sine, voltages.slow_sine, voltages.triangle, voltages.staircase,
    voltages.multisine, voltages.chirp, voltages.decaying, voltages.long_hold,
)  # fmt: skip
FEW_SWINGS = {
    "ramp": lambda t: 105.0 * t / t[-1],
    "up and down": lambda t: 105.0 * (1.0 - np.abs(2.0 * t / t[-1] - 1.0)),
    "step": lambda t: np.where(t < 0.2 * t[-1], 0.0, 80.0),
    "pulse": lambda t: np.where((t > 0.4 * t[-1]) & (t < 0.6 * t[-1]), 105.0, 0.0),
    "one sine": lambda t: 52.5 - 52.5 * np.cos(2.0 * np.pi * 1.3 * t / t[-1]),
    "three levels": lambda t: np.array([40.0, 105.0, 20.0])[np.minimum(3 * t / t[-1], 2).astype(int)],
}
REVERSED = (
    r"the displacement falls by [\d.]+ µm while the voltage rises from [-\d.]+ to [\d.]+ V: "
    r"the sensor's sign is reversed, or the stage pulls; add --invert-displacement"
)


def record(voltage, displacement, **channels):
    """Return a record of signals in V and um."""
    time = np.arange(len(voltage)) * TS
    return Record("stage", time, voltage, 1e-6 * np.asarray(displacement), TS, **channels)


def stage(voltage, rng, *, loop=0.0, **effects):
    """Return what a simulated stage does, um; the width of its loop is a share of the range."""
    effects = {name: effect for name, effect in effects.items() if effect}
    if loop:
        # a ramp's branches of a uniform density up to half the range are half its share apart
        effects["play"] = sim.Play("uniform", 0.5 * 105.0, min(2.0 * loop, 1.0), 105.0)
    grid = sim.Grid(TS, 4, bool(rng.integers(2)))
    around = sim.Surroundings(grid, np.arange(len(voltage))[None] * TS)
    return sim.Plant(sim.TABLE_1, effects).run(voltage[None], around)[0]


def assert_passes_and_its_mirror_image_does_not(voltage, displacement, **channels):
    check_response(record(voltage, displacement, **channels))
    mirrored = record(voltage, -np.asarray(displacement), **channels)
    with pytest.raises(InputError, match=REVERSED):
        check_response(mirrored)
    check_response(mirrored.invert())


# --- what a stage gives --------------------------------------------------------------------------


@pytest.mark.parametrize("draw", DRIVES, ids=lambda draw: draw.__name__)
@pytest.mark.parametrize("seed", range(3))
def test_a_stage_with_everything_at_once_passes(draw, seed):
    rng = np.random.default_rng(seed)
    voltage = draw(rng, np.arange(3000) * TS, 105.0)
    displacement = stage(
        voltage,
        rng,
        loop=0.3 * rng.random(),
        delay=sim.Delay(rng.integers(0, 8) * TS),
        creep=sim.Creep.logarithmic(0.2 * rng.random(), 5e-3, 1.0),
        resonance=sim.Resonance(rng.uniform(500.0, 2000.0), 0.02),
        drift=sim.Drift(rate=rng.uniform(-10.0, 10.0)),
    )
    noise = rng.uniform(0.0, 1.0 / 3.0) * np.ptp(displacement) * rng.standard_normal(3000)
    zero = rng.choice([0.0, -100.0, 2000.0])
    assert_passes_and_its_mirror_image_does_not(voltage, displacement + noise + zero)


@pytest.mark.parametrize("name", FEW_SWINGS)
@pytest.mark.parametrize("seed", range(3))
def test_a_few_swings_are_enough(name, seed):
    rng = np.random.default_rng(seed)
    voltage = FEW_SWINGS[name](np.arange(1000) * TS)
    displacement = stage(voltage, rng, loop=0.15, creep=sim.Creep.logarithmic(0.1, 5e-3, 1.0))
    noise = 0.1 * np.ptp(displacement) * rng.standard_normal(1000)
    drift = rng.uniform(-0.3, 0.3) * np.ptp(displacement) * np.linspace(0.0, 1.0, 1000)
    assert_passes_and_its_mirror_image_does_not(voltage, displacement + noise + drift)


@pytest.mark.parametrize("seed", range(4))
def test_a_small_signal_far_from_zero_under_a_greater_drift_passes(seed):
    rng = np.random.default_rng(seed)
    time = np.arange(6000) * TS
    voltage = 50.0 + 0.5 * np.sin(2.0 * np.pi * 30.0 * time)
    response = 0.05 * np.sin(2.0 * np.pi * 30.0 * time - 0.3) + 0.02 * rng.standard_normal(6000)
    walk = np.cumsum(rng.standard_normal(6000)) / np.sqrt(6000)
    for drift in (0.5 * time / time[-1], -0.5 * time / time[-1], 0.3 * walk):
        check_response(record(voltage, response + drift - 100.0))


@pytest.mark.parametrize("seed", range(3))
def test_a_stage_that_a_force_moves_more_than_the_voltage_passes(seed):
    rng = np.random.default_rng(seed)
    time = np.arange(5000) * TS
    voltage, force, heat = (voltages.multisine(rng, time, 100.0) for _ in range(3))
    displacement = 0.1 * voltage - 0.2 * force + 0.02 * heat + 0.02 * rng.standard_normal(5000)
    check_response(record(voltage, displacement))
    check_response(record(voltage, displacement, force=force, temperature=293.0 + heat))


def test_a_resonance_a_dead_time_and_a_quantised_reading_pass():
    time = np.arange(5000) * TS
    step = np.where(time < 0.05, 0.0, 50.0)
    ringing = sim.Resonance(300.0, 0.01)
    grid = sim.Grid(TS)
    around = sim.Surroundings(grid, time[None])
    fine = ringing.apply(0.1 * grid.refine(step[None]), around)
    check_response(record(step, grid.sample(fine)[0]))
    for delay in (10, 40):
        late = 5.0 - 5.0 * np.cos(2.0 * np.pi * 20.0 * np.maximum(time - delay * TS, 0.0))
        check_response(record(50.0 - 50.0 * np.cos(2.0 * np.pi * 20.0 * time), late))
        check_response(record(50.0 - 50.0 * np.cos(2.0 * np.pi * 20.0 * time), np.round(late / 3.0)))


def test_a_damper_is_refused_only_where_its_force_has_the_other_sign():
    time = np.arange(4000) * 1e-3
    position = 0.02 * np.sin(2.0 * np.pi * 2.0 * time)
    velocity = np.gradient(position, 1e-3)
    memory, force = 0.0, np.empty(4000)
    for k, v in enumerate(velocity):
        memory = np.clip(memory + 1e-3 * 60.0 * (v - abs(v) * memory), -1.0, 1.0)
        force[k] = 800.0 * v + 300.0 * memory + 50.0 * position[k]
    force *= 10.0 / np.ptp(force)
    for drive in (velocity / np.ptp(velocity), position / np.ptp(position)):
        check_response(record(drive, force))
        check_response(record(force, drive))
    with pytest.raises(InputError, match=REVERSED):
        check_response(record(velocity / np.ptp(velocity), -force))


def test_what_is_not_certain_passes():
    time = np.arange(5000) * TS
    # a sensor's sign or half a cycle of delay: at the end of the band either may be
    fast = 50.0 - 50.0 * np.cos(2.0 * np.pi * 400.0 * time)
    check_response(record(fast, -0.1 * fast))
    # above its resonance a stage lags by less than half a cycle
    grid, around = sim.Grid(TS), sim.Surroundings(sim.Grid(TS), time[None])
    drive = 50.0 - 50.0 * np.cos(2.0 * np.pi * 60.0 * time)
    fine = sim.Resonance(50.0, 0.1).apply(0.1 * grid.refine(drive[None]), around)
    check_response(record(drive, grid.sample(fine)[0]))


@pytest.mark.parametrize("frequency", [0.05, 20.0, 150.0])
def test_a_long_record_is_looked_at_in_parts(frequency):
    rng = np.random.default_rng(0)
    voltage = 50.0 - 50.0 * np.cos(2.0 * np.pi * frequency * np.arange(300_000) * TS)
    lagging = 5.0 - 5.0 * np.cos(2.0 * np.pi * frequency * np.arange(300_000) * TS - 0.2)
    noise = rng.standard_normal(300_000)
    assert_passes_and_its_mirror_image_does_not(voltage, lagging + noise)
    with pytest.raises(InputError, match="no more than chance"):
        check_response(record(voltage, noise))


# --- what no stage gives -------------------------------------------------------------------------


def butterfly(drive, coercive, rng):
    """Return the displacement of a stack driven beyond its coercive field: its polarisation squared."""
    fields = np.abs(rng.normal(coercive, 0.15 * coercive, 60))
    domains, result = -np.ones(60), np.empty(len(drive))
    for k, field in enumerate(drive):
        domains = np.where(field > fields, 1.0, np.where(field < -fields, -1.0, domains))
        result[k] = (domains.mean() + 0.25 * field / np.max(np.abs(drive))) ** 2
    return 10.0 * result / np.ptp(result)


@pytest.mark.parametrize("share", [0.3, 0.5, 0.7])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_butterfly_is_refused_with_what_was_measured(share, sign):
    rng = np.random.default_rng(1)
    drive = 150.0 * np.sin(2.0 * np.pi * 10.0 * np.arange(4000) * TS)
    reading = sign * butterfly(drive, share * 150.0, rng) + 0.1 * rng.standard_normal(4000)
    with pytest.raises(InputError) as caught:
        check_response(record(drive, reading))
    message = str(caught.value)
    ways = {1.0: "falls and rises again", -1.0: "rises and falls again"}
    assert f"the displacement {ways[sign]} while the voltage rises" in message
    found = re.findall(r"([-\d.]+) µm at ([-\d.]+) V", message)
    (left, low), (turn, middle), (right, high) = [(float(y), float(v)) for y, v in found]
    assert low < -140.0 and high > 140.0 and abs(middle) < 0.8 * 150.0
    assert abs(left - right) < 2.0 and sign * (left - turn) > 2.0
    assert "butterfly" in message and "one side of zero volts" in message


@pytest.mark.parametrize("tilt", [-4.0, -2.0, 4.0])
@pytest.mark.parametrize("cycles", [1, 3])
def test_a_butterfly_that_is_not_the_same_on_both_sides_is_no_reversed_sensor(tilt, cycles):
    """Measured ones were: on average they fall, and a sign would not have mended that."""
    rng = np.random.default_rng(2)
    turn = 2.0 * np.pi * np.arange(400 * cycles) / 400
    drive = 1500.0 * np.sin(turn)
    # half a period before, so that the domains are as the drive left them
    whole = 1500.0 * np.sin(np.arange(-np.pi, turn[-1] + 0.01, 2.0 * np.pi / 400))
    reading = butterfly(whole, 900.0, rng)[-len(turn) :] + tilt * drive / 1500.0
    with pytest.raises(InputError, match="butterfly loop"):
        check_response(record(drive, reading + 0.02 * rng.standard_normal(len(turn))))


@pytest.mark.parametrize("lag", np.linspace(0.0, np.pi, 9))
@pytest.mark.parametrize("cycles", [1, 5])
def test_what_lags_is_no_butterfly(lag, cycles):
    """Its branches turn back, but to the opposite at opposite voltages."""
    turn = 2.0 * np.pi * np.arange(400 * cycles) / 400
    drive = 50.0 + 45.0 * np.sin(turn)
    reading = 5.0 * np.sin(turn - lag) + 0.4 * np.sin(2.0 * (turn - lag))
    try:
        check_response(record(drive, reading))
    except InputError as error:
        assert "butterfly" not in str(error)


def test_a_chirp_through_a_resonance_is_no_butterfly():
    """Mean branches of it turn back, but tell nothing of the record."""
    time = np.arange(6000) * 1e-4
    drive = 50.0 * signal.chirp(time, 10.0, time[-1], 3000.0)
    angle, radius = 2.0 * np.pi * 800.0 * 1e-4, np.exp(-0.02 * 2.0 * np.pi * 800.0 * 1e-4)
    poles = [1.0, -2.0 * radius * np.cos(angle), radius**2]
    check_response(record(drive, 0.1 * signal.lfilter([sum(poles)], poles, drive)))


def test_a_curve_that_bends_but_rises_is_no_butterfly():
    drive = np.linspace(-1.0, 1.0, 500)
    drive = np.concatenate([drive, drive[::-1]] * 3)
    for bend in (-0.5, 0.5):
        assert_passes_and_its_mirror_image_does_not(
            50.0 * (drive + 1.0), 10.0 * (drive + bend * drive**2)
        )


NOISES = {
    "white": lambda rng, n: rng.standard_normal(n),
    "coloured": lambda rng, n: np.convolve(rng.standard_normal(n), np.ones(20) / 20, "same"),
    "quantised": lambda rng, n: np.round(0.7 * rng.standard_normal(n)),
    "with a drift": lambda rng, n: rng.standard_normal(n) + 5.0 * np.linspace(0.0, 1.0, n),
    "a walk": lambda rng, n: np.cumsum(rng.standard_normal(n)),
    "a line": lambda rng, n: np.sin(0.0731 * np.arange(n)) + 0.1 * rng.standard_normal(n),
}


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("draw", [voltages.two_sines, voltages.triangle, voltages.multisine])
def test_noise_is_refused_with_how_much_the_voltage_explains(noise, draw):
    rng = np.random.default_rng(4)
    voltage = draw(rng, np.arange(8000) * TS, 105.0)
    with pytest.raises(InputError, match=r"the voltage explains [\d.]+ % of the displacement, no more"):
        check_response(record(voltage, NOISES[noise](rng, 8000)))


def test_white_noise_is_hardly_ever_taken_for_a_response():
    missed = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        time = np.arange(int(rng.choice([200, 600, 2000]))) * TS
        voltage = DRIVES[seed % len(DRIVES)](rng, time, 105.0)
        if np.ptp(voltage) == 0.0:
            continue
        try:
            check_response(record(voltage, rng.standard_normal(len(time))))
            missed += 1
        except InputError:
            pass
    assert missed <= 1


# --- where it is asked ---------------------------------------------------------------------------


@pytest.fixture
def reversed_file(tmp_path):
    voltage = 52.5 - 52.5 * np.cos(2.0 * np.pi * 20.0 * np.arange(2000) * TS)
    write_record(tmp_path / "r.csv", Stand().record(voltage, "r").invert())
    return tmp_path / "r.csv"


def test_a_file_is_refused_by_name_and_read_inverted(reversed_file):
    with pytest.raises(InputError, match=re.escape(f"{reversed_file}: the displacement falls by 14")):
        read_record(reversed_file)
    turned = read_record(reversed_file, invert_displacement=True)
    assert turned.inverted
    assert any("was inverted" in note for note in turned.notes)
    assert np.corrcoef(turned.voltage, turned.displacement)[0, 1] > 0.9


def test_an_option_that_makes_it_wrong_is_named(tmp_path):
    voltage = 52.5 - 52.5 * np.cos(2.0 * np.pi * 20.0 * np.arange(2000) * TS)
    write_record(tmp_path / "r.csv", Stand().record(voltage, "r"))
    with pytest.raises(InputError, match="leave out --invert-displacement"):
        read_record(tmp_path / "r.csv", invert_displacement=True)


def test_the_reference_is_turned_with_the_displacement():
    voltage = 50.0 - 50.0 * np.cos(2.0 * np.pi * 20.0 * np.arange(500) * TS)
    upright = record(voltage, 0.1 * voltage, reference=1e-7 * voltage)
    turned = upright.invert()
    np.testing.assert_array_equal(turned.displacement, -upright.displacement)
    np.testing.assert_array_equal(turned.reference, -upright.reference)
    assert turned.inverted and not turned.invert().inverted


def test_python_asks_too(reversed_file):
    signals = np.genfromtxt(reversed_file, delimiter=",", names=True)
    frame = {name: signals[name] for name in signals.dtype.names}
    given = read_record(reversed_file, invert_displacement=True).invert()
    for item in (frame, str(reversed_file), given):
        with pytest.raises(InputError, match="invert_displacement=True"):
            identify(item, rules=1)
    found = identify(frame, rules=1, invert_displacement=True)
    assert found.parameters["rule[1].q2"] > 0.0


@needs_measured_records
@pytest.mark.parametrize(
    ("name", "fall", "low", "high"),
    [("train", 44, "0", "3.6"), ("minor_loops", 38, "0.2363", "3.424"), ("test", 40, "0.1689", "3.51")],
)
def test_the_measured_stage_passes_and_is_refused_reversed(name, fall, low, high):
    measured = read_record(YAN9A / f"{name}.csv")
    with pytest.raises(InputError) as caught:
        check_response(measured.invert().invert().invert())
    found = re.search(
        r"falls by ([\d.]+) µm while the voltage rises from (\S+) to (\S+) V", str(caught.value)
    )
    assert float(found[1]) == pytest.approx(fall, abs=1.0)
    assert found.groups()[1:] == (low, high)
