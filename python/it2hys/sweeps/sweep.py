"""Running a sweep: chunks to workers, what comes back to the store, the table to a report."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from it2hys.errors import InputError
from it2hys.support.processes import check_workers
from it2hys.support.progress import Progress, silent
from it2hys.sweeps.cases import make_plan
from it2hys.sweeps.plan import Plan
from it2hys.sweeps.pool import Crash, Dask, Processes, ThisProcess, Workers
from it2hys.sweeps.schema import SweepScenario
from it2hys.sweeps.store import Store
from it2hys.sweeps.worker import failure, format_rows

if TYPE_CHECKING:
    from it2hys.reports.provenance import Provenance


@dataclass(frozen=True)
class SweepOutcome:
    """What a sweep leaves: its table and its report, how many cases failed or were warned of.

    `out_of_range` counts cases with samples beyond what a model holds for; `summary` says it in words.
    """

    results: Path
    report: Path
    cases: int
    failed: int
    warned: int
    out_of_range: int
    summary: str


def run_sweep(
    scenario: SweepScenario,
    directory: str | Path,
    workers: int | None = None,
    dask: str | None = None,
    restart: bool = False,
    progress: Progress = silent,
    provenance: Provenance | None = None,
) -> SweepOutcome:
    """Run all cases of a scenario, or those that an interrupted run has left.

    Parameters
    ----------
    scenario : SweepScenario
        What is run.
    directory : path
        For `results.parquet`, `report.html` and its figures.
    workers : int, optional
        Processes; as many as there are processors by default. With 0 the cases run in this process.
    dask : str, optional
        Address of a Dask scheduler, instead.
    restart : bool
        Discard what the directory holds.
    progress : callable
        Told the share done and what is being done.
    provenance : Provenance, optional
        Where the sweep comes from, for its report.

    Raises
    ------
    InputError
        If the scenario, the directory or the cluster is not usable: before any case runs. If the
        disk is full: the sweep can be resumed.
    """
    try:
        plan = make_plan(scenario)
    except InputError as error:
        raise InputError(f"{scenario.file}: {error}" if scenario.file else str(error)) from None
    store = Store(directory, plan, restart)
    if not store.complete:
        _fill(store, plan, lambda: _workers(plan, workers, dask), progress)
    store.tidy()
    from it2hys.sweeps.report import write_sweep_report  # with matplotlib, which workers do not need

    report, counts = write_sweep_report(store.results, store.directory, provenance)
    return SweepOutcome(
        store.results,
        report,
        counts.cases,
        counts.failed,
        counts.warned,
        counts.out_of_range,
        counts.text,
    )


def _workers(plan: Plan, count: int | None, dask: str | None) -> Workers:
    if dask is not None:
        return Dask(plan, dask)
    count = (os.cpu_count() or 1) if count is None else count
    check_workers(count)
    return Processes(plan, min(count, len(plan.chunks()))) if count else ThisProcess(plan)


def _fill(store: Store, plan: Plan, make_workers: Callable[[], Workers], progress: Progress) -> None:
    """Run the chunks that the store lacks."""
    chunks = plan.chunks()
    number = {chunk.start: i for i, chunk in enumerate(chunks)}
    workers = make_workers()
    try:
        store.begin()
        done = store.done(range(len(chunks)))
        waiting = [chunk for i, chunk in enumerate(chunks) if i not in done]
        finished = sum(len(chunks[i]) for i in done)
        for cases, content in _run(waiting, workers, plan):
            store.write(number[cases.start], content)
            finished += len(cases)
            progress(finished / plan.cases, f"{plan.name}: {finished} of {plan.cases} cases")
    finally:
        workers.close()
    store.finish(len(chunks))


def _run(chunks: list[range], workers: Workers, plan: Plan) -> Iterator[tuple[range, bytes]]:
    """Yield every chunk with its rows.

    Chunks that a worker died over, and those that died with them, run again one at a time.
    """
    suspects, under_way = [], 0
    waiting = deque(chunks)
    while waiting or under_way:
        while waiting and under_way < workers.room:
            workers.submit(waiting.popleft())
            under_way += 1
        cases, result = workers.next()
        under_way -= 1
        if isinstance(result, Crash):
            suspects.append(cases)
        else:
            yield cases, result
    for cases in suspects:
        yield cases, _join(list(_isolate(cases, workers, plan)))


def _isolate(cases: range, workers: Workers, plan: Plan) -> Iterator[bytes]:
    """Yield the rows of a chunk, halving it until the case that kills is alone."""
    workers.submit(cases)
    _, result = workers.next()
    if not isinstance(result, Crash):
        yield result
    elif len(cases) == 1:
        yield format_rows(plan, cases, [failure(result.message)])
    else:
        middle = len(cases) // 2
        yield from _isolate(cases[:middle], workers, plan)
        yield from _isolate(cases[middle:], workers, plan)


def _join(pieces: list[bytes]) -> bytes:
    import polars as pl

    if len(pieces) == 1:
        return pieces[0]
    buffer = BytesIO()
    pl.concat([pl.read_ipc_stream(piece) for piece in pieces]).write_ipc_stream(buffer)
    return buffer.getvalue()
