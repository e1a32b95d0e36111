"""The C core with effects of the user's own: built from a copy of the package's sources, and kept.

Everything that calls compiled code goes on as without them: `native_directory` names the folder that is
built here. It is made once for the same effects, sources and compiler.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from it2hys.errors import InputError
from it2hys.fmu import cross_compiling
from it2hys.fmu.amalgamation import write_folders
from it2hys.fmu.codegen import hash_header, table_header, write_headers
from it2hys.model.compiled import library_name, packaged_native
from it2hys.model.own_effect import OwnEffect
from it2hys.model.own_loading import load_effect
from it2hys.model.parameters import ParameterSet
from it2hys.model.stages import own_effects, set_own_effects
from it2hys.model.variables import load_table

#: Chains that are kept in the cache, those used last; one of the last day may be in use, and stays.
KEPT, DAY = 40, 86_400.0
#: Folder of the C sources in what the package brings.
SOURCES = "source"
#: Beside the core, what the library for Python is made of, and how; as in fmu_src/CMakeLists.txt.
_LIBRARY = {
    "python/it2core.c": "-O2",
    "python/stepper.c": "-O2",
    "python/course_summary.c": "-O2 -funroll-loops",
    "core/it2_free_run.c": "-O2",
    "identification/chain_sensitivity.c": "-O3",
}
_FLAGS = (
    "-std=c99",
    "-ffp-contract=off",
    "-fvisibility=hidden",
    "-fPIC",
    "-Wall",
    "-Wextra",
    "-Werror",
)


def use_effects(paths: Iterable[str | Path]) -> tuple[OwnEffect, ...]:
    """Have the chain with effects of one's own from now on, in place of those that it has.

    Parameters
    ----------
    paths : iterable of path
        Python files (`it2hys.model.own_effect`), which are run; none for the chain as it comes.

    Raises
    ------
    InputError
        With file and line, if one cannot be a stage or its name is taken; if there is no C compiler.
    """
    effects = tuple(load_effect(path) for path in paths)
    if [e.digest for e in effects] == [e.digest for e in own_effects().values()]:
        return tuple(own_effects().values())
    _put(effects)
    return effects


def _put(effects: Sequence[OwnEffect]) -> None:
    set_own_effects(effects, None)  # the table and the list are what C is generated from
    try:
        native = _built(effects) if effects else None
    except BaseException:
        set_own_effects((), None)
        raise
    set_own_effects(effects, native)


@contextmanager
def only_used(parameters: ParameterSet) -> Iterator[ParameterSet]:
    """Have no effects of one's own in the chain but those that a set has, for a while.

    Yields the set without the parameters of the others.
    """
    before = tuple(own_effects().values())
    used = [e for e in before if e.is_on(parameters)]
    if len(used) == len(before):
        yield parameters
        return
    gone = {f"{e.name}.{p.name}" for e in before if e not in used for p in e.parameters}
    _put(used)
    try:
        yield ParameterSet({n: v for n, v in parameters.items() if n not in gone}, parameters.name)
    finally:
        _put(before)


@cache
def compiler() -> tuple[str, ...]:
    """Return the command of a C compiler: the one of the system, or zig's.

    Raises
    ------
    InputError
        If there is none.
    """
    for name in (os.environ.get("CC"), "cc", "gcc", "clang"):
        if name and sys.platform != "win32" and shutil.which(name):
            return (name,)
    return zig()


def zig() -> tuple[str, ...]:
    """Return the command of zig's C compiler."""
    if importlib.util.find_spec("ziglang") is None:
        raise InputError(
            "an effect of your own needs a C compiler, and none was found: install one, or "
            "`pip install ziglang`, which also makes the FMUs' binaries for the other platforms"
        )
    return sys.executable, "-m", "ziglang", "cc"


def cache_directory() -> Path:
    """Return where is kept what was built: `IT2HYS_CACHE`, or the user's folder for such things."""
    if own := os.environ.get("IT2HYS_CACHE"):
        return Path(own)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home()) / "it2hys" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "it2hys"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "it2hys"


