"""The C side's one list: another stage is its own file and a line of the list, and nothing else.

The layer of the FMUs knows neither stages nor any other physics, nor a version of FMI.
"""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from compilers import compiler

from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.model.effect import Memory
from it2hys.model.stages import BEFORE_CORE, BEHIND_CORE, EFFECTS, READING
from it2hys.model.variables import load_table

SOURCES = Path(__file__).parents[2] / "fmu_src"
LIST = SOURCES / "core" / "stages.h"
ENTRY = re.compile(r"^    ([A-Z]+)\((\w+), ([A-Z]+), ([A-Z]+)\)", re.MULTILINE)
STRICT = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off"]


def text_of(path: Path) -> str:
    """Return a C file without its comments and what it says to people."""
    text = re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    return re.sub(r'"[^"\n]*%[^"\n]*"|"[^"\n]* [^"\n]*"', "", text)


def test_the_list_is_pythons():
    found = ENTRY.findall(LIST.read_text(encoding="utf-8"))
    assert [name for _, name, _, _ in found] == list(EFFECTS)
    sides = {"BEFORE": BEFORE_CORE, "BEHIND": BEHIND_CORE, "READING": READING}
    for memory, name, upper, side in found:
        assert upper == name.upper()
        assert name in sides[side]
        assert EFFECTS[name].memory is Memory[memory]
        source = text_of(SOURCES / "core" / f"{name}.c")
        stage = re.search(rf"{name}_stage = {{(.*?)}};", source, re.DOTALL)[1]
        assert EFFECTS[name].limits == (".limits = true" in stage)
        assert EFFECTS[name].has_inverse == (".inverse = " in stage)


@pytest.mark.parametrize("effect", EFFECTS)
def test_what_an_effect_says_of_itself_is_there(effect):
    known, evidence = load_table().parameters(), EVIDENCE[effect]
    assert list(EVIDENCE) == list(EFFECTS)
    assert evidence.meaning and evidence.experiment
    assert evidence.channel in (None, "force", "temperature")
    stage = EFFECTS[effect]
    own = {*stage.per_record, *filter(None, [stage.shift, stage.sampling_delay])}
    assert {known[name].effect for name in own} <= {effect}


def test_one_effect_shifts_what_is_sampled():
    assert [name for name, effect in EFFECTS.items() if effect.shift] == ["delay"]
    assert {name for name, effect in EFFECTS.items() if effect.sampled} == {"lag", "resonance", "slew"}


@pytest.mark.parametrize("effect", EFFECTS)
def test_no_file_but_its_own_and_the_list_names_a_stage(effect):
    """Counts and histories are parameters of the set, and have names of their own."""
    named = re.compile(rf"\b{effect}(_\w+)?\b|\bCHAIN_{effect.upper()}\b")
    own = {f"{effect}.c", f"{effect}.h", LIST.name}
    folders = ("core", "fmi", "models", "identification", "python")
    files = [p for f in folders for p in (SOURCES / f).glob("*.[ch]") if p.name not in own]
    assert len(files) > 40
    found = {p.name: named.search(text_of(p))[0] for p in files if named.search(text_of(p))}
    assert not found


def test_the_layer_knows_no_physics_and_no_version_of_fmi():
    files = [p for p in (SOURCES / "fmi").glob("*.[ch]") if p.name[:4] not in ("fmi2", "fmi3")]
    assert {"fmu.h", "fmu_step.c", "fmu_state.c"} <= {p.name for p in files}
    for path in files:
        text = text_of(path)
        assert not re.search(r"voltage|displacement|reference_|chain|it2_|\bforce\b", text), path.name
        assert not re.search(r"fmi[23]", text), path.name


def test_a_twelfth_stage_is_its_files_and_a_line_of_the_list(tmp_path):
    for folder in ("core", "identification", "tests"):
        shutil.copytree(SOURCES / folder, tmp_path / folder)
    core, own = tmp_path / "core", tmp_path / "tests" / "twelfth"
    for name in ("tilt.h", "tilt.c"):
        shutil.copy(own / name, core)
    listed = (core / LIST.name).read_text(encoding="utf-8")
    listed = listed.replace('#include "slew.h"\n', '#include "slew.h"\n#include "tilt.h"\n')
    listed = listed.replace("    NONE(drift,", "    AIMED(tilt, TILT, BEHIND) \\\n    NONE(drift,")
    (core / LIST.name).write_text(listed, encoding="utf-8")
    sources = [*core.glob("*.c"), tmp_path / "identification/chain_sensitivity.c", own / "main.c"]
    places = [f"-I{tmp_path / name}" for name in ("core", "identification", "tests")]
    program = tmp_path / "twelve"
    command = [*compiler(), *STRICT, *places, *map(str, sources), "-o", str(program), "-lm"]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    done = subprocess.run([program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
