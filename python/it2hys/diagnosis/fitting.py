"""Fits of chains to records: joint ones of everything, and of what belongs to a record alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from math import ceil

import numpy as np
from scipy.stats import chi2, median_abs_deviation

from it2hys.diagnosis.comparison import compare
from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.residuals import LeftOver, left_over
from it2hys.diagnosis.variants import (
    behind_gain,
    sampled_otherwise,
    shifted,
    with_another_rule,
    with_effect,
)
from it2hys.identification.criterion import ChainFit, Model, Trace, minimise, with_rules
from it2hys.identification.inverse import inverse_error, least_inverse_error
from it2hys.identification.result import IdentificationError, Options
from it2hys.identification.rule_search import search_rules
from it2hys.identification.starts import (
    Starts,
    at_rest,
    memories,
    sampling_delay,
    with_histories,
)
from it2hys.identification.traces import stays
from it2hys.identification.uncertainty import correlation_time
from it2hys.model.compiled import Drive
from it2hys.model.stages import EFFECTS
from it2hys.model.variables import load_table
from it2hys.policy import NOISE, SEARCH, STARTS
from it2hys.support.processes import LONG, called, thread_map

#: Such parts of a sample: from one to another the cost goes up and down where a slew limit sets in.
_SHIFTS = (0.01, 0.99)
#: Guesses of an effect that the rules imitate for which those are sought anew, the starts of each, the
#: iterations with everything free after which the best are chosen, and how many are fitted on. Where an
#: effect is much of what a stage does, the cost falls but near the truth: of 10 time constants of a
#: lag, only one led to it.
_ANEW, _ANEW_STARTS, _ANEW_BEGUN, _ANEW_SETTLED = 10, 1, 10, 4
#: Starts where the effects' parameters are known already.
_STARTS = 12
#: Guesses of an effect that are followed, and the iterations of the two rounds; those from new rules.
_FOLLOWED, _SIFTING, _SETTLING = 3, 6, 25
_SETTLING_ANEW = 60
#: Iterations of a fit with more than most records show: weights of many operators settle slowly.
_SETTLING_FAR = 150
#: Costs of fits that are as good as the best one, as a multiple of its.
_ALIKE = 1.02
#: Share of a bound up to which a value is on it: it goes there and back through its coordinate.
_ROUNDING = 1e-9
#: Rows of the Jacobian by which guesses are compared.
_ROWS = 20_000
#: No range limits an inverse.
UNLIMITED = {
    "displacementMin": -np.inf, "displacementMax": np.inf, "voltageMin": -np.inf, "voltageMax": np.inf,
}  # fmt: skip


def _behind_turns(trace: Trace) -> np.ndarray:
    """Return which changes from sample to sample, (N - 1,), are behind sharp turns of the voltage."""
    turning = np.abs(np.diff(trace.drive.voltage, n=2))
    sharpest = np.argsort(-turning, kind="stable")[: ceil(SEARCH.sharpest * len(turning))]
    sharpest = sharpest[turning[sharpest] > 0.0]
    behind = np.zeros(len(trace.y) - 1, dtype=bool)
    for later in range(1, SEARCH.behind + 1):
        behind[np.minimum(sharpest + later, len(behind) - 1)] = True
    return behind & trace.judged[1:] & trace.judged[:-1]


def _loss(error: np.ndarray, other: np.ndarray) -> float:
    """Return by how much a record is less likely by other errors: twice the logarithm of the ratio.

    Of as many samples as are independent: what a model misses of a record is alike in many of them, and
    starts that are fitted one by one take up some of it.
    """
    powers = np.maximum([np.mean(other**2), np.mean(error**2)], np.finfo(float).tiny)
    return len(error) / correlation_time(error) * float(np.log(powers[0] / powers[1]))


def _root_mean_square(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def excess(rms: float, noise: float) -> float:
    """Return what of an error is not noise; less than a part of the noise cannot be told."""
    return float(np.sqrt(max(rms**2 - noise**2, (SEARCH.least_excess * noise) ** 2)))


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of a pair of model and inverse on records, arrays of the judged samples, m.

    Parameters
    ----------
    free : list of ndarray
        Of the free run.
    band, wide : list of ndarray
        Of the inverse fed with the measured displacement, by the plant's gain, with either reference.
    """

    free: list[np.ndarray]
    band: list[np.ndarray]
    wide: list[np.ndarray]


