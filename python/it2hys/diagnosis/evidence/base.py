"""How an effect shows in records, and how a fit of it begins.

The physics of an effect is in `it2hys.model.effects`; here is what a diagnosis knows about it, so that
nothing else in the loop names an effect.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from it2hys.records import Record
from it2hys.records.clues import Clues, Extent


@dataclass(frozen=True)
class Signature:
    """How much of a residual looks as one effect would make it.

    Attributes
    ----------
    statistic : float
        What `p_value` comes from, see the effect's `signature`; larger speaks for the effect.
    p_value : float
        Probability of such a statistic in noise, coloured or not, corrected for what was tried on the
        way (thresholds, frequencies), not for the number of effects.
    text : str
        What was found, as a sentence with units.
    """

    statistic: float
    p_value: float
    text: str


class EffectEvidence(ABC):
    """What a diagnosis knows about one effect.

    Attributes
    ----------
    meaning : str
        What the effect is, in plain words, as a clause.
    experiment : str
        The experiment that tells it from other effects, as a clause.
    channel : str or None
        Channel beside the voltage without which no record can show the effect.
    imitated : bool
        Whether the rules can imitate it in part, so that they are sought anew for it.
    of_any_loop : bool
        Whether a loop of one amplitude and one frequency cannot tell it apart.
    of_the_core : bool
        Whether all that it does to a loop of one amplitude and one frequency the core can do, too.
    of_a_controller : bool
        Whether a controller's slow correction looks like it.
    by_its_signature : bool
        Whether it takes a part of any error, so that its signature always has to be there.
    smooths : bool
        Whether it takes away what is fast, so that its inverse enlarges the noise of a reference.
    occasional : bool
        Whether few moments of a record may show it, of which those that decide may have none.
    guessed_by_shape : bool
        Whether a guess does not say how strong the effect is, so that the size and sign of what it
        changes do not count when guesses are compared.
    """

    meaning: str
    experiment: str
    channel: str | None = None
    imitated: bool = False
    of_any_loop: bool = False
    of_the_core: bool = False
    of_a_controller: bool = False
    by_its_signature: bool = False
    smooths: bool = False
    occasional: bool = False
    guessed_by_shape: bool = False

    # --- what has to be there ----------------------------------------------------------------------

    @abstractmethod
    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return values to start a fit from, from what a model without the effect leaves over."""

    @abstractmethod
    def signature(self, clues: Clues) -> Signature | None:
        """Return how much of that looks as this effect alone would make it, and how surely."""

    # --- of a fit ----------------------------------------------------------------------------------

    def further_guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return guesses with more than most records show, which count where they fit far better."""
        return []

    def promising(self, clues: Clues, trials: Sequence[Mapping]) -> list[int]:
        """Return the places of the trials that are worth to be followed with new rules."""
        return list(range(len(trials)))

    def gain_at_rest(self, values: Mapping) -> float:
        """Return the share of the mean stroke that the effect adds to it."""
        return 0.0

    def extended(self, values: Mapping, extent: Extent) -> list[dict[str, float]]:
        """Return the values of more elements, in each way that a fit of them may begin."""
        return []

    def scaled(self, values: Mapping, extent: Extent, factor: float) -> dict[str, float]:
        """Return the places of all elements at a multiple of what they are; none without places.

        Nor where they would do nothing on the records.
        """
        return {}

    def reaching(self, values: Mapping, extent: Extent) -> dict[str, float] | None:
        """Return the values with what `further_guesses` have more; None where there is no more."""
        return None

    # --- of a fitted effect ------------------------------------------------------------------------

    def is_within_a_sample(self, values: Mapping) -> bool:
        """Return whether it shifts or smooths by less than a sample, as another sampling would."""
        return False

    def only_smooths(self, values: Mapping) -> bool:
        """Return whether it does no more than a lag, which has fewer parameters to choose."""
        return False

    def is_done_within(self, values: Mapping, time: float) -> bool:
        """Return whether it has done most of its work in a time, in s."""
        return False

    def not_shown(self, values: Mapping, fitted: Sequence[Record], deciding: Sequence[Record]) -> str:
        """Return a sentence on what of the effect the fitted records cannot show; empty without it."""
        return ""

    def going_on(
        self, values: Mapping, extent: Extent, share: float = 1.0
    ) -> tuple[dict[str, float], list[str]] | None:
        """Return the values with an element for what is slower than the records, and its parameters.

        It goes on by a share of what it does at their end. None where there is no such thing, which is
        the default.
        """
        return None

    def even(self, values: Mapping, extent: Extent) -> tuple[dict[str, float], list[str]] | None:
        """Return the values with elements of one size at all times that records show and behind, held.

        None where there is no such thing, which is the default.
        """
        return None

    def beyond(self, values: Mapping) -> str:
        """Return in what it is more than a stage can have, as a part of a sentence; empty if it is not.

        By default its bounds see to that.
        """
        return ""

    def imitated_by(self, values: Mapping, rested: bool) -> str:
        """Return what of a model does nearly the same, as a part of a sentence; empty without it.

        `rested` says whether all records began after long rest, rather than each as it fits best.
        """
        return ""

    def unshown(self, values: Mapping, time: np.ndarray) -> list[np.ndarray]:
        """Return the shapes, (N,), that this leaves in the residual of a record, over its time, s."""
        return []
