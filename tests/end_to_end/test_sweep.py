"""Whole sweeps: one table whoever runs them and however often they are interrupted."""

import errno
import hashlib
import html
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import namedtuple
from pathlib import Path

import jsonschema
import polars as pl
import pytest
from foreign_fmu import build_foreign
from polars.testing import assert_frame_equal
from test_cli import html_of

import it2hys
from it2hys.cli import main
from it2hys.errors import InputError
from it2hys.sweeps import parse_sweep, read_sweep, run_sweep, store, sweep, worker
from it2hys.sweeps.cases import make_plan

SCHEMA = json.loads((Path(__file__).parents[2] / "docs" / "sweep_report.schema.json").read_text())
SCENARIO = """
title = "Sweeps under test"
seed = 3
samples = 40
duration = 0.1
lead_in = 0.02
connections = [
  { from = "reference", to = "inverse.reference" },
  { from = "inverse.voltage", to = "plant.voltage" },
]
keep = ["reference", "plant.displacement"]
keep_every = 50

[fmu.inverse]
source = "IT2Inverse"
start = { initialDisplacement = 1e-6 }

[fmu.plant]
source = "IT2Plant"
start = { initialDisplacement = 1e-6 }

[signal.reference]
signal = "sine"
frequency = 50.0
low = 1e-6
high = 9e-6

[[vary]]
name = "top"
of = "reference.high"
range = [5e-6, 12e-6]
count = 30

[[vary]]
name = "q2"
of = "plant.rule[1].q2"
method = "random"
range = [1.5e-8, 2.2e-8]

[[metric]]
kind = "e_mr"
of = "plant.displacement"
against = "reference"

[[metric]]
name = "drive"
kind = "max"
of = "inverse.voltage"
"""
CASES = 1200


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    path = tmp_path_factory.mktemp("scenario") / "under_test.toml"
    path.write_text(SCENARIO, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def expected(scenario, tmp_path_factory):
    """Return the table of an uninterrupted run in one process."""
    outcome = run_sweep(read_sweep(scenario), tmp_path_factory.mktemp("expected"), 0)
    table = pl.read_parquet(outcome.results)
    assert table["case"].to_list() == list(range(CASES))
    assert table["status"].unique().to_list() == ["ok"]
    assert table["e_mr"].null_count() == 0 and table["plant.displacement"].list.len().max() == 20
    return table


def assert_same(directory, expected):
    """Assert the same rows in the same order, to the last bit, and that nothing else is left."""
    table = pl.read_parquet(directory / "results.parquet")
    assert_frame_equal(table, expected, check_exact=True)
    left = {path.name for path in directory.iterdir() if not path.name.startswith("figure")}
    assert left == {"results.parquet", "report.html", "report.json"}


# --- whoever runs it ---------------------------------------------------------------------------


@pytest.mark.parametrize("workers", [1, 2])
def test_the_table_does_not_depend_on_the_number_of_workers(
    workers, scenario, expected, tmp_path, capsys
):
    arguments = ["sweep", str(scenario), "-o", str(tmp_path), "--workers", str(workers), "--json"]
    assert main(arguments) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["cases"] == CASES and said["failed"] == 0
    assert Path(said["results"]) == tmp_path / "results.parquet"
    assert_same(tmp_path, expected)


def test_a_dask_cluster_gives_the_same_table_though_a_worker_is_killed(scenario, expected, tmp_path):
    distributed = pytest.importorskip("distributed")
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    )
    killed = []

    def kill_a_worker():
        while not list(tmp_path.glob("parts/0*.arrow")):
            time.sleep(0.005)
        killed.append(next(iter(cluster.workers.values())).pid)
        os.kill(killed[0], signal.SIGKILL)

    with cluster:
        thread = threading.Thread(target=kill_a_worker)
        thread.start()
        address = cluster.scheduler_address
        assert main(["sweep", str(scenario), "-o", str(tmp_path), "--dask", address, "--quiet"]) == 0
        thread.join()
    assert killed
    assert_same(tmp_path, expected)


