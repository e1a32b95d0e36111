"""The binaries of all platforms: what they are, what they show, what they need, what they compute.

Linux runs here, Linux on ARM under qemu and Windows under wine; of the others the formats are read.
"""

import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from compilers import HEADERS, declared_functions, declared_functions_of_fmi3
from conftest import TS, Master, Unpacked

from it2hys.fmu.cross_compiling import join_slices
from it2hys.stand.excitations import identification

lief = pytest.importorskip("lief", reason="lief is missing")

# a binary serves FMUs of both versions
SHOWN = declared_functions() | declared_functions_of_fmi3()
BINARIES = {
    "linux64": "{}.so",
    "aarch64-linux": "{}.so",
    "win64": "{}.dll",
    "win32": "{}.dll",
    "aarch64-windows": "{}.dll",
    "darwin64": "{}.dylib",
    "aarch64-darwin": "{}.dylib",
}


@pytest.fixture(params=["plant", "inverse", "controller", "plant with an own effect"])
def fmu(request, models, controller) -> Unpacked:
    """Return each of the three FMUs in turn, and one with an effect of the user's own."""
    if request.param == "plant with an own effect":
        return request.getfixturevalue("mounted")[1]["plant"]
    return {**models, "controller": controller}[request.param]


@pytest.fixture(params=["table_1", "five_rules", "mounted"])
def plant(request, packaged) -> Unpacked:
    """Return plants: a set compiled in, one read from resources, one with an own effect."""
    if request.param == "mounted":
        return request.getfixturevalue("mounted")[1]["plant"]
    return packaged[request.param][1]["plant"]


def binary(unpacked: Unpacked, platform: str) -> Path:
    path = unpacked.directory / "binaries" / platform / BINARIES[platform].format(unpacked.identifier)
    if not path.is_file():
        pytest.skip(f"no binary for {platform}: this build was for the host alone")
    return path


def names(symbols: object) -> set[str]:
    return {symbol.name for symbol in symbols}


# --- Linux -------------------------------------------------------------------------------------


PROCESSORS = {"linux64": lief.ELF.ARCH.X86_64, "aarch64-linux": lief.ELF.ARCH.AARCH64}


@pytest.mark.parametrize("platform", PROCESSORS)
def test_the_linux_binary_runs_on_every_glibc_from_2_17_on(fmu, platform):
    elf = lief.ELF.parse(str(binary(fmu, platform)))
    assert elf.header.machine_type == PROCESSORS[platform]
    if not (fmu.directory / "binaries" / "win64").is_dir():
        pytest.skip("this build was for the host alone, with its compiler and C library")
    assert set(elf.libraries) <= {"libc.so.6", "libm.so.6", "libdl.so.2"}
    needed = [v.name for r in elf.symbols_version_requirement for v in r.get_auxiliary_symbols()]
    versions = {tuple(map(int, n.removeprefix("GLIBC_").split("."))) for n in needed}
    assert needed
    assert max(versions) <= (2, 17)


@pytest.mark.parametrize("platform", PROCESSORS)
def test_the_linux_binary_shows_the_functions_of_fmi_and_nothing_else(fmu, platform):
    elf = lief.ELF.parse(str(binary(fmu, platform)))
    assert names(elf.exported_symbols) == SHOWN


# --- Windows -----------------------------------------------------------------------------------

MACHINES = {
    "win64": lief.PE.Header.MACHINE_TYPES.AMD64,
    "win32": lief.PE.Header.MACHINE_TYPES.I386,
    "aarch64-windows": lief.PE.Header.MACHINE_TYPES.ARM64,
}


@pytest.mark.parametrize("platform", MACHINES)
def test_a_windows_binary_needs_nothing_that_windows_lacks(fmu, platform):
    pe = lief.PE.parse(str(binary(fmu, platform)))
    assert pe.header.machine == MACHINES[platform]
    libraries = {i.name.lower() for i in pe.imports}
    assert libraries
    assert all(n == "kernel32.dll" or n.startswith("api-ms-win-crt-") for n in libraries)
    assert names(pe.get_export().entries) == SHOWN
    assert pe.header.characteristics & int(lief.PE.Header.CHARACTERISTICS.DLL)


@pytest.mark.parametrize("platform", MACHINES)
def test_a_windows_binary_bears_no_time_of_its_build(fmu, platform):
    """Where the linker's time would be there is a hash of the content, which a directory says."""
    pe = lief.PE.parse(str(binary(fmu, platform)))
    assert lief.PE.Debug.TYPES.REPRO in [entry.type for entry in pe.debug]
    stamps = {pe.header.time_date_stamps, *(entry.timestamp for entry in pe.debug)}
    assert len(stamps) == 1
    assert pe.get_export().timestamp == 0


