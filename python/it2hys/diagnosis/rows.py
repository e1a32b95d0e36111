"""The evidence on every effect: its signature, its trial, and the reason for the verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from it2hys.diagnosis.chances import largest_chance, level
from it2hys.diagnosis.comparison import compare, is_worse
from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.outcome import Evidence
from it2hys.diagnosis.refinement import Node
from it2hys.diagnosis.selection import Search, Trial
from it2hys.model.chain import EFFECTS
from it2hys.policy import SEARCH
from it2hys.records.clues import Clues
from it2hys.records.figures_of_merit import change_in_percent


@dataclass(frozen=True)
class Verdict:
    """The result of the search, and the effects that it was not to try.

    Parameters
    ----------
    search : Search
    node : Node
        The model that was chosen.
    named : tuple of str
        Effects that were added to it.
    groups : tuple of tuple of str
        Effects that cannot be told apart.
    declared : tuple of str
        Effects in the model from the start.
    inseparable : tuple of str
        Effects that the records cannot show.
    excluded : tuple of str
        Effects that the caller kept out.
    regulated : tuple of str
        Effects that a controller imitates, where it was on in all records that decide.
    of_the_core : tuple of str
        Effects whose work in a loop the core can do, where the records go through one alone.
    """

    search: Search
    node: Node
    named: tuple[str, ...]
    groups: tuple[tuple[str, ...], ...]
    declared: tuple[str, ...]
    inseparable: tuple[str, ...]
    excluded: tuple[str, ...] = ()
    regulated: tuple[str, ...] = ()
    of_the_core: tuple[str, ...] = ()


def indistinguishable(chosen: Node, rivals: Sequence[Node]) -> tuple[tuple[str, ...], ...]:
    """Return the groups of effects of which any would do."""
    common = chosen.effects.intersection(*(rival.effects for rival in rivals))
    group = {e for n in (chosen, *rivals) for e in n.effects - common}
    return (tuple(e for e in EFFECTS if e in group),) if group else ()


def evidence_of(verdict: Verdict, left: Clues) -> tuple[Evidence, ...]:
    """Return the evidence on every effect.

    Parameters
    ----------
    verdict : Verdict
    left : Clues
        Residuals of the first model.
    """
    return tuple(_evidence_on(effect, verdict, left) for effect in EFFECTS)


def _evidence_on(effect: str, verdict: Verdict, left: Clues) -> Evidence:
    signature, trial = EVIDENCE[effect].signature(left), _trial_of(effect, verdict)
    reason = _untried(effect, verdict, left) if trial is None else _reason(effect, trial, verdict)
    known = Evidence(
        effect,
        np.nan if signature is None else signature.statistic,
        np.nan if signature is None else signature.p_value,
        "" if signature is None else signature.text,
        np.nan,
        np.nan,
        effect in verdict.named,
        reason,
        reason,
    )
    if trial is None:
        return known
    c = trial.comparison
    return replace(
        known,
        held_out_gain=c.gain,
        held_out_p_value=c.p_value,
        why=_why(effect, trial, verdict, reason),
        beside=tuple(sorted(trial.base)),
        error_before=c.before,
        error_after=c.after,
        level=trial.level,
    )


def _trial_of(effect: str, verdict: Verdict) -> Trial | None:
    """Return the trial that decided on an effect.

    For one that was added, the one on the way to the model; for another, that on the final model if
    there is one, otherwise that on the first.
    """
    own = [t for t in verdict.search.trials if t.addition == effect]
    if effect in verdict.named:
        own = [t for t in own if t.base <= verdict.node.added and t.accepted] or own
        last = max(own, key=lambda t: len(t.base), default=None)
        return last if last is None or last.accepted else _decided_later(effect, last, verdict)
    final = [t for t in own if t.base == verdict.node.added]
    return (final or own or [None])[0]


def _decided_later(effect: str, trial: Trial, verdict: Verdict) -> Trial:
    """Return what decided on an effect that was followed before it was accepted.

    It is the comparison of the last model with the one that lacks the effect alone.
    """
    without = verdict.search.nodes.get(verdict.node.added - {effect})
    if without is None:
        return trial
    comparison = compare(without.errors.free, verdict.node.errors.free)
    return replace(trial, base=without.added, comparison=comparison, accepted=True)


def _untried(effect: str, verdict: Verdict, left: Clues) -> str:
    """Return why an effect was not tried."""
    if effect in verdict.declared:
        return "declared: in the model from the start"
    if effect in verdict.node.fit.model.effects:
        return "in the starting model"
    if effect in verdict.excluded:
        return "not tried: excluded"
    if effect in verdict.regulated:
        return (
            "not tried: the validation records were taken in closed loop, where a controller's slow "
            f"correction looks like it; give one taken in open loop, or --declared {effect}"
        )
    if effect in verdict.of_the_core:
        return (
            "not tried: the training records hold one amplitude at one frequency, and all that it does "
            "to one loop the core can do, too"
        )
    channel = EVIDENCE[effect].channel
    if channel and getattr(left.extent, channel) is None:
        return f"not tried: no record has a {channel} channel"
    if effect in verdict.inseparable:
        others = [", ".join(e for e in verdict.inseparable if e != effect), "the core's own phase lag"]
        return (
            "not tried: the training records hold one amplitude at one frequency, which cannot "
            f"tell it from {' and from '.join(filter(None, others))}"
        )
    return "not tried: a run with it diverges from every initial guess, or its channel is constant"


def _why(effect: str, trial: Trial, verdict: Verdict, reason: str) -> str:
    """Return the verdict on an effect that was tried, in a sentence."""
    c = trial.comparison
    fall = (
        f"changes the free-run error on held-out data from {1e6 * c.before:.4g} to "
        f"{1e6 * c.after:.4g} µm ({change_in_percent(-c.gain)} %, p = {c.p_value:.2g})"
    )
    if effect in verdict.named:
        return f"adding it {fall}{_besides(trial)}"
    if any(effect in group for group in verdict.groups):
        return f"adding it {fall}, but {reason}"
    base = " + ".join(["the model", *sorted(trial.base)])
    return f"added to {base} it {fall}{', but ' if trial.accepted else ': '}{reason}"


def _besides(trial: Trial) -> str:
    """Return what else speaks for an effect that held-out data alone do not decide."""
    if trial.comparison.p_value <= largest_chance(trial.comparison.gain, trial.level):
        return ""
    for inverse in (trial.band, trial.wide):
        if inverse.gain > 0.0 and inverse.p_value <= level():
            change = change_in_percent(-inverse.gain)
            return f"; that of the inverse by {change} % (p = {inverse.p_value:.2g})"
    if trial.fitted < SEARCH.least_share:
        return ""
    return "; it shows in the fitted records, and by its signature in what other effects leave"


def _reason(effect: str, trial: Trial, verdict: Verdict) -> str:
    """Return why an effect that was tried was not added; nothing where it was."""
    if effect in verdict.named:
        return ""
    rivals = [g for g in verdict.groups if effect in g]
    if rivals:
        return "these records cannot tell it from " + ", ".join(e for e in rivals[0] if e != effect)
    if effect in verdict.search.withdrawn:
        return verdict.search.withdrawn[effect]
    if trial.refused:
        return trial.refused
    c = trial.comparison
    is_chance = c.p_value > largest_chance(c.gain, trial.level)
    if trial.accepted and not is_chance and verdict.node.effects <= trial.base:
        return "with the model without it fitted anew, it is not accepted any more"
    if trial.accepted and not is_chance:
        return "other effects explain the residual better"
    if not is_chance and trial.sampling:
        return "it acts within a sample, as a delay or another sampling of the signals would"
    if not is_chance and is_worse(trial.band, SEARCH.spoils):
        return "the inverse gets worse by it"
    if not is_chance and trial.fitted < SEARCH.commensurate * c.gain:
        return "the training records hardly show it: train with a record that does"
    if not is_chance and c.gain > SEARCH.clear_gain:
        return "it explains a small part of the residual, which lacks this effect's signature"
    reason = "not significant at the level of a search" if is_chance else "below the required gain"
    if trial.fitted > SEARCH.plain:
        reason += (
            f", although it lowers the error on the training records by {100 * trial.fitted:.0f} %: "
            "add validation records with similar excitation"
        )
    return reason
