"""The fit for a given number of rules: one step ahead from many starts, then the free run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from it2hys import core
from it2hys.identification import usability, variable_projection
from it2hys.identification.criteria import FreeRun, Series
from it2hys.identification.levenberg_marquardt import Minimum, levenberg_marquardt
from it2hys.identification.result import IdentificationError, Options, Start

#: Pairs used while the starts are sifted, and to polish the best of them.
_FEW_PAIRS = 600
_MANY_PAIRS = 6000
#: Iterations of the three rounds of the one-step fit and of the first round in free run.
_SIFTING, _SETTLING, _POLISHING, _TRYING = 40, 200, 30, 20
#: Disturbances of the best fit: rounds of replacing each rule, then sizes by which all are moved.
_REPLACING_ROUNDS = 2
_MOVES = (0.2, 0.1, 0.2)
#: Steps of the one-step fit after a disturbance.
_SHAKEN_STEPS = 20
#: Two optima are the same if their costs differ by less than this share.
_SAME_COST = 1e-4
#: Strengths of the penalties for an unusable model, tried in turn.
_STRENGTHS = (1.0, 1e1, 1e2, 1e3)


@dataclass(frozen=True, eq=False)
class Fit:
    """A free-run optimum.

    Parameters
    ----------
    criterion : FreeRun
        What was minimised.
    minimum : Minimum
        Where it ended.
    starts : tuple of Start
        Errors of every start, best first, in scaled units.
    """

    criterion: FreeRun
    minimum: Minimum
    starts: tuple[Start, ...] = ()

    @property
    def rules(self) -> np.ndarray:
        """Scaled rules, shape (L, 6)."""
        return self.criterion.rules(self.minimum.coordinates)

    @property
    def rms(self) -> float:
        """Root mean square of the weighted residuals."""
        return rms_of(self.minimum.cost, self.criterion.samples)


def rms_of(cost: float, samples: int) -> float:
    """Return the root mean square residual of a cost (23)."""
    return float(np.sqrt(2.0 * cost / samples))


def fit_rules(
    series: Sequence[Series],
    rule_count: int,
    options: Options,
    progress: Callable[[float, str], None],
    warm: Sequence[np.ndarray] = (),
) -> Fit:
    """Fit L rules to scaled series, usable over the range of the data with its margin if possible.

    Parameters
    ----------
    series : sequence of Series
        The training records.
    rule_count : int
        Number of rules L.
    options : Options
    progress : callable
        Told the share done and what is being done.
    warm : sequence of ndarray, each of shape (L, 6)
        Further starts of the free-run fit, such as those of a smaller model.

    Returns
    -------
    Fit

    Raises
    ------
    IdentificationError
        If every start diverges.
    """
    progress(0.0, f"L = {rule_count}: one-step fits")
    candidates = one_step_candidates(series, rule_count, options)
    criterion = guarded(FreeRun(list(series), rule_count))
    guesses = candidates + [Candidate(np.nan, rules, None) for rules in warm]
    tried = []
    for i, guess in enumerate(guesses):
        progress(0.3 + 0.4 * i / len(guesses), f"L = {rule_count}: free-run fits")
        minimum = minimise_free_run(criterion, start_of(criterion, guess), _TRYING)
        tried.append((minimum, guess.cost))
    tried.sort(key=lambda pair: pair[0].cost)
    if not np.isfinite(tried[0][0].cost):
        raise IdentificationError(
            f"no free run with {rule_count} rules stays finite on the training records: "
            "check that voltage and displacement belong together and are in the right columns"
        )
    progress(0.7, f"L = {rule_count}: final fit")
    finals = [
        minimise_free_run(criterion, m.coordinates, options.max_iterations)
        for m, _ in _distinct(tried)[:2]
    ]
    best = min(finals, key=lambda m: m.cost)
    starts = tuple(
        Start(rms_of(one_step, criterion.samples), rms_of(m.cost, criterion.samples))
        for m, one_step in tried
    )
    return make_usable(Fit(criterion, best, starts), options)


@dataclass(frozen=True, eq=False)
class Candidate:
    """A one-step optimum: where a free-run fit starts.

    Parameters
    ----------
    cost : float
        (23), scaled from the pairs used to all samples, so that it compares with a free run's.
    rules : ndarray, shape (L, 6)
        Scaled rules.
    offsets : ndarray or None
        Offsets of the series that have one; None for their guesses.
    """

    cost: float
    rules: np.ndarray
    offsets: np.ndarray | None


def start_of(criterion: FreeRun, candidate: Candidate) -> np.ndarray:
    """Return the coordinates at which a free-run fit starts."""
    if candidate.offsets is None:
        return criterion.pack(candidate.rules)
    offsets = np.zeros(len(criterion.series))
    offsets[[s.has_offset for s in criterion.series]] = candidate.offsets
    states = [s.state - o for s, o in zip(criterion.series, offsets, strict=True)]
    return criterion.pack(candidate.rules, states, offsets)


def one_step_candidates(
    series: Sequence[Series], rule_count: int, options: Options
) -> list[Candidate]:
    """Return the best one-step optima, one for each basin, best first."""
    generator = np.random.default_rng(options.seed)
    pairs = _pairs(series)
    few = _projected(pairs, _FEW_PAIRS, rule_count, generator)
    guesses = np.array([s.offset for s in series if s.has_offset])
    # Offsets start from nothing and from their guesses in turn: a guess from a static curve is poor
    # where the loops' phase lag differs between records.
    starts = [
        np.concatenate([start, (i % 2) * guesses])
        for i, start in enumerate(
            variable_projection.antecedent_starts(pairs[2], rule_count, options.starts, generator)
        )
    ]
    minima = [variable_projection.fit_projected(few, start, _SIFTING) for start in starts]
    minima = sorted(minima, key=lambda m: m.cost)[: max(options.starts // 3, options.refined)]
    minima = [
        variable_projection.fit_projected(few, m.coordinates, _SETTLING) if not m.converged else m
        for m in minima
    ]
    minima.sort(key=lambda m: m.cost)
    distinct = [m for m, _ in _distinct([(m, None) for m in minima])]
    many = _projected(pairs, _MANY_PAIRS, rule_count, generator)
    polished = [
        variable_projection.fit_projected(many, m.coordinates, _POLISHING)
        for m in distinct[: options.refined]
    ]
    polished.sort(key=lambda m: m.cost)
    share = len(pairs[2]) / len(many.y)
    return [
        Candidate(share * m.cost, many.rules(m.coordinates), many.offsets(m.coordinates))
        for m in polished
    ]


def minimise_free_run(
    criterion: FreeRun, start: np.ndarray, max_iterations: int, tolerance: float = 1e-6
) -> Minimum:
    """Minimise the free-run criterion by Levenberg-Marquardt from one start."""
    return levenberg_marquardt(
        criterion.residual,
        criterion.linearise,
        start,
        criterion.lower,
        criterion.upper,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )


def guarded(
    criterion: FreeRun, strength: float = _STRENGTHS[0], offsets: Sequence[float] | None = None
) -> FreeRun:
    """Return the criterion with penalties for a model unusable over the band of the data.

    The penalties vanish where the model is usable, so they do not move the optimum of such a model.
    """
    if offsets is None:
        offsets = [s.offset for s in criterion.series]
    band = usability.Band.of_data(criterion.series, offsets)
    strength *= np.sqrt(criterion.samples)
    return criterion.with_guard(usability.Guard(criterion.rule_count, band, strength))


def make_usable(fit: Fit, options: Options) -> Fit:
    """Return the fit, refitted with rising penalties until it is usable over the band of data."""
    for strength in _STRENGTHS[1:]:
        offsets = fit.criterion.offsets(fit.minimum.coordinates)
        if usability.is_usable(fit.rules, usability.Band.of_data(fit.criterion.series, offsets)):
            break
        criterion = guarded(fit.criterion, strength, offsets)
        minimum = minimise_free_run(criterion, fit.minimum.coordinates, options.max_iterations)
        fit = replace(fit, criterion=criterion, minimum=minimum)
    return fit


def shake(fit: Fit, options: Options, progress: Callable[[float, str], None]) -> Fit:
    """Return the fit, or a better one reached from disturbances of it.

    A poor optimum mostly has one rule where none is needed. Each rule in turn gets a new, random
    antecedent; then all antecedents are moved a little.

    Parameters
    ----------
    fit : Fit
    options : Options
    progress : callable

    Returns
    -------
    Fit
    """
    criterion, best = fit.criterion, fit.minimum
    generator = np.random.default_rng(options.seed)
    rule_count = criterion.rule_count
    disturbances = [(rule, 0.0) for _ in range(_REPLACING_ROUNDS) for rule in range(rule_count)]
    disturbances += [(None, size) for size in _MOVES]
    for i, (rule, size) in enumerate(disturbances):
        progress(i / len(disturbances), "search around the best fit")
        antecedents = criterion.rule_coordinates(best.coordinates)[:, :3].copy()
        antecedents += size * generator.standard_normal(antecedents.shape)
        if rule is not None:
            fresh = _random_antecedents(criterion, generator)
            # the rule of the spread that is nearest to a gap between the others
            antecedents[rule] = fresh[_emptiest(fresh, np.delete(antecedents, rule, axis=0))]
        start = _from_antecedents(criterion, best.coordinates, antecedents.ravel(), generator)
        minimum = minimise_free_run(criterion, start, _TRYING)
        if minimum.cost < best.cost:
            best = minimum
    if best is fit.minimum:
        return fit
    minimum = minimise_free_run(criterion, best.coordinates, options.max_iterations)
    return make_usable(replace(fit, minimum=minimum), options)


def _random_antecedents(criterion: FreeRun, generator: np.random.Generator) -> np.ndarray:
    """Return antecedents spread over the data, shape (L, 3)."""
    y = np.concatenate([(s.y - s.offset)[s.weight > 0] for s in criterion.series])
    *_, drawn = variable_projection.antecedent_starts(y, criterion.rule_count, 2, generator)
    return drawn.reshape(-1, 3)


def _emptiest(candidates: np.ndarray, others: np.ndarray) -> int:
    """Return which candidate's centre is farthest from the centres of all other rules."""
    if len(others) == 0:
        return 0
    return int(np.argmax(np.min(np.abs(candidates[:, 2:] - others[:, 2]), axis=1)))


