"""The one table of variables (`variables.toml`), expanded.

Everything that names a variable asks here: the parameter sets, modelDescription.xml, the C table of
value references and the documentation. Only the standard library is used, because the C build reads
the table too.
"""

import re
import tomllib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import Any

TABLE = Path(__file__).with_name("variables.toml")
CONTROLLER = Path(__file__).with_name("controller.toml")
#: Name of the parameter set that is the table's start.
TABLE_1 = "Table 1"
MODELS = ("plant", "inverse")
INDEXED = re.compile(r"(?P<group>\w+)\[(?P<index>[1-9]\d*)\]\.(?P<field>\w+)")


@dataclass(frozen=True)
class DeclaredType:
    """A declared type of the table: base type, unit, bounds and nominal value."""

    name: str
    base: str = "Real"
    unit: str | None = None
    displayUnit: str | None = None  # noqa: N815 (the attribute's name in FMI)
    quantity: str | None = None
    min: float | None = None
    max: float | None = None
    nominal: float | None = None


@dataclass(frozen=True)
class Variable:
    """One scalar variable of the expanded table.

    `group`, `index` and `field` are set for an element of a structured parameter: `rule[2].q1` has
    the group `rule`, the index 2 and the field `q1`. An effect's scalar, such as
    `resonance.frequency`, is in no group. `effect` is set for the parameters of effects.
    """

    name: str
    value_reference: int
    models: tuple[str, ...]
    causality: str
    type: DeclaredType
    start: float | int | bool | None
    depends: tuple[str, ...]
    description: str
    group: str | None = None
    index: int | None = None
    effect: str | None = None

    @property
    def field(self) -> str:
        """Name within the group; the name itself for a variable outside any group."""
        return self.name.rsplit(".", 1)[-1]

    def is_among(self, counts: Mapping[str, int]) -> bool:
        """Tell whether it is used where the groups have so many elements."""
        return self.group is None or self.index is None or self.index <= counts[self.group]

    @property
    def variability(self) -> str:
        """FMI's variability: parameters are fixed, flags and integers discrete."""
        if self.causality == "parameter":
            return "fixed"
        return "continuous" if self.causality == "input" and self.type.base == "Real" else "discrete"


@dataclass(frozen=True)
class Table:
    """The expanded table: every variable that the binaries know, in value reference order.

    `own` are the hashes of the effects of the user's own that rows belong to.
    """

    variables: tuple[Variable, ...]
    types: dict[str, DeclaredType]
    units: dict[str, dict]
    counts: dict[str, dict]
    outdated: dict[str, dict]
    own: tuple[str, ...] = ()

    def parameters(self) -> dict[str, Variable]:
        """Return the parameters by name, structured ones at their full count."""
        return {v.name: v for v in self.variables if v.causality == "parameter"}

    def effect_of(self, parameter: str) -> str | None:
        """Return the effect that a parameter belongs to; None of the core's and the record's."""
        return self.parameters()[parameter].effect

    def start(self) -> dict[str, float | int | bool]:
        """Return the start values of the parameters by name, structured ones at their start count."""
        parameters = self.parameters()
        counts = {g: int(parameters[c["variable"]].start or 0) for g, c in self.counts.items()}
        return {
            name: v.start
            for name, v in parameters.items()
            if v.start is not None and v.is_among(counts)
        }

    def of_model(self, model: str, counts: dict[str, int]) -> list[Variable]:
        """Return one FMU's variables, with as many structured elements as `counts` says."""
        return [v for v in self.variables if model in v.models and v.is_among(counts)]


def _expand(rows: list[dict], counts: dict[str, dict]) -> Iterator[tuple[dict, str, int | None, Any]]:
    """Yield row, name, index and start value of every scalar; a group's elements stay together."""
    for group, members in groupby(rows, key=lambda row: row.get("per")):
        if group is None:
            yield from ((row, row["name"], None, _start(row)) for row in members)
            continue
        elements = list(members)
        for index in range(1, counts[group]["maximum"] + 1):
            for row in elements:
                own = row.get("start", [])
                start = own[index - 1] if index <= len(own) else 0.0
                yield row, row["name"].replace("[]", f"[{index}]"), index, start


def _start(row: dict) -> Any:
    """Return the start value of a scalar: a parameter's is 0 unless it has one, an output has none."""
    return row.get("start", 0.0 if _causality(row) == "parameter" else None)


def _causality(row: dict) -> str:
    return row.get("causality", "parameter")


def _variable(
    row: dict, types: Mapping[str, DeclaredType], models: tuple[str, ...], **own: Any
) -> Variable:
    """Return a row as a variable, of which `own` is said beside it."""
    return Variable(
        models=models,
        causality=_causality(row),
        type=types[row["type"]],
        depends=tuple(row.get("depends", ())),
        description=row["description"],
        **own,
    )


@cache
def load_table() -> Table:
    """Read and expand `variables.toml`."""
    source = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    types = {name: DeclaredType(name, **fields) for name, fields in source["types"].items()}
    expanded = _expand(source["variable"], source["counts"])
    variables = [
        _variable(
            row,
            types,
            MODELS if row.get("model", "both") == "both" else (row["model"],),
            name=name,
            value_reference=place,
            start=start,
            group=row.get("per"),
            index=index,
            effect=row.get("effect"),
        )
        for place, (row, name, index, start) in enumerate(expanded)
    ]
    variables += [replace(v, value_reference=len(variables) + i) for i, v in enumerate(_more)]
    units = source["units"] | {v.type.unit: {} for v in _more if v.type.unit not in source["units"]}
    types |= {v.type.name: v.type for v in _more}
    return Table(tuple(variables), types, units, source["counts"], source["outdated"], _own)


#: Rows of effects that are not in the file, and the hashes of these effects' files.
_more: tuple[Variable, ...] = ()
_own: tuple[str, ...] = ()


def table_with(variables: Sequence[Variable], own: Sequence[str]) -> None:
    """Let the table end with these rows, in place of those that it ended with."""
    global _more, _own
    _more, _own = tuple(variables), tuple(own)
    load_table.cache_clear()


def off_values(effects: Collection[str]) -> dict[str, float | int]:
    """Return the parameters of effects where these are off, but for those of their elements."""
    known = load_table().parameters()
    return {
        n: v.start
        for n, v in known.items()
        if v.start is not None and v.effect in effects and v.group is None
    }


@dataclass(frozen=True)
class ControllerTable:
    """The table of the controller's variables."""

    guid: str
    units: dict[str, dict]
    variables: tuple[Variable, ...]


@cache
def load_controller() -> ControllerTable:
    """Read `controller.toml`."""
    source = tomllib.loads(CONTROLLER.read_text(encoding="utf-8"))
    types = load_table().types | {n: DeclaredType(n, **f) for n, f in source["types"].items()}
    variables = tuple(
        _variable(
            row, types, ("controller",), name=row["name"], value_reference=place, start=_start(row)
        )
        for place, row in enumerate(source["variable"])
    )
    return ControllerTable(source["guid"], load_table().units | source["units"], variables)
