"""The search for the effects that a model lacks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy.stats import chi2, combine_pvalues

from it2hys.diagnosis.bounds import pressed_with_values
from it2hys.diagnosis.chances import (
    BEAM,
    DEPTH,
    MODELS,
    Gains,
    chance_of_a_rival,
    largest_chance,
    level,
    level_of_planned,
)
from it2hys.diagnosis.comparison import Comparison, compare
from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.fitting import Bench, excess
from it2hys.diagnosis.imitation import (
    WAITING,
    delays_beside,
    ends_better,
    follows_noise,
    imitated_by,
    imitates,
    refusal,
)
from it2hys.diagnosis.refinement import (
    FINISHING,
    Node,
    finest,
    first_fit,
    node_of,
    refined,
    refined_from,
    sharpened,
    spoils,
    with_addition,
    with_effect,
    with_effects,
    without,
)
from it2hys.diagnosis.variants import is_delay, is_sampling
from it2hys.identification.criterion import ChainFit, Model
from it2hys.model.chain import EFFECTS
from it2hys.policy import SEARCH
from it2hys.support.processes import called

#: One rule more: what the core can absorb is no effect.
RULE = "rule"
_TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class Trial:
    """One addition that was tried.

    Parameters
    ----------
    base : frozenset of str
        What had been added before.
    addition : str
    comparison, band, wide : Comparison
        Of the errors on the records that decide: of the free run, and of the inverse with either
        reference.
    accepted : bool
        Whether it is better by more than chance and by enough.
    sampling : bool
        Whether with it an effect does no more than how signals were sampled, or a delay.
    fitted : float
        Share of the error on the training records, which decide nothing, that it takes away.
    refused : str
        Why it is not accepted although it is better, see `refusal`; empty where nothing speaks against.
    level : float
        Probability by chance up to which a small gain of it counts.
    """

    base: frozenset[str]
    addition: str
    comparison: Comparison
    band: Comparison
    wide: Comparison
    accepted: bool
    sampling: bool
    fitted: float
    refused: str = ""
    level: float = field(default_factory=level)


@dataclass(eq=False)
class Search:
    """The search over sets of effects, beginning with a model.

    Parameters
    ----------
    bench : Bench
    report : callable
        Told of every fit of a model with an addition, as soon as it is made: which model it is.
    excluded : tuple of str
        Effects that are not tried.
    each : callable
        `map`, or one that has its calls made by several processes.
    given : Model, optional
        A model of other records to begin with. Fitted to these while it lacks an effect, its rules make
        up for that: the first additions are tried beside the rules that it came with, too.
    planned : tuple of str
        Effects between which the records were designed to decide. Which comparisons these are was fixed
        before anything was measured: they share a part of the budget, and all others the rest.
    withdrawn : mapping of str to str
        Effects that are not tried any more, and why, see `withdrawn_by`.
    """

    bench: Bench
    report: Callable[[str], None] = lambda model: None
    excluded: tuple[str, ...] = ()
    each: Callable[..., Iterable] = map
    given: Model | None = None
    planned: tuple[str, ...] = ()
    withdrawn: Mapping[str, str] = field(default_factory=dict)
    trials: list[Trial] = field(default_factory=list)
    nodes: dict[frozenset[str], Node] = field(default_factory=dict)
    rivals: list[Node] = field(default_factory=list)
    _kept: dict[tuple[str, Node], ChainFit | None] = field(default_factory=dict, init=False)
    #: What had been added to the models beside which every addition was tried.
    _grown: set[frozenset[str]] = field(default_factory=set, init=False)
    #: Those that held-out records do not tell from the chosen model: the rivals, and what fits worse.
    _alike: list[Node] = field(default_factory=list, init=False)

    def run(self, model: Model, plain: Model) -> Node:
        """Search from a model; return what was chosen. `plain` has no effect that was declared."""
        self._plain = plain
        first = self.bench.fit(model, FINISHING)
        if not np.isfinite(first.minimum.cost):  # the given core does not contract where records go
            first = self.bench.reshaped(model)
        self.root = node_of(self.bench, frozenset(), first)
        if model.effects:
            self.root = sharpened(self.bench, self.root, self.each)
        self._keep(self.root)
        beam = [self.root]
        for _ in range(DEPTH):
            self._promising: list[Node] = []
            grown = [child for node in beam for child in self._grow(node, node is beam[0])]
            grown = grown or self._most_promising()
            if not grown:
                break
            grown.sort(key=lambda n: n.rms)
            if self.bench.leaves_noise(grown[0].fit):
                grown = [n for n in grown if n.rms <= SEARCH.beam_ratio * grown[0].rms]
            grown[:BEAM] = self._sharpen(grown[:BEAM])
            for node in grown:
                self._keep(node)
            grown.sort(key=lambda n: n.rms)
            if self.bench.leaves_noise(grown[0].fit):
                break
            beam = [n for n in grown[:BEAM] if n.rms <= SEARCH.beam_ratio * grown[0].rms]
        self._grow_waiting()
        return self._chosen_among_all()

    def _chosen_among_all(self) -> Node:
        """Return the chosen model once nothing that it may lack has been left untried beside it.

        One that is reached by leaving out what proves needless, as a resonance that stood in for how
        signals were sampled, was on no way of the search.
        """
        chosen = self.choose()
        while self._may_lack_more(chosen):
            grown = self._grow(chosen, True)
            if not grown:
                return chosen
            grown.sort(key=lambda n: n.rms)
            for node in self._sharpen(grown[:BEAM]):
                self._keep(node)
            chosen = self.choose()
        return chosen

    def _may_lack_more(self, node: Node) -> bool:
        untried = node.added not in self._grown and len(self._grown) < MODELS
        return untried and not self.bench.leaves_noise(node.fit)

    def _most_promising(self) -> list[Node]:
        """Return of the models that are no better by themselves the best, and those that fit as well.

        What hides behind what is still missing may be of either of two kinds that act alike.
        """
        costs = [n.fit.minimum.cost for n in self._promising]
        largest = (1.0 + SEARCH.equal) ** 2 * min(costs, default=0.0)  # costs are squares of errors
        return [n for n, cost in zip(self._promising, costs, strict=True) if cost <= largest]

    def _sharpen(self, nodes: Sequence[Node]) -> list[Node]:
        if len(nodes) == 1:  # its starts are shared: all but one process would be idle
            return [sharpened(self.bench, nodes[0], self.each)]
        return list(self.each(partial(sharpened, self.bench), nodes))

    def _grow_waiting(self) -> None:
        """Try a delay beside what was found: the free run may be as good, and the inverse better.

        A slow core does the work of a delay, and its inverse enlarges the noise of a reference.
        """
        best = min(self.nodes.values(), key=lambda n: n.rms)
        inverts_well = self.bench.inverts_well(best.wide_rms, self.bench.deciding)
        if self.bench.leaves_noise(best.fit) and inverts_well:
            return
        for node in self._grow(best, True, (WAITING,)):
            self._keep(node)

    def _keep(self, node: Node) -> None:
        self.nodes[node.added] = node

    def _grow(self, node: Node, thorough: bool, only: tuple[str, ...] = ()) -> list[Node]:
        """Return the models with one addition more that are better than this one."""
        additions = [a for a in self._additions(node) if node.added | {a} not in self.nodes]
        if only:
            additions = [a for a in additions if a in only]
        else:
            self._grown.add(node.added)
        starts = [node.fit.model, *([self.given] if self.given and node is self.root else [])]
        fits = self._tried("first", node, additions, partial(first_fit, self.bench, starts))
        if thorough:
            fits |= self._with_new_rules(node, fits)
        ranked = sorted(fits, key=lambda a: fits[a].minimum.cost)
        finish = partial(with_addition, self.bench, node.added, node.errors)
        finished = self.each(finish, ranked, [fits[a] for a in ranked], range(len(ranked)))
        grown, near = [], []
        for addition, (child, gains) in zip(ranked, finished, strict=True):
            self._report(node, addition)
            model = child.fit.model
            sampling = any(is_sampling(model, e) or is_delay(model, e) for e in child.effects)
            fitted = _share_of_error(node, child)
            better = not sampling and self._accepts(node, child, addition, gains, fitted)
            refused = refusal(node, child, gains) if better else ""
            accepted = better and not refused
            trial = Trial(
                node.added, addition, gains.free, gains.band, gains.wide, accepted, sampling, fitted,
                refused, self._level(node, child),
            )  # fmt: skip
            self.trials.append(trial)
            if accepted:
                self._keep(child)
                grown.append(child)
            elif not (sampling or refused):
                if self._accepts(node, child, addition, gains, fitted, likely=True):
                    near.append(child)
                if child.fit.minimum.cost < SEARCH.promising * node.fit.minimum.cost:
                    self._promising.append(child)
        for child in self._as_good(grown, near):
            self._keep(child)
            grown.append(child)
        return grown

    @staticmethod
    def _as_good(accepted: Sequence[Node], likely: Sequence[Node]) -> list[Node]:
        """Return of models that are likely better those that are as good as the best that is for sure.

        A little more chance, or an inverse that enlarges more of the noise of its reference, does not
        tell which of two effects is there. Inverses are compared once rules have been sought anew.
        """
        if not accepted:
            return []
        best = min(accepted, key=lambda n: n.rms)
        near = [n for n in likely if n.rms <= (1.0 + SEARCH.equal) * best.rms and n.effects == n.added]
        return [n for n in near if not Gains.of(n.errors, best.errors).free_tells]

    def _accepts(
        self,
        node: Node,
        child: Node,
        addition: str,
        gains: Gains,
        fitted: float,
        likely: bool = False,
    ) -> bool:
        """Return whether a model with an addition is better by more than chance, and by enough.

        Or whether it most likely is, at the usual level of one test.
        """
        predicts = self._predicts(node, child, gains)
        if likely and not predicts:
            predicts = self.is_better(gains.free, SEARCH.likely)
            predicts = predicts and not spoils(self.bench, child, gains)
        return self._waits(node, child, gains) or (
            predicts
            and self._fits_better(node, child, fitted, gains)
            and self._is_of_its_kind(node, addition, gains.free)
        )

    def _report(self, node: Node, addition: str) -> None:
        self.report(" + ".join(["model", *sorted(node.added), addition]))

    def _with_new_rules(self, node: Node, fits: Mapping[str, ChainFit]) -> dict[str, ChainFit]:
        """Return better fits of what the rules can imitate, unless one explains what was left over.

        Of what the records were designed to tell apart, each has its best fit: the rules of the first
        model may have made up for it.
        """
        planned = self.planned if node is self.root else ()
        effects = [e for e in fits if e in planned or (e in EFFECTS and EVIDENCE[e].imitated)]
        best = min([node.fit, *fits.values()], key=lambda fit: fit.minimum.cost)
        if self.bench.is_near_noise(best):
            effects = [e for e in effects if e in planned or {*fits} == {WAITING}]
        found = self._tried("anew", node, effects, partial(self.bench.add_anew, node.fit.model))
        return {effect: self.bench.preferred([fits[effect], fit]) for effect, fit in found.items()}

    def _tried(
        self, way: str, node: Node, additions: Sequence[str], fitted: Callable
    ) -> dict[str, ChainFit]:
        """Return the fits of a model with one of each addition more, where there is one.

        That with a delay is kept: it is tried again in the end, as a rule beside the same model.
        """
        known = {WAITING: self._kept[way, node]} if (way, node) in self._kept else {}
        missing = [a for a in additions if a not in known]
        for addition, fit in zip(missing, self.each(fitted, missing), strict=True):
            self._report(node, addition)
            known[addition] = fit
        if WAITING in known:
            self._kept[way, node] = known[WAITING]
        fits = {a: known[a] for a in additions}
        return {a: fit for a, fit in fits.items() if fit}

    def _additions(self, node: Node) -> list[str]:
        rules = sum(a.startswith(RULE) for a in node.added)
        settled = (*node.fit.model.effects, *self.excluded, *self.withdrawn)
        return [
            *(e for e in EFFECTS if e not in settled),
            *([RULE if rules == 0 else f"{RULE} {rules + 1}"] if rules < 2 else []),
        ]

    def _is_of_its_kind(self, node: Node, addition: str, comparison: Comparison) -> bool:
        """Return whether an addition explains much, or what it explains is what it alone predicts.

        What a record's own history is fitted to takes a little of whatever is slow. What has a value
        of its own in every record takes a part of any error: it needs its signature.
        """
        if addition not in EFFECTS:
            return True
        if self._share(comparison) > SEARCH.least_share and not EVIDENCE[addition].by_its_signature:
            return True
        signature = EVIDENCE[addition].signature(self.bench.clues(node.fit.model))
        return signature is not None and signature.p_value < SEARCH.likely

    def _fits_better(self, node: Node, child: Node, fitted: float, gains: Gains) -> bool:
        """Return whether an addition lowers the error on the training records, too.

        By more than chance (ratio of likelihoods), and by a part at least of what it does where it was
        not fitted: otherwise it makes up for how those records begin. Where they leave little more than
        noise, a part of that little is enough: others may go where the effect is larger. No part has to
        go here where the larger part of both errors goes there.
        """
        before, after = (self.bench.excess_fitted(n.fit) for n in (node, child))
        share = 1.0 - after / max(before, _TINY)  # 0 of a record that is matched
        shows = fitted >= SEARCH.commensurate * gains.free.gain or share >= SEARCH.least_share
        if not shows and min(gains.free.gain, gains.band.gain) <= SEARCH.indispensable:
            return False
        ratio = node.fit.minimum.cost / child.fit.minimum.cost
        added = len(child.fit.minimum.coordinates) - len(node.fit.minimum.coordinates)
        if ratio <= 1.0:
            return False
        statistic = node.fit.criterion.samples * np.log(ratio)
        return bool(chi2.sf(statistic, max(added, 1)) <= level())

    def _improves(self, before: Node, after: Node) -> bool:
        """Return whether a pair of model and inverse is better by more than chance.

        The free run gets better and does not spoil the inverse; or, with a delay, the inverse gets
        better by far and the free run not worse.
        """
        gains = Gains.of(before.errors, after.errors)
        better = self._predicts(before, after, gains) or self._waits(before, after, gains)
        return better and not imitated_by(before, after, gains)

    def _predicts(self, before: Node, after: Node, gains: Gains) -> bool:
        chance = largest_chance(gains.free.gain, self._level(before, after))
        better = (
            self.is_better(gains.free, chance)
            or self._both_gain(gains)
            or self._shows_itself(before, after, gains)
        )
        return better and not spoils(self.bench, after, gains)

    def _level(self, before: Node, after: Node) -> float:
        """Return the probability by chance up to which a model counts as better than another."""
        if self.planned and not before.added and after.added in [{effect} for effect in self.planned]:
            return level_of_planned(len(self.planned))
        return level(planned=len(self.planned))

    def _both_gain(self, gains: Gains) -> bool:
        """Return whether the inverse gets better by far, and the free run most likely.

        Where a record turns but a few times, few stretches of it are independent.
        """
        halves = gains.band.gain > SEARCH.indispensable and self.is_better(gains.band)
        return halves and self.is_better(gains.free, SEARCH.confirming)

    def _shows_itself(self, before: Node, after: Node, gains: Gains) -> bool:
        """Return whether an effect more takes away much of the error, and has left its signature.

        Or whether the pair gets better by it, see `_both_gain`.

        What acts but now and then, as a resonance that few steps excite, decides too few samples to be
        significant by them alone. The signature is that of the residuals that are fitted, and the gain
        that of others: Fisher's method makes one test of the two. Where the others show nothing of it,
        the inverse may tell: a core does the work of what is missing, and is the worse to invert.
        """
        added = [*(after.effects - before.effects)]
        if len(added) != 1 or added[0] not in EFFECTS:
            return False
        if self._both_gain(gains):
            return True
        evidence = EVIDENCE[added[0]]
        if evidence.occasional:
            seen = max(gains.free, gains.band, key=lambda c: c.gain)
            # of two tests the better one; the other is no worse, but for chance
            is_as_good = gains.free.gain > -SEARCH.least_gain
            enough = seen.gain > 0.0 and (is_as_good or gains.free.p_value < 1.0 - SEARCH.likely)
            p_value, least_fitted = min(2.0 * seen.p_value, 1.0), SEARCH.least_share
        else:
            enough, p_value = gains.free.gain > SEARCH.indispensable, gains.free.p_value
            least_fitted = SEARCH.indispensable
        if not enough or p_value > SEARCH.likely or _share_of_error(before, after) < least_fitted:
            return False
        signature = evidence.signature(self.bench.clues(before.fit.model))
        if signature is None:
            return False
        chances = np.maximum([p_value, signature.p_value], _TINY)
        return bool(combine_pvalues(chances, method="fisher").pvalue <= SEARCH.together * level())

    def _lacks_what_shows(self, node: Node, other: Node) -> bool:
        """Return whether another model has an effect that shows itself in what this one leaves."""
        if len(other.effects) > len(node.effects) + 1 or len(other.effects - node.effects) != 1:
            return False
        # before the comparison by blocks, which takes longest
        left = other.inverse_rms / max(node.inverse_rms, _TINY)
        if _share_of_error(node, other) < SEARCH.least_share and left > 1.0 - SEARCH.indispensable:
            return False
        gains = Gains.of(node.errors, other.errors)
        return self._shows_itself(node, other, gains) and not spoils(self.bench, other, gains)

    def _waits(self, before: Node, after: Node, gains: Gains) -> bool:
        """Return whether a delay makes the inverse better, and no record shows that there is none.

        A delay calms the inverse of any core that is slow, even where that is what the stage is.
        """
        added = after.effects - before.effects
        if not (WAITING in added and before.effects < after.effects and gains.calms):
            return False
        ratio = self.bench.likelihood_ratio_behind_turns(before.fit.model, after.fit.model)
        return ratio > -float(chi2.isf(SEARCH.at_once, 1))

    def is_better(self, comparison: Comparison, chance: float = 0.0) -> bool:
        """Return whether a gain is more than chance (by default at a search's level), and enough."""
        chance = chance or largest_chance(comparison.gain)
        if comparison.gain < SEARCH.least_gain or comparison.p_value > chance:
            return False
        return comparison.gain > SEARCH.clear_gain or self._share(comparison) > SEARCH.least_share

    def _share(self, comparison: Comparison) -> float:
        """Return the share of what exceeds the noise that a gain takes away."""
        before, after = (excess(e, self.bench.floor) for e in (comparison.before, comparison.after))
        return 1.0 - after / before

    def choose(self) -> Node:
        """Return the model with the fewest effects that none is better than.

        Effects added early are tested again: without each of them the rest is fitted anew, and where
        nothing is lost, the model without it is the one. That is done also where the search has been
        without it before: on its way there it may have ended in a poorer optimum.
        """
        chosen, tested = self._simplest(), []
        while chosen not in tested:
            tested.append(chosen)
            effects = [e for e in EFFECTS if e in chosen.effects]
            for node in self.each(partial(without, self.bench, chosen), effects):
                delays = any(is_delay(node.fit.model, e) for e in node.effects)
                if not delays and self._is_best_known(node):
                    self._keep(node)
            chosen = self._simplest()
        # of those that lack one effect, the fit of the best decides on it
        others = [*self._with_one_less(chosen)[:1], *self._with_another(chosen)]
        ended = self._with_fresh_fits([chosen, *others])
        for node in ended:
            self._keep(node)
        chosen = self._simplest()
        chosen = chosen if chosen in ended else refined(self.bench, chosen, self.each)
        return finest(self.bench, self._needed(chosen))

    def _needed(self, chosen: Node) -> Node:
        """Return the chosen model without effects that it is no better for by itself.

        A model with more effects, all of which it needs together, may have spoken for them. Where
        others foretell as well as the chosen one, they speak for it, even where the fitted records tell
        which it is.
        """
        # the free run does without a delay, which shows in the inverse
        less = [n for n in self._with_one_less(chosen) if WAITING not in chosen.effects - n.effects]
        alike = [chosen, *self._alike]
        less = [n for n in less if not any(self._beats(o, n) for o in alike)]
        less = [n for n in less if not self._lacks_what_shows(n, chosen)]
        if not less:
            return chosen
        self.rivals, self._alike = [], []
        return self._needed(less[0])

    def _is_best_known(self, node: Node) -> bool:
        """Return whether a model predicts better than the known one, and inverts nearly as well."""
        known = self.nodes.get(node.added)
        if known is None:
            return True
        return node.rms < known.rms and not Gains.of(known.errors, node.errors).inverts_far_worse

    def _with_one_less(self, node: Node) -> list[Node]:
        """Return the models that lack one of several additions, the best one first."""
        known = [n for n in self.nodes.values() if n.added < node.added]
        known = [n for n in known if len(n.added) == len(node.added) - 1]
        return sorted(known, key=lambda n: n.rms)

    def _with_another(self, node: Node) -> list[Node]:
        """Return the best model that has another effect in place of one, if it comes near."""
        known = [n for n in self.nodes.values() if len(n.added) == len(node.added)]
        known = [n for n in known if len(n.effects ^ node.effects) == 2]
        near = (1.0 + SEARCH.near) * node.rms
        known = [n for n in known if n.rms <= near and not imitates(n, node)]
        return sorted(known, key=lambda n: n.rms)[:1]

    def _with_fresh_fits(self, nodes: Sequence[Node]) -> list[Node]:
        """Return models refined, or with their effects added to the plain one anew if that ends better.

        What was fitted on the way, while effects were missing, may lead to a poorer optimum. Which one
        is better, too few elements of an effect may hide. Those that leave but noise are left out.
        """
        first: dict[str, ChainFit | None] = {}
        pieces = []
        for node in nodes:
            if not node.effects or node.added != node.effects or self.bench.leaves_noise(node.fit):
                continue
            effects = {*node.fit.model.effects} - {*self._plain.effects}
            fresh, missing = with_effects(self.bench, self._plain, effects, self.each, first=first)
            if not missing:
                pieces += [
                    partial(refined, self.bench, node),
                    partial(refined_from, self.bench, node.added, fresh),
                ]
        ended = list(self.each(called, pieces))
        pairs = zip(ended[::2], ended[1::2], strict=True)
        return [other if ends_better(other, node) else node for node, other in pairs]

    def _simplest(self) -> Node:
        nodes = list(self.nodes.values())
        best = min(nodes, key=lambda n: n.rms)
        near = [n for n in nodes if n.rms <= (1.0 + SEARCH.equal) * best.rms]
        calmest = min(near, key=lambda n: n.wide_rms)
        alike = [
            n for n in nodes if not any(self._beats(o, n) for o in (best, calmest, *self._children(n)))
        ]
        alike = [n for n in alike if not any(self._lacks_what_shows(n, other) for other in nodes)]
        alike = alike or [best]
        fewest = min((len(n.effects), len(n.added)) for n in alike)
        alike = [n for n in alike if (len(n.effects), len(n.added)) == fewest]
        alike = [n for n in alike if not any(delays_beside(n, other) for other in alike)]
        alike = [n for n in alike if not any(follows_noise(n, other) for other in alike)]
        chosen, *others = sorted(alike, key=lambda n: n.rms)
        others = [n for n in others if not imitates(n, chosen)]
        self._alike = [n for n in others if not self._predicts_better(chosen, n)]
        gains = [compare(n.errors.free, chosen.errors.free) for n in self._alike]
        pairs = zip(self._alike, gains, strict=True)
        self.rivals = [n for n, gain in pairs if not self._all_records_tell(chosen, n, gain)]
        return chosen

    def _children(self, node: Node) -> list[Node]:
        """Return the models that have one addition more.

        The one with the least error may owe that to what spoils its inverse, and be no better for it.
        """
        larger = [n for n in self.nodes.values() if n.added > node.added]
        return [n for n in larger if len(n.added) == len(node.added) + 1]

    def settled(self, chosen: Node) -> Node:
        """Return the chosen model without the effects that a rival does without.

        A rival is as good a model with as few effects. Where none of them predicts better than what
        they have in common, as where a delay only calmed the inverse, there is nothing to tell apart.
        """
        common = chosen.effects.intersection(*(rival.effects for rival in self.rivals))
        if common == chosen.effects:
            return chosen
        node = self._with_only(chosen, common)
        gains = [(n, Gains.of(node.errors, n.errors)) for n in (chosen, *self.rivals)]
        if not any(
            self._predicts(node, n, g) or (self._waits(node, n, g) and g.free.gain > SEARCH.least_gain)
            for n, g in gains
        ):
            self.rivals = []
        return node

    def withdrawn_by(self, node: Node, last: ChainFit) -> dict[str, str]:
        """Return what of the effects found the last fit takes back, and why.

        That is what it leaves nothing of, or else the least effect that it presses against bounds or
        makes larger than a stage's can be. At such a size it is not in a stage, and makes up for
        something else. One without which most of the error stays is there. Others may be pressed
        because of the least: one goes at a time.
        """
        values, extent = last.model.values, self.bench.extent
        if nil := [e for e in sorted(node.effects) if EFFECTS[e].is_nil(values, extent)]:
            return dict.fromkeys(nil, "the fit to the whole records leaves nothing of it")
        pressed = pressed_with_values(last, sorted(node.effects))
        reason = "its fit rests on the bound of {}: the records ask for more than there may be of it"
        reasons = {effect: reason.format(names) for effect, names in pressed.items()}
        reasons |= {e: said for e in sorted(node.effects) if (said := EVIDENCE[e].beyond(values))}
        gains = {}
        for effect in reasons:
            other = Gains.of(self._with_only(node, node.effects - {effect}).errors, node.errors)
            gains[effect] = max(other.free.gain, other.band.gain)
        least = min(gains, key=lambda e: gains[e], default="")
        if not least or gains[least] > SEARCH.indispensable:
            return {}
        return {least: reasons[least]}

    def anew_without(self, withdrawn: Mapping[str, str]) -> Search:
        """Return a search of the same kind without effects; how they were tried is kept."""
        withdrawn = {**self.withdrawn, **withdrawn}
        trials = [t for t in self.trials if t.addition in withdrawn]
        return replace(self, withdrawn=withdrawn, trials=trials, nodes={}, rivals=[])

    def shown_beside(self, chosen: Node, others: Sequence[str]) -> Node:
        """Return the chosen model without the effects that it needs in place of others.

        What opens a loop in some way is imitated by anything else that does: creep, a static curve or
        hum at a multiple of the loop's frequency. Of these, only what is found beside the others as
        well is in the records.
        """
        if not chosen.effects:
            return chosen
        with_others, _ = with_effects(self.bench, self.root.fit.model, others, self.each)
        node = node_of(self.bench, frozenset(), self.bench.finish(with_others, FINISHING))
        while found := [
            child for e in sorted(chosen.effects - node.effects) if (child := self._beside(node, e))
        ]:
            node = min(found, key=lambda n: n.rms)
        if node.effects == chosen.effects:
            return chosen
        self.rivals = []
        return self._with_only(chosen, node.effects)

    def _beside(self, node: Node, effect: str) -> Node | None:
        """Return the model with an effect more if it predicts better by more than chance."""
        fit = with_effect(self.bench, node.fit.model, effect)
        if fit is None:
            return None
        child, gains = with_addition(self.bench, node.added, node.errors, effect, fit, 0)
        fitted = _share_of_error(node, child)
        better = self._predicts(node, child, gains)
        return child if better and self._fits_better(node, child, fitted, gains) else None

    def _with_only(self, chosen: Node, effects: frozenset[str]) -> Node:
        """Return the best known model with these of the chosen effects; failing that, fit it."""
        known = [n for n in self.nodes.values() if n.effects == effects]
        if known:
            return min(known, key=lambda n: n.rms)
        return without(self.bench, chosen, *(chosen.effects - effects))

    def _predicts_better(self, one: Node, other: Node) -> bool:
        """Return whether of two equally simple models one is better by more than chance."""
        least = self.bench.least_inverse_error(other.fit.model)
        return Gains.of(other.errors, one.errors).tell(least)

    def _all_records_tell(self, one: Node, other: Node, held_out: Comparison) -> bool:
        """Return whether fitted records and those that decide, together, tell that one model is right.

        Vuong's test compares the fits of models that do not contain each other; for each parameter more
        a fit has to be better by what Schwarz's criterion asks. Fisher's method makes one test of that
        and of the held-out errors, which hardly differ where both models are near the noise.
        """
        if held_out.gain <= 0.0:
            return False
        fitted = compare(*(self.bench.residuals(node.fit.model) for node in (other, one)))
        if held_out.p_value > SEARCH.likely and fitted.gain <= SEARCH.indispensable:
            return False
        more = len(one.fit.minimum.coordinates) - len(other.fit.minimum.coordinates)
        samples = one.fit.criterion.samples
        if 2.0 * samples * np.log(fitted.before / fitted.after) <= more * np.log(samples):
            return False
        chances = np.maximum([fitted.p_value, held_out.p_value], _TINY)
        together = combine_pvalues(chances, method="fisher").pvalue
        return bool(together <= chance_of_a_rival(held_out.gain))

    def _beats(self, one: Node, other: Node) -> bool:
        if one is other:
            return False
        if self._improves(other, one):
            return True
        return self._inverts_poorly(other) and Gains.of(other.errors, one.errors).calms

    def _inverts_poorly(self, node: Node) -> bool:
        """Return whether an inverse is off by more than its reference causes.

        A lag's inverse enlarges noise, and a delay's does not: that tells nothing of what is there. A
        core that enlarges it by itself is slow, and does the work of a delay.
        """
        error = node.wide_rms
        if self.bench.inverts_well(error, self.bench.deciding):
            return False
        name = "wide" if any(EVIDENCE[e].smooths for e in node.fit.model.effects) else "band"
        return error > SEARCH.noisy * self.bench.least_inverse_error(node.fit.model, name)


def _share_of_error(before: Node, after: Node) -> float:
    """Return the share of the error on the fitted records that a model takes away from another's."""
    cost = max(before.fit.minimum.cost, _TINY)  # 0 of a record that is matched
    return 1.0 - float(np.sqrt(after.fit.minimum.cost / cost))
