"""Of two models, which only imitates the other: with what no stage has, or by following noise."""

from __future__ import annotations

from it2hys.diagnosis.bounds import resting_on_bounds, touching_bounds
from it2hys.diagnosis.chances import Gains, level
from it2hys.diagnosis.comparison import compare
from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.refinement import Node
from it2hys.identification.starts import SHIFT, SHIFTING, sampling_delay
from it2hys.model.variables import load_table
from it2hys.policy import SEARCH

#: The effect that waits as a slow core does.
WAITING = SHIFTING


def refusal(node: Node, child: Node, gains: Gains) -> str:
    """Return why an addition that makes a model better is not accepted; empty if it is."""
    gain = max(gains.free.gain, gains.band.gain)
    if overdriven := overdriven_by(node, child, gain):
        return f"it fits only with {' and '.join(overdriven)} pressed against its bounds"
    return imitated_by(node, child, gains)


def imitated_by(node: Node, child: Node, gains: Gains) -> str:
    """Return what of a model does nearly the same as what it has more than another; empty without it.

    What takes away the larger part of the error is there, whatever else there is.
    """
    if gains.free.gain > SEARCH.indispensable:
        return ""
    model = child.fit.model
    added = sorted(child.effects - node.effects)
    said = (EVIDENCE[effect].imitated_by(model.values, model.rested) for effect in added)
    return next(filter(None, said), "")


def overdriven_by(node: Node, child: Node, gain: float) -> tuple[str, ...]:
    """Return the effects of a model that an addition presses against bounds where they were not.

    The two then cancel each other in part, and fit better at sizes that neither has in a stage. An
    addition without which most of the error stays is there, whatever is pressed beside it.
    """
    if gain > SEARCH.indispensable:
        return ()
    effects = sorted(node.fit.model.effects)
    before, after = (resting_on_bounds(n.fit, effects) for n in (node, child))
    return tuple(e for e in effects if {*after.get(e, ())} - {*before.get(e, ())})


def ends_better(node: Node, other: Node) -> bool:
    """Return whether a model fits better than one with the same effects, and predicts as well.

    Or predicts better, where its records begin at rest and the other one's as they fit best.
    """
    gains = Gains.of(other.errors, node.errors)
    fits = node.fit.minimum.cost < other.fit.minimum.cost
    if node.fit.model.rested and not other.fit.model.rested:
        fits = fits or gains.free.refines
    return fits and gains.free.gain >= -SEARCH.equal and not gains.inverts_worse


def imitates(node: Node, other: Node) -> bool:
    """Return whether a model needs more parameters than another, and is no such effect with them.

    A resonance that does not ring, or rests on a bound, answers nearly as a lag does, which has none of
    that to choose.
    """
    if len(node.fit.minimum.coordinates) <= len(other.fit.minimum.coordinates):
        return False
    own, others = node.effects - other.effects, other.effects - node.effects
    values = node.fit.model.values
    is_none = touching_bounds(node.fit, [*own]) or any(EVIDENCE[e].only_smooths(values) for e in own)
    return bool(is_none) and not touching_bounds(other.fit, [*others])


def follows_noise(node: Node, other: Node) -> bool:
    """Return whether a model has more parameters than another, a far worse inverse, and no less error.

    Something damped that waits no less than a delay does predicts as the delay, but its inverse
    enlarges what noise a reference has.
    """
    needed, enough = (
        sum(load_table().effect_of(c.name) in n.effects for c in n.fit.criterion.common)
        for n in (node, other)
    )
    if needed <= enough:
        return False
    wide = compare(node.errors.wide, other.errors.wide)
    if wide.gain <= SEARCH.inverse_gain or wide.p_value > level():
        return False
    return not Gains.of(other.errors, node.errors).free_tells


def delays_beside(node: Node, other: Node) -> bool:
    """Return whether a model is another one, which delays, with an effect beside nearly all of that.

    A delay of a part of a sample belongs to whatever acts within samples. A model that needs all of it,
    and an effect, too, to predict no better is no rival of the one that only delays. One that needs a
    part of it may be the truth.
    """
    model, delays = node.fit.model, other.effects - node.effects
    if delays != {WAITING} or len(node.effects) != len(other.effects):
        return False
    (effect,) = node.effects - other.effects
    name = sampling_delay(model, effect)
    return bool(name) and model.values[name] > SEARCH.same_delay * other.fit.model.values[SHIFT]