def _from_antecedents(
    criterion: FreeRun, point: np.ndarray, antecedents: np.ndarray, generator: np.random.Generator
) -> np.ndarray:
    """Return the coordinates of a start from antecedents, shape (3 L,), with fitted consequents.

    They are fitted, in a few one-step iterations that also move the antecedents, to the run of the
    model at `point` in place of the measurement: without noise in y(k-1), which biases that fit.
    """
    rules, states = criterion.rules(point), criterion.states(point)
    modelled = [
        replace(s, y=core.free_run(rules, s.x, state), has_offset=False)
        for s, state in zip(criterion.series, states, strict=True)
    ]
    problem = _projected(_pairs(modelled), _FEW_PAIRS, criterion.rule_count, generator)
    near = variable_projection.fit_projected(problem, antecedents, _SHAKEN_STEPS)
    return criterion.pack(problem.rules(near.coordinates), states, criterion.offsets(point))


def refit(fit: Fit, series: Sequence[Series], options: Options) -> Fit:
    """Return the fit continued on changed series: other weights, discards or offsets."""
    criterion = guarded(FreeRun(list(series), fit.criterion.rule_count))
    point = fit.minimum.coordinates
    start = criterion.pack(fit.rules, fit.criterion.states(point), fit.criterion.offsets(point))
    minimum = minimise_free_run(criterion, start, options.max_iterations)
    return make_usable(Fit(criterion, minimum, fit.starts), options)