def test_a_dask_scheduler_that_does_not_answer_is_named_before_any_case_runs(
    scenario, tmp_path, capsys, monkeypatch
):
    pytest.importorskip("distributed")
    monkeypatch.setattr("it2hys.sweeps.pool.PATIENCE", "1s")
    for address in ("tcp://127.0.0.1:1", "nonsense://x"):
        arguments = ["sweep", str(scenario), "-o", str(tmp_path / "out"), "--dask", address]
        assert main(arguments) == 2
        error = capsys.readouterr().err
        assert f"--dask {address}: no Dask scheduler answers" in error
        assert not (tmp_path / "out").exists()


def test_a_worker_begins_without_what_most_cases_do_not_need():
    """Its start is most of what a small sweep takes: scipy's parts alone were half of it."""
    late = {"scipy.signal", "scipy.stats", "matplotlib", "jinja2", "it2hys.fmu.packaging"}
    code = f"import sys, it2hys.sweeps.worker; print(sorted({late} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


# --- however it is interrupted -----------------------------------------------------------------


def start(scenario, directory):
    """Start the command in a session of its own."""
    command = [sys.executable, "-m", "it2hys", "sweep", str(scenario), "-o", str(directory)]
    return subprocess.Popen(
        [*command, "--workers", "2", "--quiet"], start_new_session=True, stderr=subprocess.PIPE
    )


