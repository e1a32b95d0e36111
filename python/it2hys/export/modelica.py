"""Parameter records for the Modelica library, generated from the variable table.

`Parameters/Base.mo` declares what the table declares, `Parameters/Table1.mo` holds the paper's
values, `Internal/Values.mo` hands all of them to the C sources, `Internal/checkBounds.mo` holds them
to the table's bounds, and `format_record` writes any parameter set as a record beside those.
Structured names become vectors: ``rule[2].centre`` is ``ruleCentre[2]``, ``lag.timeConstant`` is
``lagTimeConstant``.
The library also holds the C sources of the FMUs, because a tool that compiles them has the library
only, not this repository. After a change of the table or of the C sources,
``python -m it2hys.export.modelica modelica/IT2Hysteresis`` brings the library up to date.
"""

import re
import sys
from html import escape
from itertools import groupby
from pathlib import Path

from it2hys.errors import InputError
from it2hys.model.compiled import native_directory
from it2hys.model.parameters import ParameterSet, table_1
from it2hys.model.stages import own_effects
from it2hys.model.variables import DeclaredType, Variable, load_table
from it2hys.support.files import write_atomically

LIBRARY_VERSION = "0.1.0"
PACKAGE = "IT2Hysteresis.Parameters"
INTERNAL = "IT2Hysteresis.Internal"
C_SOURCES = "Resources/C-Sources"
START = "initialDisplacement"

#: The chain, the layer and the models, as one C file (`it2hys.fmu.amalgamation`).
SOURCES = ("it2hys.h", "it2hys.c")

#: Quantities of the table that `Modelica.Units.SI` has a type for, of the same name and unit.
SI_QUANTITIES = {
    "ElectricPotential",
    "Force",
    "Frequency",
    "Length",
    "ThermodynamicTemperature",
    "Time",
}


def format_record(parameters: ParameterSet, name: str, within: str | None = None) -> str:
    """Return a parameter set as a Modelica record.

    Parameters
    ----------
    parameters : ParameterSet
        The set; numbers are written with the fewest digits that read back to the same bits.
    name : str
        Name of the record. It begins with a capital letter, as the names of Modelica classes do.
    within : str, optional
        Package that the record belongs to; by default it stands alone and says which version of
        the library it uses.

    Raises
    ------
    InputError
        If the name is not a class name.
    """
    if not re.fullmatch(r"[A-Z][A-Za-z0-9_]*", name):
        raise InputError(
            f"{name!r} is not a name for a Modelica record; "
            "use letters, digits and underscores, a capital letter first"
        )
    modifiers = [f"    {field}={value}" for field, value in _values(parameters).items()]
    annotations = ['defaultComponentPrefixes="parameter"']
    if within is None:
        annotations.append(f"uses(IT2Hysteresis(version={_string(LIBRARY_VERSION)}))")
    info = (
        f"<p>\nThe parameter set <em>{escape(parameters.name)}</em>, written by it2hys. "
        "Numbers are in SI units.\n</p>"
    )
    return _record(
        name,
        f"Parameter set {parameters.name}",
        [f"  extends {PACKAGE}.Base(", ",\n".join(modifiers) + ");"],
        [*annotations, _documentation(info)],
        within,
    )


def format_base() -> str:
    """Return the record that every parameter set extends: the table's parameters, declared."""
    parameters = load_table().parameters().values()
    example = next(v.name for v in _rows() if v.effect and v.group is None)
    counted = ", ".join(
        f"<code>{field(count)}</code> is that of <code>{_first(group)}</code>"
        for count, group in _counts().items()
    )
    info = (
        "<p>\nWhat identifies an actuator, plant and inverse alike. Names are those of the FMUs'\n"
        "parameters, with a vector for every column of a structured one: "
        "<code>ruleCentre[l]</code>\nis the FMUs' <code>rule[l].centre</code>, "
        f"<code>{field(example)}</code> their <code>{example}</code>.\n"
        "There are no rules by default, and effects are off, see\n"
        '<a href="modelica://IT2Hysteresis.UsersGuide.Effects">Effects</a>.\n</p>\n'
        "<p>\nHow many rules, play operators and creep terms there are follows from the lengths of\n"
        f"their vectors: {counted}.\nVectors that belong together are of one length; "
        "blocks refuse a set where they are not.\n</p>"
    )
    return _record(
        "Base",
        "Parameters of plant and inverse",
        [
            "  extends Modelica.Icons.Record;",
            *(_declaration(v) for v in parameters if v.index in (None, 1)),
        ],
        ['defaultComponentPrefixes="parameter"', _documentation(info)],
        PACKAGE,
    )


