"""Pages of the reference that are written when the site is built, from what they describe."""

import argparse
import json
import tempfile
import tomllib
import types
import typing
import zipfile
from collections import Counter
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from fmpy import read_model_description
from packaging.requirements import Requirement
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from it2hys.cli import make_parser
from it2hys.cli_help import EXAMPLES, KINDS, listed
from it2hys.experiments.scenario import Scenario
from it2hys.fmu.packaging import package
from it2hys.model.parameters import table_1
from it2hys.model.variables import Variable, load_table
from it2hys.sweeps.schema import CsvArguments, Intervals, Span, SweepScenario

ROOT = Path(__file__).parents[2]
PLATFORMS = {
    "linux64": "Linux, x86-64", "win64": "Windows, x86-64", "win32": "Windows, 32 bit",
    "darwin64": "macOS, Intel and Apple silicon",
}  # fmt: skip


def _row(*cells: object) -> str:
    return "| " + " | ".join(str(cell).replace("|", r"\|").replace("\n", " ") for cell in cells) + " |"


def _table(heads: list[str], rows: list[list[object]]) -> str:
    return "\n".join([_row(*heads), _row(*["---"] * len(heads)), *(_row(*row) for row in rows)]) + "\n"


def commands() -> str:
    """Return all commands with their options, from the parser."""
    text = []
    for name, command in _commands(make_parser()):
        text += [f"## it2hys {name}\n", f"{command.description}\n"]
        usage = command.format_usage().removeprefix("usage: ")
        text += [f"```text\n{usage}```\n"]
        actions = [a for a in command._actions if not isinstance(a, argparse._HelpAction)]
        actions.sort(key=lambda action: bool(action.option_strings))  # what must be given comes first
        rows = [[f"`{_typed(a)}`", (a.help or "") % vars(a)] for a in actions]
        text += [_table(["argument", "meaning"], rows)]
        if name in EXAMPLES:
            text += [f"```text\n{EXAMPLES[name].strip()}\n```\n"]
    return "\n".join(text)