def group_is_gone(group, patience=20.0):
    """Tell whether all processes of a group end; workers must not outlive what started them."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="needs process groups")
def test_kill_9_at_any_moment_loses_nothing_and_doubles_nothing(scenario, expected, tmp_path):
    """Some kills here; benchmarks/sweep.py does twenty."""
    generator, kept = random.Random(0), [0]
    for _ in range(2):
        process = start(scenario, tmp_path)
        # from the first part that this run adds, so that every run gets somewhere
        while process.poll() is None and len(list(tmp_path.glob("parts/0*.arrow"))) <= kept[-1]:
            time.sleep(0.005)
        time.sleep(generator.uniform(0.0, 0.15))
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stderr.close()
        assert group_is_gone(process.pid)
        for part in tmp_path.glob("parts/0*.arrow"):
            pl.read_ipc_stream(part)
        kept.append(len(list(tmp_path.glob("parts/0*.arrow"))))
    assert kept[1] > 0 or (tmp_path / "results.parquet").exists()
    process = start(scenario, tmp_path)
    assert process.wait() == 0, process.stderr.read()
    process.stderr.close()
    assert_same(tmp_path, expected)


def test_a_resumed_sweep_runs_only_what_is_missing(scenario, expected, tmp_path, monkeypatch):
    run, calls = worker.run_cases, []

    def interrupted(fingerprint, cases):
        calls.append(cases)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return run(fingerprint, cases)

    monkeypatch.setattr(worker, "run_cases", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_sweep(read_sweep(scenario), tmp_path, 0)
    (tmp_path / "parts" / ".000007.arrow.half").write_bytes(b"half")  # a write that was cut off
    run_sweep(read_sweep(scenario), tmp_path, 0)
    assert_same(tmp_path, expected)
    chunks = make_plan(read_sweep(scenario)).chunks()
    assert sorted(c.start for c in calls) == sorted([*(c.start for c in chunks), calls[3].start])
    calls.clear()
    run_sweep(read_sweep(scenario), tmp_path, 0)
    assert calls == []


def test_a_worker_that_is_killed_costs_no_case(scenario, expected, tmp_path, monkeypatch):
    pools = []
    make = sweep.Processes

    def processes(*arguments):
        pools.append(make(*arguments))
        return pools[0]

    monkeypatch.setattr(sweep, "Processes", processes)

    def kill_a_worker():
        while not list(tmp_path.glob("parts/0*.arrow")):
            time.sleep(0.005)
        os.kill(next(iter(pools[0]._pool._processes)), signal.SIGKILL)

    thread = threading.Thread(target=kill_a_worker)
    thread.start()
    run_sweep(read_sweep(scenario), tmp_path, 2)
    thread.join()
    assert_same(tmp_path, expected)


# --- cases that fail ---------------------------------------------------------------------------


def small(**changes):
    """Return a scenario of five cases as a dictionary."""
    return {
        "duration": 0.02,
        "fmu": {"plant": {"source": "IT2Plant"}},
        "signal": {"voltage": {"signal": "sine", "frequency": 50.0}},
        "connections": [{"from": "voltage", "to": "plant.voltage"}],
        "vary": [{"name": "x", "of": "plant.rule[1].sigmaLower",
                  "values": [4.0e-6, 4.1e-6, 4.2e-6, 4.3e-6, 4.4e-6]}],
        "metric": [{"name": "top", "kind": "max", "of": "plant.displacement"}],
        **changes,
    }  # fmt: skip


def test_a_case_that_fails_is_a_row_with_its_message():
    """The lower deviation is above the upper one, which the FMU refuses, and nobody else can know."""
    good = it2hys.sweep(small())
    vary = small()["vary"][0]
    values = [*vary["values"][:2], 30e-6, *vary["values"][3:]]
    table = it2hys.sweep(small(vary=[{**vary, "values": values}]))
    assert table["status"].to_list() == ["ok", "ok", "failed", "ok", "ok"]
    failed = table.row(2, named=True)
    assert failed["x"] == 30e-6 and failed["top"] is None
    assert failed["message"].startswith("plant (IT2Plant): ") and "rule[1].sigma" in failed["message"]
    others = pl.Series([0, 1, 3, 4])
    assert_frame_equal(table[others], good[others], check_exact=True)


def test_cases_beyond_the_range_of_their_model_are_counted_everywhere(tmp_path):
    """They are not failures: the numbers are an extrapolation, and somebody has to say so."""
    varied = [{"name": "x", "of": "voltage.high", "values": [50.0, 100.0, 130.0, 1900.0]}]
    scenario = parse_sweep(small(duration=1.0, vary=varied))
    outcome = run_sweep(scenario, tmp_path / "out", 0)
    table = pl.read_parquet(outcome.results)
    assert table["status"].to_list() == ["ok"] * 4
    assert table["warned"].to_list() == [False, False, True, True]
    outside = table["out_of_range"].to_list()
    assert outside[:2] == [0, 0]
    assert 0 < outside[2] < outside[3] < 10_000
    assert table["top"][3] < 13 * 16e-6  # a straight continuation, not 1e100 m
    assert (outcome.failed, outcome.warned, outcome.out_of_range) == (0, 2, 2)
    expected = (
        "4 cases, 0 failed, 2 with warnings: in 2 a plant leaves the range of its model "
        f"(outOfRange), for up to {outside[3]} samples"
    )
    assert outcome.summary == expected
    assert expected in outcome.report.read_text(encoding="utf-8")
    assert main(["sweep", str(outcome.results), "-o", str(tmp_path / "again")]) == 0
    assert expected in (tmp_path / "again" / "report.html").read_text(encoding="utf-8")


def test_messages_name_the_instance_and_its_model(tmp_path):
    """Two plants of one model leave their range, at voltages of their own."""
    fmus = {name: {"source": "IT2Plant"} for name in ("stiff", "soft")}
    connections = [{"from": "voltage", "to": f"{name}.voltage", "offset": 200.0} for name in fmus]
    metric = [{"name": "top", "kind": "max", "of": "soft.displacement"}]
    vary = [{"name": "x", "of": "soft.force", "values": [0.0, 1.0]}]
    table = small(fmu=fmus, connections=connections, metric=metric, vary=vary, duration=0.001)
    outcome = run_sweep(parse_sweep(table), tmp_path, 0)
    for message in pl.read_parquet(outcome.results)["message"]:
        said = message.split(" | ")
        assert {text.partition(": ")[0] for text in said} == {"stiff (IT2Plant)", "soft (IT2Plant)"}
        assert all(text.endswith(".") for text in said)
    page = html.unescape(outcome.report.read_text(encoding="utf-8"))
    for text in said:
        assert re.sub(r"\b\d+(\.\d+)?(e[-+]?\d+)?\b", "…", text) in page


def foreign_table(path, values):
    return {
        "duration": 1.0,
        "step": 0.1,
        "fmu": {"a": {"source": str(path), "start": {"on": True}}},
        "signal": {"n": {"signal": "triangle"}},
        "connections": [{"from": "n", "to": "a.n"}],
        "vary": [{"name": "x", "of": "a.x", "values": values}],
        "metric": [{"name": "y", "kind": "final", "of": "a.y"}],
    }


def test_an_fmu_that_allows_but_one_instance_is_shared_by_threads(tmp_path):
    """Threads of a Dask worker take turns; two components of that FMU are refused."""
    path = build_foreign(tmp_path, capabilities='canBeInstantiatedOnlyOncePerProcess="true"')
    table = foreign_table(path, [float(x) for x in range(40)])
    plan = make_plan(parse_sweep(table))
    worker.install(plan)
    pieces = {}

    def run(cases):
        pieces[cases.start] = pl.read_ipc_stream(worker.run_cases(plan.fingerprint, cases))

    threads = [threading.Thread(target=run, args=(range(a, a + 10),)) for a in range(0, 40, 10)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    worker.close()
    rows = pl.concat([pieces[a] for a in sorted(pieces)])
    assert rows["y"].to_list() == [x + 0.9 for x in range(40)]
    table["fmu"]["b"] = table["fmu"]["a"]
    with pytest.raises(InputError, match=r"fmu.a: is the same FMU as fmu.b, .* only once per process"):
        make_plan(parse_sweep(table))


def test_an_fmu_that_crashes_costs_its_case_alone(tmp_path):
    """Its binary calls abort(), which ends the process that runs it."""
    path = build_foreign(tmp_path)
    values = [0.0, -5.0, -1.5, 3.0]
    outcome = run_sweep(parse_sweep(foreign_table(path, values)), tmp_path / "out", 2)
    table = pl.read_parquet(outcome.results)
    assert outcome.failed == 2
    assert table.filter(pl.col("status") == "failed")["case"].to_list() == [1, 2]
    assert "an FMU's binary crashed" in table["message"][1]
    assert "x is -1.5, which is fatal" in table["message"][2]
    good = table.filter(pl.col("status") == "ok")
    assert good["y"].to_list() == [x + 0.9 for x in good["x"]]
    page = outcome.report.read_text(encoding="utf-8")
    assert "Cases that failed" in page and "binary crashed" in page


# --- the disk, the directory, the report -------------------------------------------------------


def test_a_script_that_lacks_its_guard_is_told_so(tmp_path):
    """Spawned workers import the script again, which must not begin a sweep of its own."""
    script = tmp_path / "script.py"
    script.write_text(f"import it2hys\nit2hys.sweep({small()!r}, workers=1)\n", encoding="utf-8")
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert 'must do so under if __name__ == "__main__"' in done.stderr.splitlines()[-1]


def test_a_disk_that_is_too_full_is_told_before_any_case_runs(scenario, tmp_path, monkeypatch, capsys):
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(10**9, 10**9 - 10**6, 10**6))
    monkeypatch.setattr(worker, "run_cases", lambda *_: pytest.fail("a case has run"))
    out = tmp_path / "out"
    assert main(["sweep", str(scenario), "-o", str(out), "--workers", "0", "--quiet"]) == 2
    assert "1 MB are free" in capsys.readouterr().err
    assert not out.exists()


def test_a_disk_that_fills_up_ends_the_sweep_which_can_be_resumed(
    scenario, expected, tmp_path, monkeypatch, capsys
):
    replace, count = os.replace, []

    def full(source, target):
        if str(target).endswith("000002.arrow") and not count:
            count.append(1)
            raise OSError(errno.ENOSPC, "No space left on device")
        replace(source, target)

    monkeypatch.setattr(os, "replace", full)
    arguments = ["sweep", str(scenario), "-o", str(tmp_path), "--workers", "0", "--quiet"]
    assert main(arguments) == 2
    assert "000002.arrow: cannot be written: No space left on device" in capsys.readouterr().err
    assert len(list((tmp_path / "parts").glob("*.arrow"))) == 2
    assert not (tmp_path / "results.parquet").exists()
    assert main(arguments) == 0
    assert_same(tmp_path, expected)


def test_the_results_of_another_sweep_are_not_touched_unless_told(tmp_path):
    run_sweep(parse_sweep(small()), tmp_path, 0)
    before = (tmp_path / "results.parquet").read_bytes()
    other = parse_sweep(small(duration=0.03))
    with pytest.raises(InputError, match=r"holds results of another sweep.*--restart"):
        run_sweep(other, tmp_path, 0)
    assert (tmp_path / "results.parquet").read_bytes() == before
    run_sweep(other, tmp_path, 0, restart=True)
    assert (tmp_path / "results.parquet").read_bytes() != before
    # texts and figures are no part of what the table depends on
    run_sweep(parse_sweep(small(duration=0.03, title="new")), tmp_path, 0)
    with pytest.raises(InputError, match="--workers -1"):
        run_sweep(other, tmp_path / "new", -1)


FIGURES = """
[[figure]]
kind = "heat map"
x = "top"
y = "q2"
value = "e_mr"

