"""The fit for a given number of rules: free runs from many starts, then from the best found."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, islice
from math import ceil

import numpy as np

from it2hys.identification import usability, variable_projection
from it2hys.identification.criterion import (
    ChainCriterion,
    ChainFit,
    Trace,
    minimise_from,
    paper_model,
    paper_problem,
)
from it2hys.identification.excerpts import excerpt
from it2hys.identification.levenberg_marquardt import Minimum
from it2hys.identification.result import IdentificationError, Options, Start
from it2hys.identification.scaling import Scaling
from it2hys.identification.solvers import solve

#: Pairs from which the consequents of a start are found.
_PAIRS = 600
#: One-step iterations of every other start; more of them end in the poor optima of that criterion.
_NEARING = 8
#: Starts of a batch, and the share of it that is settled.
_BATCH, _PROMISING = 12, 1 / 3
#: Iterations of the two rounds of the search.
_SIFTING, _SETTLING = 30, 80
#: So many starts that agree on the best cost, to this share, end the search.
_AGREEING, _SAME_COST = 3, 1e-3
#: A root mean square error, scaled, below which a model is exact and no better one is sought.
_PERFECT = 1e-6
#: Optima of the search that are continued on the whole records: so many, so near to the best.
_CONTINUED, _NEAR = 3, 0.1


@dataclass(frozen=True, eq=False)
class RuleFit(ChainFit):
    """A free-run optimum of the paper's model.

    Parameters
    ----------
    starts : tuple of Start
        Errors of every start, best first, in m.
    """

    starts: tuple[Start, ...] = ()

    @property
    def rules(self) -> np.ndarray:
        """Scaled rules, shape (L, 6)."""
        return self.criterion.rules(self.minimum.coordinates)

    @property
    def courses(self) -> list[usability.Course]:
        """Scaled voltage and displacement of the records, their fitted constants taken off."""
        return self.criterion.data_courses(self.model.offsets)


def _problem(
    traces: Sequence[Trace],
    scaling: Scaling,
    rules: np.ndarray,
    offsets: np.ndarray | None = None,
    begins: np.ndarray | None = None,
) -> ChainCriterion:
    """Return the guarded problem of the paper's model from scaled rules."""
    model = paper_model(traces, scaling, rules, offsets, begins)
    problem = paper_problem(traces, model, scaling)
    return problem.guarded_by_data(usability.STRENGTHS[0], model.offsets)


def _some_rules(count: int) -> np.ndarray:
    """Return rules that stand for their number alone, shape (L, 6)."""
    return np.tile([1.0, 2.0, 0.0, 0.5, 0.5, 0.0], (count, 1))


def _point(
    problem: ChainCriterion,
    rules: np.ndarray,
    offsets: np.ndarray | None = None,
    begins: np.ndarray | None = None,
) -> np.ndarray:
    """Return the coordinates of scaled rules, of the problem's own constants by default."""
    offsets = problem.model.offsets if offsets is None else offsets
    return problem.pack(paper_model(problem.traces, problem.scaling, rules, offsets, begins))


def rms_of(cost: float, samples: float) -> float:
    """Return the root mean square residual of a cost (23)."""
    return float(np.sqrt(2.0 * cost / samples))


def fit_rules(
    traces: Sequence[Trace],
    scaling: Scaling,
    offsets: np.ndarray,
    rule_count: int,
    options: Options,
    progress: Callable[[float, str], None],
    warm: Sequence[np.ndarray] = (),
    each: Callable = map,
) -> RuleFit:
    """Fit L rules to records, usable over the band of the data if possible.

    Parameters
    ----------
    traces : sequence of Trace
        The training records.
    scaling : Scaling
    offsets : ndarray, shape (R,)
        Guesses of the records' constants, m.
    rule_count : int
        Number of rules L.
    options : Options
    progress : callable
        Told the share done and what is being done.
    warm : sequence of ndarray, each of shape (L, 6)
        Further starts, scaled, such as those of a smaller model.
    each : callable
        A `map`; one over processes shares the work among them.

    Returns
    -------
    RuleFit

    Raises
    ------
    IdentificationError
        If every start diverges.
    """
    windows, records = excerpt(traces)
    some = _some_rules(rule_count)
    brief = _problem(windows, scaling, some, offsets[records])
    found = _search(brief, options, lambda share, text: progress(0.7 * share, text), warm, each)
    progress(0.7, f"L = {rule_count}: final fit")
    problem = _problem(traces, scaling, some, offsets)
    points = [
        _transferred(brief, m, problem, records)
        for m in _distinct([m for m, _ in found])[:_CONTINUED]
        if m.cost <= found[0][0].cost * (1.0 + _NEAR)
    ]
    settling = replace(options, max_iterations=min(_SETTLING, options.max_iterations))
    best = min(each(partial(solve, problem, options=settling), points), key=lambda m: m.cost)
    best = solve(problem, best.coordinates, options)
    starts = tuple(
        Start(one_step * scaling.y_unit, rms_of(m.cost, brief.samples) * scaling.y_unit)
        for m, one_step in found
    )
    return make_usable(RuleFit(problem, best, starts), options)


