"""The Makefile's stages and messages, and that a build needs nothing that it does not name."""

import os
import pty
import re
import shutil
import subprocess
import sys
import time
import tomllib
import venv
from importlib.metadata import metadata
from pathlib import Path

import pytest
from compilers import HEADERS, environment_for_cmake
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
#: The Python of Debian 12.
DEBIAN = "3.11.2"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
STAGES = ("pyvenv.cfg", ".runtime", ".installed", ".tools")

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="make is missing")


def make(folder, *arguments, **environment):
    """Return a finished `make`, which must not find Maven: it would fetch."""
    # this test may itself be run by make
    own = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MAKELEVEL", "MFLAGS")}
    return subprocess.run(
        ["make", *arguments],
        cwd=folder,
        env={**own, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def tree(tmp_path):
    """Return a copy of what the Makefile looks at, with a space in its path, not yet installed."""
    folder = tmp_path / "Kopie für make"
    for name in ("fmu_src", "scenarios", "modelica", "python", "tools"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    for name in ("Makefile", "pyproject.toml", "LICENSE", "requirements.lock", "requirements-dev.lock"):
        shutil.copy(ROOT / name, folder)
    return folder


@pytest.fixture
def installed(tree):
    """Return the same as it is after an installation."""
    (tree / ".venv").mkdir()
    for name in STAGES:
        (tree / ".venv" / name).touch()
    return tree


def touch(path):
    """Make a file younger than all others."""
    later = time.time() + 10
    os.utime(path, (later, later))


def test_make_alone_prints_its_goals_and_does_nothing(tree):
    before = sorted(tree.iterdir())
    done = make(tree)
    assert done.returncode == 0
    goals = ["demo", "test", "docs", "diagnosis", "design", "own-effects", "bench", "modelica", "clean"]
    assert [line.split()[:2] for line in done.stdout.splitlines()] == [["make", g] for g in goals]
    assert sorted(tree.iterdir()) == before


def test_the_demo_installs_no_tools_of_the_tests(tree):
    done = make(tree, "--dry-run", "demo")
    assert "-r requirements.lock" in done.stdout and "run demo" in done.stdout
    assert "requirements-dev" not in done.stdout
    assert "requirements-dev.lock" in make(tree, "--dry-run", "test").stdout


def test_an_edit_of_a_python_file_installs_nothing_anew(installed):
    assert make(installed, "--question", "install").returncode == 0
    touch(installed / "python/it2hys/api.py")
    touch(installed / "fmu_src/tests/test_it2.c")
    assert make(installed, "--question", "install").returncode == 0


@pytest.mark.parametrize(
    "name", ["fmu_src/core/chain.c", "python/it2hys/model/variables.toml", "scenarios/demo.toml"]
)
def test_an_edit_of_what_is_compiled_or_copied_does(installed, name):
    touch(installed / name)
    assert make(installed, "--question", "install").returncode == 1
    assert "--editable ." in make(installed, "--dry-run", "install").stdout


def fake_python(folder, script):
    path = folder / "fake_python"
    path.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    path.chmod(0o755)
    return path.name


def test_an_old_python_is_refused_in_a_sentence(tree):
    done = make(tree, "demo", f"PYTHON=./{fake_python(tree, 'exit 1')}")
    assert done.returncode == 2
    assert "it2hys needs Python 3.11 or newer, which ./fake_python is not" in done.stderr
    assert "make PYTHON=python3.12" in done.stderr
    assert not (tree / ".venv").exists()


def test_a_python_without_venv_is_told_of_debians_package(tree):
    script = 'test "$1" = -c && exit 0; mkdir -p .venv; exit 1'
    done = make(tree, "demo", f"PYTHON=./{fake_python(tree, script)}")
    assert done.returncode == 2
    assert "Debian and Ubuntu have that in the package python3-venv" in done.stderr
    assert not (tree / ".venv").exists()


def test_clean_removes_what_was_built(installed):
    for name in ("build", "dist", "out"):
        (installed / name).mkdir()
    kept = {p.name for p in installed.iterdir()} - {".venv", "build", "dist", "out"}
    assert make(installed, "clean").returncode == 0
    assert {p.name for p in installed.iterdir()} == kept


def test_the_makefile_leaves_the_systems_packages_alone():
    assert "apt" not in (ROOT / "Makefile").read_text(encoding="utf-8").split()


# --- what is installed -------------------------------------------------------------------------


def pins(name):
    lines = (ROOT / name).read_text(encoding="utf-8").split()
    return {canonicalize_name(n): version for n, _, version in (line.partition("==") for line in lines)}


def test_what_runs_and_what_tests_is_pinned_apart():
    runtime, tools = pins("requirements.lock"), pins("requirements-dev.lock")
    assert not set(runtime) & set(tools)
    needed = {canonicalize_name(Requirement(r).name) for r in PROJECT["project"]["dependencies"]}
    assert needed <= set(runtime)
    tested = PROJECT["project"]["optional-dependencies"]["test"]
    assert {canonicalize_name(Requirement(r).name) for r in tested} <= set(tools)


def test_the_documentation_has_its_own_pins_and_takes_nothing_into_the_product():
    runtime, tools = pins("requirements.lock"), pins("requirements-dev.lock")
    site = pins("requirements-docs.lock")
    assert {"sphinx", "myst-parser", "furo"} <= set(site)
    assert not set(site) & set(runtime)
    # installed apart, because tools of the tests want another version
    assert set(site) & set(tools) == {"docutils"}


def test_every_pin_is_for_the_python_of_debian():
    """Which is 3.11.2: the newest of a package may ask for a later one."""
    for name, version in (pins("requirements.lock") | pins("requirements-dev.lock")).items():
        installed = metadata(name)
        assert installed["Version"] == version  # or this is another one's answer
        # a package need not say it; `importlib_metadata`, where a test has loaded it, raises for that
        wanted = installed.get("Requires-Python") or ""
        assert DEBIAN in SpecifierSet(wanted), f"{name} asks for Python {wanted}"


@pytest.mark.installation
def test_every_pin_of_the_documentation_does(tmp_path):
    done = subprocess.run(
        [
            *(sys.executable, "-m", "pip", "install", "--dry-run", "--no-deps", "--ignore-installed"),
            *("--python-version", DEBIAN, "--only-binary", ":all:", "--target", tmp_path / "site"),
            *("-r", ROOT / "requirements-docs.lock"),
        ],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0 and "yanked" not in done.stderr, done.stderr


def test_developers_build_with_the_tools_of_an_isolated_build():
    both = pins("requirements.lock") | pins("requirements-dev.lock")
    for text in PROJECT["build-system"]["requires"]:
        requirement = Requirement(text)
        assert str(requirement.specifier) == f"=={both[canonicalize_name(requirement.name)]}"


def test_the_generator_of_the_c_tables_needs_the_standard_library_alone(tmp_path):
    """As CMake runs it in an isolated build; -S leaves out all that is installed."""
    command = [sys.executable, "-E", "-S", "-m", "it2hys.fmu.codegen", str(tmp_path)]
    subprocess.run(command, cwd=ROOT / "python", check=True)
    assert {p.name for p in tmp_path.iterdir()} == {
        "fmu_table.h", "fmu_places.h", "fmu_table_hash.h", "chain_table.h", "fmu_start.h",
        "controller_table.h", "controller_start.h",
    }  # fmt: skip
    cmake = (ROOT / "fmu_src" / "CMakeLists.txt").read_text(encoding="utf-8")
    assert "${Python_EXECUTABLE} -E -S -m it2hys.fmu.codegen" in cmake
    assert "PYTHONPATH" not in cmake


def test_the_c_sources_are_joined_with_the_standard_library_alone(tmp_path):
    """As CMake does it, and to the same bytes as Modelica's."""
    run = [sys.executable, "-E", "-S", "-m"]
    for module, *arguments in (
        ("it2hys.fmu.codegen", tmp_path),
        ("it2hys.fmu.amalgamation", ROOT / "fmu_src", tmp_path),
    ):
        subprocess.run([*run, module, *map(str, arguments)], cwd=ROOT / "python", check=True)
    library = ROOT / "modelica/IT2Hysteresis/Resources/C-Sources"
    for name in ("it2hys.h", "it2hys.c"):
        assert (tmp_path / "sources" / name).read_bytes() == (library / name).read_bytes()
    cmake = (ROOT / "fmu_src" / "CMakeLists.txt").read_text(encoding="utf-8")
    assert cmake.count("${Python_EXECUTABLE} -E -S -m it2hys.") == 2


def test_the_headers_of_fmi_are_those_of_fmpy(tmp_path):
    """No copy of them is here, and where they are missing, CMake says what to install."""
    names = {path.name for path in HEADERS.glob("fmi2*.h")}
    assert len(names) == 3
    assert not [path for path in (ROOT / "fmu_src").rglob("*.h") if path.name in names]
    bare = tmp_path / "bare"
    venv.create(bare)
    python = next(bare.glob("bin/python"))
    command = ["cmake", "-S", str(ROOT / "fmu_src"), "-B", str(tmp_path / "build"), "-G", "Ninja"]
    done = subprocess.run(
        [*command, f"-DPython_EXECUTABLE={python}"], capture_output=True, text=True, check=False,
        env=environment_for_cmake(),
    )  # fmt: skip
    assert done.returncode != 0
    assert "has no package fmpy" in done.stderr


# --- what is shown meanwhile -------------------------------------------------------------------

WATCH = [sys.executable, str(ROOT / "tools" / "watch.py")]
SLOW = "for i in range(4): print(f'[{i}/4] step', flush=True); time.sleep(0.4)"


def shown(code, terminal=False):
    command = [*WATCH, "building", sys.executable, "-c", f"import sys, time\n{code}"]
    if not terminal:
        return subprocess.run(command, capture_output=True, text=True, check=False)
    master, screen = pty.openpty()
    with subprocess.Popen(command, stdout=screen, stderr=screen) as process:
        os.close(screen)
        text = b""
        try:
            while piece := os.read(master, 4096):
                text += piece
        except OSError:  # how Linux says that the other side is closed
            pass
    os.close(master)
    return subprocess.CompletedProcess(command, process.returncode, text.decode(), "")


def test_a_pipe_gets_few_lines():
    done = shown(SLOW)
    assert done.returncode == 0
    lines = done.stdout.splitlines()
    assert lines[0] == "building ..." and re.fullmatch(r"building: done after \d+ s", lines[-1])
    assert len(lines) <= 3  # one every ten seconds


def test_a_terminal_gets_one_line_that_changes():
    done = shown(SLOW, terminal=True)
    assert done.returncode == 0
    assert re.search(r"building: \d s  \[\d/4\] step", done.stdout)
    assert done.stdout.count("\n") == 1 and done.stdout.count("\r\033[K") > 2


def test_all_is_shown_of_a_build_that_fails():
    done = shown("print('first'); print('why', file=sys.stderr); sys.exit(3)")
    assert done.returncode == 3
    assert "building: failed after" in done.stdout
    assert {"first", "why"} <= set(done.stderr.splitlines())
