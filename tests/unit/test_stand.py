"""The simulated test stand: each part does what it says, and the paper's ranges hold."""

import ast
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import dblquad

import it2hys.stand
from it2hys.errors import InputError
from it2hys.records import Record
from it2hys.stand import (
    LINEAR_SLOPE,
    NOMINAL_GAIN,
    Amplifier,
    Converter,
    Creep,
    Gauge,
    Hum,
    Hysteresis,
    Mechanics,
    Stand,
    ThermalExpansion,
)
from it2hys.stand.linear import ModeBank

TS = 1e-4
IDEAL = Stand(
    dac=None,
    amplifier=None,
    hysteresis=None,
    creep=None,
    mechanics=None,
    thermal=None,
    gauge=None,
    noise=0.0,
    adc=None,
)
ALL_ON = Stand(
    dead_time=3.7e-4,
    amplifier=Amplifier(current=0.05),
    mechanics=Mechanics(damping=0.03),
    hum=Hum(),
)

voltages = st.floats(0.0, 150.0)
histories = st.lists(voltages, max_size=12)


def sine(frequency, periods):
    """Give full-scale sines of the paper, 0 to 105 V, from 0 V."""
    ticks = np.arange(round(periods / (frequency * TS)))
    return 52.5 - 52.5 * np.cos(2.0 * np.pi * frequency * ticks * TS)


def drive(turns, hysteresis):
    """Give a running operator that has been through some turning points."""
    running = hysteresis.start()
    if turns:
        running.advance(np.array(turns, dtype=float))
    return running


def loop(stand, frequency):
    """Give lowest, highest and remanent reading, m, and the loop width over the range."""
    voltage = sine(frequency, 3)
    measured = stand.run(voltage).measured
    period = round(1.0 / (frequency * TS))
    u, y = voltage[-period:], measured[-period:]
    half = period // 2
    grid = np.linspace(1.0, 104.0, 400)
    ascending = np.interp(grid, u[: half + 1], y[: half + 1])
    descending = np.interp(grid, u[half:][::-1], y[half:][::-1])
    return measured.min(), measured.max(), y.min(), np.max(descending - ascending) / np.ptp(y)


# Running the stand ------------------------------------------------------------------------------


def test_same_seed_same_reading():
    voltage = sine(50.0, 1)
    first, second = Stand().run(voltage, seed=3), Stand().run(voltage, seed=3)
    assert np.array_equal(first.measured, second.measured)
    assert not np.array_equal(first.measured, Stand().run(voltage, seed=4).measured)


@pytest.mark.parametrize("stand", [Stand(), ALL_ON, IDEAL], ids=["default", "all on", "ideal"])
def test_batch_equals_sample_by_sample(stand):
    rng = np.random.default_rng(1)
    voltage = np.concatenate([sine(50.0, 1), 120.0 * rng.random(200).cumsum() % 120.0])
    force = 100.0 * rng.random(voltage.size)
    temperature = 293.15 + rng.random(voltage.size)
    batch = stand.run(voltage, seed=5, force=force, temperature=temperature)
    running = stand.start(seed=5)
    inputs = zip(voltage, force, temperature, strict=True)
    single = [(running.step(*sample), running.displacement) for sample in inputs]
    assert np.allclose(single, np.c_[batch.measured, batch.displacement], rtol=0.0, atol=1e-18)
    assert running.amplifier_voltage == pytest.approx(batch.amplifier[-1], rel=1e-12, abs=1e-12)


def test_chunks_do_not_show(monkeypatch):
    voltage = sine(50.0, 2)
    whole = ALL_ON.run(voltage)
    monkeypatch.setattr("it2hys.stand.stand._CHUNK", 37)
    assert np.allclose(ALL_ON.run(voltage).measured, whole.measured, rtol=0.0, atol=1e-18)


def test_reading_answers_to_the_voltage_of_its_own_tick():
    voltage = np.array([0.0, 50.0, 50.0])
    reading = IDEAL.run(voltage)
    assert np.allclose(reading.measured, LINEAR_SLOPE * voltage, atol=1e-18)
    assert np.array_equal(reading.command, voltage)
    assert np.allclose(reading.time, [0.0, 1e-4, 2e-4])


def test_defaults_reproduce_the_range_and_loop_of_the_paper():
    widths = []
    for frequency in (1.0, 5.0, 20.0, 40.0, 100.0):
        low, high, remanence, width = loop(Stand(), frequency)
        assert -0.1e-6 < low < 0.1e-6
        assert 15.2e-6 < high < 15.8e-6
        assert 0.6e-6 < remanence < 1.0e-6
        widths.append(width)
    assert min(widths) > 0.10 and max(widths) < 0.15
    assert max(widths) - min(widths) < 0.02  # what is left is the lag of the gauge