def format_values() -> str:
    """Return the record that makes one vector of a set, which the C sources read by the same table.

    It is no function: rumoca, in which the library is tested, hands none to a function of which a field
    says how long a vector is.
    """
    start = load_table().parameters()[START].type
    arguments, sizes, wanted, numbers = [], [], [], 0
    for group, members in groupby(_rows(), key=lambda v: v.group):
        names = [_value_of(v) for v in members]
        numbers += len(names)  # of a vector, its length
        if group is None:
            arguments.append("{" + ",\n        ".join(names) + "}")
        for name in names if group else ():
            arguments += [f"{{1.0*size({name}, 1)}}", name]
            sizes.append(f"size({name}, 1)")
            wanted.append(f"size({names[0]}, 1)")
    info = (
        "<p>\nWhat the constructors of the external objects take: the parameters in the order of\n"
        f'<a href="modelica://{PACKAGE}.Base">Base</a>, a vector behind the number of its elements.\n'
        "The C sources read them by the table that this is generated from.\n</p>"
    )
    return _record(
        "Values",
        "All parameters of a set as one vector",
        [
            "  extends Modelica.Icons.Record;",
            f'  parameter {PACKAGE}.Table1 parameters "Parameter set";',
            f"  parameter {_type(start)} {START}{_attributes(start, '')}=parameters.{START}",
            '    "Displacement before the first tick, which a block may choose";',
            f"  final parameter Real vector[{_sum(numbers, sizes)}]=",
            "    cat(",
            "      1,",
            ",\n".join(f"      {argument}" for argument in arguments) + ")",
            '    "Numbers in SI units";',
            # where a vector is too short, what says so would read beyond the end: rumoca refuses that
            f"  final parameter Integer needed={_sum(numbers, wanted)}",
            '    "Numbers that there are where vectors that belong together are of one length"',
            "    annotation (Evaluate=true);",
            f"  final parameter Real checked[needed]={INTERNAL}.resized(vector, needed)",
            '    "Those that checkBounds reads";',
        ],
        [_documentation(info)],
        INTERNAL,
    )


def _sum(number: int, sizes: list[str]) -> str:
    """Return the size of a vector; equal terms are taken together."""
    counted = [f"{sizes.count(size)}*{size}" for size in dict.fromkeys(sizes)]
    return "\n    " + " +\n    ".join([str(number), *(c.removeprefix("1*") for c in counted)])


def format_bounds() -> str:
    """Return the function that holds the vector of `Values` to the table's bounds, as the FMUs do.

    The blocks in pure Modelica call it. An effect of the user's own is C there is no Modelica of: where
    it is on, they stop and say which blocks have it.
    """
    counts = {group: name for name, group in _counts().items()}
    body, before, behind = [], 0, ""
    for group, members in groupby(_rows(), key=lambda v: v.group):
        if group is None:
            for variable in members:
                before += 1
                place = f"values[{before}{behind}]"
                body += _bound(variable, place, "", "  ")
                body += _only_in_fmus(variable, place)
            continue
        columns, count = list(members), field(counts[group])
        lengths, elements = [], [f"  for j in 1:{count} loop"]
        for k, variable in enumerate(columns):
            before += 1  # the number of elements
            place = f"{before}{behind}" + (f" + {k}*{count}" if k else "")
            lengths += (
                _length(variable, columns[0], count, f"values[{place}]")
                if k
                else _bound(load_table().parameters()[counts[group]], f"values[{place}]", "", "  ")
            )
            elements += _bound(variable, f"values[{place} + j]", "[j]", "    ")
        body += [*lengths, *elements, "  end for;"]
        behind += f" + {len(columns)}*{count}"
    info = (
        "<p>\nThe vector is <code>checked</code> of "
        f'<a href="modelica://{INTERNAL}.Values">Values</a>. Bounds and words are\nthose of the '
        "FMUs.\n</p>"
    )
    return _record(
        "checkBounds",
        "Stops with the reason where a parameter is beyond its bounds",
        [
            "  extends Modelica.Icons.Function;",
            '  input String name "Block that messages begin with";',
            '  input Real values[:] "All parameters, of Values";',
            *(
                f'  input Integer {field(count)} "{load_table().parameters()[count].description}";'
                for count in counts.values()
            ),
            "algorithm",
            *body,
        ],
        [_documentation(info)],
        INTERNAL,
        kind="function",
    )


