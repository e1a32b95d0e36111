"""How a record begins: its start, fitted on its lead-in alone, all else held."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.stats import chi2

from it2hys.identification.criterion import ChainCriterion, Model, Trace, minimise
from it2hys.identification.effect_coordinates import Coordinate, by_record, of_reading
from it2hys.identification.lead_in import Misfit, lead_in_length
from it2hys.identification.scaling import Scaling
from it2hys.identification.uncertainty import correlation_time
from it2hys.model.effect import History
from it2hys.model.stages import EFFECTS
from it2hys.policy import PHYSICS, STARTS
from it2hys.records.clues import Clue, Clues, Extent

#: The effect that shifts the voltage, up to a sample of which goes with sampled ones; its parameter.
SHIFTING, SHIFT = next((name, e.shift) for name, e in EFFECTS.items() if e.shift)
#: Histories from which what belongs to a record is fitted, and those that a lead-in has to tell apart.
_HISTORIES = 7
#: Parts of the second half of a lead-in whose means tell what is slow of an error.
_BLOCKS = 4


def fitted_coordinates(model: Model, extent: Extent) -> list[Coordinate]:
    """Return what of a model's effects is fitted."""
    result = []
    for effect in model.effects:
        starts = EFFECTS[effect].starts_of(model.values, extent)
        result += [Coordinate.of(name, start) for name, start in starts.items()]
    result.append(Coordinate("initialDisplacement", extent.displacement, logarithmic=False))
    if shifts(model):
        bounds = (PHYSICS.shortest_shift * extent.sample_time, extent.sample_time)
        result.append(Coordinate(SHIFT, bounds, logarithmic=False))
    return result


def shifts(model: Model) -> bool:
    """Return whether a delay of up to a sample belongs to a model without it being an effect."""
    waits = [EFFECTS[e] for e in model.effects if EFFECTS[e].sampled and not EFFECTS[e].sampling_delay]
    return SHIFTING not in model.effects and bool(waits)


def sampling_delay(model: Model, effect: str) -> str | None:
    """Return the parameter that is the part of a sample beside an effect of a model, if any."""
    return EFFECTS[effect].sampling_delay or (SHIFT if shifts(model) else None)