[[figure]]
kind = "lines"
x = "top"
value = "e_mr"

[[figure]]
kind = "loops"
x = "reference"
y = "plant.displacement"
by = "top"

[[figure]]
kind = "time course"
value = "plant.displacement"
by = "top"
select = { top = 9e-6 }

[[figure]]
kind = "distribution"
value = "e_mr"
"""


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Return a scenario with figures of every kind, and what the command made of it."""
    path = tmp_path_factory.mktemp("drawn") / "s.toml"
    path.write_text(SCENARIO + FIGURES, encoding="utf-8")
    out = path.parent / "out"
    assert main(["sweep", str(path), "-o", str(out), "--workers", "0", "--quiet"]) == 0
    return path, out


def test_the_report_is_drawn_from_the_table_alone(drawn, tmp_path):
    _, out = drawn
    shutil.copy(out / "results.parquet", tmp_path)
    moved = tmp_path / "results.parquet"
    assert main(["sweep", str(moved), "-o", str(tmp_path / "again"), "--quiet"]) == 0
    first, again = (
        {p.name: p.read_bytes() for p in folder.glob("*.png")} for folder in (out, tmp_path / "again")
    )
    assert first == again
    kinds = ["1_heat_map", "2_lines", "3_loops", "4_time_course", "5_distribution"]
    assert set(again) == {f"figure_{kind}.png" for kind in kinds}
    assert all(len(content) > 8000 for content in again.values())
    # but for what it was made by and of, which ends it
    first, again = (html_of(f).split('<div class="about">') for f in (out, tmp_path / "again"))
    assert first[0] == again[0] and len(first) == len(again) == 2


