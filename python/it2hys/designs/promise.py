"""The probability that a record decides between models, before it is measured.

One model's readings on a voltage are fitted by another model: the difference that remains
(T-optimality) is compared with the one by which the diagnosis calls one of two models the better one.
Refits are those of the identification, by the exact sensitivities of the compiled chain.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.stats import norm

from it2hys.designs.families import FAMILIES
from it2hys.designs.hypotheses import Hypothesis, Question, trace_of
from it2hys.designs.limits import Limits
from it2hys.diagnosis.chances import chance_of_a_rival, largest_chance, level_of_planned
from it2hys.diagnosis.comparison import block_length, chance_of_sizes
from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.variants import is_delay, is_sampling, with_effect
from it2hys.identification.coverage import is_one_tone
from it2hys.identification.criterion import ChainCriterion, ChainFit, Model, Trace, minimise
from it2hys.identification.scaling import Scaling
from it2hys.identification.starts import Starts
from it2hys.identification.traces import set_aside
from it2hys.identification.uncertainty import assess
from it2hys.policy import COVERAGE, DESIGN, SEARCH
from it2hys.records.clues import Extent

#: Iterations of a refit while designs are compared, and of one that a promise rests on.
_QUICK, _THOROUGH = 8, 60
#: Guesses of an effect from which it is fitted first to what another one makes.
_GUESSES = 6
#: Standard deviations by which a test statistic of the wanted power is above its threshold.
_SURE = float(norm.ppf(DESIGN.decides))
#: Arguments at which a cumulant generating function is looked at for its minimum.
_TILTS = -np.geomspace(1e-2, 1e3, 61)
#: Draws of errors that stand for what noise usually makes of a comparison.
_DRAWS = 15
_TINY = np.finfo(float).tiny
#: Jacobians that are kept: those of the models on the last few voltages.
_KEPT = 24
#: Differences of so many half travels are those of runs on their way to infinity.
_FAR = 1e3


@dataclass(frozen=True)
class Separation:
    """How well a record separates one model from another that is refitted to its readings.

    Parameters
    ----------
    truth, rival : str
        The model that makes the readings, and the one that is refitted to them.
    distance : float
        Root of the sum of squares of the difference after the refit, in units of the noise.
    gain : float
        Expected share by which the error of the truth is smaller, on the samples that decide.
    power : float
        Probability that the diagnosis tells the truth: that it calls it the better model, or does not
        take the rival into account. Not a number where the run of a model is on its way to infinity.
    score : float
        Log of what is left over, by what is needed for the wanted power; positive where it decides.
    refused : bool
        Whether the refitted rival does no more than a delay, or another sampling, would: the diagnosis
        takes no such effect, however near its readings are.
    rejected : float
        Probability that the refitted rival is no better than the model without the effects, by enough
        and by more than chance: the diagnosis takes none into account that is not.
    """

    truth: str
    rival: str
    distance: float
    gain: float
    power: float
    score: float
    refused: bool = False
    rejected: float = 0.0


@dataclass(frozen=True)
class Odds:
    """Whether a diagnosis will call one of two models the better one.

    Parameters
    ----------
    gain : float
        Expected share by which its error is smaller, on the samples that decide.
    beyond : float
        Standard deviations by which what is compared is above what is asked for.
    sure, surely_not : float
        Log of what is compared, by what makes it certain enough that it is called so, or that it is
        not; positive where it is certain enough.
    """

    gain: float
    beyond: float
    sure: float
    surely_not: float

    @property
    def power(self) -> float:
        """Probability that it is called the better one."""
        return float(norm.cdf(self.beyond))


@dataclass(frozen=True, eq=False)
class Left:
    """What a rival leaves of the readings of the truth once it is refitted.

    Parameters
    ----------
    course : ndarray, shape (N,), or None
        Rival less truth, m; None where the run of one is on its way to infinity, so that the voltage is
        none that they can be compared on.
    deciding : ndarray of bool, shape (N,)
        M samples that decide.
    refused : bool
        As in `Separation`.
    spread : ndarray, shape (M, P)
        How the refitted truth is off where it is decided, in units of the noise, by P independent
        normal variables: what is fitted tells its parameters to an error.
    """

    course: np.ndarray | None
    deciding: np.ndarray
    refused: bool
    spread: np.ndarray


@dataclass(frozen=True, eq=False)
class Ground:
    """The models and limits of a question, and what refits of them start from.

    Parameters
    ----------
    question : Question
    limits : Limits
    """

    question: Question
    limits: Limits

    @cached_property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """The rivals, at rest where a record begins."""
        return tuple(h.at_rest(self.limits.rest) for h in self.question.hypotheses)

    @cached_property
    def neither(self) -> Hypothesis | None:
        """The model without what they differ in, at rest where a record begins."""
        known = self.question.neither
        return None if known is None else known.at_rest(self.limits.rest)

    @cached_property
    def pairs(self) -> list[tuple[Hypothesis, Hypothesis]]:
        """The rivals, each with all others that it has to be told from."""
        if len(self.hypotheses) < 2:
            return []
        others = [*self.hypotheses, *([self.neither] if self.neither else [])]
        return [(truth, rival) for truth in self.hypotheses for rival in others if rival is not truth]

    @cached_property
    def sought(self) -> list[tuple[Hypothesis, Hypothesis]]:
        """The pairs that a record is to tell: the rivals smaller and of other kinds are truths, too.

        What is twice as large as usual is told the best.
        """
        return [(t, rival) for h, rival in self.pairs for t in (h, *h.sizes[:1], *h.variants)]

    @cached_property
    def probe(self) -> np.ndarray:
        """A voltage that shows a little of all: steps, reversals and sines, V."""
        family = FAMILIES["steps, reversals and multisine"]
        return family.voltage(np.full(family.size, 0.6), self.limits)

    @cached_property
    def scaling(self) -> Scaling:
        """That of the displacements on the probe."""
        return Scaling.of_data(self._readings, np.array([self.limits.low, self.limits.high]))

    @cached_property
    def extent(self) -> Extent:
        """What a record within the limits spans."""
        limits, y = self.limits, self._readings
        return Extent(
            limits.sample_time,
            limits.samples * limits.periods * limits.sample_time,
            (limits.low, limits.high),
            (float(y.min()), float(y.max())),
            zero=self.question.base["displacementZero"],
        )

    @cached_property
    def _readings(self) -> np.ndarray:
        runs = [self.reading(h, self.probe) for h in self.hypotheses]
        return np.concatenate(runs)

    @cached_property
    def _starts(self) -> dict[tuple[str, str], Model]:
        return {}

    def start(self, truth: Hypothesis, rival: Hypothesis) -> Model:
        """Return a rival as it is when refitted to what the truth makes of the probe."""
        key = truth.name, rival.name
        if key not in self._starts:
            self._starts[key] = self._imitation(truth, rival)
        return self._starts[key]

    def reading(self, hypothesis: Hypothesis, voltage: np.ndarray) -> np.ndarray:
        """Return what a model reads on a voltage, (N,), without noise, m."""
        trace = trace_of(voltage, voltage, 0.0, self.limits.sample_time)
        return hypothesis.model.predict(trace, 0)

    def trace(self, voltage: np.ndarray, y: np.ndarray) -> Trace:
        """Return a record of this noise."""
        return trace_of(voltage, y, self.question.noise, self.limits.sample_time)

    def fit(self, traces: Sequence[Trace], model: Model, iterations: int) -> ChainFit:
        """Return a fit of everything to records, from a model."""
        return minimise(Starts(list(traces), self.scaling, self.extent).criterion(model), iterations)

    def _imitation(self, truth: Hypothesis, rival: Hypothesis) -> Model:
        """Return the rival as near to what the truth makes of the probe as refits bring it.

        They start from its own parameters, and from guesses of its effects where these are its own.
        """
        trace = self.trace(self.probe, self.reading(truth, self.probe))
        starts = [rival.model]
        if len(rival.own) == 1 and self.neither is not None:
            guesses = EVIDENCE[rival.own[0]].guesses(
                Starts([trace], self.scaling, self.extent).clues(self.neither.model)
            )
            places = np.unique(np.linspace(0, len(guesses) - 1, _GUESSES).round().astype(int))
            chosen = [guesses[i] for i in places] if guesses else []
            starts += [with_effect(self.neither.model, rival.own[0], g, self.extent) for g in chosen]
        best = self._best_fit(trace, starts)
        return best.model if np.isfinite(best.minimum.cost) else rival.model

    def _best_fit(self, trace: Trace, starts: Sequence[Model]) -> ChainFit:
        """Return the fit from the start that is the best after a few iterations."""
        fits = [self.fit([trace], start, _QUICK) for start in starts]
        best = min(fits, key=lambda fit: fit.minimum.cost)
        return self.fit([trace], best.model, _THOROUGH) if np.isfinite(best.minimum.cost) else best

    # --- one of several ------------------------------------------------------------------------------

    @np.errstate(over="ignore", invalid="ignore")
    def left_over(
        self, truth: Hypothesis, rival: Hypothesis, voltage: np.ndarray, thorough: bool = False
    ) -> Left:
        """Return what a rival leaves of the readings of the truth on a voltage once it is refitted.

        Parameters
        ----------
        truth, rival : Hypothesis
        voltage : ndarray, shape (N,)
        thorough : bool
            Refit to the end, from the better start, and as the diagnosis does: without what decides.
        """
        y = self.reading(truth, voltage)
        trace = self.trace(voltage, y)
        (fitted,), (deciding,) = set_aside([trace])
        starts = [self.start(truth, rival), rival.model]
        if thorough:
            found = self._best_fit(fitted, starts)
        else:
            found = self.fit([trace], starts[0], _QUICK)
            if not np.isfinite(found.minimum.cost):
                found = self.fit([trace], starts[1], _QUICK)
        left = found.model.predict(trace, 0) - y
        jacobian, refused = self._jacobian(truth, voltage), is_refused(found.model, rival)
        if jacobian is None or not np.all(np.abs(left) < _FAR * self.scaling.y_unit):
            return Left(None, deciding.judged, refused, np.empty((0, 0)))
        spread = spread_of(jacobian, fitted.weight > 0.0, deciding.judged)
        return Left(left, deciding.judged, refused, spread)

    def judged(
        self,
        truth: Hypothesis,
        rival: Hypothesis,
        left: Left,
        without: Left | None = None,
        quieter: float = 1.0,
    ) -> Separation:
        """Return what the diagnosis would make of a difference that is left, as `left_over` has it.

        `without` is what the model without the effects leaves, in comparison with which the diagnosis
        takes a rival into account or not; by default it does. The noise is `quieter` times smaller than
        the question's.
        """
        if left.course is None:
            return Separation(truth.name, rival.name, np.inf, np.nan, np.nan, -np.inf)
        noise = self.question.noise / quieter
        distance = float(np.linalg.norm(left.course)) / noise
        if left.refused:
            return Separation(truth.name, rival.name, distance, 0.0, 1.0, np.inf, refused=True)
        off = left.course[left.deciding] / noise
        least, chance = DESIGN.base_gain, self.chance_beside_neither
        if rival.own:
            least, chance = SEARCH.telling, chance_of_a_rival
        told = odds(off, np.zeros_like(off), left.spread, least, chance)
        score, rejected = told.sure, 0.0
        if without is not None and without.course is not None:
            apart = without.course[left.deciding] / noise
            taken = odds(apart, off, left.spread, SEARCH.least_gain, self.chance_beside_neither)
            score, rejected = max(score, taken.surely_not), 1.0 - taken.power
        power = 1.0 - (1.0 - told.power) * (1.0 - rejected)
        return Separation(truth.name, rival.name, distance, told.gain, power, score, rejected=rejected)

    def chance_beside_neither(self, gain: float) -> float:
        """Return the p-value up to which an effect counts by a gain over the model without any."""
        return largest_chance(gain, level_of_planned(len(self.hypotheses)))

    def is_taken(self, voltage: np.ndarray) -> bool:
        """Return whether a diagnosis from the model without effects takes a record of a voltage, (N,).

        It calls a delay, a lag and play inseparable where the voltage has one amplitude at one
        frequency, whatever their difference. It refuses records that move far less, or more, than that
        model does at rest over the same voltages: as if they were in another unit. One that is all too
        fast moves less. Here half of what it allows is used, for what is not known of the stage.
        """
        base = self.question.base
        if is_one_tone(voltage, self.limits.sample_time):
            return False
        share = np.ptp(voltage) / np.ptp(base.voltage_range)
        at_rest = share * float(np.ptp(base.displacement_range))
        most = 1.0 + 0.5 * (COVERAGE.same_unit - 1.0)
        spans = np.array([np.ptp(self.reading(h, voltage)) for h in self.hypotheses])
        return bool(np.all((spans < most * at_rest) & (spans > at_rest / most)))

    # --- parameters of one ---------------------------------------------------------------------------

    def information(self, voltage: np.ndarray, of_effects: bool = False) -> float:
        """Return how much a record tells of the parameters, nats a parameter, the least of all models.

        It is half the logarithm of the determinant (D-optimality) of the information on the coordinates
        of a fit, for whose prior a standard deviation of 1 stands.

        Parameters
        ----------
        voltage : ndarray, shape (N,)
        of_effects : bool
            On the effects' parameters alone, all else being free; on all where there are none.
        """
        return min(self._information(h, voltage, of_effects) for h in self.hypotheses)

    def _information(self, hypothesis: Hypothesis, voltage: np.ndarray, of_effects: bool) -> float:
        jacobian = self._jacobian(hypothesis, voltage)
        if jacobian is None:
            return -np.inf
        criterion, count = self._criterion(hypothesis, voltage), jacobian.shape[1]
        factor = np.linalg.qr(np.vstack([jacobian, np.eye(count)]), mode="r")
        if not (of_effects and criterion.common):
            return float(np.sum(np.log(np.abs(np.diag(factor)))) / count)
        inverse = solve_triangular(factor, np.eye(count))[criterion.places_of_common]
        return float(-0.5 * np.linalg.slogdet(inverse @ inverse.T)[1] / len(inverse))

    def _criterion(self, hypothesis: Hypothesis, voltage: np.ndarray) -> ChainCriterion:
        trace = self.trace(voltage, self.reading(hypothesis, voltage))
        return Starts([trace], self.scaling, self.extent).criterion(hypothesis.model)

    @np.errstate(over="ignore", invalid="ignore")
    def _jacobian(self, hypothesis: Hypothesis, voltage: np.ndarray) -> np.ndarray | None:
        """Return the derivatives of a model's readings by the coordinates of its fit, (N + K, P).

        They are in units of the noise; the last K rows are of what a fit knows beside the record. None
        where the run is on its way to infinity. Those of the last voltages asked for are kept.
        """
        key = (hypothesis, voltage.tobytes())
        if key not in self._jacobians:
            while len(self._jacobians) >= _KEPT:
                del self._jacobians[next(iter(self._jacobians))]
            criterion = self._criterion(hypothesis, voltage)
            linear = criterion.jacobian(criterion.pack(hypothesis.model))
            scale = self.scaling.y_unit / self.question.noise
            self._jacobians[key] = None if linear is None else linear[0] * scale
        return self._jacobians[key]

    @cached_property
    def _jacobians(self) -> dict[tuple[Hypothesis, bytes], np.ndarray | None]:
        return {}

    def intervals(
        self, hypothesis: Hypothesis, voltage: np.ndarray, seed: int = 0
    ) -> dict[str, tuple[float, float]]:
        """Return the 95 % intervals of a model's parameters on a record, by FMU name, SI units.

        They are those of the report of a fit, at the truth, to a record with noise. There are none
        where the model's run on the voltage is on its way to infinity.
        """
        y = self.reading(hypothesis, voltage)
        noisy = y + self.noise_draw(len(y), np.random.default_rng(seed))
        trace = self.trace(voltage, noisy)
        criterion = Starts([trace], self.scaling, self.extent).criterion(hypothesis.model)
        if criterion.jacobian(criterion.pack(hypothesis.model)) is None:
            return {}
        found = assess(minimise(criterion, 0)).intervals
        effects = {n: ends for n, ends in found.items() if not n.startswith("rule[")}
        return effects or found

    def noise_draw(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Return noise of the question's size, (count,), m."""
        return self.question.noise * rng.standard_normal(count)


