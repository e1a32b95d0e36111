"""The free-run criterion (23) of the whole chain on several records, with exact derivatives.

Fitted are the rules, the parameters of the effects that are on, and what belongs to a record alone:
the displacement at which it begins and the history before it, a constant between it and the model,
the phase of a line. A record begins as the plant FMU does with these parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cache, cached_property

import numpy as np

from it2hys.identification import rule_coordinates
from it2hys.identification.effect_coordinates import Coordinate, by_record
from it2hys.identification.inverse import References
from it2hys.identification.levenberg_marquardt import (
    Block,
    Linearisation,
    Minimum,
    joined,
    levenberg_marquardt,
)
from it2hys.identification.scaling import Scaling
from it2hys.identification.usability import Band, Course, Guard
from it2hys.model import compiled
from it2hys.model.effect import Effect
from it2hys.model.parameters import RULE_FIELDS
from it2hys.model.stages import EFFECTS
from it2hys.model.variables import load_table
from it2hys.policy import CORE, PHYSICS, STARTS

#: Where the error is larger than so many half ranges, rms, a run is on its way to infinity.
_DIVERGED = 1e3
#: A fit that is continued later has arrived where a step raises twice the log-likelihood by less.
_UNSEEN = 0.01
#: Weight, in samples, with which the effects' coordinates are held near their guesses.
_EFFECT_PRIOR = 1e-3


@dataclass(frozen=True, eq=False)
class Trace:
    """A record as the criterion sees it.

    Parameters
    ----------
    name, role : str
        Role is "train", "validation" or "test".
    drive : Drive
    y : ndarray, shape (N,)
        Measured displacement, m.
    weight : ndarray, shape (N,)
        Of every residual; 0 for samples that are not fitted.
    judged : ndarray of bool, shape (N,)
        Samples whose errors count when models are compared.
    lead : int
        Samples of the lead-in, on which the start of a record that is not fitted is.
    noise : float
        In m rms.
    has_offset : bool
        Whether a constant between record and model is fitted.
    importance : float
        Weight of the record, in fits (part of `weight`) and where models are compared.
    references : References
        The measured displacement as an inverse is fed with it.
    noise_method : str
        How the noise was estimated.
    """

    name: str
    role: str
    drive: compiled.Drive
    y: np.ndarray
    weight: np.ndarray
    judged: np.ndarray
    lead: int
    noise: float
    references: References
    has_offset: bool = False
    importance: float = 1.0
    noise_method: str = ""

    def part(self, kept: slice) -> Trace:
        """Return a part of the record, as a record of its own."""
        drive = self.drive
        channels = (drive.voltage[kept], drive.force[kept], drive.temperature[kept])
        return replace(
            self,
            drive=compiled.Drive(*channels),
            y=self.y[kept],
            weight=self.weight[kept],
            judged=self.judged[kept],
        )

    @cached_property
    def fitted(self) -> slice | np.ndarray:
        """Index of the samples that are fitted: a slice, which copies nothing, where they adjoin."""
        places = np.flatnonzero(self.weight > 0)
        adjoin = len(places) and places[-1] - places[0] == len(places) - 1
        return slice(int(places[0]), int(places[-1]) + 1) if adjoin else places


@dataclass(frozen=True, eq=False)
class Model:
    """A chain and what belongs to the records it was fitted to, in SI units.

    Parameters
    ----------
    values : Mapping
        Parameters by FMU variable name.
    effects : tuple of str
        Names of the effects that it has, in the order in which they came.
    offsets : ndarray, shape (R,)
        The constant of each record.
    own : Mapping of str to ndarray, shape (R,)
        Values of parameters that differ from record to record.
    smoothness : float
        With which what an effect has of a density is held smooth, CORE.stiff or CORE.soft.
    contraction : float
        Largest |dF/dy| of the core: that of any usable one, or less.
    rested : bool
        Whether all records begin after long rest; what may have been before is not fitted then.
    """

    values: Mapping[str, float | int]
    effects: tuple[str, ...]
    offsets: np.ndarray
    own: Mapping[str, np.ndarray]
    smoothness: float = field(default_factory=lambda: CORE.stiff)
    contraction: float = field(default_factory=lambda: CORE.contraction)
    rested: bool = False

    @property
    def rules(self) -> np.ndarray:
        """Rules, shape (L, 6), SI units."""
        names = _rule_names(int(self.values["ruleCount"]))
        return np.array([self.values[n] for n in names]).reshape(-1, len(RULE_FIELDS))

    def packed(self, index: int) -> np.ndarray:
        """Return the parameters for one record as the C core takes them."""
        return compiled.pack_chain(self.start(index), self._shared)

    @cached_property
    def _shared(self) -> np.ndarray:
        """What all records share, packed."""
        return compiled.pack_chain(self.values)

    def start(self, index: int) -> dict[str, float]:
        """Return the parameters with which the plant FMU begins one record."""
        return {name: float(values[index]) for name, values in self.own.items()}

    def predict(self, trace: Trace, index: int) -> np.ndarray:
        """Return the reading of the free run over a record, its offset included, m."""
        return self.run(trace, index)[0] + self.offsets[index]

    def run(self, trace: Trace, index: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return reading, core's input and core's output of the free run over a record."""
        return compiled.chain_predict(self.packed(index), trace.drive)


