"""Where a report comes from: version, date, command, seed, and the inputs with their hashes."""

from __future__ import annotations

import hashlib
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from it2hys.records import Record
from it2hys.support.version import package_version


@dataclass(frozen=True)
class Provenance:
    """What a report was made by and of.

    Parameters
    ----------
    command : str
        As one would type it; empty where it was no command.
    seed : int or None
        Of the random starts.
    files : tuple of Path
        Inputs beside the records: a starting model, a scenario.
    """

    command: str = ""
    seed: int | None = None
    files: tuple[Path, ...] = ()

    @classmethod
    def of_command(
        cls, arguments: Sequence[str], seed: int | None = None, files: Sequence[Path] = ()
    ) -> Provenance:
        """Return the provenance of a command line's arguments, those behind the program's name."""
        return cls(shlex.join(["it2hys", *arguments]), seed, tuple(files))

    def entries(
        self,
        records: Sequence[Record] = (),
        roles: Sequence[str] = (),
        directory: Path | None = None,
    ) -> dict:
        """Return the keys of `report.json`.

        Parameters
        ----------
        records : sequence of Record
        roles : sequence of str
            Theirs.
        directory : Path, optional
            Of the report: files in it are named from there.
        """
        inputs = [
            {
                "name": r.name,
                "role": role,
                "file": _text(r.path, directory),
                "sha256": file_hash(r.path),
            }
            for r, role in zip(records, roles, strict=True)
        ]
        inputs += [
            {
                "name": path.name,
                "role": "input",
                "file": _text(path, directory),
                "sha256": file_hash(path),
            }
            for path in self.files
        ]
        return {
            "version": package_version(),
            "date": datetime.now(UTC).isoformat(timespec="seconds"),
            "command": self.command,
            "seed": self.seed,
            "inputs": inputs,
        }


def _text(path: Path | None, directory: Path | None) -> str | None:
    if path is not None and directory is not None and path.is_relative_to(directory):
        path = path.relative_to(directory)
    return None if path is None else path.as_posix()


def file_hash(path: Path | None) -> str | None:
    """Return the SHA-256 of a file as hexadecimal digits, or None where there is no file."""
    if path is None or not path.is_file():
        return None
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def about(report: Mapping) -> str:
    """Return where a report comes from, in a line."""
    date = report["date"].replace("T", " ").replace("+00:00", " UTC")
    command = f", by `{report['command']}`" if report["command"] else ""
    return f"it2hys {report['version']}, {date}{command}"
