"""PIController.fmu, and gains for it that suit a parameter set.

The controller closes the loop around the inverse and the plant in studies of feedback and in SSP
packages. Its variables are listed in `controller.toml`.
"""

from collections.abc import Sequence

import numpy as np

from it2hys.fmu.build_description import format_build_description
from it2hys.fmu.documentation import render
from it2hys.fmu.fmi_versions import Content
from it2hys.fmu.model_description import format_content
from it2hys.fmu.packaging import BUILD_DESCRIPTION, fmu_archive, fmu_sources
from it2hys.fmu.platforms import platform_binaries
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet
from it2hys.model.variables import load_controller
from it2hys.support.version import package_version

IDENTIFIER = "PIController"
#: Crossover of the default loop times the sample time: two delayed ticks then cost little phase.
CROSSOVER = 0.1


def controller_fmu(fmi: int = 2) -> bytes:
    """Return PIController.fmu of a version of FMI, 2 or 3."""
    native = compiled.native_directory()
    page = render("controller.html", fmi=fmi, variables=load_controller().variables)
    sources = fmu_sources(IDENTIFIER, native / "controller", fmi)
    c_files = [name for name in sources if name.endswith(".c")]
    return fmu_archive(
        {
            "modelDescription.xml": _description(c_files, fmi),
            **{f"sources/{name}": content for name, content in sources.items()},
            BUILD_DESCRIPTION: format_build_description(IDENTIFIER, c_files),
            **platform_binaries(IDENTIFIER, native, fmi),
            "documentation/index.html": page.encode(),
            "documentation/licenses/license.txt": (native / "LICENSE").read_bytes(),
        }
    )


def _description(c_files: Sequence[str], fmi: int) -> bytes:
    table = load_controller()
    start = {v.name: v.start for v in table.variables if v.start is not None}
    content = Content(
        identifier=IDENTIFIER,
        token=table.guid,
        description="Sampled PI controller with feedforward, limits and no wind-up",
        variables=table.variables,
        start=start,
        rows=len(table.variables),
        sample_time=float(start["sampleTime"]),
        units=table.units,
        source_files=c_files,
        derivatives=False,
        interpolates=False,
    )
    return format_content(content, package_version(), fmi)


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