def _bound(variable: Variable, value: str, index: str, indent: str) -> list[str]:
    """Return the assertion that a value is within the table's bounds; `[j]` is an element's index."""
    low, high = variable.type.min, variable.type.max
    name = field(variable.name) + ('[" + String(j) + "]' if index else "")
    return [
        f"{indent}assert({value} >= {low!r} and {value} <= {high!r},",
        f'{indent}  name + ": {name} is " + String({value}, significantDigits=6)',
        f'{indent}  + "; it must be {low:g} to {high:g}.");',
    ]


def _length(variable: Variable, first: Variable, count: str, value: str) -> list[str]:
    """Return the assertion that a vector is as long as the first of its group."""
    return [
        f"  assert(abs({value} - {count}) < 0.5,",
        f'    name + ": {field(variable.name)} has " + String({value}, significantDigits=6)',
        f'    + " elements and {field(first.name)} has " + String({count})',
        '    + "; they must have the same number.");',
    ]


def _only_in_fmus(variable: Variable, value: str) -> list[str]:
    """Return the assertion that an effect of the user's own is off, if the parameter switches one."""
    effect = own_effects().get(variable.effect or "")
    if effect is None or variable.name != effect.switch:
        return []
    return [
        f"  assert({value} == 0,",
        f'  name + ": the effect {effect.name} is on, which pure Modelica does not have; take "',
        '  + "IT2Hysteresis.Blocks.Plant and IT2Hysteresis.Blocks.Inverse, which hold the FMUs, "',
        f'  + "or set {field(variable.name)} to 0.");',
    ]


def _counts() -> dict[str, str]:
    """Return the group that a parameter counts the elements of, by the parameter's name."""
    return {entry["variable"]: group for group, entry in load_table().counts.items()}


def _first(group: str) -> str:
    """Return the vector of a group that says how many elements there are: the table's first."""
    return next(field(v.name) for v in load_table().parameters().values() if v.group == group)


def _rows() -> list[Variable]:
    """Return the table's parameters but for the counts, of a group the first element only."""
    known = load_table().parameters()
    return [v for name, v in known.items() if v.index in (None, 1) and name not in _counts()]


def _value_of(variable: Variable) -> str:
    """Return a parameter's value as it stands in the vector of all."""
    if variable.name == START:
        return START
    return f"parameters.{field(variable.name)}"


def write_record(parameters: ParameterSet, directory: Path) -> Path:
    """Write a set as a record class of its own into a directory, which exists; return the file.

    The class is named after the set: ``my stage 2`` gives ``MyStage2.mo``.
    """
    name = class_name(parameters.name)
    path = directory / f"{name}.mo"
    write_atomically(path, format_record(parameters, name).encode())
    return path


def class_name(text: str) -> str:
    """Return a Modelica class name made from any text: its words, joined, a capital letter first."""
    words = re.findall(r"[A-Za-z0-9]+", text)
    joined = "".join(word[0].upper() + word[1:] for word in words)
    return joined if joined[:1].isalpha() else f"Set{joined}"


def write_library(directory: Path) -> None:
    """Write what is generated of the library whose `package.mo` is in `directory`."""
    for place, content in generated_files().items():
        (directory / place).parent.mkdir(parents=True, exist_ok=True)
        write_atomically(directory / place, content)