@cache
def _rule_names(count: int) -> tuple[str, ...]:
    """Return the names of the parameters of so many rules, row by row."""
    return tuple(f"rule[{i}].{field}" for i in range(1, count + 1) for field in RULE_FIELDS)


def with_rules(model: Model, rules: np.ndarray) -> Model:
    """Return the model with other rules, SI units."""
    values = {n: v for n, v in model.values.items() if not n.startswith("rule[")}
    values["ruleCount"] = len(rules)
    values.update(zip(_rule_names(len(rules)), np.ravel(rules).tolist(), strict=True))
    return replace(model, values=values)


def paper_model(
    traces: Sequence[Trace],
    scaling: Scaling,
    rules: np.ndarray,
    offsets: Sequence[float] | None = None,
    begins: Sequence[float] | None = None,
) -> Model:
    """Return the paper's model, the chain with no effect on, of records.

    Parameters
    ----------
    traces : sequence of Trace
        R records.
    scaling : Scaling
    rules : ndarray, shape (L, 6)
        Scaled.
    offsets, begins : sequence of float, optional
        Constant of each record and displacement before it, m. By default there is no constant, and a
        record begins with its first reading.
    """
    offsets = np.zeros(len(traces)) if offsets is None else np.asarray(offsets, dtype=float)
    begins = [t.y[0] for t in traces] - offsets if begins is None else np.asarray(begins)
    values = {"sampleTime": traces[0].references.sample_time}
    model = Model(values, (), offsets, {"initialDisplacement": begins})
    return with_rules(model, scaling.physical_rules(rules))


def paper_problem(traces: Sequence[Trace], model: Model, scaling: Scaling) -> ChainCriterion:
    """Return the criterion of a model with no effect on: its rules, and how the records begin."""
    # so that 1 is half the travel, as it is for the displacements of the rules
    reach = (float(scaling.displacement(-5.0)), float(scaling.displacement(5.0)))
    begin = Coordinate("initialDisplacement", reach, logarithmic=False)
    return ChainCriterion(traces, model, [begin], scaling)


