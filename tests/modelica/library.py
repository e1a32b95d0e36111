"""The Modelica library as files and texts, for the tests of this directory."""

import re
from collections.abc import Mapping
from pathlib import Path

from it2hys.model.variables import load_table

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


def values_of(parameters: Mapping) -> list[float]:
    """Return the numbers of a set as the external objects take them: in the order of the table.

    The elements of a group are columns, behind their number.
    """
    numbers, known = [], load_table().parameters()
    for name, variable in known.items():
        if variable.group is None:
            numbers.append(float(parameters[name]))
        elif variable.index == 1:
            column = name.replace("[1]", "[{}]").format
            count = parameters[load_table().counts[variable.group]["variable"]]
            numbers += [float(parameters[column(i)]) for i in range(1, count + 1)]
    return numbers
