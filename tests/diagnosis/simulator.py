"""A piezoelectric stage simulated apart from the product, to test its diagnosis on.

Nothing of the product's physics is used. The base is the paper's fuzzy model (10), written again
here. Everything around it acts on a grid that is `substeps` times finer than the sampling and is
parameterised as a physicist would, not as the product's chain is:

    voltage -> delay -> slew -> saturation -> lag | play -> (10) | load -> creep -> resonance | drift
            -> nonlinearity -> hum -> reading

Between the bars the signal is on the sampling grid: (10) is a model in discrete time, play does not
know time, and what follows the resonance has no memory. Signals have the shape (records, samples),
voltages are in V and displacements in um; all records of a run have one length.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from scipy import signal

#: Table 1: s1, s2, c in um, q1, q2 in um/V, q3 in um of each rule, made for 0 .. 105 V.
TABLE_1 = np.array(
    [
        [4.3427, 17.8879, 0.0892, 0.8943, 0.0196, 1.7504],
        [2.5647, 11.5798, 8.6067, 0.9140, 0.0129, 0.8773],
        [2.1349, 19.8162, 18.7381, 1.1882, 0.0148, -6.2312],
    ]
)
PAPER_VOLTAGE = 105.0


@dataclass(frozen=True)
class Grid:
    """How time is divided.

    A discrete filter of the same poles without zeros, as the product has, is early against what is
    sampled here: a resonance by half a tick where values are held and by one where they run
    straight, a lag by none and by half a tick. That is no dead time of the stage.

    Parameters
    ----------
    sample_time : float
        Sample time, s.
    substeps : int
        Fine steps in it.
    straight : bool
        Whether signals run straight from tick to tick; otherwise each value is held from the tick
        at which it is set up to the next, just before which the reading is taken.
    """

    sample_time: float
    substeps: int = 10
    straight: bool = False

    @property
    def step(self) -> float:
        """Fine step, s."""
        return self.sample_time / self.substeps

    def refine(self, x: np.ndarray) -> np.ndarray:
        """Return a sampled signal on the fine grid, shape (records, samples * substeps)."""
        held = np.repeat(x, self.substeps, axis=-1)
        if not self.straight:
            return held
        before = np.repeat(np.concatenate([x[:, :1], x[:, :-1]], axis=1), self.substeps, axis=-1)
        share = np.tile(np.arange(1, self.substeps + 1) / self.substeps, x.shape[-1])
        return before + share * (held - before)

    def sample(self, fine: np.ndarray) -> np.ndarray:
        """Return what is read of a fine signal, shape (records, samples)."""
        return fine[:, self.substeps - 1 :: self.substeps]

    def filter(self, numerator: list, denominator: list, fine: np.ndarray) -> np.ndarray:
        """Pass a fine signal through a transfer function of s, from rest at its first value."""
        system = (numerator, denominator)
        if self.straight:
            b, a, _ = signal.cont2discrete(system, self.step, "foh")
            b = b[0]
        else:
            b, a, _ = signal.cont2discrete(system, self.step, "zoh")
            b = b[0][1:]  # read at the end of each fine step, not at its beginning
        rest = signal.lfilter_zi(b, a)
        return signal.lfilter(b, a, fine, zi=rest * fine[:, :1])[0]


@dataclass(frozen=True)
class Surroundings:
    """What acts on a stage beside the voltage; arrays have the shape (records, samples)."""

    grid: Grid
    time: np.ndarray
    force: np.ndarray | None = None
    temperature: np.ndarray | None = None


class Effect(Protocol):
    """A part of the plant that can be left out."""

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        """Return the signal behind the effect."""


# --- the base ----------------------------------------------------------------------------------


def advance(rules: np.ndarray, y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return y_k of (10).

    Parameters
    ----------
    rules : ndarray, shape (..., 3, 6)
        As `TABLE_1`.
    y, x : ndarray, shape (...)
        y_{k-1}, um, and x_k, V.
    """
    s1, s2, c, q1, q2, q3 = np.moveaxis(rules, -1, 0)
    y, x = y[..., None], x[..., None]
    squared = (y - c) ** 2
    weight = np.exp(-0.5 / s1**2 * squared) + np.exp(-0.5 / s2**2 * squared)
    return (weight * (q1 * y + q2 * x + q3)).sum(-1) / weight.sum(-1)


