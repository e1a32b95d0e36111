"""The binaries of FMUs with effects of the user's own, for the platforms that the package has.

They are compiled by zig as the package's own are (`it2hys.fmu.cross_compiling`). A machine without zig
makes the host's alone, by the compiler of the system, and so does a build of the package for the host
alone.
"""

from __future__ import annotations

import importlib.util
import platform
import sys
from pathlib import Path

from it2hys.fmu.cross_compiling import (
    ACTUATOR,
    CONTROLLER,
    JOINED,
    TARGETS,
    compile_fmus,
    join_slices,
    put_binary,
)
from it2hys.fmu.own_library import SOURCES, compiler, fmi_headers, run_all, zig
from it2hys.fmu.platforms import PLATFORMS
from it2hys.model.compiled import packaged_native


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
    for name in (n for n in possible if n in TARGETS):
        # zig's runs with older C libraries than the host's, as all of the package's own do
        _make(native, name, by_host=not has_zig or wanted == [host])
    if JOINED in possible and host != JOINED:
        join_slices(ACTUATOR, native / "binaries")
    for name in possible:
        for path in (packaged_native() / "binaries" / name).glob(f"{CONTROLLER[0]}.*"):
            if not (native / "binaries" / name / path.name).exists():
                put_binary(native / "binaries" / name / path.name, path.read_bytes())
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
    target, folder = TARGETS[name], native / "binaries" / name
    if all((folder / f"{fmu}{target.suffix}").is_file() for fmu in ACTUATOR):
        return
    command = [*zig(), "-target", target.zig]
    if by_host and compiler()[0] != sys.executable:
        command, target = list(compiler()), target.by_its_own_compiler()
    include = [f"-I{native.parent / 'generated'}", "-isystem", str(fmi_headers())]
    more = native / SOURCES / "platforms"
    compile_fmus(ACTUATOR, native / "sources", more, target, [*command, *include], folder, run_all)
