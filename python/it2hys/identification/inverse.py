"""The inverse on measured data: which voltage it asks for when fed with the measured displacement.

The voltage that was applied is the answer. Without the rig, their difference says how well feedforward
will track. Three references are made of a record. What a user's may contain is *local*: up to the
highest frequency at which the displacement stands out of the noise thereabouts. A ring once in ten
seconds is no reason to feed the inverse with noise all the time. A search compares inverses on its
*band*, the same everywhere in a record, and on a *wide* one, which holds more noise and tells inverses
that differentiate from those that only wait.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import ndimage, signal, stats

from it2hys.model import compiled
from it2hys.model.chain import EFFECTS, active_effects
from it2hys.model.compiled import Drive
from it2hys.model.stages import BEFORE_CORE, BEHIND_CORE, READING
from it2hys.model.variables import off_values
from it2hys.policy import REFERENCE

#: Segments that the power density is averaged over, at least.
_SEGMENTS = 8
#: Order of the filter, which is run both ways, so that it has no phase.
_ORDER = 4
#: A core that hands on its input, in V for m.
_WIRE = {
    "ruleCount": 1, "rule[1].centre": 0.0, "rule[1].sigmaLower": 1e9, "rule[1].sigmaUpper": 1e9,
    "rule[1].q1": 0.0, "rule[1].q2": 1.0, "rule[1].q3": 0.0,
}  # fmt: skip
#: Periods of the band's end that a filter needs to settle at either end of a record.
_SETTLING = 2.0


class Part(NamedTuple):
    """What a reference holds of a displacement up to one frequency.

    `band` is in Hz, and `weight`, (N,), how much it counts at each sample.
    """

    band: float
    weight: np.ndarray


@dataclass(frozen=True, eq=False)
class Reference:
    """A measured displacement as an inverse is fed with it.

    Parameters
    ----------
    displacement : ndarray, shape (N,)
        In m, the record's constant included.
    band : float
        Its highest frequency, Hz, but for steps.
    parts : list of Part
        Of which it is mixed, the widest first; their weights add up to 1.
    inside : ndarray of bool, shape (N,)
        Samples at which the filters have settled.
    whole : ndarray of bool, shape (N,)
        Samples at which the displacement is as measured, its noise included.
    """

    displacement: np.ndarray
    band: float
    parts: list[Part]
    inside: np.ndarray
    whole: np.ndarray


@dataclass(frozen=True, eq=False)
class References:
    """The references of a record.

    Parameters
    ----------
    displacement : ndarray, shape (N,)
        As measured, m.
    trusted : ndarray of bool, shape (N,)
    noise : float
        m rms.
    sample_time : float
        s.
    """

    displacement: np.ndarray
    trusted: np.ndarray
    noise: float
    sample_time: float

    @cached_property
    def wide(self) -> Reference:
        """Up to a fifth of the sampling frequency."""
        return self._reference(self._widest, [Part(self._widest, np.ones(len(self.whole)))])

    @cached_property
    def band(self) -> Reference:
        """Up to the highest frequency at which the displacement stands out of the noise."""
        highest, _, _ = self._ends()
        return self._reference(highest, [Part(highest, np.ones(len(self.whole)))])

    @cached_property
    def local(self) -> Reference:
        """Up to the highest frequency at which the displacement stands out of the noise thereabouts."""
        highest, middle, ends = self._ends()
        halvings = np.floor(np.log2(highest / ends))
        count = np.arange(int(halvings.max()) + 1)
        times = np.arange(len(self.whole)) * self.sample_time
        wider = highest * 2.0 ** np.arange(np.ceil(np.log2(self._widest / highest)), 0.0, -1.0)
        parts = [Part(min(band, self._widest), np.zeros(len(times))) for band in wider]
        parts += [
            Part(highest / 2.0**k, np.interp(times, middle, 1.0 * (halvings == k))) for k in count
        ]
        return self._reference(highest, parts)

    @cached_property
    def whole(self) -> np.ndarray:
        """The displacement, straight across samples that are not to be trusted."""
        places = np.flatnonzero(self.trusted)
        return np.interp(np.arange(len(self.displacement)), places, self.displacement[places])

    @property
    def _widest(self) -> float:
        return REFERENCE.widest / self.sample_time

    def _ends(self) -> tuple[float, np.ndarray, np.ndarray]:
        """Return the highest frequency that stands out of the noise, and that of each segment, Hz.

        Between them stand the times of the segments' middles, s, (S,).
        """
        rate, length = 1.0 / self.sample_time, max(16, len(self.whole) // _SEGMENTS)
        frequency, middle, density = signal.spectrogram(
            self.whole, rate, "hann", length, length // 2, detrend="constant"
        )
        density /= max(2.0 * self.noise**2 / rate, np.finfo(float).tiny)
        lowest, above = 4.0 * rate / length, density.mean(axis=1) > REFERENCE.stands_out
        highest = float(np.clip(np.max(frequency[above], initial=0.0), lowest, self._widest))
        # of one segment, the density of noise is a chi squared with two degrees of freedom
        largest = REFERENCE.stands_out + np.log(density.size / REFERENCE.widens)
        ends = np.max(frequency[:, None] * (density > largest), axis=0)
        # what is at the seam of two segments is small in both
        return highest, middle, np.clip(ndimage.maximum_filter1d(ends, 3), lowest, highest)

    def filtered(self, band: float) -> np.ndarray:
        """Return the displacement up to a frequency in Hz, without a phase."""
        low_pass = signal.butter(_ORDER, band, fs=1.0 / self.sample_time, output="sos")
        return signal.sosfiltfilt(low_pass, self.whole)

    def like(self, reference: Reference) -> np.ndarray:
        """Return the displacement as a reference of this record holds it, m, (N,)."""
        filtered = sum(p.weight * self.filtered(p.band) for p in reference.parts if p.weight.any())
        return np.where(reference.whole, self.whole, filtered)

    def _reference(self, band: float, parts: list[Part]) -> Reference:
        """Return the reference of parts, the widest first, each where it takes only noise away."""
        weights, whole = [p.weight for p in parts], np.zeros(len(self.whole), dtype=bool)
        for k in reversed(range(len(parts))):
            if not weights[k].any():
                continue
            # a filter rings before and after a step: play would take that for turning points
            leaves = ndimage.binary_dilation(
                self._leaves(parts[k].band), iterations=self._period(parts[k].band)
            )
            if k == 0:
                whole = leaves & (weights[0] > 0.0)
                break
            moved = weights[k] * ndimage.uniform_filter1d(1.0 * leaves, self._period(parts[k].band))
            weights[k - 1], weights[k] = weights[k - 1] + moved, weights[k] - moved
        parts = [Part(p.band, w) for p, w in zip(parts, weights, strict=True)]
        reference = Reference(self.whole, band, parts, self._settled(parts), whole)
        return replace(reference, displacement=self.like(reference))

    def _leaves(self, band: float) -> np.ndarray:
        """Return where a filter takes more than noise away, (N,) of bool."""
        largest = stats.norm.isf(0.5 * REFERENCE.leaves / len(self.whole))
        return np.abs(self.filtered(band) - self.whole) > largest * self.noise

    def _settled(self, parts: Sequence[Part]) -> np.ndarray:
        """Return where the filters of parts have settled, (N,) of bool."""
        inside = np.ones(len(self.whole), dtype=bool)
        for p in parts:
            edge = int(_SETTLING * self._period(p.band))
            for end in (slice(edge), slice(max(0, len(inside) - edge), None)):
                inside[end] &= p.weight[end] == 0.0
        return inside

    def _period(self, band: float) -> int:
        """Return the period of the end of a band in samples."""
        return int(np.ceil(1.0 / (band * self.sample_time)))


def applied_voltage(values: Mapping, drive: Drive) -> np.ndarray:
    """Return the applied voltage as far as an inverse can know it, V, shape (N,).

    Delay, slew limit and saturation lose what they cut off: the voltage behind them is the one that an
    inverse can ask for, later by the delay. Later, too, by what a stage behind the core delays.
    """
    # the core as a wire: what it answers is not asked for, and without the play it was fitted behind it
    # may diverge
    lossless = [*_made_up_for(), *BEHIND_CORE, *READING]
    start = {"initialDisplacement": drive.voltage[0], "displacementZero": 0.0}
    wire = {**values, **off_values(lossless), **_WIRE, **start}
    applied = compiled.chain_predict(compiled.pack_chain(wire), drive)[1]
    behind = [EFFECTS[e] for e in active_effects(values) if e in BEHIND_CORE]
    ticks = sum(e.latency(values) for e in behind) / values["sampleTime"]
    if not ticks:
        return applied
    count = np.arange(len(applied))
    return np.interp(count - ticks, count, applied)


def _made_up_for() -> list[str]:
    """Return the effects before the core that lose nothing, so that an inverse makes up for them."""
    return [name for name, e in BEFORE_CORE.items() if e.has_inverse and not e.limits]


def ask_inverse(
    values: Mapping, drive: Drive, references: References, name: str = "local", offset: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return the voltage that the inverse asks for, V, and where it cannot follow, both of shape (N,).

    What the model says is picked up is taken off the reference.

    Parameters
    ----------
    values : Mapping
        Parameters of the chain, the start of the record among them.
    drive : Drive
        Of the record.
    references : References
        Of the displacement as measured.
    name : str, optional
        Which of them: "local", "band" or "wide".
    offset : float, optional
        The record's constant, m.
    """
    free, measured = compiled.chain_free_run(values, drive.voltage, drive.force, drive.temperature)
    wanted, picked_up = getattr(references, name).displacement - offset, measured - free
    if np.any(picked_up):
        # as filtered as the reference: of a line beyond its band, nothing is left in it
        wanted = wanted - _in_band(references, name, picked_up)
    return compiled.chain_inverse_run(values, wanted, drive.force, drive.temperature)


