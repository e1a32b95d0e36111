"""The simulator that the diagnosis is tested on: its physics is right, its cases are as promised."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from diagnosis import simulator as sim
from diagnosis import voltages
from diagnosis.cases import (
    BIPOLAR,
    EACH,
    FAR,
    LEAST_EFFECT,
    LEAST_UNABSORBED,
    NONE,
    PAIRS,
    RANGE,
    Case,
    quick,
    short,
    suite,
)

from it2hys.model import compiled
from it2hys.model.parameters import table_1

TS = 1e-4
HELD, STRAIGHT = sim.Grid(TS), sim.Grid(TS, 20, straight=True)
GRIDS = pytest.mark.parametrize("grid", [HELD, STRAIGHT], ids=["held", "straight"])
QUICK = tuple(quick())


def ticks(samples):
    return np.arange(samples) * TS


def around(samples, grid=HELD, **signals):
    signals = {name: np.atleast_2d(values) for name, values in signals.items()}
    return sim.Surroundings(grid, ticks(samples)[None], **signals)


def swing(frequency, samples, low=0.0, high=105.0):
    shape = -np.cos(2.0 * np.pi * frequency * ticks(samples))
    return 0.5 * (low + high) + 0.5 * (high - low) * shape[None]


def through(effect, x, grid=HELD, **signals):
    """Return a sampled signal behind an effect on the fine grid."""
    return grid.sample(effect.apply(grid.refine(x), around(x.shape[1], grid, **signals)))


@cache
def made(name):
    return next(case for case in suite() if case.name == name)


# --- the base ----------------------------------------------------------------------------------


def test_table_1_covers_the_range_that_the_paper_gives():
    t = ticks(4000)
    voltage = 62.5 - 40.0 * np.cos(2 * np.pi * 50 * t) - 22.5 * np.cos(2 * np.pi * 25 * t)
    y = sim.run_base(sim.TABLE_1, voltage[None])[0, 2000:]
    assert y.min() == pytest.approx(0.84, abs=0.01)
    assert y.max() == pytest.approx(15.31, abs=0.01)


def test_base_is_the_model_that_the_product_has_too():
    voltage = swing(37.0, 1000)
    y = sim.run_base(sim.TABLE_1, voltage)[0]
    rest = 1e-6 * float(sim.equilibrium(sim.TABLE_1, voltage[:, 0])[0])
    product = compiled.free_run(table_1().rules, voltage[0], rest)
    np.testing.assert_allclose(1e6 * np.ravel(product), y, atol=1e-9)


def test_drawn_bases_rise_contract_and_keep_their_travel():
    volts = np.linspace(0.0, 120.0, 30)
    for seed in range(5):
        rules = sim.draw_rules(np.random.default_rng(seed), 120.0, 1.5)
        rest = sim.equilibrium(rules, volts)
        slope = (sim.advance(rules, rest + 1e-4, volts) - rest) / 1e-4
        assert np.all(np.diff(rest) > 0.0) and 8.0 <= np.ptp(rest) <= 16.0
        assert np.all(slope < 1.0)


@GRIDS
def test_plant_without_effects_is_the_base_bit_for_bit(grid):
    voltage = np.concatenate([swing(20.0, 800), swing(90.0, 800, 20.0, 60.0)])
    surroundings = replace(around(800, grid), time=np.tile(ticks(800), (2, 1)))
    expected = sim.run_base(sim.TABLE_1, voltage)
    assert np.array_equal(sim.Plant(sim.TABLE_1).run(voltage, surroundings), expected)
    plant = sim.Plant(sim.TABLE_1, {"play": sim.Play("uniform", 20.0, 0.5, 105.0)})
    assert not np.array_equal(plant.run(voltage, surroundings), expected)
    assert np.array_equal(plant.without("play").run(voltage, surroundings), expected)


# --- the effects ---------------------------------------------------------------------------------


@pytest.mark.parametrize("density", ["exponential", "uniform", "hump"])
def test_loop_area_of_play_does_not_depend_on_frequency(density):
    play = sim.Play(density, 20.0, 0.4, 105.0)

    def area(frequency, periods):
        count = round(1.0 / (frequency * TS))
        x = swing(frequency, periods * count + 1)
        y = play.apply(x, around(x.shape[1]))
        x, y = x[0, -count - 1 :], y[0, -count - 1 :]
        return -np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x))

    assert area(5.0, 2) > 100.0  # V^2, some per cent of the square that the range makes
    assert area(50.0, 4) == pytest.approx(area(5.0, 2), rel=5e-3)


def test_play_keeps_the_ends_of_the_range_and_remembers_where_the_voltage_turned():
    play = sim.Play("exponential", 15.0, 0.8, 100.0)
    turns = [0.0, 100.0, 40.0, 70.0, 40.0, 100.0]
    x = np.interp(np.arange(501), np.arange(6) * 100, turns)[None]
    y = play.apply(x, around(501))[0]
    assert y[100] == pytest.approx(100.0) == y[500]
    assert y[200] == pytest.approx(y[400])  # the minor loop closes and is forgotten
    assert y[300] > np.interp(70.0, x[0, :101], y[:101])  # within the great loop


@GRIDS
def test_logarithmic_creep_grows_alike_in_every_decade(grid):
    x = np.where(np.arange(30000) < 10, 0.0, 10.0)[None]
    creep = sim.Creep.logarithmic(0.1, 2e-3, 20.0)
    y = through(creep, x, grid)[0]
    after = y[[10 + 100, 10 + 1000, 10 + 10000]]
    assert np.all(np.diff(y[10:]) > 0.0) and y[9] == 0.0
    assert np.diff(after) == pytest.approx(0.25, rel=0.1)  # 0.1 * 10 um over four decades


@GRIDS
def test_resonance_rings_at_its_frequency_and_decays_with_its_damping(grid):
    resonance = sim.Resonance(500.0, 0.03)
    x = np.where(np.arange(1000) < 10, 0.0, 1.0)[None]
    fine = resonance.apply(grid.refine(x), around(1000, grid))[0]
    peaks = np.flatnonzero((fine[1:-1] > fine[:-2]) & (fine[1:-1] >= fine[2:])) + 1
    peaks = peaks[fine[peaks] > 1.05]
    period = np.diff(peaks).mean() * grid.step
    decrement = -np.diff(np.log(fine[peaks] - 1.0)).mean()
    assert 1.0 / period == pytest.approx(500.0 * np.sqrt(1.0 - 0.03**2), rel=5e-3)
    assert decrement == pytest.approx(2.0 * np.pi * 0.03, rel=0.03)
    assert fine[-1] == pytest.approx(1.0, abs=1e-3)


@GRIDS
def test_lag_attenuates_and_turns_a_sine_as_an_rc_element(grid):
    lag = sim.Lag(500.0, 2e-6)  # 1 ms
    frequency, count = 100.0, 2000
    x = swing(frequency, count, -1.0, 1.0)
    y = through(lag, x, grid)[0, 1000:]
    turn = np.exp(-2j * np.pi * frequency * ticks(count)[1000:])
    ratio = (y @ turn) / (x[0, 1000:] @ turn)
    jw = 2j * np.pi * frequency
    # a held voltage is half a tick late on average and is read a whole one after it was set
    lead = 0.0 if grid.straight else 0.5 * TS
    assert ratio == pytest.approx(np.exp(jw * lead) / (1.0 + 1e-3 * jw), abs=2e-3)


def test_delay_is_not_bound_to_ticks():
    ramp = np.linspace(0.0, 50.0, 501)[None]
    y = through(sim.Delay(3.7 * TS), ramp, STRAIGHT)[0]
    np.testing.assert_allclose(y[10:], ramp[0, 10:] - 0.37, atol=1e-12)


@GRIDS
def test_slew_limits_the_rate_and_nothing_else(grid):
    x = swing(50.0, 600)
    steepest = np.pi * 50.0 * 105.0
    y = through(sim.Slew(0.5 * steepest), x, grid)
    assert np.abs(np.diff(y)).max() <= 0.5 * steepest * TS * (1.0 + 1e-9)
    assert np.abs(y - x).max() > 5.0
    np.testing.assert_allclose(through(sim.Slew(20.0 * steepest), x, grid), x, atol=1e-9)


def test_load_shortens_by_force_over_stiffness():
    force = np.where(np.arange(50) < 20, 0.0, 30.0)
    y = through(sim.Load(60.0), np.ones((1, 50)), force=force)[0]
    assert y[19] == 1.0 and y[20:] == pytest.approx(0.5)


def test_drift_follows_temperature_and_time():
    kelvin = np.linspace(293.15, 295.15, 50)
    surroundings = around(50, temperature=kelvin)
    y = sim.Drift(coefficient=0.1).apply(np.zeros((1, 50)), surroundings)[0]
    assert y == pytest.approx(0.1 * (kelvin - 293.15))
    y = sim.Drift(rate=2.0).apply(np.zeros((1, 50)), surroundings)[0]
    assert y == pytest.approx(2.0 * ticks(50))


def test_nonlinearity_depends_on_the_displacement_alone():
    curve = sim.Nonlinearity(0.0, 12.0, (0.1, -0.05, 0.08), bend=0.2, waves=3)
    x = np.random.default_rng(0).uniform(0.0, 12.0, (3, 200))
    y = curve.apply(x, around(200))
    order = np.argsort(x, axis=None)
    again = curve.apply(x.ravel()[order][None], around(600))[0]
    assert np.array_equal(y.ravel()[order], again)
    assert np.abs(y - x).max() > 0.1


def test_hum_has_one_amplitude_and_a_phase_of_its_own_in_each_record():
    surroundings = sim.Surroundings(HELD, np.tile(ticks(2000), (4, 1)))
    hum = sim.Hum(0.03, 50.0, seed=3).apply(np.zeros((4, 2000)), surroundings)
    line = hum @ np.exp(-2j * np.pi * 50.0 * ticks(2000)) / 1000.0
    assert np.abs(line) == pytest.approx(0.03)
    assert np.ptp(np.angle(line)) > 0.1


def test_what_the_base_absorbs_is_told_from_what_it_cannot():
    voltage = np.concatenate([swing(20.0, 1500), swing(60.0, 1500, 10.0, 90.0)])
    base = sim.run_base(sim.TABLE_1, voltage)
    other = sim.TABLE_1.copy()
    other[1, 2] += 1e-3
    other[0, 4] *= 1.0001
    change = sim.run_base(other, voltage) - base
    left = sim.unabsorbed(sim.TABLE_1, voltage, change)
    assert np.abs(change).max() > 5e-4 and np.abs(left).max() < 0.02 * np.abs(change).max()
    line = 0.02 * np.sin(2.0 * np.pi * 333.0 * np.tile(ticks(1500), (2, 1)))
    assert np.std(sim.unabsorbed(sim.TABLE_1, voltage, line)) > 0.95 * np.std(line)


# --- the cases -----------------------------------------------------------------------------------


def test_suite_has_what_it_promises():
    cases = list(suite())
    assert len({case.name for case in cases}) == len({case.seed for case in cases}) == len(cases)
    assert len(cases) >= 80
    for effect in sim.CATALOGUE:
        assert sum(case.truth == (effect,) for case in cases) >= EACH >= 5
    assert len(PAIRS) >= 8
    assert sum(not case.truth and not case.outside for case in cases) >= NONE >= 20
    assert sum(case.outside for case in cases) >= 6
    assert all(set(case.declared) <= set(case.truth) for case in cases)
    assert {c.undeclared for c in cases if c.declared} >= {("creep",), ("drift",), ()}


def records_of(case):
    return [*case.train, *case.validation, *case.test]


AT_REST = (
    "play, quantised", "play, both ways and far from zero", "resonance, steps", "hum, 5 ms",
    "delay+creep, 5 ms",
)  # fmt: skip


@pytest.mark.parametrize("case", [*QUICK, *map(made, AT_REST)], ids=lambda case: case.name)
def test_records_are_the_plant_and_noise_of_the_size_stated(case):
    records = [*case.train, *case.validation, *case.test]
    samples = min(len(record) for record in records)

    def stacked(quantity):
        signals = [getattr(record, quantity) for record in records]
        return None if signals[0] is None else np.array([s[:samples] for s in signals])

    surroundings = sim.Surroundings(
        case.grid, stacked("time"), stacked("force"), stacked("temperature")
    )
    plant = case.plant.without(case.anomaly)
    error = 1e6 * stacked("displacement") - plant.run(stacked("voltage"), surroundings) - case.zero
    rms = 1e-6 * np.sqrt(np.mean(error**2))
    if case.outside:
        assert rms > 2.0 * case.noise_rms
    else:
        assert rms == pytest.approx(case.noise_rms, rel=0.04)


@pytest.mark.parametrize("case", [*short(), *map(made, AT_REST)], ids=lambda case: case.name)
def test_effects_of_short_and_special_records_show(case):
    assert set(case.effect_rms) == set(case.truth)
    assert all(size >= LEAST_EFFECT * case.noise_rms for size in case.effect_rms.values())
    assert all(rest >= LEAST_UNABSORBED * case.noise_rms for rest in case.unabsorbed_rms.values())


@pytest.mark.parametrize("case", QUICK, ids=lambda case: case.name)
def test_effects_are_as_large_as_promised(case):
    assert set(case.effect_rms) == {*case.truth, *filter(None, [case.anomaly])}
    assert all(size >= LEAST_EFFECT * case.noise_rms for size in case.effect_rms.values())
    assert all(rest >= LEAST_UNABSORBED * case.noise_rms for rest in case.unabsorbed_rms.values())
    assert 3e-9 <= case.noise_rms <= 10e-9
    assert 25_000 <= case.samples <= 50_000
    for record in (*case.train, *case.validation, *case.test):
        assert np.ptp(record.voltage) > 20.0 and np.all(np.isfinite(record.displacement))
    if "load" in case.truth:
        assert all(record.force is not None for record in case.train)


def test_cases_are_decided_by_their_seeds():
    case = made("none 1")
    again, other = Case(case.seed, "again"), Case(case.seed + 1, "other")
    for first, second in zip(case.train, again.train, strict=True):
        assert np.array_equal(first.displacement, second.displacement)
    assert not np.array_equal(case.test[0].voltage[:100], other.test[0].voltage[:100])


def test_records_of_a_case_in_motion_do_not_start_at_rest():
    case = made("none 8")
    assert case.in_motion and case.train[1].time[0] == 0.0
    rest = sim.equilibrium(case.plant.rules, np.array([r.voltage[0] for r in case.train]))
    started = np.array([r.displacement[0] for r in case.train])
    assert np.abs(1e6 * started - rest).max() > 0.1


def test_a_suite_has_seeds_of_its_own_range():
    here, there = list(suite()), list(suite(3 * RANGE))
    assert [case.name for case in here] == [case.name for case in there]
    assert all(0 <= case.seed < RANGE for case in [*here, *short()])
    assert [case.seed + 3 * RANGE for case in here] == [case.seed for case in there]
    assert not np.array_equal(here[0].test[0].voltage[:100], there[0].test[0].voltage[:100])
    with pytest.raises(ValueError, match="multiple"):
        suite(RANGE + 1)


def test_suite_has_records_as_people_bring_them():
    cases = [case for case in suite() if case.truth or not case.outside]
    times = {case.sample_time for case in cases}
    assert {1e-3, 2e-3, 5e-3} <= times
    assert {case.history for case in cases} == {"", "driven", "stepped"}
    assert any("delay" in case.truth and case.sample_time >= 5e-3 for case in cases)
    assert all(FAR[0] <= case.zero <= FAR[1] for case in cases if case.bipolar)
    for kind in ("bipolar", "steps", "quantised"):
        assert {case.truth for case in cases if getattr(case, kind)} >= {(), ("play",), ("creep",)}


@pytest.mark.parametrize("name", ["none, driven before", "none, off equilibrium"])
def test_records_with_a_history_begin_at_rest_where_they_say_so_and_elsewhere_they_do_not(name):
    case = made(name)
    started = np.array([1e6 * r.displacement[0] for r in records_of(case)])
    rest = sim.equilibrium(case.plant.rules, np.array([r.voltage[0] for r in records_of(case)]))
    away = np.abs(started - rest) > 5e6 * case.noise_rms
    at_rest = np.array(case._made.at_rest)
    assert 0 < np.count_nonzero(at_rest) < len(at_rest)
    assert not np.any(away[at_rest]) and np.count_nonzero(away) >= 2
    assert case.tests_begin_at_rest == tuple(at_rest[-2:])


def test_a_history_leaves_a_memory_that_no_first_voltage_tells():
    case = made("play, driven before")
    away = []
    for record in records_of(case):
        assert record.time[0] == 0.0
        surroundings = sim.Surroundings(case.grid, record.time[None])
        fresh = case.plant.run(record.voltage[None], surroundings)[0]
        away.append(np.sqrt(np.mean((1e6 * record.displacement - fresh)[:200] ** 2)))
    remembers = np.array(away) > 2e6 * case.noise_rms
    at_rest = np.array(case._made.at_rest)
    assert not np.any(remembers[at_rest])
    # what was before may by chance leave next to nothing
    assert np.count_nonzero(remembers) > 0.6 * np.count_nonzero(~at_rest)


def test_a_stage_driven_both_ways_uses_its_range_and_reads_far_from_zero():
    case = made("creep, both ways and far from zero")
    voltage = np.concatenate([r.voltage for r in records_of(case)])
    assert BIPOLAR[0] <= voltage.min() < -120.0 and 120.0 < voltage.max() <= BIPOLAR[1]
    reading = 1e6 * np.concatenate([r.displacement for r in records_of(case)])
    assert case.zero - 2.0 < reading.min() and reading.max() < case.zero + 20.0 < -50.0


def test_slow_records_are_slower_as_a_whole():
    case = made("delay, 5 ms")
    assert case.grid.sample_time == 5e-3 == case.train[0].sample_time
    assert case.test[0].time[-1] > 15.0
    assert 2.5 <= case.plant.effects["delay"].time / 5e-3 <= 8.0
    steps = np.concatenate([np.abs(np.diff(r.voltage)) for r in records_of(case)])
    assert np.median(steps) < 3.0  # V: slow enough to be followed


def test_steps_are_held_and_a_coarse_sensor_has_few_levels():
    for record in records_of(made("play, steps")):
        assert np.mean(np.diff(record.voltage) == 0.0) > 0.97
        assert np.ptp(record.voltage) > 20.0
    case = made("play, quantised")
    levels = np.unique(np.concatenate([r.displacement for r in records_of(case)]))
    step = np.min(np.diff(levels))
    assert step > 0.8 * case.noise_rms
    np.testing.assert_allclose(levels / step, np.round(levels / step), atol=1e-3)


def test_stairs_climb_in_equal_steps_and_come_back():
    t = np.arange(3000) * 1e-3
    voltage = voltages.stairs(np.random.default_rng(0), t, 100.0)
    jumps = np.diff(voltage)[np.diff(voltage) != 0.0]
    assert np.abs(jumps) == pytest.approx(np.abs(jumps[0])) and {*np.sign(jumps)} == {-1.0, 1.0}
    assert voltage[0] == 0.0 and 85.0 <= voltage.max() <= 100.0
