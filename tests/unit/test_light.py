"""What runs without the libraries that fits, sweeps and reports need, which are most of the weight."""

import subprocess
import sys

import pytest

from it2hys.cli import main

#: Of an installation's 950 MB they are 700.
HEAVY = ("casadi", "scipy", "polars", "matplotlib", "bokeh", "pydantic")
#: A Python in which they are not there.
BARE = f"""
import sys
for name in {HEAVY!r}:
    sys.modules[name] = None
from it2hys.cli import main
sys.exit(main(sys.argv[1:]))
"""


def bare(*arguments):
    """Return a command where the heavy libraries are not installed."""
    return subprocess.run(
        [sys.executable, "-c", BARE, *map(str, arguments)], capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("light")
    (folder / "u.csv").write_text("time_s,voltage_V\n0,1\n1e-4,2\n2e-4,3\n")
    done = bare("build", "-o", folder / "b", "--fmi", 2)
    assert done.returncode == 0, done.stderr
    return folder


def test_fmus_are_built_packaged_and_run_without_them(built):
    for command in (
        ["package", built / "b/parameters.ssv", "--ssp", "--c-header", "--modelica", "-o", built / "p"],
        ["modelica", built / "m.zip"],
        ["simulate", built / "b/IT2Plant.fmu", "--input", built / "u.csv", "-o", built / "y.csv"],
        ["list", "scenarios"],
    ):
        done = bare(*command)
        assert done.returncode == 0, done.stderr
    ours = built / "ours"
    assert main(["build", "--fmi", "2", "--quiet", "-o", str(ours)]) == 0
    assert (built / "b/IT2Plant.fmu").read_bytes() == (ours / "IT2Plant.fmu").read_bytes()


@pytest.mark.parametrize(
    ("command", "missing"), [(["run", "demo"], ""), (["design", "{set}", "-o", "{out}"], "")]
)
def test_what_needs_them_says_so_in_a_sentence(command, missing, built):
    places = {"set": built / "b/parameters.ssv", "out": built / "d"}
    done = bare(*(text.format(**places) for text in command))
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert "this needs the package " in done.stderr and "pip install" in done.stderr
    assert any(name in done.stderr for name in HEAVY)
    assert not (built / "d").exists()