def search_rules(
    traces: Sequence[Trace],
    scaling: Scaling,
    rule_count: int,
    options: Options,
    warm: Sequence[np.ndarray] = (),
    each: Callable = map,
) -> np.ndarray:
    """Return the rules with which `fit_rules` would begin its final fit: a start for another one.

    Parameters and errors as there.
    """
    brief = _problem(excerpt(traces)[0], scaling, _some_rules(rule_count))
    found = _search(brief, options, lambda share, text: None, warm, each)
    return brief.rules(found[0][0].coordinates)


def _search(
    criterion: ChainCriterion,
    options: Options,
    progress: Callable[[float, str], None],
    warm: Sequence[np.ndarray],
    each: Callable,
) -> list[tuple[Minimum, float]]:
    """Return where the starts led, best first, each with the one-step error that it began with.

    In batches, until several starts agree on the best optimum or all are spent. Raises
    IdentificationError if every start diverges.
    """
    generator = np.random.default_rng(options.seed)
    warmed = ((_point(criterion, rules), np.nan) for rules in warm)
    starts = chain(warmed, draw_starts(criterion, generator))
    total = options.starts + len(warm)
    nearing = partial(minimise_from, criterion, tolerance=criterion.rough_tolerance)
    sift = partial(nearing, max_iterations=_SIFTING)
    settle = partial(nearing, max_iterations=_SETTLING)
    found: list[tuple[Minimum, float]] = []
    while len(found) < total and not _agreed([m for m, _ in found], criterion.samples):
        points, errors = zip(*islice(starts, min(_BATCH, total - len(found))), strict=True)
        sifted = []
        for minimum, one_step in zip(each(sift, points), errors, strict=True):
            sifted.append((minimum, one_step))
            share = (len(found) + len(sifted)) / total
            progress(share, f"L = {criterion.rule_count}: free-run fits")
        sifted.sort(key=lambda pair: pair[0].cost)
        promising = sifted[: ceil(_PROMISING * len(sifted))]
        settled = each(settle, [minimum.coordinates for minimum, _ in promising])
        sifted[: len(promising)] = [(m, e) for m, (_, e) in zip(settled, promising, strict=True)]
        found = sorted(found + sifted, key=lambda pair: pair[0].cost)
    if not np.isfinite(found[0][0].cost):
        raise IdentificationError(
            f"no free run with {criterion.rule_count} rules stays finite on the training records: "
            "check that voltage and displacement are of one measurement and in the right columns"
        )
    return found


def drawn_starts(
    traces: Sequence[Trace], scaling: Scaling, rules: np.ndarray, seed: int
) -> tuple[ChainCriterion, Iterator[tuple[np.ndarray, float]]]:
    """Return the guarded problem of the paper's model from scaled rules, and starts for it.

    See `draw_starts`.
    """
    problem = _problem(traces, scaling, rules)
    return problem, draw_starts(problem, np.random.default_rng(seed))