class ChainCriterion:
    """The sum of squared errors of free runs over coordinates.

    Parameters
    ----------
    traces : sequence of Trace
    model : Model
        Gives structure, guesses and everything that is not fitted.
    fitted : sequence of Coordinate
        Parameters of effects that are fitted.
    scaling : Scaling
        Of the rules and of the residuals.
    """

    def __init__(
        self,
        traces: Sequence[Trace],
        model: Model,
        fitted: Sequence[Coordinate],
        scaling: Scaling,
    ):
        self.traces, self.model, self.scaling = list(traces), model, scaling
        self.common = [c for c in fitted if c.name not in by_record()]
        self._own = [c for c in fitted if c.name in by_record()]
        self.rule_count = int(model.values["ruleCount"])
        self.rule_size = rule_coordinates.RULE_SIZE * self.rule_count
        self._with_offset = [i for i, t in enumerate(self.traces) if t.has_offset]
        self.samples = sum(float(t.weight @ t.weight) for t in self.traces)
        self._guard: Guard | None = None
        self._free_groups = {"rules", "effects"}
        self.held: tuple[str, ...] = ()
        self._places = self._layout()
        self._shared = compiled.pack_chain(model.values)
        self._drives = compiled.Drives([t.drive for t in self.traces])
        self.lower, self.upper = self._bounds()
        self._guess = self.pack(model)
        self._roughness = self._smoothness()
        self._steepness = self._slopes()
        self._prior = self._prior_weights()
        self._seen = self._seen_coordinates()

    @property
    def rough_tolerance(self) -> float:
        """Tolerance of a fit that is compared with others, or continued, and not yet the result.

        Twice the logarithm of the likelihood is N ln(cost) less a constant.
        """
        return max(_UNSEEN / self.samples, 1e-6)

    def _layout(self) -> dict[str, slice]:
        sizes = {
            "rules": self.rule_size,
            "effects": len(self.common),
            "offsets": len(self._with_offset),
            **{c.name: len(self.traces) for c in self._own},
        }
        ends = np.cumsum(list(sizes.values()))
        return {n: slice(int(e - s), int(e)) for (n, s), e in zip(sizes.items(), ends, strict=True)}

    def _bounds(self) -> tuple[np.ndarray, np.ndarray]:
        parts = []
        for end in (0, 1):
            far = 3.0 if end else -3.0
            parts.append(
                np.concatenate(
                    [
                        rule_coordinates.rule_bounds(self.rule_count)[end],
                        [c.of_value(c.bounds[end]) for c in self.common],
                        np.full(len(self._with_offset), far),
                        *(self._own_bounds(c)[end] / c.unit for c in self._own),
                    ]
                )
            )
        return parts[0], parts[1]

    def _own_bounds(self, coordinate: Coordinate) -> tuple[np.ndarray, np.ndarray]:
        """Return the bounds of what belongs to a record, arrays of shape (R,), in SI units.

        A record begins near its first reading; the effects know the rest.
        """
        low, high = (np.full(len(self.traces), end) for end in coordinate.bounds)
        begins = np.array([t.y[0] for t in self.traces]) - self.model.offsets
        effect = load_table().effect_of(coordinate.name)
        if effect is None:
            near = STARTS.near * (high - low)
            return begins - near, begins + near
        least, most = self._travel()
        near = STARTS.near * (most - least)
        travel = least - near, most + near
        return EFFECTS[effect].bounds_of_record(coordinate.name, (low, high), begins, travel)

    def _travel(self) -> tuple[float, float]:
        """Return the lowest and the highest displacement of the records that gave the scaling, m."""
        return tuple(float(self.scaling.displacement(end)) for end in (-1.0, 1.0))

    def pack(self, model: Model) -> np.ndarray:
        """Return the coordinates of a model, shape (P,)."""
        scaling = self.scaling
        return np.concatenate(
            [
                rule_coordinates.to_coordinates(scaling.rules(model.rules)),
                [c.of_value(model.values[c.name]) for c in self.common],
                np.asarray(model.offsets)[self._with_offset] / scaling.y_unit,
                *(np.asarray(model.own[c.name]) / c.unit for c in self._own),
            ]
        )

    @property
    def start_columns(self) -> np.ndarray:
        """Places of the coordinates that belong to records, the constants among them."""
        names = ["offsets", *(c.name for c in self._own)]
        return np.concatenate([np.arange(self._places[n].start, self._places[n].stop) for n in names])

    @property
    def places_of_common(self) -> slice:
        """Places of the coordinates of the effects' parameters that all records share."""
        return self._places["effects"]

    @property
    def first_start(self) -> list[tuple[str, float, int]]:
        """Name, unit in SI and place of the coordinates that belong to the first record alone."""
        return [(c.name, c.unit, self._places[c.name].start) for c in self._own]

    def unpack(self, point: np.ndarray) -> Model:
        """Return the model of the coordinates."""
        scaling, places = self.scaling, self._places
        rules = scaling.physical_rules(self.rules(point))
        values = {
            **self.model.values,
            **dict(zip(_rule_names(len(rules)), rules.ravel().tolist(), strict=True)),
        }
        for c, value in zip(self.common, point[places["effects"]], strict=True):
            values[c.name] = c.value(value)
        own = {c.name: point[places[c.name]] * c.unit for c in self._own}
        return replace(self.model, values=values, offsets=self._offsets(point), own=own)

    def _packed(self, point: np.ndarray) -> np.ndarray:
        """Return what the model of the coordinates packs for each record, shape (R, ...)."""
        places, packed = self._places, self._template.copy()
        at_rules, at_common, at_own = self._packed_places
        packed[:, at_rules] = self.scaling.physical_rules(self.rules(point)).ravel()
        if self.common:
            common = zip(self.common, point[places["effects"]].tolist(), strict=True)
            packed[:, at_common] = [c.value(value) for c, value in common]
        for c, at in zip(self._own, at_own, strict=True):
            packed[:, at] = point[places[c.name]] * c.unit
        return packed

    @cached_property
    def _template(self) -> np.ndarray:
        """What is packed for each record and is not fitted, shape (R, ...)."""
        return np.tile(self._shared, (len(self.traces), 1))

    @cached_property
    def _packed_places(self) -> tuple[slice, np.ndarray, list[int]]:
        first = int(compiled.chain_places(_rule_names(1))[0])  # the rules are an array there
        common, own = (compiled.chain_places([c.name for c in cs]) for cs in (self.common, self._own))
        return slice(first, first + self.rule_size), common, own.tolist()

    def _offsets(self, point: np.ndarray) -> np.ndarray:
        """Return the constant of each record, m, shape (R,)."""
        offsets = np.array(self.model.offsets, dtype=float)
        if self._with_offset:
            offsets[self._with_offset] = point[self._places["offsets"]] * self.scaling.y_unit
        return offsets

    @cached_property
    def _held(self) -> tuple[np.ndarray, np.ndarray]:
        """Places of the coordinates that have a prior, and its weights."""
        held = np.flatnonzero(self._prior > 0.0)
        return held, self._prior[held]

    @cached_property
    def _measured(self) -> np.ndarray:
        """The measured displacement of all records, one after the other, m."""
        return np.concatenate([t.y for t in self.traces])

    @cached_property
    def _fitted(self) -> tuple[np.ndarray, np.ndarray]:
        """Places in `_measured` that are fitted, and their weights."""
        ends = np.cumsum(self._drives.lengths)
        every = [np.arange(end - len(t.y), end) for t, end in zip(self.traces, ends, strict=True)]
        places = [places[t.fitted] for places, t in zip(every, self.traces, strict=True)]
        return np.concatenate(places), np.concatenate([t.weight[t.fitted] for t in self.traces])

    @np.errstate(over="ignore", invalid="ignore")
    def guarded(self, strength: float) -> ChainCriterion:
        """Return the criterion with penalties for rules that are unusable where the core works."""
        courses = []
        for i, trace in enumerate(self.traces):
            _, x, y = self.model.run(trace, i)
            x, y = self.scaling.x(x), self.scaling.y(y)
            if np.all(np.abs(y) < _DIVERGED):
                courses.append((x, y, np.ones(len(x), dtype=bool)))
        return self.guarded_over(Band.of_data(courses), strength) if courses else copy(self)

    def guarded_by_data(self, strength: float, offsets: np.ndarray) -> ChainCriterion:
        """Return the criterion with penalties for rules that are unusable where the data are.

        Of a model with no effect on: its core gets the voltage, and the measured displacement, less a
        record's constant in m, is what it is to put out.
        """
        return self.guarded_over(self.data_band(offsets), strength)

    def data_band(self, offsets: np.ndarray) -> Band:
        """Return the band of the fitted samples, the records' constants in m taken off."""
        return Band.of_data(self.data_courses(offsets))

    def data_courses(self, offsets: np.ndarray) -> list[Course]:
        """Return voltage and displacement, constants taken off, scaled, and which are fitted."""
        return [
            (self.scaling.x(t.drive.voltage), self.scaling.y(t.y - offset), t.weight > 0.0)
            for t, offset in zip(self.traces, offsets, strict=True)
        ]

    def guarded_over(self, band: Band, strength: float) -> ChainCriterion:
        """Return the criterion with penalties for rules that are unusable over a band.

        Stronger ones than 1 are for rules that were unusable with those: where, a finer grid shows.
        """
        band = band if strength <= 1.0 else band.verified
        result = copy(self)
        result._guard = Guard(band, strength * np.sqrt(self.samples), self.model.contraction)
        return result

    def rules(self, point: np.ndarray) -> np.ndarray:
        """Return the scaled rules, shape (L, 6), of the coordinates."""
        return rule_coordinates.to_rules(point[self._places["rules"]])

    def holding(self, names: Sequence[str]) -> ChainCriterion:
        """Return the criterion with groups of coordinates ("rules", "effects"), or one, held."""
        held = copy(self)
        held.lower, held.upper = self.lower.copy(), self.upper.copy()
        for name in names:
            place = self._places[name] if name in self._places else self._place_of(name)
            held.lower[place] = held.upper[place] = self._guess[place]
        held._free_groups = self._free_groups - {*names}
        held.held = (*self.held, *names)
        return held

    def _place_of(self, name: str) -> int:
        """Return the place of a parameter that all records share."""
        return self._places["effects"].start + [c.name for c in self.common].index(name)

    @np.errstate(over="ignore", invalid="ignore")  # of runs on their way to infinity
    def residual(self, point: np.ndarray) -> np.ndarray | None:
        """Return the weighted residuals, or None where a run is no longer finite."""
        lengths = self._drives.lengths
        error = compiled.chain_predict_each(self._packed(point), self._drives)
        if error is None:
            return None
        error += np.repeat(self._offsets(point), lengths)
        error -= self._measured
        error /= self.scaling.y_unit
        squares = np.add.reduceat(error * error, self._drives.firsts)
        if not (squares < _DIVERGED**2 * lengths).all():
            return None
        places, weight = self._fitted
        parts = [weight * error[places]]
        held, prior = self._held
        parts.append(prior * (point - self._guess)[held])
        if len(self._seen[0]):
            parts.append(self._unseen(point))
        if len(self._roughness):
            parts.append(self._roughness @ point)
        if len(self._steepness):
            parts.append(self._falling(point))
        if self._guard is not None:
            parts.append(self._guard.residual(self.rules(point)))
        return np.concatenate(parts)

    def residual_or_nan(self, point: np.ndarray) -> np.ndarray:
        """Return the weighted residuals, NaN in all places where a run is no longer finite."""
        values = self.residual(point)
        if values is not None:
            return values
        fitted = sum(np.count_nonzero(t.weight > 0.0) for t in self.traces)
        penalties = 0 if self.band is None else 4 * len(self.band.y)
        priors = np.count_nonzero(self._prior) + len(self._seen[0])
        priors += len(self._roughness) + len(self._steepness)
        return np.full(fitted + priors + penalties, np.nan)

    def full_jacobian(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the Jacobian of all residuals, priors and penalties too, and those, or None."""
        return joined(self._blocks(point), len(point))

    def unconstrained(self) -> ChainCriterion:
        """Return the criterion without penalties: for a solver that holds constraints."""
        result = copy(self)
        result._guard, result._steepness = None, self._steepness[:0]
        return result

    @property
    def band(self) -> Band | None:
        """Where the penalties ask for contraction and invertibility."""
        return self._guard.band if self._guard else None

    def penalised(self, point: np.ndarray) -> bool:
        """Return whether the core of a point is poor anywhere, and costs for it."""
        return self._guard is not None and bool(np.any(self._guard.residual(self.rules(point))))

    @property
    def curve_slopes(self) -> np.ndarray:
        """The slope of the static curve, less 1, by the coordinates, (K, P); no rows if not fitted."""
        return self._steepness / np.sqrt(self.samples)

    def _smoothness(self) -> np.ndarray:
        """Return the rows, (K, P), that make cost what is not smooth of an effect."""
        return self._noise() * self.model.smoothness * self._rows(lambda effect: effect.roughness)

    def _rows(self, of: Callable[[Effect], Callable]) -> np.ndarray:
        """Return rows that the effects have over their coordinates, as rows over all, (K, P)."""
        units = {c.name: c.unit for c in self.common}
        own = [of(EFFECTS[effect])(self.model.values, units) for effect in self.model.effects]
        stacked = np.vstack([np.zeros((0, len(units))), *own])
        rows = np.zeros((len(stacked), len(self._guess)))
        rows[:, self.rule_size : self.rule_size + len(units)] = stacked
        return rows

    def _slopes(self) -> np.ndarray:
        """Return the rows, (K, P), of what the coordinates add to the slope of the static curve.

        They are as heavy as all samples together: a curve that falls has no inverse.
        """
        return np.sqrt(self.samples) * self._rows(lambda effect: effect.steepness)

    def _falling(self, point: np.ndarray) -> np.ndarray:
        """Return by how much the static curve rises less than it must, where it does."""
        least = np.sqrt(self.samples) * (PHYSICS.curve_slope - 1.0)
        return np.maximum(least - self._steepness @ point, 0.0)

    def _prior_weights(self) -> np.ndarray:
        weights = np.zeros(len(self._guess))
        weights[self._places["effects"]] = _EFFECT_PRIOR
        for c in self._own:
            weights[self._places[c.name]] = STARTS.prior * self._noise()
        return weights

    def _seen_coordinates(self) -> tuple[np.ndarray, np.ndarray]:
        """Return places of coordinates of which records show values up to some, and those."""
        first = self._places["effects"].start
        ends = np.array([c.of_value(c.seen) if np.isfinite(c.seen) else np.inf for c in self.common])
        seen = np.flatnonzero(np.isfinite(ends))
        return first + seen, ends[seen]

    @property
    def _unseen_weight(self) -> float:
        return self._noise() / PHYSICS.unseen

    def _unseen(self, point: np.ndarray) -> np.ndarray:
        """Return what it costs that coordinates are beyond what the records show."""
        places, ends = self._seen
        return self._unseen_weight * np.maximum(point[places] - ends, 0.0)

    def _noise(self) -> float:
        return float(np.sqrt(np.mean([t.noise**2 for t in self.traces]))) / self.scaling.y_unit

    @np.errstate(over="ignore", invalid="ignore")
    def linearise(self, point: np.ndarray) -> Linearisation | None:
        """Return the problem linearised at a point, or None where a run is no longer finite."""
        return Linearisation.of_blocks(self._blocks(point), len(point))

    def jacobian(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the Jacobian of the records' residuals, (M, P), and those, (M,), without priors."""
        return joined(self._record_blocks(point), len(point))

    def _blocks(self, point: np.ndarray) -> Iterator[Block | None]:
        """Yield records, priors and penalties; None where a run is no longer finite."""
        yield from self._record_blocks(point)
        every, (held, weights) = np.arange(len(point)), self._held
        yield np.diag(weights), weights * (point - self._guess)[held], every[held], None
        if len(places := self._seen[0]):
            beyond = self._unseen(point)
            yield np.diag(self._unseen_weight * (beyond > 0.0)), beyond, places, None
        if len(self._roughness):
            yield self._roughness, self._roughness @ point, every, None
        if len(self._steepness):
            falling = self._falling(point)
            yield -self._steepness * (falling > 0.0)[:, None], falling, every, None
        if self._guard is not None:
            by_rules, penalties = self._guard.linearise(self.rules(point))
            yield by_rules, penalties, every[: self.rule_size], None

    def _record_blocks(self, point: np.ndarray) -> Iterator[Block | None]:
        packed, offsets = self._packed(point), self._offsets(point)
        whole = self._by_coordinates(point)
        fitted = [i for i, t in enumerate(self.traces) if len(t.weight[t.fitted])]

        def block(i: int) -> Block | None:
            to_places = whole if i in self._with_offset else whole[:-1, :-1]
            return self._record_block(i, packed[i], offsets[i], to_places)

        for made in self._drives.mapped(block, fitted):
            yield made
            if made is None:
                return

    @np.errstate(over="ignore", invalid="ignore")  # in a thread, that of the caller does not hold
    def _record_block(
        self, index: int, packed: np.ndarray, offset: float, to_places: np.ndarray
    ) -> Block | None:
        """Return one record's residuals and derivatives; None where its run is no longer finite."""
        trace = self.traces[index]
        weight = trace.weight[trace.fitted, None]
        names = [c.name for c in (*self._moving, *self._own)]
        run, by = compiled.chain_sensitivity(packed, trace.drive, names, "rules" in self._free_groups)
        residual = (run + offset - trace.y) / self.scaling.y_unit
        if not (residual @ residual < _DIVERGED**2 * len(residual) and np.isfinite(by[-1]).all()):
            return None
        jacobian = by[trace.fitted]
        jacobian *= weight / self.scaling.y_unit
        own = [self._places[c.name].start + index for c in self._own]
        if index in self._with_offset:
            jacobian = np.hstack([jacobian, weight])
            own.append(self._places["offsets"].start + self._with_offset.index(index))
        first = 0 if "rules" in self._free_groups else self.rule_size
        places = np.array([*range(first, self.rule_size + len(self._moving)), *own], dtype=int)
        return jacobian, weight[:, 0] * residual[trace.fitted], places, to_places

    @property
    def _moving(self) -> list[Coordinate]:
        """What all records share of the effects; nothing where it is held and needs no derivatives."""
        return self.common if "effects" in self._free_groups else []

    def _by_coordinates(self, point: np.ndarray) -> np.ndarray:
        """Return what the C core differentiates by, by the coordinates that a record depends on.

        Those are the rules', the effects' and, at the end, its own and its constant.
        """
        slopes = [
            c.slope(v) for c, v in zip(self._moving, point[self._places["effects"]], strict=False)
        ]
        units = [*slopes, *(c.unit for c in self._own), 1.0]
        if "rules" not in self._free_groups:
            return np.diag(units)
        rules = self.rules(point)
        scaled = rule_coordinates.chain_rule(np.eye(self.rule_size), rules)
        result = np.diag([*np.zeros(self.rule_size), *units])
        result[: self.rule_size, : self.rule_size] = self.scaling.rule_jacobian(rules) @ scaled
        return result


@dataclass(frozen=True, eq=False)
class ChainFit:
    """An optimum of the criterion.

    Parameters
    ----------
    criterion : ChainCriterion
    minimum : Minimum
    """

    criterion: ChainCriterion
    minimum: Minimum

    @property
    def model(self) -> Model:
        """The fitted model."""
        return self.criterion.unpack(self.minimum.coordinates)

    @property
    def rms(self) -> float:
        """Weighted root mean square of the residuals, in the unit of the scaling."""
        return float(np.sqrt(2.0 * self.minimum.cost / self.criterion.samples))


def minimise(criterion: ChainCriterion, max_iterations: int, tolerance: float = 1e-6) -> ChainFit:
    """Minimise the criterion by Levenberg-Marquardt from the model that it was made with."""
    start = criterion.pack(criterion.model)
    return ChainFit(criterion, minimise_from(criterion, start, max_iterations, tolerance))


def minimise_from(
    criterion: ChainCriterion, start: np.ndarray, max_iterations: int, tolerance: float = 1e-6
) -> Minimum:
    """Minimise the criterion by Levenberg-Marquardt from coordinates, shape (P,)."""
    return levenberg_marquardt(
        criterion.residual,
        criterion.linearise,
        np.clip(start, criterion.lower, criterion.upper),
        criterion.lower,
        criterion.upper,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )
