"""The identification of the paper's model from measured records, start to end."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from it2hys.errors import InputError
from it2hys.identification import usability
from it2hys.identification.coverage import coverage_warnings
from it2hys.identification.criterion import Trace
from it2hys.identification.findings import coarse_readings, record_findings
from it2hys.identification.judgement import Judgement, judge_records
from it2hys.identification.order import choose_rule_count, fit_begin, split
from it2hys.identification.preparation import (
    Prepared,
    check_rule_count,
    check_sample_times,
    data_scaling,
    largest_rule_count,
    prepare,
    too_short,
)
from it2hys.identification.result import (
    Identification,
    IdentificationError,
    Options,
    OrderTrial,
)
from it2hys.identification.rule_search import RuleFit, fit_rules, refit, shake
from it2hys.identification.stage_figures import stage_figures
from it2hys.identification.starts import Starts
from it2hys.identification.traces import extent_of, guess_offsets, plain_trace, to_trace
from it2hys.identification.uncertainty import assess
from it2hys.identification.weights import weigh
from it2hys.model.parameters import ParameterSet
from it2hys.model.stages import EFFECTS
from it2hys.policy import CORE, COVERAGE, NOISE
from it2hys.records import Record
from it2hys.records.figures_of_merit import noise_size, times_the_noise
from it2hys.support.progress import Progress

#: Errors below this share of half the travel count as none.
_RESOLUTION = 1e-6
#: Rounds of disturbing the best fit: for a model that lacks something, and for one that does not.
_ROUNDS, _THOROUGH_ROUNDS = 1, 4


def identify(
    train: Sequence[Record],
    validation: Sequence[Record] = (),
    test: Sequence[Record] = (),
    rules: int | None = None,
    options: Options | None = None,
    progress: Progress | None = None,
    each: Callable = map,
) -> Identification:
    """Identify the IT2 model (10) from records.

    Parameters
    ----------
    train : sequence of Record
        Records that are fitted, each with its own initial state.
    validation : sequence of Record
        Records that decide on the number of rules. Without any, the last 30 % of every training
        record decide, and are fitted once the number is chosen.
    test : sequence of Record
        Records that decide nothing and are only reported on.
    rules : int, optional
        Number of rules L; chosen if not given.
    options : Options, optional
    progress : callable, optional
        Called with the share done, 0 to 1, and what is being done.
    each : callable
        A `map`; one over processes shares the fits among them. The result does not depend on it.

    Returns
    -------
    Identification
        Write its parameters only if `converged`.

    Raises
    ------
    InputError
        If there are no training records, their sample times differ, they have too few samples
        that can be trusted, or `rules` is no number of rules.
    IdentificationError
        If no usable model was found.
    """
    if not train:
        raise InputError("no training record is given")
    check_rule_count(rules)
    options = options or Options()
    progress = progress or (lambda share, text: None)
    check_sample_times([*train, *validation, *test])
    return _Session(train, validation, test, rules, options, progress, each).run()


class _Session:
    """One identification: what its phases hand on to each other."""

    def __init__(
        self,
        train: Sequence[Record],
        validation: Sequence[Record],
        test: Sequence[Record],
        rule_count: int | None,
        options: Options,
        progress: Progress,
        each: Callable,
    ):
        self._options, self._progress, self._rule_count = options, progress, rule_count
        self._each = each
        self._train = [prepare(r) for r in train]
        self._largest = largest_rule_count(self._train)
        if rule_count is not None and rule_count > self._largest:
            raise InputError(too_short(rule_count, self._train))
        self._others = [
            (role, prepare(r))
            for role, records in (("validation", validation), ("test", test))
            for r in records
        ]
        self._scaling = data_scaling(self._train)
        self._has_offset = len(train) > 1
        self._orders: tuple[OrderTrial, ...] = ()
        self._warm: list[np.ndarray] = []
        self._seconds: dict[str, float] = {}

    def run(self) -> Identification:
        """Run all phases."""
        self._timed("number of rules", self._choose)
        fit = self._timed("fit", self._fit)
        fit = self._timed("repeated fit", self._reconsider, fit)
        return self._timed("assessment", self._report, fit)

    def _timed(self, name: str, phase: Callable, *arguments: object):
        start = time.perf_counter()
        result = phase(*arguments)
        self._seconds[name] = time.perf_counter() - start
        return result

    def _traces(self, prepared: Sequence[Prepared]) -> list[Trace]:
        """Return training records as traces; the first one's displacement is what others are set to."""
        return [plain_trace(p, "train", self._has_offset and i > 0) for i, p in enumerate(prepared)]

    def _guesses(self, traces: Sequence[Trace]) -> np.ndarray:
        """Return guesses of the training records' constants, m."""
        return guess_offsets(traces, self._scaling) if self._has_offset else np.zeros(len(traces))

    def _choose(self) -> None:
        """Choose the number of rules if it is not given."""
        if self._rule_count is not None:
            return
        traces = self._traces(self._train)
        validation = [p for role, p in self._others if role == "validation"]
        fitted, decisive = split(traces)
        if validation:
            fitted = traces
            decisive = [plain_trace(p, "validation", self._has_offset) for p in validation]
        chosen, self._orders = choose_rule_count(
            fitted,
            decisive,
            self._scaling,
            self._guesses(fitted),
            self._largest,
            self._options,
            lambda s, text: self._progress(0.5 * s, text),
        )
        self._rule_count, self._warm = len(chosen), [chosen]

    def _fit(self) -> RuleFit:
        done = 0.5 if self._orders else 0.0
        traces = self._traces(self._train)
        return fit_rules(
            traces,
            self._scaling,
            self._guesses(traces),
            self._rule_count,
            self._options,
            lambda s, text: self._progress(done + (0.85 - done) * s, text),
            self._warm,
            self._each,
        )

    def _reconsider(self, fit: RuleFit) -> RuleFit:
        """Take back what the fitted model shows to have been unnecessary: discards and offsets."""
        fit = self._restore_leads(fit)
        if self._has_offset:
            fit = self._drop_offsets(fit)
        fit = self._reweigh(fit)
        # an error of a few per cent of the noise decides what the model does on other records,
        # where the noise is all there is; a model that lacks something is not worth the time
        reaches_noise = fit.rms * self._scaling.y_unit < NOISE.lacking * self._noise()
        rounds = _THOROUGH_ROUNDS if reaches_noise else _ROUNDS

        def tell(share: float, text: str) -> None:
            self._progress(0.85 + 0.1 * share, text)

        return shake(fit, rounds, self._options, tell, self._each)

    def _restore_leads(self, fit: RuleFit) -> RuleFit:
        """Fit the leading samples of records on which the model explains them."""
        restored = list(self._train)
        for i, p in enumerate(self._train):
            if _explains_lead(p, fit, fit.model.offsets[i]):
                restored[i] = replace(p, skip=0)
        if restored == self._train:
            return fit
        self._train = restored
        return refit(fit, self._traces(restored), self._options)

    def _drop_offsets(self, fit: RuleFit) -> RuleFit:
        """Do without offsets unless they lower the error by far."""
        traces = [plain_trace(p, "train") for p in self._train]
        plain = refit(fit, traces, self._options)
        if plain.minimum.cost * (1.0 - COVERAGE.offset_gain) > fit.minimum.cost:
            return fit
        self._has_offset = False
        return plain

    def _reweigh(self, fit: RuleFit) -> RuleFit:
        """Fit again with the records weighted by noise and novelty, if these differ."""
        noise, unit = self._noise(), self._scaling.y_unit
        misfit = np.sqrt(max((fit.rms * unit) ** 2 - noise**2, 0.0))
        if misfit < NOISE.lacking * noise:
            misfit = 0.0
        traces = weigh(fit.criterion.traces, self._train, misfit, unit)
        return fit if traces is None else refit(fit, traces, self._options)

    def _noise(self) -> float:
        return float(np.sqrt(np.mean([p.noise.rms**2 for p in self._train])))

    def _usable_range(self, fit: RuleFit) -> tuple[float, float]:
        """Return the displacement range in m in which the model is usable.

        Raises
        ------
        IdentificationError
            If it does not even hold the training records.
        """
        low, high = (self._scaling.displacement(v) for v in usability.data_range(fit.courses))
        physical = self._scaling.physical_rules(fit.rules)
        usable = usability.widest_range(physical, low, high)
        if usable is None:
            found = record_findings([p.record for p in self._train])
            raise IdentificationError(
                "no model that fits the training records has an inverse over their range. "
                + (" ".join(found) or "Give records that cover the range better")
            )
        return usable

    def _contraction(self, fit: RuleFit) -> tuple[float, float, float]:
        """Return the largest |dy(k)/dy(k-1)| over the band of the data, and where, scaled."""
        return usability.largest_contraction(fit.rules, usability.Band.of_data(fit.courses))

    def _report(self, fit: RuleFit) -> Identification:
        self._progress(0.95, "assessment")
        usable = self._usable_range(fit)
        uncertainty = assess(fit)
        parameters = self._parameters(fit, usable)
        results = self._results(fit, parameters)
        identification = Identification(
            parameters=parameters,
            records=results,
            noise_rms=float(np.sqrt(np.mean([r.noise**2 for r in results if r.role == "train"]))),
            intervals={**uncertainty.intervals, **uncertainty.starts},
            condition=uncertainty.condition,
            undetermined=uncertainty.undetermined,
            stage_figures=stage_figures(fit, uncertainty),
            warnings=(
                *self._findings(results),
                *self._warnings(fit, usable),
                *uncertainty.sentences(),
            ),
            converged=fit.minimum.converged,
            message=fit.minimum.message,
            contraction=self._contraction(fit)[0],
            starts=fit.starts,
            orders=self._orders,
            seconds=self._seconds,
        )
        self._progress(1.0, "done")
        return _with_lack(identification)

    def _findings(self, results: Sequence[Judgement]) -> list[str]:
        """Return the findings on the records that hold for any model."""
        records = [p.record for p in (*self._train, *(p for _, p in self._others))]
        return [
            *record_findings(records),
            *coarse_readings(records, [r.noise for r in results], results),
        ]

    def _parameters(self, fit: RuleFit, usable: tuple[float, float]) -> ParameterSet:
        scaling = self._scaling
        voltages = [p.record.voltage for p in self._train]
        return ParameterSet.from_rules(
            scaling.physical_rules(fit.rules),
            name="identified",
            sampleTime=self._train[0].record.sample_time,
            **fit.model.start(0),
            voltageMin=float(min(v.min() for v in voltages)),
            voltageMax=float(max(v.max() for v in voltages)),
            displacementMin=float(usable[0]),
            displacementMax=float(usable[1]),
            **{n: v for e in EFFECTS.values() for n, v in e.over_range(*map(float, usable)).items()},
        )

    def _results(self, fit: RuleFit, parameters: ParameterSet) -> tuple[Judgement, ...]:
        records = [p.record for p in self._train]
        starts = Starts(fit.criterion.traces, self._scaling, extent_of(records))
        every = [*(("train", p) for p in self._train), *self._others]
        traces = [to_trace(p, role, self._has_offset and i > 0) for i, (role, p) in enumerate(every)]
        traces = list(self._each(partial(starts.with_lead_in, fit.model), traces))
        return judge_records(starts, fit.model, parameters, traces, self._each)

    def _warnings(self, fit: RuleFit, usable: tuple[float, float]) -> list[str]:
        warnings = coverage_warnings(self._train, [p for _, p in self._others])
        low, high = (self._scaling.displacement(v) for v in usability.data_range(fit.courses))
        margin = 0.99 * CORE.margin * (high - low)
        if usable[0] > low - margin or usable[1] < high + margin:
            warnings.append(
                "Little beyond the range of the training records the model no longer contracts or can "
                "no longer be inverted: it is admissible from "
                f"{usable[0] * 1e6:.4g} to {usable[1] * 1e6:.4g} µm."
            )
        contraction, y, x = self._contraction(fit)
        if contraction >= 1.0:
            warnings.append(
                f"|dy(k)/dy(k-1)| reaches {contraction:.3g} at "
                f"{self._scaling.displacement(y) * 1e6:.4g} µm and {self._scaling.voltage(x):.4g} "
                "V, within the margin around the training records: runs from different states "
                "drift apart there."
            )
        return warnings


