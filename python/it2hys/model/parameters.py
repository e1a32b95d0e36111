"""Parameter sets: reading, writing and validating what identifies a model.

A parameter set is a flat mapping from FMU variable names to SI values. Its file format is the SSP
standard's parameter set (SSV) in the narrow profile that common masters read.
"""

import difflib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from it2hys.errors import InputError
from it2hys.model import compiled
from it2hys.model.ssv import SSV_NAMESPACE, format_set
from it2hys.model.variables import INDEXED, TABLE_1, Variable, load_table
from it2hys.support.files import write_atomically
from it2hys.support.numerals import parse_number

RULE_FIELDS = ("sigmaLower", "sigmaUpper", "centre", "q1", "q2", "q3")


@dataclass(frozen=True, eq=False)  # compared as the mapping that it is
class ParameterSet(Mapping):
    """The values of all parameters of a chain, by FMU variable name, in SI units.

    Parameters that are not given take the table's start value, except the rules, which must be
    complete: a set without `ruleCount` has as many rules as it names. So it is with play operators
    and creep terms, of which there may be none. Effects are off at the table's start.

    Raises
    ------
    InputError
        For a name that the table lacks, a value of the wrong type or outside its bounds, or an
        incomplete rule.
    """

    values: Mapping[str, float | int | bool]  # type: ignore[assignment]
    name: str = "parameters"
    _complete: dict = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_complete", _complete(self.values))

    def __getitem__(self, name: str) -> float | int | bool:
        return self._complete[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._complete)

    def __len__(self) -> int:
        return len(self._complete)

    @property
    def counts(self) -> dict[str, int]:
        """Number of elements of every structured parameter: ``{"rule": 3, "play": 0, "creep": 0}``."""
        return {group: int(self[entry["variable"]]) for group, entry in load_table().counts.items()}

    @property
    def rules(self) -> np.ndarray:
        """Rules, shape (L, 6), in the columns of Table 1: s1, s2, c in m, q1, q2 in m/V, q3 in m."""
        count = self.counts["rule"]
        return np.array(
            [[self[f"rule[{i}].{name}"] for name in RULE_FIELDS] for i in range(1, count + 1)]
        )

    @property
    def displacement_range(self) -> tuple[float, float]:
        """Displacement range in m in which the model is invertible and contracting."""
        return self["displacementMin"], self["displacementMax"]

    @property
    def voltage_range(self) -> tuple[float, float]:
        """Voltage range in V that the parameters are valid for."""
        return self["voltageMin"], self["voltageMax"]

    def replace(self, **changes: float | int | bool) -> "ParameterSet":
        """Return a copy with scalar parameters changed, such as ``initialDisplacement=1e-6``."""
        return ParameterSet({**self._complete, **changes}, self.name)

    def validate(self) -> "ParameterSet":
        """Return self if the model is usable over its displacement range.

        Raises
        ------
        InputError
            If a deviation is not positive, a lower one is above the upper one, the model cannot be
            inverted (30) or does not contract somewhere in the range, or an effect is not one that
            can be. Names the parameter.
        """
        message = compiled.chain_check(self)
        if message:
            raise InputError(message)
        return self

    @classmethod
    def from_rules(
        cls, rules: np.ndarray, name: str = "parameters", **scalars: float
    ) -> "ParameterSet":
        """Build a set from an (L, 6) array of rules in SI units and scalar parameters by name."""
        values = {"ruleCount": len(rules), **scalars}
        for i, rule in enumerate(np.asarray(rules, dtype=float), start=1):
            values.update({f"rule[{i}].{f}": float(v) for f, v in zip(RULE_FIELDS, rule, strict=True)})
        return cls(values, name)


def table_1() -> ParameterSet:
    """Return the paper's Table 1, read as (s1, s2, c) (see PAPER.md), which is the table's start."""
    return ParameterSet(load_table().start(), TABLE_1)


def _complete(values: Mapping) -> dict[str, float | int | bool]:
    """Check the given values and add what is not given, in the table's order."""
    known = load_table().parameters()
    for name in values:
        if name not in known:
            raise InputError(f"unknown parameter {name!r}; {_suggest(name, known)}")
    given = {name: _checked(known[name], value) for name, value in values.items()}
    counts = {g: _count(g, entry, given) for g, entry in load_table().counts.items()}
    complete: dict[str, float | int | bool] = {}
    for name, variable in known.items():
        group = variable.group
        if group is None:
            complete[name] = given[name] if name in given else _start(variable)
        elif variable.is_among(counts):
            if name not in given:
                raise InputError(
                    f"parameter {name!r} is missing; a set with "
                    f"{counts[group]} {group}s must give all their parameters"
                )
            complete[name] = given[name]
        elif name in given:
            raise InputError(
                f"parameter {name!r} is given, but "
                f"{load_table().counts[group]['variable']} is {counts[group]}"
            )
    for group, entry in load_table().counts.items():
        complete[entry["variable"]] = counts[group]
    return complete


def _start(variable: Variable) -> float | int | bool:
    assert variable.start is not None, variable.name
    return variable.start


