"""Parameter sets: what is accepted, what is refused and how it is told, and the SSV file."""

import os
import tempfile
from pathlib import Path

import numpy as np
import pytest
from conftest import make_set, parameter_sets
from fmpy.ssp import ssd
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from it2hys.errors import InputError
from it2hys.model.parameters import (
    RULE_FIELDS,
    SSV_NAMESPACE,
    ParameterSet,
    format_ssv,
    read_ssv,
    table_1,
    write_ssv,
)
from it2hys.model.variables import load_table

PAPER = np.array(
    [
        [4.3427, 17.8879, 0.0892, 0.8943, 0.0196, 1.7504],
        [2.5647, 11.5798, 8.6067, 0.9140, 0.0129, 0.8773],
        [2.1349, 19.8162, 18.7381, 1.1882, 0.0148, -6.2312],
    ]
)  # um and V, columns s1, s2, c, q1, q2, q3


def table_1_with(**changes: object) -> dict:
    """Return Table 1's values with some changed; ``None`` leaves one out; `_` is a full stop."""
    values = dict(table_1())
    for name, value in changes.items():
        name = name.replace("rule1_", "rule[1].").replace("rule2_", "rule[2].")
        values[name] = value
        if value is None:
            del values[name]
    return values


# --- what a set holds --------------------------------------------------------------------------


def test_table_1_is_the_papers_in_si_units():
    si = PAPER * np.array([1e-6, 1e-6, 1e-6, 1.0, 1e-6, 1e-6])
    np.testing.assert_allclose(table_1().rules, si, rtol=1e-15)
    assert table_1().validate().counts == {"rule": 3, "play": 0, "creep": 0}
    assert table_1()["sampleTime"] == 1e-4


def test_scalars_that_are_not_given_take_the_tables_start():
    rules_only = {n: v for n, v in table_1().items() if n.startswith("rule[")}
    assert dict(ParameterSet(rules_only)) == dict(table_1())


@pytest.mark.parametrize("count", [1, 2, 3, 5, 16])
def test_from_rules_gives_the_rules_back(count):
    parameters = make_set(count, count)
    again = ParameterSet.from_rules(parameters.rules)
    assert np.array_equal(again.rules, parameters.rules)
    assert again["ruleCount"] == again.counts["rule"] == count
    elements = 6 * (16 - count) + 2 * 32 + 2 * 16  # rules, play operators, creep terms not there
    assert len(again) == len(load_table().parameters()) - elements


def test_replace_changes_one_value_and_leaves_the_original():
    original = table_1()
    changed = original.replace(initialDisplacement=1e-6)
    assert changed["initialDisplacement"] == 1e-6
    assert original["initialDisplacement"] == 0.0
    assert {**changed, "initialDisplacement": 0.0} == dict(original)


def test_integers_stay_integers_and_reals_become_floats():
    parameters = ParameterSet(table_1_with(ruleCount="3", voltageMax=np.float32(120)))
    assert (type(parameters["ruleCount"]), parameters["ruleCount"]) == (int, 3)
    assert (type(parameters["voltageMax"]), parameters["voltageMax"]) == (float, 120.0)


