"""PIController.fmu, and gains for it that suit a parameter set.

The controller closes the loop around the inverse and the plant in studies of feedback and in SSP
packages. Its variables are listed in `controller.toml`.
"""

from collections.abc import Sequence

import numpy as np
from lxml import etree

from it2hys.fmu.build_description import format_build_description
from it2hys.fmu.documentation import render
from it2hys.fmu.model_description import (
    add_log_categories,
    add_structure,
    add_types,
    add_units,
    add_variables,
)
from it2hys.fmu.packaging import BUILD_DESCRIPTION, fmu_archive, platform_binaries
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet
from it2hys.model.variables import load_controller
from it2hys.support.version import package_version

IDENTIFIER = "PIController"
CAPABILITIES = {
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "false",
    "maxOutputDerivativeOrder": "0",
    "canRunAsynchronuously": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "false",
}
#: Crossover of the default loop times the sample time: two delayed ticks then cost little phase.
CROSSOVER = 0.1


def controller_fmu() -> bytes:
    """Return PIController.fmu."""
    native = compiled.native_directory()
    page = render("controller.html", variables=load_controller().variables)
    sources = {path.name: path.read_bytes() for path in sorted((native / "controller").iterdir())}
    c_files = [name for name in sources if name.endswith(".c")]
    return fmu_archive(
        {
            "modelDescription.xml": _description(c_files),
            **{f"sources/{name}": content for name, content in sources.items()},
            BUILD_DESCRIPTION: format_build_description(IDENTIFIER, c_files),
            **platform_binaries(IDENTIFIER, native),
            "documentation/index.html": page.encode(),
            "documentation/licenses/license.txt": (native / "LICENSE").read_bytes(),
        }
    )


def _description(c_files: Sequence[str]) -> bytes:
    table = load_controller()
    version = package_version()
    root = etree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=IDENTIFIER,
        guid=table.guid,
        description="Sampled PI controller with feedforward, limits and no wind-up",
        version=version,
        copyright="Copyright (c) 2026, the it2hys developers",
        license="BSD-2-Clause",
        generationTool=f"it2hys {version}",
        variableNamingConvention="structured",
    )
    slave = etree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=IDENTIFIER,
        **CAPABILITIES,
    )
    files = etree.SubElement(slave, "SourceFiles")
    for name in c_files:
        etree.SubElement(files, "File", name=name)
    types = {v.type.name: v.type for v in table.variables}
    add_units(root, {t.unit for t in types.values()}, table.units)
    add_types(root, types)
    add_log_categories(root)
    etree.SubElement(
        root, "DefaultExperiment", startTime="0.0", stopTime="0.2", tolerance="1e-6", stepSize="1e-4"
    )
    add_variables(root, table.variables, {})
    add_structure(root, table.variables)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def suitable_gains(parameters: ParameterSet) -> dict[str, float]:
    """Return parameters of a PI controller for the plant that a set describes.

    The plant, linearised in the middle of its range, is a lag of gain K and time constant T. The
    controller's zero is put on the lag, and the integral gain makes the loop cross over at
    `CROSSOVER` / sampleTime. Effects beyond the core are left to the loop's margins.

    Parameters
    ----------
    parameters : ParameterSet
        Of the plant.

    Returns
    -------
    dict of str to float
        Values for PIController.fmu by name, in SI units.
    """
    rules, sample_time = parameters.rules, parameters["sampleTime"]
    middle = np.array([float(np.mean(parameters.displacement_range))])
    voltage = compiled.solve(rules, middle, middle)
    _, _, (by_voltage, by_displacement, _) = compiled.gradient(rules, middle[0], voltage[0])
    gain = by_voltage / (1.0 - by_displacement)
    time_constant = -sample_time / np.log(by_displacement) if 0.0 < by_displacement < 1.0 else 0.0
    integral_gain = CROSSOVER / sample_time / gain
    low, high = parameters.voltage_range
    return {
        "sampleTime": sample_time,
        "proportionalGain": float(integral_gain * time_constant),
        "integralGain": float(integral_gain),
        "voltageMin": low,
        "voltageMax": high,
    }
