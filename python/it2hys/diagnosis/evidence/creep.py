"""Creep: first-order terms, driven by the displacement above the sensor's zero and added to it.

Its signature is a residual that, after a step, grows with the logarithm of the time held, and slow
cycles whose loops are wider than fast ones'. A drift with time grows without any step.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import lsq_linear

from it2hys.diagnosis.evidence.base import EffectEvidence, Signature
from it2hys.diagnosis.evidence.statistics import (
    Ground,
    absorbed,
    after_steps,
    lagged,
    modelled,
    readable,
)
from it2hys.model.effects.creep import COUNT, EFFECT
from it2hys.model.variables import load_table
from it2hys.policy import PHYSICS, STARTS
from it2hys.records import Record
from it2hys.records.clues import Clues, Extent

#: Terms in each decade of creep that is as large in all, and durations of the records at which it ends.
_A_DECADE, _BEHIND = 2, 10.0


class CreepEvidence(EffectEvidence):
    """A residual that goes on after the displacement has moved, over decades of time."""

    meaning = "the stage goes on moving when the voltage has stopped"
    experiment = "steps held over several decades of time (creep goes on with the logarithm of time)"

    of_a_controller = True

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return no, small and large gains at time constants spread over the records' decades."""
        values = EFFECT.starts(clues.extent, COUNT)
        constants = {name: start.value for name, start in values.items() if "timeConstant" in name}
        gains = [name for name in values if "gain" in name]
        return [
            {"creepCount": COUNT, **constants, **dict.fromkeys(gains, total / COUNT)}
            for total in (1e-3, 0.02, 0.1)
        ]

    def gain_at_rest(self, values: Mapping) -> float:
        """Return the sum of the gains."""
        return sum(_terms(values)[0])

    def extended(self, values: Mapping, extent: Extent) -> list[dict[str, float]]:
        """Return one term more: slower than the others if the records allow, or all spread anew.

        Between terms that too few of them have drawn apart, one more does not find its place.
        """
        count = int(values["creepCount"])
        if count >= load_table().counts["creep"]["maximum"]:
            return []
        gains, constants = _terms(values)
        slower = [*constants, min(3.0 * max(constants), extent.duration)]
        spread = np.geomspace(_fastest(constants, extent), max(constants), count + 1)
        return [
            _of_terms([*gains, 1e-3], slower),
            _of_terms([sum(gains) / (count + 1)] * (count + 1), [float(t) for t in spread]),
        ]

    def signature(self, clues: Clues) -> Signature | None:
        """Return whether the residual goes on after the displacement has moved, over decades of time.

        The residual is regressed on slow lags of the model's reading, three over the decades that the
        records see, once the model's own means are taken out; errors are spectral and by blocks (HAC).
        The statistic is the share of the residual's power that they explain. The text gives the growth
        by decade of hold time.
        """
        seen = readable(clues)
        duration = clues.extent.duration / clues.extent.sample_time
        if seen is None or duration < 1000:
            return None
        ticks = np.geomspace(20.0, duration, 6)[::2]
        trial = Ground(seen, [absorbed(seen)]).test(
            lambda c: np.column_stack([lagged(modelled(c), t) for t in ticks])
        )
        slope = after_steps(seen)
        text = (
            f"Slow responses to the displacement explain {100 * trial.share:.0f} % of the "
            "residual's power"
        )
        if slope is not None:
            text += (
                f"; after a step it goes on by {100 * slope:.2g} % of the step per decade of the "
                "time held"
            )
        return Signature(trial.share, trial.p_value, text + ".")

    def not_shown(self, values: Mapping, fitted: Sequence[Record], deciding: Sequence[Record]) -> str:
        """Return a sentence where all records that were fitted begin at one voltage.

        What is slower than they are is then the same in all of them.
        """
        begins = np.array([r.voltage[0] for r in fitted])
        span = max(r.voltage.max() for r in fitted) - min(r.voltage.min() for r in fitted)
        if np.ptp(begins) > STARTS.slack * span:
            return ""
        longest = max(r.time[-1] - r.time[0] for r in fitted)
        travel = max(np.ptp(r.displacement) for r in fitted)
        elsewhere = [r for r in deciding if abs(r.voltage[0] - begins.mean()) > STARTS.slack * span]
        ask = "A record that begins after a rest at another voltage would show it."
        if elsewhere:
            ask = (
                f"Record '{elsewhere[0].name}', which was not fitted, begins at "
                f"{elsewhere[0].voltage[0]:.3g} V: as a training record it may show more of it."
            )
        gains, constants = (np.array(terms) for terms in _terms(values))
        further = gains[np.isclose(constants, PHYSICS.goes_on * longest, rtol=0.01)]  # see `going_on`
        growth = np.sum(further) if len(further) else _growth(values, 0.1 * longest, longest)
        size = (
            f"by {100 * growth:.2g} % of the way from there for every decade of time, up to "
            f"{1e6 * growth * travel:.2g} µm"
        )
        if max(constants) > 2.0 * longest:
            told = f"The model takes it to go on as creep does, {size}."
        else:
            told = (
                "After a rest at another voltage the model may miss it: if creep goes on as at their "
                f"end, {size}."
            )
        return (
            f"All records that were fitted begin at {begins.mean():.3g} V. They do not show how much "
            f"creep there is that takes longer than the longest of them ({longest:.3g} s). {told} {ask}"
        )

    def going_on(
        self, values: Mapping, extent: Extent, share: float = 1.0
    ) -> tuple[dict[str, float], list[str]] | None:
        """Return the values with a last term as large as the creep over the last decade of the records.

        Or as a share of that. Creep goes on with the logarithm of time. The term is slower than the
        records, stands for all that are as slow, and the others are less by what it takes up of a step
        within the records.
        """
        gains, constants = (np.array(terms) for terms in _terms(values))
        longest = extent.duration
        far = PHYSICS.goes_on * longest
        slow = constants > 0.5 * (longest + far)
        kept, others = constants[~slow], gains[~slow]
        if not len(kept) or len(kept) == load_table().counts["creep"]["maximum"]:
            return None
        growth = share * min(_growth(values, 0.1 * longest, longest), PHYSICS.slow_gain)
        time = np.geomspace(1e-3 * longest, longest, 60)[:, None]
        # what is there at once is the core's
        taken = np.hstack([np.ones_like(time), _grown(time, kept)])
        more = growth * _grown(time, far)[:, 0] - _grown(time, constants[slow]) @ gains[slow]
        # terms that are as slow as each other could otherwise change by any amount, and back
        most = np.append(np.inf, np.maximum(others, np.finfo(float).tiny))
        least = np.append(-np.inf, np.full_like(others, -np.sum(gains[slow])))
        less = lsq_linear(taken, more, (least, most)).x[1:]
        terms = _of_terms([*np.maximum(others - less, 0.0).tolist(), growth], [*kept.tolist(), far])
        last = int(terms["creepCount"])
        return _with_terms(values, terms), [f"creep[{last}].gain", f"creep[{last}].timeConstant"]

    def even(self, values: Mapping, extent: Extent) -> tuple[dict[str, float], list[str]] | None:
        """Return the values of terms that creep as much within every decade, to behind the records."""
        _, constants = _terms(values)
        fastest, longest = _fastest(constants, extent), extent.duration
        decades = float(np.log10(_BEHIND * longest / fastest))
        count = min(round(_A_DECADE * decades) + 1, load_table().counts["creep"]["maximum"])
        growth = _growth(values, fastest, longest) / np.log10(longest / fastest)
        spread = np.geomspace(fastest, _BEHIND * longest, count)
        terms = _of_terms([growth * decades / count] * count, spread.tolist())
        return _with_terms(values, terms), [name for name in terms if name.endswith("timeConstant")]

    def beyond(self, values: Mapping) -> str:
        """Return that it grows by more than a stage's does within a decade of time, if so.

        Each term has its bound, but several with one time constant make a larger one.
        """
        _, constants = _terms(values)
        times = np.geomspace(0.1 * min(constants), max(constants), 100)
        most = max(_growth(values, time, 10.0 * time) for time in times)
        if most <= PHYSICS.slow_gain:
            return ""
        return (
            f"it would be {100 * most:.0f} % of a step within a decade of time, more than the "
            f"{100 * PHYSICS.slow_gain:.0f} % that are taken as possible: makers state up to 5 %"
        )

    def unshown(self, values: Mapping, time: np.ndarray) -> list[np.ndarray]:
        """Return a constant, and what the slowest term forgets: it stands for those that are slower."""
        _, constants = _terms(values)
        return [np.ones_like(time), np.exp(-time / max(constants))]


