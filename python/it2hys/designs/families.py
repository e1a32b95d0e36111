"""Families of voltages that a rig can play, each with a few shape parameters.

A shape parameter is between 0 and 1; a family turns a point of them into a period of voltage that keeps
the limits, from rest to rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import signal

from it2hys.designs.limits import Limits
from it2hys.support.numerals import plain

#: Shares of a period that a part of a combination has at least, beside an equal share of the rest.
_LEAST_PART = 0.15
#: Golden ratio, whose multiples spread evenly whatever their number.
_GOLDEN = 0.6180339887498949
_MOST_TONES = 32
#: A voltage that the limits change by more than this share of the range, rms, is described so.
_NOTICED, _CUT = 0.02, ", cut to the limits"


@dataclass(frozen=True)
class Family:
    """One kind of voltage.

    Parameters
    ----------
    name : str
    size : int
        Number of shape parameters.
    shape : callable
        Takes point, (size,), samples and limits, and returns a voltage in V that need not keep them.
    words : callable
        Takes the same, and returns what is played, in the rig's units.
    """

    name: str
    size: int
    shape: Callable[[np.ndarray, int, Limits], np.ndarray]
    words: Callable[[np.ndarray, int, Limits], str]

    def period(self, point: np.ndarray, limits: Limits) -> np.ndarray:
        """Return a period of voltage, (limits.samples,), within the limits."""
        return limits.kept(self.shape(np.clip(point, 0.0, 1.0), limits.samples, limits))

    def voltage(self, point: np.ndarray, limits: Limits) -> np.ndarray:
        """Return all periods, V."""
        return np.tile(self.period(point, limits), limits.periods)

    def described(self, point: np.ndarray, limits: Limits) -> str:
        """Return what is played, in words and the rig's units."""
        return self.said(np.clip(point, 0.0, 1.0), limits.samples, limits)

    def said(self, point: np.ndarray, samples: int, limits: Limits) -> str:
        """Return what is played in so many samples, and whether the limits leave less of it."""
        wanted = self.shape(point, samples, limits)
        off = np.sqrt(np.mean((limits.kept(wanted) - wanted) ** 2))
        return self.words(point, samples, limits) + (_CUT if off > _NOTICED * limits.span else "")


def _frequency(share: float, samples: int, limits: Limits) -> float:
    """Return the frequency at a share of the band's decades, at least one cycle in the samples, Hz."""
    low = min(max(limits.lowest, 1.0 / (samples * limits.sample_time)), limits.highest)
    return float(low * (limits.highest / low) ** share)


def _ends(amplitude: float, centre: float, limits: Limits) -> tuple[float, float]:
    """Return the ends, V, of a swing of 0.4 to 1 of the range, the rest of which is above or below."""
    share = 0.4 + 0.6 * amplitude
    low = limits.low + (1.0 - share) * centre * limits.span
    return low, low + share * limits.span