def equilibrium(rules: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return where (10) comes to rest at voltages x, coming from below its range."""
    y = np.zeros(np.broadcast_shapes(rules.shape[:-2], np.shape(x)))
    for _ in range(3000):
        last, y = y, advance(rules, y, x)
        if not np.any(np.abs(y - last) > 1e-13):  # a draw that diverged to NaN ends here too
            break
    return y


def run_base(rules: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Run (10) from rest at the first voltage; shape (rows, samples), rules for all rows or each."""
    y = equilibrium(rules, x[:, 0])
    s1, s2, c, q1, q2, q3 = (np.ascontiguousarray(p) for p in np.moveaxis(rules, -1, 0))
    k1, k2 = -0.5 / s1**2, -0.5 / s2**2
    driven = q2 * x.T[:, :, None] + q3
    result = np.empty((x.shape[1], x.shape[0]))
    for k, forcing in enumerate(driven):
        column = y[:, None]
        squared = (column - c) ** 2
        weight = np.exp(k1 * squared) + np.exp(k2 * squared)
        y = (weight * (q1 * column + forcing)).sum(-1) / weight.sum(-1)
        result[k] = y
    return result.T


def draw_rules(rng: np.random.Generator, greatest: float, quickness: float) -> np.ndarray:
    """Return Table 1 with every parameter changed, contracting and of 8 to 16 um over 0 .. greatest.

    Parameters
    ----------
    rng : numpy.random.Generator
    greatest : float
        Upper end of the voltages, V.
    quickness : float
        Factor of the rate at which the model comes to rest; its equilibria do not change with it.
    """
    volts = np.linspace(0.0, greatest, 41)
    while True:
        rules = TABLE_1 * rng.uniform(0.9, 1.1, TABLE_1.shape)
        rules[:, 2] = TABLE_1[:, 2] + rng.uniform(-1.0, 1.0, 3)
        rules[:, 3] = 1.0 + quickness * (TABLE_1[:, 3] - 1.0) * rng.uniform(0.85, 1.15, 3)
        rules[:, 4:] *= quickness
        rules[:, 4] *= PAPER_VOLTAGE / greatest
        rules[:, [0, 1, 2, 4, 5]] *= rng.uniform(0.6, 1.05)
        with np.errstate(all="ignore"):  # a draw may fold and diverge; it is refused then
            rest = equilibrium(rules, volts)
        if not 8.0 <= rest[-1] - rest[0] <= 16.0 or rest[0] < -1.0 or np.any(np.diff(rest) <= 0.0):
            continue
        if _contracts(rules, volts, rest):
            return rules


def _contracts(rules: np.ndarray, volts: np.ndarray, rest: np.ndarray) -> bool:
    """Tell whether dy_k/dy_{k-1} lies in 0 .. 0.985 at rest, and in -0.2 .. 1 wherever steps lead."""

    def slope(y: np.ndarray, x: np.ndarray) -> np.ndarray:
        return (advance(rules, y + 1e-5, x) - advance(rules, y - 1e-5, x)) / 2e-5

    at_rest = slope(rest, volts)
    anywhere = slope(*np.meshgrid(rest, volts))
    calm = at_rest.min() > 0.0 and at_rest.max() < 0.985
    return calm and anywhere.min() > -0.2 and anywhere.max() < 0.998


# --- in front of the base, on the fine grid ------------------------------------------------------


@dataclass(frozen=True)
class Delay:
    """Dead time, s, to the nearest fine step."""

    time: float

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        shift = round(self.time / around.grid.step)
        lead = np.repeat(x[:, :1], shift, axis=1)
        return np.concatenate([lead, x], axis=1)[:, : x.shape[1]]


@dataclass(frozen=True)
class Slew:
    """An amplifier that cannot change faster than a rate, V/s."""

    rate: float

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        most = self.rate * around.grid.step
        result = np.empty_like(x.T)
        y = x[:, 0].copy()
        for i, target in enumerate(np.ascontiguousarray(x.T)):
            y = np.minimum(np.maximum(target, y - most), y + most)
            result[i] = y
        return result.T


@dataclass(frozen=True)
class Saturation:
    """An amplifier that ends at two voltages."""

    low: float
    high: float

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        return np.clip(x, self.low, self.high)


@dataclass(frozen=True)
class Lag:
    """An RC element: resistance (ohm) before the capacitance (F) of the stack."""

    resistance: float
    capacitance: float

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        return around.grid.filter([1.0], [self.resistance * self.capacitance, 1.0], x)


# --- in front of the base, without time ----------------------------------------------------------


@dataclass(frozen=True)
class Play:
    """Prandtl-Ishlinskii operator of a density over its thresholds.

    Parameters
    ----------
    density : str
        `exponential`, `uniform` or `hump`.
    scale : float
        Of the density, V.
    share : float
        Share of the memory in the voltage that acts; the rest follows the voltage at once.
    greatest : float
        Voltage that is reached unchanged on the initial loading curve, V.
    operators : int
        By how many the density is represented.
    """

    density: str
    scale: float
    share: float
    greatest: float
    operators: int = 48

    def elements(self) -> tuple[np.ndarray, np.ndarray]:
        """Return thresholds, V, and weights."""
        most = 0.5 * self.greatest
        r = most * (np.arange(self.operators) + 0.5) / self.operators
        density = {
            "exponential": np.exp(-r / self.scale),
            "uniform": np.where(r < self.scale, 1.0, 0.0),
            "hump": r / self.scale * np.exp(-0.5 * (r / self.scale) ** 2),
        }[self.density]
        return r, density / np.sum(density * (1.0 - r / self.greatest))

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        r, weights = self.elements()
        start = x[:, :1]
        state = np.sign(start) * np.maximum(np.abs(start) - r, 0.0)
        result = np.empty((x.shape[1], x.shape[0]))
        for k, column in enumerate(x.T[:, :, None]):
            state = np.minimum(np.maximum(state, column - r), column + r)
            result[k] = state @ weights
        return (1.0 - self.share) * x + self.share * result.T


@dataclass(frozen=True)
class Stiction:
    """Outside the catalogue: sticks whenever the voltage is slower than a rate (V/s), then snaps."""

    rate: float

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        speed = np.abs(np.diff(x, axis=1, prepend=x[:, :1])) / around.grid.sample_time
        moving = speed > self.rate
        moving[:, 0] = True
        last = np.maximum.accumulate(np.where(moving, np.arange(x.shape[1]), 0), axis=1)
        return np.take_along_axis(x, last, axis=1)


# --- behind the base, on the fine grid -----------------------------------------------------------


@dataclass(frozen=True)
class Load:
    """Spring of a stiffness, N/um, that a compressive force shortens."""

    stiffness: float

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        return x - around.grid.refine(around.force) / self.stiffness


@dataclass(frozen=True)
class Creep:
    """Slow part of the displacement, a sum of first-order terms with gains and time constants, s.

    The displacement at once is smaller by the whole of it, so that the travel after long rest
    stays as it is.
    """

    gains: tuple[float, ...]
    times: tuple[float, ...]

    @classmethod
    def logarithmic(cls, total: float, first: float, last: float) -> Creep:
        """Return creep that grows with the logarithm of time from `first` to `last`, s."""
        times = np.geomspace(first, last, 14)
        return cls((total / 14,) * 14, tuple(times))

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        result = (1.0 - sum(self.gains)) * x
        for gain, time in zip(self.gains, self.times, strict=True):
            result = result + gain * around.grid.filter([1.0], [time, 1.0], x)
        return result


@dataclass(frozen=True)
class Resonance:
    """Mass on a spring: natural frequency, Hz, and Lehr's damping."""

    frequency: float
    damping: float

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        w = 2.0 * np.pi * self.frequency
        return around.grid.filter([1.0], [1.0 / w**2, 2.0 * self.damping / w, 1.0], x)


# --- behind the base, without memory -------------------------------------------------------------


@dataclass(frozen=True)
class Drift:
    """Thermal expansion, um/K from a reference in K, and drift with time, um/s."""

    coefficient: float = 0.0
    reference: float = 293.15
    rate: float = 0.0

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        result = x + self.rate * around.time
        if self.coefficient:
            result = result + self.coefficient * (around.temperature - self.reference)
        return result


@dataclass(frozen=True)
class Nonlinearity:
    """Curve of the reading: Chebyshev polynomials 2 .. 4 and a bend like a sine's, over a range.

    Parameters
    ----------
    low, high : float
        Range, um.
    chebyshev : tuple of float
        Amplitudes of T2, T3 and T4, um, none of which vanishes at the ends.
    bend : float
        Amplitude of one or more half waves that vanish at the ends, um.
    waves : int
        Half waves over the range.
    """

    low: float
    high: float
    chebyshev: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bend: float = 0.0
    waves: int = 2

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        z = (2.0 * x - self.low - self.high) / (self.high - self.low)
        curve = np.polynomial.chebyshev.chebval(z, [0.0, 0.0, *self.chebyshev])
        return x + curve + self.bend * np.sin(0.5 * np.pi * self.waves * (z + 1.0))


@dataclass(frozen=True)
class Hum:
    """Line of an amplitude, um, and a frequency, Hz, with a phase of its own in each record."""

    amplitude: float
    frequency: float
    seed: int

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        phase = np.random.default_rng(self.seed).uniform(0.0, 2.0 * np.pi, (len(x), 1))
        return x + self.amplitude * np.sin(2.0 * np.pi * self.frequency * around.time + phase)


@dataclass(frozen=True)
class Jumps:
    """Outside the catalogue: the reading jumps between two levels, um apart, at random times."""

    height: float
    per_record: float
    seed: int

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        rng = np.random.default_rng(self.seed)
        flips = rng.random(x.shape) < self.per_record / x.shape[1]
        return x + self.height * (np.cumsum(flips, axis=1) % 2)


@dataclass(frozen=True)
class Whistle:
    """Outside the catalogue: a disturbance that sweeps and swells, differently in each record."""

    amplitude: float
    low: float
    high: float
    seed: int

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        rng = np.random.default_rng(self.seed)
        ends = rng.uniform(self.low, self.high, (2, len(x), 1))
        swell = rng.uniform(2.0, 6.0, (len(x), 1))
        phase = rng.uniform(0.0, 2.0 * np.pi, (2, len(x), 1))
        t = around.time - around.time[:, :1]
        duration = t[:, -1:]
        angle = 2.0 * np.pi * (ends[0] * t + 0.5 * (ends[1] - ends[0]) * t**2 / duration)
        envelope = 0.5 * (1.0 + np.cos(2.0 * np.pi * swell * t / duration + phase[0]))
        return x + self.amplitude * envelope * np.sin(angle + phase[1])


@dataclass(frozen=True)
class Slip:
    """Outside the catalogue: the gain changes at one moment of each record, to a share of its own."""

    most: float
    seed: int

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        rng = np.random.default_rng(self.seed)
        moment = rng.uniform(0.2, 0.8, (len(x), 1)) * x.shape[1]
        change = self.most * rng.uniform(0.5, 1.0, (len(x), 1)) * rng.choice([-1.0, 1.0], (len(x), 1))
        return x * (1.0 + change * (np.arange(x.shape[1]) >= moment))


@dataclass(frozen=True)
class Bursts:
    """Outside the catalogue: short bursts of noise, um."""

    amplitude: float
    share: float
    seed: int

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        rng = np.random.default_rng(self.seed)
        length = 40
        blocks = rng.random((len(x), x.shape[1] // length + 1)) < self.share
        on = np.repeat(blocks, length, axis=1)[:, : x.shape[1]]
        return x + self.amplitude * on * rng.standard_normal(x.shape)


@dataclass(frozen=True)
class HiddenHeat:
    """Outside the catalogue: the gain follows a temperature that nobody recorded."""

    most: float
    seed: int

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        return x * (1.0 + self.most * _slow_walk(self.seed, x.shape))


@dataclass(frozen=True)
class Wander:
    """Outside the catalogue: the reading walks at random at low frequencies, um."""

    most: float
    seed: int

    def apply(self, x: np.ndarray, around: Surroundings) -> np.ndarray:
        return x + self.most * _slow_walk(self.seed, x.shape)


def _slow_walk(seed: int, shape: tuple[int, int]) -> np.ndarray:
    """Return random walks, smoothed, from 0, each within -1 .. 1 and without its own trend."""
    walk = np.cumsum(np.random.default_rng(seed).standard_normal(shape), axis=1)
    walk = signal.sosfiltfilt(signal.butter(2, 40.0 / shape[1], output="sos"), walk, axis=1)
    walk = signal.detrend(walk, axis=1)
    walk = walk - walk[:, :1]
    return walk / np.max(np.abs(walk), axis=1, keepdims=True)


# --- the whole -----------------------------------------------------------------------------------

#: Effects by the place at which they act, in their order there; those below have no other name.
FRONT_FINE = ("delay", "slew", "saturation", "lag")
FRONT = ("play", "stiction")
BEHIND_FINE = ("load", "creep", "resonance")
READING = (
    "slip", "hidden heat", "drift", "wander", "jumps", "nonlinearity", "hum", "whistle", "bursts",
)  # fmt: skip
#: What is in `own_physics`: those that know time, and that between samples knows none.
OWN_FINE, OWN = ("second resonance", "self-heating", "drag"), ("friction",)
OUTSIDE = ("stiction", "slip", "hidden heat", "wander", "jumps", "whistle", "bursts")
CATALOGUE = tuple(name for name in (*FRONT_FINE, *FRONT, *BEHIND_FINE, *READING) if name not in OUTSIDE)


@dataclass(frozen=True, eq=False)
class Plant:
    """A stage: its base and its effects by name.

    Parameters
    ----------
    rules : ndarray, shape (3, 6)
        As `TABLE_1`.
    effects : mapping of str to Effect
        Those that are there; the rest of the chain is left out.
    """

    rules: np.ndarray
    effects: Mapping[str, Effect] = field(default_factory=dict)

    def without(self, name: str) -> Plant:
        """Return the plant without one effect."""
        return replace(self, effects={n: e for n, e in self.effects.items() if n != name})

    def run(self, voltage: np.ndarray, around: Surroundings) -> np.ndarray:
        """Return the reading without noise, from long rest at the first voltage, um."""
        x = self._fine(FRONT_FINE, voltage, around)
        x = self._walk(FRONT, x, around)
        y = run_base(self.rules, x)
        y = self._fine((*BEHIND_FINE, *OWN_FINE), y, around)
        return self._walk((*OWN, *READING), y, around)

    def _walk(self, names: tuple[str, ...], x: np.ndarray, around: Surroundings) -> np.ndarray:
        for name in names:
            if name in self.effects:
                x = self.effects[name].apply(x, around)
        return x

    def _fine(self, names: tuple[str, ...], x: np.ndarray, around: Surroundings) -> np.ndarray:
        if not any(name in self.effects for name in names):
            return x
        return around.grid.sample(self._walk(names, around.grid.refine(x), around))


def unabsorbed(rules: np.ndarray, voltage: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Return what of a change of the reading no small change of (10)'s parameters makes, um.

    The change is projected on the space of the free run's derivatives by the eighteen parameters
    and of a constant, over all records at once.

    Parameters
    ----------
    rules : ndarray, shape (3, 6)
    voltage, change : ndarray, shape (records, samples)
    """
    records, samples = voltage.shape
    steps = 1e-5 * np.maximum(np.abs(rules), 0.1).ravel()
    varied = rules + steps[:, None, None] * np.eye(18).reshape(18, 3, 6)
    rows = np.repeat(np.concatenate([rules[None], varied]), records, axis=0)
    runs = run_base(rows, np.tile(voltage, (19, 1))).reshape(19, records * samples)
    derivatives = np.vstack([(runs[1:] - runs[0]) / steps[:, None], np.ones(runs.shape[1])]).T
    derivatives /= np.linalg.norm(derivatives, axis=0)
    fit = np.linalg.lstsq(derivatives, change.ravel(), rcond=1e-10)[0]
    return change - (derivatives @ fit).reshape(change.shape)
