"""Processes of this machine that share independent work."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial
from typing import TypeVar

from it2hys.errors import InputError

#: Read when the libraries are loaded. On matrices as small as a fit's, threads of their own only wait
#: for each other, and most of all where other work wants the processors.
_LINEAR_ALGEBRA = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
_THREADS = (*_LINEAR_ALGEBRA, "POLARS_MAX_THREADS")


_Result = TypeVar("_Result")

#: Samples from which on threads share runs and fits: those of long records take their time in C.
LONG = 5000


def without_threads() -> None:
    """Let linear algebra do without threads of its own, unless the user has chosen their number.

    It must be called before numpy is loaded.
    """
    for name in _LINEAR_ALGEBRA:
        os.environ.setdefault(name, "1")


#: Threads that share what several processes cannot, of this process or of one of a `parallel_map`. A
#: single fit that takes longer than the others would else leave the other processors idle.
_threads: ContextVar[ThreadPoolExecutor | None] = ContextVar("threads", default=None)


class Terminated(KeyboardInterrupt):
    """SIGTERM asked this process to end."""


@contextmanager
def ended_by_sigterm() -> Iterator[None]:
    """Let SIGTERM end the work as Ctrl-C does: what is temporary goes, nothing is left half written."""
    if threading.current_thread() is not threading.main_thread():  # only it may be interrupted
        yield
        return

    def end(number: int, frame: object) -> None:
        raise Terminated

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def temporary_files() -> Iterator[None]:
    """Have all temporary files of this process in one folder, which goes whenever the work ends.

    An interruption may come between the making of a folder and the note that it is to be removed.
    """
    before = tempfile.tempdir
    try:
        tempfile.tempdir = tempfile.mkdtemp(prefix="it2hys-")
    except OSError:  # most commands need none
        yield
        return
    folder = tempfile.tempdir
    try:
        yield
    finally:
        tempfile.tempdir = before
        shutil.rmtree(folder, ignore_errors=True)


class _Process(multiprocessing.context.SpawnProcess):
    """A process whose libraries have one thread each.

    The values are inherited: a script that is run anew in it may load the libraries before `_begin`.
    """

    def start(self) -> None:
        with _environment(dict.fromkeys(_THREADS, "1")):
            super().start()


class _Context(multiprocessing.context.SpawnContext):
    Process = _Process


def make_pool(
    count: int, begin: Callable | None = None, scratch: str | None = None
) -> ProcessPoolExecutor:
    """Return processes that end when this one does, however it ends.

    They are spawned, not forked: a fork copies locks that threads of other libraries hold.

    Parameters
    ----------
    count : int
    begin : callable, optional
        Called in each of them first.
    scratch : str, optional
        Directory for their temporary files, made for them alone: it goes with them.
    """
    return ProcessPoolExecutor(count, _Context(), _begin, (begin, scratch))


@contextmanager
def _environment(values: Mapping[str, str]) -> Iterator[None]:
    """Let processes that are started inherit values."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _begin(begin: Callable | None, scratch: str | None) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to answer
    if scratch is not None:
        tempfile.tempdir = scratch
    threading.Thread(target=_end_with_parent, args=(scratch,), daemon=True).start()
    if begin is None:
        return
    try:
        begin()
    except OSError:
        if scratch is not None and not os.path.isdir(scratch):  # the parent has gone meanwhile
            os._exit(1)
        raise


def _end_with_parent(scratch: str | None) -> None:
    if parent := multiprocessing.parent_process():
        parent.join()
    if scratch is not None:
        shutil.rmtree(scratch, ignore_errors=True)
    os._exit(1)


def check_workers(workers: int) -> None:
    """Refuse a negative number of processes; 0 stands for none beside this one."""
    if workers < 0:
        raise InputError(f"--workers {workers}: must not be negative; 0 is this process alone")


@contextmanager
def parallel_map(workers: int) -> Iterator[Callable]:
    """Hand out a `map` that has its calls made by so many processes; by this one if they are 0 or 1.

    Each of them, and this one while they wait for work, has as many threads for that of `thread_map`.

    Raises
    ------
    InputError
        If a process ends before its work is done.
    """
    check_workers(workers)
    if workers <= 1:
        yield map
        return
    pool = make_pool(workers, partial(_begin_threads, workers))
    try:
        with _shared_threads(workers):
            yield pool.map
    except BrokenProcessPool:
        raise InputError(
            "a worker process ended before its work was done: it was killed (too little memory?), "
            'or a script calls this without if __name__ == "__main__"; use one worker'
        ) from None
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _shared_threads(count: int) -> Iterator[None]:
    with ThreadPoolExecutor(count) as threads:
        token = _threads.set(threads)
        try:
            yield
        finally:
            _threads.reset(token)


def _begin_threads(count: int) -> None:
    _threads.set(ThreadPoolExecutor(count))


def thread_map(function: Callable, *arguments: Iterable) -> Iterator:
    """Map as `map` does, the calls shared by the threads of `parallel_map` where there are any.

    For calls that spend their time in C, without Python's lock: a fit that is the only one to be made
    leaves the other processes idle.
    """
    threads = _threads.get()
    return (threads.map if threads else map)(function, *arguments)


def called(piece: Callable[[], _Result]) -> _Result:
    """Call a piece of work: for a map over pieces that differ."""
    return piece()


def has_threads() -> bool:
    """Return whether `thread_map` shares its calls among threads."""
    return _threads.get() is not None
