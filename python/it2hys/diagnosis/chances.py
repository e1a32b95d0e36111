"""What may be chance in a search: levels of its comparisons, and gains that are more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from it2hys.diagnosis.comparison import Comparison, compare, is_worse
from it2hys.diagnosis.fitting import Errors
from it2hys.model.chain import EFFECTS
from it2hys.policy import SEARCH

#: Models that are followed side by side.
BEAM = 3
#: Effects that are added one after the other.
DEPTH = 4
#: Models, at most, beside which every addition is tried: on the way, and what is chosen in the end.
MODELS = DEPTH * BEAM


def comparisons(effects: int) -> int:
    """Return how many comparisons, all on the same samples, share the budget.

    With the 11 effects of the catalogue there are 144 at most, of 12 models with 12 additions. An
    effect of the user's own is one addition more. The larger a model, the fewer additions there are:
    the rest is for a delay by two tests and anew, and for what is tested again in the end.
    """
    return MODELS * (effects + 1)


def level(effects: int = 0, planned: int = 0) -> float:
    """Return the probability by chance up to which one comparison counts; by default of all effects.

    Where a record was designed to show one of some `planned` effects, what these may spend is missing.
    """
    budget = SEARCH.budget * (1.0 - SEARCH.planned if planned else 1.0)
    return budget / comparisons(effects or len(EFFECTS))


def level_of_planned(planned: int) -> float:
    """Return the same for one of the effects that a record was designed for, alone beside the model.

    These comparisons were fixed before the record was measured, and are as few as the effects.
    """
    return SEARCH.planned * SEARCH.budget / planned


def largest_chance(gain: float, least: float = 0.0) -> float:
    """Return the p-value up to which a gain counts in a search.

    Chance does not take away the larger part of an error, however few stretches are independent. The
    level rises to that of such gains from a smaller one on, evenly in its logarithm: two fits of one
    model may gain a little less and a little more.

    Parameters
    ----------
    gain : float
    least : float, optional
        That of small gains; by default `level`.
    """
    least = least or level()
    share = (gain - SEARCH.large) / (SEARCH.indispensable - SEARCH.large)
    share = min(max(share, 0.0), 1.0)
    return float(least ** (1.0 - share) * SEARCH.confirming**share)


def chance_of_a_rival(gain: float) -> float:
    """Return the p-value up to which one of two equally simple models counts as better by a gain.

    A model has at most as many rivals as there are effects: they share a budget as large as that of the
    search, beside it. What is decided is not whether there is an effect, but which.
    """
    return max(SEARCH.budget / len(EFFECTS), largest_chance(gain))


def _tells(comparison: Comparison) -> bool:
    gain = comparison.gain
    return gain > SEARCH.telling and comparison.p_value <= chance_of_a_rival(gain)


@dataclass(frozen=True)
class Gains:
    """What a pair of model and inverse does better than another, on the records that decide.

    Parameters
    ----------
    free : Comparison
        Of the free run.
    band, wide : Comparison
        Of the inverse, with either reference.
    """

    free: Comparison
    band: Comparison
    wide: Comparison

    @classmethod
    def of(cls, before: Errors, after: Errors) -> Gains:
        """Compare the errors of two models."""
        return cls(
            compare(before.free, after.free),
            compare(before.band, after.band),
            compare(before.wide, after.wide),
        )

    @property
    def calms(self) -> bool:
        """Whether the inverse gets better by far, and the free run not worse.

        For every time that its error is halved, the free run's may rise by what counts as equal.
        """
        if self.wide.gain <= SEARCH.inverse_gain or self.wide.p_value > largest_chance(self.wide.gain):
            return False
        return self.free.gain > -SEARCH.equal * max(1.0, np.log2(self.wide.before / self.wide.after))

    @property
    def inverts_worse(self) -> bool:
        """Whether the inverse gets worse with either reference, by enough and by more than chance."""
        return any(is_worse(comparison, SEARCH.spoils) for comparison in (self.band, self.wide))

    @property
    def inverts_far_worse(self) -> bool:
        """Whether the inverse gets worse by as much as a delay has to make it better."""
        return is_worse(self.band, SEARCH.inverse_gain)

    def tell(self, least: float) -> bool:
        """Return whether of two equally simple models one is better by more than chance.

        `least` is the error that the worse one's inverse would have if it were the stage, m rms: which
        inverse is the calmer one says nothing of which model is right.
        """
        is_least = self.band.before <= SEARCH.noisy * least
        return self.free_tells or (not is_least and _tells(self.band))

    @property
    def free_tells(self) -> bool:
        """Whether of two equally simple models one predicts better by more than chance."""
        return _tells(self.free)
