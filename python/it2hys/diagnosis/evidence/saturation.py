"""Saturation of the amplifier.

Its signature is a residual that is confined to |u| beyond one level, where the displacement no longer
answers to the voltage at all; the tops of large cycles are flat.
"""

from collections.abc import Callable

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from it2hys.diagnosis.evidence.base import EffectEvidence, Signature
from it2hys.diagnosis.evidence.statistics import (
    UM,
    Columns,
    Ground,
    lagged,
    modelled,
    readable,
    rms,
    scaled,
)
from it2hys.model.effects.saturation import EFFECT
from it2hys.records.clues import Clue, Clues

#: Degree of the curve that a fit of the rules can bend to, and levels and their combinations tried.
_SMOOTH, _TRIED = 5, 49

#: Lags, in ticks, with which the core may answer.
_QUICKNESS = (0.1, 5.0, 15.0)


class SaturationEvidence(EffectEvidence):
    """A residual that is confined to voltages beyond a level."""

    meaning = "the amplifier's voltage stops at a limit"
    experiment = "slow sines of rising amplitude (beyond a limit the displacement stays where it is)"

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return limits at the upper end, at the lower end and at both."""
        low, high = clues.extent.voltage
        span, bounds = high - low, EFFECT.starts(clues.extent)
        none = bounds["saturation.minimum"].low, bounds["saturation.maximum"].high
        shares = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4)
        limits = [(none[0], high - s * span) for s in shares]
        limits += [(low + s * span, none[1]) for s in shares]
        limits += [(low + s * span, high - t * span) for s in shares[1::2] for t in shares[1::2]]
        return [{"saturation.minimum": a, "saturation.maximum": b} for a, b in limits]

    def signature(self, clues: Clues) -> Signature | None:
        """Return whether the residual is confined to voltages beyond levels, where it falls behind.

        The residual is regressed on what lies beyond a level, the best of several at the upper end, at
        the lower end and at both, once what a smooth curve of the displacement can do is taken out;
        errors are spectral and by blocks (HAC), the p-value is corrected for the number of levels. The
        statistic is the share of the residual's power that is explained, less what is linear in the
        displacement.
        """
        seen, span = readable(clues), clues.extent.voltage_span
        if seen is None or span <= 0.0:
            return None
        low, high = clues.extent.voltage
        shares = np.array((0.03, 0.05, 0.08, 0.11, 0.14, 0.18, 0.22, 0.28))
        ground = Ground(
            seen, [lambda c: chebvander(np.clip(scaled(clues, c), -1.2, 1.2), _SMOOTH)[:, 1:]]
        )
        limits = (
            [(np.minimum, v) for v in high - shares * span],
            [(np.maximum, v) for v in low + shares * span],
        )
        # the core answers to what is missing as quickly or slowly as to anything else
        ends = [[_missing(*limit, t) for t in _QUICKNESS for limit in end] for end in limits]
        chosen = [ground.best(bank, positive=True)[0] for bank in ends]
        upper, lower = (bank[i] for bank, i in zip(ends, chosen, strict=True))
        tried = {
            "upper": upper,
            "lower": lower,
            "both": lambda c: np.column_stack([upper(c), lower(c)]),
        }
        trials = {end: ground.test(columns) for end, columns in tried.items()}
        # a negative coefficient: the displacement would run ahead of the voltage
        trials = {end: t for end, t in trials.items() if np.all(t.coefficients >= 0.0)}
        if not trials:
            return Signature(
                0.0, 1.0, "The displacement falls behind the model at neither end of the voltage range."
            )
        end, trial = min(trials.items(), key=lambda item: (item[1].p_value, -item[1].share))
        share = Ground(seen, [modelled]).test(tried[end]).share
        levels = [float(end[i % len(shares)][1]) for end, i in zip(limits, chosen, strict=True)]
        beyond = [_beyond(c, end, *levels) for c in seen.records]
        inside, outside = (
            rms(
                np.concatenate(
                    [
                        c.residual[c.used & (b == side)]
                        for c, b in zip(seen.records, beyond, strict=True)
                    ]
                )
            )
            for side in (True, False)
        )
        names = {"upper": f"above {levels[0]:.3g} V", "lower": f"below {levels[1]:.3g} V"}
        place = names.get(end, " and ".join(names.values()))
        text = (
            f"The displacement falls behind the model {place}, more as the voltage goes further: "
            f"residual {inside * UM:.2g} µm rms there, {outside * UM:.2g} µm elsewhere."
        )
        return Signature(share, min(1.0, _TRIED * trial.p_value), text)


def _missing(limit: Callable, level: float, ticks: float) -> Columns:
    """Return what a limit takes from the voltage, after a lag; columns by record."""
    return lambda c: lagged(limit(level - c.voltage, 0.0), ticks)


def _beyond(clue: Clue, end: str, upper: float, lower: float) -> np.ndarray:
    """Return which samples lie beyond a level, (N,)."""
    above, below = clue.voltage > upper, clue.voltage < lower
    return {"upper": above, "lower": below, "both": above | below}[end]


EVIDENCE = SaturationEvidence()
