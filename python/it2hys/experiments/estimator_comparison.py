"""The estimators side by side: the same criterion from the same start."""

import time
from collections.abc import Sequence
from itertools import islice

import numpy as np

from it2hys.identification import Options
from it2hys.identification.criteria import FreeRun, OneStep
from it2hys.identification.estimators import METHODS, cost, minimise
from it2hys.identification.preparation import data_scaling, prepare, to_series
from it2hys.identification.rule_search import draw_starts, rms_of
from it2hys.records import Record
from it2hys.reports.page import Section, Table
from it2hys.support.progress import Progress

UM = 1e6
CRITERIA = {"one step ahead": OneStep, "free run": FreeRun}


def plausible_rules(count: int) -> np.ndarray:
    """Return what one would guess, scaled: rules spread over the range, each a lag of gain 1."""
    rules = np.empty((count, 6))
    rules[:, 0], rules[:, 1], rules[:, 2] = 1 / count, 3 / count, np.linspace(-1, 1, count)
    rules[:, 3:] = 0.9, 0.1, 0.0
    return rules


def compare_estimators(
    records: Sequence[Record],
    rules: int,
    seed: int = 0,
    progress: Progress = lambda share, text: None,
) -> Section:
    """Run every estimator on both criteria, from a guess and from the best one-step optimum.

    Parameters
    ----------
    records : sequence of Record
        What is fitted.
    rules : int
        Number of rules L.
    seed : int
        Of the random starts and the evolutionary method.
    progress : callable
        Told the share done and what is being done.

    Returns
    -------
    Section
        With one table.
    """
    options = Options(seed=seed)
    prepared = [prepare(record, options) for record in records]
    scaling = data_scaling(prepared)
    series = [to_series(p, scaling) for p in prepared]
    # of the starts drawn, every second goes some way towards an optimum of the one-step criterion
    drawn = islice(draw_starts(FreeRun(series, rules), np.random.default_rng(seed)), 1, 2)
    starts = {
        "guess": FreeRun(series, rules).pack(plausible_rules(rules)),
        "projected": next(drawn)[0],
    }
    rows = []
    cases = [(c, s, m) for c in CRITERIA for s in starts for m in METHODS]
    for i, (name, start, method) in enumerate(cases):
        progress(i / len(cases), f"{method}, {name}, from a {start} start")
        criterion = CRITERIA[name](series, rules)
        began = time.perf_counter()
        minimum = minimise(criterion, starts[start], method, max_iterations=100, seed=seed)
        seconds = time.perf_counter() - began
        reached = rms_of(cost(criterion, minimum.coordinates), criterion.samples)
        rows.append(
            [
                method, name, start,
                f"{reached * scaling.y_unit * UM:.4f}", f"{minimum.iterations}", f"{seconds:.2f}",
            ]
        )  # fmt: skip
    table = Table(
        ["estimator", "criterion", "start", "rms µm", "iterations", "seconds"],
        rows,
        "Estimators on the training records, at most 100 iterations each",
    )
    text = [
        "Gradient descent is (21), quasi-Newton the method of the paper's fminunc, the evolutionary "
        "one its future work. The guess spreads the rules over the range. The projected "
        "start has drawn antecedents, and the consequents that go with them by the one-step "
        "criterion, which is linear in these. What any method reaches depends on its start: the "
        "default is Levenberg-Marquardt in free run from many projected starts."
    ]
    return Section("Estimators", text, [table])
