"""Reading TOML files with messages that point at the key."""

import difflib
import tomllib
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from types import UnionType
from typing import Any

from it2hys.errors import InputError


def read_toml(path: Path) -> dict:
    """Read a TOML file; raises InputError naming the file, and the line where it is not TOML."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))  # some editors begin with a BOM
    except OSError:
        raise InputError(f"{path}: no such file, or it cannot be read") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not TOML: {error}") from None


#: What values are called where TOML is written.
_KINDS = {
    float: "a number", int: "a whole number", str: "a text", bool: "true or false", list: "a list",
    dict: "a table",
}  # fmt: skip
#: Known names that a message lists.
_LISTED = 20


class Keys:
    """The keys of a table, taken one by one; what is left over is a mistake.

    Parameters
    ----------
    place : str
        Where the table is, as messages begin: ``"record 1: "``.
    table : mapping
        As TOML gives it; anything else is an InputError.
    """

    def __init__(self, place: str, table: object) -> None:
        if not isinstance(table, Mapping):
            raise InputError(f"{place}must be a table, not {table!r}")
        self.place, self._left = place, dict(table)
        self._known: list[str] = []

    def take(self, key: str, kind: type | UnionType, *default: object) -> Any:
        """Return the value of a key, of a type (an int is a float too), or the default."""
        self._known.append(key)
        if key not in self._left:
            if not default:
                given = ", ".join(self._left) or "none"
                raise InputError(f"{self.place}key {key!r} is missing; other keys given: {given}")
            return default[0]
        value = self._left.pop(key)
        if kind in (float, float | dict) and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        numeric = kind in (int, float) or kind == float | dict
        if not isinstance(value, kind) or (numeric and isinstance(value, bool)):
            kinds = [_KINDS[k] for k in getattr(kind, "__args__", [kind])]
            raise InputError(f"{self.place}{key} is {value!r}; it must be {' or '.join(kinds)}")
        return value

    def choose(self, key: str, choices: Sequence[str], *default: str) -> str:
        """Return a text that must be one of some choices."""
        value = self.take(key, str, *default)
        if value not in choices:
            raise InputError(f"{self.place}{key} is {value!r}; it must be one of {', '.join(choices)}")
        return value

    def rest(self) -> dict:
        """Take all keys that are left."""
        rest, self._left = self._left, {}
        return rest

    def done(self) -> None:
        """Raise InputError if a key is left over: it is misspelled, or in the wrong place."""
        for key in self._left:
            raise InputError(f"{self.place}unknown key {key!r}; {known_names(key, self._known)}")


def known_names(name: str, known: Collection[str]) -> str:
    """Return what to say of an unknown name: the one it resembles, and the first of the known ones."""
    alike = difflib.get_close_matches(name, known, n=1)
    guess = f"did you mean {alike[0]!r}? " if alike else ""
    more = len(known) - _LISTED
    listed = ", ".join(list(known)[:_LISTED]) or "none"
    return f"{guess}known are {listed}" + (f" and {more} more" if more > 0 else "")