def _explains_lead(prepared: Prepared, fit: RuleFit, offset: float) -> bool:
    """Return whether a fit explains the discarded lead of a record as well as the rest.

    `offset` is the record's constant, m.
    """
    if prepared.skip == 0:
        return False
    whole = plain_trace(replace(prepared, skip=0), "train")
    whole = replace(whole, y=whole.y - offset)
    begun = fit_begin(fit.rules, whole, fit.criterion.scaling)
    error = np.abs(begun.model.predict(whole, 0) - whole.y)
    in_lead, used = np.arange(len(error)) < prepared.skip, whole.weight > 0
    lead, rest = error[in_lead & used], error[~in_lead & used]
    floor = _RESOLUTION * fit.criterion.scaling.y_unit
    return bool(
        np.sqrt(np.mean(lead**2)) <= COVERAGE.explained_lead * np.sqrt(np.mean(rest**2)) + floor
        and np.max(lead, initial=0.0) <= COVERAGE.explained_lead * np.max(rest) + floor
    )


def _with_lack(identification: Identification) -> Identification:
    """Add a warning that says plainly how far the error is above the noise."""
    ratio = identification.error_over_noise
    if not ratio > NOISE.lacking:
        return identification
    error = ratio * identification.noise_rms
    text = (
        f"The free-run error on the training records, {error * 1e6:.3g} µm rms, is "
        f"{times_the_noise(ratio)} ({noise_size(identification.noise_rms)}): the model lacks something "
        "that the records contain."
    )
    return replace(identification, warnings=(*identification.warnings, text))
