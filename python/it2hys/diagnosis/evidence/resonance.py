"""Ringing of the mechanics.

Its signature is ringing at one frequency after steps and corners, and a coherent peak of the residual's
transfer from the voltage there, at every amplitude; below it, the residual grows with the square of
frequency and is in phase.
"""

import math
from collections.abc import Mapping

import numpy as np
from scipy.signal import find_peaks, lfilter, lfilter_zi
from scipy.stats import f as f_distribution

from it2hys.diagnosis.evidence.base import Signature
from it2hys.diagnosis.evidence.statistics import (
    Answer,
    Ground,
    Stage,
    StepEvidence,
    absorbed,
    coherence_with_voltage,
    modelled,
    readable,
)
from it2hys.model.effects.resonance import poles
from it2hys.policy import PHYSICS
from it2hys.records.clues import Clues
from it2hys.support.numerals import plain

#: Dampings that a signature tries, and how many frequencies of each.
_GRID = {0.015: 64, 0.05: 32, 0.15: 28}

#: What follows a step is looked at for so many samples at most, and if the voltage goes on without a
#: step for so many at least.
_LONGEST, _SHORTEST = 400, 40

#: Peaks of the spectrum of what follows steps that are refined, steps of frequency about each (over one
#: line of the spectrum to either side), and dampings.
_PEAKS, _NEAR, _DAMPINGS = 2, 21, np.geomspace(0.003, 0.3, 13)

#: Of a ring: frequency, damping, amplitude and phase.
_PARAMETERS = 4


def _rung(ring: tuple[float, float]) -> Stage:
    """Return a resonance, by cycles per tick and damping, of responses."""
    a1, a2 = poles(2.0 * np.pi * ring[0], ring[1])
    return lambda x: lfilter([1.0 - a1 - a2], [1.0, -a1, -a2], x)


class ResonanceEvidence(StepEvidence):
    """A residual that rings at one frequency whenever the displacement changes."""

    meaning = "the stage rings at its own frequency after a fast change"
    experiment = "small steps, or a small chirp through the band (a resonance rings at one frequency)"

    occasional = True
    smooths = True
    answer = Answer(
        _rung, tuple((f, d) for f in np.geomspace(0.015, 0.4, 24) for d in (0.02, 0.06, 0.15))
    )

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return frequencies over the whole band, where the residual peaks, and rings after steps."""
        nyquist = 0.5 / clues.extent.sample_time
        frequency, power = clues.spectrum(400)
        peaks, _ = find_peaks(np.log(power + np.finfo(float).tiny), distance=10)
        highest = peaks[np.argsort(power[peaks])[::-1][:6]]
        spread = np.geomspace(0.01, 0.9, 40) * nyquist
        frequencies = [*spread, *frequency[highest]]
        grid = [(f, d) for f in frequencies if f > 2e-3 * nyquist for d in (0.02, 0.1, 0.5)]
        rings = [*grid, *((f, d) for f, d, _ in _after_steps(clues))]
        return [{"resonance.frequency": f, "resonance.damping": d} for f, d in rings]

    def is_within_a_sample(self, values: Mapping) -> bool:
        """Return whether it smooths, and is quick at that."""
        slow = 2.0 * np.pi * values["resonance.frequency"] * values["sampleTime"] < 1.0
        return self.only_smooths(values) and not slow

    def only_smooths(self, values: Mapping) -> bool:
        """Return whether it is damped so much that it does not ring."""
        return bool(values["resonance.damping"] > PHYSICS.damped)

    def is_done_within(self, values: Mapping, time: float) -> bool:
        """Return whether a ring has decayed by two of its time constants."""
        decay = 2.0 * np.pi * values["resonance.damping"] * values["resonance.frequency"]
        return decay * time > 2.0

    def signature(self, clues: Clues) -> Signature | None:
        """Return whether the residual rings at one frequency whenever the displacement changes.

        The residual is regressed on the ringing that resonances of many frequencies would add to the
        model's reading, once the model's own means are taken out; errors are spectral and by blocks
        (HAC), the p-value is corrected for the number of frequencies and dampings, those of the rings
        that were sought after steps among them. The statistic is the share of the residual's power that
        the best explains. What rings after a few steps alone is a few events to such errors: where most
        of what follows steps is one ring, that is a test of its own.
        """
        seen = readable(clues)
        if seen is None:
            return None
        nyquist = 0.5 / clues.extent.sample_time
        # the less damped, the narrower
        rings = _after_steps(seen)
        tried = [(f, d) for d, n in _GRID.items() for f in np.geomspace(0.03, 0.9, n) * nyquist]
        tried += [(f, d) for f, d, _ in rings]
        bank = [lambda c, p=p: _ringing(modelled(c), *p, clues.extent.sample_time) for p in tried]
        chosen, trial = Ground(seen, [absorbed(seen)]).best(bank, positive=True)
        frequency, damping = tried[chosen]
        at, coherences = coherence_with_voltage(seen)
        text = (
            f"Whenever the displacement changes, the residual rings at about {plain(frequency)} Hz "
            "(damping about "
            f"{damping:.2g}): {100 * trial.share:.0f} % of its power; its coherence with the "
            "voltage is "
            f"{np.interp(frequency, at, coherences.max(axis=0)):.2g} there."
        )
        # the rings were chosen among many more than are in the bank
        choices = 1.0 + len(rings) * _NEAR * len(_DAMPINGS) / len(tried)
        # of two tests the better one
        p_value = 2.0 * min([choices * trial.p_value, *(chance for _, _, chance in rings)])
        return Signature(trial.share, min(1.0, p_value), text)


def _after_steps(clues: Clues) -> list[tuple[float, float, float]]:
    """Return frequency, Hz, damping and p-value of what rings in the residual after steps."""
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
    return [
        (f / sample_time, d, _by_chance(d, share, len(mean)))
        for f, d, share in found
        if share > PHYSICS.ring_share
    ]


def _by_chance(damping: float, share: float, count: int) -> float:
    """Return the p-value (F-test) of a ring that is most of what follows steps, for some cycles."""
    if damping > PHYSICS.ring_damping or share < PHYSICS.ring_most:
        return 1.0
    free = count - _PARAMETERS
    ratio = share / _PARAMETERS / max((1.0 - share) / free, np.finfo(float).tiny)
    tried = _PEAKS * _NEAR * len(_DAMPINGS)
    return min(1.0, tried * float(f_distribution.sf(ratio, _PARAMETERS, free)))


def _mean_after_steps(clues: Clues) -> np.ndarray | None:
    """Return the residual after steps, on average by their height, as long as half of them are held."""
    parts, heights = [], []
    for clue in clues.records:
        change = np.diff(clue.voltage)
        steps = np.flatnonzero(np.abs(change) > PHYSICS.ring_step * clues.extent.voltage_span)
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
    a1, a2 = poles(2.0 * math.pi * frequency * sample_time, damping)
    filtered = ([1.0 - a1 - a2], [1.0, -a1, -a2])
    return lfilter(*filtered, y, zi=lfilter_zi(*filtered) * y[0])[0] - y


EVIDENCE = ResonanceEvidence()
