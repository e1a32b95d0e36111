"""Rate-independent memory in front of the core: play operators, Prandtl-Ishlinskii.

Its signature is a residual whose loop area does not depend on frequency: it is there in the slowest
cycles, where every lag closes; and minor loops within a cycle that remember where the voltage turned.
"""

from collections.abc import Mapping

import numpy as np

from it2hys.diagnosis.evidence.base import EffectEvidence, Signature
from it2hys.diagnosis.evidence.statistics import (
    UM,
    Ground,
    absorbed,
    by_record,
    loop_widths,
    readable,
    walked,
)
from it2hys.model.effects.play import reach, thresholds
from it2hys.model.variables import load_table
from it2hys.records.clues import Clues, Extent
from it2hys.support.numerals import plain

#: Share of its mean that a density has everywhere where operators are placed by it.
_LEAST_DENSITY = 0.05
#: Weights of all operators together that fits begin with: hardly any memory, a weak and a strong one.
_TOTALS = (0.01, 0.1, 0.4)
#: Weight of an operator that a fit may bring in: from exactly 0 it would not stir.
_LIGHT = 1e-3
#: Share by which a finer density has more operators.
_FINER = 0.6
#: How much farther than loops initial curves have to go for operators of their own.
_FARTHER = 1.1


class PlayEvidence(EffectEvidence):
    """A residual that remembers where the voltage turned, however slow or fast it moves."""

    meaning = "memory of the voltage's turning points, with loops that are as wide slow as fast"
    experiment = (
        "slow loops of several amplitudes, each at two frequencies (memory keeps the area of its loops)"
    )

    of_any_loop = True

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return equal weights, for hardly any, a weak and a strong memory."""
        return _with_equal_weights(thresholds(clues.extent))

    def further_guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return the same with operators that only an initial curve engages, where one may be."""
        if not _goes_farther(clues.extent):
            return []
        return _with_equal_weights(thresholds(clues.extent, initial=True))

    def reaching(self, values: Mapping, extent: Extent) -> dict[str, float] | None:
        """Return the values with operators that only an initial curve engages, as light as none."""
        count, most = int(values["playCount"]), load_table().counts["play"]["maximum"]
        half = 0.5 * extent.voltage_span
        beyond = [r for r in thresholds(extent, initial=True).values() if r >= half]
        reaches = values[f"play[{count}].threshold"] >= half
        if reaches or not _goes_farther(extent) or count + len(beyond) > most:
            return None
        added = {"playCount": count + len(beyond)}
        for j, threshold in enumerate(beyond, start=count + 1):
            added |= {f"play[{j}].threshold": threshold, f"play[{j}].weight": _LIGHT}
        return added

    def extended(self, values: Mapping, extent: Extent) -> list[dict[str, float]]:
        """Return more operators, up to all there may be, close where the density found is great.

        A curve of straight pieces comes nearest to one of curvature d if the pieces are as d^(-1/3).
        The last operator stands for all up to where none engages: half the voltage's span in loops.
        """
        count, most = int(values["playCount"]), load_table().counts["play"]["maximum"]
        ends = np.array([0.0, *(values[f"play[{j}].threshold"] for j in range(1, count + 1))])
        found = np.array([0.0, *(values[f"play[{j}].weight"] for j in range(1, count + 1))])
        if count >= most or found.sum() <= 0.0:
            return []
        half = 0.5 * extent.voltage_span
        ends[-1] = half if ends[-1] < half else reach(extent)
        if np.any(np.diff(ends) <= 0.0):
            return []
        more = min(count + max(1, int(_FINER * count)), most)
        density = found[1:] / np.diff(ends)
        pieces = np.cbrt(density + _LEAST_DENSITY * np.mean(density)) * np.diff(ends)
        passed = np.concatenate([[0.0], np.cumsum(pieces)])
        finer = np.interp(np.arange(1, more + 1) / (more + 1) * passed[-1], passed, ends)
        # each has the weight up to it, the last one that beyond it, too
        total = np.cumsum(found)
        sums = np.interp(finer, ends, total)
        sums[-1] = total[-1]
        weights = np.maximum(np.diff(sums, prepend=0.0), 0.0)  # rounding may leave them below
        operators = {f"play[{j}].threshold": float(r) for j, r in enumerate(finer, start=1)}
        operators |= {f"play[{j}].weight": float(w) for j, w in enumerate(weights, start=1)}
        return [{"playCount": more, **operators}]

    def scaled(self, values: Mapping, extent: Extent, factor: float) -> dict[str, float]:
        """Return all thresholds at a multiple of what they are, up to half the span, as in loops."""
        count = int(values["playCount"])
        if factor > 1.0 and factor * values[f"play[{count}].threshold"] > 0.5 * extent.voltage_span:
            return {}
        names = [f"play[{j}].threshold" for j in range(1, count + 1)]
        return {name: factor * values[name] for name in names}

    def signature(self, clues: Clues) -> Signature | None:
        """Return whether the residual remembers where the voltage turned, however slowly it moves.

        The residual is regressed on the outputs of three play operators, which know no time, once the
        model's own means are taken out; errors are spectral and by blocks (HAC). The statistic is the
        share of the residual's power that they explain. Loops are told of the slowest cycles: in fast
        ones the model, fitted without play, has made up for them.
        """
        seen = readable(clues)
        if seen is None or clues.extent.voltage_span <= 0.0:
            return None
        thresholds = np.array([0.04, 0.12, 0.25]) * clues.extent.voltage_span
        start = np.array(
            [np.clip(0.0, c.voltage[0] - thresholds, c.voltage[0] + thresholds) for c in seen.records]
        )
        outputs = walked(seen, start, lambda y, x: np.clip(y, x - thresholds, x + thresholds))
        trial = Ground(seen, [absorbed(seen)]).test(by_record(seen, outputs))
        frequency, width = loop_widths(seen)
        text = f"Play of the voltage explains {100 * trial.share:.0f} % of the residual's power"
        if len(width) >= 4:
            slow = frequency <= np.quantile(frequency, 0.25)
            text += (
                f"; in the slowest cycles (up to {plain(float(np.max(frequency[slow])))} Hz), "
                "where lags close, the "
                f"residual's loops over the voltage are {np.median(width[slow]) * UM:.2g} µm wide"
            )
        return Signature(trial.share, trial.p_value, text + ".")


def _goes_farther(extent: Extent) -> bool:
    """Return whether initial curves from 0 V go farther than loops, so that it shows."""
    return reach(extent) >= _FARTHER * 0.5 * extent.voltage_span


def _with_equal_weights(held: Mapping[str, float]) -> list[dict[str, float]]:
    names = [f"play[{j}].weight" for j in range(1, len(held) + 1)]
    return [
        {"playCount": len(held), **held, **dict.fromkeys(names, total / len(held))} for total in _TOTALS
    ]


EVIDENCE = PlayEvidence()
