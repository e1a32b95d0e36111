"""Drive voltages for simulated records: each kind drawn at random, from a start at rest.

Every kind is a function of a random generator, a time array in s and the greatest voltage in V; it
returns the voltage at those times, within 0 .. greatest.
"""

from collections.abc import Callable

import numpy as np
from scipy import signal

Draw = Callable[[np.random.Generator, np.ndarray, float], np.ndarray]


def _between(unit: np.ndarray, low: float, high: float) -> np.ndarray:
    """Map -1 .. 1 onto low .. high."""
    return 0.5 * (low + high) + 0.5 * (high - low) * unit


def _range(rng: np.random.Generator, greatest: float, least_share: float) -> tuple[float, float]:
    """Draw a range, more often than not from 0 V, of at least a share of the greatest voltage."""
    share = rng.uniform(least_share, 1.0)
    low = 0.0 if rng.random() < 0.6 else rng.uniform(0.0, 1.0 - share)
    return low * greatest, (low + share) * greatest


def two_sines(rng: np.random.Generator, t: np.ndarray, greatest: float) -> np.ndarray:
    """Sum a sine and its octave, of nearly the whole range, as (22) does."""
    phase = 2.0 * np.pi * rng.uniform(8.0, 40.0) * t
    shape = rng.uniform(0.4, 0.75) * -np.cos(2.0 * phase) - 0.4 * np.cos(phase)
    shape = (shape - shape.min()) / np.ptp(shape)
    return rng.uniform(0.85, 1.0) * greatest * shape


def sine(rng: np.random.Generator, t: np.ndarray, greatest: float) -> np.ndarray:
    """Swing at one of 5 .. 100 Hz."""
    frequency = 5.0 * 20.0 ** rng.random()
    return _between(-np.cos(2.0 * np.pi * frequency * t), *_range(rng, greatest, 0.4))


def slow_sine(rng: np.random.Generator, t: np.ndarray, greatest: float) -> np.ndarray:
    """Swing slowly, over nearly the whole range."""
    frequency = rng.uniform(2.5, 8.0)
    return _between(-np.cos(2.0 * np.pi * frequency * t), 0.0, rng.uniform(0.85, 1.0) * greatest)


def triangle(rng: np.random.Generator, t: np.ndarray, greatest: float) -> np.ndarray:
    """Ramp up and down."""
    angle = 2.0 * np.pi * rng.uniform(5.0, 40.0) * t
    return _between(signal.sawtooth(angle, width=0.5), *_range(rng, greatest, 0.5))


def staircase(rng: np.random.Generator, t: np.ndarray, greatest: float) -> np.ndarray:
    """Step to random levels and hold each for 20 to 80 ms."""
    count = int(t[-1] / 0.02) + 2
    holds = rng.uniform(0.02, 0.08, count)
    levels = rng.uniform(0.0, greatest, count)
    levels[0] = 0.0 if rng.random() < 0.7 else 0.5 * greatest
    return levels[np.searchsorted(np.cumsum(holds), t, side="right")]


def stairs(rng: np.random.Generator, t: np.ndarray, greatest: float) -> np.ndarray:
    """Climb in equal steps to nearly the greatest voltage and back, once or twice."""
    turns = int(rng.integers(1, 3))
    count = int(rng.integers(3, 7))
    up = np.linspace(0.0, rng.uniform(0.85, 1.0) * greatest, count + 1)
    levels = np.tile(np.concatenate([up[:-1], up[:0:-1]]), turns)
    return levels[np.minimum((levels.size * t / t[-1]).astype(int), levels.size - 1)]


def multisine(rng: np.random.Generator, t: np.ndarray, greatest: float) -> np.ndarray:
    """Add many sines of random phase up to 60 .. 300 Hz."""
    # tones well below the sampling frequency, however slow that is
    top = min(rng.uniform(60.0, 300.0), 0.15 / (t[1] - t[0]))
    tones = np.geomspace(rng.uniform(3.0, 8.0), top, int(rng.integers(12, 30)))
    total = np.zeros_like(t)
    for tone, phase in zip(tones, rng.uniform(0.0, 2.0 * np.pi, tones.size), strict=True):
        total += np.sin(2.0 * np.pi * tone * t + phase)
    unit = 2.0 * (total - total.min()) / np.ptp(total) - 1.0
    return _between(unit, *_range(rng, greatest, 0.6))


def chirp(rng: np.random.Generator, t: np.ndarray, greatest: float) -> np.ndarray:
    """Sweep the frequency up to 60 .. 250 Hz."""
    top = min(rng.uniform(60.0, 250.0), 0.15 / (t[1] - t[0]))
    sweep = signal.chirp(t, rng.uniform(2.0, 6.0), t[-1], top, phi=180.0)
    return _between(sweep, *_range(rng, greatest, 0.5))


def decaying(rng: np.random.Generator, t: np.ndarray, greatest: float) -> np.ndarray:
    """Swing in loops, one within the other."""
    envelope = np.exp(-t / (rng.uniform(0.2, 0.5) * t[-1]))
    unit = -np.cos(2.0 * np.pi * rng.uniform(12.0, 50.0) * t) * envelope
    return _between(unit, 0.0, rng.uniform(0.85, 1.0) * greatest)


def long_hold(rng: np.random.Generator, t: np.ndarray, greatest: float) -> np.ndarray:
    """Step up early, hold for long, step back for the last part."""
    level = rng.uniform(0.5, 1.0) * greatest
    duration = t[-1]
    up, down = rng.uniform(0.05, 0.1) * duration, rng.uniform(0.6, 0.75) * duration
    rest = rng.uniform(0.0, 0.3) * level
    return np.select([t < up, t < down], [0.0, level], rest)
