"""C headers generated from the variable table and a parameter set.

`fmu_table.h` is the table itself, `fmu_places.h` where inputs and outputs are, `fmu_table_hash.h` what
the GUIDs begin with, `fmu_start.h` a parameter set compiled in, `chain_table.h` the places of the
parameters for Python, `controller_table.h` and `controller_start.h` the same for the controller. The
CMake build and the packager write them.

Only the standard library is used: an isolated build has no other packages.
"""

import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from it2hys.model.ssv import format_set
from it2hys.model.variables import (
    INDEXED,
    MODELS,
    TABLE_1,
    Table,
    Variable,
    load_controller,
    load_table,
)

BASES = {"Real": "FMU_REAL", "Integer": "FMU_INTEGER", "Boolean": "FMU_BOOLEAN"}
#: Room in the layer (fmu_src/fmi/fmu.h) for a model's inputs, Real outputs and Boolean outputs.
ROOM = {("input", "Real"): 4, ("output", "Real"): 2, ("output", "Boolean"): 2}
GENERATED = "/* Generated from {} by codegen.py. */"


def fnv1a(data: bytes) -> int:
    """Return the 64-bit FNV-1a hash, as fmu_hash of fmu_src/fmi does."""
    value = 14695981039346656037
    for byte in data:
        value = (value ^ byte) * 1099511628211 % 2**64
    return value


def table_hash(model: str) -> int:
    """Return the hash of one model's variables: the first half of its GUIDs."""
    rows = [
        (v.name, v.value_reference, v.causality, v.variability, v.type.name, v.type.base)
        for v in load_table().variables
        if model in v.models
    ]
    return fnv1a(repr((model, rows, *load_table().own)).encode())


def parameters_hash(ssv: str) -> int:
    """Return the hash of a set's SSV text: the second half of the GUIDs."""
    return fnv1a(ssv.encode())


def guid(model: str, ssv: str) -> str:
    """Return the GUID of a packaged FMU: which variables, and which parameter set, as SSV text."""
    digits = f"{table_hash(model):016x}{parameters_hash(ssv):016x}"
    parts = digits[:8], digits[8:12], digits[12:16], digits[16:20], digits[20:]
    return "{" + "-".join(parts) + "}"


def parameter_path(name: str) -> str:
    """Return a parameter's place in `struct chain_parameters`: C indices start at 0."""
    if match := INDEXED.fullmatch(name):
        return f"{match['group']}[{int(match['index']) - 1}].{match['field']}"
    return name


def places(variables: Sequence[Variable]) -> dict[tuple[str, str], int]:
    """Return the place of each input and output, by causality and name: their order in each model.

    What several models have is at the same place in each.
    """
    found: dict[tuple[str, str], int] = {}
    for model in sorted({m for v in variables for m in v.models}):
        for (causality, base), room in ROOM.items():
            own = [
                v
                for v in variables
                if model in v.models and (v.causality, v.type.base) == (causality, base)
            ]
            for place, variable in enumerate(own):
                assert place < room, f"{model} has more {causality}s than the layer has room for"
                assert found.setdefault((causality, variable.name), place) == place, variable.name
    return found


def table_rows(variables: Sequence[Variable], struct: str, counts: Mapping[str, str]) -> list[str]:
    """Return the rows of a `struct fmu_variable[]`: one per value reference.

    Parameters
    ----------
    variables : sequence of Variable
        All of the table, in the order of their value references.
    struct : str
        Struct of the parameters.
    counts : mapping
        Name of the parameter that says how many elements of a group are in use, by group.
    """
    place = places(variables)
    rows = []
    for v in variables:
        kinds = " | ".join(f"FMU_{model.upper()}" for model in v.models)
        low, high = (v.type.min or 0, v.type.max or 0)
        offset = f"offsetof(struct {struct}, {parameter_path(v.name)})"
        if v.causality != "parameter":
            member = "flag" if v.type.base == "Boolean" else "real"
            index = place[v.causality, v.name]
            offset = (
                f"{index} * sizeof(double)"
                if v.causality == "input"
                else f"offsetof(struct fmu_outputs, {member}[{index}])"
            )
        count = f"offsetof(struct {struct}, {counts[v.group]}), {v.index}" if v.group else "0, 0"
        stride = len({w.field for w in variables if w.group == v.group}) if v.group else 0
        rows.append(
            f'    {{ "{v.name}", {BASES[v.type.base]}, FMU_{v.causality.upper()}, {kinds}, {offset}, '
            f"{low!r}, {high!r}, {count}, {stride} }},"
        )
    return rows