def draw_starts(
    criterion: ChainCriterion, generator: np.random.Generator
) -> Iterator[tuple[np.ndarray, float]]:
    """Yield coordinates of starts and their one-step errors, without end.

    Antecedents are drawn; the consequents that go with them are those of the one-step criterion,
    which is linear in them. Half of the starts first go some way towards an optimum of it: which
    half finds the optimum in free run differs from one set of records to the next.
    """
    has_offset = np.array([t.has_offset for t in criterion.traces])
    measured = criterion.data_courses(np.zeros(len(criterion.traces)))
    problem = _projected(criterion, measured, has_offset, generator)
    guesses = np.array(criterion.model.offsets)
    y = np.concatenate([y[used] for _, y, used in criterion.data_courses(guesses)])
    unit = criterion.scaling.y_unit
    for i, antecedents in enumerate(
        variable_projection.antecedent_starts(y, criterion.rule_count, generator)
    ):
        # Offsets start from their guesses and from nothing in turn: a guess from a static curve is
        # poor where the loops' phase lag differs between records.
        offsets = guesses if i // 2 % 2 == 0 else 0.0 * guesses
        point = np.concatenate([antecedents, offsets[has_offset] / unit])
        if i % 2:
            point = variable_projection.fit_projected(problem, point, _NEARING).coordinates
            offsets = offsets.copy()
            offsets[has_offset] = unit * problem.offsets(point)
        residual = problem.residual(point)
        one_step = float(np.sqrt(residual @ residual / len(problem.y)))
        yield _point(criterion, problem.rules(point), offsets), one_step


def _agreed(minima: Sequence[Minimum], samples: float) -> bool:
    """Return whether the best minimum, the first, is perfect or enough have practically its cost."""
    if len(minima) < _AGREEING:
        return False
    if rms_of(minima[0].cost, samples) < _PERFECT:
        return True
    return minima[_AGREEING - 1].cost <= minima[0].cost * (1.0 + _SAME_COST)


def _transferred(
    brief: ChainCriterion, minimum: Minimum, criterion: ChainCriterion, records: np.ndarray
) -> np.ndarray:
    """Return a point of the criterion of an excerpt as one of the whole records' criterion."""
    offsets = brief.unpack(minimum.coordinates).offsets
    means = [float(np.mean(offsets[records == i])) for i in range(len(criterion.traces))]
    return _point(criterion, brief.rules(minimum.coordinates), np.array(means))


def make_usable(fit: RuleFit, options: Options) -> RuleFit:
    """Return the fit, refitted with rising penalties until it is usable over the band of data.

    The penalties vanish where the model is usable, so they do not move the optimum of such a model.
    """
    for strength in usability.STRENGTHS[1:]:
        if usability.is_usable(fit.rules, usability.Band.of_data(fit.courses)):
            break
        criterion = fit.criterion.guarded_by_data(strength, fit.model.offsets)
        minimum = solve(criterion, fit.minimum.coordinates, options)
        fit = replace(fit, criterion=criterion, minimum=minimum)
    return fit


def shake(
    fit: RuleFit,
    rounds: int,
    options: Options,
    progress: Callable[[float, str], None],
    each: Callable = map,
) -> RuleFit:
    """Return the fit, or a better one reached from disturbances of it.

    A poor optimum mostly has one rule where none is needed: each rule in turn gets a new, random
    antecedent. In between, all rules are drawn anew, for weights and offsets may have changed since
    the first search.

    Parameters
    ----------
    fit : RuleFit
    rounds : int
        How often each rule is replaced, and all are drawn, without a gain before the search ends.
    options : Options
    progress : callable
    each : callable
        A `map`.

    Returns
    -------
    RuleFit
    """
    windows, records = excerpt(fit.criterion.traces)
    brief = _problem(windows, fit.criterion.scaling, fit.rules, fit.model.offsets[records])
    original = minimise_from(brief, brief.pack(brief.model), _SETTLING)
    best, idle, limit = original, 0, rounds * brief.rule_count
    generator = np.random.default_rng(options.seed + 1)
    fresh_starts = draw_starts(brief, generator)
    sift = partial(minimise_from, brief, max_iterations=_SIFTING)
    settle = partial(minimise_from, brief, max_iterations=_SETTLING)
    while idle < limit and rms_of(best.cost, brief.samples) > _PERFECT:
        progress(idle / limit, "search around the best fit")
        disturbed = _with_new_rule(brief, best.coordinates, idle % brief.rule_count, generator)
        fresh, _ = next(fresh_starts)
        before = best.cost
        sifted = each(sift, [disturbed, fresh])
        near = [m.coordinates for m in sifted if m.cost < before * (1.0 + _NEAR)]
        best = min([best, *each(settle, near)], key=lambda m: m.cost)
        idle = 0 if best.cost < before * (1.0 - _SAME_COST) else idle + 1
    if best is original:
        return fit
    start = _transferred(brief, best, fit.criterion, records)
    minimum = solve(fit.criterion, start, options)
    if minimum.cost >= fit.minimum.cost:
        return fit
    return make_usable(replace(fit, minimum=minimum), options)


