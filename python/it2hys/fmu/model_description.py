"""modelDescription.xml of a packaged FMU, generated from the variable table and a parameter set.

It is written here for both versions of FMI; what they say in different words is in
`it2hys.fmu.fmi_versions`.
"""

from collections.abc import Mapping, Sequence

from lxml import etree

from it2hys.fmu.codegen import guid
from it2hys.fmu.fmi_versions import VERSIONS, Content
from it2hys.model.parameters import ParameterSet, format_ssv
from it2hys.model.variables import load_table

IDENTIFIERS = {"plant": "IT2Plant", "inverse": "IT2Inverse"}
DESCRIPTIONS = {
    "plant": "Piezo actuator with hysteresis: interval type-2 fuzzy model from voltage to displacement",
    "inverse": "Closed-form inverse of a piezo actuator with hysteresis: from displacement to voltage",
}
LOG_CATEGORIES = {
    "logEvents": "Instantiation and other events",
    "logStatusWarning": "Something is not right, but the simulation continues",
    "logStatusDiscard": "A value or a step was refused; the last good state is kept",
    "logStatusError": "A call was wrong and had no effect",
    "logAll": "All messages",
}
# ticks that the default experiment shows: 0.2 s at the paper's sample time
DEFAULT_TICKS = 2000


def format_model_description(
    model: str, parameters: ParameterSet, source_files: Sequence[str], version: str, fmi: int = 2
) -> bytes:
    """Return modelDescription.xml of the plant or the inverse.

    Parameters
    ----------
    model : {"plant", "inverse"}
        Which FMU.
    parameters : ParameterSet
        Gives the start values and the number of structured variables.
    source_files : sequence of str
        C files in `sources/` to compile.
    version : str
        Version of the FMU.
    fmi : {2, 3}
        Version of FMI.
    """
    table = load_table()
    content = Content(
        identifier=IDENTIFIERS[model],
        token=guid(model, format_ssv(parameters)),
        description=f"{DESCRIPTIONS[model]} ({parameters.name})",
        variables=table.of_model(model, parameters.counts),
        start=parameters,
        rows=len(table.variables),
        sample_time=parameters["sampleTime"],
        units=table.units,
        counts={group: entry["variable"] for group, entry in table.counts.items()},
        source_files=source_files,
    )
    return format_content(content, version, fmi)


def format_content(content: Content, version: str, fmi: int) -> bytes:
    """Return modelDescription.xml of an FMU of one version of FMI; `version` is the FMU's own."""
    words = VERSIONS[fmi]
    root = etree.Element(
        "fmiModelDescription",
        fmiVersion=words.name,
        modelName=content.identifier,
        **{words.token: content.token},
        description=content.description,
        version=version,
        copyright="Copyright (c) 2026, the it2hys developers",
        license="BSD-2-Clause",
        generationTool=f"it2hys {version}",
        variableNamingConvention="structured",
    )
    slave = etree.SubElement(
        root, "CoSimulation", modelIdentifier=content.identifier, **words.capabilities(content)
    )
    words.add_source_files(slave, content)
    types = {v.type.name: v.type for v in content.variables}
    _add_units(root, {t.unit for t in types.values()}, content.units)
    definitions = etree.SubElement(root, "TypeDefinitions")
    for declared in types.values():
        words.add_type(definitions, declared)
    _add_log_categories(root)
    etree.SubElement(
        root,
        "DefaultExperiment",
        startTime="0.0",
        stopTime=repr(DEFAULT_TICKS * content.sample_time),
        tolerance="1e-6",
        stepSize=repr(content.sample_time),
    )
    words.add_variables(etree.SubElement(root, "ModelVariables"), content)
    words.add_structure(etree.SubElement(root, "ModelStructure"), content)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def _add_log_categories(root: etree._Element) -> None:
    """Add those of the layer that all FMUs share."""
    categories = etree.SubElement(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        etree.SubElement(categories, "Category", name=name, description=description)


def _add_units(root: etree._Element, used: set[str | None], units: Mapping[str, Mapping]) -> None:
    """Add the definitions of the units in use."""
    definitions = etree.SubElement(root, "UnitDefinitions")
    for name, unit in {"1": {}, **units}.items():
        if name not in used:
            continue
        element = etree.SubElement(definitions, "Unit", name=name)
        exponents = {k: str(v) for k, v in unit.items() if k != "display"}
        if exponents or name == "1":  # nothing is known of one that only a user's own effect has
            etree.SubElement(element, "BaseUnit", **exponents)
        for display, conversion in unit.get("display", {}).items():
            numbers = {k: repr(float(v)) for k, v in conversion.items()}
            etree.SubElement(element, "DisplayUnit", name=display, **numbers)