def test_a_sweep_says_what_it_was_made_by_and_of(drawn, tmp_path):
    path, made = drawn
    out = shutil.copytree(made, tmp_path / "out")
    report = json.loads((out / "report.json").read_text(encoding="utf-8"))
    jsonschema.validate(report, SCHEMA)
    assert report["command"].startswith(f"it2hys sweep {path}") and report["seed"] is not None
    (entry,) = [i for i in report["inputs"] if i["name"] == "s.toml"]
    assert entry["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert entry["sha256"] in html_of(out)
    assert (report["cases"], report["failed"]) == (CASES, 0)
    (out / "report.html").unlink()
    assert main(["report", str(out), "--quiet"]) == 0
    assert json.loads((out / "report.json").read_text(encoding="utf-8")) == report
    assert entry["sha256"] in html_of(out)


def test_a_file_that_is_no_table_is_named(tmp_path, capsys):
    pl.DataFrame({"a": [1]}).write_parquet(tmp_path / "other.parquet")
    (tmp_path / "broken.parquet").write_bytes(b"PAR1")
    for name in ("other", "broken"):
        assert main(["sweep", str(tmp_path / f"{name}.parquet")]) == 2
        assert f"{name}.parquet: no table of `it2hys sweep`" in capsys.readouterr().err
    assert main(["sweep", str(tmp_path / "none.parquet")]) == 2
    assert "none.parquet: no such file" in capsys.readouterr().err


def test_the_table_carries_what_it_is(expected, scenario, tmp_path):
    outcome = run_sweep(parse_sweep(small()), tmp_path, 0)
    known = store.read_metadata(outcome.results)
    assert known["metrics"] == [
        {"name": "top", "kind": "max", "unit": "m", "of": "plant.displacement", "against": ""}
    ]
    assert known["axes"] == [{"name": "x", "unit": "m", "method": "grid", "scale": "linear"}]
    assert known["cases"] == 5
    assert json.dumps(known)
    assert expected.columns == [
        "case", "variant", "top", "q2", "e_mr", "drive", "reference", "plant.displacement", "status",
        "warned", "out_of_range", "message",
    ]  # fmt: skip
    assert Path(scenario).exists()