def _fastest(constants: Sequence[float], extent: Extent) -> float:
    """Return from which time constant on terms are spread anew, s: faster than the fastest found."""
    return max(min(constants) / 3.0, PHYSICS.dynamics_longest * extent.sample_time)


def _growth(values: Mapping, early: float, late: float) -> float:
    """Return the share of a step by which creep grows between two times after it, s."""
    gains, constants = (np.array(terms) for terms in _terms(values))
    return float(gains @ (np.exp(-early / constants) - np.exp(-late / constants)))


def _grown(time: np.ndarray, constants: np.ndarray | float) -> np.ndarray:
    """Return the share of each term, (N, K), that is there at times (N, 1) after a step."""
    return 1.0 - np.exp(-time / np.atleast_1d(constants))


def _terms(values: Mapping) -> tuple[list[float], list[float]]:
    """Return the gains of a model's terms and their time constants, s."""
    terms = range(1, int(values["creepCount"]) + 1)
    gains, constants = ([values[f"creep[{i}].{n}"] for i in terms] for n in ("gain", "timeConstant"))
    return gains, constants


def _with_terms(values: Mapping, terms: Mapping) -> dict[str, float]:
    """Return the values of a model with terms in place of those that it has."""
    return {**{n: v for n, v in values.items() if not n.startswith("creep[")}, **terms}


def _of_terms(gains: Sequence[float], constants: Sequence[float]) -> dict[str, float]:
    """Return the values of terms, given their gains and time constants, s."""
    values: dict[str, float] = {"creepCount": len(gains)}
    for i, (gain, constant) in enumerate(zip(gains, constants, strict=True), start=1):
        values |= {f"creep[{i}].gain": gain, f"creep[{i}].timeConstant": constant}
    return values


EVIDENCE = CreepEvidence()