def inverse_error(
    values: Mapping, drive: Drive, references: References, name: str = "local", offset: float = 0.0
) -> np.ndarray:
    """Return what the inverse asks for, less the voltage that was applied, V, shape (N,).

    Parameters are those of `ask_inverse`.
    """
    asked, _ = ask_inverse(values, drive, references, name, offset)
    return asked - applied_voltage(values, drive)


def noise_of_inverse(
    values: Mapping, drive: Drive, references: References, name: str = "local"
) -> np.ndarray:
    """Return what noise in a reference makes of the inverse's voltage, V, shape (N,).

    The inverse is fed with the model's own run, and with that and white noise of the record's size, in
    the band of that reference ("local", "band" or "wide").
    """
    free, noise = _own_run(values, drive), _noise(references)
    return _asked_beyond(values, drive, free, free + _in_band(references, name, noise))


def least_inverse_error(
    values: Mapping, drive: Drive, references: References, name: str = "local"
) -> np.ndarray:
    """Return by how much the inverse would miss the voltage of a stage as the model is, V, shape (N,).

    A reference of the model's own run holds noise, and lacks what is beyond the band: neither is a
    fault of the model.
    """
    free, noise = _own_run(values, drive), _noise(references)
    return _asked_beyond(values, drive, free, _in_band(references, name, free + noise))


def _own_run(values: Mapping, drive: Drive) -> np.ndarray:
    return compiled.chain_free_run(values, drive.voltage, drive.force, drive.temperature)[0]


def _noise(references: References) -> np.ndarray:
    count = len(references.displacement)
    return references.noise * np.random.default_rng(0).standard_normal(count)


def _in_band(references: References, name: str, displacement: np.ndarray) -> np.ndarray:
    """Return a displacement as a reference ("local", "band" or "wide") holds it."""
    return replace(references, displacement=displacement).like(getattr(references, name))


def _asked_beyond(values: Mapping, drive: Drive, free: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Return what the inverse asks for beyond what it asks for of the model's own run, V."""
    asked, own = (
        compiled.chain_inverse_run(values, y, drive.force, drive.temperature)[0]
        for y in (reference, free)
    )
    return asked - own