def _built(effects: Sequence[OwnEffect]) -> Path:
    """Return the folder of the core with these effects; it appears whole or not at all."""
    from it2hys.fmu.own_stage import own_stage  # it needs CasADi

    sources = packaged_native() / SOURCES
    if not sources.is_dir():
        raise InputError(f"{sources}: the C sources are not there; build the package again")
    generated = {name: text for effect in effects for name, text in own_stage(effect).items()}
    place = cache_directory() / "effects" / _key(sources, generated, effects)
    if (place / "native" / library_name()).is_file():
        with suppress(OSError):  # somebody else's
            os.utime(place)
        return place / "native"
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        work = Path(tempfile.mkdtemp(prefix="new-", dir=place.parent))
    except OSError as error:
        raise InputError(
            f"{place.parent}: {error.strerror}; set IT2HYS_CACHE to another folder for compiled effects"
        ) from None
    try:
        _build(work, sources, generated, effects)
        try:
            work.rename(place)
        except OSError:  # another process was quicker
            if not (place / "native" / library_name()).is_file():
                raise
    finally:
        shutil.rmtree(work, ignore_errors=True)
    _forget_unused(place.parent)
    return place / "native"


def _forget_unused(folder: Path) -> None:
    """Remove what was built, or left half built, and not used for long; the last ones stay."""
    used = {}
    for place in folder.iterdir():
        with suppress(OSError):  # another process was quicker
            used[place] = place.stat().st_mtime
    for place in sorted(used, key=used.__getitem__, reverse=True)[KEPT:]:
        if time.time() - used[place] > DAY:
            gone = folder / f"old-{place.name}"
            with suppress(OSError):  # loaded by another process, where that forbids it
                place.rename(gone)
                shutil.rmtree(gone, ignore_errors=True)


def _key(sources: Path, generated: Mapping[str, str], effects: Sequence[OwnEffect]) -> str:
    """Return a name for what comes out."""
    hashed = hashlib.sha256(repr((compiler(), sys.platform, *generated.items())).encode())
    hashed.update((hash_header() + table_header(load_table())).encode())
    hashed.update(repr([(e.name, e.side, e.memory) for e in effects]).encode())
    for path in sorted(p for p in sources.rglob("*") if p.is_file()):
        hashed.update(path.relative_to(sources).as_posix().encode() + path.read_bytes())
    return hashed.hexdigest()[:24]


def _build(
    work: Path, sources: Path, generated: Mapping[str, str], effects: Sequence[OwnEffect]
) -> None:
    """Make the source tree, what the package holds of it, and the library for Python."""
    from it2hys.fmu.own_stage import stages_with

    tree, headers, native = work / SOURCES, work / "generated", work / "native"
    shutil.copytree(sources, tree)
    for name, text in generated.items():
        (tree / "core" / name).write_text(text, encoding="utf-8", newline="\n")
    stages = tree / "core" / "stages.h"
    stages.write_text(
        stages_with(stages.read_text(encoding="utf-8"), effects), encoding="utf-8", newline="\n"
    )
    write_headers(headers)
    write_folders(tree, headers)
    native.mkdir()
    for folder in ("sources", "controller", "embedded"):
        shutil.copytree(headers / folder, native / folder)
    shutil.copytree(tree, native / SOURCES)
    shutil.copy(packaged_native() / "LICENSE", native)
    _compile_library(work, native / library_name())


def _compile_library(work: Path, library: Path) -> None:
    tree, headers = work / SOURCES, work / "generated"
    places = [tree / "core", tree / "fmi", tree / "models", tree / "identification", headers]
    include = [f"-I{place}" for place in places] + ["-isystem", str(fmi_headers())]
    core = headers / "embedded" / "it2hys.c"
    jobs = {
        "core.o": (core, "-O2"),
        **{f"{Path(name).stem}.o": (tree / name, level) for name, level in _LIBRARY.items()},
    }
    objects = [work / name for name in jobs]
    run_all(
        [*compiler(), *_FLAGS, *level.split(), *include, "-c", str(source), "-o", str(work / name)]
        for name, (source, level) in jobs.items()
    )
    libraries = [] if sys.platform == "win32" else ["-lm"]
    run_all([[*compiler(), "-shared", "-O2", "-o", str(library), *map(str, objects), *libraries]])


def fmi_headers() -> Path:
    """Return the folder of FMI's headers, which fmpy brings."""
    found = importlib.util.find_spec("fmpy")
    assert found and found.submodule_search_locations
    return Path(found.submodule_search_locations[0]) / "c-code"


def run_all(commands: Iterable[Sequence[str]]) -> None:
    """Run compilers side by side; what one of them says is raised."""
    environment = {"ZIG_GLOBAL_CACHE_DIR": str(cache_directory() / "zig"), **os.environ}
    try:
        cross_compiling.run_all(commands, environment)
    except subprocess.CalledProcessError as error:
        said = error.output[-2000:]
        raise InputError(f"the C compiler refuses an effect's stage:\n{said}") from None