def spread_of(jacobian: np.ndarray, fitted: np.ndarray, deciding: np.ndarray) -> np.ndarray:
    """Return how a fit is off on other samples than it is of, (M, P), in units of the noise.

    Parameters
    ----------
    jacobian : ndarray, shape (N + K, P)
        Derivatives in units of the noise, by coordinates for whose prior a standard deviation of 1
        stands; the last K rows count in every fit.
    fitted, deciding : ndarray of bool, shape (N,)
        Samples that are fitted, and M others.

    Returns
    -------
    ndarray, shape (M, P)
        By what each of P independent standard normal variables changes the fit.
    """
    size, count = len(fitted), jacobian.shape[1]
    known = [jacobian[:size][fitted], jacobian[size:], np.eye(count)]
    factor = np.linalg.qr(np.vstack(known), mode="r")
    return solve_triangular(factor, jacobian[:size][deciding].T, trans="T").T


def odds(
    worse: np.ndarray,
    better: np.ndarray,
    spread: np.ndarray,
    least: float,
    chance: Callable[[float], float],
) -> Odds:
    """Return whether a diagnosis will call one of two models better than the other.

    It compares mean squares of both errors on the samples that decide, by the signs of blocks, and asks
    for a gain besides: what is less likely decides. The errors are those without noise, and noise, and
    what both fits make of the noise of the samples that are fitted.

    Parameters
    ----------
    worse, better : ndarray, shape (M,)
        Errors of both models without noise, in units of the noise.
    spread : ndarray, shape (M, P)
        As in `Left`.
    least : float
        Gain that is asked for.
    chance : callable
        Returns the largest p-value at which a gain counts.
    """
    count = len(worse)
    more, less = float(np.mean(worse**2)), float(np.mean(better**2))
    floor = less + 1.0 + float(np.mean(np.sum(spread**2, axis=1)))
    needed, difference = floor * (1.0 / (1.0 - least) ** 2 - 1.0), worse - better
    by_chance = 2.0 * np.sqrt(np.sum(difference**2) + np.sum((difference @ spread) ** 2)) / count
    by_chance = max(float(by_chance), _TINY)
    gain = float(1.0 - np.sqrt(floor / max(floor + more - less, _TINY)))
    above, threshold = above_chance(worse, better, spread), float(norm.isf(chance(gain)))
    found = max(more - less, _TINY)
    return Odds(
        gain,
        float(min((more - less - needed) / by_chance, above - threshold)),
        float(min(np.log(found / (needed + _SURE * by_chance)), _twice_log(above, threshold + _SURE))),
        float(max(np.log(needed / (found + _SURE * by_chance)), _twice_log(threshold, above + _SURE))),
    )