@dataclass(frozen=True, eq=False)
class Starts:
    """The records that a model was fitted to, and how the starts of these and others are found.

    Parameters
    ----------
    traces : list of Trace
        Records that are fitted.
    scaling : Scaling
    extent : Extent
    """

    traces: list[Trace]
    scaling: Scaling
    extent: Extent

    def clues(self, model: Model) -> Clues:
        """Return what a model leaves over of the training records."""
        return clues(model, self.traces, self.extent)

    def criterion(self, model: Model) -> ChainCriterion:
        """Return the joint criterion of everything, from a model."""
        fitted = fitted_coordinates(model, self.extent)
        criterion = ChainCriterion(self.traces, model, fitted, self.scaling)
        return criterion.holding(memories(model)) if model.rested else criterion

    def fit_own(self, model: Model, traces: Sequence[Trace], known: int = 0) -> Model:
        """Return the model with what belongs to records fitted to these ones, all else held.

        The first `known` of them are the records that the model was fitted to.
        """
        kept = [_of_record(model, i) for i in range(known)]
        return _joined([*kept, *(self._fit_own_to_one(model, t) for t in traces[known:])])

    def with_lead_in(self, model: Model, trace: Trace) -> Trace:
        """Return a record with a lead-in that is as long as the model's start needs.

        Histories that the lead-in cannot tell apart do not differ by more than the error behind it, and
        at its end the likeliest is as near to the record as the model is.
        """
        # what a record may remember does not show in the slopes of a start after long rest
        fitted = self._starts(model, trace, rested=False)[0]
        used = trace.weight > 0.0
        criterion = self._of_start(fitted, replace(trace, weight=1.0 * used))
        linear = criterion.jacobian(criterion.pack(fitted))
        if linear is None:  # a run on its way to infinity
            return trace
        rows = linear[0][:, criterion.start_columns]
        misfit = self._misfit(model)
        error = trace.noise**2 + misfit.power
        lead = lead_in_length(
            rows * self.scaling.y_unit,
            used,
            trace.noise,
            misfit,
            lambda lead: (
                lead >= _told_after(model)
                and _moves(model, trace, lead, self.extent)
                and self._determines(model, replace(trace, lead=lead), error)
            ),
        )
        used[:lead] = False
        return replace(trace, lead=lead, judged=used)

    def _determines(self, model: Model, trace: Trace, error: float) -> bool:
        """Return whether a lead-in determines the start, where an error, m^2, is usual behind it."""
        best, *others = self._starts(model, trace)
        run = best.predict(trace, 0)
        behind, late = trace.weight > 0.0, trace.weight > 0.0
        behind[: trace.lead] = late[trace.lead :] = late[: trace.lead // 2] = False
        if not _forgotten((run - trace.y)[late], trace.noise**2, error - trace.noise**2):
            return False
        squares = [np.mean((other.predict(trace, 0) - run)[behind] ** 2) for other in others]
        return float(max(squares, default=0.0)) <= error

    def _misfit(self, model: Model) -> Misfit:
        """Return what a model misses of the training records behind their lead-ins.

        What it misses in them, of a former state that it cannot have, is not there later.
        """
        residuals = [
            clue.residual[t.lead :] - np.mean(clue.residual[t.lead :][clue.used[t.lead :]])
            for clue, t in zip(self.clues(model).records, self.traces, strict=True)
        ]
        return Misfit.of(residuals, [t.noise for t in self.traces])

    def _of_start(self, model: Model, trace: Trace) -> ChainCriterion:
        """Return the criterion of what belongs to one record, all else held."""
        fitted = [c for c in fitted_coordinates(model, self.extent) if c.name in by_record()]
        return ChainCriterion([trace], model, fitted, self.scaling).holding(["rules"])

    def _fit_own_to_one(self, model: Model, trace: Trace) -> Model:
        """Return the model of one record, its start fitted on the lead-in."""
        return self._starts(model, trace)[0]

    def _starts(self, model: Model, trace: Trace, rested: bool = True) -> list[Model]:
        """Return the model of one record with starts fitted on the lead-in from likely histories.

        The likeliest comes first, and with it those that the lead-in cannot tell from it. One of them
        may be that after long rest. Where none describes the whole, they are fitted to its second half.
        """
        part, voltage = lead_in(trace), trace.drive.voltage
        whole = self._fitted_starts(model, part, voltage, rested)
        if not memories(model) or _power(whole[0], part) <= STARTS.late * part.noise**2:
            return whole
        # what no start describes in the first half is made up for in the second, and goes on behind
        weight = part.weight.copy()
        weight[: np.flatnonzero(weight)[np.count_nonzero(weight) // 2]] = 0.0
        late = replace(part, weight=weight)
        half = self._fitted_starts(model, late, voltage, rested)
        error = _power(whole[0], late)
        uneven = 2.0 * _power(whole[0], part) - error > STARTS.late * error
        return half if uneven or error > STARTS.late * _power(half[0], late) else whole

    def _fitted_starts(
        self, model: Model, trace: Trace, voltage: np.ndarray, rested: bool
    ) -> list[Model]:
        """Return the model of a lead-in with likely starts; its range is that of `voltage`."""
        start = with_starts(model, [trace])
        histories = likely_histories(start, trace, 0, voltage)[:_HISTORIES]
        starts = [_as_trained(model, start), *(_with_history(start, h) for h in histories)]
        fits = [minimise(self._of_start(s, trace), 30, 1e-8).model for s in starts]
        handicaps = [0.0, *(PHYSICS.excursion * h.has_to_show for h in histories)]
        if rested and (remembered := memories(model)):
            criterion = self._of_start(at_rest(start), trace).holding(remembered)
            fits.append(minimise(criterion, 30, 1e-8).model)
            # what is fitted beside it makes any fit a little better
            chance = float(chi2.isf(STARTS.rested, len(remembered)))
            handicaps = [*(h + chance for h in handicaps), 0.0]
        errors = [(fit.predict(trace, 0) - trace.y)[trace.fitted] for fit in fits]
        unlikely = _unlikeliness(errors, handicaps)
        order = np.argsort(unlikely, kind="stable")
        return [fits[i] for i in order if unlikely[i] <= unlikely[order[0]] + 2.0 * PHYSICS.excursion]


def _power(model: Model, trace: Trace) -> float:
    """Return the mean square of the errors of one record's model on the samples with a weight, m^2."""
    return float(np.mean((model.predict(trace, 0) - trace.y)[trace.fitted] ** 2))


def _forgotten(late: np.ndarray, noise: float, misfit: float) -> bool:
    """Return whether the errors late in a lead-in, m, tell that what was before is forgotten.

    Beyond the squares of the noise and of what the model misses, m^2, a slow error counts for more than
    a fast one: it goes on behind the lead-in.
    """
    if not len(late):
        return True
    means = [np.mean(block) for block in np.array_split(late, min(_BLOCKS, len(late)))]
    by_chance = noise * len(means) / len(late)
    slow = np.mean(np.square(means)) - STARTS.late * misfit - by_chance
    return bool(np.mean(late**2) <= STARTS.late * (noise + misfit) and slow <= STARTS.slow**2 * noise)


def _told_after(model: Model) -> float:
    """Return after how many samples of a record the effects tell what of them belongs to it."""
    longest = max((EFFECTS[e].told_after(model.values) for e in model.effects), default=0.0)
    return longest / model.values["sampleTime"]


def _moves(model: Model, trace: Trace, lead: int, extent: Extent) -> bool:
    """Return whether a lead-in shows what a model may remember: its voltage moves, where it ever does.

    While it is held, one kind of memory looks like another, and like a small error of the model.
    """
    little = STARTS.slack * extent.voltage_span
    begun, whole = (float(np.ptp(v)) for v in (trace.drive.voltage[:lead], trace.drive.voltage))
    return not memories(model) or begun > little or whole <= little


def memories(model: Model) -> list[str]:
    """Return what of a model is 0 for a record that begins after long rest."""
    return [n for e in model.effects for n in EFFECTS[e].per_record if n not in of_reading()]


def at_rest(model: Model) -> Model:
    """Return the model with every record begun after long rest."""
    rested = {n: np.zeros_like(model.own[n]) for n in memories(model)}
    return replace(model, own={**model.own, **rested}, rested=True)


def lead_in(trace: Trace) -> Trace:
    """Return the lead-in of a record, as a record of its own."""
    part = trace.part(slice(0, trace.lead))
    return replace(part, judged=part.weight > 0.0)


def _of_record(model: Model, index: int) -> Model:
    own = {name: values[index : index + 1] for name, values in model.own.items()}
    return replace(model, offsets=model.offsets[index : index + 1], own=own)


def _as_trained(model: Model, start: Model) -> Model:
    """Return the model of one record, begun as the first training record begins."""
    own = {n: model.own[n][:1] if n not in of_reading() else v for n, v in start.own.items()}
    return replace(start, own=own)


def _joined(models: Sequence[Model]) -> Model:
    """Return one model with what belongs to the records of several, which are alike but for that."""
    return replace(
        models[0],
        offsets=np.concatenate([m.offsets for m in models]),
        own={name: np.concatenate([m.own[name] for m in models]) for name in models[0].own},
        rested=False,
    )


def clues(model: Model, traces: Sequence[Trace], extent: Extent) -> Clues:
    """Return what a model leaves over of records."""
    records = [
        Clue(
            t.drive.voltage,
            t.drive.force,
            t.drive.temperature,
            t.y - model.offsets[i],
            t.y - model.predict(t, i),
            t.weight > 0,
        )
        for i, t in enumerate(traces)
    ]
    return Clues(extent, records)


def with_starts(model: Model, traces: Sequence[Trace]) -> Model:
    """Return the model with guesses of what belongs to records, for records not seen before."""
    count = len(traces)
    model = replace(
        model,
        offsets=np.where([t.has_offset for t in traces], np.mean(model.offsets), 0.0),
        own={name: np.zeros(count) for name in model.own},
    )
    begins = np.array([t.y[0] for t in traces]) - model.offsets
    model = replace(model, own={**model.own, "initialDisplacement": begins})
    model = with_histories(model, traces)
    extent = Extent(model.values["sampleTime"], 0.0, (0.0, 0.0), (0.0, 0.0))
    for effect in model.effects:
        found = EFFECTS[effect].found_in_records(
            model.values, partial(_left_with, model, traces, extent)
        )
        model = replace(model, own={**model.own, **found})
    return model


def _left_with(model: Model, traces: Sequence[Trace], extent: Extent, values: Mapping) -> Clues:
    """Return what is left over of records with other values."""
    return clues(replace(model, values=values), traces, extent)


def with_histories(model: Model, traces: Sequence[Trace]) -> Model:
    """Return the model with the history before each record that suits it best, of a few likely ones."""
    records = [
        _with_history(_of_record(model, i), likely_histories(model, t, i)[0])
        for i, t in enumerate(traces)
    ]
    return _joined(records)


def _with_history(model: Model, history: History) -> Model:
    values = {n: np.full(model.offsets.shape, v) for n, v in history.values.items()}
    return replace(model, own={**model.own, **values})


@np.errstate(over="ignore", invalid="ignore")
def likely_histories(
    model: Model, trace: Trace, index: int, voltage: np.ndarray | None = None
) -> list[History]:
    """Return what may have been before a record, the likeliest first; its range is that of `voltage`.

    Where the effects remember nothing, there is one history, which says nothing.
    """
    voltage = trace.drive.voltage if voltage is None else voltage
    histories = [History({}, False)]
    for effect in model.effects:
        own = EFFECTS[effect].histories(voltage) or [History({}, False)]
        histories = [
            History({**h.values, **o.values}, h.has_to_show or o.has_to_show)
            for h in histories
            for o in own
        ]
    if len(histories) == 1:
        return histories
    errors = [
        (_with_history(model, history).predict(trace, index) - trace.y)[trace.fitted]
        for history in histories
    ]
    if trace.has_offset:
        errors = [error - np.mean(error) for error in errors]
    unlikely = _unlikeliness(errors, [PHYSICS.excursion * h.has_to_show for h in histories])
    return [histories[i] for i in np.argsort(unlikely, kind="stable")]


@np.errstate(over="ignore", invalid="ignore")
def _unlikeliness(errors: Sequence[np.ndarray], handicaps: Sequence[float]) -> np.ndarray:
    """Return of starts how unlikely each is, by the errors on a record that is begun with it.

    It is twice the negative logarithm of the likelihood, of as many samples as are independent. What a
    start has more than another has to earn its place by its handicap: where a lead-in does not show it,
    it would show later.
    """
    power = np.array([np.mean(error**2) for error in errors])
    power[~np.isfinite(power)] = np.inf
    best = errors[int(np.argmin(power))]
    if not np.isfinite(power.min()):
        return power
    independent = len(best) / correlation_time(best)
    # a run without an error is no more than as good as one without a noticeable one
    power = np.maximum(power, np.finfo(float).tiny)
    relative = power / power.min()
    return independent * np.log(relative) + np.array(handicaps)