def _with_new_rule(
    criterion: ChainCriterion, point: np.ndarray, rule: int, generator: np.random.Generator
) -> np.ndarray:
    """Return the coordinates of a model with one rule replaced and the consequents fitted anew.

    They are fitted to the run of the model in place of the measurement: without noise in y(k-1),
    which biases that fit.
    """
    model, scaling = criterion.unpack(point), criterion.scaling
    modelled = [
        (scaling.x(t.drive.voltage), scaling.y(model.run(t, i)[0]), t.weight > 0.0)
        for i, t in enumerate(criterion.traces)
    ]
    y = np.concatenate([y[used] for _, y, used in modelled])
    count = criterion.rule_count
    # the first is not random in its centres
    _, drawn = islice(variable_projection.antecedent_starts(y, count, generator), 2)
    antecedents = point[: criterion.rule_size].reshape(count, -1)[:, :3].copy()
    fresh = drawn.reshape(-1, 3)
    # the rule of the spread that is nearest to a gap between the others
    antecedents[rule] = fresh[_emptiest(fresh, np.delete(antecedents, rule, axis=0))]
    problem = _projected(criterion, modelled, np.zeros(len(modelled), dtype=bool), generator)
    rules = problem.rules(antecedents.ravel())
    return _point(criterion, rules, model.offsets, model.own["initialDisplacement"])


def _emptiest(candidates: np.ndarray, others: np.ndarray) -> int:
    """Return which candidate's centre is farthest from the centres of all other rules."""
    if len(others) == 0:
        return 0
    return int(np.argmax(np.min(np.abs(candidates[:, 2:] - others[:, 2]), axis=1)))


def refit(fit: RuleFit, traces: Sequence[Trace], options: Options) -> RuleFit:
    """Return the fit continued on changed records: other weights, discards or constants."""
    model = fit.model
    own = np.where([t.has_offset for t in traces], model.offsets, 0.0)
    begins = model.own["initialDisplacement"]
    problem = _problem(traces, fit.criterion.scaling, fit.rules, own, begins)
    minimum = solve(problem, problem.pack(problem.model), options)
    return make_usable(RuleFit(problem, minimum, fit.starts), options)


def _projected(
    criterion: ChainCriterion,
    courses: Sequence[usability.Course],
    has_offset: np.ndarray,
    generator: np.random.Generator,
) -> variable_projection.ProjectedOneStep:
    """Return the projected one-step criterion on some of the pairs of the records."""
    parts, offset_count = [], 0
    for trace, (x, y, _), own in zip(criterion.traces, courses, has_offset, strict=True):
        # a pair is as good as the worse of its two readings
        weight = np.minimum(trace.weight[:-1], trace.weight[1:])
        used = weight > 0
        group = np.full(np.count_nonzero(used), offset_count if own else -1)
        offset_count += int(own)
        parts.append((y[:-1][used], x[1:][used], y[1:][used], weight[used], group))
    pairs = [np.concatenate(columns) for columns in zip(*parts, strict=True)]
    chosen = generator.permutation(len(pairs[0]))[:_PAIRS]
    return variable_projection.ProjectedOneStep(
        *(p[chosen] for p in pairs), offset_count, criterion.rule_count
    )


def _distinct(minima: Sequence[Minimum]) -> list[Minimum]:
    """Return sorted minima without those that have practically the cost of a better one."""
    kept = [minima[0]]
    for minimum in minima[1:]:
        if minimum.cost > kept[-1].cost * (1.0 + _SAME_COST):
            kept.append(minimum)
    return kept
