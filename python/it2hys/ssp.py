"""System packages: FMUs, their connections and their parameters as SSP files.

An SSP (System Structure and Parameterization, 1.0) is a zip of FMUs, a description of how they are
connected, and parameter sets. Masters read a narrow profile of it, which is what is written here: the
literal prefixes `ssd:`, `ssc:` and `ssv:`, version 1.0, Real connectors, parameter sets as files of
`resources/`, and no name that an FMU lacks. All sets of a package have one name, because ecos applies
the sets of the one name that it is given, and without a name none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

from it2hys.controller import IDENTIFIER as CONTROLLER
from it2hys.controller import controller_fmu, load_controller, suitable_gains
from it2hys.files import write_atomically
from it2hys.model_description import DEFAULT_TICKS
from it2hys.packaging import fmu_archive, make_directory, package_bytes
from it2hys.parameters import ParameterSet, format_ssv
from it2hys.ssv import SSV_NAMESPACE, format_entries

SSD_NAMESPACE = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC_NAMESPACE = "http://ssp-standard.org/SSP1/SystemStructureCommon"


@dataclass(frozen=True)
class Component:
    """An FMU of a system.

    Attributes
    ----------
    fmu : str
        Its file in `resources/`.
    parameters : str
        Its parameter set in `resources/`.
    inputs, outputs : tuple of str
        Connectors by name.
    """

    fmu: str
    parameters: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


INVERSE = Component("IT2Inverse.fmu", "parameters.ssv", ("reference",), ("voltage",))
PLANT = Component("IT2Plant.fmu", "parameters.ssv", ("voltage",), ("displacement",))
CONTROL = Component(
    f"{CONTROLLER}.fmu",
    "controller.ssv",
    ("reference", "displacement", "feedforward"),
    ("voltage",),
)
#: Systems by file name: components in the order in which they should step, and connections.
SYSTEMS: dict[str, tuple[dict[str, Component], tuple[tuple[str, str], ...]]] = {
    "feedforward": (
        {"inverse": INVERSE, "plant": PLANT},
        (("inverse.voltage", "plant.voltage"),),
    ),
    "feedback": (
        {"inverse": INVERSE, "controller": CONTROL, "plant": PLANT},
        (
            ("inverse.voltage", "controller.feedforward"),
            ("plant.displacement", "controller.displacement"),
            ("controller.voltage", "plant.voltage"),
        ),
    ),
}


def write_ssp(parameters: ParameterSet, directory: str | Path) -> list[Path]:
    """Write `feedforward.ssp` (inverse, plant) and `feedback.ssp` (with a PI controller between).

    The controller's gains suit the plant (`it2hys.controller.suitable_gains`); another set of them can
    be put into `resources/controller.ssv`. The reference is an input that the user drives: that of the
    inverse, and in the feedback system that of the controller too.

    Parameters
    ----------
    parameters : ParameterSet
        Of plant and inverse.
    directory : path
        Created if it does not exist.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the directory cannot be written to.
    """
    directory = make_directory(directory)
    fmus = {f"{name}.fmu": content for name, content in package_bytes(parameters).items()}
    fmus[CONTROL.fmu] = controller_fmu()
    sets = {
        "parameters.ssv": format_ssv(parameters),
        "controller.ssv": format_controller_ssv(suitable_gains(parameters), parameters.name),
    }
    contents = {
        directory / f"{name}.ssp": format_ssp(name, fmus, sets, parameters["sampleTime"])
        for name in SYSTEMS
    }
    for path, content in contents.items():
        write_atomically(path, content)
    return list(contents)


def format_ssp(
    name: str, fmus: Mapping[str, bytes], sets: Mapping[str, str], sample_time: float
) -> bytes:
    """Return an SSP.

    Parameters
    ----------
    name : {"feedforward", "feedback"}
        Which system.
    fmus : mapping of str to bytes
        FMUs by file name; those that the system has not are left out.
    sets : mapping of str to str
        Parameter sets by file name, as SSV.
    sample_time : float
        In s; the default experiment lasts 2000 of them.
    """
    components, connections = SYSTEMS[name]
    return fmu_archive(
        {
            "SystemStructure.ssd": format_ssd(name, components, connections, sample_time).encode(),
            **{f"resources/{c.fmu}": fmus[c.fmu] for c in components.values()},
            **{f"resources/{c.parameters}": sets[c.parameters].encode() for c in components.values()},
        }
    )


def format_controller_ssv(values: Mapping[str, float], name: str) -> str:
    """Return a parameter set of the controller as SSV."""
    types = {v.name: v.type for v in load_controller().variables}
    return format_entries(values, types, name)


def format_ssd(
    name: str,
    components: Mapping[str, Component],
    connections: Sequence[tuple[str, str]],
    sample_time: float,
) -> str:
    """Return SystemStructure.ssd."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<ssd:SystemStructureDescription name={quoteattr(name)} version="1.0"',
        f'    xmlns:ssc="{SSC_NAMESPACE}"',
        f'    xmlns:ssd="{SSD_NAMESPACE}"',
        f'    xmlns:ssv="{SSV_NAMESPACE}">',
        f"  <ssd:System name={quoteattr(name)}>",
        "    <ssd:Elements>",
    ]
    for label, component in components.items():
        lines += _component(label, component)
    lines += ["    </ssd:Elements>", "    <ssd:Connections>"]
    for source, target in connections:
        (a, x), (b, y) = (end.split(".") for end in (source, target))
        lines += [
            f'      <ssd:Connection startElement="{a}" startConnector="{x}"',
            f'          endElement="{b}" endConnector="{y}"/>',
        ]
    stop = DEFAULT_TICKS * sample_time
    return "\n".join(
        [
            *lines,
            "    </ssd:Connections>",
            "  </ssd:System>",
            f'  <ssd:DefaultExperiment startTime="0.0" stopTime="{stop!r}"/>',
            "</ssd:SystemStructureDescription>",
            "",
        ]
    )


def _component(label: str, component: Component) -> list[str]:
    connectors = [
        f'          <ssd:Connector name="{name}" kind="{kind}"><ssc:Real/></ssd:Connector>'
        for kind, names in (("input", component.inputs), ("output", component.outputs))
        for name in names
    ]
    return [
        f'      <ssd:Component name="{label}" type="application/x-fmu-sharedlibrary"',
        f'          source="resources/{component.fmu}">',
        "        <ssd:Connectors>",
        *connectors,
        "        </ssd:Connectors>",
        "        <ssd:ParameterBindings>",
        f'          <ssd:ParameterBinding source="resources/{component.parameters}"/>',
        "        </ssd:ParameterBindings>",
        "      </ssd:Component>",
    ]
