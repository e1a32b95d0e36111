"""An effect of the user's own on the command line: begun, checked, found in records, refused."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from conftest import TS, UM
from own_effects import file_of, in_chain
from test_cli import assert_refused, run
from test_diagnose import stage_with

from it2hys import diagnose, package
from it2hys.fmu.own_library import use_effects
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet
from it2hys.model.stages import EFFECTS
from it2hys.records import Record, write_record

SAMPLES, NOISE = 1500, 0.004 * UM
MOUNT = {"mount.gain": 0.15, "mount.frequency": 350.0, "mount.damping": 0.05}
#: So that it is quick: what is tested is the way, not the search.
OTHERS = ",".join(name for name in EFFECTS)


def measure(stage: ParameterSet, name: str, seed: int) -> Record:
    """Return a record of a slow sine and a chirp over the mount's resonance, with noise."""
    rng, time = np.random.default_rng(seed), np.arange(SAMPLES) * TS
    chirp = np.cos(2 * np.pi * (30.0 * time + 0.5 * rng.uniform(4000.0, 5000.0) * time**2))
    voltage = 50.0 - 30.0 * np.cos(2 * np.pi * rng.uniform(9.0, 14.0) * time) - 15.0 * chirp
    measured = compiled.chain_free_run(stage, voltage)[1] + NOISE * rng.standard_normal(SAMPLES)
    return Record(name, time, voltage, measured, TS)


@pytest.fixture(scope="module")
def records(tmp_path_factory) -> Path:
    """Return a folder with a training and a validation record of a stage whose mount rings."""
    folder = tmp_path_factory.mktemp("own")
    with in_chain("mount"):
        stage = stage_with(**MOUNT)
        for seed, name in enumerate(("train", "valid"), start=1):
            write_record(folder / f"{name}.csv", measure(stage, name, seed))
    return folder


@pytest.fixture(scope="module")
def diagnosed(records) -> Path:
    """Return the folder of a diagnosis by two processes."""
    assert run(
        "diagnose", records / "train.csv", "--validate", records / "valid.csv", "--rules", 1,
        "--effect", file_of("mount"), "--exclude", OTHERS, "--workers", 2, "-o", records / "out",
        "--quiet",
    ) == 0  # fmt: skip
    assert "mount" not in EFFECTS
    return records / "out"


def test_it_is_found_fitted_and_packaged(diagnosed):
    report = json.loads((diagnosed / "report.json").read_text(encoding="utf-8"))
    assert report["effects"] == ["mount"]
    for name, value in MOUNT.items():
        assert report["parameters"][name]["value"] == pytest.approx(value, rel=0.02)
    (named,) = [entry for entry in report["inputs"] if entry["name"] == "mount.py"]
    assert len(named["sha256"]) == 64
    with zipfile.ZipFile(diagnosed / "IT2Plant.fmu") as archive:
        assert archive.read("resources/mount.py") == file_of("mount").read_bytes()


def test_its_set_is_packaged_with_the_file_beside_it(diagnosed, tmp_path, capsys):
    command = ["package", diagnosed / "parameters.ssv", "-o", tmp_path / "out"]
    assert_refused(capsys, command, "effects of your own, mount", f"--effect {diagnosed / 'mount.py'}")
    assert not (tmp_path / "out").exists()
    more = ["--effect", diagnosed / "mount.py", "--c-header", "--modelica", "--ssp", "--quiet"]
    assert run(*command, *more) == 0
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"IT2Plant.fmu", "IT2Inverse_fmi3.fmu", "mount.py", "parameters.ssv", "embedded"} <= written


def test_one_that_is_not_found_is_not_in_the_fmus(records):
    """Declared is the right one; the other has its chance, and leaves nothing behind."""
    assert run(
        "diagnose", records / "train.csv", "--validate", records / "valid.csv", "--rules", 1,
        "--effect", file_of("mount"), "--effect", file_of("beat"), "--declared", "mount",
        "--exclude", OTHERS, "--workers", 0, "-o", records / "two", "--quiet",
    ) == 0  # fmt: skip
    assert (records / "two" / "mount.py").exists()
    assert not (records / "two" / "beat.py").exists()
    assert "beat." not in (records / "two" / "parameters.ssv").read_text()


def test_the_api_takes_it(records, tmp_path):
    paths = [records / "train.csv"], [records / "valid.csv"]
    try:
        found = diagnose(*paths, rules=1, exclude=OTHERS.split(","), own_effects=[file_of("mount")])
        assert found.effects == ("mount",)
        written = package(found, tmp_path / "out", own_effects=[file_of("mount")])
        assert tmp_path / "out" / "mount.py" in written
    finally:
        use_effects(())


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[u, state[0]]", "[u]", "the number of states cannot change"),
        ('name = "mount"', 'name = "lag"', "step raises KeyError"),
        ("import math", "import mathx", "No module named"),
        ("angle = 2", "angle = ca.sqrt(-1 - x * x)", "is not finite"),
    ],
)
def test_what_cannot_be_a_stage_is_refused_before_the_work(records, tmp_path, capsys, old, new, said):
    text, path = file_of("mount").read_text(encoding="utf-8"), tmp_path / "mine.py"
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    command = ["diagnose", records / "train.csv", "--effect", path, "-o", tmp_path / "out"]
    assert_refused(capsys, command, f"{path}:", said)
    assert not (tmp_path / "out").exists()


def test_an_effect_is_begun_and_checked(records, tmp_path, capsys):
    path = tmp_path / "slow.py"
    assert run("effect", "new", "slow", "-o", path) == 0
    assert_written = path.read_text(encoding="utf-8")
    assert 'name = "slow"' in assert_written
    capsys.readouterr()
    assert_refused(capsys, ["effect", "new", "slow", "-o", path], "this file exists already")
    assert_refused(capsys, ["effect", "new", "lag"], "an effect of this name already")
    assert_refused(capsys, ["effect", "new", "Slow"], "lower-case")
    assert run("effect", "check", path, "--records", records / "train.csv") == 0
    rows = capsys.readouterr().out.splitlines()
    for what in ("causality", "finite over train", "monotone over train", "inverse over train"):
        assert any(row.startswith(f"ok    {what}") for row in rows), rows
    for what in ("derivatives over train", "C and CasADi", "time"):
        assert any(row.startswith(f"ok    {what}") for row in rows), rows


def test_a_check_that_fails_is_a_finding(tmp_path, capsys):
    """It rises where it rests at any voltage of Table 1, and falls when the voltage goes fast."""
    text = file_of("charge").read_text(encoding="utf-8")
    old, new = "* leaked, [leaked]", "* (leaked + 0.003 * (x - state[0]) ** 3), [leaked]"
    assert old in text
    path = tmp_path / "charge.py"
    text = text.replace(old, new).replace("low=-0.3, high=0.3", "low=0.01, high=0.1")
    path.write_text(text, encoding="utf-8")
    assert run("effect", "check", path) == 1
    assert "FAIL  monotone over Table 1" in capsys.readouterr().out
