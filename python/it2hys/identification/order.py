"""Choice of the number of rules by prediction, with a parsimony rule."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from it2hys.identification.criteria import Series
from it2hys.identification.prediction import fit_state
from it2hys.identification.result import IdentificationError, Options, OrderTrial
from it2hys.identification.rule_search import fit_rules

#: Share of every training record set aside where there are no validation records.
_SET_ASIDE = 0.3
#: A smaller model is taken if its error is within this share, and a standard error, of the best.
_TOLERANCE = 0.02
#: Starts, besides one from the next smaller model, and last iterations of each trial.
_STARTS, _ITERATIONS = 6, 60


def split(series: Sequence[Series]) -> tuple[list[Series], list[Series]]:
    """Return the series without the ends of their records, and with nothing but the ends.

    The set-aside part keeps the samples before it, with weight 0: the free run over them brings
    the model into the state in which the part begins. Of a record that moves only at its end the
    beginning is set aside.
    """
    fitted, decisive = [], []
    for s in series:
        at_end = np.arange(len(s.x)) >= round(len(s.x) * (1.0 - _SET_ASIDE))
        aside = at_end if _moves(s, ~at_end) else at_end[::-1]
        kept = slice(int(np.argmin(aside)), len(aside) - int(np.argmin(aside[::-1])))
        state = s.state if kept.start == 0 else float(s.y[kept.start - 1])
        part = {"x": s.x[kept], "y": s.y[kept], "weight": s.weight[kept], "state": state}
        fitted.append(replace(s, **part))
        decisive.append(replace(s, weight=np.where(aside, s.weight, 0.0)))
    return fitted, decisive


def _moves(series: Series, part: np.ndarray) -> bool:
    """Return whether a part of a record shows at least half of what the voltage does in all of it."""
    used = series.weight > 0
    seen = part & used
    return bool(np.any(seen)) and np.ptp(series.x[seen]) >= 0.5 * np.ptp(series.x[used])


def choose_rule_count(
    fitted: Sequence[Series],
    decisive: Sequence[Series],
    options: Options,
    progress: Callable[[float, str], None],
) -> tuple[np.ndarray, tuple[OrderTrial, ...]]:
    """Choose the number of rules by the free-run error on the decisive series.

    Parameters
    ----------
    fitted, decisive : sequence of Series
        What is fitted and what decides.
    options : Options
    progress : callable

    Returns
    -------
    rules : ndarray, shape (L, 6)
        The fit with the smallest number of rules whose error is within 2 % and one standard error
        of the best, to start the final fit from.
    trials : tuple of OrderTrial
        Errors in scaled units.

    Raises
    ------
    IdentificationError
        If no number of rules gives a finite free run.
    """
    quick = replace(options, starts=min(options.starts, _STARTS), max_iterations=_ITERATIONS)
    trials: list[OrderTrial] = []
    fits: list[np.ndarray] = []
    for count in range(1, options.max_rules + 1):
        progress((count - 1) / options.max_rules, f"choosing the number of rules: L = {count}")
        warm = [split_widest_rule(fits[-1])] if fits else []
        fits.append(fit_rules(fitted, count, quick, lambda *_: None, warm).rules)
        trials.append(OrderTrial(count, _error(fits[-1], decisive)))
        # two numbers in a row without a gain: more rules do not help
        if count >= 3 and _best(trials[-2:]) > (1.0 - _TOLERANCE) * _best(trials[:-2]):
            break
    best = _best(trials)
    if not np.isfinite(best):
        raise IdentificationError(
            "no number of rules gives a finite free run on the records that decide"
        )
    samples = sum(np.count_nonzero(s.weight) for s in decisive)
    # an rms of n independent errors has the relative standard error 1 / sqrt(2 n)
    limit = best * (1.0 + _TOLERANCE + 1.0 / np.sqrt(2.0 * samples))
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


def _error(rules: np.ndarray, decisive: Sequence[Series]) -> float:
    squares = samples = 0.0
    for s in decisive:
        *_, rms = fit_state(s, rules, s.has_offset)
        squares += rms**2 * np.count_nonzero(s.weight)
        samples += np.count_nonzero(s.weight)
    return float(np.sqrt(squares / samples))
