"""Workers that run the cases: this process, processes on this machine, or a Dask cluster.

All three take chunks of cases and hand back what became of them, in any order. A worker that dies
(an FMU's binary may crash) hands back a `Crash`.
"""

from __future__ import annotations

import pickle
import queue
import tempfile
from collections import deque
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Protocol

from it2hys.errors import InputError
from it2hys.support.processes import make_pool
from it2hys.sweeps import worker
from it2hys.sweeps.plan import Plan

#: Chunks that wait at a worker, so that it need not wait.
AHEAD = 2
#: The plan's file in the directory that local workers share.
PLAN = "plan.pickle"
#: Seconds in which a scheduler must answer.
PATIENCE = "10s"


@dataclass(frozen=True)
class Crash:
    """A worker died over a chunk."""

    message: str


class Workers(Protocol):
    """Anything that runs chunks of cases."""

    room: int  # chunks that may be on the way at once

    def submit(self, cases: range) -> None:
        """Begin with a chunk."""

    def next(self) -> tuple[range, bytes | Crash]:
        """Wait for any chunk to be finished."""

    def close(self) -> None:
        """Let the workers go."""


class ThisProcess:
    """Runs chunks here, one after the other."""

    room = 1

    def __init__(self, plan: Plan) -> None:
        worker.install(plan)
        self._fingerprint, self._waiting = plan.fingerprint, deque()

    def submit(self, cases: range) -> None:
        """Begin with a chunk."""
        self._waiting.append(cases)

    def next(self) -> tuple[range, bytes | Crash]:
        """Run the next chunk."""
        cases = self._waiting.popleft()
        return cases, worker.run_cases(self._fingerprint, cases)

    def close(self) -> None:
        """Free the instances."""
        worker.close()


class _Futures:
    """Chunks that are run elsewhere, as futures."""

    def __init__(self) -> None:
        self._done: queue.SimpleQueue = queue.SimpleQueue()

    def _watch(self, future: Future, cases: range) -> None:
        future.add_done_callback(lambda done: self._done.put((cases, done)))

    def next(self) -> tuple[range, bytes | Crash]:
        """Wait for any chunk to be finished."""
        cases, future = self._done.get()
        try:
            return cases, future.result()
        except self.deadly as error:
            return cases, Crash(self.obituary(error))


class Processes(_Futures):
    """Processes on this machine."""

    deadly = BrokenProcessPool

    def __init__(self, plan: Plan, count: int) -> None:
        super().__init__()
        self.room = AHEAD * count
        self._fingerprint, self._count = plan.fingerprint, count
        self._directory = tempfile.TemporaryDirectory(prefix="it2hys-", ignore_cleanup_errors=True)
        # as a file: handed over in a pipe, it would block this process where a worker fails to start
        Path(self._directory.name, PLAN).write_bytes(pickle.dumps(plan))
        self._pool = self._make()
        try:
            # one call for each: the pool starts a process only for work that no other is idle for
            first, *_ = [self._pool.submit(worker.ready, plan.fingerprint) for _ in range(count)]
            first.result()
        except BrokenProcessPool:
            self.close()
            raise InputError(
                "the worker processes do not start; a script that sweeps must do so under "
                'if __name__ == "__main__", or with workers=0'
            ) from None

    def _make(self) -> ProcessPoolExecutor:
        folder = self._directory.name
        return make_pool(self._count, partial(_install, folder), folder)

    @staticmethod
    def obituary(_error: Exception) -> str:
        """Return what to say of a case that a worker died over."""
        return (
            "its worker process ended unexpectedly: an FMU's binary crashed, or the process was killed"
        )

    def submit(self, cases: range) -> None:
        """Begin with a chunk."""
        try:
            future = self._pool.submit(worker.run_cases, self._fingerprint, cases)
        except BrokenProcessPool:  # it died over another chunk
            self._pool.shutdown(wait=False)
            self._pool = self._make()
            future = self._pool.submit(worker.run_cases, self._fingerprint, cases)
        self._watch(future, cases)

    def close(self) -> None:
        """End the processes."""
        self._pool.shutdown(wait=True, cancel_futures=True)
        self._directory.cleanup()


def _install(directory: str) -> None:
    worker.install(pickle.loads(Path(directory, PLAN).read_bytes()))


class Dask(_Futures):
    """A Dask cluster, by the address of its scheduler.

    The plan goes to every worker as a plugin, which those that join later or start again get as well.
    The package must be installed there.

    Raises
    ------
    InputError
        If `distributed` is not installed, or no scheduler answers.
    """

    def __init__(self, plan: Plan, address: str) -> None:
        super().__init__()
        try:
            import distributed
        except ImportError:
            raise InputError("--dask needs the package distributed: pip install it2hys[dask]") from None
        self.deadly, self._lost = distributed.KilledWorker, distributed.CancelledError
        try:
            self._client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise InputError(f"--dask {address}: no Dask scheduler answers ({error})") from None
        self._fingerprint = plan.fingerprint
        workers = self._client.scheduler_info()["workers"]
        self.room = AHEAD * max(sum(w["nthreads"] for w in workers.values()), 1)
        try:
            self._client.register_plugin(_plugin(plan))
        except Exception as error:  # whatever a worker raises over what it cannot load
            self._client.close()
            raise InputError(
                f"--dask {address}: the workers cannot take the sweep; it2hys must be installed there, "
                f"in this version ({error})"
            ) from None

    @staticmethod
    def obituary(error: Exception) -> str:
        """Return what to say of a case that a worker died over."""
        return f"the Dask workers that ran it died: {error}"

    def next(self) -> tuple[range, bytes | Crash]:
        """Wait for any chunk to be finished."""
        try:
            return super().next()
        except self._lost:
            raise InputError("the Dask cluster was lost; the same command resumes the sweep") from None

    def submit(self, cases: range) -> None:
        """Begin with a chunk."""
        future = self._client.submit(worker.run_cases, self._fingerprint, cases, pure=False)
        self._watch(future, cases)

    def close(self) -> None:
        """Leave the cluster."""
        self._client.close()


def _plugin(plan: Plan):
    """Return a plugin that installs a plan; `distributed` is imported where it is wanted."""
    from it2hys.sweeps.dask_plugin import PlanPlugin

    return PlanPlugin(plan)
