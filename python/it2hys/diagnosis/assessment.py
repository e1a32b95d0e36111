"""The assessment of what a search found: its models on the whole records, and what they leave."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.evidence.statistics import FEWEST, rms
from it2hys.diagnosis.fitting import Bench
from it2hys.diagnosis.last_fit import usable_over
from it2hys.diagnosis.outcome import ON_TEST_RECORDS, Rival, Stage
from it2hys.diagnosis.refinement import Node
from it2hys.diagnosis.residuals import LeftOver, left_over
from it2hys.diagnosis.rest import begins_at_zero, begun_at_rest, resting
from it2hys.diagnosis.selection import Search
from it2hys.errors import InputError
from it2hys.identification.criterion import ChainFit, Model, Trace
from it2hys.identification.findings import coarse_readings, record_findings
from it2hys.identification.judgement import Judgement, judge_records, judged_samples
from it2hys.identification.preparation import Prepared
from it2hys.identification.starts import clues
from it2hys.identification.traces import within
from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import ParameterSet
from it2hys.records import Record
from it2hys.records.clues import Clue


@dataclass(frozen=True, eq=False)
class Assessment:
    """The whole records, on which models are judged as their users will use them.

    Parameters
    ----------
    bench : Bench
        The training records, all of which are fitted, with their last fit.
    prepared : sequence of (str, Prepared)
        All records with their roles.
    models : mapping of Node to Model
        Models that a search met, fitted to the whole training records.
    each : callable
        `map`, or one that has its calls made by several processes.
    """

    bench: Bench
    prepared: Sequence[tuple[str, Prepared]]
    models: Mapping[Node, Model]
    each: Callable

    def _records(self, role: str) -> list[Record]:
        return [p.record for r, p in self.prepared if r == role]

    def usable(self, model: Model) -> Model | None:
        """Return a model with a range in which its core is usable; None without one."""
        return usable_over(model, self.bench.traces)

    def rivals(
        self,
        settled: Model,
        least: Node,
        nodes: Sequence[Node],
        leaves_more: Callable[[Model], bool],
    ) -> tuple[Rival, ...]:
        """Return the models that the records cannot tell apart, behind the one settled on."""
        if len(nodes) < 2:
            return ()
        parameters = self.parameters(settled, "none of them")
        errors = least.rms, least.inverse_rms
        found = [Rival((), settled.effects, parameters, *errors, leaves_more(settled))]
        for node in nodes:
            model = self.usable(self.models[node])
            own = tuple(e for e in EFFECTS if e in node.effects and e not in settled.effects)
            if model is None or not own:
                continue
            try:
                parameters = self.parameters(model, " + ".join(own))
            except InputError:  # not usable over the whole range of the records: it rivals nothing
                continue
            effects = tuple(node.fit.model.effects)
            errors = node.rms, node.inverse_rms
            found.append(Rival(own, effects, parameters, *errors, leaves_more(model)))
        return tuple(found)

    def findings(self, after: Sequence[Judgement]) -> list[str]:
        """Return the findings on the records that hold for any model."""
        records = [p.record for _, p in self.prepared]
        return [*record_findings(records), *coarse_readings(records, [j.noise for j in after], after)]

    def not_shown(self, model: Model) -> list[str]:
        """Return sentences on what of the model's effects the records cannot show."""
        fitted, deciding = self._records("train"), self._records("validation")
        texts = (EVIDENCE[e].not_shown(model.values, fitted, deciding) for e in model.effects)
        return [text for text in texts if text]

    def left_by(self, model: Model, traces: Sequence[Trace], known: int) -> LeftOver:
        """Judge the residual of records after their lead-ins; the first `known` of them are fitted."""
        seen = clues(self.bench.fit_own(model, traces, known), traces, self.bench.extent)
        records = [_behind_lead_in(c, t) for c, t in zip(seen.records, traces, strict=True)]
        unshown = self._unshown(model, traces, records)
        records = [
            replace(c, residual=c.residual - unshown[i]) if i in unshown else c
            for i, c in enumerate(records)
        ]
        left = left_over(replace(seen, records=records), [t.noise for t in traces])
        if unshown:  # with the verdict, as it is a part of it
            sizes = [
                f"{1e6 * rms(part[records[i].used]):.2g} µm rms of record '{traces[i].name}'"
                for i, part in unshown.items()
            ]
            left.sentences[0] += (
                f" It leaves out {' and '.join(sizes)}, begun at another voltage than all that were "
                "fitted: effects slower than those records cause it, and none of them shows how large."
            )
        return left

    def _unshown(
        self, model: Model, traces: Sequence[Trace], records: Sequence[Clue]
    ) -> dict[int, np.ndarray]:
        """Return what no fitted record could show of residuals that count, by the record's place."""
        if not self.not_shown(model):
            return {}
        return {
            i: _unshown_part(c, model)
            for i, (c, t) in enumerate(zip(records, traces, strict=True))
            if t.role != "test" and self.bench.begins_elsewhere(t)
        }

    def seen_in_tests(self, model: Model, traces: Sequence[Trace]) -> list[str]:
        """Describe the residual of the test records where it is more than noise; it decides nothing."""
        traces = [within(t, self.bench.extent.voltage) for t in traces if t.role == "test"]
        traces = [t for t in traces if np.count_nonzero(t.weight) >= FEWEST]
        seen = self.left_by(model, traces, 0) if traces else None
        if seen is None or not seen.significant:
            return []
        return [f"{ON_TEST_RECORDS}, which decided nothing: " + " ".join(seen.sentences)]

    def parameters(self, model: Model, name: str) -> ParameterSet:
        """Return the model as a parameter set that begins at rest, see `begun_at_rest`."""
        fitted = self._records("train")
        voltages = [r.voltage for r in fitted]
        values = {
            **model.values,
            "voltageMin": float(min(v.min() for v in voltages)),
            "voltageMax": float(max(v.max() for v in voltages)),
        }
        # a set that the search began with may have begun far from these records
        middle = 0.5 * (values["displacementMin"] + values["displacementMax"])
        begun_there = _ordered({**values, "initialDisplacement": middle})
        rest = resting(ParameterSet(begun_there, name).validate())
        starts = {
            i: model.start(i)
            for i, record in enumerate(fitted)
            if begins_at_zero(record, rest.voltage_range)
        }
        return begun_at_rest(rest, starts, self.bench.traces, model.offsets)

    def judgements(self, model: Model, traces: Sequence[Trace]) -> tuple[Judgement, ...]:
        """Judge a model on records, as the packaged pair that it makes."""
        parameters = self.parameters(model, "judged")
        return judge_records(self.bench, model, parameters, traces, self.each)

    def stages(
        self,
        search: Search,
        node: Node,
        fit: ChainFit,
        before: tuple[Judgement, ...],
        after: tuple[Judgement, ...],
        traces: Sequence[Trace],
    ) -> tuple[Stage, ...]:
        """Return the first model, the usable ones after each addition, and the last."""
        stages = [self._stage("before", search.root, before)]
        for best in on_the_way(search, node):
            # a model on the way may have a core that makes no pair
            if usable := self.usable(self.models[best]):
                stages.append(self._stage(_label(node, best), best, self.judgements(usable, traces)))
        if node.effects:
            last = Node(node.added, fit, self.bench.errors(fit.model))
            stages.append(self._stage(_label(node, node), last, after))
        return tuple(stages)

    def _stage(self, label: str, node: Node, judgements: tuple[Judgement, ...]) -> Stage:
        """Return a model, its error on what decided, and its residuals behind the lead-ins."""
        residuals = [
            np.where(j.used, r.displacement - j.y, np.nan)
            for r, j in zip(self._records("train"), judgements, strict=False)
        ]
        return Stage(label, residuals, node.rms, judgements)


