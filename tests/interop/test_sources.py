"""An FMU's sources: any C99 compiler builds them, to the same bits and with FMI's functions alone."""

import shutil
import subprocess
from pathlib import Path

import fmpy
import pytest
from compilers import HEADERS, compiler, declared_functions, environment_for_cmake
from conftest import MODELS, Instance, Unpacked, moved_binary, rewrite, trajectory
from fmpy.build import build_platform_binary
from fmpy.model_description import read_build_description
from lxml import etree

pytestmark = pytest.mark.skipif(fmpy.platform != "linux64", reason="builds for Linux")


def recipe(unpacked: Unpacked) -> tuple[list[str], list[str], list[str]]:
    """Return the C files, options and libraries of buildDescription.xml that are for Linux."""
    root = etree.parse(unpacked.directory / "sources" / "buildDescription.xml").getroot()
    tuples = [c.get("platform") for c in root.iterfind("BuildConfiguration")]
    configuration = root.find("BuildConfiguration")
    assert tuples[0] is None  # the one for all platforms that have none of their own
    assert "x86_64-linux" not in tuples
    files = configuration.find("SourceFileSet")
    folder = unpacked.directory / "sources"
    sources = [str(folder / file.get("name")) for file in files.iterfind("SourceFile")]
    libraries = [f"-l{library.get('name')}" for library in configuration.iterfind("Library")]
    return sources, files.get("compilerOptions").split(), libraries


def build(unpacked: Unpacked, library: Path, *flags: str) -> Path:
    """Compile an FMU's sources into a library as it says; its compiler must have nothing to say.

    FMI's headers are those of the tool that builds: here FMPy's.
    """
    sources, options, libraries = recipe(unpacked)
    places = ["-I", str(unpacked.directory / "sources"), "-isystem", str(HEADERS)]
    command = [*compiler(), "-std=c99", *options, *flags, "-shared", "-fPIC", *places, *sources]
    command += [*libraries, "-o", str(library)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return library


def exported(library: Path) -> set[str]:
    """Return the functions that a library shows, the C runtime's own two left out."""
    lief = pytest.importorskip("lief", reason="lief is missing")
    symbols = lief.ELF.parse(str(library)).exported_symbols
    return {s.name for s in symbols if s.is_function} - {"_init", "_fini"}


STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wno-c11-extensions")


@pytest.mark.parametrize("name", ["table_1", "five_rules"])
@pytest.mark.parametrize("which", MODELS)
def test_sources_compile_without_warnings_and_compute_the_same_bits(tmp_path, packaged, name, which):
    unpacked = packaged[name][1][which]
    library = build(unpacked, tmp_path / "own.so", *STRICT)
    assert trajectory(unpacked, library) == trajectory(unpacked)


@pytest.fixture(params=["plant", "inverse", "controller"])
def fmu(request, five_rules, controller) -> Unpacked:
    """Return each of the three FMUs in turn."""
    return {**five_rules, "controller": controller}[request.param]


def test_the_sources_say_how_they_are_built_and_leave_fmis_headers_to_the_importer(fmu):
    """FMI 2.0.5, section 2.3: buildDescription.xml as in FMI 3.0, and no header of the standard."""
    folder = fmu.directory / "sources"
    assert not list(folder.glob("fmi2[FT]*.h"))
    configurations = read_build_description(fmu.directory)  # checks against FMI's schema
    there = sorted(p.name for p in folder.glob("*.c"))
    root = etree.parse(fmu.directory / "modelDescription.xml").getroot()
    assert sorted(f.get("name") for f in root.iterfind("CoSimulation/SourceFiles/File")) == there
    for configuration in configurations:
        assert configuration.modelIdentifier == fmu.identifier
        assert [sorted(s.sourceFiles) for s in configuration.sourceFileSets] == [there]
    _, options, libraries = recipe(fmu)
    assert options == ["-ffp-contract=off"]
    assert libraries == ([] if fmu.identifier == "PIController" else ["-lm", "-ldl"])


# a process with no more than the C library in it
BARE_HOST = """
#include <dlfcn.h>
#include <stdio.h>
int main(int count, char **argument)
{
    void *library = count == 2 ? dlopen(argument[1], RTLD_NOW) : NULL;
    if (!library || !dlsym(library, "fmi2DoStep"))
        return puts(dlerror()), 1;
    return 0;
}
"""


def test_a_library_from_the_sources_loads_into_a_host_without_libm(tmp_path, fmu):
    lief = pytest.importorskip("lief", reason="lief is missing")
    (tmp_path / "host.c").write_text(BARE_HOST, encoding="utf-8")
    host = tmp_path / "host"
    subprocess.run([*compiler(), str(tmp_path / "host.c"), "-o", str(host), "-ldl"], check=True)
    assert "libm.so.6" not in lief.ELF.parse(str(host)).libraries
    library = build(fmu, tmp_path / "own.so", "-O1")
    needs_libm = "libm.so.6" in lief.ELF.parse(str(library)).libraries
    assert needs_libm == (fmu.identifier != "PIController")
    done = subprocess.run([str(host), str(library)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


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