def place_lines(variables: Sequence[Variable]) -> list[str]:
    """Return C lines that name the places of inputs and outputs, and the number of rows."""
    lines = []
    for (causality, name), place in places(variables).items():
        words = re.sub("([A-Z])", r"_\1", name).upper()
        lines.append(f"#define {'IN' if causality == 'input' else 'OUT'}_{words} {place}")
    return [*lines, f"#define FMU_TABLE_ROWS {len(variables)}"]


def input_start(variables: Sequence[Variable], model: str) -> str:
    """Return the C initialiser of a model's inputs."""
    starts = [repr(v.start) for v in variables if model in v.models and v.causality == "input"]
    return "{ " + ", ".join(starts) + " }"


def table_header(table: Table) -> str:
    """Return `fmu_table.h`: a row per value reference."""
    counts = {group: entry["variable"] for group, entry in table.counts.items()}
    return "\n".join(
        [
            GENERATED.format("variables.toml"),
            "const struct fmu_variable actuator_table[] = {",
            *table_rows(table.variables, "chain_parameters", counts),
            "};",
            "",
        ]
    )


def places_header(table: Table) -> str:
    """Return `fmu_places.h`: where inputs and outputs are, and the inputs' start values."""
    return "\n".join(
        [
            GENERATED.format("variables.toml"),
            "#ifndef IT2HYS_FMU_PLACES_H",
            "#define IT2HYS_FMU_PLACES_H",
            *place_lines(table.variables),
            *(f"#define FMU_{m.upper()}_INPUT_START {input_start(table.variables, m)}" for m in MODELS),
            "#endif",
            "",
        ]
    )


def controller_headers() -> dict[str, str]:
    """Return `controller_table.h` and `controller_start.h`: the same for the controller."""
    table = load_controller()
    digits = re.sub("[{}-]", "", table.guid)
    first = GENERATED.format("controller.toml")
    start = {v.name: v.start for v in table.variables if v.causality == "parameter"}
    return {
        "controller_table.h": "\n".join(
            [
                first,
                "enum { FMU_CONTROLLER = 1 };",
                "static const struct fmu_variable CONTROLLER_TABLE[] = {",
                *table_rows(table.variables, "pi_parameters", {}),
                "};",
                *place_lines(table.variables),
                f"#define FMU_INPUT_START {input_start(table.variables, 'controller')}",
                f"#define FMU_TABLE_HASH 0x{digits[:16]}u",
                "",
            ]
        ),
        "controller_start.h": "\n".join(
            [
                first,
                f"#define FMU_START_HASH 0x{digits[16:]}u",
                "static const struct pi_parameters FMU_START = {",
                *initialisers(start),
                "};",
                "",
            ]
        ),
    }


def chain_table_header(table: Table) -> str:
    """Return `chain_table.h`: where in `struct chain_parameters` each parameter lies."""
    rows = [
        f'    {{ "{v.name}", offsetof(struct chain_parameters, {parameter_path(v.name)}), '
        f"{int(v.type.base != 'Real')} }},"
        for v in table.parameters().values()
    ]
    return "\n".join(
        [
            GENERATED.format("variables.toml"),
            "static const struct { const char *name; size_t offset; int integer; } CHAIN_TABLE[] = {",
            *rows,
            "};",
            "",
        ]
    )


def hash_header() -> str:
    """Return `fmu_table_hash.h`."""
    lines = [f"#define FMU_TABLE_HASH_{m.upper()} 0x{table_hash(m):016x}u" for m in MODELS]
    return "\n".join([GENERATED.format("variables.toml"), *lines, ""])


def start_header(parameters: Mapping, ssv: str) -> str:
    """Return `fmu_start.h`: a parameter set as a C initialiser, and the hash of its SSV text."""
    return "\n".join(
        [
            "/* A parameter set, generated by codegen.py. */",
            f"#define FMU_START_HASH 0x{parameters_hash(ssv):016x}u",
            "static const struct chain_parameters FMU_START = {",
            *initialisers(parameters),
            "};",
            "",
        ]
    )


def initialisers(parameters: Mapping, real: str = "{!r}") -> Iterator[str]:
    """Yield the lines of a C initialiser of `struct chain_parameters`; `real` formats its reals."""
    for name, value in parameters.items():
        number = real.format(value) if isinstance(value, float) else repr(int(value))
        yield f"    .{parameter_path(name)} = {number},"


def write_headers(directory: Path) -> None:
    """Write all generated headers into a directory, with Table 1 as the parameter set."""
    start = load_table().start()
    headers = {
        "fmu_table.h": table_header(load_table()),
        "fmu_places.h": places_header(load_table()),
        "fmu_table_hash.h": hash_header(),
        "chain_table.h": chain_table_header(load_table()),
        "fmu_start.h": start_header(start, format_set(start, TABLE_1)),
        **controller_headers(),
    }
    directory.mkdir(parents=True, exist_ok=True)
    for name, text in headers.items():
        (directory / name).write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    write_headers(Path(sys.argv[1]))
