"""The inverse on measured data: which voltage it asks for when fed with the measured displacement.

The voltage that was applied is the answer. Without the rig, their difference says how well feedforward
will track. Two references are made of a record: its *band*, up to the highest frequency at which the
displacement stands out of the noise, which is what a user's reference may contain; and a *wide* one,
which holds more noise and tells inverses that differentiate from those that only wait.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

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


@dataclass(frozen=True, eq=False)
class Reference:
    """A measured displacement as an inverse is fed with it.

    Parameters
    ----------
    displacement : ndarray, shape (N,)
        In m, the record's constant included.
    band : float
        Its highest frequency, Hz.
    inside : ndarray of bool, shape (N,)
        Samples at which the filter has settled.
    whole : ndarray of bool, shape (N,)
        Samples at which the displacement is as measured, its noise included.
    """

    displacement: np.ndarray
    band: float
    inside: np.ndarray
    whole: np.ndarray


@dataclass(frozen=True, eq=False)
class References:
    """Both references of a record.

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
        return self._up_to(REFERENCE.widest / self.sample_time)

    @cached_property
    def band(self) -> Reference:
        """Up to the highest frequency at which the displacement stands out of the noise."""
        return self._up_to(self._highest())

    @cached_property
    def whole(self) -> np.ndarray:
        """The displacement, straight across samples that are not to be trusted."""
        places = np.flatnonzero(self.trusted)
        return np.interp(np.arange(len(self.displacement)), places, self.displacement[places])

    def _highest(self) -> float:
        rate = 1.0 / self.sample_time
        length = max(16, len(self.whole) // _SEGMENTS)
        frequency, density = signal.welch(self.whole, rate, nperseg=length)
        floor = max(2.0 * self.noise**2 / rate, np.finfo(float).tiny)
        above = frequency[density > REFERENCE.stands_out * floor]
        return float(np.clip(np.max(above, initial=0.0), 4.0 * rate / length, REFERENCE.widest * rate))

    def filtered(self, band: float) -> np.ndarray:
        """Return the displacement up to a frequency in Hz, without a phase."""
        low_pass = signal.butter(_ORDER, band, fs=1.0 / self.sample_time, output="sos")
        return signal.sosfiltfilt(low_pass, self.whole)

    def _up_to(self, band: float) -> Reference:
        filtered = self.filtered(band)
        # a filter rings before and after a step: play would take that for turning points
        period = int(np.ceil(1.0 / (band * self.sample_time)))
        largest = stats.norm.isf(0.5 * REFERENCE.leaves / len(filtered))
        leaves = np.abs(filtered - self.whole) > largest * self.noise
        leaves = ndimage.binary_dilation(leaves, iterations=period)
        edge = int(_SETTLING * period)
        inside = np.ones(len(filtered), dtype=bool)
        inside[:edge] = inside[max(0, len(filtered) - edge) :] = False
        return Reference(np.where(leaves, self.whole, filtered), band, inside, leaves)


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
    values: Mapping, drive: Drive, displacement: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the voltage that the inverse asks for, V, and where it cannot follow, both of shape (N,).

    Parameters
    ----------
    values : Mapping
        Parameters of the chain, the start of the record among them.
    drive : Drive
        Of the record.
    displacement : ndarray, shape (N,)
        As measured, without the record's constant, m. What the model says is picked up is
        taken off.
    """
    free, measured = compiled.chain_free_run(values, drive.voltage, drive.force, drive.temperature)
    return compiled.chain_inverse_run(
        values, displacement - (measured - free), drive.force, drive.temperature
    )


def inverse_error(values: Mapping, drive: Drive, displacement: np.ndarray) -> np.ndarray:
    """Return what the inverse asks for, less the voltage that was applied, V, shape (N,).

    Parameters are those of `ask_inverse`.
    """
    return ask_inverse(values, drive, displacement)[0] - applied_voltage(values, drive)


def noise_of_inverse(
    values: Mapping, drive: Drive, references: References, name: str = "band"
) -> np.ndarray:
    """Return what noise in a reference makes of the inverse's voltage, V, shape (N,).

    The inverse is fed with the model's own run, and with that and white noise of the record's size, in
    the band of that reference ("band" or "wide").
    """
    free, noise = _own_run(values, drive), _noise(references)
    return _asked_beyond(values, drive, free, free + _in_band(references, name, noise))


def least_inverse_error(
    values: Mapping, drive: Drive, references: References, name: str = "band"
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
    """Return a displacement as a reference ("band" or "wide") holds it."""
    reference = getattr(references, name)
    filtered = replace(references, displacement=displacement).filtered(reference.band)
    return np.where(reference.whole, displacement, filtered)


def _asked_beyond(values: Mapping, drive: Drive, free: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Return what the inverse asks for beyond what it asks for of the model's own run, V."""
    asked, own = (
        compiled.chain_inverse_run(values, y, drive.force, drive.temperature)[0]
        for y in (reference, free)
    )
    return asked - own
