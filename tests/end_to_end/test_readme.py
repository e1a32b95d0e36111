"""The README's commands and code, pasted as they stand."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from it2hys import excitations
from it2hys.records import write_record
from it2hys.rig import Stand

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
    commands, code = blocks("sh"), blocks("python")
    assert len(commands) == 1 and len(code) == 1
    for line in commands[0].strip().splitlines():
        program, *arguments = line.split()
        assert program == ".venv/bin/it2hys"
        done = run([sys.executable, "-m", "it2hys", *arguments], rig_folder)
        assert "report: out/mystage/report.html" in done
    printed = run([sys.executable, "-c", code[0]], rig_folder)
    low, high = re.fullmatch(r"(\S+) to (\S+) um\n", printed).groups()
    assert -1.0 < float(low) < 2.0 and 10.0 < float(high) < 20.0


def run(command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_command_of_the_readme_exists():
    text = README.read_text(encoding="utf-8")
    helped = run([sys.executable, "-m", "it2hys", "--help"], ".")
    for command in set(re.findall(r"^    it2hys (\w+)", text, re.MULTILINE)):
        assert re.search(rf"^    {command}\b", helped, re.MULTILINE), command
    makefile = (README.parent / "Makefile").read_text(encoding="utf-8")
    for target in set(re.findall(r"make (\w+)", text)):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