# --- what is refused ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "phrase"),
    [
        ({"sampletime": 1e-3}, "unknown parameter 'sampletime'; did you mean 'sampleTime'?"),
        ({"rule1_sigma": 1e-6}, "unknown parameter 'rule[1].sigma'; did you mean 'rule[1].sigma"),
        ({"rule[17].q1": 0.5}, "unknown parameter 'rule[17].q1'; did you mean 'rule["),
        ({"xyz": 1.0}, "unknown parameter 'xyz'; `variables.toml` lists the known ones"),
        ({"rule2_q3": None}, "parameter 'rule[2].q3' is missing; a set with 3 rules must give all"),
        ({"ruleCount": 4}, "parameter 'rule[4].sigmaLower' is missing"),
        ({"ruleCount": 2}, "parameter 'rule[3].sigmaLower' is given, but ruleCount is 2"),
        ({"ruleCount": 2.5}, "ruleCount is 2.5; it must be a whole number"),
        ({"ruleCount": 0}, "ruleCount is 0; it must be 1 to 16"),
        ({"ruleCount": 17}, "ruleCount is 17; it must be 1 to 16"),
        ({"rule1_sigmaLower": 0.0}, "rule[1].sigmaLower is 0 m; it must be 1e-12 to 1 m"),
        ({"rule1_sigmaLower": -1e-6}, "rule[1].sigmaLower is -1e-06 m; it must be 1e-12"),
        ({"rule2_centre": 4.3427}, "rule[2].centre is 4.3427 m; it must be -0.1 to 0.1 m"),
        ({"sampleTime": 0.0}, "sampleTime is 0 s; it must be 1e-09 to 1000 s"),
        ({"rule1_q1": float("nan")}, "rule[1].q1 is nan; it must be a finite number"),
        ({"voltageMax": float("inf")}, "voltageMax is inf; it must be a finite number"),
        ({"voltageMax": 10**400}, "voltageMax"),
        ({"rule1_q1": "much"}, "rule[1].q1 is 'much'; it must be a number"),
        ({"rule1_q1": [1.0]}, "rule[1].q1 is [1.0]; it must be a number"),
    ],
)
def test_values_that_cannot_be_are_refused_by_name(changes, phrase):
    with pytest.raises(InputError) as refusal:
        ParameterSet(table_1_with(**changes))
    assert phrase in str(refusal.value)


def test_a_set_without_rules_is_refused():
    with pytest.raises(InputError, match=r"no parameter rule\[1\].* is given; a model needs"):
        ParameterSet({"sampleTime": 1e-4})


@pytest.mark.parametrize(
    ("changes", "phrases"),
    [
        (
            {"rule1_sigmaLower": 18e-6},
            ["rule[1].sigmaUpper is 1.78879e-05, below rule[1].sigmaLower", "swapped"],
        ),
        ({"voltageMin": 110.0}, ["voltageMin, 110 V, must be below voltageMax, 110 V"]),
        ({"displacementMin": 20e-6}, ["displacementMin, 2e-05, must be below displacementMax"]),
        (
            {f"rule[{i}].q2": -1e-8 for i in (1, 2, 3)},
            ["rule[].q2", "not positive", "cannot be inverted", "displacementMin"],
        ),
        ({"displacementMax": 25e-6}, ["contraction", "must be below 1", "displacementMax"]),
        ({"rule2_q1": 1.2}, ["contraction", "must be below 1", "rule[].q1"]),
    ],
)
def test_models_that_cannot_be_used_are_refused_with_the_mend(changes, phrases):
    parameters = ParameterSet(table_1_with(**changes))
    with pytest.raises(InputError) as refusal:
        parameters.validate()
    for phrase in phrases:
        assert phrase in str(refusal.value)


def test_the_column_order_of_the_papers_text_is_refused():
    """Read as (c, s1, s2), Table 1 has its lower membership above the upper one."""
    reordered = table_1().rules[:, [1, 2, 0, 3, 4, 5]]
    with pytest.raises(InputError, match=r"rule\[1\].sigmaUpper .* below rule\[1\].sigmaLower"):
        ParameterSet.from_rules(reordered).validate()


# --- the SSV file ------------------------------------------------------------------------------


@given(parameter_sets())
def test_a_set_survives_the_file_bit_for_bit(tmp_path_factory, parameters):
    path = tmp_path_factory.getbasetemp() / "round-trip.ssv"
    write_ssv(parameters, path)
    again = read_ssv(path)
    assert dict(again) == dict(parameters)
    assert again.rules.tobytes() == parameters.rules.tobytes()
    assert again.name == parameters.name
    assert format_ssv(again) == path.read_text(encoding="utf-8")


@given(
    st.text(st.characters(min_codepoint=32, exclude_categories=["Cs", "Cn", "Cc", "Co"]), min_size=1)
)
def test_any_name_survives_the_file(tmp_path_factory, name):
    path = tmp_path_factory.getbasetemp() / "name.ssv"
    write_ssv(ParameterSet(dict(table_1()), name), path)
    assert read_ssv(path).name == name


