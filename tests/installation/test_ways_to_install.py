"""The package in all the ways that pip has: a checkout, an sdist, a wheel of it, an editable checkout.

The environment is the users', with the newest pip, which isolates builds most strictly. Nothing is on
the path where it says so: no compiler, no CMake, no ninja. The tests of the users come before these,
which take the wheel out of the environment.
"""

import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import lief
import pytest

from it2hys.fmu.packaging import package
from it2hys.fmu.platforms import PLATFORMS
from it2hys.model.parameters import table_1

ROOT = Path(__file__).parents[2]
SUFFIXES = {"linux": "so", "darwin": "dylib", "win": "dll"}
BINARIES = {name: next(s for n, s in SUFFIXES.items() if n in name) for name in PLATFORMS}
#: The wheel is built for all platforms, the editable checkout of `make install`, which runs these
#: tests, likewise; what is built for this one alone takes half the time.
THIS_PLATFORM = "--config-settings=cmake.define.IT2HYS_ALL_PLATFORMS=OFF"
FMUS = ("IT2Plant", "IT2Inverse", "PIController")

pytestmark = [
    pytest.mark.installation,
    pytest.mark.skipif(sys.platform != "linux", reason="paths of a virtual environment on Linux"),
]


def files_of_python():
    """Return the files of the package as the repository has them."""
    found = (ROOT / "python" / "it2hys").rglob("*")
    return {
        p.relative_to(ROOT / "python").as_posix()
        for p in found
        if p.is_file() and not {"__pycache__", "native", "fmus"} & set(p.parts)
    }


def assert_works(environment, folder, empty_path, everywhere=False):
    """Build FMUs and run one, where there is no compiler; they are those of this installation."""
    shutil.rmtree(folder / "used", ignore_errors=True)
    environment.run("it2hys", "build", "-o", folder / "used", path=empty_path)
    signal = folder / "used" / "u.csv"
    signal.write_text("time_s,voltage_V\n0.0000,0\n0.0001,40\n0.0002,40\n", encoding="utf-8")
    plant, output = folder / "used" / "IT2Plant.fmu", folder / "used" / "y.csv"
    environment.run("it2hys", "simulate", plant, "--input", signal, "-o", output, path=empty_path)
    assert len(output.read_text(encoding="utf-8").splitlines()) == 4
    package(table_1(), folder / "ours")
    for name in ("IT2Plant.fmu", "IT2Inverse.fmu"):
        with (
            zipfile.ZipFile(folder / "used" / name) as its,
            zipfile.ZipFile(folder / "ours" / name) as ours,
        ):
            names = [
                [n for n in fmu.namelist() if everywhere or not n.startswith("binaries/")]
                for fmu in (its, ours)
            ]
            assert names[0] == names[1]
            for member in ("modelDescription.xml", "resources/parameters.ssv"):
                assert its.read(member) == ours.read(member)


def test_the_sdist_holds_what_a_build_needs_and_nothing_built(sdist):
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {"pyproject.toml", "README.md", "LICENSE", "PKG-INFO", "Makefile"} <= names
    assert {f"python/{name}" for name in files_of_python()} <= names
    sources = (p.relative_to(ROOT).as_posix() for p in (ROOT / "fmu_src").rglob("*.[ch]"))
    assert set(sources) <= names
    assert not any(name.startswith((".ci", "build", "dist", "out", ".venv")) for name in names)


