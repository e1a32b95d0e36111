"""Files of ours: written whole or not at all, together or not at all, and read."""

import json
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from it2hys.errors import InputError

#: Room that FMUs, a report and its figures may take, bytes.
ROOM = 20_000_000
#: Begins the name of the folder in which results are gathered.
_GATHERED = ".it2hys-"


def write_atomically(path: str | Path, content: bytes) -> None:
    """Write `content` under a temporary name beside `path`, then rename it.

    Raises
    ------
    InputError
        If the directory does not exist or cannot be written to.
    """
    path = Path(path)
    try:
        descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except OSError as error:
        Path(temporary).unlink(missing_ok=True)
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def read_json(path: Path, keys: Sequence[str], absent: str, other: str) -> dict:
    """Return what a JSON file of ours holds.

    Parameters
    ----------
    path : Path
    keys : sequence of str
        What it must have.
    absent, other : str
        What there is to do where there is no such file, and where it is another one.

    Raises
    ------
    InputError
        If it is not there, cannot be read, or is something else.
    """
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file{absent}") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}{other}") from None
    if missing := [key for key in keys if not isinstance(found, dict) or key not in found]:
        raise InputError(f"{path}: {', '.join(missing)} missing{other}")
    return found


def make_directory(directory: str | Path) -> Path:
    """Create an output directory.

    Raises
    ------
    InputError
        If it cannot be created.
    """
    directory = Path(directory)
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{directory}: this directory cannot be created: {error.strerror}") from None
    return directory


def check_directory(directory: str | Path, room: int = ROOM) -> None:
    """Refuse an output directory that cannot be used, before the work; nothing is left in it.

    Parameters
    ----------
    directory : path
        It need not exist.
    room : int
        What may be written to it, bytes.

    Raises
    ------
    InputError
        If it is a file, if nothing can be written to it or to where it would be made, or if its disk
        is too full.
    """
    directory = Path(directory)
    place = _existing(directory)
    if not place.is_dir():
        raise InputError(f"{directory}: this directory cannot be created: {place} is a file")
    try:
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError as error:
        raise InputError(f"{directory}: cannot be written to: {error.strerror}") from None
    free = shutil.disk_usage(place).free
    if free < room:
        raise InputError(
            f"{directory}: {free / 1e6:.0f} MB are free, {room / 1e6:.0f} MB may be needed; make room, "
            "or choose another directory with -o"
        )


def check_file(path: str | Path, inputs: Sequence[str | Path] = ()) -> None:
    """Refuse an output file that cannot be used, before the work: nor may it be one of the inputs.

    Raises
    ------
    InputError
        If it is one of the inputs or a directory, or if its directory cannot be used.
    """
    path = Path(path)
    if any(path.resolve() == Path(other).resolve() for other in inputs):
        raise InputError(f"{path}: -o would overwrite an input of this command; name another file")
    if path.is_dir():
        raise InputError(
            f"{path}: this is a directory; -o needs the name of a file, such as {path / 'y.csv'}"
        )
    check_directory(path.parent, room=0)


@contextmanager
def gathered(directory: str | Path, outdated: Iterable[Path] = ()) -> Iterator[Path]:
    """Hand out a folder whose files come to `directory` when all are written.

    After an error, or an interruption, none of them does: what `directory` held is as it was, and if
    it was not there, it is not.

    Parameters
    ----------
    directory : path
        Created if it does not exist.
    outdated : iterable of Path
        Files of `directory` that go when the new ones come, unless they are among those.

    Raises
    ------
    InputError
        If the directory cannot be made or written to.
    """
    directory = Path(directory)
    made = [folder for folder in (directory, *directory.parents) if not folder.exists()]
    try:
        make_directory(directory)
        with _scratch(directory) as folder:
            try:
                yield folder
            except InputError as error:  # names the place that the user knows
                raise InputError(str(error).replace(str(folder), str(directory))) from None
            new = {directory / path.relative_to(folder) for path in folder.rglob("*")}
            _bring(folder, directory)
            for path in {*outdated} - new:
                path.unlink(missing_ok=True)
    except BaseException:
        for folder in made:
            if folder.is_dir() and not any(folder.iterdir()):
                folder.rmdir()
        raise


def write_together(directory: str | Path, contents: Mapping[str, bytes]) -> list[Path]:
    """Write files by name into a directory, all or none; return their paths. Raises as `gathered`."""
    with gathered(directory) as folder:
        for name, content in contents.items():
            write_atomically(folder / name, content)
    return [Path(directory) / name for name in contents]


@contextmanager
def _scratch(directory: Path) -> Iterator[Path]:
    try:
        scratch = tempfile.TemporaryDirectory(
            dir=directory, prefix=_GATHERED, ignore_cleanup_errors=True
        )
    except OSError as error:
        raise InputError(f"{directory}: cannot be written to: {error.strerror}") from None
    with scratch as name:
        yield Path(name)


def _bring(folder: Path, directory: Path) -> None:
    """Move the files of a folder, and of those in it, to a directory: within one disk, by renaming."""
    moves = {path: directory / path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}
    for target in moves.values():
        make_directory(target.parent)
        if target.is_dir():
            raise InputError(
                f"{target}: a file is to be written here, but this is a directory; remove it"
            )
    for path, target in moves.items():
        try:
            os.replace(path, target)
        except OSError as error:
            raise InputError(f"{target}: cannot be written: {error.strerror}") from None


def _existing(path: Path) -> Path:
    """Return a path, or the nearest of those above it that exists."""
    path = path.absolute()
    while not path.exists():
        path = path.parent
    return path
