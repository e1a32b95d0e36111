"""The FMUs' binaries for every platform that people use, compiled by zig from one machine.

zig brings the headers and libraries of all of them. What an FMU's `sources/` has is what is compiled:
two files for each library, and one for each version of FMI; starting zig for each of the fifty files of
`fmu_src` took longer than compiling them.

Only the standard library is used, because the C build runs this in an environment without packages:
``python -m it2hys.fmu.cross_compiling PLATFORM GENERATED BINARIES HEADERS ZIG`` compiles the package's
own FMUs. Those with effects of the user's own are compiled by `it2hys.fmu.own_binaries`.
"""

import os
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

ACTUATOR, CONTROLLER = ("IT2Plant", "IT2Inverse"), ("PIController",)
#: Those of the C that the package brings; an effect of the user's own may need to do without.
WARNINGS = ("-Wall", "-Wextra", "-Werror", "-Wno-c11-extensions")
_FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-fPIC")
# zig would build its library of arithmetic for each target, too, which takes seconds: 64-bit processors
# lack nothing that is used here, and the linker fails if that changes.
_NO_RUNTIME = "-rtlib=none"
# the C library of the oldest Linux in use, fifteen years old
_GLIBC = "gnu.2.17"
_ELF = ("-lm", "-ldl", "-Wl,-z,defs", _NO_RUNTIME)
# zig builds the MinGW library from its sources, which takes a minute for each Windows: what little of
# it is needed is in windows_runtime.c, the rest comes from the C library that is part of Windows.
# -Brepro: the same sources give the same bytes, where the time of the build would be in them.
_WINDOWS_C = ("convert", "heap", "locale", "math", "private", "runtime", "stdio", "string", "utility")
_WINDOWS = (
    "-nostdlib", "-rtlib=compiler-rt", "-Wl,-Brepro", "-lkernel32",
    *(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in _WINDOWS_C),
)  # fmt: skip
_MACOS = ("-Wl,-install_name,@rpath/{fmu}.dylib", _NO_RUNTIME)
_MACH_O_64, _UNIVERSAL = 0xFEEDFACF, 0xCAFEBABE
#: 2^14 bytes, a page on Apple's processors.
_ALIGNMENT = 14


@dataclass(frozen=True)
class Target:
    """How the FMUs are compiled for a platform, and what zig calls it.

    `more` are C files of fmu_src/platforms that each FMU needs there.
    """

    zig: str
    suffix: str
    link: tuple[str, ...]
    flags: tuple[str, ...] = ()
    more: tuple[str, ...] = ()

    def by_its_own_compiler(self) -> "Target":
        """Return how the platform's own compiler does it, which has a runtime."""
        return replace(self, link=tuple(t for t in self.link if t != _NO_RUNTIME), more=())


_MORE = ("windows_runtime.c",)
#: By the platform's folder (`it2hys.fmu.platforms`).
TARGETS = {
    "linux64": Target(f"x86_64-linux-{_GLIBC}", ".so", _ELF),
    "aarch64-linux": Target(f"aarch64-linux-{_GLIBC}", ".so", _ELF),
    "win64": Target("x86_64-windows-gnu", ".dll", _WINDOWS, (), _MORE),
    # SSE2 rounds every operation to double, as everywhere else; the x87 does not
    "win32": Target("x86-windows-gnu", ".dll", _WINDOWS, ("-msse2", "-mfpmath=sse"), _MORE),
    "aarch64-windows": Target("aarch64-windows-gnu", ".dll", _WINDOWS, (), _MORE),
    "x86_64-darwin": Target("x86_64-macos.11.0", ".dylib", _MACOS),
    "aarch64-darwin": Target("aarch64-macos.11.0", ".dylib", _MACOS),
}
#: FMI 2.0 has one folder for both processors of macOS.
JOINED, _SLICES = "darwin64", ("x86_64-darwin", "aarch64-darwin")


def run_all(commands: Iterable[Sequence[str]], environment: Mapping[str, str] | None = None) -> None:
    """Run compilers side by side; raises CalledProcessError with what the first that fails says."""
    commands, most = list(commands), os.cpu_count() or 1
    while commands:
        now, commands = commands[:most], commands[most:]
        running = [
            subprocess.Popen(
                c, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
            )
            for c in now
        ]
        said = [process.communicate()[0] for process in running]
        for process, text in zip(running, said, strict=True):
            if process.returncode:
                raise subprocess.CalledProcessError(process.returncode, process.args, text)


