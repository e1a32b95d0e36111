"""Models on the way of a search: with an effect more or less, fitted, and what that shaped anew."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from it2hys.diagnosis.chances import Gains
from it2hys.diagnosis.comparison import is_worse
from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.fitting import Bench, Errors
from it2hys.diagnosis.variants import extended, in_other_roles, without_effect
from it2hys.identification.criterion import ChainFit, Model
from it2hys.identification.starts import at_rest, with_histories
from it2hys.identification.usability import largest_contraction
from it2hys.model.chain import EFFECTS
from it2hys.policy import CORE, SEARCH

#: Candidates that are fitted to the end; iterations for that.
FINALISTS, FINISHING = 4, 60
#: Factors by which the places of elements are brought closer together, each again and again, and apart
#: in the end: the last step may have been too long.
_SCALES = (0.7, 0.85, 1.1)


@dataclass(frozen=True, eq=False)
class Node:
    """A model of the search.

    Parameters
    ----------
    added : frozenset of str
        What was added to the first model: effects, and rules as "rule", "rule 2".
    fit : ChainFit
    errors : Errors
        On the records that decide.
    """

    added: frozenset[str]
    fit: ChainFit
    errors: Errors

    @property
    def rms(self) -> float:
        """Free-run error on the records that decide, m."""
        return _rms(self.errors.free)

    @property
    def inverse_rms(self) -> float:
        """Error of the inverse on the records that decide, by the records' gain, m."""
        return _rms(self.errors.band)

    @property
    def wide_rms(self) -> float:
        """The same, fed with all that the records show."""
        return _rms(self.errors.wide)

    @property
    def effects(self) -> frozenset[str]:
        """Effects that were added."""
        return frozenset(a for a in self.added if a in EFFECTS)


def with_effects(
    bench: Bench,
    model: Model,
    effects: Iterable[str],
    each: Callable,
    report: Callable = lambda _: None,
    first: dict[str, ChainFit | None] | None = None,
) -> tuple[Model, list[str]]:
    """Add effects one after the other, those first that explain the most.

    Parameters
    ----------
    bench : Bench
    model : Model
    effects : iterable of str
    each : callable
        `map`, or one that has its calls made by several processes.
    report : callable, optional
        Told of every effect once it is added.
    first : dict of str to ChainFit, optional
        Fits of the model with one effect that are known; those that are made are added to it.

    Returns
    -------
    Model
    list of str
        Effects that could not be added: every guess of them diverges.
    """
    missing = [e for e in EFFECTS if e in {*effects}]
    known = {} if first is None else first
    while missing:
        untried = [e for e in missing if e not in known]
        known.update(zip(untried, each(partial(with_effect, bench, model), untried), strict=True))
        fits = {effect: fit for effect in missing if (fit := known[effect])}
        if not fits:
            break
        best = min(fits, key=lambda e: fits[e].minimum.cost)
        report(best)
        missing.remove(best)
        model, known = fits[best].model, {}
    return model, missing


def with_effect(bench: Bench, model: Model, effect: str) -> ChainFit | None:
    """Return the fit of a model with an effect, None where every guess diverges."""
    fits = [bench.add(model, effect)]
    if EVIDENCE[effect].imitated:
        fits.append(bench.add_anew(model, effect))
    known = [fit for fit in fits if fit]
    return bench.preferred(known) if known else None


def node_of(bench: Bench, added: frozenset[str], fit: ChainFit) -> Node:
    """Return the node of a fit, with its errors, without what no record shows."""
    fit = bench.without_unseen(fit)
    return Node(added, fit, bench.errors(fit.model))


def first_fit(bench: Bench, models: Sequence[Model], addition: str) -> ChainFit | None:
    """Return a first fit with an addition, from the best of some models."""
    if addition not in EFFECTS:
        return bench.add_rule(models[0])
    fits = [fit for model in models if (fit := bench.add(model, addition))]
    return bench.preferred(fits) if fits else None


def with_addition(
    bench: Bench, base: frozenset[str], before: Errors, addition: str, fit: ChainFit, rank: int
) -> tuple[Node, Gains]:
    """Return the model with an addition, fitted to the end if it ranks high, and what it gains."""
    if rank < FINALISTS:
        fit = _finished(bench, fit.model)
    node = node_of(bench, base | {addition}, fit)
    return node, Gains.of(before, node.errors)