def _commands(
    parser: argparse.ArgumentParser, before: str = ""
) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    """Yield names and parsers of all commands, and of those within them."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, command in action.choices.items():
                yield before + name, command
                yield from _commands(command, f"{before}{name} ")


def _typed(action: argparse.Action) -> str:
    """Return how an argument is typed, with what stands for its value."""
    choices = None if action.choices is None else f"{{{','.join(map(str, action.choices))}}}"
    value = "" if action.nargs == 0 else action.metavar or choices or ""
    return f"{', '.join(action.option_strings)} {value}".strip() or action.dest


def names() -> str:
    """Return the scenarios, effects and excitations that have a name."""
    text = []
    for kind in KINDS:
        rows = listed(kind)
        heads = list(rows[0])
        text += [f"## {kind.capitalize()}\n", _table(heads, [[row[h] for h in heads] for row in rows])]
    return "\n".join(text)


def variables() -> str:
    """Return all variables of plant and inverse, from the one table."""
    text = []
    for causality in ("input", "output", "parameter"):
        rows = [
            [f"`{v.name}`", " and ".join(v.models), _unit(v), _start(v), v.description]
            for v in load_table().variables
            if v.causality == causality and v.index in (None, 1)
        ]
        heads = ["name", "FMU", "unit (shown as)", "start", "meaning"]
        text += [f"## {causality.capitalize()}s\n", _table(heads, rows)]
    return "\n".join(text)


def _start(variable: Variable) -> str:
    return "" if variable.start is None else str(variable.start)


def _unit(variable: Variable) -> str:
    unit, shown = variable.type.unit or "", variable.type.displayUnit
    return f"{unit} ({shown})" if shown else unit


def fmus() -> str:
    """Return what the FMUs can do and where they run, read from the FMUs."""
    with tempfile.TemporaryDirectory() as folder:
        plant, inverse, _ = package(table_1(), folder)
        found = [read_model_description(str(path)).coSimulation for path in (plant, inverse)]
        with zipfile.ZipFile(plant) as archive:
            binaries = [Path(n).parent.name for n in archive.namelist() if n.startswith("binaries/")]
    capabilities = [n for n in dir(found[0]) if n.startswith(("can", "provides"))]
    rows = [[f"`{n}`", *("yes" if getattr(fmu, n) else "no" for fmu in found)] for n in capabilities]
    places = [[PLATFORMS.get(name, name), f"`binaries/{name}`"] for name in dict.fromkeys(binaries)]
    return "\n".join(
        [
            "## Capabilities\n", _table(["attribute", "IT2Plant", "IT2Inverse"], rows),
            "## Platforms\n", _table(["platform", "in the FMU"], places),
            "On any other platform, a C99 compiler makes the binary of `sources/`.\n",
        ]
    )  # fmt: skip


#: What a key holds, by the type of its field.
KINDS_OF_VALUES = {
    str: "text", int: "whole number", float: "number", bool: "`true` or `false`", dict: "table",
    Span: "number or table",
}  # fmt: skip
#: Tables that are read in place of another, or are written another way: under the heading of that.
BESIDE = {
    "Source": [('with `signal = "csv"`', CsvArguments)],
    "SweepScenario": [("a time in periods", Span)],
    "Vary": [("with `intervals`", Intervals)],
}


def scenarios() -> str:
    """Return the keys of scenarios, from the models that read them."""
    experiment = _keys("Keys of an experiment", Scenario, set())
    return "\n".join([*experiment, *_keys("Keys of a sweep", SweepScenario, set())])


def _keys(title: str, model: type[BaseModel], shown: set[type[BaseModel]], level: int = 2) -> list[str]:
    """Return the keys of a table, and of those within it, each of these once."""
    shown.add(model)
    rows, within = [], []
    for name, field in model.model_fields.items():
        if field.init is False or field.annotation is type(None):
            continue
        key = field.alias or name
        head, inner = _inside(key, field)
        rows.append([f"`{key}`", _kind(field), field.description, _default(field)])
        within += [(head, m) for m in inner]
    text = ["#" * level + f" {title}\n", _table(["key", "value", "meaning", "default"], rows)]
    for head, inner_model in within:
        text += [] if inner_model in shown else _keys(head, inner_model, shown, 3)
    for head, other in BESIDE.get(model.__name__, []):
        text += _keys(f"{title}, {head}" if level > 2 else head.capitalize(), other, shown, 3)
    return text


def _inside(key: str, field: FieldInfo) -> tuple[str, list[type[BaseModel]]]:
    """Return how the tables of a key are headed, and their models."""
    found = [t for t in _types(field.annotation) if isinstance(t, type) and issubclass(t, BaseModel)]
    outer = _outer(field.annotation)
    head = {tuple: f"`[[{key}]]`", dict: f"`[{key}.NAME]`"}.get(outer, f"`[{key}]`")
    return head, [t for t in found if t not in (Span, Intervals)]


def _outer(annotation: object) -> object:
    """Return whether an annotation, but for None, is of a tuple, a dict or neither."""
    for part in (annotation, *typing.get_args(annotation)):
        if (outer := typing.get_origin(part)) in (tuple, dict):
            return outer
    return None


def _types(annotation: object) -> Iterator[object]:
    """Yield the types that an annotation is made of."""
    arguments = typing.get_args(annotation)
    if not arguments or typing.get_origin(annotation) is typing.Literal:
        yield annotation
        return
    for argument in arguments[:1] if typing.get_origin(annotation) is typing.Annotated else arguments:
        yield from _types(argument)


def _kind(field: FieldInfo) -> str:
    """Return what a key holds, in words."""
    outer = _outer(field.annotation)
    inner = [t for t in _types(field.annotation) if t not in (type(None), Ellipsis)]
    words = []
    for kind in inner:
        if typing.get_origin(kind) is typing.Literal:
            choices = typing.get_args(kind)
            words.append("one of those listed" if len(choices) > 8 else
                         ", ".join(f'`"{c}"`' for c in choices))  # fmt: skip
        elif kind in KINDS_OF_VALUES:
            words.append(KINDS_OF_VALUES[kind])
        else:
            words.append("table" if isinstance(kind, type) and issubclass(kind, BaseModel) else "value")
    one = " or ".join(dict.fromkeys(words))
    if outer is tuple:
        return f"list: {one}"
    return "table by name" if outer is dict else one


def _default(field: FieldInfo) -> str:
    """Return the default of a key."""
    if field.is_required():
        return "required"
    if field.default_factory is not None or isinstance(field.default, BaseModel | types.NoneType):
        return ""
    if isinstance(field.default, bool | str) and field.default != "":
        return f"`{json.dumps(field.default)}`"
    return f"{field.default:g}" if isinstance(field.default, int | float) else ""


def weights() -> str:
    """Return what the packages weigh that it2hys needs, as they are installed here."""
    sizes: Counter[str] = Counter()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    waiting = [Requirement(r).name for r in project["dependencies"]]
    while waiting:
        name = waiting.pop().lower().replace("_", "-")
        if name in sizes:
            continue
        try:
            found = distribution(name)
        except PackageNotFoundError:
            continue
        paths = (Path(str(found.locate_file(f))) for f in found.files or [])
        sizes[name] = sum(p.stat().st_size for p in paths if p.is_file())
        needs = (Requirement(r) for r in found.requires or [])
        waiting += [r.name for r in needs if r.marker is None or r.marker.evaluate({"extra": ""})]
    rows = [[f"`{name}`", f"{size / 1e6:.0f}"] for name, size in sizes.most_common(10)]
    rows.append(["all", f"{sum(sizes.values()) / 1e6:.0f}"])
    return _table(["package", "MB"], rows)


PAGES = {
    "commands": commands,
    "names": names,
    "scenarios": scenarios,
    "variables": variables,
    "fmus": fmus,
    "weights": weights,
}


def write(app: object) -> None:
    """Write all pages; those that did not change keep their time, so that they are not built anew."""
    folder = Path(app.srcdir) / "_generated"  # type: ignore[attr-defined]
    folder.mkdir(exist_ok=True)
    for name, make in PAGES.items():
        path, text = folder / f"{name}.md", make()
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def setup(app: object) -> dict:
    """Register the pages."""
    app.connect("builder-inited", write)  # type: ignore[attr-defined]
    return {"parallel_read_safe": False}
