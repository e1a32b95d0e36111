"""The work of a worker: it runs cases of a plan and returns them as a piece of the table."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, nullcontext
from functools import reduce
from io import BytesIO
from math import isinf, isnan
from pathlib import Path
from typing import Any

import numpy as np

from it2hys.cosimulation.slave import Slave
from it2hys.cosimulation.stepping import System, named
from it2hys.errors import InputError
from it2hys.sweeps.measures import KINDS, MetricData, count_true
from it2hys.sweeps.plan import Plan, Setup, by_owner, signal_values

OK, FAILED = "ok", "failed"
#: Between the messages of a case.
MESSAGES_APART = " | "
#: Output of a plant that is true beyond what its parameters hold for.
OUT_OF_RANGE = "outOfRange"
#: Signals kept for cases that share them, and their samples; a grid over the signals themselves would
#: fill the memory, and so would a few that last for hours.
KEPT_SIGNALS, KEPT_SAMPLES = 8, 20_000_000
#: Against 3.0000000000000004 ticks where 3 are meant.
_ROUNDING = 1e-9

_plans: dict[str, Plan] = {}
_local = threading.local()
_shared: dict[str, Runner] = {}
_turn = threading.Lock()


def install(plan: Plan) -> None:
    """Make a plan known to this process."""
    _plans[plan.fingerprint] = plan


def ready(fingerprint: str) -> bool:
    """Tell whether a plan is installed."""
    return fingerprint in _plans


def run_cases(fingerprint: str, cases: Sequence[int]) -> bytes:
    """Run cases of an installed plan; return their rows as a stream of Arrow's.

    Instances are made once for every thread and used again by reset; where an FMU allows but one in a
    process, the threads take turns with it.
    """
    plan = _plans[fingerprint]
    with _turn if plan.alone else nullcontext():
        runner = _runner(plan, _shared if plan.alone else _local.__dict__)
        with np.errstate(all="ignore"):  # what overflows is told in its row
            rows = [runner.row(case) for case in cases]
        return format_rows(plan, cases, rows)


def _runner(plan: Plan, place: dict[str, Any]) -> Runner:
    """Return the runner that is kept in a place, a new one if that was for another plan."""
    kept = place.get("runner")
    if kept is None or kept.plan is not plan:
        if kept is not None:
            kept.close()
        place["runner"] = kept = Runner(plan)
    return kept


def close() -> None:
    """Free the instances of this thread, and the shared ones, with their files."""
    for place in (_local.__dict__, _shared):
        if "runner" in place:
            place.pop("runner").close()


def failure(message: str) -> dict:
    """Return the row of a case that failed."""
    return {"status": FAILED, "message": message}


def format_rows(plan: Plan, cases: Sequence[int], rows: list[dict]) -> bytes:
    """Return the rows of cases as a stream of Arrow's; what a row lacks is null."""
    import polars as pl

    number = np.asarray(cases)
    given = {
        "case": (pl.Int64, number),
        "variant": (pl.String, [plan.setups[i].name or None for i in plan.variant[number]]),
        **{a.name: (pl.Float64, plan.matrix[number, i]) for i, a in enumerate(plan.axes)},
    }
    found = {
        **{metric.name: pl.Float64 for metric in plan.metrics},
        **{name: pl.List(pl.Float64) for name in plan.keep},
        "status": pl.String, "warned": pl.Boolean, "out_of_range": pl.Int64, "message": pl.String,
    }  # fmt: skip
    columns = {name: [row.get(name) for row in rows] for name in found}
    for name in plan.keep:  # as series: polars would make arrays of traces of one length
        columns[name] = [None if trace is None else pl.Series(trace) for trace in columns[name]]
    columns = {name: values for name, (_, values) in given.items()} | columns
    schema = {name: kind for name, (kind, _) in given.items()} | found
    buffer = BytesIO()
    pl.DataFrame(columns, schema=schema).write_ipc_stream(buffer)
    return buffer.getvalue()


def _range_flags(slaves: Mapping[str, Slave]) -> list[str]:
    """Return the outputs that tell whether an FMU is beyond what its parameters hold for."""
    return [f"{name}.{OUT_OF_RANGE}" for name, s in slaves.items() if OUT_OF_RANGE in s.names("output")]