@dataclass(frozen=True, eq=False)
class Bench(Starts):
    """The records, and how models are fitted to and judged on them.

    Parameters
    ----------
    deciding : list of Trace
        Records, or parts of them, that decide between models.
    parts : bool
        Whether `deciding` are parts of the same records, which were not fitted.
    known : Mapping of str to float
        Parameters of a model that was given: other records may have shown them.
    """

    deciding: list[Trace]
    parts: bool = False
    known: Mapping[str, float] = field(default_factory=dict)

    def excess_fitted(self, fit: ChainFit) -> float:
        """Return what of a fit's error on the training records is not noise, m rms."""
        return excess(fit.rms * self.scaling.y_unit, _root_mean_square([t.noise for t in self.traces]))

    @property
    def _shared(self) -> Callable:
        """What maps over fits; see `thread_map`."""
        return thread_map if sum(len(t.y) for t in self.traces) >= LONG else map

    @property
    def floor(self) -> float:
        """Noise of the records that decide, m rms."""
        return _root_mean_square([t.noise for t in self.deciding])

    def fit(
        self, model: Model, iterations: int, strength: float = 1.0, held: Sequence[str] = ()
    ) -> ChainFit:
        """Fit everything jointly from a model, but for what is `held`.

        `strength` is that of the penalties for a poor core.
        """
        return minimise(self.criterion(model).holding(held).guarded(strength), iterations)

    def finish(self, model: Model, iterations: int, held: Sequence[str] = ()) -> ChainFit:
        """Fit everything jointly to the end, on two ways of which the better one counts.

        The penalties for a poor core bar the way where the core is poor for a while on it: one fit is
        held by them from the beginning, one only once it has arrived without them.
        """
        free = minimise(self.criterion(model).holding(held), iterations)
        starts = [model]
        if np.isfinite(free.minimum.cost):
            guarded = self.criterion(free.model).holding(held).guarded(1.0)
            if not guarded.penalised(free.minimum.coordinates):
                return ChainFit(guarded, free.minimum)
            starts.append(free.model)
        fits = self._shared(partial(self.fit, iterations=iterations, held=held), starts)
        return min(fits, key=lambda fit: fit.minimum.cost)

    def rested(self, fit: ChainFit, iterations: int, found: Model | None = None) -> ChainFit:
        """Return the fit with all records begun after long rest, if that is as good or worse by chance.

        Or if the records that decide are foretold better by it. What is fitted to each record takes up
        a part of what the effects do, and leads them astray: a model that was `found` with its records
        at rest is a better start than what came of that.
        """
        if fit.model.rested or not memories(fit.model):
            return fit
        starts = [at_rest(fit.model)]
        if found is not None and found.rested:
            starts.append(replace(found, offsets=fit.model.offsets))
        fits = self._shared(partial(self.fit, iterations=iterations), starts)
        other = min(fits, key=lambda fit: fit.minimum.cost)
        return other if self.is_as_good(other, fit) else fit

    def is_as_good(self, other: ChainFit, fit: ChainFit) -> bool:
        """Return whether a fit with records begun after long rest is as good as another one.

        It is so by its cost, by what it leaves of the records, by chance where the other one has starts
        of its own, or because it foretells what decides better.
        """
        if not np.isfinite(other.minimum.cost):
            return False
        if other.minimum.cost <= _ALIKE * fit.minimum.cost:
            return True
        # by the residuals alone: the cost also has priors on parameters that a fit holds
        pairs = zip(self.residuals(fit.model), self.residuals(other.model), strict=True)
        loss = sum(_loss(*pair) for pair in pairs)
        freedom = 0 if fit.model.rested else len(memories(fit.model)) * len(self.traces)
        if loss <= 0.0 or (freedom and chi2.sf(loss, freedom) > STARTS.rested):
            return True
        # these odds are those of a model that misses nothing: what else starts fit shows elsewhere
        return compare(self.errors(fit.model).free, self.errors(other.model).free).refines

    def without_unseen(self, fit: ChainFit) -> ChainFit:
        """Return the fit without what its records do not show: it would act on others.

        A limit of the voltage may end where no record goes, or take up noise just below where the one
        ends that goes farthest; one that goes further would be cut off. It has to make its records as
        much likelier as Schwarz's criterion asks of a parameter.
        """
        model, point = fit.model, fit.minimum.coordinates.copy()
        found: dict[str, float] = {}
        for effect in model.effects:
            found |= EFFECTS[effect].nowhere(self.extent)
        found = {n: v for n, v in found.items() if not self._shows(model, n, v)}
        first = fit.criterion.places_of_common.start
        for place, c in enumerate(fit.criterion.common, first):
            if c.name in found:
                point[place] = c.of_value(found[c.name])
        return replace(fit, minimum=replace(fit.minimum, coordinates=point)) if found else fit

    def _shows(self, model: Model, name: str, nowhere: float) -> bool:
        """Return whether a parameter is known, or its records show it by its value against another."""
        if np.isclose(model.values[name], self.known.get(name, nowhere)):
            return True
        errors = self.residuals(model)
        others = self.residuals(replace(model, values={**model.values, name: nowhere}))
        loss = sum(_loss(*pair) for pair in zip(errors, others, strict=True))
        return loss > np.log(sum(map(len, errors)))

    def _rough_fit(self, model: Model, iterations: int) -> ChainFit:
        """Fit as `fit`, as far as it takes to compare the result with others."""
        criterion = self.criterion(model).guarded(1.0)
        return minimise(criterion, iterations, criterion.rough_tolerance)

    def resampled(self, fit: ChainFit) -> ChainFit:
        """Return the fit, or a better one from the other end of the part of a sample beside an effect.

        The end at which that was found may be that of a model that lacked something, or had too much.
        """
        model = fit.model
        names = {sampling_delay(model, e) for e in model.effects if EFFECTS[e].sampled}
        for name in sorted(filter(None, names)):
            share = model.values[name] / model.values["sampleTime"]
            farther = max(_SHIFTS, key=lambda end, share=share: abs(end - share))
            other = self._rough_fit(shifted(model, name, farther), _SETTLING)
            fit = min(fit, other, key=lambda f: f.minimum.cost)
        return fit

    def add(self, model: Model, effect: str) -> ChainFit | None:
        """Fit a model with one effect more, from the best of the guesses of it.

        Parameters
        ----------
        model : Model
        effect : str

        Returns
        -------
        ChainFit or None
            None where the records cannot show the effect, or every guess diverges.
        """
        fit = self._first_fit(model, effect)
        if fit is None:
            return None
        again = self._best(fit.model, self._without_idleness(fit, effect))
        # a limit at the very end of the records takes up a little of the noise, and is none
        if again and _ALIKE * again.minimum.cost < fit.minimum.cost:
            fit = again
        fits = [fit]
        name = sampling_delay(fit.model, effect)
        if EFFECTS[effect].sampled and name:
            delayed = [shifted(fit.model, name, share) for share in _SHIFTS]
            trials = [*delayed, *sampled_otherwise(fit, effect)]
            fits += self._shared(partial(self._rough_fit, iterations=_SETTLING), trials)
        return self.preferred(fits)

    def _first_fit(self, model: Model, effect: str) -> ChainFit | None:
        """Fit from the best guess, with more than most records show only where that ends far better."""
        evidence, clues = EVIDENCE[effect], self.clues(model)
        by_shape = evidence.guessed_by_shape
        fit = self._best(model, self._guessed(model, effect, evidence.guesses(clues)), by_shape)
        trials = self._guessed(model, effect, evidence.further_guesses(clues))
        further = self._best(model, trials, by_shape) if trials else None
        if not (fit and further):
            return fit or further
        # rules that made up for the effect hide which is better; neither way always gets out of that
        ways = [
            partial(way, f.model)
            for f in (fit, further)
            for way in (self.reshaped, partial(self.finish, iterations=_SETTLING_FAR))
        ]
        costs = [ended.minimum.cost for ended in self._shared(called, ways)]
        return further if min(costs[2:]) < SEARCH.far_better * min(costs[:2]) else fit

    def preferred(self, fits: Sequence[ChainFit]) -> ChainFit:
        """Return of the fits that are as good as the best one that with the calmest inverse.

        Where the records have little that is fast, a slow core waits as a delay does, and its inverse
        enlarges whatever is fast in a reference.
        """
        least = min(fit.minimum.cost for fit in fits)
        alike = [fit for fit in fits if fit.minimum.cost <= _ALIKE * least]
        return min(alike, key=self._unrest) if len(alike) > 1 else alike[0]

    def inverts_well(self, error: float, traces: Sequence[Trace]) -> bool:
        """Return whether an inverse's error, m rms, is small beside the travel, or near the noise."""
        noise = float(np.sqrt(np.mean([t.noise**2 for t in traces])))
        small = SEARCH.inverse_small * self.extent.displacement_span
        return error <= max(small, SEARCH.noisy * noise)

    def _unrest(self, fit: ChainFit) -> float:
        """Return the error of the inverse with the wide reference on the training records, m."""
        model = fit.model
        judged = self._inverted(self.traces, "wide")
        errors = [
            self._inverse_error(model, t, i, "wide")[judged[i]] for i, t in enumerate(self.traces)
        ]
        return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))

    def _without_idleness(self, fit: ChainFit, effect: str) -> list[Model]:
        """Return the model with guesses for what of an effect went to a bound.

        It may do nothing there: such as the limit at one end, where only that at the other was found.
        """
        idle = self._idle(fit, effect)
        guesses = EVIDENCE[effect].guesses(self.clues(fit.model)) if idle else []
        values = {tuple(guess[name] for name in idle) for guess in guesses if {*idle} <= {*guess}}
        return [
            replace(fit.model, values={**fit.model.values, **dict(zip(idle, v, strict=True))})
            for v in sorted(values)
        ]

    def _idle(self, fit: ChainFit, effect: str) -> list[str]:
        """Return what of an effect, but for terms of a series, went to a bound."""
        of_effect = load_table().parameters()
        return [
            c.name
            for c in fit.criterion.common
            if of_effect[c.name].effect == effect
            and of_effect[c.name].group is None
            and np.any(np.isclose(fit.model.values[c.name], c.bounds, rtol=_ROUNDING, atol=0.0))
        ]

    def add_anew(self, model: Model, effect: str) -> ChainFit | None:
        """Fit as `add`, with the rules sought anew for some of the guesses.

        Where the rules imitate the effect, no descent leads to where the effect does it.
        """
        clues = self.clues(model)
        trials = self._guessed(model, effect, EVIDENCE[effect].guesses(clues))
        kept = EVIDENCE[effect].promising(clues, [t.values for t in trials])
        trials = [trials[i] for i in kept]
        spread = np.unique(np.linspace(0, len(trials) - 1, _ANEW).round().astype(int))
        anew = partial(self._with_rules_anew, starts=_ANEW_STARTS)
        starts = [fit.model for fit in self._shared(anew, [trials[i] for i in spread])]
        # rules that are fitted by themselves favour a slow core: a few iterations tell what leads far
        fits = self._shared(partial(self._rough_fit, iterations=_ANEW_BEGUN), starts)
        fits = sorted(fits, key=lambda fit: fit.minimum.cost)
        settled = list(self._shared(self._settled, fits[:_ANEW_SETTLED]))
        return self.preferred(settled) if settled else None

    def _guessed(self, model: Model, effect: str, guesses: Sequence[Mapping]) -> list[Model]:
        return [self._prepared(with_effect(model, effect, g, self.extent), effect) for g in guesses]

    def leaves_noise(self, fit: ChainFit) -> bool:
        """Return whether the residual of the training records is indistinguishable from noise."""
        left = self._left_over(fit)
        return left.size <= NOISE.reached or (left.size <= NOISE.nearly and left.p_value > NOISE.level)

    def is_near_noise(self, fit: ChainFit) -> bool:
        """Return whether the residual of every record is hardly larger than its noise."""
        if self._left_over(fit).size > NOISE.nearly:
            return False
        deciding = np.concatenate(self.errors(fit.model).free)
        return bool(np.sqrt(np.mean(deciding**2)) <= NOISE.nearly * self.floor)

    def _left_over(self, fit: ChainFit) -> LeftOver:
        return left_over(self.clues(fit.model), [t.noise for t in self.traces])

    def add_rule(self, model: Model) -> ChainFit | None:
        """Fit a model with one rule more, from the best way of splitting one in two."""
        if model.values["ruleCount"] >= load_table().counts["rule"]["maximum"]:
            return None
        distance = 0.05 * self.extent.displacement_span
        rules = range(int(model.values["ruleCount"]))
        return self._best(model, [with_another_rule(model, i, distance) for i in rules])

    def _best(self, model: Model, trials: list[Model], by_shape: bool = False) -> ChainFit | None:
        if len(trials) > _FOLLOWED:
            costs = self._projected_costs(model, trials, by_shape)
            trials = [trials[i] for i in np.argsort(costs)[:_FOLLOWED]]
        fits = self._shared(partial(self._rough_fit, iterations=_SIFTING), trials)
        fits = [fit for fit in fits if np.isfinite(fit.minimum.cost)]
        if not fits:
            return None
        best = min(fits, key=lambda fit: fit.minimum.cost)
        # the penalties are those of where its core was to go then: they may lead it astray from there
        return min(best, self._rough_fit(best.model, _SETTLING), key=lambda fit: fit.minimum.cost)

    def _prepared(self, model: Model, effect: str) -> Model:
        if gain := EVIDENCE[effect].gain_at_rest(model.values):
            model = behind_gain(model, gain, self.traces)
        return with_histories(model, self.traces)

    @np.errstate(over="ignore", invalid="ignore")
    def _projected_costs(self, model: Model, trials: list[Model], by_shape: bool) -> np.ndarray:
        """Return for each trial the cost that is left once the model's own parameters adapt, linearly.

        No trial is fitted for this: the residual's part in the span of the model's Jacobian is what
        those parameters can take up. By shape, what a trial changes may have any size and sign. A model
        whose run is on its way to infinity takes up nothing.
        """
        criterion = self.criterion(model)
        linear = criterion.jacobian(criterion.pack(model))
        step = max(1, sum(np.count_nonzero(t.weight) for t in self.traces) // _ROWS)
        basis = np.linalg.qr(linear[0][::step])[0] if linear else None

        def left_by(trial: Model) -> np.ndarray:
            residual = np.concatenate(self.residuals(trial))[::step] / self.scaling.y_unit
            return residual if basis is None else residual - basis @ (basis.T @ residual)

        costs, before = [], left_by(model)
        for trial in trials:
            left = left_by(trial)
            if by_shape:
                change = left - before
                left = before - (before @ change) / (change @ change) * change
            cost = left @ left
            costs.append(cost if np.isfinite(cost) else np.inf)
        return np.array(costs)

    def reshaped(self, model: Model, each: Callable | None = None) -> ChainFit:
        """Fit from rules that were sought anew, from many starts, on what the effects leave for them.

        A base that was fitted while an effect was missing is a poor start once it is there.
        """
        return self._settled(self._with_rules_anew(model, _STARTS, each))

    def _settled(self, fit: ChainFit) -> ChainFit:
        """Return the fit continued with everything in it."""
        return self._rough_fit(fit.model, _SETTLING_ANEW)

    @np.errstate(over="ignore", invalid="ignore")
    def _with_rules_anew(self, model: Model, starts: int, each: Callable | None = None) -> ChainFit:
        """Fit rules that are sought anew, and how records begin, while the effects wait.

        While the rules are far off, creep's gains would go to zero and stay there.
        """
        seen = []
        for i, t in enumerate(self.traces):
            reading, x, y = model.run(t, i)
            if not np.all(np.isfinite(x)):
                continue
            # the measurement less what the stages behind the core add to it, where its run tells that
            added = reading - y
            told = np.all(np.abs(added) < self._far)
            target = t.y - model.offsets[i] - (added if told else 0.0)
            core = replace(t, drive=Drive.of(x), y=target, has_offset=False)
            # what is set aside at the end has nothing to say here
            seen.append(core.part(slice(0, int(np.flatnonzero(t.weight)[-1]) + 1)))
        if seen:
            model = self._with_found_rules(model, seen, starts, each or self._shared)
        waiting = self.criterion(model).guarded(1.0).holding(["effects"])
        return minimise(waiting, _SETTLING, waiting.rough_tolerance)

    def _with_found_rules(self, model: Model, seen: list[Trace], starts: int, each: Callable) -> Model:
        """Return the model with the best rules of some starts; where all diverge, with its own."""
        count, own = int(model.values["ruleCount"]), self.scaling.rules(model.rules)
        with suppress(IdentificationError):
            found = search_rules(seen, self.scaling, count, Options(starts=starts), [own], each)
            return with_rules(model, self.scaling.physical_rules(found))
        return model

    def residuals(self, model: Model) -> list[np.ndarray]:
        """Return the weighted errors of the free run on the fitted training samples, m, by record."""
        return [(t.weight * (model.predict(t, i) - t.y))[t.fitted] for i, t in enumerate(self.traces)]

    def errors(self, model: Model, traces: Sequence[Trace] | None = None) -> Errors:
        """Return the errors on the judged samples of records, by default of those that decide.

        They are weighted as the records are, with a mean square weight of 1. Those of a record that
        `begins_elsewhere` come without their mean.
        """
        known = self.parts and traces is None
        traces = self.deciding if traces is None else traces
        fitted = model if known else self.fit_own(model, traces)
        counts = [np.count_nonzero(t.judged) for t in traces]
        level = np.sqrt(np.average([t.importance**2 for t in traces], weights=counts))
        weights = [t.importance / level for t in traces]
        elsewhere = [not self.parts and self.begins_elsewhere(t) for t in traces]

        def weighted(error: Callable, judged: Sequence[np.ndarray]) -> list[np.ndarray]:
            counted = [i for i, samples in enumerate(judged) if samples.any()]
            found = {i: error(fitted, traces[i], i)[judged[i]] for i in counted}
            return [weights[i] * (e - np.mean(e) if elsewhere[i] else e) for i, e in found.items()]

        free = weighted(self._error, [t.judged for t in traces])
        band, wide = (
            weighted(partial(self._inverse_error, name=name), self._inverted(traces, name))
            for name in ("band", "wide")
        )
        return Errors(free, band, wide)

    def _inverted(self, traces: Sequence[Trace], name: str) -> list[np.ndarray]:
        """Return which samples of records, (N,) each, judge the inverse; none of some of them.

        Where the voltage goes beyond what was fitted, the model extrapolates, and the inverse's play
        remembers the voltages that it asks for there: none behind that are taken, and none of a record
        with few before it, unless no record has more.
        """
        inside = [t.judged & getattr(t.references, name).inside for t in traces]
        first = [np.logical_and.accumulate(stays(t, self.extent.voltage)) for t in traces]
        before = [judged & early for judged, early in zip(inside, first, strict=True)]
        tell = [np.count_nonzero(samples) >= STARTS.fewest_deciding for samples in before]
        if not any(tell):
            return inside
        return [samples & enough for samples, enough in zip(before, tell, strict=True)]

    @property
    def _begins(self) -> tuple[np.ndarray, float]:
        """The first voltages of the training records, and what little apart such ones are."""
        begins = np.array([t.drive.voltage[0] for t in self.traces])
        return begins, STARTS.slack * self.extent.voltage_span

    @property
    def begins_alike(self) -> bool:
        """Whether all training records begin at one voltage."""
        begins, little = self._begins
        return bool(np.ptp(begins) <= little)

    def begins_elsewhere(self, trace: Trace) -> bool:
        """Return whether all training records begin at one voltage, and a record at another one.

        Creep slower than the records is then in none that is fitted, and all of it in this one, as a
        constant that no model foretells during the search: it tells nothing of which one is right.
        """
        begins, little = self._begins
        apart = abs(trace.drive.voltage[0] - np.mean(begins)) > little
        return self.begins_alike and bool(apart)

    @np.errstate(over="ignore", invalid="ignore")
    def _error(self, model: Model, trace: Trace, index: int) -> np.ndarray:
        """Return model minus measured; ten times the travel where a run is on its way to infinity."""
        return self._bounded(model.predict(trace, index) - trace.y)

    @np.errstate(over="ignore", invalid="ignore")
    def _inverse_error(self, model: Model, trace: Trace, index: int, name: str) -> np.ndarray:
        """Return what the inverse asks for beyond the voltage applied, in m by the records' gain."""
        values = {**model.values, **model.start(index), **self._ends}
        error = inverse_error(values, trace.drive, trace.references, name, model.offsets[index])
        gain = self.extent.displacement_span / self.extent.voltage_span
        return self._bounded(gain * error)

    @property
    def _ends(self) -> dict[str, float]:
        """What limits the inverse: nearly the range of the voltage, as when it is packaged.

        Without, it would follow a ring that the model lacks to any voltage, and play would remember
        voltages that nobody applies. A little beyond, so that it counts if it asks for more than that.
        """
        low, high = self.extent.voltage
        reserve = SEARCH.beyond * (high - low)
        low, high = low - reserve, high + reserve
        return {**UNLIMITED, "voltageMin": low, "voltageMax": high}

    def likelihood_ratio_behind_turns(self, before: Model, after: Model) -> float:
        """Return the likelihood-ratio statistic of two models behind the sharpest turns of the voltage.

        It is positive where `after` is likelier. It compares the changes of the errors from one sample
        to the next: what both models miss is slow, and does not count in them.
        """
        total = 0.0
        for i, trace in enumerate(self.traces):
            old, new = (np.diff(m.predict(trace, i) - trace.y) for m in (before, after))
            chosen = _behind_turns(trace)
            noise = max(float(median_abs_deviation(old, scale="normal")), trace.noise)
            total += float(np.sum((old[chosen] / noise) ** 2 - (new[chosen] / noise) ** 2))
        return total

    def least_inverse_error(self, model: Model, name: str = "band") -> float:
        """Return by how much the inverse would miss if the stage were the model, m rms.

        Noise in the references of what decides causes it, and what is beyond their band.
        """
        fitted = model if self.parts else self.fit_own(model, self.deciding)
        gain = self.extent.displacement_span / self.extent.voltage_span
        judged = self._inverted(self.deciding, name)
        errors = [
            least_inverse_error(
                {**model.values, **fitted.start(i), **self._ends}, t.drive, t.references, name
            )[judged[i]]
            for i, t in enumerate(self.deciding)
        ]
        return gain * float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))

    def _bounded(self, error: np.ndarray) -> np.ndarray:
        return np.clip(np.where(np.isfinite(error), error, self._far), -self._far, self._far)

    @property
    def _far(self) -> float:
        """Ten times the travel: where a run on its way to infinity is cut off, m."""
        return 10.0 * self.extent.displacement_span