def on_the_way(search: Search, node: Node) -> list[Node]:
    """Return the best models with the first effects that were added, one more in each."""
    order = [e for e in node.fit.model.effects if e in node.effects]
    sets = [frozenset(order[:count]) for count in range(1, len(order))]
    found = [[n for n in search.nodes.values() if n.effects == effects] for effects in sets]
    return [min(nodes, key=lambda n: n.rms) for nodes in found if nodes]


def _label(node: Node, on_the_way: Node) -> str:
    """Return which of a model's effects one on the way to it has, in the order of their addition."""
    return " + ".join(e for e in node.fit.model.effects if e in on_the_way.effects)


def _ordered(values: dict) -> dict:
    """Return the values with the effects' elements in the order that the inverse wants."""
    for effect in EFFECTS.values():
        values = effect.ordered(values)
    return values


def _behind_lead_in(clue: Clue, trace: Trace) -> Clue:
    """Return what is left of a record behind its lead-in, or of all of it where that is too little."""
    used = clue.used & judged_samples(trace)
    return replace(clue, used=used) if np.count_nonzero(used) >= FEWEST else clue


def _unshown_part(clue: Clue, model: Model) -> np.ndarray:
    """Return the part of a residual, (N,), that has the shapes of what no fitted record shows, m."""
    time = model.values["sampleTime"] * np.arange(len(clue.residual))
    columns = [s for e in model.effects for s in EVIDENCE[e].unshown(model.values, time)]
    shapes = np.column_stack(columns)
    return shapes @ np.linalg.lstsq(shapes[clue.used], clue.residual[clue.used])[0]
