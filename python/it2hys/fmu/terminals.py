"""`terminalsAndIcons/` of an FMU: which variables belong together, and the picture of the FMU.

FMI 3.0 defines the files; tools read them in FMUs of FMI 2.0 too. The terminals of plant and inverse
fit each other: what ends in the plant's `drive` begins in the inverse's.

Their `fmiVersion` is that of the file's format, 3.0, in an FMU of FMI 2.0 too: so the standard says
(FMI 3.0, Terminals and Icons), and its schema. FMILibrary 3.0.5 compares it with the FMU's version
instead, and calls the difference fatal; FMUs without the folder pass.
"""

from importlib.resources import files

from lxml import etree

from it2hys.model.parameters import ParameterSet
from it2hys.model.variables import load_table

# name: matching rule, description, members
TERMINALS = {
    "drive": ("plug", "Voltage at the actuator", ("voltage",)),
    "target": ("plug", "Displacement that is asked for", ("reference",)),
    "position": ("bus", "Displacement, and what the sensor reads of it", ("displacement", "measured")),
    "surroundings": ("bus", "What acts on the actuator from outside", ("force", "temperature")),
}
# of the icon, in the drawing units of FMI 3.0
EXTENT = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}


def format_terminals(model: str, parameters: ParameterSet) -> bytes:
    """Return terminalsAndIcons.xml."""
    root = etree.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = etree.SubElement(root, "GraphicalRepresentation")
    etree.SubElement(picture, "CoordinateSystem", **EXTENT, suggestedScalingFactorTo_mm="0.1")
    etree.SubElement(picture, "Icon", **EXTENT)
    terminals = etree.SubElement(root, "Terminals")
    there = {v.name for v in load_table().of_model(model, parameters.counts)}
    for name, (rule, description, members) in TERMINALS.items():
        if not there.issuperset(members):
            continue
        terminal = etree.SubElement(
            terminals, "Terminal", name=name, matchingRule=rule, description=description
        )
        for member in members:
            etree.SubElement(
                terminal,
                "TerminalMemberVariable",
                variableName=member,
                memberName=member,
                variableKind="signal",
            )
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def picture_files(model: str) -> dict[str, bytes]:
    """Return the FMU's picture by its path in the FMU."""
    return {"model.png": _picture(model)}


def terminal_files(model: str, parameters: ParameterSet) -> dict[str, bytes]:
    """Return the FMU's terminals and icon by their path in the FMU."""
    return {
        "terminalsAndIcons/icon.png": _picture(model),
        "terminalsAndIcons/terminalsAndIcons.xml": format_terminals(model, parameters),
    }


def _picture(model: str) -> bytes:
    return (files("it2hys.fmu") / "templates" / f"{model}.png").read_bytes()
