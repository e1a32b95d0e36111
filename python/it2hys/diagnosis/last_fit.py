"""The last fit: of the model that was chosen, to the whole training records."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.fitting import Bench
from it2hys.diagnosis.rest import cold_error
from it2hys.errors import InputError
from it2hys.identification.criterion import ChainFit, Model, Trace, with_rules
from it2hys.identification.starts import at_rest
from it2hys.identification.usability import STRENGTHS, widest_range
from it2hys.policy import COVERAGE, STARTS

#: Iterations of the last fit, whose way is long, and nearly level; and of that with what goes on. Ended
#: too soon, it is worse than the fit without, and what goes on is lost: at 10 it was, at 30 it was not.
_ITERATIONS, _GOING_ON = 150, 60
#: Shares of what the records do at their end by which it may go on. The records of 16 of 20 simulated
#: stages that all begin at 0 V tell no share from another; 0.9 was the median of the best ones.
_SHARES = (1.0, 0.75, 0.5, 0.25)


def last_fit(bench: Bench, model: Model, before: Model) -> tuple[Bench, ChainFit]:
    """Fit everything that may be fitted to the end, with a core that is usable.

    Parameters
    ----------
    bench : Bench
        Fits the whole training records.
    model : Model
    before : Model
        One with a usable core, to begin with where that of `model` cannot be made usable.

    Returns
    -------
    Bench
        The same, without a constant for each record where none is needed.
    ChainFit
        Of a model with a range in which it is usable.

    Raises
    ------
    InputError
        If the model is not usable, however hard that is asked for.
    """
    fit = bench.finish(replace(model, rested=False), _ITERATIONS)
    bench, fit = _without_offsets(bench, fit)
    fit = _even_at_rest(bench, bench.rested(fit, _ITERATIONS, model))
    usable = _made_usable(bench, fit)
    if usable is None:
        # a core that few voltages determine may be past mending: that of before has a range
        other = with_rules(fit.model, before.rules)
        usable = _made_usable(bench, bench.fit(other, _ITERATIONS, STRENGTHS[0]))
    if usable is None:
        raise InputError(
            "no model that fits the training records has an inverse over their range. Give records "
            "that cover the range better"
        )
    return bench, _going_on(bench, usable)


def _made_usable(bench: Bench, fit: ChainFit) -> ChainFit | None:
    """Return the fit, refitted with rising penalties until it has a range; None without one."""
    for strength in STRENGTHS[1:]:
        if usable_over(fit.model, bench.traces) is not None:
            break
        fit = bench.fit(fit.model, _ITERATIONS, strength)
    return _over_range(bench, fit)


def _without_offsets(bench: Bench, fit: ChainFit) -> tuple[Bench, ChainFit]:
    """Return the fit without a constant for each record, unless that makes it worse by far.

    They were there for the paper's model, and may have made up for what that lacks.
    """
    if not any(t.has_offset for t in bench.traces):
        return bench, fit
    plain = replace(bench, traces=[replace(t, has_offset=False) for t in bench.traces])
    other = plain.finish(replace(fit.model, offsets=np.zeros(len(plain.traces))), _ITERATIONS)
    if other.minimum.cost * (1.0 - COVERAGE.offset_gain) > fit.minimum.cost:
        return bench, fit
    return plain, other


def _over_range(bench: Bench, fit: ChainFit) -> ChainFit | None:
    """Return the fit as one of a model with the range in which its core is usable; None without one."""
    usable = usable_over(fit.model, bench.traces)
    if usable is None:
        return None
    return ChainFit(bench.criterion(usable).holding(fit.criterion.held), fit.minimum)


def _even_at_rest(bench: Bench, fit: ChainFit) -> ChainFit:
    """Return the fit with even creep, and all records begun after long rest, if that is as good.

    Rest at several voltages shows how much creep there is in all. Few terms, at the time constants
    where they are worth most within the records, miss it. Records do not determine the time constants
    of many terms, so these are held.
    """
    if bench.begins_alike:
        return fit
    for effect in fit.model.effects:
        found = EVIDENCE[effect].even(fit.model.values, bench.extent)
        if found is None:
            continue
        values, held = found
        begun = bench.finish(replace(fit.model, values=values), _ITERATIONS, held)
        other = bench.finish(at_rest(begun.model), _ITERATIONS, held)
        fit = other if bench.is_as_good(other, fit) else fit
    return fit


def _going_on(bench: Bench, fit: ChainFit) -> ChainFit:
    """Return the fit with what goes on for longer than records that all begin at one voltage.

    They hardly show how much there is, and a stage that rested at another voltage moves by all of it.
    That it goes on as at their end is kept if it explains them as well, and the largest share of that
    otherwise which they are no less likely with. It is held, and has no interval: where records hardly
    show it, a fit gives it the size that makes up for other errors. Records that decide, and begin at
    rest at another voltage, show which share it is, or nothing.
    """
    if not bench.begins_alike:
        return fit
    elsewhere = _begun_elsewhere(bench, fit)
    for effect in fit.model.effects:
        if elsewhere:
            fits = [_with_more(bench, fit, effect, share) for share in _SHARES]
            kept = [fit, *(other for other in fits if other is not None)]
            fit = min(kept, key=lambda f: cold_error(f.model, elsewhere))
        else:
            likely = (STARTS.rested, *(1.0 for _ in _SHARES[1:]))
            fits = (_with_more(bench, fit, effect, *pair) for pair in zip(_SHARES, likely, strict=True))
            fit = next((other for other in fits if other is not None), fit)
    return fit


def _begun_elsewhere(bench: Bench, fit: ChainFit) -> list[Trace]:
    """Return the records that show how much goes on: not fitted, begun at rest at another voltage."""
    if bench.parts or not fit.model.rested or any(t.has_offset for t in bench.traces):
        return []
    return [t for t in bench.deciding if bench.begins_elsewhere(t)]


def _with_more(
    bench: Bench, fit: ChainFit, effect: str, share: float, likely: float = STARTS.rested
) -> ChainFit | None:
    """Return the fit with a share of what of an effect goes on, if it explains the records as well.

    That is if the ratio of likelihoods has at least the p-value `likely`: with 1 it has to be no less
    likely.
    """
    found = EVIDENCE[effect].going_on(fit.model.values, bench.extent, share)
    if found is None:
        return None
    values, held = found
    other = bench.fit(replace(fit.model, values=values), _GOING_ON, held=held)
    usable = _over_range(bench, other)
    loss = fit.criterion.samples * np.log(_power(other) / max(_power(fit), np.finfo(float).tiny))
    return usable if usable is not None and chi2.sf(loss, len(held)) >= likely else None


def _power(fit: ChainFit) -> float:
    """Return the sum of the squares of the records' residuals, without priors and penalties."""
    linear = fit.criterion.jacobian(fit.minimum.coordinates)
    return np.inf if linear is None else float(linear[1] @ linear[1])


def usable_over(model: Model, traces: list[Trace]) -> Model | None:
    """Return a model of records with a range in which its core is usable.

    The range holds the core's outputs, and the displacements too where it can; None without one.
    """
    runs = [model.run(t, i) for i, t in enumerate(traces)]
    core = [output for _, _, output in runs]
    ranges = (
        widest_range(model.rules, float(min(map(np.min, ys))), float(max(map(np.max, ys))))
        for ys in ([*core, *(reading for reading, _, _ in runs)], core)
    )
    usable = next((usable for usable in ranges if usable is not None), None)
    if usable is None:
        return None
    ends = dict(zip(("displacementMin", "displacementMax"), usable, strict=True))
    return replace(model, values={**model.values, **ends})
