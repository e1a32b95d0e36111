"""What an FMU carries beside the model: a reference run that replays, terminals, a picture."""

import struct
from pathlib import Path
from urllib.parse import unquote

import fmpy
import numpy as np
import pytest
from conftest import MODELS, package_models
from effects import with_effects
from fmpy.ssp.ssd import read_ssv
from fmpy.util import read_csv
from lxml import etree

from it2hys.fmu.reference_run import FOLDER, NAMESPACE, STANDARD, format_manifest
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS

SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi3"
# What fmi-ls-ref wants of its manifest, as 1.0.0-alpha.1 and 1.0.0-beta.1 have it: both still say
# 1.0.0-alpha.1 of themselves. The attributes of the root are those of FMI 3, whose schema FMPy brings.
# Sub-roles and annotations, which we have no use for, are left out.
ROLES = [
    *("configuration", "delivery", "document", "experiment", "meta-data", "method", "model", "other"),
    *("parameter", "rationale", "report", "request", "requirement", "result", "serialized-state"),
    *("signature", "specification", "system", "testcase"),
]
DESCRIPTION = "Layered Standard providing information on related files included in an FMU."
MANIFEST_XSD = f"""
<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema" xmlns:ls="{NAMESPACE}">
  <xs:import namespace="{NAMESPACE}" schemaLocation="fmi3LayeredStandardManifest.xsd"/>
  <xs:element name="fmiReferences"><xs:complexType>
    <xs:sequence>
      <xs:element name="Related" minOccurs="0" maxOccurs="unbounded"><xs:complexType>
        <xs:sequence>
          <xs:element name="Label" minOccurs="0" maxOccurs="unbounded"><xs:complexType>
            <xs:attribute name="name" type="xs:string" use="required"/>
            <xs:attribute name="description" type="xs:string"/>
          </xs:complexType></xs:element>
        </xs:sequence>
        <xs:attribute name="type" type="xs:string"/>
        <xs:attribute name="source" type="xs:anyURI" use="required"/>
        <xs:attribute name="role" use="required"><xs:simpleType><xs:restriction base="xs:string">
          {"".join(f'<xs:enumeration value="{role}"/>' for role in ROLES)}
        </xs:restriction></xs:simpleType></xs:attribute>
        <xs:attribute name="description" type="xs:string"/>
      </xs:complexType></xs:element>
    </xs:sequence>
    <xs:attribute ref="ls:fmi-ls-name" use="required" fixed="org.fmi-standard.fmi-ls-ref"/>
    <xs:attribute ref="ls:fmi-ls-version" use="required"/>
    <xs:attribute ref="ls:fmi-ls-description" use="required"
        fixed="{DESCRIPTION}"/>
  </xs:complexType></xs:element>
</xs:schema>
"""
SETS = ("table_1", "one_rule", "five_rules", "sixteen_rules")


def replay(unpacked, parameters) -> tuple[np.ndarray, np.ndarray]:
    """Assert that FMPy repeats an FMU's reference run to the last bit; return inputs and outputs."""
    folder = unpacked.directory / FOLDER
    given, expected = read_csv(folder / "input.csv"), read_csv(folder / "result.csv")
    sample_time = parameters["sampleTime"]
    variables = unpacked.description.modelVariables
    outputs = [v.name for v in variables if v.causality == "output"]
    assert expected.dtype.names == ("time", *outputs)
    assert set(given.dtype.names) == {"time", *(v.name for v in variables if v.causality == "input")}
    result = fmpy.simulate_fmu(
        str(unpacked.path),
        stop_time=expected["time"][-1],
        step_size=sample_time,
        output_interval=sample_time,
        input=given,
        output=outputs,
    )
    assert np.ptp(expected[outputs[0]]) > 0
    for column in expected.dtype.names:
        assert result[column].astype(float).tobytes() == expected[column].tobytes(), column
    return given, expected


@pytest.mark.parametrize("which", MODELS)
@pytest.mark.parametrize("name", SETS)
def test_the_reference_run_replays_in_fmpy_bit_for_bit(packaged, name, which):
    parameters, models = packaged[name]
    _, run = replay(models[which], parameters)
    if which == "inverse":
        cut = run["saturated"] != 0
        assert cut.mean() < 0.2  # rest at 0 um may ask for less than 0 V
        assert (run["voltage"][cut] == parameters["voltageMin"]).all()


