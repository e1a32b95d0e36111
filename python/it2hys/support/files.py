"""Writing files so that they appear whole or not at all."""

import os
import tempfile
from pathlib import Path

from it2hys.errors import InputError


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