@pytest.mark.parametrize("count", [1, 3, 16])
def test_fmpy_reads_the_file_and_finds_it_valid_against_the_standards_schema(tmp_path, count):
    parameters = make_set(count, count)
    path = tmp_path / "p.ssv"
    write_ssv(parameters, path)
    read = ssd.read_ssv(str(path), validate=True)  # against SystemStructureParameterValues.xsd
    known = load_table().parameters()
    assert {p.name: float(p.value) for p in read.parameters} == dict(parameters)
    assert {p.name: p.type for p in read.parameters} == {n: known[n].type.base for n in parameters}
    for entry in read.parameters:
        assert entry.type != "Real" or entry.unit == known[entry.name].type.unit


def test_the_file_keeps_to_the_profile_that_common_masters_read():
    text = format_ssv(table_1())
    root = etree.fromstring(text.encode())
    assert "<ssv:ParameterSet " in text
    assert root.nsmap == {"ssv": SSV_NAMESPACE}
    assert root.get("version") == "1.0"
    kinds = {etree.QName(entry).localname for entry in root.iterfind(".//ssv:Parameter/*", root.nsmap)}
    assert kinds == {"Real", "Integer"}
    assert {e.get("name") for e in root.iter(f"{{{SSV_NAMESPACE}}}Parameter")} == set(table_1())


def edited(tmp_path: Path, old: str, new: str) -> Path:
    """Write Table 1's file with one text replaced by another."""
    text = format_ssv(table_1())
    assert old in text
    path = tmp_path / "edited.ssv"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return path


ENTRY = """<ssv:Parameter name="voltageMin">
      <ssv:Real value="0.0" unit="V"/>
    </ssv:Parameter>"""


@pytest.mark.parametrize(
    ("old", "new", "phrase"),
    [
        ('unit="m/V"', 'unit="um/V"', "parameter 'rule[1].q2' is in 'um/V'; it must be in 'm/V'"),
        (ENTRY, ENTRY + ENTRY, "parameter 'voltageMin' is given twice"),
        ('value="0.0001" unit="s"', "", "parameter 'sampleTime' has no value"),
        ('value="0.0001"', 'value="1_0e-5"', "sampleTime is '1_0e-5'; it must be a number"),
        ('value="0.0001"', 'value="٠.٠٠٠١"', "sampleTime is '٠.٠٠٠١'; it must be a number"),
        ('value="0.0001"', 'value="１e-4"', "sampleTime is '１e-4'; it must be a number"),
        ('<ssv:Real value="110.0" unit="V"/>', "", "parameter 'voltageMax' has no value"),
        ('name="voltageMin"', 'name="voltagemin"', "unknown parameter 'voltagemin'; did you mean"),
        ('name="voltageMin"', "", "has no name"),
        ('value="110.0"', 'value="1,5e2"', "voltageMax is '1,5e2'; it must be a number"),
        ('value="110.0"', 'value="NaN"', "voltageMax is nan; it must be a finite number"),
        ('value="3"', 'value="3.5"', "ruleCount is 3.5; it must be a whole number"),
        ('value="4.3427e-06"', 'value="-1"', "rule[1].sigmaLower is -1 m; it must be"),
        ('value="1.6e-05"', 'value="2.5e-05"', "contraction"),
        ("</ssv:ParameterSet>", "", "not an XML file"),
        ("ssv:ParameterSet", "ssv:Parameters", "not an XML file"),
        (SSV_NAMESPACE, "http://example.org/", "not an SSP parameter set (the root element is"),
    ],
)
def test_an_unusable_file_is_refused_with_its_name_and_the_culprit(tmp_path, old, new, phrase):
    path = edited(tmp_path, old, new)
    with pytest.raises(InputError) as refusal:
        read_ssv(path)
    assert str(refusal.value).startswith(f"{path}: ")
    assert phrase in str(refusal.value)


OLD_REST = """  <ssv:Parameter name="initialRestOffset">
      <ssv:Real value="12.0" unit="V"/>
    </ssv:Parameter>
  </ssv:Parameters>"""


def test_a_set_of_an_older_version_is_read_where_nothing_depends_on_its_history(tmp_path):
    path = edited(tmp_path, "  </ssv:Parameters>", OLD_REST)
    zero = """    <ssv:Parameter name="displacementZero">
      <ssv:Real value="0.0" unit="m"/>
    </ssv:Parameter>
"""
    text = path.read_text(encoding="utf-8")
    assert zero in text
    path.write_text(text.replace(zero, ""), encoding="utf-8")
    assert dict(read_ssv(path)) == dict(table_1())