def _twice_log(deviations: float, needed: float) -> float:
    """Return the log of squares of deviations, as mean squares of errors are compared."""
    return 2.0 * float(np.log(deviations / needed))


def above_chance(worse: np.ndarray, better: np.ndarray, spread: np.ndarray) -> float:
    """Return by how many standard deviations a comparison by blocks finds a model better, usually.

    Errors are drawn: noise, and what the fits make of noise, to which both models' own errors are
    added. The differences X of their squares in blocks are given random signs, and it counts how rarely
    those that are turned sum up to no more than 0: their cumulant generating function
    is K(t) = sum log((1 + exp(X t)) / 2), and the probability about exp(min K) (saddle point). Few
    blocks are compared by their sizes. The median of the draws counts.

    Parameters
    ----------
    worse, better, spread
        As in `odds`.

    Returns
    -------
    float
        Of a normal variable which is exceeded as rarely; positive.
    """
    rng = np.random.default_rng(0)
    errors = rng.standard_normal((_DRAWS, len(worse)))
    errors += rng.standard_normal((_DRAWS, spread.shape[1])) @ spread.T
    length = block_length(worse**2 - better**2 + 2.0 * errors[0] * (worse - better))
    whole = len(worse) // length * length
    squares = np.stack([(errors + worse) ** 2, (errors + better) ** 2], axis=-1)[:, :whole]
    blocks = squares.reshape(_DRAWS, -1, length, 2).mean(axis=2)
    if blocks.shape[1] <= SEARCH.few_blocks:
        above = norm.isf(chance_of_sizes(blocks))
    else:
        gains = blocks[..., 0] - blocks[..., 1]
        gains /= np.sqrt(np.maximum(np.mean(gains**2, axis=1, keepdims=True), _TINY))
        tilted = np.logaddexp(0.0, _TILTS[:, None, None] * gains) - np.log(2.0)
        above = np.sqrt(-2.0 * np.minimum(np.min(np.sum(tilted, axis=2), axis=0), 0.0))
    return float(max(np.median(above), _TINY))


def is_refused(model: Model, rival: Hypothesis) -> bool:
    """Return whether a refitted rival has an effect that a diagnosis takes for sampling or a delay."""
    return any(is_sampling(model, effect) or is_delay(model, effect) for effect in rival.own)


def worst(separations: Iterable[Separation]) -> Separation:
    """Return the separation that is least likely to be seen, or the one that is not known."""
    return min(separations, key=lambda s: (np.nan_to_num(s.power, nan=-1.0), s.score))
