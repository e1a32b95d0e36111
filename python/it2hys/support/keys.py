"""Reading TOML files, and advice on an unknown name."""

import difflib
import tomllib
from collections.abc import Collection
from pathlib import Path

from it2hys.errors import InputError


def read_toml(path: Path) -> dict:
    """Read a TOML file; raises InputError naming the file, and the line where it is not TOML."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))  # some editors begin with a BOM
    except OSError:
        raise InputError(f"{path}: no such file, or it cannot be read") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not TOML: {error}") from None


#: Known names that a message lists.
_LISTED = 20


def known_names(name: str, known: Collection[str]) -> str:
    """Return advice on an unknown name: the one that it resembles, and the first of the known ones."""
    alike = difflib.get_close_matches(name, known, n=1)
    guess = f"did you mean {alike[0]!r}? " if alike else ""
    more = len(known) - _LISTED
    listed = ", ".join(list(known)[:_LISTED]) or "none"
    return f"{guess}known are {listed}" + (f" and {more} more" if more > 0 else "")
