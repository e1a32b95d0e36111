"""Fifteen defects, put into our generator's output one by one: each is caught.

FMPy's validation finds most; what no checker sees, `own_findings` does. The same two find nothing in
what we package.
"""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import MODELS
from fmpy.validation import validate_fmu
from lxml import etree

SETS = ("table_1", "one_rule", "five_rules", "sixteen_rules")


# --- the check ---------------------------------------------------------------------------------


def own_findings(directory: Path) -> list[str]:
    """Return what is wrong with an unpacked FMU that FMPy's validation does not look at."""
    root = etree.parse(directory / "modelDescription.xml").getroot()
    return [
        *_file_findings(root, directory),
        *_reference_findings(root),
        *_range_findings(root),
        *_order_findings(root),
    ]


def _file_findings(root: etree._Element, directory: Path) -> list[str]:
    listed = {f.get("name") for f in root.iterfind("CoSimulation/SourceFiles/File")}
    there = {p.name for p in (directory / "sources").glob("*.c")}
    identifier = root.find("CoSimulation").get("modelIdentifier")
    binaries = {p.stem for p in (directory / "binaries").glob("*/*")}
    hashes = (directory / "sources" / "it2hys.c").read_text(encoding="utf-8")
    digits = root.get("guid", "").strip("{}").replace("-", "")
    findings = [f"source file {name} is not as listed" for name in listed ^ there]
    findings += [f"binary {name} is not {identifier}" for name in binaries - {identifier}]
    return findings + ([] if digits and digits[:16] in hashes else ["the GUID is not the binary's"])


def _reference_findings(root: etree._Element) -> list[str]:
    references = [
        (v[0].tag, v.get("valueReference")) for v in root.iterfind("ModelVariables/ScalarVariable")
    ]
    types = {t.get("name") for t in root.iterfind("TypeDefinitions/SimpleType")}
    findings = [
        f"value reference {r} is used twice" for r in set(references) if references.count(r) > 1
    ]
    for variable in root.iterfind("ModelVariables/ScalarVariable"):
        if variable[0].get("declaredType") not in types:
            findings.append(f"{variable.get('name')}: no such declared type")
    return findings


def _range_findings(root: etree._Element) -> list[str]:
    types = {t.get("name"): t[0] for t in root.iterfind("TypeDefinitions/SimpleType")}
    findings = []
    for variable in root.iterfind("ModelVariables/ScalarVariable"):
        declared, start = types.get(variable[0].get("declaredType")), variable[0].get("start")
        if declared is None or start is None or declared.get("min") is None:
            continue
        try:
            inside = float(declared.get("min")) <= float(start) <= float(declared.get("max"))
        except ValueError:
            inside = False
        if not inside:
            findings.append(f"{variable.get('name')}: start {start} is out of range")
    return findings


def _order_findings(root: etree._Element) -> list[str]:
    findings = []
    count = len(root.findall("ModelVariables/ScalarVariable"))
    for part in root.find("ModelStructure"):
        indices = [int(u.get("index")) for u in part]
        known = [int(i) for u in part for i in u.get("dependencies", "").split()]
        if indices != sorted(set(indices)):
            findings.append(f"{part.tag} are not in ascending order")
        if any(not 1 <= i <= count for i in indices + known):
            findings.append(f"{part.tag}: an index is none of a variable")
    return findings


def findings_of(directory: Path) -> list[str]:
    try:
        return validate_fmu(str(directory)) + own_findings(directory)
    except (etree.XMLSyntaxError, ValueError) as error:
        return [str(error)]


@pytest.mark.parametrize("which", MODELS)
@pytest.mark.parametrize("name", SETS)
def test_nothing_is_found_in_what_we_package(packaged, name, which):
    assert findings_of(packaged[name][1][which].directory) == []


# --- the defects -------------------------------------------------------------------------------


def change(path: str, **attributes: str | None) -> Callable[[etree._Element], None]:
    """Return a defect: attributes of the first element at a path are set or, with None, removed."""

    def apply(root: etree._Element) -> None:
        element = root if path == "." else root.find(path)
        for key, value in attributes.items():
            if value is None:
                del element.attrib[key]
            else:
                element.set(key, value)

    return apply


def drop(path: str) -> Callable[[etree._Element], None]:
    """Return a defect: the first element at a path is missing."""

    def apply(root: etree._Element) -> None:
        element = root.find(path)
        element.getparent().remove(element)

    return apply


def swap_initial_unknowns(root: etree._Element) -> None:
    unknowns = root.find("ModelStructure/InitialUnknowns")
    unknowns.append(unknowns[0])


def variable(name: str, child: str = "") -> str:
    return f"ModelVariables/ScalarVariable[@name='{name}']{child}"


TS_REAL = variable("sampleTime", "/Real")
DEFECTS = {
    "guid missing": change(".", guid=None),
    "guid of another model": change(".", guid="{00000000-0000-0000-0000-000000000000}"),
    "value reference used twice": change(variable("initialDisplacement"), valueReference="0"),
    "name used twice": change(variable("voltageMax"), name="voltageMin"),
    "name that the convention forbids": change(variable("voltageMax"), name="voltage max]"),
    "start missing": change(TS_REAL, start=None),
    "start outside min and max": change(TS_REAL, start="-1.0"),
    "start of another type": change(TS_REAL, start="fast"),
    "causality and variability at odds": change(variable("sampleTime"), variability="continuous"),
    "initial and causality at odds": change(variable("sampleTime"), initial="calculated"),
    "unit undefined": change(TS_REAL, unit="fortnight"),
    "declared type undefined": change(TS_REAL, declaredType="Fortnight"),
    "output not in ModelStructure": drop("ModelStructure/Outputs/Unknown"),
    "index of no variable": change("ModelStructure/Outputs/Unknown", dependencies="999"),
    "initial unknown missing": drop("ModelStructure/InitialUnknowns/Unknown"),
    "initial unknowns out of order": swap_initial_unknowns,
    "listed source file missing": change("CoSimulation/SourceFiles/File", name="nowhere.c"),
    "model identifier unlike the binary": change("CoSimulation", modelIdentifier="Other"),
}


@pytest.mark.parametrize("defect", DEFECTS)
def test_a_defect_is_found(models, tmp_path, defect):
    directory = tmp_path / "fmu"
    shutil.copytree(models["plant"].directory, directory)
    path = directory / "modelDescription.xml"
    tree = etree.parse(path)
    DEFECTS[defect](tree.getroot())
    tree.write(path, xml_declaration=True, encoding="UTF-8")
    assert path.read_bytes() != (models["plant"].directory / "modelDescription.xml").read_bytes()
    assert findings_of(directory)
