"""An FMU's sources: any C99 compiler builds them, to the same bits and with FMI's functions alone."""

import shutil
import subprocess
from pathlib import Path

import fmpy
import pytest
from compilers import compiler, declared_functions, environment_for_cmake
from conftest import MODELS, Instance, Unpacked, moved_binary, rewrite, trajectory
from fmpy.build import build_platform_binary

pytestmark = pytest.mark.skipif(fmpy.platform != "linux64", reason="builds for Linux")


def build(unpacked: Unpacked, library: Path, *flags: str) -> Path:
    """Compile all C files of an FMU's sources into a library; its compiler must have nothing to say."""
    sources = sorted(str(p) for p in (unpacked.directory / "sources").glob("*.c"))
    command = [*compiler(), "-std=c99", *flags, "-shared", "-fPIC", *sources, "-lm", "-o", str(library)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return library


def exported(library: Path) -> set[str]:
    """Return the functions that a library shows, the C runtime's own two left out."""
    lief = pytest.importorskip("lief", reason="lief is missing")
    symbols = lief.ELF.parse(str(library)).exported_symbols
    return {s.name for s in symbols if s.is_function} - {"_init", "_fini"}


@pytest.mark.parametrize("name", ["table_1", "five_rules"])
@pytest.mark.parametrize("which", MODELS)
def test_sources_compile_without_warnings_and_compute_the_same_bits(tmp_path, packaged, name, which):
    unpacked = packaged[name][1][which]
    flags = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wno-c11-extensions"]
    library = build(unpacked, tmp_path / "own.so", *flags)
    assert trajectory(unpacked, library) == trajectory(unpacked)


def test_a_binary_from_the_sources_needs_no_resources(tmp_path, five_rules):
    """The set is compiled in: an embedded host may have no file system."""
    unpacked = five_rules["plant"]
    library = build(unpacked, tmp_path / "own.so", "-O1")
    with Instance(unpacked, resources=None, library=library) as instance:
        assert instance.made, instance.messages
    with Instance(unpacked, resources=None, library=moved_binary(unpacked, tmp_path)) as instance:
        assert not instance.made  # whereas the shared binary has nowhere to read this set


def compile_by_fmpy(unpacked: Unpacked, directory: Path, monkeypatch: pytest.MonkeyPatch) -> Unpacked:
    """Return a copy whose binary FMPy has built from the sources."""
    for name, value in environment_for_cmake().items():
        monkeypatch.setenv(name, value)
    if shutil.which("cmake") is None or shutil.which("ninja") is None:
        pytest.skip("cmake or ninja is missing")
    copy = rewrite(unpacked, directory / "copy")
    shutil.rmtree(copy.directory / "binaries")
    (directory / "build").mkdir()
    build_platform_binary(copy.directory, build_dir=directory / "build")
    assert copy.binary.is_file()
    return copy


@pytest.mark.parametrize("which", MODELS)
def test_fmpy_compiles_the_sources_and_they_compute_the_same_bits(
    tmp_path, five_rules, which, monkeypatch
):
    """Without a flag for it from FMPy, the binary shows the functions of FMI and nothing else."""
    copy = compile_by_fmpy(five_rules[which], tmp_path, monkeypatch)
    assert trajectory(copy) == trajectory(five_rules[which])
    assert exported(copy.binary) == declared_functions()


def test_fmpy_compiles_the_controller(tmp_path, controller, monkeypatch):
    copy = compile_by_fmpy(controller, tmp_path, monkeypatch)
    assert exported(copy.binary) == declared_functions()
    read = []
    for unpacked in (controller, copy):
        with Instance(unpacked) as instance:
            instance.initialize({"integralGain": 1e9, "reference": 1e-6})
            assert instance.step(0.0, 0.01) == 0
            read.append(instance.get("voltage"))
    assert read[0] == read[1] > 0
