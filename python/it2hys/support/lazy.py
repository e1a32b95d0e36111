"""Libraries that are large and needed by some of the work only: loaded when they are first used."""

import importlib
from typing import Any


class Lazy:
    """A module that is loaded when something of it is first asked for.

    Where it is not installed, that raises ModuleNotFoundError, which the command line turns into one
    sentence; what does not use it works without.
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        value = getattr(importlib.import_module(self._name), attribute)
        setattr(self, attribute, value)  # found without this function from now on
        return value