def _finished(bench: Bench, model: Model) -> ChainFit:
    """Return a model fitted to the end, its records begun after long rest where that is likely."""
    fit = bench.finish(replace(model, rested=False), FINISHING)
    return bench.rested(bench.resampled(fit), FINISHING)


def sharpened(bench: Bench, node: Node, each: Callable | None = None) -> Node:
    """Return the model with roles exchanged and rules sought anew, unless it leaves but noise."""
    if bench.leaves_noise(node.fit):
        return node
    node = _with_rules_anew(bench, _with_roles(bench, node), each)
    return _with_faster_core(bench, _resolved(bench, _with_histories(bench, node)))


def refined_from(bench: Bench, added: frozenset[str], model: Model) -> Node:
    """Return a model that no addition has led to, fitted to the end and refined."""
    fit = _finished(bench, model)
    return refined(bench, sharpened(bench, node_of(bench, added, fit)))


def refined(bench: Bench, node: Node, each: Callable | None = None) -> Node:
    """Return the model with more elements of its effects as long as they predict better.

    What fewer of them left has shaped the rules.
    """
    begun = None
    while node is not begun:
        begun = node = _with_rules_anew(bench, node, each)
        for effect in sorted(node.fit.model.effects):
            while (better := _with_more_elements(bench, node, effect)) is not node:
                node = better
            node = _scaled(bench, node, effect)
    return node


def finest(bench: Bench, node: Node) -> Node:
    """Return the model with densities as fine and as rough as may be, begun after long rest, if better.

    What is fitted to each record makes up for what few elements miss, and many that are held smooth
    miss as much: no step by itself leads there. So many may do the work of a delay, too, but invert
    worse.
    """
    for effect in sorted(e for e in node.fit.model.effects if EFFECTS[e].is_smoothed):
        model = at_rest(replace(node.fit.model, smoothness=CORE.soft))
        most = _with_most_elements(bench, model, effect)
        if most is model:
            continue
        fitted = node_of(bench, node.added, bench.fit(most, FINISHING))
        gains = Gains.of(node.errors, fitted.errors)
        if gains.free.refines and not gains.inverts_worse:
            node = fitted
    return node


def _with_most_elements(bench: Bench, model: Model, effect: str) -> Model:
    """Return the model with as many elements of an effect as there may be."""
    while variants := extended(model, effect, bench.extent):
        model = variants[0]
    return model


def _with_more_elements(bench: Bench, node: Node, effect: str) -> Node:
    """Return the model with more elements of an effect, in the way that predicts best, if better."""
    variants = extended(node.fit.model, effect, bench.extent)
    nodes = [better for v in variants if (better := _better(bench, node, v)) is not node]
    return min(nodes, key=lambda n: n.rms, default=node)


def _with_rules_anew(bench: Bench, node: Node, each: Callable | None) -> Node:
    """Return the model with rules sought anew where it fits better."""
    fit = bench.preferred([node.fit, bench.reshaped(node.fit.model, each)])
    if fit is node.fit:
        return node
    reshaped = node_of(bench, node.added, fit)
    # what fits the training records better may do so by how they begin, and fail on others, or by a
    # slow core, which does the work of a delay
    predicts = reshaped.rms <= (1.0 + SEARCH.equal) * node.rms
    gains = Gains.of(node.errors, reshaped.errors)
    return reshaped if predicts and not gains.inverts_far_worse else node


def _with_histories(bench: Bench, node: Node) -> Node:
    """Return the model with what was before each record sought anew, where that predicts better.

    It was sought by a model that lacked the addition.
    """
    return _better(bench, node, with_histories(node.fit.model, bench.traces))


def _with_roles(bench: Bench, node: Node) -> Node:
    """Return the model with the roles of effects that are alike exchanged where that fits better."""
    for model in in_other_roles(node.fit.model):
        fit = bench.preferred([node.fit, bench.fit(model, FINISHING)])
        if fit is not node.fit:
            node = node_of(bench, node.added, fit)
    return node


