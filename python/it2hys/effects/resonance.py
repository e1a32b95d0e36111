"""Mechanical resonance, exact poles and no zeros.

For it speaks ringing at one frequency after steps and corners, and a coherent peak of the residual's
transfer from the voltage there, at every amplitude; below it, the residual grows with the square of
frequency and is in phase.
"""

import math

import casadi as ca
import numpy as np
from scipy.signal import find_peaks, lfilter, lfilter_zi

from it2hys.effects import Clues, Extent, Scalar, Signature, Start, Surroundings, Values
from it2hys.effects.statistics import Ground, absorbed, coherence_with_voltage, modelled, readable

#: Dampings that a signature tries, and how many frequencies of each.
_GRID = {0.015: 64, 0.05: 32, 0.15: 28}

#: A step is a change of the voltage of this share of its range; what follows it is looked at for so
#: many samples at most, and if the voltage goes on without a step for so many at least.
_STEP, _LONGEST, _SHORTEST = 0.05, 400, 40
#: Peaks of the spectrum of what follows steps that are refined, steps of frequency about each (over one
#: line of the spectrum to either side), and dampings.
_PEAKS, _NEAR, _DAMPINGS = 2, 21, np.geomspace(0.003, 0.3, 13)
#: Share of what follows steps, on average, that a ring has to be.
_RINGS = 0.1

#: What the effect is, in plain words.
MEANING = "the stage rings at its own frequency after a fast change"
#: What would show the effect apart from others.
EXPERIMENT = "small steps, or a small chirp through the band (a resonance rings at one frequency)"


def is_on(parameters: Values) -> bool:
    """Return whether there is a resonance."""
    return parameters["resonance.frequency"] > 0.0


def size(parameters: Values) -> int:
    """Return the number of states: the last two outputs."""
    return 2


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input at rest and the states."""
    return y, [y, y]


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the resonating displacement and the last two."""
    damping = values["resonance.damping"]
    angle = 2.0 * math.pi * values["resonance.frequency"] * values["sampleTime"]
    radius = ca.exp(-damping * angle)
    a1 = 2.0 * radius * ca.cos(angle * ca.sqrt(1.0 - damping * damping))
    a2 = -radius * radius
    y = a1 * state[0] + a2 * state[1] + (1.0 - a1 - a2) * x
    return y, [y, state[0]]


def starts(extent: Extent) -> dict[str, Start]:
    """Start at a quarter of the Nyquist frequency; the peak of the residual's spectrum is better."""
    nyquist = 0.5 / extent.sample_time
    return {
        "resonance.frequency": Start(0.25 * nyquist, 1e-3 * nyquist, 0.98 * nyquist),
        "resonance.damping": Start(0.05, 1e-3, 0.95),
    }


def guesses(clues: Clues) -> list[dict[str, float]]:
    """Return frequencies over the whole band, where the residual peaks, and rings after steps."""
    nyquist = 0.5 / clues.extent.sample_time
    frequency, power = clues.spectrum(400)
    peaks, _ = find_peaks(np.log(power + np.finfo(float).tiny), distance=10)
    highest = peaks[np.argsort(power[peaks])[::-1][:6]]
    spread = np.geomspace(0.01, 0.9, 40) * nyquist
    frequencies = [*spread, *frequency[highest]]
    poles = [(f, d) for f in frequencies if f > 2e-3 * nyquist for d in (0.02, 0.1, 0.5)]
    return [
        {"resonance.frequency": f, "resonance.damping": d} for f, d in (*poles, *_after_steps(clues))
    ]


