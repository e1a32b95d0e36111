"""modelDescription.xml of a packaged FMU, generated from the variable table and a parameter set."""

from collections.abc import Mapping, Sequence

from lxml import etree

from it2hys.fmu.codegen import guid
from it2hys.model.parameters import ParameterSet, format_ssv
from it2hys.model.variables import DeclaredType, Variable, load_table

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
CAPABILITIES = {
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "true",
    "maxOutputDerivativeOrder": "0",
    "canRunAsynchronuously": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "true",
}
# ticks that the default experiment shows: 0.2 s at the paper's sample time
DEFAULT_TICKS = 2000


def format_model_description(
    model: str, parameters: ParameterSet, source_files: list[str], version: str
) -> bytes:
    """Return modelDescription.xml.

    Parameters
    ----------
    model : {"plant", "inverse"}
        Which FMU.
    parameters : ParameterSet
        Gives the start values and the number of structured variables.
    source_files : list of str
        C files in `sources/` to compile.
    version : str
        Version of the FMU.
    """
    variables = load_table().of_model(model, parameters.counts)
    root = etree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=IDENTIFIERS[model],
        guid=guid(model, format_ssv(parameters)),
        description=f"{DESCRIPTIONS[model]} ({parameters.name})",
        version=version,
        copyright="Copyright (c) 2026, the it2hys developers",
        license="BSD-2-Clause",
        generationTool=f"it2hys {version}",
        variableNamingConvention="structured",
    )
    slave = etree.SubElement(root, "CoSimulation", modelIdentifier=IDENTIFIERS[model], **CAPABILITIES)
    files = etree.SubElement(slave, "SourceFiles")
    for name in source_files:
        etree.SubElement(files, "File", name=name)
    types = {v.type.name: v.type for v in variables}
    add_units(root, {t.unit for t in types.values()}, load_table().units)
    add_types(root, types)
    add_log_categories(root)
    sample_time = parameters["sampleTime"]
    etree.SubElement(
        root,
        "DefaultExperiment",
        startTime="0.0",
        stopTime=repr(DEFAULT_TICKS * sample_time),
        tolerance="1e-6",
        stepSize=repr(sample_time),
    )
    add_variables(root, variables, parameters)
    add_structure(root, variables)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def add_log_categories(root: etree._Element) -> None:
    """Add LogCategories: those of the layer that all FMUs share."""
    categories = etree.SubElement(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        etree.SubElement(categories, "Category", name=name, description=description)


def add_units(root: etree._Element, used: set[str | None], units: Mapping[str, Mapping]) -> None:
    """Add the definitions of the units in use."""
    definitions = etree.SubElement(root, "UnitDefinitions")
    for name, unit in {"1": {}, **units}.items():
        if name not in used:
            continue
        element = etree.SubElement(definitions, "Unit", name=name)
        exponents = {k: str(v) for k, v in unit.items() if k != "display"}
        etree.SubElement(element, "BaseUnit", **exponents)
        for display, conversion in unit.get("display", {}).items():
            numbers = {k: repr(float(v)) for k, v in conversion.items()}
            etree.SubElement(element, "DisplayUnit", name=display, **numbers)


def add_types(root: etree._Element, types: Mapping[str, DeclaredType]) -> None:
    """Add the definitions of the declared types."""
    definitions = etree.SubElement(root, "TypeDefinitions")
    for name, declared in types.items():
        simple = etree.SubElement(definitions, "SimpleType", name=name)
        attributes = {
            key: _text(value)
            for key in ("quantity", "unit", "displayUnit", "min", "max", "nominal")
            if (value := getattr(declared, key)) is not None
        }
        if declared.base == "Boolean":
            attributes = {}
        etree.SubElement(simple, declared.base, **attributes)


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else repr(value)


def add_variables(
    root: etree._Element, variables: Sequence[Variable], parameters: Mapping[str, float | int | bool]
) -> None:
    """Add the variables, with start values from a parameter set or else from the table."""
    element = etree.SubElement(root, "ModelVariables")
    for variable in variables:
        attributes = {
            "name": variable.name,
            "valueReference": str(variable.value_reference),
            "description": variable.description,
            "causality": variable.causality,
            "variability": variable.variability,
        }
        if variable.causality == "output":
            attributes["initial"] = "calculated"
        elif variable.causality == "parameter":
            attributes["initial"] = "exact"
        scalar = etree.SubElement(element, "ScalarVariable", **attributes)
        typed = {"declaredType": variable.type.name}
        if variable.type.unit:
            typed["unit"] = variable.type.unit
        if variable.type.displayUnit:
            typed["displayUnit"] = variable.type.displayUnit
        if variable.causality != "output":
            typed["start"] = _text(parameters.get(variable.name, variable.start))
        if variable.type.base == "Integer":  # a count: the FMU has no more than its set
            typed["max"] = typed["start"]
        etree.SubElement(scalar, variable.type.base, **typed)


def add_structure(root: etree._Element, variables: Sequence[Variable]) -> None:
    """Say what depends on what.

    At a communication point an output is held since the last tick: it depends on no input that is
    set there, so there is no algebraic loop. Before the first tick it depends on parameters, but not on
    those of an effect of which this FMU has no element: how the play operators began, for instance.
    """
    without = set(load_table().counts) - {v.group for v in variables}
    structure = etree.SubElement(root, "ModelStructure")
    outputs = [(i, v) for i, v in enumerate(variables, start=1) if v.causality == "output"]
    element = etree.SubElement(structure, "Outputs")
    for index, _ in outputs:
        etree.SubElement(element, "Unknown", index=str(index), dependencies="")
    element = etree.SubElement(structure, "InitialUnknowns")
    for index, output in outputs:
        known = [
            str(i)
            for i, v in enumerate(variables, start=1)
            if (v.name in output.depends or v.group in output.depends) and v.effect not in without
        ]
        etree.SubElement(element, "Unknown", index=str(index), dependencies=" ".join(known))