# --- macOS -------------------------------------------------------------------------------------


def test_the_macos_binary_holds_both_processors(fmu):
    universal = lief.MachO.parse(str(binary(fmu, "darwin64")))
    cpus = lief.MachO.Header.CPU_TYPE
    assert [m.header.cpu_type for m in universal] == [cpus.X86_64, cpus.ARM64]
    for slice_ in universal:
        assert slice_.header.file_type == lief.MachO.Header.FILE_TYPE.DYLIB
        own, *libraries = [library.name for library in slice_.libraries]
        assert own == f"@rpath/{fmu.identifier}.dylib"
        assert libraries == ["/usr/lib/libSystem.B.dylib"]
        shown = {n for n in names(slice_.exported_symbols) if n.startswith("_fmi")}
        assert shown == {f"_{n}" for n in SHOWN}
        # the linker's own, in every library
        assert names(slice_.exported_symbols) - shown <= {"__mh_dylib_header", "___dso_handle"}
    assert universal.at(1).has_code_signature  # Apple's processors run nothing without


def test_the_macos_binary_for_arm_alone_is_the_one_in_the_universal(fmu):
    """Tools on Apple's processors look for the tuple or for FMI 2.0's one name, and find the same."""
    alone = binary(fmu, "aarch64-darwin").read_bytes()
    assert binary(fmu, "darwin64").read_bytes().count(alone) == 1


def test_the_slices_of_the_macos_binary_lie_as_its_table_says(fmu):
    """Apple's loader wants them on page boundaries, in order and apart."""
    path = binary(fmu, "darwin64")
    content = path.read_bytes()
    word = lambda place: int.from_bytes(content[place : place + 4], "big")  # noqa: E731
    assert word(0) == 0xCAFEBABE
    slices = [tuple(word(8 + 20 * i + 4 * j) for j in range(5)) for i in range(word(4))]
    for _, _, offset, size, alignment in slices:
        assert offset % (1 << alignment) == 0
        assert content[offset : offset + 4] == b"\xcf\xfa\xed\xfe"
        assert offset + size <= len(content)
    assert all(a[2] + a[3] <= b[2] for a, b in pairwise(slices))


def test_a_macos_binary_is_whole_at_any_moment(fmu, tmp_path):
    """Two processes that package the same effects join its slices where the other one reads."""
    for platform in ("x86_64-darwin", "aarch64-darwin"):
        (tmp_path / platform).mkdir()
        shutil.copy(binary(fmu, "aarch64-darwin"), tmp_path / platform)
    join_slices([fmu.identifier], tmp_path)
    joined = tmp_path / "darwin64" / f"{fmu.identifier}.dylib"
    whole = joined.stat().st_size
    with ThreadPoolExecutor() as pool:
        joining = [pool.submit(join_slices, [fmu.identifier], tmp_path) for _ in range(200)]
        sizes = {joined.stat().st_size for _ in iter(lambda: all(j.done() for j in joining), True)}
    assert sizes <= {whole}
    assert [path.name for path in joined.parent.iterdir()] == [joined.name]


# --- the same bits everywhere ------------------------------------------------------------------

HOST = Path(__file__).parent / "hosts" / "run_plant.c"
TARGETS = {"win64": "x86_64-windows-gnu", "win32": "x86-windows-gnu"}
# Programs that run binaries of a platform, with what each wants in its environment: recent ones are
# 64-bit throughout and run both kinds, older ones need a 32-bit loader with a prefix of that kind.
WINES = {
    "win64": [("wine64", {}), ("wine", {}), ("/usr/lib/wine/wine64", {})],
    "win32": [
        ("wine", {}),
        ("wine", {"WINEARCH": "win32"}),
        ("/usr/lib/wine/wine", {"WINEARCH": "win32"}),
    ],
}
QEMUS = ("qemu-aarch64", "qemu-aarch64-static")
# where Debian's libc6-arm64-cross is, or what else QEMU_LD_PREFIX names
ARM_LIBRARIES = Path(os.environ.get("QEMU_LD_PREFIX", "/usr/aarch64-linux-gnu"))


def zig(directory: Path, *arguments: object) -> None:
    """Run zig's C compiler, with a cache in a directory unless there is one."""
    environment = {"ZIG_GLOBAL_CACHE_DIR": str(directory / "zig"), **os.environ}
    subprocess.run([sys.executable, "-m", "ziglang", "cc", *arguments], check=True, env=environment)


