"""Variants of a model: with an effect more or less, with other values, with another rule."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.identification.criterion import ChainFit, Model, Trace, with_rules
from it2hys.identification.effect_coordinates import by_record
from it2hys.identification.scaling import moved
from it2hys.identification.starts import SHIFT, SHIFTING, sampling_delay, shifts
from it2hys.model.stages import EFFECTS, STAGES
from it2hys.model.variables import load_table, off_values
from it2hys.records.clues import Extent


def shifted(model: Model, name: str, share: float) -> Model:
    """Return the model with a delay of a share of a sample, which this parameter is."""
    return replace(model, values={**model.values, name: share * model.values["sampleTime"]})


def sampled_otherwise(fit: ChainFit, effect: str) -> list[Model]:
    """Return the model with what tells of others' sampling on the bound that it is farther from.

    It was fitted while the effect was missing. A zero and a delay that make up for a part of each other
    are an optimum of their own; half a sample, by which what is held and what runs straight differ,
    leads out of it.
    """
    known, values = load_table().parameters(), fit.model.values
    found = [c for c in fit.criterion.common if c.of_sampling and known[c.name].effect != effect]
    other = {c.name: max(c.bounds, key=lambda b, c=c: abs(b - values[c.name])) for c in found}
    name = sampling_delay(fit.model, effect)
    halfway = shifted(fit.model, name, 0.5) if name else fit.model
    return [replace(halfway, values={**halfway.values, **other})] if other else []


def is_sampling(model: Model, effect: str) -> bool:
    """Return whether an effect beside another fast one may be no more than how signals were sampled.

    It is if it shifts or smooths by less than a sample.
    """
    if not any(EFFECTS[e].sampled and e != effect for e in model.effects):
        return False
    return EVIDENCE[effect].is_within_a_sample(model.values)


def is_delay(model: Model, effect: str) -> bool:
    """Return whether a fast effect is no more than the delay of up to a sample that goes with it.

    It is if it has done most of its work in that delay.
    """
    name = sampling_delay(model, effect)
    return bool(name) and EVIDENCE[effect].is_done_within(model.values, model.values[name])


def with_effect(model: Model, effect: str, guess: Mapping, extent: Extent) -> Model:
    """Return the model with an effect at guessed values."""
    known = load_table().parameters()
    own = dict(model.own)
    for name in by_record():
        if known[name].effect == effect:
            own[name] = np.broadcast_to(guess.get(name, 0.0), model.offsets.shape).copy()
    values = {**model.values, **{n: v for n, v in guess.items() if n not in by_record()}}
    result = replace(model, values=values, effects=(*model.effects, effect), own=own)
    name = sampling_delay(result, effect)
    if name and not values[name]:
        values[name] = 0.5 * extent.sample_time
    return result


def without_effect(model: Model, effect: str) -> Model:
    """Return the model with an effect switched off."""
    known = load_table().parameters()
    values = {n: v for n, v in model.values.items() if known[n].effect != effect}
    values.update(off_values([effect]))
    own = {n: v for n, v in model.own.items() if known[n].effect != effect}
    effects = tuple(e for e in model.effects if e != effect)
    result = replace(model, values=values, effects=effects, own=own)
    if SHIFTING not in effects and not shifts(result):
        values[SHIFT] = 0.0
    return result


def extended(model: Model, effect: str, extent: Extent) -> list[Model]:
    """Return the model with more elements of an effect, as often as that is a variant of it."""
    variants = EVIDENCE[effect].extended(model.values, extent)
    return [replace(model, values={**model.values, **more}) for more in variants]


def in_other_roles(model: Model) -> list[Model]:
    """Return the model with what two effects have alike exchanged, for every such pair.

    Two that ring behind one another answer nearly alike in either order, and no descent leads from
    the one to the other.
    """
    values = model.values
    pairs = [_alike(*pair) for pair in combinations(model.effects, 2)]
    exchanged = [{to: values[of] for a, b in names for of, to in ((a, b), (b, a))} for names in pairs]
    return [replace(model, values={**values, **changed}) for changed in exchanged if changed]


def _alike(one: str, other: str) -> list[tuple[str, str]]:
    """Return the parameters of like name and unit of two effects on one side of the core."""
    if STAGES[one] is not STAGES[other]:
        return []
    single = {n: p for n, p in load_table().parameters().items() if p.group is None}
    first, second = (
        {(n.rpartition(".")[2], p.type.unit): n for n, p in single.items() if p.effect == effect}
        for effect in (one, other)
    )
    return [(name, second[key]) for key, name in first.items() if key in second]


def with_another_rule(model: Model, rule: int, distance: float) -> Model:
    """Return the model with a rule split into two equal ones whose centres move apart."""
    rules = model.rules
    twins = np.repeat(rules[rule : rule + 1], 2, axis=0)
    twins[:, 2] += [-distance, distance]
    return with_rules(model, np.vstack([rules[:rule], twins, rules[rule + 1 :]]))


def behind_gain(model: Model, total: float, traces: Sequence[Trace]) -> Model:
    """Return the model with its core moved so that a gain leaves the mean reading where it is.

    Otherwise the readings would be off by what it adds to their mean stroke.
    """
    readings = [(t.y - o)[t.judged] for t, o in zip(traces, model.offsets, strict=True)]
    distance = (
        total
        / (1.0 + total)
        * (float(np.mean(np.concatenate(readings))) - model.values["displacementZero"])
    )
    return with_rules(model, moved(model.rules, -distance))