def compile_fmus(
    fmus: Sequence[str],
    sources: Path,
    more: Path,
    target: Target,
    compiler: Sequence[str],
    folder: Path,
    run: Callable[[Iterable[Sequence[str]]], None] = run_all,
) -> None:
    """Compile FMUs that share a folder of C files, each file once; binaries appear whole or not at all.

    Parameters
    ----------
    fmus : sequence of str
        Model identifiers.
    sources : Path
        Folder of their C files.
    more : Path
        That of those that some platforms need besides.
    target : Target
    compiler : sequence of str
        Command of the compiler, with options for it.
    folder : Path
        Where the binaries go, three folders below one on the same disk to work in.
    run : callable
        What runs commands.
    """
    faces = [sources / f"{fmu}{version}.c" for fmu in fmus for version in ("", "_fmi3")]
    files = [sources / "it2hys.c", *faces, *(more / name for name in target.more)]
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parents[2]) as name:
        work = Path(name)
        run(
            [*compiler, *_FLAGS, *target.flags, "-c", str(f), "-o", str(work / f"{f.stem}.o")]
            for f in files
        )
        # linked apart: on Windows an import library appears beside the binary. Without -O2 zig would
        # first build a runtime for its sanitizers.
        run(
            [
                *compiler, "-shared", "-O2", "-s", "-o", str(work / f"{fmu}{target.suffix}"),
                *(str(work / f"{f.stem}.o") for f in files
                  if f not in faces or f.stem.removesuffix("_fmi3") == fmu),
                *(text.format(fmu=fmu) for text in target.link),
            ]
            for fmu in fmus
        )  # fmt: skip
        for fmu in fmus:
            (work / f"{fmu}{target.suffix}").replace(folder / f"{fmu}{target.suffix}")


def join_slices(fmus: Sequence[str], binaries: Path) -> None:
    """Join the binaries for both processors of macOS, as Apple's lipo does."""
    for fmu in fmus:
        name = f"{fmu}.dylib"
        slices = [(binaries / platform / name).read_bytes() for platform in _SLICES]
        put_binary(binaries / JOINED / name, universal_binary(slices))


def put_binary(path: Path, content: bytes) -> None:
    """Write a binary that appears whole: another process may read what was there before."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as work:
        whole = Path(work) / path.name
        whole.write_bytes(content)
        whole.chmod(0o755)
        whole.replace(path)


def universal_binary(slices: Sequence[bytes]) -> bytes:
    """Return Mach-O binaries as one: a big-endian table, then the slices on page boundaries."""
    page = 1 << _ALIGNMENT
    table = struct.pack(">II", _UNIVERSAL, len(slices))
    body = b""
    for content in slices:
        magic, processor, subtype = struct.unpack_from("<III", content)
        if magic != _MACH_O_64:
            raise ValueError("a slice is no 64-bit Mach-O binary")
        offset = page + len(body)
        table += struct.pack(">IIIII", processor, subtype, offset, len(content), _ALIGNMENT)
        body += content + bytes(-len(content) % page)
    return table.ljust(page, b"\0") + body


def main(arguments: Sequence[str]) -> None:
    """Compile the package's FMUs for a platform; the joined one is made of what is there."""
    platform, generated, binaries, headers, zig = arguments
    if platform == JOINED:
        join_slices((*ACTUATOR, *CONTROLLER), Path(binaries))
        return
    target = TARGETS[platform]
    compiler = [zig, "cc", "-target", target.zig, *WARNINGS, f"-I{generated}", "-isystem", headers]
    more = Path(__file__).parents[3] / "fmu_src" / "platforms"
    for fmus, folder in ((ACTUATOR, "sources"), (CONTROLLER, "controller")):
        sources, output = Path(generated, folder), Path(binaries, platform)
        compile_fmus(fmus, sources, more, target, compiler, output)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except subprocess.CalledProcessError as error:
        sys.exit(error.output)