def _resolved(bench: Bench, node: Node) -> Node:
    """Return the model with finer effects, smoother or rougher ones, where it predicts better.

    What they lack would be taken for another effect.
    """
    for effect in node.fit.model.effects:
        node = _scaled(bench, _with_more_elements(bench, node, effect), effect)
        if wider := EVIDENCE[effect].reaching(node.fit.model.values, bench.extent):
            model = replace(node.fit.model, values={**node.fit.model.values, **wider})
            farther = _better(bench, node, model)
            # more than most records show: such operators also fit what other effects leave
            if farther.fit.minimum.cost < SEARCH.far_better * node.fit.minimum.cost:
                node = farther
        if EFFECTS[effect].is_smoothed:
            # what was missing before may have asked for less of it than there is
            smoothness = CORE.stiff if node.fit.model.smoothness == CORE.soft else CORE.soft
            node = _better(bench, node, replace(node.fit.model, smoothness=smoothness))
    return node


def _scaled(bench: Bench, node: Node, effect: str) -> Node:
    """Return the model with an effect's elements closer together or apart, as long as that is better.

    A memory may end at once far below where the records go. A grid that is held, and smooth, up to
    there smears it.
    """
    for factor in _SCALES:
        while scaled := EVIDENCE[effect].scaled(node.fit.model.values, bench.extent, factor):
            model = replace(node.fit.model, values={**node.fit.model.values, **scaled})
            better = _better(bench, node, model)
            if better is node:
                break
            node = better
    return node


def refitted(bench: Bench, model: Model, before: Errors, each: Callable | None = None) -> Node:
    """Return a model that was found at another sample time, fitted at that of the bench.

    Its rules are sought anew where the fit leads astray: where its errors are larger than before. At
    its own rate a core may be faster.
    """
    # the penalties of the first fit are those of where its core went at the other sample time
    fit = bench.finish(bench.finish(model, FINISHING).model, FINISHING)
    node = node_of(bench, frozenset(), fit)
    if node.rms > (1.0 + SEARCH.equal) * _rms(before.free):
        anew = node_of(bench, frozenset(), bench.reshaped(model, each))
        node = min(node, anew, key=lambda n: n.rms)
    return _with_faster_core(bench, node)


def _with_faster_core(bench: Bench, node: Node) -> Node:
    """Return the model with a core as fast as is as good, where its inverse is poor.

    A core that is slower than the truth makes up for what a model of a finite number of elements leaves
    of the records that are fitted, fails on others, and its inverse enlarges noise.
    """
    if bench.inverts_well(node.wide_rms, bench.deciding):
        return node
    slope = SEARCH.faster * min(1.0, _slope(bench, node.fit.model))
    while slope > CORE.at_once:
        faster = _better(bench, node, replace(node.fit.model, contraction=slope))
        if faster is node:
            break
        node, slope = faster, SEARCH.faster * slope
    return node


def _slope(bench: Bench, model: Model) -> float:
    """Return the largest slope of the core by its last output, where the records are."""
    band = bench.criterion(model).data_band(model.offsets)
    return largest_contraction(bench.scaling.rules(model.rules), band)[0]


def _better(bench: Bench, node: Node, variant: Model) -> Node:
    """Return a variant of the model, fitted, if it predicts better; otherwise the model.

    Or if it predicts as well, and its inverse is far better.
    """
    fitted = node_of(bench, node.added, bench.fit(variant, FINISHING))
    gains = Gains.of(node.errors, fitted.errors)
    better = gains.free.refines and not (spoils(bench, fitted, gains) or gains.inverts_far_worse)
    return fitted if better or gains.calms else node


def spoils(bench: Bench, after: Node, gains: Gains) -> bool:
    """Return whether the inverse gets worse, and by more than its reference causes.

    The inverse of what smooths, rings, or has little but memory enlarges noise, and that of all that
    is quick misses what the reference leaves out; that is no fault of the model.
    """
    if not is_worse(gains.band, SEARCH.spoils):
        return False
    return gains.band.after > SEARCH.noisy * bench.least_inverse_error(after.fit.model)


def without(bench: Bench, node: Node, *effects: str) -> Node:
    """Return the model without effects, fitted anew."""
    model = replace(node.fit.model, contraction=CORE.contraction)
    for effect in effects:
        model = without_effect(model, effect)
    return node_of(bench, node.added - {*effects}, bench.resampled(bench.fit(model, FINISHING)))


def _rms(errors: list[np.ndarray]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))