@pytest.mark.parametrize("effects", [*((e,) for e in EFFECTS), tuple(EFFECTS)], ids="+".join)
def test_the_reference_run_has_the_effects_of_its_set(effects, tmp_path):
    """Each alone and all together; the core alone would make another run of the same inputs."""
    parameters = with_effects(effects, 3)
    alone, models = with_effects((), 3), package_models(parameters, tmp_path)
    given, run = replay(models["plant"], parameters)
    _, measured = compiled.chain_free_run(alone, given["voltage"])
    assert np.abs(run["measured"][1:] - measured[:-1]).max() > 1e-9
    given, run = replay(models["inverse"], parameters)
    voltage, _ = compiled.chain_inverse_run(alone, given["reference"])
    if not {"delay", "hum"}.issuperset(effects):  # which the inverse does not see
        assert np.abs(run["voltage"][1:] - voltage[:-1]).max() > 1e-3


@pytest.fixture(scope="module")
def manifest_schema() -> etree.XMLSchema:
    return etree.XMLSchema(etree.fromstring(MANIFEST_XSD, base_url=f"{SCHEMAS.as_uri()}/own.xsd"))


@pytest.mark.parametrize("which", MODELS)
@pytest.mark.parametrize("name", SETS)
def test_the_manifest_is_as_the_layered_standard_wants_it(packaged, name, which, manifest_schema):
    directory = packaged[name][1][which].directory
    root = etree.parse(directory / FOLDER / "fmi-ls-manifest.xml").getroot()
    manifest_schema.assertValid(root)
    # values that are fixed, which libxml2 does not look at
    assert STANDARD["name"] == "org.fmi-standard.fmi-ls-ref"
    assert STANDARD["description"] == DESCRIPTION
    assert dict(root.attrib) == {f"{{{NAMESPACE}}}fmi-ls-{k}": v for k, v in STANDARD.items()}
    for file in root:
        path = (directory / FOLDER / unquote(file.get("source"))).resolve()
        assert path.is_file(), file.get("source")
        assert path.is_relative_to(directory.resolve())
    assert {r.get("role") for r in root} == {"testcase", "result", "parameter", "document"}
    there = {p.name for p in (directory / FOLDER).iterdir()}
    assert there - {r.get("source") for r in root} == {"fmi-ls-manifest.xml"}
    # the parameters can be applied to the FMU as they are: this is the role's one rule
    (parameters,) = (r for r in root if r.get("role") == "parameter")
    assert parameters.get("type") == "application/x-ssp-parameter-set"
    given = {p.name for p in read_ssv(directory / FOLDER / parameters.get("source")).parameters}
    assert given <= set(packaged[name][1][which].variables)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("fmi-ls:fmi-ls-version=", "fmi-ls:fmi-version="),
        ("fmi-ls:fmi-ls-name=", "name="),
        ('role="result"', 'role="outcome"'),
        ('role="result"', ""),
        ('source="input.csv"', ""),
        ("fmiReferences", "fmiLayeredStandardManifest"),
        ("Related", "File"),
    ],
)
def test_a_manifest_that_is_not_is_found(manifest_schema, old, new):
    """A guard for the test above."""
    text = format_manifest().decode()
    assert old in text
    assert not manifest_schema.validate(etree.fromstring(text.replace(old, new).encode()))


def terminals_of(unpacked) -> etree._Element:
    return etree.parse(unpacked.directory / "terminalsAndIcons" / "terminalsAndIcons.xml").getroot()


def test_terminals_follow_the_schema_of_fmi_3_and_name_variables_that_exist(model):
    root = terminals_of(model)
    etree.XMLSchema(etree.parse(SCHEMAS / "fmi3TerminalsAndIcons.xsd")).assertValid(root)
    members = [m.get("variableName") for m in root.iter("TerminalMemberVariable")]
    signals = {v.name for v in model.description.modelVariables if v.causality != "parameter"}
    assert len(members) == len(set(members))
    assert signals - set(members) <= {"saturated", "outOfRange"}
    assert set(members) <= signals


def test_the_drive_of_the_inverse_fits_that_of_the_plant(models):
    drives = [
        next(t for t in terminals_of(models[m]).iter("Terminal") if t.get("name") == "drive")
        for m in MODELS
    ]
    assert [d.get("matchingRule") for d in drives] == ["plug", "plug"]
    assert [[m.get("memberName") for m in d] for d in drives] == [["voltage"], ["voltage"]]


@pytest.mark.parametrize("place", ["model.png", "terminalsAndIcons/icon.png"])
def test_the_picture_is_a_small_square_png(model, place):
    content = (model.directory / place).read_bytes()
    assert content.startswith(b"\x89PNG\r\n\x1a\n")
    width, height = struct.unpack_from(">II", content, 16)
    assert width == height >= 100
    assert len(content) < 30_000
