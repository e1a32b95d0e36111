"""The Modelica library as files and texts, for the tests of this directory."""

import re
from pathlib import Path

LIBRARY = Path(__file__).parents[2] / "modelica" / "IT2Hysteresis"
FILES = sorted(LIBRARY.rglob("*.mo"))
HEADER = re.compile(
    r"^(?:within(?P<within>[ \w.]*);\n)"
    r"(?:partial |impure )?(?P<kind>package|class|model|block|record|function) (?P<name>\w+)"
    r"\s+\"(?P<description>[^\"]+)\"\n",
)
STRING = r'\s*=\s*"((?:[^"\\]|\\.)*)"'


def class_name(file: Path) -> str:
    """Return the full name of the class that a file holds by its place in the library."""
    parts = file.relative_to(LIBRARY.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "package" else parts)


CLASSES = {class_name(file): file for file in FILES}


def kind(name: str) -> str:
    """Return what a class is: package, class, model, block, record or function."""
    return HEADER.match(CLASSES[name].read_text(encoding="utf-8"))["kind"]


def html(file: Path, attribute: str) -> list[str]:
    """Return the HTML texts of `info` or `revisions` in a file, unescaped."""
    texts = re.findall(attribute + STRING, file.read_text(encoding="utf-8"))
    return [re.sub(r"\\(.)", r"\1", text) for text in texts]
