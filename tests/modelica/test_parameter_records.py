"""The generated records: one table, nothing typed twice."""

import re
from pathlib import Path

import pytest
from conftest import make_set
from effects import with_effects
from library import CLASSES, LIBRARY

from it2hys.errors import InputError
from it2hys.export.modelica import (
    C_SOURCES,
    LIBRARY_VERSION,
    class_name,
    field,
    format_base,
    format_record,
    generated_files,
    write_library,
)
from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import table_1
from it2hys.model.variables import load_table

#: Groups by the parameter that counts their elements.
COUNTS = {entry["variable"]: group for group, entry in load_table().counts.items()}


def test_the_committed_files_are_the_generated_ones():
    stale = [
        place
        for place, content in generated_files().items()
        if not (LIBRARY / place).is_file() or (LIBRARY / place).read_bytes() != content
    ]
    assert not stale, "run `python -m it2hys.export.modelica modelica/IT2Hysteresis`"


def test_the_c_sources_are_the_generated_ones_and_the_glue():
    present = {f"{C_SOURCES}/{p.name}" for p in (LIBRARY / C_SOURCES).iterdir()}
    assert present - set(generated_files()) == {f"{C_SOURCES}/IT2Hysteresis.h"}


def test_the_library_is_written_where_there_is_none_yet(tmp_path):
    write_library(tmp_path / "IT2Hysteresis")
    for place, content in generated_files().items():
        assert (tmp_path / "IT2Hysteresis" / place).read_bytes() == content


def test_every_parameter_is_declared_with_unit_and_bounds():
    declarations = re.findall(r"^  (?:final )?parameter .*?;$", format_base(), re.MULTILINE | re.DOTALL)
    rows = {re.sub(r"\[\d+\]", "", n): v for n, v in load_table().parameters().items()}
    assert len(declarations) == len(rows)
    for declaration, variable in zip(declarations, rows.values(), strict=True):
        kind = variable.type
        assert f" {field(variable.name)}" in declaration
        assert f'"{variable.description}"' in declaration
        assert f"min={kind.min!r}" in declaration
        assert f"max={kind.max!r}" in declaration
        assert "Units.SI." in declaration or not kind.unit or f'unit="{kind.unit}"' in declaration
        assert not kind.displayUnit or f'displayUnit="{kind.displayUnit}"' in declaration


@pytest.mark.parametrize("parameters", [make_set(7, 4), with_effects(tuple(EFFECTS), seed=1)])
def test_a_record_reads_back_to_the_same_bits(parameters):
    text = format_record(parameters, "Stage")
    columns: dict[str, list] = {}
    for name, value in parameters.items():
        if name in COUNTS:
            assert field(name) not in text, "it follows from the vectors"
        elif "[" in name:
            columns.setdefault(field(name), []).append(value)
        else:
            assert float(re.search(rf"\b{field(name)}=([^,)]+)", text)[1]) == value
    for name, values in columns.items():
        numbers = re.search(rf"\b{name}={{([^}}]+)}}", text)[1].split(", ")
        assert [float(n) for n in numbers] == values


@pytest.mark.parametrize("count", COUNTS)
def test_a_count_is_the_length_of_its_vectors_and_nothing_that_is_given(count):
    declared = rf"^  final parameter Integer {count}\([^)]*\)=size\((\w+), 1\)$"
    (first,) = re.findall(declared, format_base(), re.MULTILINE)
    group = COUNTS[count]
    vectors = re.findall(rf"^  parameter [\w.]+ ({group}[A-Z]\w*)\[:\]\(", format_base(), re.MULTILINE)
    assert first == vectors[0] and len(vectors) > 1
    # what reads a record reads the vectors: for a set given as parameters=Mine(...), OpenModelica took
    # final elements from the type's own defaults (its issue 16142)
    assert not [n for n, f in CLASSES.items() if re.search(rf"\w\.{count}\b", without_chain(f))]


def without_chain(file: Path) -> str:
    """Return a class without what it reads from `Internal.Constants`, which has counts of its own."""
    return re.sub(r"\bchain\.\w+", "", file.read_text(encoding="utf-8"))


def test_a_record_of_its_own_says_what_it_uses():
    text = format_record(table_1(), "Stage")
    assert text.startswith('record Stage "')
    assert f'uses(IT2Hysteresis(version="{LIBRARY_VERSION}"))' in text
    assert format_record(table_1(), "Stage", "A.B").startswith('within A.B;\nrecord Stage "')


def test_a_name_of_a_set_may_hold_anything():
    text = format_record(make_set(1, 1, 'a "set" <&> \\ of µm'), "Stage")
    assert r'record Stage "Parameter set a \"set\" <&> \\ of µm"' in text
    assert r"a &quot;set&quot; &lt;&amp;&gt; \\ of µm</em>" in text


@pytest.mark.parametrize("name", ["", "stage", "1Stage", "My Stage", "A.B", "Stäge", "end"])
def test_a_name_that_is_no_class_name_is_refused(name):
    with pytest.raises(InputError, match="capital letter"):
        format_record(table_1(), name)


@pytest.mark.parametrize(
    ("text", "name"),
    [("my stage 2", "MyStage2"), ("Table 1", "Table1"), ("20VS12-a", "Set20VS12A"), ("µ", "Set")],
)
def test_a_class_is_named_after_its_set(text, name):
    assert class_name(text) == name
    format_record(make_set(1, 1, text), name)
