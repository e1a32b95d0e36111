"""The search for the effects that a model lacks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from it2hys.chain import EFFECTS
from it2hys.core import REST_TEMPERATURE
from it2hys.diagnosis.comparison import Comparison, compare
from it2hys.diagnosis.coordinates import BY_RECORD, Coordinate
from it2hys.diagnosis.criterion import ChainCriterion, ChainFit, Model, Trace, minimise
from it2hys.effects import Clue, Clues, Extent
from it2hys.identification.criteria import Series
from it2hys.identification.fitting import fit_rules
from it2hys.identification.result import Options
from it2hys.identification.scaling import Scaling
from it2hys.parameters import RULE_FIELDS
from it2hys.variables import load_table

TIMES = {}


def coordinates_for(values, extent: Extent) -> list[Coordinate]:
    """Return what is fitted of the effects that are on."""
    result = []
    for name, effect in EFFECTS.items():
        if not effect.is_on({**OFF, **values}):
            continue
        counts = load_table().counts
        options = {"count": int(values[counts[name]["variable"]])} if name in counts else {}
        for parameter, start in effect.starts(extent, **options).items():
            result.append(Coordinate.of(parameter, start))
    return result


OFF = {n: v.start for n, v in load_table().parameters().items() if v.effect and v.group is None}


@dataclass(eq=False)
class Bench:
    """The records and how models are fitted to and judged on them."""

    traces: list[Trace]
    deciding: list[Trace]
    scaling: Scaling
    extent: Extent

    def clues(self, model: Model) -> Clues:
        records = []
        for i, t in enumerate(self.traces):
            residual = t.y - model.predict(t, i)
            records.append(
                Clue(t.drive.voltage, t.drive.force, t.drive.temperature, t.y, residual, t.weight > 0)
            )
        return Clues(self.extent, records)

    def criterion(self, model: Model) -> ChainCriterion:
        return ChainCriterion(
            self.traces, model, coordinates_for(model.values, self.extent), self.scaling
        )

    def fit(self, model: Model, iterations: int, tolerance=1e-6) -> ChainFit:
        return minimise(self.criterion(model).guarded(1.0), iterations, tolerance)

    def errors(self, model: Model, traces=None) -> list[np.ndarray]:
        """Return errors on the judged samples; only what belongs to a record is fitted to them."""
        if traces is None:
            traces = self.deciding
        fitted = fit_own(model, traces, self.scaling, self.extent)
        return [(fitted.predict(t, i) - t.y)[t.judged] for i, t in enumerate(traces)]

    def add(self, model: Model, guess: dict) -> Model:
        own, values = dict(model.own), dict(model.values)
        for name, value in guess.items():
            if name in BY_RECORD:
                own[name] = np.asarray(value, dtype=float)
                value = float(own[name][0])
            values[name] = value
        return replace(model, values=values, own=own)

    def without(self, model: Model, effect: str) -> Model:
        known = load_table().parameters()
        values = {n: v for n, v in model.values.items() if known[n].effect != effect}
        values.update({n: v for n, v in OFF.items() if known[n].effect == effect})
        own = {n: v for n, v in model.own.items() if known[n].effect != effect}
        return replace(model, values=values, own=own)

    def projected(self, model: Model, guesses: list[dict]) -> np.ndarray:
        """Return for each guess the cost that remains once the model's own parameters adapt."""
        criterion = self.criterion(model)
        jacobian, _ = criterion.jacobian(criterion.pack(model))
        step = max(1, len(jacobian) // 20000)
        q, _ = np.linalg.qr(jacobian[::step])
        costs = []
        for guess in guesses:
            trial = self.add(model, guess)
            parts = []
            for i, t in enumerate(self.traces):
                used = t.weight > 0
                parts.append((t.weight * (trial.predict(t, i) - t.y))[used] / self.scaling.y_unit)
            r = np.concatenate(parts)[::step]
            if not np.all(np.isfinite(r)):
                costs.append(np.inf)
                continue
            costs.append(float(r @ r - np.sum((q.T @ r) ** 2)))
        return np.array(costs)

    def reshaped(self, model: Model, starts: int = 12, seed: int = 0) -> ChainFit:
        """Return a fit whose rules were sought anew, on what the effects leave for the core."""
        series = []
        for i, t in enumerate(self.traces):
            reading, x, y = model.run(t, i)
            target = t.y - model.offsets[i] - (reading - y)
            y_scaled = self.scaling.y(target)
            series.append(
                Series(self.scaling.x(x), y_scaled, t.weight, float(self.scaling.y(model.starts[i])))
            )
        count = int(model.values["ruleCount"])
        options = Options(starts=starts, seed=seed)
        found = fit_rules(series, count, options, lambda *a: None, [self.scaling.rules(model.rules)])
        rules = self.scaling.physical_rules(found.rules)
        values = dict(model.values)
        for i, rule in enumerate(rules, start=1):
            values.update({f"rule[{i}].{f}": float(v) for f, v in zip(RULE_FIELDS, rule, strict=True)})
        return self.fit(replace(model, values=values), 60)

    def screen(self, model: Model, effect: str, best: int = 3, short=6, long=25) -> ChainFit | None:
        guesses = EFFECTS[effect].guesses(self.clues(model))
        if not guesses:
            return None
        if len(guesses) > best:
            costs = self.projected(model, guesses)
            guesses = [guesses[i] for i in np.argsort(costs)[:best]]
        fits = [self.fit(self.add(model, g), short) for g in guesses]
        fits = [f for f in fits if np.isfinite(f.minimum.cost)]
        if not fits:
            return None
        first = min(fits, key=lambda f: f.minimum.cost)
        return self.fit(first.model, long)


def fit_own(model: Model, traces: Sequence[Trace], scaling: Scaling, extent: Extent) -> Model:
    """Return the model with what belongs to the records fitted to these records alone."""
    own = {name: np.full(len(traces), np.mean(v)) for name, v in model.own.items()}
    gain = 1.0 + sum(
        v for n, v in model.values.items() if n.startswith("creep[") and n.endswith("gain")
    )
    first = np.array([t.y[0] for t in traces]) / gain
    start = Model(model.values, first, np.zeros(len(traces)), own)
    fitted = [c for c in coordinates_for(model.values, extent) if c.name in BY_RECORD]
    criterion = ChainCriterion(traces, start, fitted, scaling)
    if own:
        guesses = []
        for i, t in enumerate(traces):
            base = start.predict(t, i)
            # the line as the residual has it
            w = 2 * np.pi * model.values["hum.frequency"] * np.arange(len(t.y)) * extent.sample_time
            cols = np.column_stack([np.sin(w), np.cos(w), np.ones(len(w))])[t.weight > 0]
            quiet = Model({**model.values, "hum.amplitude": 0.0}, first, np.zeros(len(traces)), {})
            s, c, _ = np.linalg.lstsq(cols, (t.y - quiet.predict(t, i))[t.weight > 0])[0]
            guesses.append(np.arctan2(c, s))
        start = replace(start, own={"hum.phase": np.array(guesses)})
        criterion = ChainCriterion(traces, start, fitted, scaling)
    return minimise(criterion.holding(["rules"]), 30, 1e-8).model


@dataclass(eq=False)
class Node:
    effects: frozenset
    fit: ChainFit
    errors: list
    parent: object = None
    step: Comparison | None = None

    @property
    def rms(self):
        e = np.concatenate(self.errors)
        return float(np.sqrt(np.mean(e**2)))

    @property
    def size(self):
        return len(self.fit.criterion._common) + 2 * len(self.fit.criterion._own)


LEVEL = 0.01
LEAST_GAIN = 0.05
BEAM = 3


def significant(c: Comparison, tried: int, noise: float) -> bool:
    if not (c.gain > LEAST_GAIN and c.p_value * tried < LEVEL):
        return False
    return c.gain > 0.15 or 1.0 - excess(c.after, noise) / excess(c.before, noise) > 0.3


def excess(rms, noise):
    return float(np.sqrt(max(rms**2 - noise**2, (0.3 * noise) ** 2)))


def search(bench: Bench, model: Model, declared=(), say=lambda *a: None, max_depth=4):
    fit = bench.fit(model, 60)
    for e in declared:
        fit = bench.screen(fit.model, e)
    if declared:
        fit = bench.fit(fit.model, 100)
    floor = float(np.sqrt(np.mean([t.noise**2 for t in bench.deciding])))
    root = Node(frozenset(), fit, bench.errors(fit.model))
    nodes = {root.effects: root}
    beam = [root]
    trials = {}
    for depth in range(max_depth):
        grown = []
        for node in beam:
            options = [e for e in EFFECTS if e not in node.effects and e not in declared]
            screened = {}
            for e in options:
                key = node.effects | {e}
                if key in nodes:
                    continue
                f = bench.screen(node.fit.model, e)
                if f is not None:
                    screened[e] = f
            order = sorted(screened, key=lambda e: screened[e].minimum.cost)
            for rank, e in enumerate(order):
                f = screened[e]
                if rank < 4:
                    f = bench.fit(f.model, 60)
                errors = bench.errors(f.model)
                c = compare(node.errors, errors)
                trials[(node.effects, e)] = c
                child = Node(node.effects | {e}, f, errors, node, c)
                if significant(c, len(EFFECTS), floor):
                    nodes[child.effects] = child
                    grown.append(child)
                say(
                    "  " * depth,
                    sorted(node.effects),
                    "+",
                    e,
                    f"train {f.rms * bench.scaling.y_unit * 1e9:.2f} val {c.before * 1e9:.2f}->{c.after * 1e9:.2f} p={c.p_value:.1e}",
                    "*" if significant(c, len(EFFECTS), floor) else "",
                )
        if not grown:
            break
        grown.sort(key=lambda n: n.rms)
        for n in grown[:BEAM]:
            if n.fit.rms * bench.scaling.y_unit > 1.1 * floor:
                f = bench.reshaped(n.fit.model)
                say(
                    "   reshaped",
                    sorted(n.effects),
                    n.fit.rms * bench.scaling.y_unit * 1e9,
                    f.rms * bench.scaling.y_unit * 1e9,
                )
                if f.minimum.cost < 0.999 * n.fit.minimum.cost:
                    n.fit, n.errors = f, bench.errors(f.model)
        grown.sort(key=lambda n: n.rms)
        beam = [n for n in grown[:BEAM] if n.rms < 2.0 * grown[0].rms]
    return root, nodes, floor


def choose(root: Node, nodes: dict, floor: float):
    """Return the chosen node and its rivals."""
    ordered = sorted(nodes.values(), key=lambda n: n.rms)
    best = ordered[0]
    alike = [n for n in ordered if n is best or not _worse(best, n, floor)]
    least = min(len(n.effects) for n in alike)
    alike = [n for n in alike if len(n.effects) == least]
    alike.sort(key=lambda n: n.rms)
    return alike[0], alike[1:]


def _worse(best: Node, other: Node, floor) -> bool:
    return significant(compare(other.errors, best.errors), 1, floor)