class Runner:
    """Runs cases one after the other on instances of its own.

    Parameters
    ----------
    plan : Plan
        What is run.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._stack = ExitStack()
        self._slaves: dict[str, Slave] = {}
        self._systems: dict[str, tuple[System, list[str]]] = {}
        self._signals: dict[tuple, np.ndarray] = {}
        self._directory = Path(
            self._stack.enter_context(
                tempfile.TemporaryDirectory(prefix="it2hys-", ignore_cleanup_errors=True)
            )
        )
        outputs = [*(m.of for m in plan.metrics), *(m.against for m in plan.metrics), *plan.keep]
        self._recorded = list(dict.fromkeys(name for name in outputs if "." in name))
        self._timed = sorted(plan.timed)
        self._last_timed: list | None = None
        self._last_steps: tuple[Any, Any, Any] = (0.0, 0, 0)

    def close(self) -> None:
        """Free the instances and their files."""
        self._stack.close()

    def row(self, case: int) -> dict:
        """Run a case and return its row; a failure is a row, too."""
        try:
            return self._run(case)
        except Exception as error:  # whatever a case does, the others go on
            text = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
            for name in self.plan.files:
                model = self._slaves[name].model if name in self._slaves else ""
                text = text.replace(str(self._path(name)), named(name, model))
            return failure(text)

    def _path(self, fmu: str) -> Path:
        return self._directory / f"{fmu}.fmu"

    def _slave(self, fmu: str) -> Slave:
        if fmu not in self._slaves:
            self._path(fmu).write_bytes(self.plan.files[fmu])
            self._slaves[fmu] = self._stack.enter_context(Slave(self._path(fmu)))
        return self._slaves[fmu]

    def _system(self, setup: Setup) -> tuple[System, list[str]]:
        """Return the FMUs of a setup, and which of the recorded outputs are range flags."""
        if setup.name not in self._systems:
            slaves = {name: self._slave(name) for name in setup.fmus}
            flags = _range_flags(slaves)
            recorded = dict.fromkeys([*self._recorded, *flags])
            self._systems[setup.name] = System(slaves, setup.connections, list(recorded)), flags
        return self._systems[setup.name]

    def _run(self, case: int) -> dict:
        plan, values = self.plan, self.plan.values(case)
        setup = plan.setups[plan.variant[case]]
        step, count, skipped = self._steps(values)
        system, range_flags = self._system(setup)
        owned = by_owner(values)
        signals = {name: self._signal(name, owned, step, count) for name in system.signals}
        system.initialize(owned, {name: signal[0] for name, signal in signals.items()})
        records = system.run(signals, count, step)
        outside = [records[name] for name in range_flags]
        row = {
            "status": OK,
            "warned": any(slave.warned for slave in system.slaves.values()),
            "out_of_range": count_true(reduce(np.logical_or, outside)) if outside else None,
            "message": MESSAGES_APART.join(system.messages) or None,
        }
        judged: dict[tuple[str, str], MetricData] = {}
        for metric in plan.metrics:
            pair = metric.of, metric.against
            if pair not in judged:
                of, against = (
                    self._output(name, records, owned, step, count, metric.of) for name in pair
                )
                other = None if against is None else against[skipped:]
                judged[pair] = MetricData(of[skipped:], other, step)
            number = KINDS[metric.kind].function(judged[pair])
            if isinf(number):
                raise InputError(f"{metric.name} is not finite: the outputs diverge")
            row[metric.name] = None if isnan(number) else number
        for name in plan.keep:
            row[name] = self._output(name, records, owned, step, count)[:: plan.keep_every]
        return row

    def _steps(self, values: Mapping[str, float]) -> tuple[Any, Any, Any]:
        """Return `Plan.steps`, most often those of the case before."""
        timed = [values.get(target) for target in self._timed]
        if timed != self._last_timed:
            self._last_timed, self._last_steps = timed, self.plan.steps(values)
        return self._last_steps

    def _output(
        self,
        name: str,
        records: Mapping[str, np.ndarray],
        owned: Mapping[str, Mapping[str, float]],
        step: float,
        count: int,
        beside: str = "",
    ) -> np.ndarray | None:
        """Return a record, or a signal at the times that the output `beside` belongs to."""
        if "." in name or not name:
            return records.get(name)
        slave = self._slaves.get(beside.partition(".")[0])
        tick = slave.sample_time if slave else None
        return self._signal(name, owned, step, count, tick)

    def _signal(
        self,
        name: str,
        owned: Mapping[str, Mapping[str, float]],
        step: float,
        count: int,
        tick: float | None = None,
    ) -> np.ndarray:
        """Return a signal at the beginnings of the steps, or at the ticks that are read at their ends.

        What is read at the end of a step is the output of the last tick before it. Where steps and
        ticks are as long, that is the tick at the beginning.
        """
        own = owned.get(name, {})
        late = tick is not None and abs(tick / step - 1.0) > _ROUNDING
        key = (name, tuple(own.items()), step, count, tick if late else None)
        if key not in self._signals:
            while self._signals and (
                len(self._signals) >= KEPT_SIGNALS
                or sum(map(len, self._signals.values())) + count > KEPT_SAMPLES
            ):
                del self._signals[next(iter(self._signals))]
            begins = np.arange(count) * step
            times = begins
            if late:
                last = np.ceil((begins + step) / tick - _ROUNDING) - 1.0
                # with the inputs' samples, for a signal whose scale depends on those asked for
                times = np.concatenate([begins, last * tick])
            made = signal_values(self.plan.signals[name], own, times, count * step)
            self._signals[key] = made[-count:]
        return self._signals[key]