def generated_files() -> dict[str, bytes]:
    """Return records and C sources by their place in the library."""
    native = native_directory()
    copies = [*(native / "sources" / name for name in SOURCES), native / "LICENSE"]
    return {
        "Parameters/Base.mo": format_base().encode(),
        "Internal/Values.mo": format_values().encode(),
        "Internal/checkBounds.mo": format_bounds().encode(),
        "Parameters/Table1.mo": format_record(table_1(), "Table1", PACKAGE).encode(),
        **{f"{C_SOURCES}/{path.name}": path.read_bytes() for path in copies},
    }


def field(name: str) -> str:
    """Return a parameter's name in the record: ``resonance.frequency`` is ``resonanceFrequency``."""
    first, *others = re.sub(r"\[\d+\]", "", name).split(".")
    return first + "".join(part[0].upper() + part[1:] for part in others)


def _values(parameters: ParameterSet) -> dict[str, str]:
    """Return the values by their name in the record, structured parameters as vectors, no counts."""
    known = load_table().parameters()
    scalars: dict[str, str] = {}
    vectors: dict[str, list[str]] = {}
    for name, value in parameters.items():
        if name in _counts():
            continue
        text = _literal(value)
        if known[name].group is None:
            scalars[field(name)] = text
        else:
            vectors.setdefault(field(name), []).append(text)
    return scalars | {name: "{" + ", ".join(texts) + "}" for name, texts in vectors.items()}


def _declaration(variable: Variable) -> str:
    """Return the declaration of a parameter, or of a vector of them for a group's first element."""
    prefix, size, start = "", "", f"={_literal(variable.start)}"
    if variable.group is not None:
        # its length follows from what it is bound to, which a tool must find even where there is none
        size, start = "[:]", "=fill(0.0, 0)"
    group = _counts().get(variable.name)
    if group is not None:
        prefix, start = "final ", f"=size({_first(group)}, 1)"
    attributes = _attributes(variable.type, each="each " if size else "")
    annotations = _place_in_dialog(variable)
    if group is not None:
        annotations.append("Evaluate=true")
    annotation = f"\n    annotation ({', '.join(annotations)})" if annotations else ""
    return (
        f"  {prefix}parameter {_type(variable.type)} {field(variable.name)}{size}{attributes}{start}\n"
        f"    {_string(variable.description)}{annotation};"
    )


def _place_in_dialog(variable: Variable) -> list[str]:
    """Return the annotation that groups parameters in a tool's dialog, if there is any."""
    if variable.effect:
        return [f'Dialog(tab="Effects", group={_string(variable.effect.capitalize())})']
    return [f"Dialog(group={_string(variable.group.capitalize())})"] if variable.group else []


def _type(kind: DeclaredType) -> str:
    """Return the Modelica type, that of `Modelica.Units.SI` where there is one."""
    return f"Modelica.Units.SI.{kind.quantity}" if kind.quantity in SI_QUANTITIES else kind.base


def _attributes(kind: DeclaredType, each: str) -> str:
    """Return the modification of the attributes that the Modelica type does not set."""
    own = {}
    if kind.quantity not in SI_QUANTITIES:
        own = {"final quantity": kind.quantity, "final unit": kind.unit}
    own |= {name: getattr(kind, name) for name in ("displayUnit", "min", "max", "nominal")}
    lines = [f"\n    {each}{name}={_literal(v)}" for name, v in own.items() if v is not None]
    return f"({','.join(lines)})" if lines else ""


def _literal(value: float | int | bool | str | None) -> str:
    """Return a Modelica literal."""
    if isinstance(value, str):
        return _string(value)
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _string(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _documentation(info: str) -> str:
    revisions = f"<p>\nWritten for version {LIBRARY_VERSION} of the library.\n</p>"
    info, revisions = (_string(f"<html>\n{html}\n</html>") for html in (info, revisions))
    return f"Documentation(info={info},\n      revisions={revisions})"


def _record(
    name: str,
    description: str,
    elements: list[str],
    annotations: list[str],
    within: str | None,
    kind: str = "record",
) -> str:
    """Return the text of a class, a record by default."""
    return "\n".join(
        [
            *([f"within {within};"] if within else []),
            f"{kind} {name} {_string(description)}",
            *elements,
            "  annotation (",
            ",\n".join(f"    {annotation}" for annotation in annotations) + ");",
            f"end {name};",
            "",
        ]
    )


if __name__ == "__main__":
    write_library(Path(sys.argv[1]))
