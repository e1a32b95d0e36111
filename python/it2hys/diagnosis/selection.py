"""The search for the effects that a model lacks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from it2hys.chain import EFFECTS
from it2hys.diagnosis.comparison import Comparison, compare
from it2hys.diagnosis.criterion import SOFT, ChainFit, Model
from it2hys.diagnosis.fitting import Bench, is_sampling, with_slower_creep, without_effect

#: One rule more: what the core can absorb is no effect.
RULE = "rule"
#: Level of significance, over all effects tried.
LEVEL = 0.01
#: Least share by which the error has to fall ...
LEAST_GAIN = 0.05
#: ... which has to be more than this, or else more than the other share of what exceeds the noise.
CLEAR_GAIN, LEAST_SHARE = 0.1, 0.25
#: Least gain, and largest probability of it by chance, for a variant of a model to be taken.
_REFINED, _LIKELY = 0.01, 0.05
#: A model that is not accepted, but lowers the cost on the training records to less than this share, is
#: followed where no other is: of two effects that are both missing, one alone may predict nothing.
_PROMISING = 0.7
#: Models that are followed side by side, none with an error above so many times the best one's.
BEAM, BEAM_RATIO = 3, 2.0
#: Effects that are added one after the other.
DEPTH = 4
#: Candidates that are fitted to the end; iterations for that.
FINALISTS, FINISHING = 4, 60


@dataclass(eq=False)
class Node:
    """A model of the search.

    Parameters
    ----------
    added : frozenset of str
        What was added to the first model: effects, and rules as "rule", "rule 2".
    fit : ChainFit
    errors : list of ndarray
        On the records that decide, m.
    """

    added: frozenset[str]
    fit: ChainFit
    errors: list[np.ndarray]

    @property
    def rms(self) -> float:
        """Error on the records that decide, m."""
        return float(np.sqrt(np.mean(np.concatenate(self.errors) ** 2)))

    @property
    def effects(self) -> frozenset[str]:
        """Effects that were added."""
        return frozenset(a for a in self.added if a in EFFECTS)


@dataclass(frozen=True)
class Trial:
    """One addition that was tried.

    Parameters
    ----------
    base : frozenset of str
        What had been added before.
    addition : str
    comparison : Comparison
        Of the errors on the records that decide.
    accepted : bool
        Whether it is better by more than chance and by enough.
    """

    base: frozenset[str]
    addition: str
    comparison: Comparison
    accepted: bool


@dataclass(eq=False)
class Search:
    """The search over sets of effects, beginning with a model.

    Parameters
    ----------
    bench : Bench
    report : callable
        Told of every addition that was tried.
    excluded : tuple of str
        Effects that are not tried.
    """

    bench: Bench
    report: Callable[[Trial], None] = lambda trial: None
    excluded: tuple[str, ...] = ()
    trials: list[Trial] = field(default_factory=list)
    nodes: dict[frozenset[str], Node] = field(default_factory=dict)
    rivals: list[Node] = field(default_factory=list)

    def run(self, model: Model) -> Node:
        """Search; return the model that was chosen."""
        fit = self.bench.fit(model, FINISHING)
        self.root = Node(frozenset(), fit, self.bench.errors(fit.model))
        self.nodes[frozenset()] = self.root
        beam = [self.root]
        for _ in range(DEPTH):
            self._promising: list[Node] = []
            grown = [child for node in beam for child in self._grow(node, node is beam[0])]
            grown = grown or sorted(self._promising, key=lambda n: n.fit.minimum.cost)[:1]
            if not grown:
                break
            for node in sorted(grown, key=lambda n: n.rms)[:BEAM]:
                self._sharpen(node)
            grown.sort(key=lambda n: n.rms)
            beam = [n for n in grown[:BEAM] if n.rms < BEAM_RATIO * grown[0].rms]
        return self.choose()

    def _grow(self, node: Node, thorough: bool) -> list[Node]:
        """Return the models with one addition more that are better than this one."""
        fits = {}
        for addition in self._additions(node):
            if node.added | {addition} in self.nodes:
                continue
            fit = (
                self.bench.add(node.fit.model, addition, thorough)
                if addition in EFFECTS
                else self.bench.add_rule(node.fit.model)
            )
            if fit is not None:
                fits[addition] = fit
        grown = []
        for rank, addition in enumerate(sorted(fits, key=lambda a: fits[a].minimum.cost)):
            fit = fits[addition]
            if rank < FINALISTS:
                fit = self.bench.fit(fit.model, FINISHING)
            child = Node(node.added | {addition}, fit, self.bench.errors(fit.model))
            comparison = compare(node.errors, child.errors)
            sampling = any(is_sampling(fit.model, e) for e in child.effects)
            accepted = self.is_better(comparison, len(EFFECTS)) and not sampling
            trial = Trial(node.added, addition, comparison, accepted)
            self.trials.append(trial)
            self.report(trial)
            if accepted:
                self.nodes[child.added] = child
                grown.append(child)
            elif fit.minimum.cost < _PROMISING * node.fit.minimum.cost and not sampling:
                self._promising.append(child)
        return grown

    def _additions(self, node: Node) -> list[str]:
        rules = sum(a.startswith(RULE) for a in node.added)
        return [
            *(e for e in EFFECTS if e not in (*node.fit.model.effects, *self.excluded)),
            *([RULE if rules == 0 else f"{RULE} {rules + 1}"] if rules < 2 else []),
        ]

    def _sharpen(self, node: Node) -> None:
        """Seek the rules of a model anew unless it is as good as the noise allows."""
        if self.bench.has_reached_noise(node.fit):
            return
        fit = self.bench.reshaped(node.fit.model)
        if fit.minimum.cost < node.fit.minimum.cost:
            node.fit, node.errors = fit, self.bench.errors(fit.model)
        if "play" in node.effects and node.fit.model.smoothness > SOFT:
            self._take_if_better(node, replace(node.fit.model, smoothness=SOFT))

    def _take_if_better(self, node: Node, model: Model) -> bool:
        """Fit a variant of a node's model and keep it if it predicts better; return whether it does."""
        fit = self.bench.fit(model, FINISHING)
        errors = self.bench.errors(fit.model)
        comparison = compare(node.errors, errors)
        if comparison.gain < _REFINED or comparison.p_value > _LIKELY:
            return False
        node.fit, node.errors = fit, errors
        return True

    def _refine(self, node: Node) -> None:
        """Add creep terms, slower ones, as long as they predict better."""
        while "creep" in node.effects and self._take_if_better(
            node, with_slower_creep(node.fit.model, self.bench.extent)
        ):
            pass

    def is_better(self, comparison: Comparison, tried: int) -> bool:
        """Return whether a gain is more than chance, and enough to speak of."""
        if comparison.gain < LEAST_GAIN or comparison.p_value * tried > LEVEL:
            return False
        share = 1.0 - self._excess(comparison.after) / self._excess(comparison.before)
        return comparison.gain > CLEAR_GAIN or share > LEAST_SHARE

    def _excess(self, rms: float) -> float:
        """Return what of an error is not noise; less than a part of the noise cannot be told."""
        return float(np.sqrt(max(rms**2 - self.bench.floor**2, (0.3 * self.bench.floor) ** 2)))

    def choose(self) -> Node:
        """Return the model with the fewest effects that none is better than.

        Effects added early are tested again: without each of them the rest is fitted anew, and where
        nothing is lost, the model without it is the one.
        """
        chosen = self._simplest()
        while True:
            fresh = [e for e in chosen.effects if chosen.added - {e} not in self.nodes]
            if not fresh:
                self._refine(chosen)
                return chosen
            for effect in fresh:
                fit = self.bench.fit(without_effect(chosen.fit.model, effect), FINISHING)
                node = Node(chosen.added - {effect}, fit, self.bench.errors(fit.model))
                self.nodes[node.added] = node
            chosen = self._simplest()

    def _simplest(self) -> Node:
        best = min(self.nodes.values(), key=lambda n: n.rms)
        alike = [n for n in self.nodes.values() if not self._beats(best, n)]
        fewest = min((len(n.effects), len(n.added)) for n in alike)
        alike = [n for n in alike if (len(n.effects), len(n.added)) == fewest]
        alike.sort(key=lambda n: n.rms)
        self.rivals = alike[1:]
        return alike[0]

    def settled(self, chosen: Node) -> Node:
        """Return the chosen model without the effects that a rival does without.

        A rival is as good a model with as few effects.
        """
        common = chosen.effects.intersection(*(rival.effects for rival in self.rivals))
        if common == chosen.effects:
            return chosen
        known = [n for n in self.nodes.values() if n.effects == common]
        if known:
            return min(known, key=lambda n: n.rms)
        model = chosen.fit.model
        for effect in chosen.effects - common:
            model = without_effect(model, effect)
        fit = self.bench.fit(model, FINISHING)
        return Node(chosen.added - (chosen.effects - common), fit, self.bench.errors(fit.model))

    def _beats(self, one: Node, other: Node) -> bool:
        return one is not other and self.is_better(compare(other.errors, one.errors), 1)
