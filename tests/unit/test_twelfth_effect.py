"""An effect more, added as docs/architecture.md says, passes through all that loops over effects.

In a copy of the tree it is built, and passes the tests of the others that need no records: C and CasADi
are one model, both FMUs compute it, the Modelica library hands it over. A diagnosis finds it.
"""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path

import pytest
from compilers import environment_for_cmake

ROOT = Path(__file__).parents[2]
OWN = Path(__file__).parent / "twelfth"
IN_C = ROOT / "fmu_src" / "tests" / "twelfth"
COPIED = ("python", "fmu_src", "modelica", "tests", "pyproject.toml", "LICENSE")
EFFECT = "tilt"
ROWS = """
[[variable]]
name = "tilt.gain"
effect = "tilt"
type = "Ratio"
description = "Share of its last change by which the displacement is ahead; 0 for none"
"""
TESTS = (
    "tests/unit/test_stage_list.py::test_the_list_is_pythons",
    "tests/unit/test_effect_names.py",
    "tests/unit/test_effects.py::test_each_effect_is_the_same_in_casadi_and_c_and_shows[tilt]",
    "tests/unit/test_effects.py::test_casadi_derives_by_every_parameter_of_an_effect[tilt]",
    "tests/unit/test_effects.py::test_starts_lie_within_their_bounds_and_make_a_usable_set[tilt]",
    "tests/unit/test_casadi_chain.py::test_plant_and_inverse_are_the_compiled_ones[tilt]",
    "tests/interop/test_effects_fmus.py::test_both_fmus_are_the_c_chain_to_the_last_bit[tilt]",
    "tests/modelica/test_parameter_records.py",
    "tests/modelica/test_glue.py::test_the_plant_is_the_c_core_bit_for_bit[tilt]",
    "tests/modelica/test_glue.py::test_what_modelica_gets_is_what_the_packaged_fmu_gives",
)


def said_to_be_touched() -> set[str]:
    """Return the files that docs/architecture.md says an effect touches."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = re.search(r"^## How to add an effect\n(.*?)^## ", text, re.MULTILINE | re.DOTALL)[1]
    steps = re.findall(r"^\d+\. (.*?)(?=^\d+\. |\Z|^$)", section, re.MULTILINE | re.DOTALL)
    places = [place for step in steps for place in re.findall(r"`([\w./<>]+\.\w+)`", step)]
    return {place.replace("<effect>", EFFECT) for place in places}


def replaced(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1, f"{old!r} in {path}"
    path.write_text(text.replace(old, new), encoding="utf-8")


def add_the_effect(tree: Path) -> None:
    """Add it by hand, as a developer would."""
    package = tree / "python" / "it2hys"
    for name in (f"{EFFECT}.h", f"{EFFECT}.c"):
        shutil.copy(IN_C / name, tree / "fmu_src" / "core")
    stages = tree / "fmu_src" / "core" / "stages.h"
    replaced(stages, '#include "slew.h"\n', '#include "slew.h"\n#include "tilt.h"\n')
    replaced(stages, "    NONE(drift,", "    AIMED(tilt, TILT, BEHIND) \\\n    NONE(drift,")
    shutil.copy(OWN / "physics.py", package / "model" / "effects" / f"{EFFECT}.py")
    shutil.copy(OWN / "evidence.py", package / "diagnosis" / "evidence" / f"{EFFECT}.py")
    line = '    "drift": Side.BEHIND,\n'
    replaced(package / "model" / "stages.py", line, f'    "{EFFECT}": Side.BEHIND,\n{line}')
    with (package / "model" / "variables.toml").open("a", encoding="utf-8") as table:
        table.write(ROWS)
    row = f'        "{EFFECT}": lambda: {{"{EFFECT}.gain": uniform(-0.4, 0.4)}},\n'
    replaced(tree / "tests" / "effects.py", '        "drift": lambda', f'{row}        "drift": lambda')


def files(tree: Path) -> Iterator[tuple[str, bytes]]:
    for top in COPIED:
        for path in [tree / top] if (tree / top).is_file() else (tree / top).rglob("*"):
            if path.is_file() and "__pycache__" not in path.parts:
                yield path.relative_to(tree).as_posix(), path.read_bytes()


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of what is needed, without what was built."""
    tree = tmp_path_factory.mktemp("twelfth")
    unwanted = shutil.ignore_patterns("native", "fmus", "__pycache__", ".*")
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, tree / name, ignore=unwanted)
        else:
            shutil.copy(ROOT / name, tree)
    return tree


def run(tree: Path, *command: str) -> str:
    """Run a command of Python's in the tree, which an installation of another must not reach."""
    native = tree / "build" / "native"
    # an editable installation comes before all of sys.path, but only where `site` is loaded
    installed = [sysconfig.get_path("purelib"), sysconfig.get_path("platlib")]
    places = os.pathsep.join([str(tree / "python"), str(tree / "tests"), *dict.fromkeys(installed)])
    environment = {**environment_for_cmake(), "PYTHONPATH": places, "IT2HYS_NATIVE": str(native)}
    done = subprocess.run(
        [sys.executable, "-S", *command],
        cwd=tree,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]
    return done.stdout


def test_an_effect_more_touches_what_is_said_and_passes_through_everything(tree):
    before = dict(files(tree))
    add_the_effect(tree)
    after = dict(files(tree))
    touched = {place for place, content in after.items() if before.get(place) != content}
    assert touched == said_to_be_touched()

    cmake = ["-m", "cmake"]
    run(tree, *cmake, "-S", "fmu_src", "-B", "build", f"-DPython_EXECUTABLE={sys.executable}")
    run(tree, *cmake, "--build", "build", "--target", "native")
    run(tree, "-m", "it2hys.export.modelica", "modelica/IT2Hysteresis")
    generated = {
        name: (tree / "modelica" / "IT2Hysteresis" / name).read_text(encoding="utf-8")
        for name in ("Parameters/Base.mo", "Internal/Values.mo")
    }
    assert "parameter Real tiltGain(" in generated["Parameters/Base.mo"]
    assert "parameters.tiltGain" in generated["Internal/Values.mo"]
    shown = run(tree, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-rs", *TESTS)
    assert re.search(r"\d+ passed", shown) and "skipped" not in shown, shown

    assert "diagnosed" in run(tree, "tests/unit/twelfth/diagnosing.py")
