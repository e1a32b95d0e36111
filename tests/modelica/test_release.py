"""The library as it is handed on: `it2hys modelica PATH`, and the archive of `make modelica`."""

import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from library import LIBRARY, PLANT, model

from it2hys.cli import main
from it2hys.export.modelica import C_SOURCES, LIBRARY_VERSION
from it2hys.export.modelica_release import release_files
from it2hys.model import compiled
from it2hys.model.parameters import table_1

COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
#: A path as Windows users have them.
AWKWARD = "Eigene Dateien/Bücherei für Modelica"
LONGEST = 150  # of the 260 characters that Windows gives a path


def everything() -> set[str]:
    return {p.relative_to(LIBRARY.parent).as_posix() for p in LIBRARY.rglob("*") if p.is_file()}


def test_the_folder_is_the_library_with_a_record_template_and_the_licence(tmp_path, capsys):
    target = tmp_path / AWKWARD
    assert main(["modelica", str(target)]) == 0
    assert capsys.readouterr().out.splitlines()[0] == str(target / "IT2Hysteresis" / "package.mo")
    found = {p.relative_to(target).as_posix() for p in target.rglob("*") if p.is_file()}
    assert found == everything() | {"MyStage.mo", "LICENSE", "README.txt"}
    for name in everything():
        assert (target / name).read_bytes() == (LIBRARY.parent / name).read_bytes()
    template = (target / "MyStage.mo").read_text(encoding="utf-8")
    assert template.startswith('record MyStage "')
    assert f'uses(IT2Hysteresis(version="{LIBRARY_VERSION}"))' in template


def test_the_archive_holds_the_same_and_is_the_same_each_time(tmp_path):
    for name in ("a.zip", "b.zip"):
        assert main(["modelica", str(tmp_path / "new" / name)]) == 0
    first, second = ((tmp_path / "new" / name).read_bytes() for name in ("a.zip", "b.zip"))
    assert first == second
    with zipfile.ZipFile(tmp_path / "new" / "a.zip") as archive:
        assert {n: archive.read(n) for n in archive.namelist()} == release_files()


def test_the_archive_loads_by_itself_from_a_path_with_spaces_and_umlauts(tmp_path):
    """In a Modelica tool, with the record of its template: nothing of the checkout beside it."""
    simulation = pytest.importorskip("test_simulation", reason="rumoca is not installed")
    archive = tmp_path / "library.zip"
    assert main(["modelica", str(archive)]) == 0
    with zipfile.ZipFile(archive) as content:
        content.extractall(tmp_path / AWKWARD)
    source = model(
        f"parameter MyStage stage(initialDisplacement=3e-6); {PLANT} plant(parameters=stage);",
        "plant.voltage = 20;",
    )
    displacement = simulation.run_from(tmp_path / AWKWARD, source, "plant.displacement")
    expected, _ = compiled.chain_free_run(table_1().replace(initialDisplacement=3e-6), np.full(3, 20.0))
    assert displacement[-1] == pytest.approx(expected[-1], rel=1e-12)


def test_a_library_that_is_there_is_not_touched(tmp_path, capsys):
    (tmp_path / "IT2Hysteresis").mkdir()
    (tmp_path / "IT2Hysteresis" / "package.mo").write_text("mine")
    assert main(["modelica", str(tmp_path)]) == 2
    assert "is there already; remove it" in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["IT2Hysteresis"]
    assert (tmp_path / "IT2Hysteresis" / "package.mo").read_text() == "mine"


@pytest.mark.parametrize("target", ["file", "file/archive.zip", "file/folder"])
def test_a_path_that_cannot_be_is_said(tmp_path, capsys, target):
    (tmp_path / "file").write_text("")
    assert main(["modelica", str(tmp_path / target)]) == 2
    assert str(tmp_path / "file") in capsys.readouterr().err


def test_file_names_are_for_all_platforms():
    names = [n for n in release_files()]
    assert len({n.lower() for n in names}) == len(names), "they differ in case only"
    assert all(re.fullmatch(r"[A-Za-z0-9_./-]+", n) for n in names)
    assert max(map(len, names)) < LONGEST


def test_the_c_sources_compile_from_a_path_with_spaces_and_umlauts(tmp_path):
    if not COMPILER:
        pytest.skip("no C compiler (cc, gcc, clang) on the path")
    assert main(["modelica", str(tmp_path / AWKWARD), "--quiet"]) == 0
    sources = tmp_path / AWKWARD / "IT2Hysteresis" / C_SOURCES
    unit = tmp_path / "unit.c"
    unit.write_text('#include "IT2Hysteresis.h"\n')
    host = Path(__file__).parent / "glue"
    command = [COMPILER, "-std=c99", "-fsyntax-only", "-w", f"-I{sources}", f"-I{host}", str(unit)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
