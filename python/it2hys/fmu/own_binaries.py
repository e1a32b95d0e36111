"""The binaries of FMUs with effects of the user's own, for the platforms that the package has.

They are compiled by zig as `fmu_src/platforms` does it. A machine without zig makes the host's alone,
by the compiler of the system, and so does a build of the package for the host alone.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from it2hys.fmu.own_library import SOURCES, compiler, fmi_headers, run_all, zig
from it2hys.fmu.platforms import PLATFORMS
from it2hys.model.compiled import packaged_native

_FMUS = ("IT2Plant", "IT2Inverse")
_CONTROLLER = "PIController"
_FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-fPIC")
_ELF = ("-lm", "-ldl", "-Wl,-z,defs")
_WINDOWS_C = ("convert", "heap", "locale", "math", "private", "runtime", "stdio", "string", "utility")
_WINDOWS = (
    "-nostdlib", "-rtlib=compiler-rt", "-Wl,-Brepro", "-lkernel32",
    *(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in _WINDOWS_C),
)  # fmt: skip
_MACOS = ("-Wl,-install_name,@rpath/{fmu}.dylib", "-rtlib=none")


@dataclass(frozen=True)
class _Target:
    """How zig compiles for a platform: as fmu_src/platforms/CMakeLists.txt says."""

    zig: str
    suffix: str
    link: tuple[str, ...]
    flags: tuple[str, ...] = ()
    more: str | None = None


_WINDOWS_MORE = "platforms/windows_runtime.c"
_TARGETS = {
    "linux64": _Target("x86_64-linux-gnu.2.17", ".so", (*_ELF, "-rtlib=none")),
    "aarch64-linux": _Target("aarch64-linux-gnu.2.17", ".so", (*_ELF, "-rtlib=none")),
    "win64": _Target("x86_64-windows-gnu", ".dll", _WINDOWS, (), _WINDOWS_MORE),
    "win32": _Target("x86-windows-gnu", ".dll", _WINDOWS, ("-msse2", "-mfpmath=sse"), _WINDOWS_MORE),
    "aarch64-windows": _Target("aarch64-windows-gnu", ".dll", _WINDOWS, (), _WINDOWS_MORE),
    "x86_64-darwin": _Target("x86_64-macos.11.0", ".dylib", _MACOS),
    "aarch64-darwin": _Target("aarch64-macos.11.0", ".dylib", _MACOS),
}
#: FMI 2.0 has one folder for both processors of macOS.
_JOINED, _SLICES = "darwin64", ("x86_64-darwin", "aarch64-darwin")


def make_binaries(native: Path) -> list[str]:
    """Compile what is not there yet of the FMUs' binaries; return the platforms that are left out.

    Parameters
    ----------
    native : path
        Folder of the core that was built with the effects.
    """
    wanted = [p.name for p in (packaged_native() / "binaries").iterdir() if p.name in PLATFORMS]
    host, has_zig = _host(), importlib.util.find_spec("ziglang") is not None
    possible = [p for p in wanted if has_zig or p == host]
    for name in (n for n in possible if n in _TARGETS):
        # zig's runs with older C libraries than the host's, as all of the package's own do
        _make(native, name, by_host=not has_zig or wanted == [host])
    if _JOINED in possible and host != _JOINED:
        _join(native)
    for name in possible:
        for path in (packaged_native() / "binaries" / name).glob(f"{_CONTROLLER}.*"):
            if not (native / "binaries" / name / path.name).exists():
                shutil.copy(path, native / "binaries" / name)
    return [p for p in wanted if p not in possible]


def _host() -> str:
    """Return the folder of this machine's platform, as a build for the host alone names it."""
    arm = platform.machine().lower() in ("arm64", "aarch64")
    if sys.platform == "win32":
        return "aarch64-windows" if arm else "win64"
    if sys.platform == "darwin":
        return "aarch64-darwin" if arm else "x86_64-darwin"
    return "aarch64-linux" if arm else "linux64"


def _make(native: Path, name: str, by_host: bool) -> None:
    """Compile each file once, for both FMUs; binaries appear whole or not at all."""
    target, folder = _TARGETS[name], native / "binaries" / name
    if all((folder / f"{fmu}{target.suffix}").is_file() for fmu in _FMUS):
        return
    work = native.parent / f"{name}-{os.getpid()}"
    work.mkdir()
    by_host = by_host and compiler()[0] != sys.executable
    command = list(compiler()) if by_host else [*zig(), "-target", target.zig]
    sources = native / "sources"
    include = [f"-I{native.parent / 'generated'}", f"-I{sources}", "-isystem", str(fmi_headers())]
    files = [sources / "it2hys.c"]
    files += [sources / f"{fmu}{version}.c" for fmu in _FMUS for version in ("", "_fmi3")]
    files += [native / SOURCES / target.more] if target.more and not by_host else []
    try:
        run_all(
            [*command, *_FLAGS, *target.flags, *include, "-c", str(f), "-o", str(work / f"{f.stem}.o")]
            for f in files
        )
        run_all(_link(command, work, fmu, target, by_host, files) for fmu in _FMUS)
        folder.mkdir(parents=True, exist_ok=True)
        for fmu in _FMUS:
            (work / f"{fmu}{target.suffix}").replace(folder / f"{fmu}{target.suffix}")
    finally:
        shutil.rmtree(work, ignore_errors=True)


def _link(
    command: Sequence[str], work: Path, fmu: str, target: _Target, by_host: bool, files: Sequence[Path]
) -> list[str]:
    own = [f for f in files if f.stem.removesuffix("_fmi3") in (fmu, "it2hys", "windows_runtime")]
    link = [text.format(fmu=fmu) for text in target.link if not (by_host and text == "-rtlib=none")]
    output = str(work / f"{fmu}{target.suffix}")
    return [
        *command,
        "-shared",
        "-O2",
        "-s",
        "-o",
        output,
        *(str(work / f"{f.stem}.o") for f in own),
        *link,
    ]


def _join(native: Path) -> None:
    """Join the binaries for both processors of macOS, as the build does."""
    path = native / SOURCES / "platforms" / "universal_binary.py"
    specification = importlib.util.spec_from_file_location("universal_binary", path)
    assert specification and specification.loader
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    for fmu in _FMUS:
        output = native / "binaries" / _JOINED / f"{fmu}.dylib"
        output.parent.mkdir(parents=True, exist_ok=True)
        slices = [(native / "binaries" / name / f"{fmu}.dylib").read_bytes() for name in _SLICES]
        output.write_bytes(module.universal_binary(slices))
