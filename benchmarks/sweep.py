"""Benchmarks of sweeps: throughput against FMPy and bare C, scaling, memory, kill -9.

Run as ``python benchmarks/sweep.py BARE_LOOP``, the program of fmu_src/bench/bare_loop.c; ``make
bench`` does. All cases are inverse -> plant with Table 1. What is compared is measured in turns in one
run, in processor time where one process is compared with another; quoted are ratios of medians.
"""

from __future__ import annotations

import contextlib
import io
import os
import random
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import fmpy
import numpy as np
import polars as pl
from fmpy import fmi2
from polars.testing import assert_frame_equal

from it2hys.cosimulation.stepping import System
from it2hys.fmu.packaging import package
from it2hys.model.parameters import table_1
from it2hys.stand import excitations
from it2hys.sweeps import parse_sweep, read_sweep, run_sweep, worker
from it2hys.sweeps.cases import make_plan
from it2hys.sweeps.worker import install, run_cases

TICKS, SAMPLE_TIME = 10_000, 1e-4
ROUNDS = 7
#: Turns of whole processes.
TURNS = 5
#: Cases in one turn: of the sweep and the bare loop, and of FMPy's loop, which is so much slower.
CASES, FEW = 300, 2
#: What is demanded of a worker, of the speed of the bare loop.
LEAST_SPEED = 0.85
#: Cases of a whole sweep whose time is divided.
WHOLE = 10_000
START = {"initialDisplacement": 0.7e-6}
KILLS = 20
#: Seconds in which workers are ready, for sweeps that begin at one moment.
START_UP = 4.0
REFERENCE = {"signal": "sine", "frequency": 20.0, "low": 0.7e-6, "high": 14.7e-6}


def main() -> None:
    """Print all tables, or do a part of the work in a process of its own."""
    if sys.argv[1:2] == ["memory"]:
        print(*measure_memory(sys.argv[2]))
        return
    if sys.argv[1:2] == ["wall"]:
        print(*measure_wall(*map(int, sys.argv[2:5]), moment=float(sys.argv[5])))
        return
    if sys.argv[1:2] == ["whole"]:
        print(measure_whole(*map(int, sys.argv[2:5])))
        return
    bare_loop = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    begin = time.perf_counter()
    compare_throughput(bare_loop)
    divide_time()
    compare_workers()
    compare_sizes()
    compare_memory()
    kill_repeatedly()
    print(f"\n{time.perf_counter() - begin:.0f} s in total")


