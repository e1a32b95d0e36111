"""Nothing in Python names an effect but its two modules and the list: it is asked what it is like.

Words are prose: docstrings, comments, and strings with blanks in which a name stands as a word of
English. The simulated test stand is another physics, whose parts have names of their own.
"""

import ast
import re
from pathlib import Path

import pytest

import it2hys
from it2hys.model.stages import EFFECTS
from it2hys.model.variables import load_table

PACKAGE = Path(it2hys.__file__).parent
#: Parameters of effects, without the index of an element, and the counts of these.
PARAMETERS = {re.sub(r"\[\d+\]", "", n) for n, v in load_table().parameters().items() if v.effect}
PARAMETERS |= {c["variable"] for group, c in load_table().counts.items() if group in EFFECTS}
#: Names that are no effect's where they stand, and what they are.
OTHERS = {
    ("cli.py", "slew"): "an option: what an amplifier can do, whatever the model has of it",
    ("records/unused.py", "load"): "a word for a force in the header of a record",
    ("reports/courses.py", "load"): "a function of numpy",
}


def product() -> list[Path]:
    own = {f"{room}/{name}.py" for name in EFFECTS for room in ("model/effects", "diagnosis/evidence")}
    places = {p: p.relative_to(PACKAGE).as_posix() for p in PACKAGE.rglob("*.py")}
    assert own <= set(places.values())
    exempt = own | {"model/stages.py"}
    return [p for p, place in places.items() if place not in exempt and not place.startswith("stand/")]


def docstrings(tree: ast.Module) -> set[ast.AST]:
    """Return the strings that stand alone: docstrings, and what documents an attribute."""
    return {n.value for n in ast.walk(tree) if isinstance(n, ast.Expr)}


def words(node: ast.AST) -> list[str]:
    """Return what a node of the tree names."""
    match node:
        case ast.Constant(value=str(text)):
            names = re.findall(r"[A-Za-z_]\w*(?:\[\d*\]?)?(?:\.\w+)?", text)
            names = [re.sub(r"\[\d*\]?", "", name) for name in names]
            names = names if " " not in text else [n for n in names if n in PARAMETERS]
            return [part for name in names for part in (name, name.split(".")[0])]
        case ast.Name(id=name) | ast.Attribute(attr=name) | ast.arg(arg=name) | ast.keyword(arg=name):
            return [name]
        case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
            return [name]
        case ast.alias(name=name, asname=other):
            return [*name.split("."), other]
        case ast.ImportFrom(module=str(module)):
            return module.split(".")
    return []


def names_of_effects(source: str) -> dict[str, int]:
    """Return the effects and parameters of effects that a source names, with the first line."""
    tree = ast.parse(source)
    prose, known, found = docstrings(tree), PARAMETERS | set(EFFECTS), {}
    for node in ast.walk(tree):
        for word in words(node) if node not in prose else ():
            if word in known:
                found.setdefault(word, getattr(node, "lineno", 0))
    return found


@pytest.mark.parametrize("path", product(), ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_no_other_file_names_an_effect(path):
    place = path.relative_to(PACKAGE).as_posix()
    found = names_of_effects(path.read_text(encoding="utf-8"))
    assert [f"{place}:{line}: {n}" for n, line in found.items() if (place, n) not in OTHERS] == []


def test_what_is_excepted_is_there():
    for place, name in OTHERS:
        assert name in names_of_effects((PACKAGE / place).read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "line",
    [
        'NAMES = ("lag", "other")',
        'values["lag.timeConstant"] = 0.0',
        'values[f"creep[{i}].gain"] = 0.0',
        'values["creepCount"]',
        'text = "its creep[2].gain is no number"',
        '"initialExcursion" in values',
        'option = "--declared=play,creep"',
        "from it2hys.model.effects import hum",
        "from it2hys.diagnosis.evidence.hum import lines",
        "import it2hys.model.effects.drift as other",
        "model.nonlinearity(2)",
        "drift = 2",
        "f(delay=2)",
        "def play(x): pass",
        "def f(load): pass",
    ],
)
def test_the_walk_sees_a_name(line):
    assert names_of_effects(line)


@pytest.mark.parametrize(
    "line",
    [
        'def f():\n    """Return the play, creep[1].gain and all."""',
        "# the creep",
        'raise ValueError("a load that compresses the stage: delay it")',
        'name = "display"',
        'TITLE = "lagging"',
        'x.delays["playback"] = 2',
    ],
)
def test_the_walk_is_not_fooled_by_prose(line):
    assert names_of_effects(line) == {}


def test_the_physics_imports_nothing_of_identification_or_diagnosis():
    files = [*(PACKAGE / "model").rglob("*.py"), *(PACKAGE / "records").rglob("*.py")]
    assert len(files) > 2 * len(EFFECTS)
    for path in files:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                assert not re.match(r"it2hys\.(identification|diagnosis|reports|fmu)", name), path
