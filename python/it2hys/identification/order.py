"""Choice of the number of rules by prediction, with a parsimony rule."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from it2hys.identification.criterion import ChainFit, Trace, minimise, paper_model, paper_problem
from it2hys.identification.result import SOLVERS, IdentificationError, Options, OrderTrial
from it2hys.identification.rule_search import fit_rules
from it2hys.identification.scaling import Scaling
from it2hys.policy import COVERAGE

#: Share of every training record set aside where there are no validation records.
_SET_ASIDE = 0.3
#: Largest number of rules that is tried.
_MOST = 6
#: Starts, besides one from the next smaller model, and last iterations of each trial.
_STARTS, _ITERATIONS = 6, 60


def split(traces: Sequence[Trace]) -> tuple[list[Trace], list[Trace]]:
    """Return the records without their ends, and with nothing but the ends to be fitted.

    The set-aside part keeps the samples before it, with weight 0: the free run over them brings
    the model into the state in which the part begins. Of a record that moves only at its end the
    beginning is set aside.
    """
    fitted, decisive = [], []
    for t in traces:
        at_end = np.arange(len(t.y)) >= round(len(t.y) * (1.0 - _SET_ASIDE))
        aside = at_end if _moves(t, ~at_end) else at_end[::-1]
        kept = slice(int(np.argmin(aside)), len(aside) - int(np.argmin(aside[::-1])))
        fitted.append(t.part(kept))
        decisive.append(replace(t, weight=np.where(aside, t.weight, 0.0)))
    return fitted, decisive


def _moves(trace: Trace, part: np.ndarray) -> bool:
    """Return whether a part of a record shows at least half of what the voltage does in all of it."""
    used, voltage = trace.weight > 0, trace.drive.voltage
    seen = part & used
    return bool(np.any(seen)) and np.ptp(voltage[seen]) >= 0.5 * np.ptp(voltage[used])


def choose_rule_count(
    fitted: Sequence[Trace],
    decisive: Sequence[Trace],
    scaling: Scaling,
    offsets: np.ndarray,
    most: int,
    options: Options,
    progress: Callable[[float, str], None],
) -> tuple[np.ndarray, tuple[OrderTrial, ...]]:
    """Choose the number of rules by the free-run error on the records that decide.

    Parameters
    ----------
    fitted, decisive : sequence of Trace
        What is fitted and what decides.
    scaling : Scaling
    offsets : ndarray, shape (R,)
        Guesses of the fitted records' constants, m.
    most : int
        Largest number of rules for which the records have enough samples.
    options : Options
    progress : callable

    Returns
    -------
    rules : ndarray, shape (L, 6)
        The fit with the smallest number of rules whose error is within 2 % and one standard error
        of the best, scaled, to start the final fit from.
    trials : tuple of OrderTrial

    Raises
    ------
    IdentificationError
        If no number of rules gives a finite free run.
    """
    starts = min(options.starts, _STARTS)
    quick = replace(options, starts=starts, max_iterations=_ITERATIONS, solver=SOLVERS[0])
    trials: list[OrderTrial] = []
    fits: list[np.ndarray] = []
    most = min(most, _MOST)
    for count in range(1, most + 1):
        progress((count - 1) / most, f"choosing the number of rules: L = {count}")
        warm = [split_widest_rule(fits[-1])] if fits else []
        fit = fit_rules(fitted, scaling, offsets, count, quick, lambda *_: None, warm)
        fits.append(fit.rules)
        trials.append(OrderTrial(count, _error(fit.rules, decisive, scaling)))
        # two numbers in a row without a gain: more rules do not help
        if count >= 3 and _best(trials[-2:]) > (1.0 - COVERAGE.order_tolerance) * _best(trials[:-2]):
            break
    best = _best(trials)
    if not np.isfinite(best):
        raise IdentificationError(
            "with every number of rules the free run diverges on the validation data: check that they "
            "are of the same stage, in the same units, as the training records"
        )
    samples = sum(np.count_nonzero(s.weight) for s in decisive)
    # an rms of n independent errors has the relative standard error 1 / sqrt(2 n)
    limit = best * (1.0 + COVERAGE.order_tolerance + 1.0 / np.sqrt(2.0 * samples))
    chosen = next(rules for rules, t in zip(fits, trials, strict=True) if t.e_rms <= limit)
    return chosen, tuple(trials)


def split_widest_rule(rules: np.ndarray) -> np.ndarray:
    """Return L + 1 rules that nearly do what L rules do: a start for the next larger model."""
    widest = int(np.argmax(rules[:, 0]))
    twins = np.repeat(rules[widest : widest + 1], 2, axis=0)
    twins[:, 2] += np.array([-0.5, 0.5]) * min(twins[0, 0], 0.5)
    return np.vstack([np.delete(rules, widest, axis=0), twins])


def _best(trials: Sequence[OrderTrial]) -> float:
    return min(t.e_rms for t in trials)


def _error(rules: np.ndarray, decisive: Sequence[Trace], scaling: Scaling) -> float:
    """Return the free-run error of scaled rules on records, each from a start of its own, m rms."""
    squares = samples = 0.0
    for trace in decisive:
        used = np.count_nonzero(trace.weight)
        squares += fit_begin(rules, trace, scaling).rms ** 2 * used
        samples += used
    return float(np.sqrt(squares / samples)) * scaling.y_unit


def fit_begin(rules: np.ndarray, trace: Trace, scaling: Scaling) -> ChainFit:
    """Fit how one record begins, and its constant where it has one, to given scaled rules."""
    model = paper_model([trace], scaling, rules)
    if trace.has_offset:
        run = model.run(trace, 0)[0]
        finite = np.where(np.isfinite(run), run, trace.y)
        offset = np.average(trace.y - finite, weights=trace.weight)
        model = paper_model([trace], scaling, rules, [offset])
    return minimise(paper_problem([trace], model, scaling).holding(["rules"]), 30, 1e-9)
