"""What is in an FMU's archive, checked before it is unpacked: FMUs come from strangers."""

import stat
import zipfile
from pathlib import Path, PurePosixPath, PureWindowsPath

from it2hys.errors import InputError

#: Bytes that an FMU may unpack to, and how many files it may hold.
LARGEST_FMU = 2 * 2**30
MOST_FILES = 100_000


def check_archive(path: Path) -> None:
    """Refuse an archive that would unpack to much, or to places outside its folder.

    Raises
    ------
    InputError
        If the file is missing or no ZIP archive, or if an entry has an absolute path, a backslash
        or `..` in its name, or is a symbolic link.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: not an FMU: {error}") from None
    for entry in entries:
        if fault := _fault(entry):
            raise InputError(
                f"{path}: the entry {entry.filename!r} {fault}, which no FMU may have; "
                "it is not unpacked"
            )
    # entries are read to the size that is written here, so that this is a bound
    size = sum(entry.file_size for entry in entries)
    if size > LARGEST_FMU or len(entries) > MOST_FILES:
        raise InputError(
            f"{path}: unpacks to {len(entries)} files of {size / 2**30:.1f} GiB together; "
            f"{MOST_FILES} files and {LARGEST_FMU / 2**30:g} GiB are the limits"
        )


def _fault(entry: zipfile.ZipInfo) -> str | None:
    """Return what is wrong with an entry's name or kind."""
    # zipfile itself replaces what the system separates folders by, and cuts names at a null
    name = entry.orig_filename
    if "\\" in name:
        return "has a backslash in its path"
    if name.startswith("/") or ":" in name:
        return "has an absolute path"
    if ".." in name.split("/"):
        return "has a path that leaves its folder"
    if stat.S_ISLNK(entry.external_attr >> 16):
        return "is a symbolic link"
    return None


def unpack(path: Path, directory: str | Path) -> None:
    """Unpack a checked archive; raises InputError where an entry is damaged or cannot be written."""
    try:
        with zipfile.ZipFile(path) as archive:
            archive.extractall(directory)
    except Exception as error:  # of zipfile, of a decompressor or of the file system
        raise InputError(f"{path}: cannot be unpacked: {error}") from None


def is_plain_name(name: str) -> bool:
    """Tell whether a name is that of a file in a folder, on any system."""
    return (
        name not in ("", ".", "..") and name == PurePosixPath(name).name == PureWindowsPath(name).name
    )
