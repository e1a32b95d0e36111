"""The solvers side by side: the same problem from the same start."""

import time
from collections.abc import Sequence

import numpy as np

from it2hys.identification import SOLVERS, Options
from it2hys.identification.preparation import data_scaling, prepare
from it2hys.identification.rule_search import drawn_starts, rms_of
from it2hys.identification.solvers import solve
from it2hys.identification.traces import plain_trace
from it2hys.records import Record
from it2hys.reports.page import Section, Table
from it2hys.support.progress import Progress

UM = 1e6
#: Iterations that each solver is given.
_ITERATIONS = 100


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
    """Run every solver on the free run, from a guess and from a start that a search draws.

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
    prepared = [prepare(record) for record in records]
    scaling = data_scaling(prepared)
    traces = [plain_trace(p, "train") for p in prepared]
    problem, drawn = drawn_starts(traces, scaling, plausible_rules(rules), seed)
    # of the starts drawn, every second goes some way towards an optimum of the one-step criterion
    next(drawn)
    starts = {"guess": problem.pack(problem.model), "projected": next(drawn)[0]}
    cases = [(start, solver) for start in starts for solver in SOLVERS]
    rows = []
    for i, (start, solver) in enumerate(cases):
        progress(i / len(cases), f"{solver}, from a {start} start")
        options = Options(seed, max_iterations=_ITERATIONS, solver=solver)
        began = time.perf_counter()
        minimum = solve(problem, starts[start], options)
        seconds = time.perf_counter() - began
        reached = rms_of(minimum.cost, problem.samples) * scaling.y_unit
        rows.append([solver, start, f"{reached * UM:.4f}", f"{minimum.iterations}", f"{seconds:.2f}"])
    table = Table(
        ["solver", "start", "rms µm", "iterations", "seconds"],
        rows,
        f"Solvers on the training records in free run, at most {_ITERATIONS} iterations each",
    )
    text = [
        "Gradient descent is (21), quasi-Newton the method of the paper's fminunc, the evolutionary "
        "one its future work. The guess spreads the rules over the range. The projected "
        "start has drawn antecedents, and the consequents that go with them by the one-step "
        "criterion, which is linear in these. What a method reaches depends on its start: the "
        "default is Levenberg-Marquardt in free run from many projected starts."
    ]
    return Section("Solvers", text, [table])