def signature(clues: Clues) -> Signature | None:
    """Return whether the residual rings at one frequency whenever the displacement changes.

    The residual is regressed on the ringing that resonances of many frequencies would add to the
    model's reading, once the model's own means are taken out; errors are spectral and by blocks
    (HAC), the p-value is corrected for the number of frequencies and dampings, those of the rings
    that were sought after steps among them. The statistic is the share of the residual's power that
    the best explains.
    """
    seen = readable(clues)
    if seen is None:
        return None
    nyquist = 0.5 / clues.extent.sample_time
    # the less damped, the narrower
    rings = _after_steps(seen)
    poles = [(f, d) for d, n in _GRID.items() for f in np.geomspace(0.03, 0.9, n) * nyquist]
    poles += rings
    bank = [lambda c, p=p: _ringing(modelled(c), *p, clues.extent.sample_time) for p in poles]
    chosen, trial = Ground(seen, [absorbed(seen)]).best(bank, positive=True)
    frequency, damping = poles[chosen]
    at, coherences = coherence_with_voltage(seen)
    text = (
        f"Whenever the displacement changes, the residual rings at about {frequency:.3g} Hz "
        "(damping about "
        f"{damping:.2g}): {100 * trial.share:.0f} % of its power; its coherence with the voltage is "
        f"{np.interp(frequency, at, coherences.max(axis=0)):.2g} there."
    )
    # the rings were chosen among many more than are in the bank
    tried = 1.0 + len(rings) * _NEAR * len(_DAMPINGS) / len(poles)
    return Signature(trial.share, min(1.0, tried * trial.p_value), text)


def _after_steps(clues: Clues) -> list[tuple[float, float]]:
    """Return frequency, Hz, and damping of what rings in the residual after steps of the voltage."""
    mean = _mean_after_steps(clues)
    if mean is None:
        return []
    mean = mean - mean.mean()
    lines = np.fft.rfftfreq(8 * len(mean))
    power = np.abs(np.fft.rfft(mean * np.hanning(len(mean)), 8 * len(mean))) ** 2
    peaks, _ = find_peaks(power)
    highest = peaks[np.argsort(power[peaks])[::-1][:_PEAKS]]
    found = [_refined(mean, lines[peak]) for peak in highest]
    sample_time = clues.extent.sample_time
    return [(f / sample_time, d) for f, d, share in found if share > _RINGS]


def _mean_after_steps(clues: Clues) -> np.ndarray | None:
    """Return the residual after steps, on average by their height, as long as half of them are held."""
    parts, heights = [], []
    for clue in clues.records:
        change = np.diff(clue.voltage)
        steps = np.flatnonzero(np.abs(change) > _STEP * clues.extent.voltage_span)
        for first, last in zip(steps, np.append(steps, len(change))[1:], strict=True):
            part = slice(first + 1, min(last, first + _LONGEST) + 1)
            if part.stop - part.start >= _SHORTEST and np.all(clue.used[part]):
                parts.append(clue.residual[part])
                heights.append(change[first])
    if not parts:
        return None
    count = int(np.median([len(part) for part in parts]))
    chosen = [(h, part[:count]) for h, part in zip(heights, parts, strict=True) if len(part) >= count]
    return sum(h * part for h, part in chosen) / sum(h * h for h, _ in chosen)


def _refined(mean: np.ndarray, line: float) -> tuple[float, float, float]:
    """Return frequency (cycles per sample), damping and share of the ring nearest to a line."""
    ticks, best = np.arange(len(mean)), (line, float(_DAMPINGS[0]), 0.0)
    power = max(float(mean @ mean), np.finfo(float).tiny)
    for frequency in line + np.linspace(-1.0, 1.0, _NEAR) / len(mean):
        if not 0.0 < frequency < 0.5:
            continue
        for damping in _DAMPINGS:
            decay = np.exp(-2.0 * np.pi * frequency * damping * ticks)
            angle = 2.0 * np.pi * frequency * math.sqrt(1.0 - damping**2) * ticks
            basis, _ = np.linalg.qr(decay[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))
            share = float(np.sum((basis.T @ mean) ** 2)) / power
            if share > best[2]:
                best = (float(frequency), float(damping), share)
    return best


def _ringing(y: np.ndarray, frequency: float, damping: float, sample_time: float) -> np.ndarray:
    """Return what a resonance adds to a signal, from rest at its first value."""
    angle = 2.0 * math.pi * frequency * sample_time
    radius = math.exp(-damping * angle)
    a1, a2 = 2.0 * radius * math.cos(angle * math.sqrt(1.0 - damping**2)), -(radius**2)
    filtered = ([1.0 - a1 - a2], [1.0, -a1, -a2])
    return lfilter(*filtered, y, zi=lfilter_zi(*filtered) * y[0])[0] - y
