"""Seeded cases for the diagnosis: records of simulated stages, and what is truly in them.

`suite` gives all cases, `quick` a few of them and `short` small ones. A case is cheap to make: its
records are simulated when they are first asked for. An effect that would not show is drawn again, see
`LEAST_EFFECT`.

Seeds come in ranges of `RANGE`: the suite of the range that begins at 30000 has the same kinds of
cases as the one that begins at 0, and other stages and records. What the diagnosis decides by was
chosen on `CHOSEN_ON`; figures that are reported come from other ranges.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from diagnosis import own_physics as own
from diagnosis import simulator as sim
from diagnosis import voltages
from scipy import signal

from it2hys.records import Record

#: Least change of the test records that an effect makes, as a multiple of the noise (both rms).
LEAST_EFFECT = 5.0
#: The same of the part of it that no change of the base model's parameters makes.
LEAST_UNABSORBED = 2.0
#: Seeds of one suite.
RANGE = 10_000
#: First seeds of the ranges that anything was chosen on: thresholds, bounds and weights of the
#: diagnosis, and what the tests diagnose. Up to the first gate all of it was chosen on the only suite
#: there was, 1000 .. 6002, on 7000 (the benchmark of growth) and on no other seeds.
CHOSEN_ON = (0, 50_000, 80_000, 90_000, 140_000, 150_000, 160_000, 170_000, 180_000)
TRAINING, VALIDATION, TEST = 5, 2, 2
_RECORDS = TRAINING + VALIDATION + TEST
_ADC_STEP = 20.0 / 2**16  # of a 16-bit converter over 20 um
_ATTEMPTS = 60
#: Longest sample time for which voltages, forces and effects are as quick as they are, s; where samples
#: are further apart, all of it is slower by so much, the stage included.
_QUICK = 5e-4
#: Samples of a record whose voltages are as quick as `voltages` has them, where a length is given.
_USUAL = 4000
#: Ends of the voltages of a stage that is driven both ways, V.
BIPOLAR = (-150.0, 150.0)


@dataclass(frozen=True)
class Case:
    """Records of one simulated stage.

    Parameters
    ----------
    seed : int
        Decides everything that is drawn.
    name : str
        Unique in the suite.
    truth : tuple of str
        Effects of the catalogue that the stage has, declared ones included.
    outside : bool
        Whether it has one that the catalogue lacks.
    declared : tuple of str
        Effects that the diagnosis is told of from the start.
    anomaly : str
        The effect outside the catalogue, if any.
    drift_by : str
        `temperature` or `time`: what a drift follows.
    in_motion : bool
        Whether the records are cut out of longer runs; otherwise they start at long rest.
    zero : float
        What the sensor reads where the stage is at zero, um.
    sample_time : float
        In s; where it is 0, one of 0.1, 0.2 and 0.5 ms is drawn.
    length : int
        Samples of a record, whose voltages are as much quicker as it is shorter; where it is 0, 4000 to
        5000 are drawn.
    bipolar : bool
        Whether the voltages are within `BIPOLAR`; otherwise none is below 0 V.
    history : str
        `driven`: most records begin after the stage was driven in a way that nobody recorded, some of
        them in motion, others held at their first voltage for a while. `stepped`: most begin shortly
        after a step of the voltage, off their equilibrium. The others begin at long rest.
    steps : bool
        Whether every voltage is made of steps.
    quantised : bool
        Whether the sensor resolves no more than two to six times the noise.
    """

    seed: int
    name: str
    truth: tuple[str, ...] = ()
    outside: bool = False
    declared: tuple[str, ...] = ()
    anomaly: str = ""
    drift_by: str = "temperature"
    in_motion: bool = False
    zero: float = 0.0
    sample_time: float = 0.0
    length: int = 0
    bipolar: bool = False
    history: str = ""
    steps: bool = False
    quantised: bool = False

    @property
    def undeclared(self) -> tuple[str, ...]:
        """What a diagnosis has to name, and nothing else."""
        return tuple(name for name in self.truth if name not in self.declared)

    @property
    def train(self) -> list[Record]:
        """Records to fit."""
        return self._made.records[:TRAINING]

    @property
    def validation(self) -> list[Record]:
        """Records to decide on."""
        return self._made.records[TRAINING : TRAINING + VALIDATION]

    @property
    def test(self) -> list[Record]:
        """Records to report on."""
        return self._made.records[TRAINING + VALIDATION :]

    @property
    def tests_begin_at_rest(self) -> tuple[bool, ...]:
        """Whether the stage was at long rest when each test record began."""
        return tuple(bool(rest) for rest in self._made.at_rest[-TEST:])

    @property
    def noise_rms(self) -> float:
        """Noise of the reading, that of its resolution included, m."""
        return 1e-6 * self._made.noise

    @property
    def effect_rms(self) -> dict[str, float]:
        """Rms difference of the test records with and without each effect, m, by its name."""
        return {name: 1e-6 * value for name, value in self._made.sizes.items()}

    @property
    def unabsorbed_rms(self) -> dict[str, float]:
        """The same of the part that no small change of the base model makes, m."""
        return {name: 1e-6 * value for name, value in self._made.unabsorbed.items()}

    @property
    def plant(self) -> sim.Plant:
        """The stage."""
        return self._made.plant

    @property
    def grid(self) -> sim.Grid:
        """How the simulation divided time."""
        return self._made.grid

    @property
    def samples(self) -> int:
        """Number of samples in all records."""
        return sum(len(record) for record in self._made.records)

    @cached_property
    def _made(self) -> _Made:
        for attempt in range(_ATTEMPTS):
            made = _make(self, np.random.default_rng([self.seed, attempt]))
            if made.shows:
                return made
        raise RuntimeError(f"case {self.name}: no draw shows its effects")


@dataclass(frozen=True, eq=False)
class _Made:
    """What a case is made of; lengths in um."""

    plant: sim.Plant
    grid: sim.Grid
    records: list[Record]
    at_rest: np.ndarray
    noise: float
    sizes: dict[str, float]
    unabsorbed: dict[str, float]

    @property
    def shows(self) -> bool:
        """Whether every effect is large enough to be found."""
        enough = all(size >= LEAST_EFFECT * self.noise for size in self.sizes.values())
        return enough and all(r >= LEAST_UNABSORBED * self.noise for r in self.unabsorbed.values())


@dataclass(frozen=True, eq=False)
class _Scene:
    """What is drawn before the effects: the base, the voltages and what acts beside them.

    The first `lead` samples are before the records; `slowness` is how many times slower everything is
    than at a short sample time.
    """

    rules: np.ndarray
    lowest: float
    greatest: float
    voltage: np.ndarray
    around: sim.Surroundings
    noise: float
    lead: int
    at_rest: np.ndarray
    slowness: float

    @property
    def ends(self) -> tuple[float, float]:
        """Displacements at rest at the lowest and at the greatest voltage, um."""
        low, high = sim.equilibrium(self.rules, np.array([self.lowest, self.greatest]))
        return float(low), float(high)

    @property
    def travel(self) -> float:
        """Their distance, um."""
        low, high = self.ends
        return high - low

    @property
    def duration(self) -> float:
        """Length of a record, s."""
        return self.voltage.shape[1] * self.around.grid.sample_time


# --- the effects' random sizes -------------------------------------------------------------------


def _draw_delay(rng: np.random.Generator, scene: _Scene, least: float) -> sim.Delay:
    """Draw a delay of `least` to 8 ticks."""
    return sim.Delay(rng.uniform(least, 8.0) * scene.around.grid.sample_time)


def _draw_slew(rng: np.random.Generator, scene: _Scene) -> sim.Slew:
    """Clip 5 to 40 % of the record whose slope is greatest, staircases apart."""
    rates = np.abs(np.diff(scene.voltage)) / scene.around.grid.sample_time
    moving = rates[np.median(rates, axis=1) > 0.0]
    fastest = moving[np.argmax(np.sqrt(np.mean(moving**2, axis=1)))]
    return sim.Slew(float(np.quantile(fastest, 1.0 - rng.uniform(0.05, 0.4))))


def _draw_saturation(rng: np.random.Generator, scene: _Scene) -> sim.Saturation:
    low, high = rng.uniform(0.04, 0.2, 2) * (scene.greatest - scene.lowest)
    ends = rng.choice(3, p=[0.5, 0.2, 0.3])  # upper, lower, both
    return sim.Saturation(
        float(scene.lowest + low) if ends else -1e3, float(scene.greatest - high) if ends != 1 else 1e3
    )


def _draw_lag(rng: np.random.Generator, scene: _Scene) -> sim.Lag:
    capacitance = rng.uniform(1e-6, 8e-6)
    # a lag below the sample time is none; at 2 kHz the records see slower ones
    shortest = max(2e-4, 1.5 * scene.around.grid.sample_time)
    time = shortest * (3e-3 / 2e-4) ** rng.random()
    return sim.Lag(time / capacitance, capacitance)


def _draw_play(rng: np.random.Generator, scene: _Scene) -> sim.Play:
    """Set the share of memory so that the greatest loop is 4 to 20 % of the range wide."""
    density = ("exponential", "uniform", "hump")[rng.integers(3)]
    scale = rng.uniform(0.08, 0.3) * scene.greatest
    whole = sim.Play(density, scale, 1.0, scene.greatest)
    ramp = np.linspace(0.0, scene.greatest, 400)
    up_and_down = np.concatenate([ramp, ramp[::-1]])[None]
    out = whole.apply(up_and_down, scene.around)[0]
    width = np.max(out[400:][::-1] - out[:400]) / scene.greatest
    return replace(whole, share=min(rng.uniform(0.04, 0.2) / width, 1.0))


def _draw_load(rng: np.random.Generator, scene: _Scene) -> sim.Load:
    return sim.Load(float(np.ptp(scene.around.force)) / rng.uniform(0.1, 1.0))


def _draw_creep(rng: np.random.Generator, scene: _Scene) -> sim.Creep:
    total = rng.uniform(0.02, 0.15)
    shortest = 5e-3 * scene.slowness
    if rng.random() < 0.5:
        first = shortest * 4.0 ** rng.random()
        return sim.Creep.logarithmic(total, first, scene.duration * rng.uniform(1.0, 10.0))
    count = int(rng.integers(2, 5))
    shares = rng.dirichlet(np.full(count, 3.0))
    times = np.geomspace(shortest, 2.0 * scene.duration, count) * rng.uniform(0.7, 1.6, count)
    return sim.Creep(tuple(total * shares), tuple(times))


def _draw_resonance(rng: np.random.Generator, scene: _Scene) -> sim.Resonance:
    lowest = 300.0 / scene.slowness
    highest = min(2500.0, 0.35 / scene.around.grid.sample_time)
    frequency = lowest * (highest / lowest) ** rng.random()
    return sim.Resonance(frequency, 0.01 * 15.0 ** rng.random())


def _draw_drift(rng: np.random.Generator, scene: _Scene, by: str) -> sim.Drift:
    sign = rng.choice([-1.0, 1.0])
    if by == "time":
        return sim.Drift(rate=sign * rng.uniform(0.05, 1.0) / scene.duration)
    return sim.Drift(sign * rng.uniform(0.02, 0.3), 293.15)


def _draw_nonlinearity(rng: np.random.Generator, scene: _Scene) -> sim.Nonlinearity:
    low, high = scene.ends
    size = rng.uniform(0.02, 0.04) * scene.travel * rng.choice([-1.0, 1.0])
    if rng.random() < 0.4:
        return sim.Nonlinearity(low, high, bend=size, waves=int(rng.integers(2, 4)))
    mix = rng.dirichlet([0.5, 1.0, 1.0]) * rng.choice([-1.0, 1.0], 3)
    return sim.Nonlinearity(low, high, tuple(size * mix))


def _draw_hum(rng: np.random.Generator, scene: _Scene) -> sim.Hum:
    rate = 1.0 / scene.around.grid.sample_time
    lines = [50.0, 60.0, 100.0, rng.uniform(30.0, 0.2 * rate)]
    frequency = rng.choice([line for line in lines if line < 0.4 * rate])
    amplitude = rng.uniform(7.5, 14.0) * scene.noise
    return sim.Hum(amplitude, frequency, int(rng.integers(2**31)))


def _draw_mount(rng: np.random.Generator, scene: _Scene) -> own.Mount:
    frequency = 100.0 * 5.0 ** rng.random() / scene.slowness
    return own.Mount(rng.uniform(0.05, 0.25), frequency, rng.uniform(0.01, 0.04))


def _draw_guide(rng: np.random.Generator, scene: _Scene) -> own.Guide:
    return own.Guide(rng.uniform(0.005, 0.02) * scene.travel, rng.uniform(0.03, 0.15) * scene.travel)


def _draw_heating(rng: np.random.Generator, scene: _Scene) -> own.SelfHeating:
    """Draw an expansion of 1 to 5 % of the travel for the mean power of the warmest record."""
    energy = np.abs(np.diff(scene.voltage**2, axis=1)) / 2.0 * scene.travel / np.ptp(scene.voltage)
    most = np.mean(energy, axis=1).max() / scene.around.grid.sample_time
    size = rng.uniform(0.01, 0.05) * scene.travel
    return own.SelfHeating(size / most, rng.uniform(0.1, 0.6) * scene.duration, scene.voltage)


def _draw_drag(rng: np.random.Generator, scene: _Scene) -> own.Drag:
    """Draw a drag whose two parts are alike where the stage is a part of its travel behind."""
    linear = rng.uniform(0.2, 1.0) * scene.around.grid.sample_time
    return own.Drag(linear, linear**2 / (rng.uniform(0.05, 0.3) * scene.travel))


def _draw_anomaly(name: str, rng: np.random.Generator, scene: _Scene) -> sim.Effect:
    seed = int(rng.integers(2**31))
    size = rng.uniform(12.0, 30.0) * scene.noise
    return {
        "jumps": lambda: sim.Jumps(size, rng.uniform(5.0, 40.0), seed),
        "whistle": lambda: sim.Whistle(size, 40.0, 0.15 / scene.around.grid.sample_time, seed),
        "slip": lambda: sim.Slip(rng.uniform(0.01, 0.03), seed),
        "bursts": lambda: sim.Bursts(2.0 * size, rng.uniform(0.1, 0.3), seed),
        "hidden heat": lambda: sim.HiddenHeat(rng.uniform(0.01, 0.03), seed),
        "wander": lambda: sim.Wander(2.0 * size, seed),
        "second resonance": lambda: _draw_mount(rng, scene),
        "friction": lambda: _draw_guide(rng, scene),
        "self-heating": lambda: _draw_heating(rng, scene),
        "drag": lambda: _draw_drag(rng, scene),
        "stiction": lambda: sim.Stiction(rng.uniform(2.0, 6.0) * scene.greatest / scene.slowness),
    }[name]()


_DRAWS: dict[str, Callable[[np.random.Generator, _Scene], sim.Effect]] = {
    "slew": _draw_slew, "saturation": _draw_saturation, "lag": _draw_lag, "play": _draw_play,
    "load": _draw_load, "creep": _draw_creep, "resonance": _draw_resonance,
    "nonlinearity": _draw_nonlinearity, "hum": _draw_hum,
}  # fmt: skip


# --- the scene -----------------------------------------------------------------------------------


def _draw_steps(rng: np.random.Generator, t: np.ndarray, greatest: float) -> np.ndarray:
    """Draw a set that is made of steps alone."""
    kinds = [voltages.staircase, voltages.stairs, voltages.long_hold]
    train = [*kinds, voltages.staircase, voltages.stairs]
    held_out = [voltages.staircase, voltages.stairs, *rng.permutation(kinds)[:TEST]]
    return np.array([draw(rng, t, greatest) for draw in (*train, *held_out)])


def _draw_voltages(rng: np.random.Generator, t: np.ndarray, greatest: float) -> np.ndarray:
    """Draw a set in which every role has slow and fast, smooth and stepped parts."""
    smooth = [voltages.sine, voltages.triangle, voltages.two_sines, voltages.slow_sine]
    fast = [voltages.multisine, voltages.chirp]
    stepped = [voltages.staircase, voltages.long_hold]
    others = [*smooth, voltages.decaying]

    def pick(kinds: list) -> voltages.Draw:
        return kinds[rng.integers(len(kinds))]

    train = [
        voltages.two_sines, voltages.slow_sine, voltages.staircase, pick(fast),
        pick([voltages.long_hold, voltages.decaying, voltages.triangle]),
    ]  # fmt: skip
    held_out = [pick(stepped), pick(fast), *rng.permutation([pick(others), voltages.staircase])]
    if rng.random() < 0.5:
        held_out[3], held_out[1] = held_out[1], held_out[3]
    return np.array([draw(rng, t, greatest) for draw in (*train, *held_out)])


def _draw_force(rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    """Draw steps, or sines whose frequency is none of the voltage's, in N; none at the start."""
    most = rng.uniform(5.0, 100.0)
    force = np.empty((_RECORDS, t.size))
    for row in force:
        if rng.random() < 0.5:
            edges = np.sort(rng.uniform(0.05, 1.0, 6)) * t[-1]
            row[:] = rng.uniform(0.0, most, 7)[np.searchsorted(edges, t)]
            row[t < edges[0]] = 0.0
        else:
            row[:] = 0.5 * most * (1.0 - np.cos(2.0 * np.pi * rng.uniform(3.0, 30.0) * t))
    return force


