"""The four users' paths, from the wheel in a fresh environment on; nobody has the checkout.

Records are those of the simulated stage, written as CSV before.
"""

import json
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from it2hys.records import write_record
from it2hys.stand import Stand, excitations

ROOT = Path(__file__).parents[2]

pytestmark = [
    pytest.mark.installation,
    pytest.mark.skipif(sys.platform != "linux", reason="paths of a virtual environment on Linux"),
]


@pytest.fixture
def desk(user, empty_path, tmp_path):
    """Return what runs a program in an empty folder, where there is no compiler."""
    return lambda *command: user.run(*command, cwd=tmp_path, path=empty_path)


def write_records(folder):
    time = excitations.time_grid(0.1, 1e-4)
    for seed, (name, voltage) in enumerate(
        [("train", excitations.identification(time)), ("test", excitations.validation_sine(time, 40.0))]
    ):
        write_record(folder / f"{name}.csv", Stand().record(voltage, name, seed=seed))


def test_a_test_engineer_gets_fmus_and_a_report_from_a_csv(desk, tmp_path):
    write_records(tmp_path)
    said = desk("it2hys", "identify", "train.csv", "--test", "test.csv", "--rules", 1, "-o", "out/a")
    assert "it2hys diagnose train.csv --test test.csv -o DIR" in said
    said = desk("it2hys", "diagnose", "train.csv", "--test", "test.csv", "--rules", 1,
                "--exclude", "slew,saturation,resonance,hum,creep,drift,nonlinearity,lag",
                "-o", "out/b")  # fmt: skip
    assert "report: out/b/report.html" in said
    report = json.loads((tmp_path / "out/b/report.json").read_text())
    before, after = (report["error"][when]["test"]["e_rms_um"] for when in ("before", "after"))
    assert report["effects"] and after < 0.5 * before
    with zipfile.ZipFile(tmp_path / "out/b/IT2Plant.fmu") as fmu:
        assert "it2hys diagnose" in fmu.read("documentation/index.html").decode()
    # of the model of the page: the plant follows the voltage that the inverse asks for
    code = (
        "import numpy as np, it2hys\n"
        "y = 7e-6 - 3e-6 * np.cos(np.arange(500) / 30)\n"
        "r = it2hys.track('out/b/IT2Inverse.fmu', 'out/b/IT2Plant.fmu', y)\n"
        "print(np.abs(r['displacement'] - y).max())"
    )
    assert float(desk("python", "-c", code)) < 1e-12


def test_a_control_designer_runs_the_fmus_in_a_system(desk, tmp_path):
    desk("it2hys", "build", "-o", "out")
    said = desk("it2hys", "package", "out/parameters.ssv", "-o", "out/systems", "--ssp", "--c-header")
    assert "out/systems/feedback.ssp" in said and "out/systems/embedded/it2hys_model.h" in said
    time = np.arange(400) * 1e-4
    reference = 7.7 - 4.0 * np.cos(2 * np.pi * 20 * time)
    rows = "\n".join(f"{t:.4f},{y!r}" for t, y in zip(time, reference.tolist(), strict=True))
    (tmp_path / "y.csv").write_text(f"time_s,reference_um\n{rows}\n")
    start = f"initialDisplacement={float(reference[0]) * 1e-6!r}"
    desk("it2hys", "simulate", "out/IT2Inverse.fmu", "--input", "y.csv", "-o", "u.csv", "--set", start)
    desk("it2hys", "simulate", "out/IT2Plant.fmu", "--input", "u.csv", "-o", "z.csv", "--set", start)
    result = np.genfromtxt(tmp_path / "z.csv", delimiter=",", names=True)
    np.testing.assert_allclose(result["displacement_um"], reference, rtol=1e-9)
    page = (ROOT / "docs/tutorials/fmpy_and_ssp.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```{run} python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) == 2
    for block in blocks:
        value, unit = desk("python", "-c", block).split()[-2:]  # behind a warning of the FMU
        assert unit == "µm" and 6.9 < float(value) < 16.0


def test_a_sweeper_gets_a_table_and_a_report(desk, tmp_path):
    page = (ROOT / "docs/tutorials/sweep.md").read_text(encoding="utf-8")
    [toml] = re.findall(r"<<'END'\n(.*?)END\n", page, re.DOTALL)
    (tmp_path / "mine.toml").write_text(toml, encoding="utf-8")
    said = desk("it2hys", "run", "mine.toml", "--workers", 2)
    assert "27 cases, 0 failed" in said and "out/mine/report.html" in said
    code = "import polars as pl; t = pl.read_parquet('out/mine/results.parquet'); print(t.height)"
    assert desk("python", "-c", code).strip() == "27"
    names = {
        row["name"] for row in json.loads(desk("it2hys", "list", "scenarios", "--json"))["scenarios"]
    }
    assert names == {p.stem for p in (ROOT / "scenarios").glob("*.toml")}


def test_a_modelica_user_gets_a_record_for_the_library(desk, tmp_path):
    desk("it2hys", "build", "-o", "out")
    desk("it2hys", "package", "out/parameters.ssv", "-o", "out/modelica", "--modelica")
    [record] = (tmp_path / "out/modelica").glob("*.mo")
    text = record.read_text(encoding="utf-8")
    assert f"record {record.stem}" in text and "IT2Hysteresis.Parameters" in text


def test_types_of_the_package_are_seen_by_a_checker(user, tmp_path):
    """The tests' mypy looks into the user's environment."""
    shown = "".join(f"reveal_type(it2hys.{name})\n" for name in ("InputError", "identify"))
    (tmp_path / "use.py").write_text(f"import it2hys\n{shown}")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--python-executable", user.folder / "bin" / "python", "use.py"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
        env={n: v for n, v in os.environ.items() if n not in ("PYTHONPATH", "MYPYPATH")},
    )  # fmt: skip
    assert "-> it2hys.results.IdentifiedModel" in done.stdout  # of what is loaded when asked for, too
    assert "it2hys.errors.InputError" in done.stdout and "missing library stubs" not in done.stdout
