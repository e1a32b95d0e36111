"""The identification of the paper's model from measured records, start to end."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from it2hys.errors import InputError
from it2hys.identification import usability
from it2hys.identification.coverage import coverage_warnings
from it2hys.identification.criteria import Series
from it2hys.identification.findings import coarse_readings, record_findings
from it2hys.identification.fitting import Fit, fit_rules, refit, shake
from it2hys.identification.lead_in import Misfit
from it2hys.identification.order import choose_rule_count, split
from it2hys.identification.prediction import explains_lead, judge, judge_new
from it2hys.identification.preparation import (
    Prepared,
    check_rule_count,
    check_sample_times,
    data_scaling,
    guess_offsets,
    largest_rule_count,
    prepare,
    to_series,
    too_short,
)
from it2hys.identification.result import (
    Identification,
    IdentificationError,
    Options,
    OrderTrial,
    RecordResult,
    Start,
)
from it2hys.identification.uncertainty import assess
from it2hys.identification.weights import weigh
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet
from it2hys.model.stages import EFFECTS
from it2hys.records import Record
from it2hys.records.figures_of_merit import noise_size, times_the_noise
from it2hys.support.progress import Progress

#: Offsets are kept if they lower the mean squared error by this share.
_OFFSET_GAIN = 0.1
#: Free-run error over noise from which on the report says that the model lacks something.
_LACKING = 1.5
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
        self._train = [prepare(r, options) for r in train]
        self._largest = largest_rule_count(self._train)
        if rule_count is not None and rule_count > self._largest:
            raise InputError(too_short(rule_count, self._train))
        self._others = [
            (role, prepare(r, options))
            for role, records in (("validation", validation), ("test", test))
            for r in records
        ]
        self._scaling = data_scaling(self._train)
        self._offsets = len(train) > 1 and options.offsets is not False
        self._orders: tuple[OrderTrial, ...] = ()
        self._warm: list[np.ndarray] = []
        self._seconds: dict[str, float] = {}

    def run(self) -> Identification:
        """Run all phases."""
        self._timed("number of rules", self._choose)
        fit = self._timed("fit", self._fit)
        fit = self._timed("second look", self._reconsider, fit)
        return self._timed("assessment", self._report, fit)

    def _timed(self, name: str, phase: Callable, *arguments: object):
        start = time.perf_counter()
        result = phase(*arguments)
        self._seconds[name] = time.perf_counter() - start
        return result

    def _series(self) -> list[Series]:
        series = [to_series(p, self._scaling) for p in self._train]
        return guess_offsets(series) if self._offsets else series

    def _choose(self) -> None:
        """Choose the number of rules if it is not given."""
        if self._rule_count is not None:
            return
        validation = [p for role, p in self._others if role == "validation"]
        fitted, decisive = split(self._series())
        if validation:
            fitted = self._series()
            decisive = [
                replace(to_series(p, self._scaling), has_offset=self._offsets) for p in validation
            ]
        chosen, trials = choose_rule_count(
            fitted,
            decisive,
            replace(self._options, max_rules=min(self._options.max_rules, self._largest)),
            lambda s, text: self._progress(0.5 * s, text),
        )
        self._rule_count, self._warm = len(chosen), [chosen]
        unit = self._scaling.y_unit
        self._orders = tuple(OrderTrial(t.rules, t.e_rms * unit) for t in trials)

    def _fit(self) -> Fit:
        done = 0.5 if self._orders else 0.0
        return fit_rules(
            self._series(),
            self._rule_count,
            self._options,
            lambda s, text: self._progress(done + (0.85 - done) * s, text),
            self._warm,
            self._each,
        )

    def _reconsider(self, fit: Fit) -> Fit:
        """Take back what the fitted model shows to have been unnecessary: discards and offsets."""
        if self._options.skip is None:
            fit = self._restore_leads(fit)
        if self._offsets and self._options.offsets is None:
            fit = self._drop_offsets(fit)
        fit = self._reweigh(fit)
        # an error of a few per cent of the noise decides what the model does on other records,
        # where the noise is all there is; a model that lacks something is not worth the time
        reaches_noise = fit.rms * self._scaling.y_unit < _LACKING * self._noise()
        rounds = _THOROUGH_ROUNDS if reaches_noise else _ROUNDS

        def tell(share: float, text: str) -> None:
            self._progress(0.85 + 0.1 * share, text)

        return shake(fit, rounds, self._options, tell, self._each)

    def _restore_leads(self, fit: Fit) -> Fit:
        """Fit the leading samples of records on which the model explains them."""
        restored = list(self._train)
        for i, p in enumerate(self._train):
            offset = fit.criterion.offsets(fit.minimum.coordinates)[i]
            if explains_lead(p, fit.rules, self._scaling, offset):
                restored[i] = replace(p, skip=0)
        if restored == self._train:
            return fit
        self._train = restored
        return refit(fit, self._series(), self._options)

    def _drop_offsets(self, fit: Fit) -> Fit:
        """Do without offsets unless they lower the error by far."""
        series = [to_series(p, self._scaling) for p in self._train]
        plain = refit(fit, series, self._options)
        if plain.minimum.cost * (1.0 - _OFFSET_GAIN) > fit.minimum.cost:
            return fit
        self._offsets = False
        return plain

    def _reweigh(self, fit: Fit) -> Fit:
        """Fit again with the records weighted by noise and novelty, if these differ."""
        noise, unit = self._noise(), self._scaling.y_unit
        misfit = np.sqrt(max((fit.rms * unit) ** 2 - noise**2, 0.0))
        if misfit < _LACKING * noise:
            misfit = 0.0
        series = weigh(fit.criterion.series, self._train, misfit, unit)
        return fit if series is None else refit(fit, series, self._options)

    def _noise(self) -> float:
        return float(np.sqrt(np.mean([p.noise.rms**2 for p in self._train])))

    def _usable_range(self, fit: Fit) -> tuple[float, float]:
        """Return the displacement range in m in which the model is usable.

        Raises
        ------
        IdentificationError
            If it does not even hold the training records.
        """
        low, high = (self._scaling.displacement(v) for v in self._data_range(fit))
        physical = self._scaling.physical_rules(fit.rules)
        usable = usability.widest_range(physical, low, high)
        if usable is None:
            fault = compiled.check(physical, low, high)
            raise IdentificationError(
                f"the fitted model is not usable over the range of the training records: {fault}"
            )
        return usable

    def _data_range(self, fit: Fit) -> tuple[float, float]:
        offsets = fit.criterion.offsets(fit.minimum.coordinates)
        return usability.data_range(fit.criterion.series, offsets)

    def _contraction(self, fit: Fit) -> tuple[float, float, float]:
        """Return the largest |dy(k)/dy(k-1)| over the band of the data, and where, scaled."""
        offsets = fit.criterion.offsets(fit.minimum.coordinates)
        return usability.largest_contraction(
            fit.rules, usability.Band.of_data(fit.criterion.series, offsets)
        )

    def _report(self, fit: Fit) -> Identification:
        self._progress(0.95, "assessment")
        usable = self._usable_range(fit)
        scaling, point = self._scaling, fit.minimum.coordinates
        uncertainty = assess(fit.criterion.with_guard(None), point, scaling)
        parameters = self._parameters(fit, usable)
        results = self._results(fit, parameters)
        identification = Identification(
            parameters=parameters,
            records=tuple(results),
            noise_rms=self._noise(),
            intervals=uncertainty.intervals,
            condition=uncertainty.condition,
            undetermined=uncertainty.undetermined,
            warnings=(
                *self._findings(results),
                *self._warnings(fit, usable),
                *uncertainty.sentences(),
            ),
            converged=fit.minimum.converged,
            message=fit.minimum.message,
            contraction=self._contraction(fit)[0],
            starts=tuple(
                Start(s.one_step_rms * scaling.y_unit, s.free_run_rms * scaling.y_unit)
                for s in fit.starts
            ),
            orders=self._orders,
            seconds=self._seconds,
        )
        self._progress(1.0, "done")
        return _with_lack(identification)

    def _findings(self, results: Sequence[RecordResult]) -> list[str]:
        """Return what there is to say of the records whatever the model."""
        records = [p.record for p in (*self._train, *(p for _, p in self._others))]
        return [
            *record_findings(records),
            *coarse_readings(records, [r.noise_rms for r in results], results),
        ]

    def _parameters(self, fit: Fit, usable: tuple[float, float]) -> ParameterSet:
        scaling = self._scaling
        state = fit.criterion.states(fit.minimum.coordinates)[0]
        voltages = [p.record.voltage for p in self._train]
        return ParameterSet.from_rules(
            scaling.physical_rules(fit.rules),
            name="identified",
            sampleTime=self._train[0].record.sample_time,
            initialDisplacement=float(scaling.displacement(state)),
            voltageMin=float(min(v.min() for v in voltages)),
            voltageMax=float(max(v.max() for v in voltages)),
            displacementMin=float(usable[0]),
            displacementMax=float(usable[1]),
            **{n: v for e in EFFECTS.values() for n, v in e.over_range(*map(float, usable)).items()},
        )

    def _results(self, fit: Fit, parameters: ParameterSet) -> list[RecordResult]:
        scaling, point = self._scaling, fit.minimum.coordinates
        states, offsets = fit.criterion.states(point), fit.criterion.offsets(point)
        fitted = [
            judge(p, "train", parameters, scaling, s, o)
            for p, s, o in zip(self._train, states, offsets, strict=True)
        ]
        allowed = self._offsets or bool(self._options.offsets)
        residuals = [
            (p.record.displacement - r.y_free)[r.used] for p, r in zip(self._train, fitted, strict=True)
        ]
        misfit = Misfit.of(residuals, [r.noise_rms for r in fitted])
        return fitted + [
            judge_new(self._with_lead(p, fit), role, parameters, scaling, allowed, misfit)
            for role, p in self._others
        ]

    def _with_lead(self, prepared: Prepared, fit: Fit) -> Prepared:
        """Return a record that was not fitted, its lead included if the model explains it."""
        if self._options.skip is None and explains_lead(prepared, fit.rules, self._scaling):
            return replace(prepared, skip=0)
        return prepared

    def _warnings(self, fit: Fit, usable: tuple[float, float]) -> list[str]:
        warnings = coverage_warnings(self._train, [p for _, p in self._others])
        low, high = (self._scaling.displacement(v) for v in self._data_range(fit))
        margin = 0.99 * usability.MARGIN * (high - low)
        if usable[0] > low - margin or usable[1] < high + margin:
            warnings.append(
                "Beyond the range of the training records the model soon stops contracting or "
                "being invertible: it is usable from "
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


def _with_lack(identification: Identification) -> Identification:
    """Add a warning that says plainly how far the error is above the noise."""
    ratio = identification.error_over_noise
    if not ratio > _LACKING:
        return identification
    error = ratio * identification.noise_rms
    text = (
        f"The free-run error on the training records, {error * 1e6:.3g} µm rms, is "
        f"{times_the_noise(ratio)} ({noise_size(identification.noise_rms)}): the model lacks something "
        "that the records contain."
    )
    return replace(identification, warnings=(*identification.warnings, text))
