"""The diagnosis start to end: from records to a model with the effects that it lacked."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from it2hys.diagnosis.assessment import Assessment, on_the_way
from it2hys.diagnosis.bounds import bound_sentences
from it2hys.diagnosis.deciding import steps_aside
from it2hys.diagnosis.evidence import EVIDENCE, EffectEvidence
from it2hys.diagnosis.fitting import Bench
from it2hys.diagnosis.last_fit import last_fit
from it2hys.diagnosis.next_experiment import deciding_experiment
from it2hys.diagnosis.outcome import Diagnosis
from it2hys.diagnosis.refinement import FINISHING, Node, with_effects
from it2hys.diagnosis.rows import Verdict, evidence_of, indistinguishable
from it2hys.diagnosis.selection import Search
from it2hys.diagnosis.whole import Whole, at_sample_time
from it2hys.diagnosis.windows import Window, every, searched_text, step_of, windows_of
from it2hys.errors import InputError
from it2hys.identification import Options, identify
from it2hys.identification.coverage import coverage_warnings, holds_one_tone
from it2hys.identification.criterion import ChainFit, Model, Trace
from it2hys.identification.effect_coordinates import by_record
from it2hys.identification.judgement import Judgement, with_noise
from it2hys.identification.noise import NoiseEstimate
from it2hys.identification.preparation import (
    check_rule_count,
    check_sample_times,
    data_scaling,
    prepare,
)
from it2hys.identification.stage_figures import stage_figures
from it2hys.identification.traces import check_deciding, extent_of, set_aside, to_trace, within
from it2hys.identification.uncertainty import assess
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS, active_effects
from it2hys.model.parameters import ParameterSet
from it2hys.model.variables import load_table
from it2hys.policy import COVERAGE
from it2hys.records import Record
from it2hys.records.clues import Extent
from it2hys.records.feedback import find_feedback
from it2hys.records.units import UNITS
from it2hys.support.keys import known_names
from it2hys.support.processes import parallel_map
from it2hys.support.progress import Progress

#: Number of rules of the paper's model. More of them would take up a part of an effect; whether one
#: more does better than the effect is tried in the search.
RULES = 3


def diagnose(
    train: Sequence[Record],
    validation: Sequence[Record] = (),
    test: Sequence[Record] = (),
    model: ParameterSet | None = None,
    declared: Sequence[str] = (),
    rules: int = RULES,
    options: Options | None = None,
    progress: Progress | None = None,
    workers: int = 1,
    excluded: Sequence[str] = (),
    sensor_curve: bool = False,
    planned: Sequence[str] = (),
) -> Diagnosis:
    """Find the effects that records contain and a model lacks, and add them to it.

    Parameters
    ----------
    train : sequence of Record
        Records that are fitted.
    validation : sequence of Record
        Records that decide whether an effect is added. Without any, three tenths of every training
        record, spread over it, decide, and are fitted once all is decided.
    test : sequence of Record
        Records that decide nothing and are only reported on.
    model : ParameterSet, optional
        The model to start from; by default the paper's, identified on the training records.
    declared : sequence of str
        Effects that are in the model from the start.
    rules : int
        Number of rules of the model that is identified.
    options : Options, optional
    progress : callable, optional
        Called with the share done, 0 to 1, and what is being done.
    workers : int
        Processes that share the fits. The result does not depend on it.
    excluded : sequence of str
        Effects that are not tried.
    sensor_curve : bool
        That a static curve, where one is found, is the sensor's and no part of the stage.
    planned : sequence of str
        Effects between which the records were designed to decide: half of what the search may risk to
        name by chance is spent on these.

    Returns
    -------
    Diagnosis

    Raises
    ------
    InputError
        If records are too few or too short, differ in their sample time, lack the channel of a declared
        effect, or do not suit the given model; or if `rules` is no number of rules.
    """
    if not train:
        raise InputError("no training record is given")
    check_rule_count(rules)
    options = options or Options()
    roles = (train, validation, test)
    session = _Session(*roles, model, declared, excluded, planned, options, progress)
    with parallel_map(workers) as each:
        return replace(session.run(rules, each), has_sensor_curve=sensor_curve)


class _Session:
    """One diagnosis: what its phases hand on to each other."""

    def __init__(
        self,
        train: Sequence[Record],
        validation: Sequence[Record],
        test: Sequence[Record],
        model: ParameterSet | None,
        declared: Sequence[str],
        excluded: Sequence[str],
        planned: Sequence[str],
        options: Options,
        progress: Progress | None,
    ):
        check_sample_times([*train, *validation, *test])
        self._train, self._model, self._options = list(train), model, options
        self._progress = progress or (lambda share, text: None)
        self._extent = extent_of(train)
        self._declared = _checked_effects("declared", declared, self._extent)
        self._excluded = _checked_effects("exclude", excluded, self._extent)
        self._planned = tuple(e for e in EFFECTS if e in planned)
        if both := {*self._declared} & {*self._excluded}:
            raise InputError(f"{min(both)} is both declared and excluded")
        prepared, deciding = [prepare(r) for r in train], [prepare(r) for r in validation]
        self._scaling = data_scaling(prepared)
        # what is given keeps its own rate, at which it is compared with what is found
        self._step = step_of(prepared, deciding) if model is None else 1
        self._windows = windows_of(prepared, self._step)
        self._prepared = [
            *(("train", p) for p in prepared),
            *(("validation", p) for p in deciding),
            *(("test", prepare(r)) for r in test),
        ]
        # one loop, gone through again and again, is any of these, or the core
        one_tone = holds_one_tone(prepared)
        self._inseparable = self._open(lambda e: e.of_any_loop) if one_tone else ()
        self._of_the_core = self._open(lambda e: e.of_the_core) if one_tone else ()
        regulated = all(find_feedback(r) for r in validation or train)
        self._regulated = self._open(lambda e: e.of_a_controller) if regulated else ()
        self._seconds: dict[str, float] = {}
        searched = searched_text(self._windows, [Window(i, 0, p) for i, p in enumerate(prepared)])
        self._searches_all = not searched
        others = [p for role, p in self._prepared if role != "train"]
        self._warnings = [*([searched] if searched else []), *coverage_warnings(prepared, others)]
        self._has_offset = False
        check_deciding(self._traces("validation") or set_aside(self._searched())[1])

    def run(self, rules: int, each: Callable) -> Diagnosis:
        """Run all phases."""
        self._each = each
        base = self._timed("paper's model", self._base, rules)
        bench = self._bench(base)
        slower = at_sample_time(base, bench.extent.sample_time, self._judging)
        first = self._timed("declared effects", self._declare, bench, slower)
        not_tried = (*self._inseparable, *self._of_the_core, *self._excluded, *self._regulated)
        given = None if self._model is None else first
        planned = tuple(e for e in self._planned if e not in (*first.effects, *not_tried))
        search = Search(bench, self._report_fit, not_tried, each, given, planned)
        self._fits, begun = 0, (self._judging, self._has_offset)
        chosen, node, fit, before = self._found(search, first, slower, base)
        while withdrawn := search.withdrawn_by(node, fit):
            search = search.anew_without(withdrawn)
            self._judging, self._has_offset = begun
            chosen, node, fit, before = self._found(search, first, slower, base)
        self._progress(0.95, "assessment")
        return self._timed("assessment", self._assess, before, bench, search, chosen, node, fit)

    def _found(
        self, search: Search, first: Model, slower: Model, base: Model
    ) -> tuple[Node, Node, ChainFit, Model]:
        """Return what a search chose and settled on, and the last fits of that and of the base."""
        chosen = self._timed("search", search.run, first, slower)
        if self._inseparable:
            chosen = search.shown_beside(chosen, self._inseparable)
        node = search.settled(chosen)
        rivals = [chosen, *search.rivals] if search.rivals else []
        others = [*on_the_way(search, node), *rivals]
        fit, before, models = self._timed("final fit", self._finish, search.bench, node, base, others)
        self._of_whole_records = dict(zip(others, models, strict=True))
        return chosen, node, fit, before

    def _open(self, which: Callable[[EffectEvidence], bool]) -> tuple[str, ...]:
        """Return the effects of a kind of which the user has not said whether they are there."""
        settled = (*self._declared, *self._excluded)
        return tuple(e for e in EFFECTS if which(EVIDENCE[e]) and e not in settled)

    def _timed(self, name: str, phase: Callable, *arguments: object):
        start = time.perf_counter()
        result = phase(*arguments)
        self._seconds[name] = self._seconds.get(name, 0.0) + time.perf_counter() - start
        return result

    # --- the model to start from -----------------------------------------------------------------

    def _base(self, rules: int) -> Model:
        """Return the model before: the given one, or the paper's identified on the training records."""
        if self._model is not None:
            return self._given(self._model)
        identification = identify(
            self._train,
            rules=rules,
            options=self._options,
            progress=lambda share, text: self._progress(0.25 * share, f"the paper's model, {text}"),
            each=self._each,
        )
        records = identification.by_role("train")
        return Model(
            {**identification.parameters, "displacementZero": _zero_of(identification.parameters)},
            (),
            np.array([records[w.record].offset for w in self._windows]),
            {"initialDisplacement": np.array([self._begin(w, records) for w in self._windows])},
        )

    @staticmethod
    def _begin(window: Window, records: Sequence[Judgement]) -> float:
        """Return the displacement with which the paper's model begins a window."""
        result = records[window.record]
        if window.first == 0:
            return result.start["initialDisplacement"]
        return float(window.prepared.record.displacement[0]) - result.offset

    def _given(self, given: ParameterSet) -> Model:
        self._check_given(given)
        effects = tuple(active_effects(given))
        unknown = [e for e in self._declared if e in effects]
        self._declared = tuple(e for e in self._declared if e not in unknown)
        own = {
            name: np.full(len(self._windows), given[name])
            for name in by_record()
            if load_table().effect_of(name) in (None, *effects)
        }
        traces = self._searched()
        bench = Bench(traces, self._scaling, self._extent, traces)
        start = Model(dict(given), effects, np.zeros(len(traces)), own)
        # as it was given, to the last bit: its range may end where rounding makes it unusable
        return replace(bench.fit_own(start, traces), values=dict(given))

    def _check_given(self, given: ParameterSet) -> None:
        """Refuse a model that cannot be one of these records.

        Raises
        ------
        InputError
            If its sample time, its unit or its range differs from the records'.
        """
        name = f"the starting model '{given.name}'"
        if not np.isclose(given["sampleTime"], self._extent.sample_time, rtol=1e-3):
            raise InputError(
                f"{name} has a sampleTime of {given['sampleTime']:g} s, the records of "
                f"{self._extent.sample_time:g} s: resample them, or identify a model at their rate"
            )
        low, high = given.voltage_range
        beyond = COVERAGE.beyond_model * (high - low)
        record_low, record_high = self._extent.voltage
        if record_low < low - beyond or record_high > high + beyond:
            raise InputError(
                f"{name} is for {low:g} to {high:g} V (voltageMin, voltageMax), but the records go "
                f"from {record_low:g} to {record_high:g} V: check the range and the unit of the voltage"
            )
        travel = given.displacement_range[1] - given.displacement_range[0]
        share = (record_high - record_low) / (high - low)
        # a stage that rings spans more than it moves with the voltage
        spans = self._extent.displacement_span, _gain(self._train) * (record_high - record_low)
        ratios = [span / (share * travel) for span in spans]
        if not any(1.0 / COVERAGE.same_unit < ratio < COVERAGE.same_unit for ratio in ratios):
            raise InputError(
                f"{name} moves {1e6 * share * travel:.4g} µm over the records' voltages, the records "
                f"{1e6 * self._extent.displacement_span:.4g} µm: check the unit of the displacement"
            )

    def _traces(self, *roles: str, step: int = 1) -> list[Trace]:
        """Return records as traces; the first record's displacement is what the others are set to."""
        return [
            to_trace(every(p, step), role, self._has_offset and i > 0)
            for i, (role, p) in enumerate(self._prepared)
            if role in roles
        ]

    def _searched(self) -> list[Trace]:
        """Return the windows as traces."""
        return [to_trace(w.prepared, "train", self._has_offset and w.record > 0) for w in self._windows]

    def _bench(self, base: Model) -> Bench:
        """Return the bench of the search; keep that of the whole records, on which all is judged."""
        self._base_has_offset = self._has_offset = bool(np.any(base.offsets != 0.0))
        self._extent = replace(self._extent, zero=base.values["displacementZero"])
        fitted = self._traces("train")
        self._judging = replace(self._bench_of(fitted, 1), traces=fitted)
        return self._bench_of(self._searched(), self._step)

    def _bench_of(self, traces: list[Trace], step: int) -> Bench:
        deciding = self._traces("validation", step=step)
        parts = not deciding
        traces, deciding = set_aside(traces) if parts else steps_aside(traces, deciding)
        deciding = [within(t, self._extent.voltage) for t in deciding]
        extent = replace(self._extent, sample_time=step * self._extent.sample_time)
        return Bench(traces, self._scaling, extent, deciding, parts, self._model or {})

    def _declare(self, bench: Bench, base: Model) -> Model:
        """Return the model with the declared effects."""
        if not self._declared:
            return base
        # an effect is guessed from what the model leaves, which is its own unless it is fitted first
        fitted = bench.fit(base, FINISHING)
        model, missing = with_effects(
            bench,
            fitted.model if np.isfinite(fitted.minimum.cost) else base,
            self._declared,
            self._each,
            lambda effect: self._progress(0.25, f"declared: {effect}"),
        )
        if missing:
            raise InputError(
                f"'{missing[0]}' is declared, but the model with it diverges on the training "
                "records, whatever the initial guess; leave it out of --declared"
            )
        return model

    # --- search and final fit --------------------------------------------------------------------

    def _report_fit(self, model: str) -> None:
        # how many there will be depends on what is found: the bar slows down as it goes
        self._fits += 1
        self._progress(0.25 + 0.6 * (1.0 - np.exp(-self._fits / 60.0)), f"searching effects: {model}")

    def _finish(
        self, bench: Bench, node: Node, base: Model, others: Sequence[Node]
    ) -> tuple[ChainFit, Model, list[Model]]:
        """Return the last fit, and the first model and those of other nodes, of the whole records."""
        self._progress(0.87, "final fit")
        models = [base, *(other.fit.model for other in others)]
        if self._searches_all:
            self._judging, fit = last_fit(self._judging, node.fit.model, base)
        else:
            slow = replace(bench, traces=self._traces("train", step=self._step))
            whole = Whole(bench, slow, self._bench_of(self._judging.traces, 1), self._judging)
            last, models = whole.all_fitted(node.fit.model, base, models, self._each)
            self._judging, fit = last
        self._has_offset = any(t.has_offset for t in self._judging.traces)
        return fit, models[0], models[1:]

    # --- assessment ------------------------------------------------------------------------------

    def _assess(
        self, base: Model, bench: Bench, search: Search, chosen: Node, node: Node, fit: ChainFit
    ) -> Diagnosis:
        whole = Assessment(self._judging, self._prepared, self._of_whole_records, self._each)
        parameters = whole.parameters(fit.model, "diagnosed")
        judged = self._traces("train", "validation", "test")
        traces = list(self._each(partial(self._judging.with_lead_in, fit.model), judged))
        named = tuple(e for e in fit.model.effects if e in node.effects)
        groups = indistinguishable(chosen, search.rivals)
        if len(self._inseparable) > 1:
            groups = (*groups, self._inseparable)
        verdict = Verdict(
            search,
            node,
            named,
            groups,
            self._declared,
            self._inseparable,
            self._excluded,
            self._regulated,
            self._of_the_core,
        )
        after = whole.judgements(fit.model, traces)
        # what the model follows of a record is no noise, whatever was estimated before
        traces = [
            with_noise(t, NoiseEstimate(j.noise, j.noise_method))
            for t, j in zip(traces, after, strict=True)
        ]
        judged = [within(t, self._extent.voltage) for t in traces if t.role != "test"]
        if self._declared:  # fitted since its range was found
            base = whole.usable(base) or base
        left = whole.left_by(fit.model, judged, len(self._train))
        constants = [
            replace(t, has_offset=self._base_has_offset and i > 0) for i, t in enumerate(traces)
        ]
        before = whole.judgements(base, constants)
        uncertainty = assess(fit)
        rivals = whole.rivals(
            fit.model,
            node,
            [chosen, *search.rivals],
            lambda m: whole.left_by(m, judged, len(self._train)).significant,
        )
        return Diagnosis(
            parameters=parameters,
            base=whole.parameters(base, "before"),
            effects=named,
            declared=self._declared,
            unexplained=left.significant and all(r.unexplained for r in rivals),
            left_over=(*left.sentences, *whole.seen_in_tests(fit.model, traces)),
            indistinguishable=groups,
            experiments=tuple(deciding_experiment(group) for group in groups),
            noise_rms=float(np.sqrt(np.mean([t.noise**2 for t in judged]))),
            before=before,
            records=after,
            evidence=evidence_of(verdict, bench.clues(search.root.fit.model)),
            stages=whole.stages(search, node, fit, before, after, constants),
            intervals=uncertainty.intervals,
            undetermined=uncertainty.undetermined,
            stage_figures=stage_figures(fit, uncertainty),
            warnings=(
                *bound_sentences(fit, named),
                *whole.not_shown(fit.model),
                *whole.findings(after),
                *self._warnings,
            ),
            seconds=self._seconds,
            rivals=rivals,
        )


