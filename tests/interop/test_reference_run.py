"""What an FMU carries beside the model: a reference run that replays, terminals, a picture."""

import struct
from pathlib import Path
from urllib.parse import unquote

import fmpy
import numpy as np
import pytest
from conftest import MODELS
from fmpy.util import read_csv
from lxml import etree

from it2hys.reference_run import FOLDER, NAMESPACE, STANDARD

SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi3"
# the roles of fmi-ls-ref 1.0.0-alpha.1 that we use
ROLES = {"testcase", "result", "parameter", "document"}
SETS = ("table_1", "one_rule", "five_rules", "sixteen_rules")


@pytest.mark.parametrize("which", MODELS)
@pytest.mark.parametrize("name", SETS)
def test_the_reference_run_replays_in_fmpy_bit_for_bit(packaged, name, which):
    unpacked = packaged[name][1][which]
    folder = unpacked.directory / FOLDER
    given, expected = read_csv(folder / "input.csv"), read_csv(folder / "result.csv")
    sample_time = packaged[name][0]["sampleTime"]
    outputs = [v.name for v in unpacked.description.modelVariables if v.causality == "output"]
    assert expected.dtype.names == ("time", *outputs)
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


def test_the_manifest_is_as_the_layered_standard_wants_it(model):
    root = etree.parse(model.directory / FOLDER / "fmi-ls-manifest.xml").getroot()
    assert root.tag == "fmiReferences"
    assert dict(root.attrib) == {f"{{{NAMESPACE}}}fmi-ls-{k}": v for k, v in STANDARD.items()}
    schema = etree.parse(SCHEMAS / "fmi3LayeredStandardManifest.xsd")
    assert schema.getroot().get("targetNamespace") == NAMESPACE
    related = root.findall("Related")
    assert {r.get("role") for r in related} == ROLES
    assert len(related) == len(root)
    for file in related:
        assert set(file.attrib) == {"type", "source", "role", "description"}
        path = (model.directory / FOLDER / unquote(file.get("source"))).resolve()
        assert path.is_file(), file.get("source")
        assert path.is_relative_to(model.directory.resolve())
    listed = {r.get("source") for r in related}
    there = {p.name for p in (model.directory / FOLDER).iterdir()}
    assert there - listed == {"fmi-ls-manifest.xml"}


def terminals_of(unpacked) -> etree._Element:
    return etree.parse(unpacked.directory / "terminalsAndIcons" / "terminalsAndIcons.xml").getroot()


def test_terminals_follow_the_schema_of_fmi_3_and_name_variables_that_exist(model):
    root = terminals_of(model)
    etree.XMLSchema(etree.parse(SCHEMAS / "fmi3TerminalsAndIcons.xsd")).assertValid(root)
    members = [m.get("variableName") for m in root.iter("TerminalMemberVariable")]
    signals = {v.name for v in model.description.modelVariables if v.causality != "parameter"}
    assert len(members) == len(set(members))
    assert signals - set(members) <= {"saturated"}
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