def _draw_temperature(rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    """Draw random walks, ramps or sines of 1 to 3 K about 20 degC, in K."""
    temperature = np.empty((_RECORDS, t.size))
    for row in temperature:
        swing = rng.uniform(1.0, 3.0) * rng.choice([-1.0, 1.0])
        kind = rng.integers(3)
        if kind == 0:
            walk = np.cumsum(rng.standard_normal(t.size))
            walk = signal.sosfiltfilt(signal.butter(2, 0.01, output="sos"), walk)
            shape = (walk - walk[0]) / np.max(np.abs(walk - walk[0]))
        elif kind == 1:
            shape = t / t[-1] - rng.uniform(0.0, 0.5)
        else:
            shape = np.sin(2.0 * np.pi * (rng.uniform(0.7, 4.0) * t / t[-1] + rng.random()))
        row[:] = 293.15 + swing * shape
    return temperature


def _draw_history(
    rng: np.random.Generator, case: Case, t: np.ndarray, voltage: np.ndarray, greatest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Draw what was before each record, at times t, and whether that was nothing but rest.

    `voltage` is that of the records, from 0 V to the greatest as what comes before them.
    """
    swings = (voltages.sine, voltages.decaying, voltages.two_sines, voltages.staircase)
    before = np.repeat(voltage[:, :1], t.size, axis=1)
    rests = rng.random(len(voltage)) < 0.25
    for i in np.flatnonzero(~rests):
        row, first = before[i], voltage[i, 0]
        if case.history == "stepped":
            row[: t.size - int(rng.integers(0, 8))] = rng.uniform(0.0, greatest)
            continue
        row[:] = swings[rng.integers(len(swings))](rng, t, greatest)
        if rng.random() < 0.5:
            # back to the first voltage, and held there: what it remembers is not seen
            stop, hold = rng.uniform(0.4, 0.7), rng.uniform(0.0, 0.2)
            share = np.clip((np.linspace(0.0, 1.0, t.size) - stop) / (1.0 - hold - stop), 0.0, 1.0)
            row += share * (first - row)
    return before, rests


def _draw_scene(case: Case, rng: np.random.Generator) -> _Scene:
    # the seed's own: what attempts are refused must not decide on it
    sample_time = case.sample_time or float(
        np.random.default_rng(case.seed).choice([1e-4, 2e-4, 5e-4], p=[0.8, 0.12, 0.08])
    )
    grid = sim.Grid(sample_time, int(rng.integers(10, 21)), bool(rng.random() < 0.35))
    if "delay" in case.truth:
        # held voltages would hide what the delay is short of whole ticks
        grid = replace(grid, straight=True)
    samples = int(rng.integers(4000, 5001))
    samples = case.length or samples
    lead = int(rng.integers(300, 1500)) if case.in_motion or case.history else 0
    quick = min(sample_time, _QUICK)
    # as long as records are with everything quick: short ones go through as much
    t = np.arange(samples + lead) * quick * (_USUAL / case.length if case.length else 1.0)
    greatest = float(rng.choice([sim.PAPER_VOLTAGE, rng.uniform(80.0, 150.0)], p=[0.6, 0.4]))
    lowest, greatest = BIPOLAR if case.bipolar else (0.0, greatest)
    quickness = rng.uniform(0.8, 2.5) * (quick / 1e-4) ** 0.5
    rules = sim.draw_rules(rng, greatest - lowest, quickness)
    rules[:, 5] -= lowest * rules[:, 4]  # made for 0 .. greatest - lowest
    by_heat = "drift" in case.truth and case.drift_by == "temperature"
    force = _draw_force(rng, t) if "load" in case.truth or rng.random() < 0.25 else None
    heat = _draw_temperature(rng, t) if by_heat or rng.random() < 0.25 else None
    clock = np.arange(samples + lead) * sample_time
    time = np.tile(clock - lead * sample_time, (_RECORDS, 1))
    draw_voltages = _draw_steps if case.steps else _draw_voltages
    at_rest = np.full(_RECORDS, not case.in_motion)
    if case.history:
        voltage = draw_voltages(rng, t[:samples], greatest - lowest)
        before, at_rest = _draw_history(rng, case, t[:lead], voltage, greatest - lowest)
        voltage = np.concatenate([before, voltage], axis=1)
    else:
        voltage = draw_voltages(rng, t, greatest - lowest)
    return _Scene(
        rules,
        lowest,
        greatest,
        lowest + voltage,
        sim.Surroundings(grid, time, force, heat),
        noise=1e-3 * rng.uniform(3.0, 10.0),
        lead=lead,
        at_rest=at_rest,
        slowness=sample_time / quick,
    )


def _draw_noise(rng: np.random.Generator, shape: tuple[int, int], rms: float) -> np.ndarray:
    """Draw white noise, or in a quarter of the cases noise that is a little coloured."""
    white = rng.standard_normal(shape)
    if rng.random() < 0.75:
        return rms * white
    pole = rng.uniform(0.3, 0.6)
    start = pole * rng.standard_normal((shape[0], 1))
    coloured = signal.lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], white, zi=start)[0]
    return rms * coloured


# --- the case ------------------------------------------------------------------------------------


def _draw_effect(name: str, case: Case, rng: np.random.Generator, scene: _Scene) -> sim.Effect:
    if name == "drift":
        return _draw_drift(rng, scene, case.drift_by)
    if name == "delay":
        # how a filter is sampled is worth up to a tick: beside one, less delay is not known from it
        several = scene.slowness > 1.0 or {"lag", "resonance"} & {*case.truth}
        return _draw_delay(rng, scene, 2.5 if several else 0.5)
    return _DRAWS[name](rng, scene)


def _make(case: Case, rng: np.random.Generator) -> _Made:
    scene = _draw_scene(case, rng)
    effects = {name: _draw_effect(name, case, rng, scene) for name in case.truth}
    if case.anomaly:
        effects[case.anomaly] = _draw_anomaly(case.anomaly, rng, scene)
    plant = sim.Plant(scene.rules, effects)
    clean = plant.run(scene.voltage, scene.around)
    lead, noise = scene.lead, scene.noise
    sizes, unabsorbed = {}, {}
    for name in effects:
        change = (clean - plant.without(name).run(scene.voltage, scene.around))[:, lead:]
        sizes[name] = _rms(change[-TEST:])
        rest = sim.unabsorbed(scene.rules, scene.voltage[:, lead:], change)
        unabsorbed[name] = _rms(rest[-TEST:])
    reading = clean + _draw_noise(rng, clean.shape, noise)
    step = _ADC_STEP if rng.random() < 0.4 else 0.0
    if case.quantised:
        step = rng.uniform(2.0, 6.0) * noise
        noise = float(np.hypot(noise, step / np.sqrt(12.0)))
    if step:
        reading = step * np.round(reading / step)
    records = _records(scene, reading + case.zero, lead, rng)
    return _Made(plant, scene.around.grid, records, scene.at_rest, noise, sizes, unabsorbed)


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(x**2)))


def _records(scene: _Scene, reading: np.ndarray, lead: int, rng: np.random.Generator) -> list[Record]:
    """Cut the records, the training ones to lengths of their own."""
    names = [f"train {i + 1}" for i in range(TRAINING)]
    names += [f"validation {i + 1}" for i in range(VALIDATION)]
    names += [f"test {i + 1}" for i in range(TEST)]
    records = []
    for i, name in enumerate(names):
        stop = reading.shape[1] - (int(rng.integers(0, 800)) if i < TRAINING else 0)
        part = (i, slice(lead, stop))
        around = scene.around
        records.append(
            Record(
                name=name,
                time=around.time[part],
                voltage=scene.voltage[part],
                displacement=1e-6 * reading[part],
                sample_time=around.grid.sample_time,
                force=None if around.force is None else around.force[part],
                temperature=None if around.temperature is None else around.temperature[part],
            )
        )
    return records


# --- the suite -----------------------------------------------------------------------------------

PAIRS = (
    ("play", "creep"), ("play", "resonance"), ("creep", "resonance"), ("lag", "hum"),
    ("load", "creep"), ("drift", "play"), ("nonlinearity", "creep"), ("saturation", "lag"),
    ("delay", "resonance"), ("slew", "hum"),
)  # fmt: skip
#: Effects of which the diagnosis knows the first.
DECLARED = (
    ("play", "creep"), ("creep", "resonance"), ("play", "drift"), ("lag", "play"),
    ("play",), ("creep",),
)  # fmt: skip
EACH, NONE = 5, 20
#: Stages and records of another kind: what is special, how many records of which effects, in words and
#: in the arguments of `Case`. Pairs of sample time (s) and effects stand in `SLOWER`.
SPECIAL = {
    "driven before": ({"history": "driven"}, ((), ("play",), ("creep",), ("play", "creep"))),
    "off equilibrium": ({"history": "stepped"}, ((), ("play",), ("creep",), ("resonance",))),
    "both ways and far from zero": (
        {"bipolar": True},
        ((), ("play",), ("creep",), ("nonlinearity",), ("resonance",)),
    ),
    "steps": ({"steps": True}, ((), ("resonance",), ("play",), ("creep",), ("lag",))),
    "quantised": ({"quantised": True}, ((), ("play",), ("resonance",), ("creep",))),
    "slow, both ways, far from zero, driven before": (
        {"sample_time": 5e-3, "bipolar": True, "history": "driven"},
        ((), ("delay", "play"), ("delay", "play", "creep")),
    ),
}
SLOWER = (
    (1e-3, ()), (1e-3, ("play",)), (1e-3, ("resonance",)), (1e-3, ("delay",)),
    (2e-3, ()), (2e-3, ("creep",)), (2e-3, ("drift",)), (2e-3, ("delay", "play")),
    (5e-3, ()), (5e-3, ("play",)), (5e-3, ("hum",)), (5e-3, ("delay",)), (5e-3, ("delay", "creep")),
)  # fmt: skip
#: What a sensor far from zero reads where the stage is at zero, um.
FAR = (-120.0, -75.0)


def suite(first: int = 0) -> Iterator[Case]:
    """Yield all cases of the range of seeds that begins at `first`.

    They are singles, pairs, declared ones, none, those outside the catalogue, and stages and records of
    another kind.
    """
    if first < 0 or first % RANGE:
        raise ValueError(f"seeds {first}: a range begins at a multiple of {RANGE}")
    return (replace(case, seed=first + case.seed) for case in (*_usual(), *_special()))


def _usual() -> Iterator[Case]:
    for number, effect in enumerate(sim.CATALOGUE):
        for i in range(EACH):
            yield Case(
                1000 + 20 * number + i,
                f"{effect} {i + 1}",
                (effect,),
                drift_by="time" if i % 2 else "temperature",
                in_motion=effect in ("hum", "load", "creep") and i == EACH - 1,
            )
    for i, pair in enumerate(PAIRS):
        yield Case(2000 + i, "+".join(pair), pair)
    for i, effects in enumerate(DECLARED):
        name = f"{effects[0]} declared" + "".join(f", {e}" for e in effects[1:])
        yield Case(3000 + i, name, effects, declared=effects[:1])
    for i in range(NONE):
        yield Case(4000 + i, f"none {i + 1}", in_motion=i in (7, 15))
    for i, anomaly in enumerate(sim.OUTSIDE):
        yield Case(5000 + i, f"outside: {anomaly}", outside=True, anomaly=anomaly)
    for i, effects in enumerate((("creep",), ("play", "creep"), ())):
        yield Case(6000 + i, f"{_text(effects)}, far from zero", effects, zero=(-95.0, 60.0)[i % 2])
    yield Case(5100, "outside: jumps+creep", ("creep",), outside=True, anomaly="jumps")


def _special() -> Iterator[Case]:
    for number, (name, (settings, sets)) in enumerate(SPECIAL.items()):
        zeros = np.linspace(*FAR, len(sets)) if settings.get("bipolar") else np.zeros(len(sets))
        for i, (effects, zero) in enumerate(zip(sets, zeros, strict=True)):
            seed = 8000 + 100 * number + i
            yield Case(seed, f"{_text(effects)}, {name}", effects, zero=float(zero), **settings)
    for i, (sample_time, effects) in enumerate(SLOWER):
        name = f"{_text(effects)}, {1e3 * sample_time:g} ms"
        yield Case(8800 + i, name, effects, sample_time=sample_time)


def _text(effects: tuple[str, ...]) -> str:
    return "+".join(effects) or "none"


def quick() -> Iterator[Case]:
    """Yield the first case of each effect, one of none and one outside the catalogue."""
    chosen = {f"{effect} 1" for effect in sim.CATALOGUE} | {"none 1", "outside: jumps"}
    return (case for case in suite() if case.name in chosen)


def short() -> Iterator[Case]:
    """Yield a case of each effect whose records are short, so that a diagnosis takes seconds."""
    for i, effect in enumerate(sim.CATALOGUE):
        yield Case(9000 + i, f"{effect}, short", (effect,), sample_time=1e-4, length=1200)