def _onto(unit: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """Map a signal onto a range, its least and greatest values onto the ends."""
    least, most = unit.min(), unit.max()
    share = (unit - least) / (most - least) if most > least else np.zeros_like(unit)
    return ends[0] + share * (ends[1] - ends[0])


def _tones(point: np.ndarray, samples: int, limits: Limits) -> np.ndarray:
    """Return the frequencies of a multisine, Hz, whole numbers of cycles each."""
    first, last = np.sort(
        [_frequency(point[0], samples, limits), _frequency(point[1], samples, limits)]
    )
    count = 3 + round(point[2] * (_MOST_TONES - 3))
    unit = 1.0 / (samples * limits.sample_time)
    cycles = np.unique(np.maximum(1, np.round(np.geomspace(first, last, count) / unit)))
    kept = cycles[cycles * unit <= limits.highest * (1.0 + 1e-12)]
    return unit * (kept if len(kept) else cycles[:1])


def _multisine(point: np.ndarray, samples: int, limits: Limits) -> np.ndarray:
    """Return sines whose amplitudes fall with the frequency, and whose phases bend as a sweep's."""
    tones = _tones(point, samples, limits)
    number = np.arange(1, len(tones) + 1)
    amplitudes = (tones / tones[0]) ** (-1.5 * point[3])
    phases = (
        -np.pi * 2.0 * point[4] * number**2 / len(tones) + 2.0 * np.pi * _GOLDEN * number * point[5]
    )
    time = np.arange(samples) * limits.sample_time
    total = amplitudes @ np.sin(2.0 * np.pi * tones[:, None] * time + phases[:, None])
    return _onto(total, _ends(point[6], point[7], limits))


def _multisine_words(point: np.ndarray, samples: int, limits: Limits) -> str:
    tones, (low, high) = _tones(point, samples, limits), _ends(point[6], point[7], limits)
    return (
        f"a multisine of {len(tones)} tones, {tones[0]:.3g} to {plain(tones[-1])} Hz, over "
        f"{low:.3g} to {high:.3g} V"
    )


def _chirp(point: np.ndarray, samples: int, limits: Limits) -> np.ndarray:
    """Return a swept sine, up or down, whose swings grow or shrink."""
    time = np.arange(samples) * limits.sample_time
    first, last = _frequency(point[0], samples, limits), _frequency(point[1], samples, limits)
    method = "linear" if point[2] < 0.5 or first == last else "logarithmic"
    sweep = signal.chirp(time, first, time[-1], last, method=method, phi=180.0)
    envelope = 1.0 + (point[3] - 0.5) * np.linspace(-1.0, 1.0, samples)
    return _onto(envelope * sweep, _ends(point[4], point[5], limits))


def _chirp_words(point: np.ndarray, samples: int, limits: Limits) -> str:
    first, last = _frequency(point[0], samples, limits), _frequency(point[1], samples, limits)
    low, high = _ends(point[4], point[5], limits)
    return f"a chirp from {plain(first)} to {plain(last)} Hz over {low:.3g} to {high:.3g} V"


def _holds(point: np.ndarray, samples: int, limits: Limits) -> np.ndarray:
    """Return how many samples each level is held for: from short to long ones, again and again."""
    cycle = samples * limits.sample_time
    shortest, longest = 0.5 / limits.highest, min(0.5 / limits.lowest, 0.4 * cycle)
    longest = max(longest, shortest)
    ends = np.sort([shortest * (longest / shortest) ** share for share in point[:2]])
    holds: list[int] = []
    while sum(holds) < samples:
        share = (len(holds) * _GOLDEN) % 1.0
        holds.append(max(1, round(ends[0] * (ends[1] / ends[0]) ** share / limits.sample_time)))
    return np.array(holds)


def _steps(point: np.ndarray, samples: int, limits: Limits) -> np.ndarray:
    """Return held steps to levels that spread evenly over the range, between sometimes small ones."""
    holds = _holds(point, samples, limits)
    places = (point[2] + (1 + np.arange(len(holds))) * (0.25 + 0.5 * point[3])) % 1.0
    # from levels of the whole range towards two levels that take turns
    places = (1.0 - point[4]) * places + point[4] * (np.arange(len(holds)) % 2)
    return limits.low + limits.span * np.repeat(places, holds)[:samples]


def _steps_words(point: np.ndarray, samples: int, limits: Limits) -> str:
    holds = limits.sample_time * _holds(point, samples, limits)
    return (
        f"{len(holds)} held steps within {limits.low:.3g} to {limits.high:.3g} V, held for "
        f"{1e3 * holds.min():.3g} to {1e3 * holds.max():.3g} ms"
    )


def _reversals(point: np.ndarray, samples: int, limits: Limits) -> np.ndarray:
    """Return triangles of falling amplitude, their frequency from one value to another."""
    first, last = _frequency(point[0], samples, limits), _frequency(point[1], samples, limits)
    frequency = np.geomspace(first, last, samples)
    phase = np.cumsum(frequency) * limits.sample_time
    wave = signal.sawtooth(2.0 * np.pi * phase, width=0.5)
    amplitude = np.geomspace(1.0, 0.05 + 0.95 * point[2], samples)
    centre = 0.3 + 0.4 * point[3]
    # each turning point within the range, about a centre that the amplitude falls to
    low, high = centre * (1.0 - amplitude), centre + (1.0 - centre) * amplitude
    return limits.low + limits.span * (low + 0.5 * (1.0 + wave) * (high - low))


def _reversals_words(point: np.ndarray, samples: int, limits: Limits) -> str:
    first, last = _frequency(point[0], samples, limits), _frequency(point[1], samples, limits)
    greatest, least = (f"{share * limits.span:.3g}" for share in (1.0, 0.05 + 0.95 * point[2]))
    falling = f"of falling amplitude, {greatest} to {least} V" if least != greatest else f"of {least} V"
    return f"reversals {falling}, at {plain(first)} to {plain(last)} Hz"


_MULTISINE = Family("multisine", 8, _multisine, _multisine_words)
_CHIRP = Family("chirp", 6, _chirp, _chirp_words)
_STEPS = Family("steps", 5, _steps, _steps_words)
_REVERSALS = Family("reversals", 4, _reversals, _reversals_words)


def _combined(name: str, parts: tuple[Family, ...]) -> Family:
    """Return the family whose voltages are those of others, one after the other, each from rest."""
    sizes = np.cumsum([0, *(p.size for p in parts)])

    def lengths(point: np.ndarray, samples: int) -> list[int]:
        free = 1.0 - _LEAST_PART * len(parts)
        shares = _LEAST_PART + free * (point[sizes[-1] :] + 0.1) / np.sum(point[sizes[-1] :] + 0.1)
        ends = np.round(np.cumsum([0.0, *shares]) * samples).astype(int)
        return np.diff(ends).tolist()

    def pieces(point: np.ndarray, samples: int) -> list[tuple[Family, np.ndarray, int]]:
        counts = lengths(point, samples)
        return [
            (part, point[a:b], count)
            for part, a, b, count in zip(parts, sizes, sizes[1:], counts, strict=False)
        ]

    def shape(point: np.ndarray, samples: int, limits: Limits) -> np.ndarray:
        return np.concatenate(
            [limits.kept(part.shape(own, n, limits)) for part, own, n in pieces(point, samples)]
        )

    def words(point: np.ndarray, samples: int, limits: Limits) -> str:
        said = [
            f"for {limits.sample_time * n:.3g} s {part.said(own, n, limits)}"
            for part, own, n in pieces(point, samples)
        ]
        return ", then ".join(said)

    return Family(name, int(sizes[-1]) + len(parts), shape, words)


#: Families by name.
FAMILIES: dict[str, Family] = {
    family.name: family
    for family in (
        _MULTISINE,
        _CHIRP,
        _STEPS,
        _REVERSALS,
        _combined("steps and multisine", (_STEPS, _MULTISINE)),
        _combined("steps and reversals", (_STEPS, _REVERSALS)),
        _combined("steps, reversals and multisine", (_STEPS, _REVERSALS, _MULTISINE)),
    )
}