def table(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table with aligned columns."""
    widths = [max(len(line[i]) for line in [header, *rows]) for i in range(len(header))]
    print(f"\n{title}")
    for line in [header, *rows]:
        print("  " + "  ".join(text.rjust(w) for text, w in zip(line, widths, strict=True)))


def scenario(cases: int, ticks: int, **changes: object) -> dict:
    """Return a sweep of inverse -> plant over a parameter of the plant."""
    return {
        "duration": ticks * SAMPLE_TIME,
        "fmu": {name: {"source": source, "start": START}
                for name, source in (("inverse", "IT2Inverse"), ("plant", "IT2Plant"))},
        "signal": {"reference": REFERENCE},
        "connections": [
            {"from": "reference", "to": "inverse.reference"},
            {"from": "inverse.voltage", "to": "plant.voltage"},
        ],
        "vary": [{"name": "q2", "of": "plant.rule[1].q2", "range": [1.9e-8, 2.0e-8],
                  "count": max(cases, 2)}],
        "metric": [
            {"kind": "e_mr", "of": "plant.displacement", "against": "reference"},
            {"kind": "e_rms", "of": "plant.displacement", "against": "reference"},
            {"name": "drive", "kind": "max", "of": "inverse.voltage"},
            {"name": "saturated", "kind": "time true", "of": "inverse.saturated"},
        ],
        **changes,
    }  # fmt: skip


# --- throughput ----------------------------------------------------------------------------------


def compare_throughput(bare_loop: Path | None) -> None:
    """Compare one worker's cases with FMPy's loop and with the bare loop, in turns."""
    with tempfile.TemporaryDirectory() as folder:
        package(table_1(), folder)
        plan = make_plan(parse_sweep(scenario(CASES, TICKS)))
        install(plan)
        run_cases(plan.fingerprint, range(2))
        contenders: dict[str, Callable[[], float]] = {
            "sweep, one worker": lambda: (
                seconds(lambda: [run_cases(plan.fingerprint, chunk) for chunk in plan.chunks()])
                / plan.cases
            ),
            "fmpy.simulate_fmu in a loop": lambda: quietly(Path(folder)) / FEW,
        }
        if bare_loop and bare_loop.exists():
            command = bare_command(bare_loop, Path(folder))
            see_same_numbers(command, run_cases(plan.fingerprint, range(CASES)))
            contenders["bare C loop"] = lambda: bare_numbers(command)[0] / CASES
        times = {name: [] for name in contenders}
        for _ in range(ROUNDS):
            for name, measure in contenders.items():
                times[name].append(measure())
    medians = {name: statistics.median(values) for name, values in times.items()}
    ours = medians["sweep, one worker"]
    rows = [
        [name, f"{1e3 * value:.2f}", f"{1 / value:.0f}", f"{value / ours:.2f}"]
        for name, value in medians.items()
    ]
    table(
        f"Scenarios of {TICKS} ticks, inverse -> plant, outputs recorded ({ROUNDS} turns, medians)",
        ["", "ms each", "per s", "sweep is so many times as fast"],
        rows,
    )
    if "bare C loop" not in medians:
        print("  (no bare C loop: give the path of bare_loop, which `make bench` builds)")
        return
    speed = statistics.median(
        bare / ours for bare, ours in zip(times["bare C loop"], times["sweep, one worker"], strict=True)
    )
    verdict = "met" if speed >= LEAST_SPEED else "missed"
    print(
        f"  speed of a sweep, as a share of the bare C loop's {speed:.2f}   >= {LEAST_SPEED} {verdict}"
    )


def seconds(function: Callable[[], object]) -> float:
    """Return the processor time of a call."""
    begin = time.process_time()
    function()
    return time.process_time() - begin


def quietly(folder: Path) -> float:
    """Return the processor time of FMPy's loop, which warns of every input that is not connected."""
    with contextlib.redirect_stdout(io.StringIO()):
        return seconds(lambda: fmpy_loop(folder))


def fmpy_loop(folder: Path) -> None:
    """Run a few cases by FMPy's own means: the inverse, and its voltage through the plant."""
    clock = np.arange(TICKS + 1) * SAMPLE_TIME
    arguments = {k: v for k, v in REFERENCE.items() if k != "signal"}
    reference = excitations.sine(clock, **arguments)
    options = {
        "start_values": START,
        "stop_time": TICKS * SAMPLE_TIME,
        "step_size": SAMPLE_TIME,
        "output_interval": SAMPLE_TIME,
    }
    for _ in range(FEW):
        driven = np.rec.fromarrays([clock, reference], names="time,reference")
        result = fmpy.simulate_fmu(
            str(folder / "IT2Inverse.fmu"), input=driven, output=["voltage", "saturated"], **options
        )
        voltage = np.append(result["voltage"][1:], result["voltage"][-1])
        driven = np.rec.fromarrays([clock[: len(voltage)], voltage], names="time,voltage")
        fmpy.simulate_fmu(
            str(folder / "IT2Plant.fmu"), input=driven, output=["displacement"], **options
        )


def bare_command(bare_loop: Path, folder: Path) -> list[str]:
    """Return the command of the bare loop over the same FMUs."""
    libraries, references = [], []
    names = {
        "IT2Inverse": ["reference", "voltage", "saturated"],
        "IT2Plant": ["voltage", "displacement", "outOfRange", "rule[1].q2", "initialDisplacement"],
    }
    for identifier, variables in names.items():
        unpacked = folder / identifier
        fmpy.extract(str(folder / f"{identifier}.fmu"), str(unpacked))
        description = fmpy.read_model_description(str(unpacked), validate=False)
        binary = unpacked / "binaries" / fmpy.platform / f"{identifier}{fmpy.sharedLibraryExtension}"
        libraries += [str(binary), description.guid]
        known = {v.name: v.valueReference for v in description.modelVariables}
        references += [str(known[name]) for name in variables]
    return [str(bare_loop), *libraries, str(CASES), str(TICKS), *references]


def bare_numbers(command: list[str]) -> list[float]:
    """Return what the bare loop prints: its processor time, and the sums of its columns."""
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return [float(text) for text in done.stdout.split()]


def see_same_numbers(command: list[str], rows: bytes) -> None:
    """See that both have done the same scenarios."""
    table = pl.read_ipc_stream(rows)
    ours = [table[name].sum() for name in ("e_mr", "e_rms", "drive", "saturated", "out_of_range")]
    np.testing.assert_allclose(ours, bare_numbers(command)[1:], rtol=1e-9)


# --- where the time goes ---------------------------------------------------------------------------


def divide_time() -> None:
    """Print where the time of a whole sweep goes, and that of a case in a worker."""
    workers = os.cpu_count() or 1
    whole = finish(start("whole", WHOLE, TICKS, workers))[0]
    running = finish(start("wall", WHOLE, TICKS, workers, time.monotonic() + START_UP))[0]
    table(
        f"A whole sweep of {WHOLE} scenarios of {TICKS} ticks, {workers} workers: {whole:.1f} s",
        ["", "s", "share"],
        [
            ["first to last case", f"{running:.2f}", f"{running / whole:.0%}"],
            ["workers' start, table, report", f"{whole - running:.2f}", f"{1 - running / whole:.0%}"],
        ],
    )
    spent = time_of_parts()
    each = {part: 1e6 * value / CASES for part, value in spent.items()}
    rows = [[part, f"{us:.0f}", f"{us / each['all']:.0%}"] for part, us in each.items()]
    table("A case in a worker, processor time", ["", "us", "share"], rows)


def time_of_parts() -> dict[str, float]:
    """Return the processor time of the parts of cases in one process, s."""
    plan = make_plan(parse_sweep(scenario(CASES, TICKS)))
    install(plan)
    run_cases(plan.fingerprint, range(2))
    spent = dict.fromkeys(("FMUs' steps", "initialization", "signals", "metrics", "table"), 0.0)

    def timed(part: str, function: Callable) -> Callable:
        def call(*arguments: object, **options: object) -> object:
            begin = time.process_time()
            try:
                return function(*arguments, **options)
            finally:
                spent[part] += time.process_time() - begin

        return call

    kinds = {n: replace(k, function=timed("metrics", k.function)) for n, k in worker.KINDS.items()}
    with (
        patch.object(System, "run", timed("FMUs' steps", System.run)),
        patch.object(System, "initialize", timed("initialization", System.initialize)),
        patch.object(worker.Runner, "_signal", timed("signals", worker.Runner._signal)),
        patch.object(worker, "format_rows", timed("table", worker.format_rows)),
        patch.object(worker, "KINDS", kinds),
    ):
        everything = seconds(lambda: [run_cases(plan.fingerprint, chunk) for chunk in plan.chunks()])
    return {**spent, "rest": everything - sum(spent.values()), "all": everything}


# --- workers and sizes -----------------------------------------------------------------------------


def measure_wall(cases: int, ticks: int, workers: int, moment: float) -> tuple[float, float]:
    """Return the time from the first to the last case of a sweep, s: without start and report.

    And the share of it that the workers had nothing to do: neither ran nor waited for a processor.
    It begins at the moment given, s on the monotonic clock, that others may begin at, too.
    """
    from it2hys.sweeps import sweep

    plan = make_plan(parse_sweep(scenario(cases, ticks)))
    pool = sweep._workers(plan, workers, None)
    with tempfile.TemporaryDirectory() as met:
        started = [pool._pool.submit(warm_up, plan.fingerprint, met, workers) for _ in range(workers)]
        for future in started:
            future.result()
    time.sleep(max(moment - time.monotonic(), 0.0))
    processes = list(pool._pool._processes)
    busy, begin = occupied(processes), time.perf_counter()
    for _ in sweep._run(plan.chunks(), pool, plan):
        pass
    elapsed = time.perf_counter() - begin
    idle = 1.0 - (occupied(processes) - busy) / (elapsed * len(processes))
    pool.close()
    return elapsed, idle


def warm_up(fingerprint: str, meeting: str, workers: int) -> None:
    """Run a case, and wait for the other workers to have done so: each of them takes one such call."""
    run_cases(fingerprint, range(1))
    Path(meeting, str(os.getpid())).touch()
    while len(os.listdir(meeting)) < workers:
        time.sleep(0.01)


def measure_whole(cases: int, ticks: int, workers: int) -> float:
    """Return the time of a whole sweep, s: with the start of its workers, its table and its report."""
    with tempfile.TemporaryDirectory() as folder:
        begin = time.perf_counter()
        run_sweep(parse_sweep(scenario(cases, ticks)), folder, workers)
        return time.perf_counter() - begin


def occupied(processes: Sequence[int]) -> float:
    """Return how long processes have run or waited for a processor, s; NaN where nobody counts."""
    try:
        texts = [Path(f"/proc/{process}/schedstat").read_text() for process in processes]
    except OSError:
        return float("nan")
    return sum(sum(map(int, text.split()[:2])) for text in texts) / 1e9


def start(*arguments: object) -> subprocess.Popen:
    """Start this program in a process of its own."""
    command = [sys.executable, __file__, *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def finish(process: subprocess.Popen) -> list[float]:
    """Return what a process prints."""
    out, _ = process.communicate()
    if process.returncode:
        raise SystemExit(f"{process.args} ended with {process.returncode}")
    return [float(text) for text in out.split()]


def compare_workers() -> None:
    """Compare two workers with one, in turns, and with what the machine gives two at once."""
    cases, turns = 3000, []
    for _ in range(TURNS):
        once = finish(start("wall", cases, TICKS, 1, 0))
        twice = finish(start("wall", cases, TICKS, 2, 0))
        # two sweeps that know nothing of each other: no scheduling could be quicker
        moment = time.monotonic() + START_UP
        both = [start("wall", cases // 2, TICKS, 1, moment) for _ in range(2)]
        apart = max(finish(process) for process in both)
        whole = [finish(start("whole", cases, TICKS, count))[0] for count in (1, 2)]
        turns.append([(*once, whole[0]), (*twice, whole[1]), (*apart, float("nan"))])
    walls, idle, whole = np.moveaxis(turns, -1, 0)
    names = ("1", "2", "two sweeps of half the cases at once")
    columns = (
        [f"{cases / wall:.0f}" for wall in np.median(walls, axis=0)],
        [f"{ratio:.2f}" for ratio in np.median(walls[:, :1] / walls, axis=0)],
        [f"{100 * share:.1f} %" for share in np.median(idle, axis=0)],
        [f"{ratio:.2f}".replace("nan", "") for ratio in np.median(whole[:, :1] / whole, axis=0)],
    )  # fmt: skip
    table(
        f"Workers: {cases} scenarios of {TICKS} ticks, {os.cpu_count()} processors ({TURNS} turns)",
        ["workers", "scenarios per s", "times one", "workers idle", "whole sweep, times one"],
        list(zip(names, *columns, strict=True)),
    )


def compare_sizes() -> None:
    """See that the time of a case does not grow with the number of cases, the whole sweep timed."""
    sizes, times = (100, 1000, 10_000), []
    for cases in sizes:
        turns = []
        for _ in range(3):
            with tempfile.TemporaryDirectory() as folder:
                turns.append(
                    seconds(lambda n=cases, f=folder: run_sweep(parse_sweep(scenario(n, 1000)), f, 0))
                )
        times.append(statistics.median(turns))
    rows = [[f"{sizes[0]}", f"{times[0]:.2f}", ""]]
    for i in (1, 2):
        further = (times[i] - times[i - 1]) / (sizes[i] - sizes[i - 1])
        rows.append([f"{sizes[i]}", f"{times[i]:.2f}", f"{1e3 * further:.3f}"])
    table(
        "Growth: whole sweeps of scenarios of 1000 ticks, report included (3 turns, medians)",
        ["scenarios", "s", "ms for each further scenario"],
        rows,
    )


# --- memory --------------------------------------------------------------------------------------


def resident() -> float:
    """Return the memory in use, MB; the peak where the system does not say."""
    with contextlib.suppress(OSError):
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize() / 1e6
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def measure_memory(what: str) -> list[float]:
    """Return the memory after 1000 and after 10,000 scenarios, MB."""
    after = []
    if what == "sweep":
        plan = make_plan(parse_sweep(scenario(10_000, 200)))
        install(plan)
        for case in range(0, 10_000, 100):
            run_cases(plan.fingerprint, range(case, case + 100))
            if case in (900, 9900):
                after.append(resident())
        return after
    with tempfile.TemporaryDirectory() as folder:
        package(table_1(), folder)
        unpacked = fmpy.extract(str(Path(folder, "IT2Plant.fmu")), str(Path(folder, "unpacked")))
        description = fmpy.read_model_description(unpacked, validate=False)
        fmu = fmi2.FMU2Slave(
            guid=description.guid, unzipDirectory=unpacked, modelIdentifier="IT2Plant", instanceName="m"
        )
        for case in range(10_000):
            fmu.instantiate()
            for _ in range(2):
                fmu.setupExperiment()
                fmu.enterInitializationMode()
                fmu.exitInitializationMode()
                for k in range(5):
                    fmu.setReal([0], [50.0])
                    fmu.doStep(k * SAMPLE_TIME, SAMPLE_TIME)
                fmu.reset()
            fmu.fmi2FreeInstance(fmu.component)
            if case in (999, 9999):
                after.append(resident())
    return after


def compare_memory() -> None:
    """See that memory stays flat."""
    rows = []
    for what, title in (("sweep", "sweep"), ("fmpy", "FMPy's own loop: instantiate, reset, free")):
        early, late = finish(start("memory", what))
        rows.append([title, f"{early:.1f}", f"{late:.1f}", f"{late - early:+.1f}"])
    table("Memory, MB", ["", "after 1000", "after 10,000 scenarios", "more"], rows)


# --- kill -9 -------------------------------------------------------------------------------------

KILLED = """
title = "killed"
duration = 0.2
connections = [
  { from = "reference", to = "inverse.reference" },
  { from = "inverse.voltage", to = "plant.voltage" },
]
[fmu.inverse]
source = "IT2Inverse"
[fmu.plant]
source = "IT2Plant"
[signal.reference]
signal = "sine"
frequency = 20.0
low = 1e-6
high = 9e-6
[[vary]]
name = "q2"
of = "plant.rule[1].q2"
range = [1.9e-8, 2.0e-8]
count = 20000
[[metric]]
kind = "e_mr"
of = "plant.displacement"
against = "reference"
"""


def kill_repeatedly() -> None:
    """Kill a sweep at random moments, let it end, and compare its table with an uninterrupted one's."""
    generator = random.Random(20)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "killed.toml")
        path.write_text(KILLED, encoding="utf-8")
        command = [sys.executable, "-m", "it2hys", "sweep", str(path), "--quiet", "-o"]
        begin = time.perf_counter()
        subprocess.run([*command, str(Path(folder, "whole"))], check=True)
        span = time.perf_counter() - begin
        out, kills, done, shares = Path(folder, "out"), 0, 0, []
        parts = len(make_plan(read_sweep(path)).chunks())
        while kills < KILLS:
            # workers that were just starting complain of a parent that is gone
            process = subprocess.Popen(
                [*command, str(out)], start_new_session=True, stderr=subprocess.DEVNULL
            )
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(generator.uniform(0.0, 0.4 * span))
            if process.poll() is None:
                process.send_signal(signal.SIGKILL)
                kills += 1
                shares.append(len(list(out.glob("parts/0*.arrow"))) / parts)
            process.wait()
            for part in out.glob("parts/0*.arrow"):
                pl.read_ipc_stream(part)
            if (out / "results.parquet").exists():
                done += 1
                assert_frame_equal(*(pl.read_parquet(d / "results.parquet") for d in
                                     (out, Path(folder, "whole"))), check_exact=True)  # fmt: skip
                for file in out.iterdir():
                    if file.is_file():
                        file.unlink()
        subprocess.run([*command, str(out)], check=True)
        tables = [pl.read_parquet(Path(folder, d, "results.parquet")) for d in ("out", "whole")]
        assert_frame_equal(*tables, check_exact=True)
    print(
        f"\nKilled (kill -9) {kills} times at random moments, with {100 * min(shares):.0f} to "
        f"{100 * max(shares):.0f} % of the parts there; {done + 1} sweeps ended in between and "
        "after: every part whole, every table that of an uninterrupted sweep, to the last bit"
    )


if __name__ == "__main__":
    main()