def _count(group: str, entry: dict, given: Mapping) -> int:
    """Return the number of elements of a group: as given, or as many as are named."""
    if entry["variable"] in given:
        return int(given[entry["variable"]])
    known = load_table().parameters()
    indices = [int(m["index"]) for m in map(INDEXED.fullmatch, given) if m and m["group"] == group]
    if not indices and known[entry["variable"]].type.min == 0:
        return 0
    if not indices:
        raise InputError(f"no parameter {group}[1].… is given; a model needs at least one {group}")
    return max(indices)


def _suggest(name: str, known: Mapping) -> str:
    effect = name.split(".")[0]
    if "." in name and "[" not in name and not any(n.startswith(f"{effect}.") for n in known):
        return f"if {effect!r} is an effect of your own, name its file: --effect {effect}.py"
    matches = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {matches[0]!r}?" if matches else "`variables.toml` lists the known ones"


def _checked(variable: Variable, value: Any) -> float | int | bool:
    """Return the value in its declared type; bounds are part of the type."""
    kind = variable.type
    if kind.base == "Boolean":
        if not isinstance(value, bool | np.bool_):
            raise InputError(f"{variable.name} is {value!r}; it must be true or false")
        return bool(value)
    try:
        number = parse_number(value) if isinstance(value, str) else float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{variable.name} is {value!r}; it must be a number") from None
    if not np.isfinite(number):
        raise InputError(f"{variable.name} is {number}; it must be a finite number")
    if kind.base == "Integer" and number != int(number):
        raise InputError(f"{variable.name} is {number:g}; it must be a whole number")
    if (kind.min is not None and number < kind.min) or (kind.max is not None and number > kind.max):
        unit = f" {kind.unit}" if kind.unit else ""
        raise InputError(
            f"{variable.name} is {number:g}{unit}; it must be {kind.min:g} to {kind.max:g}{unit}"
        )
    return int(number) if kind.base == "Integer" else number


def format_ssv(parameters: ParameterSet) -> str:
    """Return the set as SSV text, in the profile that common masters read."""
    return format_set(parameters, parameters.name)


def write_ssv(parameters: ParameterSet, path: str | Path) -> None:
    """Write the set to an SSV file; the file appears whole or not at all."""
    write_atomically(path, format_ssv(parameters).encode())


def read_ssv(path: str | Path) -> ParameterSet:
    """Read and validate an SSV file.

    Raises
    ------
    InputError
        If the file is missing, is not an SSV parameter set, holds an unusable model or play operators
        whose history an older version wrote. The message names the file and the parameter.
    """
    path = Path(path)
    try:
        root = etree.parse(str(path), etree.XMLParser(resolve_entities=False)).getroot()
    except OSError:
        raise InputError(f"{path}: no such file, or it cannot be read") from None
    except etree.XMLSyntaxError as error:
        raise InputError(
            f"{path}: not an XML file, and so no parameter set (.ssv): {error.msg}"
        ) from None
    if root.tag != f"{{{SSV_NAMESPACE}}}ParameterSet":
        raise InputError(f"{path}: not an SSP parameter set (the root element is {root.tag})")
    try:
        entries = _up_to_date(dict(_entries(root)))
        _check_effects(entries, path.parent)
        return ParameterSet(entries, root.get("name", path.stem)).validate()
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _check_effects(entries: Mapping, folder: Path) -> None:
    """Refuse a set with effects that are not in the chain, whose files lie beside it."""
    known = {name.split(".")[0] for name in load_table().parameters()}
    others = dict.fromkeys(name.split(".")[0] for name in entries if "." in name)
    missing = [e for e in others if e not in known and (folder / f"{e}.py").is_file()]
    if missing:
        files = " ".join(f"--effect {folder / e}.py" for e in missing)
        raise InputError(f"needs effects of your own, {', '.join(missing)}; name their files: {files}")


def _up_to_date(entries: dict[str, Any]) -> dict[str, Any]:
    """Return the entries of a file without what older versions wrote and nothing depends on."""
    outdated = load_table().outdated
    for name, old in outdated.items():
        if name in entries and any(entry.startswith(f"{old['group']}[") for entry in entries):
            raise InputError(f"{name!r} {old['reason']}")
    return {name: value for name, value in entries.items() if name not in outdated}


def _entries(root: etree._Element) -> Iterator[tuple[str, Any]]:
    """Yield name and value of every entry of an SSV document, in SI units."""
    known = load_table().parameters()
    seen = set()
    for parameter in root.iter(f"{{{SSV_NAMESPACE}}}Parameter"):
        name = parameter.get("name")
        if name is None:
            raise InputError(f"the parameter in line {parameter.sourceline} has no name")
        if name in seen:
            raise InputError(f"parameter {name!r} is given twice")
        seen.add(name)
        entry = next(parameter.iterchildren("{*}*"), None)  # elements, not comments
        if entry is None or entry.get("value") is None:
            raise InputError(f"parameter {name!r} has no value")
        value, unit = entry.get("value"), entry.get("unit")
        expected = known[name].type.unit if name in known else unit
        if unit is not None and unit != expected:
            raise InputError(f"parameter {name!r} is in {unit!r}; it must be in {expected!r}")
        if etree.QName(entry).localname == "Boolean":
            value = {"true": True, "1": True, "false": False, "0": False}.get(value, value)
        yield name, value
