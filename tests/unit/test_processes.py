"""Processes that share work: in order, alone in their number, and never silently gone."""

import os
import signal

import pytest

from it2hys.errors import InputError
from it2hys.processes import parallel_map


def threads_of_libraries(_: int) -> str:
    return os.environ["OMP_NUM_THREADS"]


def end_at_once(number: int) -> int:
    if number == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


@pytest.mark.parametrize("workers", [1, 2])
def test_results_come_in_order(workers):
    with parallel_map(workers) as each:
        assert list(each(pow, [2, 3, 4], [5, 2, 2])) == [32, 9, 16]


def test_libraries_have_one_thread_in_a_worker():
    with parallel_map(2) as each:
        assert list(each(threads_of_libraries, range(4))) == ["1"] * 4


def test_a_worker_that_is_killed_is_told_of():
    with pytest.raises(InputError, match="worker process ended"), parallel_map(2) as each:
        list(each(end_at_once, range(4)))


def test_no_worker_is_refused():
    with pytest.raises(InputError, match="--workers 0"), parallel_map(0):
        pass
