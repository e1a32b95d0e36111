"""What `import it2hys` offers: every name is there, explained, typed, and in the reference."""

import inspect
import re
from pathlib import Path

import pytest

import it2hys

REFERENCE = (Path(__file__).parents[2] / "docs/reference/api.md").read_text(encoding="utf-8")
NAMES = [name for name in it2hys.__all__ if name != "__version__"]


@pytest.mark.parametrize("name", NAMES)
def test_a_public_name_is_explained_and_in_the_reference(name):
    thing = getattr(it2hys, name)
    assert inspect.getdoc(thing)
    assert re.search(rf"it2hys\.{name}$", REFERENCE, re.MULTILINE)


@pytest.mark.parametrize("name", NAMES)
def test_a_public_function_is_typed_and_each_parameter_documented(name):
    thing = getattr(it2hys, name)
    if not inspect.isfunction(thing):
        return
    signature = inspect.signature(thing)
    assert signature.return_annotation is not inspect.Signature.empty
    for parameter in signature.parameters.values():
        assert parameter.annotation is not inspect.Parameter.empty, parameter
        found = rf"^(.*, )?{parameter.name}(,.*)? : "
        assert re.search(found, inspect.getdoc(thing), re.MULTILINE), parameter


def test_checkers_and_editors_see_every_name():
    """Names that are loaded when asked for are imported where only checkers look."""
    text = Path(it2hys.__file__).read_text(encoding="utf-8")
    for name in NAMES:
        assert name == "InputError" or f" import {name} as {name}\n" in text, name
