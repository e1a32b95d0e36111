"""The Modelica library as files and texts, for the tests of this directory."""

import csv
import re
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from it2hys.model.variables import load_table

#: Loads the standard library's stub in rumoca: packages whose names stand in the source are loaded.
PREAMBLE = "import Modelica.Units.SI;"
PLANT = "IT2Hysteresis.Blocks.PureModelica.Plant"
INVERSE = "IT2Hysteresis.Blocks.PureModelica.Inverse"
FMU_PLANT = "IT2Hysteresis.Blocks.Plant"
FMU_INVERSE = "IT2Hysteresis.Blocks.Inverse"
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


#: Differences of two results that are none: 1e-12 V or m, or so much of a signal that hardly changes.
LEAST, ROUNDING = 1e-12, 1e-6
CLASSES = {class_name(file): file for file in FILES}
#: Elements that a test puts into a vector, at most.
LONGEST = 20


EXAMPLES = [
    n
    for n in CLASSES
    if n.startswith("IT2Hysteresis.Examples.") and "\nmodel " in CLASSES[n].read_text()
]
REFERENCE = LIBRARY / "Resources" / "Reference"


def experiment(name: str) -> tuple[float, float]:
    """Return stop time and interval of an example's experiment."""
    found = re.search(
        r"experiment\(StopTime=([\d.]+), Interval=([\d.e-]+),",
        CLASSES[name].read_text(encoding="utf-8"),
    )
    return float(found[1]), float(found[2])


def comparison_signals(name: str) -> list[str]:
    """Return the names that an example is compared by, without the time."""
    path = REFERENCE.joinpath(*name.split(".")) / "comparisonSignals.txt"
    first, *names = path.read_text(encoding="utf-8").split()
    assert first == "time"
    return names


def stored_path(name: str) -> Path:
    """Return the file of an example's stored result."""
    return REFERENCE.joinpath(*name.split(".")) / f"{name.rsplit('.', 1)[-1]}.csv"


def stored_result(name: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return times and signals of an example's stored result."""
    with stored_path(name).open(encoding="utf-8", newline="") as file:
        names, *rows = csv.reader(file)
    time, *columns = np.array(rows, dtype=float).T
    return time, dict(zip(names[1:], columns, strict=True))


def differences(
    name: str, time: np.ndarray, signal: Callable[[str], np.ndarray], tolerance: float = 0.02
) -> list[str]:
    """Compare a result with the stored one: by share of the span, leaving out 2 % of the times.

    Those are near events, where the moment decides. A signal that is held changes at the very times
    that are stored: what it is just before or just after is right.
    """
    found, moment = [], 0.05 * experiment(name)[1]
    times, stored = stored_result(name)
    for label, expected in stored.items():
        around = [np.interp(times + side * moment, time, signal(label)) for side in (-1, 1)]
        apart = np.quantile(np.abs(np.array(around) - expected).min(axis=0), 0.98)
        if not apart <= tolerance * max(np.ptp(expected), ROUNDING * np.abs(expected).max(), LEAST):
            found.append(f"{name}: {label} is {apart:.3g} from the stored result")
    return found


def kind(name: str) -> str:
    """Return what a class is: package, class, model, block, record or function."""
    return HEADER.match(CLASSES[name].read_text(encoding="utf-8"))["kind"]


def html(file: Path, attribute: str) -> list[str]:
    """Return the HTML texts of `info` or `revisions` in a file, unescaped."""
    texts = re.findall(attribute + STRING, file.read_text(encoding="utf-8"))
    return [re.sub(r"\\(.)", r"\1", text) for text in texts]


def values_of(parameters: Mapping) -> list[float]:
    """Return the numbers of a set as the external objects take them: in the order of the table.

    The elements of a group are columns, each behind how many there are; the counts are those numbers.
    """
    numbers, known = [], load_table().parameters()
    counts = {entry["variable"] for entry in load_table().counts.values()}
    for name, variable in known.items():
        if variable.group is None and name not in counts:
            numbers.append(float(parameters[name]))
        elif variable.index == 1:
            names = map(name.replace("[1]", "[{}]").format, range(1, LONGEST + 1))
            column = [float(parameters[n]) for n in names if n in parameters]
            numbers += [float(len(column)), *column]
    return numbers


def model(declarations: str, equations: str = "") -> str:
    """Return the source of a model M."""
    return f"model M {PREAMBLE} {declarations} equation {equations} end M;"
