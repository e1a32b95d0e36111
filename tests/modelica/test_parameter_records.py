"""The generated records: one table, nothing typed twice."""

import re

import pytest
from conftest import make_set
from library import LIBRARY

from it2hys.errors import InputError
from it2hys.modelica import LIBRARY_VERSION, format_base, format_record, write_library
from it2hys.parameters import table_1
from it2hys.variables import load_table


@pytest.mark.parametrize("name", ["Base", "Table1"])
def test_the_committed_records_are_the_generated_ones(name, tmp_path):
    (tmp_path / "Parameters").mkdir()
    write_library(tmp_path)
    place = f"Parameters/{name}.mo"
    assert (LIBRARY / place).read_bytes() == (tmp_path / place).read_bytes(), (
        "run `python -m it2hys.modelica modelica/IT2Hysteresis`"
    )


def test_every_parameter_is_declared_with_unit_and_bounds():
    declarations = re.findall(r"^  parameter .*?;$", format_base(), re.MULTILINE | re.DOTALL)
    rows = {re.sub(r"\[\d+\]", "", n): v for n, v in load_table().parameters().items()}
    rows = {n: v for n, v in rows.items() if v.effect is None}  # the library has no effects
    assert len(declarations) == len(rows)
    for declaration, variable in zip(declarations, rows.values(), strict=True):
        kind = variable.type
        assert f'"{variable.description}"' in declaration
        assert f"min={kind.min!r}" in declaration
        assert f"max={kind.max!r}" in declaration
        assert "Units.SI." in declaration or not kind.unit or f'unit="{kind.unit}"' in declaration
        assert not kind.displayUnit or f'displayUnit="{kind.displayUnit}"' in declaration


def test_a_record_reads_back_to_the_same_bits():
    parameters = make_set(7, 4)
    text = format_record(parameters, "Stage")
    for name, value in parameters.items():
        if "[" not in name and load_table().parameters()[name].effect is None:
            assert float(re.search(rf"\b{name}=([^,)]+)", text)[1]) == value
    for column, field in enumerate(("SigmaLower", "SigmaUpper", "Centre", "Q1", "Q2", "Q3")):
        numbers = re.search(rf"rule{field}={{([^}}]+)}}", text)[1].split(", ")
        assert [float(n) for n in numbers] == list(parameters.rules[:, column])


def test_a_set_with_effects_is_refused():
    with pytest.raises(InputError, match="no effects; this set has lag"):
        format_record(table_1().replace(**{"lag.timeConstant": 1e-3}), "Stage")


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
