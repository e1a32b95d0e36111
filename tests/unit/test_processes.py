"""Processes that share work: in order, alone in their number, and never silently gone."""

import os
import signal
import subprocess
import sys

import pytest

from it2hys.errors import InputError
from it2hys.support.processes import has_threads, parallel_map, thread_map


def threads_of_libraries(_: int) -> str:
    return os.environ["OMP_NUM_THREADS"]


def threads_of_its_own(_: int) -> bool:
    return has_threads()


def end_at_once(number: int) -> int:
    if number == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


@pytest.mark.parametrize("workers", [1, 2])
def test_results_come_in_order(workers):
    with parallel_map(workers) as each:
        assert list(each(pow, [2, 3, 4], [5, 2, 2])) == [32, 9, 16]


@pytest.mark.parametrize("workers", [1, 2])
def test_threads_share_what_is_left_to_this_process_alone(workers):
    with parallel_map(workers) as each:
        assert list(thread_map(pow, [2, 3, 4], [5, 2, 2])) == [32, 9, 16]
        assert has_threads() == (workers > 1)
        assert all(each(threads_of_its_own, range(4))) == (workers > 1)
        assert not any(thread_map(threads_of_its_own, range(4)))
    assert not has_threads()


def test_libraries_have_one_thread_in_a_worker():
    with parallel_map(2) as each:
        assert list(each(threads_of_libraries, range(4))) == ["1"] * 4


def test_libraries_have_one_thread_where_a_script_loads_them_before_the_worker_does(tmp_path):
    """A worker runs the script anew before anything else: what it loads then reads these values."""
    script = tmp_path / "script.py"
    script.write_text(
        "import os\n"
        "THREADS = os.environ.get('OMP_NUM_THREADS'), os.environ.get('OPENBLAS_NUM_THREADS')\n"
        "from it2hys.support.processes import parallel_map\n"
        "def threads(_):\n"
        "    return THREADS\n"
        "if __name__ == '__main__':\n"
        "    with parallel_map(2) as each:\n"
        "        print(set(each(threads, range(4))), THREADS)\n"
        "    print(os.environ.get('OMP_NUM_THREADS'))\n"
    )
    environment = {n: v for n, v in os.environ.items() if not n.endswith("_NUM_THREADS")}
    done = subprocess.run(
        [sys.executable, script], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines() == ["{('1', '1')} (None, None)", "None"]


def test_a_worker_that_is_killed_is_told_of():
    with pytest.raises(InputError, match="worker process ended"), parallel_map(2) as each:
        list(each(end_at_once, range(4)))


def test_no_worker_beside_this_process_is_asked_for_by_0_and_fewer_are_refused():
    with parallel_map(0) as each:
        assert each is map
    with pytest.raises(InputError, match="--workers -1: must not be negative"), parallel_map(-1):
        pass