def _pairs(series: Sequence[Series]) -> tuple[np.ndarray, ...]:
    """Return y(k-1), x(k), y(k), weight and number of the offset of all pairs, shape (N,) each."""
    parts, offset_count = [], 0
    for s in series:
        # a pair is as good as the worse of its two readings
        weight = np.minimum(s.weight[:-1], s.weight[1:])
        used = weight > 0
        group = np.full(np.count_nonzero(used), offset_count if s.has_offset else -1)
        offset_count += s.has_offset
        parts.append((s.y[:-1][used], s.x[1:][used], s.y[1:][used], weight[used], group))
    return tuple(np.concatenate(columns) for columns in zip(*parts, strict=True))


def _projected(
    pairs: tuple[np.ndarray, ...], count: int, rule_count: int, generator: np.random.Generator
) -> variable_projection.ProjectedOneStep:
    """Return the projected criterion on some of the pairs."""
    chosen = generator.permutation(len(pairs[0]))[:count]
    return variable_projection.ProjectedOneStep(*(p[chosen] for p in pairs), rule_count)


def _distinct(minima: list[tuple[Minimum, object]]) -> list[tuple[Minimum, object]]:
    """Return sorted minima without those that have practically the cost of a better one."""
    kept = []
    for entry in minima:
        if not kept or entry[0].cost > kept[-1][0].cost * (1.0 + _SAME_COST):
            kept.append(entry)
    return kept
