"""The README's commands and code, pasted as they stand."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import YAN9A, needs_measured_records

from it2hys.records import read_record, write_record
from it2hys.stand import Stand, excitations

README = Path(__file__).parents[2] / "README.md"


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)


@pytest.fixture
def rig_folder(tmp_path):
    """Make a folder with the records that the README speaks of."""
    time = excitations.time_grid(0.06, 1e-4)
    signals = {
        "train": excitations.identification(time),
        "minor_loops": excitations.decaying(time, 50.0, 0.03),
        "test": excitations.validation_sine(time, 40.0),
    }
    for seed, (name, voltage) in enumerate(signals.items()):
        write_record(tmp_path / f"{name}.csv", Stand().record(voltage, name, seed=seed))
    return tmp_path


def test_the_worked_example_runs(rig_folder):
    assert_the_worked_example_shows_what_the_stage_does(rig_folder)


@pytest.mark.gate
@needs_measured_records
def test_the_worked_example_runs_on_the_measured_stage(tmp_path):
    for name in ("train", "minor_loops", "test"):
        shutil.copy(YAN9A / f"{name}.csv", tmp_path)
    # two rules, for time's sake
    assert_the_worked_example_shows_what_the_stage_does(tmp_path, "--rules", "2")


def assert_the_worked_example_shows_what_the_stage_does(folder, *options):
    commands, code = blocks("sh"), blocks("python")
    assert len(commands) == 1 and len(code) == 1
    for line in commands[0].strip().splitlines():
        program, *arguments = line.split()
        assert program == ".venv/bin/it2hys"
        done = run([sys.executable, "-m", "it2hys", *arguments, *options], folder)
        assert "report: out/mystage/report.html" in done.stdout
    shown = run([sys.executable, "-W", "error", "-c", code[0]], folder)
    assert "warning" not in (shown.stdout + shown.stderr).lower()
    (ends,) = re.findall(r"^(\S+) to (\S+) µm$", shown.stdout, re.MULTILINE)
    low, high = map(float, ends)
    measured = 1e6 * read_record(folder / "train.csv").displacement
    # before its first sample a model may begin a little beyond
    travel = measured.max() - measured.min()
    assert measured.min() - 0.05 * travel <= low < high <= measured.max() + 0.05 * travel
    assert high - low > 0.7 * (measured.max() - measured.min())


def run(command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done


def test_every_command_of_the_readme_exists():
    text = README.read_text(encoding="utf-8")
    helped = run([sys.executable, "-m", "it2hys", "--help"], ".").stdout
    for command in set(re.findall(r"^    it2hys (\w+)", text, re.MULTILINE)):
        assert re.search(rf"^    {command}\b", helped, re.MULTILINE), command
    makefile = (README.parent / "Makefile").read_text(encoding="utf-8")
    for target in set(re.findall(r"make (\w+)", text)):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