def test_identification_signal_covers_the_range_of_table_1():
    t = np.arange(4000) * TS
    voltage = (
        40.0 * np.sin(2 * np.pi * 50 * t - np.pi / 2)
        + 22.5 * np.sin(2 * np.pi * 25 * t - np.pi / 2)
        + 62.5
    )
    last = Stand().run(voltage).measured[-800:]
    assert last.min() == pytest.approx(0.842742e-6, abs=0.05e-6)
    assert last.max() == pytest.approx(15.310268e-6, abs=0.05e-6)


def test_reading_is_not_clipped_in_the_paper_range():
    stand, gauge = Stand(), Gauge()
    reading = stand.run(np.concatenate([sine(100.0, 5), np.full(200, 105.0), np.zeros(200)]))
    volts = gauge.zero + gauge.sensitivity * reading.measured
    assert volts.min() > 0.2 and volts.max() < 9.8


def test_finer_grid_converges():
    voltage = np.concatenate([sine(100.0, 1), np.full(100, 40.0), np.full(100, 60.0)])
    quiet = replace(Stand(), noise=0.0, adc=None)
    exact = replace(quiet, substeps=160).run(voltage).displacement
    errors = [
        np.abs(replace(quiet, substeps=n).run(voltage).displacement - exact).max() for n in (5, 10, 20)
    ]
    assert errors[1] < 20e-9
    assert errors[0] > 2.5 * errors[1] > 6.0 * errors[2]


def test_record_for_the_identification():
    voltage, temperature = sine(50.0, 1), np.full(200, 295.0)
    record = Stand().record(voltage, "sine", seed=2, temperature=temperature)
    assert isinstance(record, Record)
    reading = Stand().run(voltage, seed=2, temperature=temperature)
    assert record.name == "sine" and record.sample_time == TS
    assert record.force is None and np.array_equal(record.temperature, temperature)
    assert np.array_equal(record.voltage, voltage)
    assert np.array_equal(record.displacement, reading.measured)


