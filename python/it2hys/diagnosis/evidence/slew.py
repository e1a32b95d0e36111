"""Slew limit of the amplifier.

Its signature is a residual that is confined to spells in which |du/dt| was above one level, grows while
they last and, in large signals of high frequency only, turns sines into triangles.
"""

from collections.abc import Mapping

import numpy as np

from it2hys.diagnosis.evidence.base import EffectEvidence, Signature
from it2hys.diagnosis.evidence.statistics import (
    UM,
    Ground,
    absorbed,
    by_record,
    readable,
    rms,
    walked,
)
from it2hys.model.effects.slew import EFFECT
from it2hys.records.clues import Clues
from it2hys.support.numerals import plain

#: Share of all changes of the voltage that pass limits which hold back what is fast.
_FEW = 0.3
#: Lowest limit that is tried, by the mean change of the voltage: less lets hardly any swing through.
_PASSED = 0.3
#: Limits below all of these changes that are tried for a signature.
_SLOWER = 4


class SlewEvidence(EffectEvidence):
    """A residual that is confined to spells in which the voltage changed too fast."""

    meaning = "the amplifier's voltage cannot change faster than at a certain rate"
    experiment = (
        "sines of one frequency and rising amplitude (beyond a slew limit they turn into triangles)"
    )

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return rates below those that the voltages ask for."""
        rates, sample_time = _changes(clues), clues.extent.sample_time
        fastest = EFFECT.starts(clues.extent)["slew.rate"].high
        highest = min(rates.max() / sample_time, fastest)
        return [{"slew.rate": r} for r in np.geomspace(_least(clues) / sample_time, highest, 24)[:-1]]

    def is_done_within(self, values: Mapping, time: float) -> bool:
        """Return whether steps of the whole range take no more than two such times."""
        return 2.0 * values["slew.rate"] * time > values["voltageMax"] - values["voltageMin"]

    def signature(self, clues: Clues) -> Signature | None:
        """Return whether the residual is confined to spells in which the voltage changed too fast.

        The residual is regressed on what limits at several rates cut off the voltage, once the model's
        own means are taken out; errors are spectral and by blocks (HAC), the p-value is corrected for
        the number of rates. The statistic is the share of the residual's power that the best explains.
        """
        seen = readable(clues)
        rates = _changes(clues)
        if seen is None or len(np.unique(rates)) < 2:
            return None
        slower = np.geomspace(_least(clues), np.quantile(rates, _FEW), _SLOWER, endpoint=False)
        levels = np.unique([*slower, *np.quantile(rates, np.linspace(_FEW, 0.99, 14))])
        start = np.array([np.full(len(levels), c.voltage[0]) for c in seen.records])
        limited = walked(seen, start, lambda y, x: y + np.clip(x - y, -levels, levels))
        cut = [y - c.voltage[:, None] for y, c in zip(limited, seen.records, strict=True)]
        bank = [by_record(seen, [x[:, j] for x in cut]) for j in range(len(levels))]
        chosen, trial = Ground(seen, [absorbed(seen)]).best(bank, positive=True)
        spell = [np.abs(x[:, chosen]) > 1e-6 * clues.extent.voltage_span for x in cut]
        inside, outside = (
            rms(
                np.concatenate(
                    [c.residual[c.used & (s == side)] for c, s in zip(seen.records, spell, strict=True)]
                )
            )
            for side in (True, False)
        )
        text = (
            "The residual is concentrated where a slew limit of "
            f"{plain(levels[chosen] / clues.extent.sample_time)} V/s would hold the voltage back: "
            f"{inside * UM:.2g} µm rms there, {outside * UM:.2g} µm elsewhere."
        )
        return Signature(trial.share, trial.p_value, text)


def _changes(clues: Clues) -> np.ndarray:
    """Return by how much the voltages change from sample to sample, where they do, V."""
    changes = np.concatenate([np.abs(np.diff(c.voltage)) for c in clues.records])
    return changes[changes > 1e-9 * clues.extent.voltage_span]


def _least(clues: Clues) -> float:
    """Return the lowest limit that records may show, V a sample.

    A limit may be below all changes: where the voltage is held between its steps, the displacement then
    takes several samples to follow each. Samples at which it is held count in the mean.
    """
    samples = sum(len(c.voltage) for c in clues.records)
    mean = float(np.sum(_changes(clues))) / samples
    return min(_PASSED * mean, float(np.quantile(_changes(clues), _FEW)))


EVIDENCE = SlewEvidence()