def build_for_windows(target: str, directory: Path) -> Path:
    """Return the host program for Windows, compiled by zig."""
    runtime = Path(__file__).parents[2] / "fmu_src" / "platforms" / "windows_runtime.c"
    objects = [directory / f"{source.stem}.o" for source in (HOST, runtime)]
    for source, place in zip((HOST, runtime), objects, strict=True):
        zig(directory, "-target", target, "-O1", "-I", HEADERS, "-c", source, "-o", place)
    parts = ("convert", "heap", "runtime", "stdio", "string")
    libraries = ["-lkernel32", *(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in parts)]
    flags = ["-nostdlib", "-rtlib=compiler-rt", "-Wl,--subsystem,console", "-Wl,-e,mainCRTStartup"]
    host = directory / "run_plant.exe"
    zig(directory, "-target", target, "-O1", *flags, *objects, *libraries, "-o", host)
    return host


def run_under(program: str, more: dict, host: Path, arguments: list, text: str) -> tuple[int, str]:
    """Run the host program; return its exit code and what it prints."""
    done = subprocess.run(
        [program, host, *map(str, arguments)],
        input=text,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, **more},
        timeout=300,
        check=False,
    )
    return done.returncode, done.stdout


def run_under_wine(wine: tuple[str, dict], host: Path, arguments: list, text: str) -> tuple[int, str]:
    """Run the host program for Windows in a prefix of its own."""
    program, more = wine
    prefix = host.parent / "-".join(["prefix", Path(program).name, *more.values()])
    environment = {"WINEPREFIX": str(prefix), "WINEDEBUG": "-all", **more}
    return run_under(program, environment, host, arguments, text)


@pytest.fixture(scope="module", params=TARGETS)
def windows(request, tmp_path_factory):
    """Return a Windows platform and a function that runs its host program under wine."""
    pytest.importorskip("ziglang", reason="ziglang is missing")
    found = [w for w in WINES[request.param] if shutil.which(w[0])]
    if not found:
        pytest.skip(f"no wine for {request.param} is installed")
    host = build_for_windows(TARGETS[request.param], tmp_path_factory.mktemp(request.param))
    for wine in found:
        if "the library cannot be loaded" in run_under_wine(wine, host, [], "")[1]:  # it has none
            return request.param, partial(run_under_wine, wine, host)
    pytest.skip(f"the wine that is installed does not run binaries for {request.param}")


@pytest.fixture(scope="module")
def arm_linux(tmp_path_factory):
    """Return a function that runs the host program for Linux on ARM under qemu."""
    pytest.importorskip("ziglang", reason="ziglang is missing")
    found = next(filter(None, map(shutil.which, QEMUS)), None)
    if not found or not (ARM_LIBRARIES / "lib" / "ld-linux-aarch64.so.1").exists():
        pytest.skip("no qemu-aarch64 with a C library for ARM (Debian: qemu-user, libc6-arm64-cross)")
    directory = tmp_path_factory.mktemp("arm")
    host = directory / "run_plant"
    target = ("-target", "aarch64-linux-gnu.2.17")
    zig(directory, *target, "-O1", "-rtlib=none", "-I", HEADERS, HOST, "-ldl", "-o", host)
    return partial(run_under, found, {"QEMU_LD_PREFIX": str(ARM_LIBRARIES)}, host)


def windows_path(path: Path) -> str:
    """Return a path as wine's drive Z names it."""
    return "Z:" + str(path).replace("/", "\\")


def check_bits(run, plant: Unpacked, library: object, resources: str) -> None:
    """Compare a run of a foreign binary with one of this platform's, bit for bit."""
    voltage = identification(np.arange(4000) * TS)
    arguments = [
        library,
        plant.description.guid,
        resources,
        plant.variables["voltage"].valueReference,
        plant.variables["displacement"].valueReference,
        repr(TS),
    ]
    code, out = run(arguments, "".join(f"{float(v).hex()}\n" for v in voltage))
    assert code == 0, out
    printed = [line for line in out.splitlines() if line.startswith(("0x", "-0x"))]
    with Master(plant) as master:
        expected = master.run(voltage)
    assert [float.fromhex(line) for line in printed] == expected.tolist()


def test_under_wine_the_windows_binary_gives_the_bits_of_the_linux_one(plant, windows):
    """Under (22); and with five rules, whose set the binary reads from the resources."""
    platform, run = windows
    library = windows_path(binary(plant, platform))
    check_bits(run, plant, library, f"file:///Z:{plant.directory}/resources")


def test_under_qemu_the_binary_for_arm_gives_the_bits_of_the_one_for_x86(plant, arm_linux):
    """Under (22): no product is fused with a sum, which ARM's processors could do."""
    library = binary(plant, "aarch64-linux")
    check_bits(arm_linux, plant, library, (plant.directory / "resources").as_uri())