def _checked_effects(option: str, names: Sequence[str], extent: Extent) -> tuple[str, ...]:
    """Return the effects that an option names, in the order of the chain.

    Raises
    ------
    InputError
        If there is no such effect, or no record has the channel that it needs.
    """
    for name in names:
        if name not in EFFECTS:
            raise InputError(f"--{option} {name}: no such effect; {known_names(name, list(EFFECTS))}")
    for name in names if option == "declared" else ():
        channel = EVIDENCE[name].channel
        if channel and getattr(extent, channel) is None:
            column = f"{channel} channel ({channel}_{next(iter(UNITS[channel]))})"
            raise InputError(f"--declared {name}: no training record has a {column}")
    return tuple(e for e in EFFECTS if e in names)


def _gain(records: Sequence[Record]) -> float:
    """Return by how much the displacement of records follows their voltage where it is slow, m/V.

    It is the regression of one's running sum on the other's, in which what rings counts for little.
    """
    sums = [np.cumsum([c - c.mean() for c in (r.voltage, r.displacement)], axis=1) for r in records]
    moments = sum(s @ s.T for s in sums)
    return float(moments[0, 1] / moments[0, 0])


def _zero_of(parameters: ParameterSet) -> float:
    """Return what the sensor reads at rest at zero voltage, m: where the core is there.

    Beyond the displacements of the records the equilibrium curve goes on straight.
    """
    displacement = np.linspace(*parameters.displacement_range, 401)
    voltage = compiled.solve(parameters.rules, displacement, displacement)
    if voltage[0] <= 0.0 <= voltage[-1]:
        return float(np.interp(0.0, voltage, displacement))
    end = slice(0, 2) if voltage[0] > 0.0 else slice(-2, None)
    (x, _), (y, _) = voltage[end], displacement[end]
    return float(y - x * np.diff(displacement[end])[0] / np.diff(voltage[end])[0])
