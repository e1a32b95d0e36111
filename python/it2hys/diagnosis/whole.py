"""From what was searched of long records to the whole of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from it2hys.diagnosis.fitting import Bench
from it2hys.diagnosis.last_fit import last_fit
from it2hys.diagnosis.refinement import refitted
from it2hys.identification.criterion import ChainFit, Model, with_rules
from it2hys.identification.scaling import relaxed
from it2hys.identification.usability import share_of_way
from it2hys.policy import CORE
from it2hys.support.processes import called


@dataclass(frozen=True, eq=False)
class Whole:
    """The whole training records, of which a search has seen a part.

    Parameters
    ----------
    searched : Bench
        That part.
    thinned : Bench
        The whole records at the sample time of the part.
    deciding : Bench
        The whole records at their own, with what decides between models.
    judging : Bench
        The same, of which everything is fitted.
    """

    searched: Bench
    thinned: Bench
    deciding: Bench
    judging: Bench

    def fitted(self, model: Model) -> Model:
        """Return the model of what was searched as one of the whole records."""
        own = self.judging.extent.sample_time
        if model.values["sampleTime"] == own:
            return self.judging.fit_own(model, self.judging.traces)
        known = self.searched.errors(model)
        model = self.thinned.fit_own(model, self.thinned.traces)
        return refitted(self.deciding, at_sample_time(model, own, self.thinned), known).fit.model

    def last_fit(self, model: Model, before: Model) -> tuple[Bench, ChainFit]:
        """Return the last fit, see `last_fit`, of a model of what was searched."""
        return last_fit(self.judging, self.fitted(model), before)

    def all_fitted(
        self, model: Model, before: Model, others: Sequence[Model], each: Callable
    ) -> tuple[tuple[Bench, ChainFit], list[Model]]:
        """Return the last fit of a model and, side by side with it, others as `fitted` returns them."""
        pieces = [partial(self.last_fit, model, before), *(partial(self.fitted, m) for m in others)]
        last, *fitted = each(called, pieces)
        return last, fitted


def at_sample_time(model: Model, sample_time: float, bench: Bench) -> Model:
    """Return a model of a bench at another sample time, its core as near to what it was as may be."""
    ratio = sample_time / model.values["sampleTime"]
    if ratio == 1.0:
        return model
    band = bench.criterion(model).guarded(1.0).band
    share = share_of_way(bench.scaling.rules(model.rules), band, ratio) if band else 1.0
    model = with_rules(model, relaxed(model.rules, share))
    values = {**model.values, "sampleTime": sample_time}
    return replace(model, values=values, contraction=min(model.contraction**ratio, CORE.contraction))