def test_the_wheel_holds_what_it_needs(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        scripts = next(name for name in names if name.endswith("entry_points.txt"))
        assert b"it2hys.cli:main" in archive.read(scripts)
    assert files_of_python() <= names
    assert {f"it2hys/scenarios/{p.name}" for p in (ROOT / "scenarios").glob("*.toml")} <= names
    # the library's two C files are those of the FMUs, in native/sources
    kept = (p for p in (ROOT / "modelica").rglob("*") if p.name not in ("it2hys.c", "it2hys.h"))
    library = (p for p in kept if p.is_file())
    assert {f"it2hys/{p.relative_to(ROOT).as_posix()}" for p in library} <= names
    native = {name.removeprefix("it2hys/native/") for name in names if "/native/" in name}
    assert {"it2core.so", "LICENSE"} <= native
    for platform, suffix in BINARIES.items():
        assert {f"binaries/{platform}/{fmu}.{suffix}" for fmu in FMUS} <= native
    for folder, own in {
        "sources": {"IT2Plant.c", "IT2Inverse.c", "IT2Plant_fmi3.c", "IT2Inverse_fmi3.c"},
        "controller": {"PIController.c", "PIController_fmi3.c"},
        "embedded": set(),
    }.items():
        expected = {f"{folder}/{name}" for name in ("it2hys.c", "it2hys.h", *own)}
        assert {name for name in native if name.startswith(f"{folder}/")} == expected
    # the core is built from these anew with effects of the user's own
    assert {f"source/core/{p.name}" for p in (ROOT / "fmu_src" / "core").glob("*.[ch]")} <= native
    assert any(name.endswith("dist-info/licenses/LICENSE") for name in names)
    assert not [name for name in names if name.startswith("it2hys/fmus/") or "__pycache__" in name]


def test_no_file_of_the_wheel_is_there_twice(wheel):
    """But for the licence, which pip and the FMUs each want, empty files, and `package.order`."""
    with zipfile.ZipFile(wheel) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    places: dict[bytes, list[str]] = {}
    for name, content in contents.items():
        if content and not name.endswith(("LICENSE", "package.order")):
            places.setdefault(content, []).append(name)
    assert [names for names in places.values() if len(names) > 1] == []


def test_the_wheel_runs_on_every_linux_that_its_tag_promises(wheel, tmp_path):
    """No symbol of the GNU C library that is asked for is newer than the tag."""
    assert wheel.name.endswith("-py3-none-manylinux_2_17_x86_64.whl")
    newest = set()
    with zipfile.ZipFile(wheel) as archive:
        for name in archive.namelist():
            if name.endswith(".so"):
                (tmp_path / "library.so").write_bytes(archive.read(name))
                library = lief.parse(str(tmp_path / "library.so"))
                wanted = [v.name for s in library.symbols_version_requirement
                          for v in s.get_auxiliary_symbols()]  # fmt: skip
                newest |= {tuple(map(int, v.removeprefix("GLIBC_").split("."))) for v in wanted}
    assert newest and max(newest) <= (2, 17)


def test_twine_is_content(sdist, wheel):
    command = [sys.executable, "-m", "twine", "check", "--strict", sdist, wheel]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("PASSED") == 2


def test_the_wheel_is_installed_and_runs_without_a_compiler(user, folder, empty_path):
    assert_works(user, folder, empty_path, everywhere=True)


def test_a_checkout_is_installed(user, checkout, folder, empty_path):
    """With a compiler, if there is one."""
    user.install("--constraint", ROOT / "requirements.lock", THIS_PLATFORM, ".", cwd=checkout)
    user.pip("check")
    assert f"it2hys @ {checkout.as_uri()}" in user.pip("freeze")
    assert_works(user, folder, empty_path)


def test_an_editable_installation_follows_the_checkout(user, checkout, folder, empty_path):
    """Without a compiler; edits and new files of Python need no new installation."""
    user.install("--no-deps", THIS_PLATFORM, "--editable", ".", cwd=checkout, path=empty_path)
    assert_works(user, folder, empty_path)
    with (checkout / "python" / "it2hys" / "errors.py").open("a", encoding="utf-8") as file:
        file.write('\nEDITED = "seen"\n')
    (checkout / "python" / "it2hys" / "brand_new.py").write_text("NEW = 'too'\n", encoding="utf-8")
    code = "from it2hys import brand_new, errors; print(errors.EDITED, brand_new.NEW)"
    assert user.run("python", "-c", code).split() == ["seen", "too"]