def test_a_history_of_play_operators_of_an_older_version_is_refused_with_the_mend(tmp_path):
    play = {"playCount": 1, "play[1].threshold": 5.0, "play[1].weight": 0.1}
    text = format_ssv(ParameterSet({**table_1(), **play}))
    path = tmp_path / "old.ssv"
    path.write_text(text.replace("  </ssv:Parameters>", OLD_REST), encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        read_ssv(path)
    assert str(refusal.value) == (
        f"{path}: 'initialRestOffset' was written when the history of play operators was relative to "
        "where the stage rests: identify the set again, or give initialDemagnetisation, the voltage at "
        "which the stage was last demagnetised, in its place"
    )
    path.write_text(text, encoding="utf-8")
    assert read_ssv(path)["initialDemagnetisation"] == 0.0


@pytest.mark.parametrize("content", [b"", b"time_s,voltage_V\n0,1\n", b"\x00\xff\xfe", b"PK\x03\x04"])
def test_a_file_that_is_not_xml_is_refused(tmp_path, content):
    path = tmp_path / "p.ssv"
    path.write_bytes(content)
    with pytest.raises(InputError, match="not an XML file"):
        read_ssv(path)


def test_a_missing_file_and_a_directory_are_refused(tmp_path):
    for path in (tmp_path / "missing.ssv", tmp_path):
        with pytest.raises(InputError, match="no such file, or it cannot be read"):
            read_ssv(path)


def test_comments_in_a_file_are_skipped(tmp_path):
    comment = '<ssv:Parameter name="voltageMin"><!-- at rest -->'
    path = edited(tmp_path, '<ssv:Parameter name="voltageMin">', comment)
    assert dict(read_ssv(path)) == dict(table_1())


def test_an_entity_that_points_to_a_file_is_not_followed(tmp_path):
    secret = tmp_path / "secret.txt"
    secret.write_text("0.0", encoding="utf-8")
    text = format_ssv(table_1()).replace(
        "?>\n", f'?>\n<!DOCTYPE p [<!ENTITY e SYSTEM "{secret.as_uri()}">]>\n', 1
    )
    path = tmp_path / "p.ssv"
    path.write_text(text.replace('name="Table 1"', 'name="&e;"'), encoding="utf-8")
    with pytest.raises(InputError, match="not an XML file"):
        read_ssv(path)


# --- writing -----------------------------------------------------------------------------------


@pytest.mark.parametrize("case", ["missing directory", "file as directory", "directory as file"])
def test_a_file_that_cannot_be_written_is_named_and_nothing_is_left(tmp_path, case):
    (tmp_path / "file").write_text("kept", encoding="utf-8")
    (tmp_path / "directory").mkdir()
    path = {
        "missing directory": tmp_path / "missing" / "p.ssv",
        "file as directory": tmp_path / "file" / "p.ssv",
        "directory as file": tmp_path / "directory",
    }[case]
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(InputError) as refusal:
        write_ssv(table_1(), path)
    assert str(refusal.value).startswith(f"{path}: cannot be written: ")
    assert sorted(tmp_path.rglob("*")) == before
    assert (tmp_path / "file").read_text(encoding="utf-8") == "kept"


def test_a_directory_without_permission_is_refused_and_nothing_is_left(tmp_path, monkeypatch):
    def refused(*_: object, **__: object) -> None:  # root may write anywhere: a mode does not do
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(tempfile, "mkstemp", refused)
    with pytest.raises(InputError, match=r"p\.ssv: cannot be written: Permission denied"):
        write_ssv(table_1(), tmp_path / "p.ssv")
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_fills_up_leaves_the_old_file_whole(tmp_path, monkeypatch):
    path = tmp_path / "p.ssv"
    write_ssv(table_1(), path)
    before = path.read_bytes()

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(InputError, match="cannot be written: No space left on device"):
        write_ssv(make_set(1, 1), path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_the_names_of_a_rules_fields_are_those_of_the_table():
    assert [f"rule[1].{f}" for f in RULE_FIELDS] == [
        n for n in load_table().parameters() if n.startswith("rule[1].")
    ]