def test_the_rig_shares_no_code_with_the_model():
    imported = set()
    for path in Path(it2hys.stand.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module.startswith("it2hys"):
                imported.add(".".join(node.module.split(".")[:2]))
    assert imported <= {"it2hys.stand", "it2hys.errors", "it2hys.records"}


# Hysteresis -------------------------------------------------------------------------------------


@given(histories, voltages, voltages, st.lists(st.floats(0.0, 1.0), max_size=8))
def test_return_point_memory(history, first, second, excursions):
    """Any excursion between two turning points leaves no trace once it is passed."""
    low, high = min(first, second), max(first, second)
    plain, excursive = drive(history, Hysteresis()), drive(history, Hysteresis())
    route = np.array([low + (high - low) * part for part in excursions])
    tail = np.linspace(high, 150.0, 5)
    direct = plain.advance(np.array([low, high, *tail]))[1:]
    detour = excursive.advance(np.array([low, high, *route, low, high, *tail]))[route.size + 3 :]
    assert np.allclose(detour, direct, rtol=0.0, atol=1e-16)


@given(histories, histories, histories)
def test_wiping_out(history, other_history, continuation):
    """A swing beyond all earlier ones, up and then down, erases what came before."""
    route = np.array([160.0, -160.0, *continuation])
    hysteresis = Hysteresis()
    answers = [drive(h, hysteresis).advance(route) for h in (history, other_history)]
    assert np.allclose(*answers, rtol=0.0, atol=1e-16)


@given(histories, histories, voltages, voltages)
def test_congruency(history, other_history, first, second):
    """Minor loops between the same voltages have one shape, whatever came before."""
    low, high = min(first, second), max(first, second)
    up, down = np.linspace(low, high, 7), np.linspace(high, low, 7)
    loops = [
        drive([*h, high, low], Hysteresis()).advance(np.concatenate([up, down]))
        for h in (history, other_history)
    ]
    assert np.allclose(loops[0] - loops[0][0], loops[1] - loops[1][0], rtol=0.0, atol=1e-16)


@given(histories, st.integers(1, 30))
def test_hysteresis_does_not_depend_on_sampling(history, cut):
    """More samples on the way, and other blocks, change nothing at the turning points."""
    turns = np.array([0.0, *history, 75.0])
    coarse = drive([], Hysteresis()).advance(turns)
    fine = np.interp(np.arange((turns.size - 1) * 10 + 1) / 10.0, np.arange(turns.size), turns)
    running = drive([], Hysteresis())
    pieces = np.split(fine, range(cut, fine.size, cut))
    output = np.concatenate([running.advance(piece) for piece in pieces])
    assert np.allclose(output[::10], coarse, rtol=0.0, atol=1e-16)


@settings(max_examples=20)
@given(st.lists(st.floats(-150.0, 150.0), min_size=1, max_size=12))
def test_symmetric_density_is_a_prandtl_ishlinskii_operator(turns):
    """Without asymmetry the relays add up to plays of weight 2 mu(2 r), here 1500 of them."""
    hysteresis = Hysteresis(asymmetry=0.0, last_peak=0.0)
    radii = (np.arange(1500) + 0.5) * 0.1
    weights = 0.1 * 2.0 * hysteresis.density * np.exp(-2.0 * radii / hysteresis.decay)
    plays, expected = np.zeros(radii.size), []
    for voltage in turns:
        plays = np.clip(plays, voltage - radii, voltage + radii)
        expected.append(weights @ plays + hysteresis.reversible(voltage))
    output = drive([], hysteresis).advance(np.array(turns))
    assert np.allclose(output, expected, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("asymmetry", [0.0, 3e-3, -8e-3])
def test_everett_function_and_initial_curve_are_integrals_of_the_density(asymmetry):
    h = Hysteresis(asymmetry=asymmetry)

    def density(beta, alpha):
        mean = (alpha + beta) / 2.0
        return 1e9 * h.density * math.exp(-(alpha - beta) / h.decay + asymmetry * mean)

    assert 1e9 * h.everett(90.0, 20.0) == pytest.approx(
        dblquad(density, 20.0, 90.0, 20.0, lambda alpha: alpha)[0], rel=1e-9
    )
    assert 1e9 * h.virgin(70.0) == pytest.approx(
        dblquad(density, 0.0, 70.0, lambda alpha: -alpha, lambda alpha: alpha)[0], rel=1e-9
    )
    lower = dblquad(lambda a, b: density(b, a), -70.0, 0.0, lambda b: b, lambda b: -b)[0]
    assert 1e9 * h.virgin(-70.0) == pytest.approx(-lower, rel=1e-9)


def test_branches_of_the_default_loop_differ():
    """Turned by half a turn, the ascending branch is not the descending one."""
    running = drive([105.0, 0.0], Hysteresis(saturation=0.0))
    up = running.advance(np.linspace(0.0, 105.0, 106))
    down = running.advance(np.linspace(105.0, 0.0, 106))
    bend_up, bend_down = up - up[0], down[0] - down
    assert np.max(np.abs(bend_up - bend_down)) > 0.01 * np.ptp(up)
    assert np.all(np.diff(up) > 0.0) and np.all(np.diff(down) < 0.0)


def test_rate_independence_with_the_dynamics_off():
    stand = replace(IDEAL, hysteresis=Hysteresis())
    voltage = sine(20.0, 2)
    fast = stand.run(voltage).displacement
    slow = stand.run(np.repeat(voltage, 7)).displacement[::7]
    assert np.allclose(slow, fast, rtol=0.0, atol=1e-18)


def test_remanence_grows_with_the_first_cycle_only_beyond_the_last_peak():
    running = drive([], Hysteresis(last_peak=60.0))
    outputs = running.advance(np.array([60.0, 0.0, 105.0, 0.0, 105.0, 0.0]))
    assert outputs[1] == pytest.approx(0.0, abs=1e-18)
    assert outputs[3] > 0.5e-6
    assert outputs[5] == pytest.approx(outputs[3], rel=1e-12)


# Dynamics ---------------------------------------------------------------------------------------


def test_mode_bank_block_and_lifted_form_agree():
    signal = np.random.default_rng(0).standard_normal(400)
    poles, gains = [-50.0, complex(-300.0, 9000.0)], [0.3, complex(1.0, -0.2)]
    whole = ModeBank(poles, gains, 0.5, 1e-5).advance(signal)
    bank = ModeBank(poles, gains, 0.5, 1e-5)
    pieces = [bank.advance(piece) for piece in np.split(signal, [7, 60, 200])]
    assert np.allclose(np.concatenate(pieces), whole, rtol=0.0, atol=1e-12)


def test_creep_is_linear_in_log_time():
    stand = replace(IDEAL, creep=Creep(per_decade=0.02))
    y = stand.run(np.full(100_000, 50.0)).displacement
    t = (np.arange(y.size) + 1) * TS
    inside = t > 10e-3  # a decade above the shortest time constant
    decades, step = np.log10(t[inside]), LINEAR_SLOPE * 50.0
    slope, offset = np.polyfit(decades, y[inside], 1)
    assert slope == pytest.approx(0.02 * step, rel=0.02)
    assert np.abs(y[inside] - slope * decades - offset).max() < 0.01 * slope * np.ptp(decades)


@pytest.mark.parametrize(("frequency", "damping"), [(2500.0, 0.05), (1200.0, 0.1)])
def test_resonance_rings_at_its_frequency(frequency, damping):
    stand = replace(IDEAL, mechanics=Mechanics(frequency, damping))
    y = stand.run(np.full(60, 50.0)).displacement[1:] - LINEAR_SLOPE * 50.0
    # A sampled free oscillation follows y[k+2] = a y[k+1] + b y[k] exactly.
    recursion = np.linalg.lstsq(np.c_[y[1:-1], y[:-2]], y[2:], rcond=None)[0]
    pole = np.log(np.roots([1.0, *-recursion])[0]) / TS
    assert abs(pole) / (2.0 * np.pi) == pytest.approx(frequency, rel=0.01)
    assert -pole.real / abs(pole) == pytest.approx(damping, rel=0.01)


def test_force_shortens_the_stack_by_its_compliance():
    stand = replace(IDEAL, mechanics=Mechanics(stiffness=50e6))
    reading = stand.run(np.zeros(300), force=np.full(300, 100.0))
    assert reading.displacement[-1] == pytest.approx(-2e-6, rel=1e-3)
    assert np.all(IDEAL.run(np.zeros(9), force=np.full(9, 100.0)).displacement == 0.0)


def test_temperature_moves_the_stack():
    stand = replace(IDEAL, thermal=ThermalExpansion(0.2e-6))
    temperature = np.array([293.15, 294.15, 298.15])
    assert np.allclose(stand.run(np.zeros(3), temperature=temperature).measured, [0, 2e-7, 1e-6])
    assert np.all(IDEAL.run(np.zeros(3), temperature=temperature).displacement == 0.0)


def test_amplifier_follows_its_bandwidth():
    stand = replace(IDEAL, amplifier=Amplifier(bandwidth=1000.0, current=math.inf))
    reading = stand.run(np.full(20, 60.0))
    expected = 60.0 * -np.expm1(-2.0 * np.pi * 1000.0 * (reading.time + TS))
    assert np.allclose(reading.amplifier, expected, rtol=1e-12)


@pytest.mark.parametrize("bandwidth", [1000.0, math.inf])
def test_amplifier_slew_limit(bandwidth):
    amplifier = Amplifier(bandwidth=bandwidth, current=0.1, capacitance=2e-6)  # 5 V per tick
    voltage = np.concatenate([np.full(40, 100.0), np.full(60, 20.0)])
    reached = replace(IDEAL, amplifier=amplifier).run(voltage).amplifier
    assert np.allclose(np.diff(reached[:15]), 5.0, rtol=1e-12)
    assert np.allclose(np.diff(reached[40:50]), -5.0, rtol=1e-12)
    assert np.abs(np.diff(reached)).max() < 5.0 + 1e-9
    assert reached[39] == pytest.approx(100.0, abs=1e-3)
    assert reached[99] == pytest.approx(20.0, abs=1e-3)


def test_current_limited_step_does_not_depend_on_the_grid():
    stand = replace(IDEAL, amplifier=Amplifier(bandwidth=1000.0, current=0.1))
    voltage = np.full(40, 100.0)
    fine = replace(stand, substeps=97).run(voltage).amplifier
    assert np.allclose(stand.run(voltage).amplifier, fine, rtol=1e-11)


def test_amplifier_and_converter_saturate():
    voltage = np.array([-20.0] * 50 + [200.0] * 50)
    analogue = replace(IDEAL, amplifier=Amplifier()).run(voltage).amplifier
    assert np.all(analogue[:50] == 0.0)
    assert analogue[-1] == pytest.approx(150.0, abs=1e-6) and analogue.max() <= 150.0
    digital = replace(IDEAL, dac=Converter()).run(voltage).amplifier
    assert digital[-1] == pytest.approx(150.0 * (1.0 - 2.0**-16), rel=1e-12)


def test_dead_time_shifts_the_command():
    voltage = sine(50.0, 1)
    late = replace(IDEAL, dead_time=3.0 * TS).run(voltage).displacement
    assert np.all(late[:3] == 0.0)
    assert np.array_equal(late[3:], IDEAL.run(voltage).displacement[:-3])
    fraction = replace(IDEAL, dead_time=0.4 * TS).run(voltage).displacement
    assert np.array_equal(fraction, IDEAL.run(voltage).displacement)  # read at the tick's end


# Reading ----------------------------------------------------------------------------------------


def test_sixteen_bit_quantum_shows_on_both_sides():
    ramp = np.linspace(0.0, 0.1, 4000)
    reached = replace(IDEAL, dac=Converter()).run(ramp).amplifier
    assert np.allclose(np.unique(np.diff(np.unique(reached))), NOMINAL_GAIN * 10.0 / 2**16)
    measured = replace(IDEAL, adc=Converter()).run(ramp).measured
    assert np.allclose(np.unique(np.diff(np.unique(measured))), 20e-6 / 2**16)


@pytest.mark.parametrize("noise", [6e-9, 50e-9])
def test_noise_rms_is_as_given_and_white(noise):
    measured = replace(IDEAL, noise=noise).run(np.zeros(40_000), seed=8).measured
    assert measured.std() == pytest.approx(noise, rel=0.02)
    assert abs(np.corrcoef(measured[1:], measured[:-1])[0, 1]) < 0.02


def test_gauge_nonlinearity_is_the_greatest_deviation_from_the_line_through_the_ends():
    gauge = Gauge(nonlinearity=1e-3, bandwidth=math.inf, zero=0.0)
    displacement = np.linspace(0.0, gauge.span, 201)
    deviation = gauge.volts(displacement) - gauge.sensitivity * displacement
    assert np.abs(deviation).max() == pytest.approx(1e-3 * 10.0, rel=1e-6)
    assert deviation[0] == 0.0 and deviation[-1] == pytest.approx(0.0, abs=1e-12)


def test_gauge_reads_nothing_without_displacement():
    assert np.abs(replace(Stand(), noise=0.0).run(np.zeros(5)).measured).max() < 20e-6 / 2**16


def test_gauge_bandwidth_delays_the_reading():
    gauge = Gauge(nonlinearity=0.0, bandwidth=1000.0)
    reading = replace(IDEAL, gauge=gauge, substeps=400).run(np.full(10, 50.0))
    expected = 50.0 * LINEAR_SLOPE * -np.expm1(-2.0 * np.pi * 1000.0 * (reading.time + TS))
    assert np.allclose(reading.measured, expected, rtol=2e-3)
    assert np.allclose(reading.displacement, 50.0 * LINEAR_SLOPE)


def test_hum_is_a_line_at_its_frequency():
    measured = replace(IDEAL, hum=Hum(30e-9, 50.0)).run(np.zeros(2000)).measured
    line = 2.0 * np.abs(np.fft.rfft(measured)) / measured.size
    assert line.argmax() * 5.0 == 50.0
    assert line.max() == pytest.approx(30e-9, rel=1e-9)


# Refusals ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "culprit"),
    [
        ({"voltage": [0.0, math.nan]}, "voltage is nan at sample 1"),
        ({"voltage": []}, "voltage must be a non-empty row"),
        ({"voltage": [[1.0]]}, "voltage must be a non-empty row"),
        ({"voltage": ["a"]}, "voltage is not a sequence of numbers"),
        ({"voltage": [0.0], "force": [1.0, 2.0]}, "force has 2 samples"),
        ({"voltage": [0.0], "temperature": [math.inf]}, "temperature is inf"),
        ({"voltage": [0.0], "sample_time": 0.0}, "sample time"),
    ],
)
def test_run_refuses_bad_input(arguments, culprit):
    with pytest.raises(InputError, match=culprit):
        Stand().run(**arguments)


def test_step_refuses_bad_input():
    with pytest.raises(InputError, match="voltage is nan"):
        Stand().start().step(math.nan)


@pytest.mark.parametrize(
    ("part", "arguments"),
    [
        (Stand, {"noise": -1e-9}),
        (Stand, {"dead_time": math.inf}),
        (Stand, {"substeps": 0}),
        (Stand, {"substeps": 2.5}),
        (Converter, {"bits": 0}),
        (Converter, {"low": 10.0}),
        (Amplifier, {"capacitance": 0.0}),
        (Amplifier, {"bandwidth": math.nan}),
        (Amplifier, {"low": 5.0}),
        (Hysteresis, {"density": -1.0}),
        (Hysteresis, {"asymmetry": 0.05}),
        (Creep, {"shortest": 1e4}),
        (Creep, {"per_decade": math.nan}),
        (Mechanics, {"damping": 1.0}),
        (ThermalExpansion, {"coefficient": math.inf}),
        (Gauge, {"span": 0.0}),
        (Hum, {"amplitude": -1.0}),
    ],
)
def test_parts_refuse_bad_parameters(part, arguments):
    with pytest.raises(InputError, match=f"rig: {part.__name__}: .*"):
        part(**arguments)
