"""System packages: FMUs, their connections and their parameters as SSP files.

An SSP (System Structure and Parameterization, 1.0) is a zip of FMUs, a description of how they are
connected, and parameter sets. Masters read a narrow profile of it, which is what is written here: the
literal prefixes `ssd:`, `ssc:` and `ssv:`, version 1.0, parameter sets as files of `resources/`, and no
name that an FMU lacks. All sets of a package have one name, because ecos applies the sets of the one
name that it is given, and without a name none.

A system has connectors of its own, which the standard wants and `fmpy.ssp` drives it by. libcosim and
ecos refuse a package with a connection to them: for these there is a second one without.

With FMUs of FMI 3.0 there is that second kind alone, because of the masters that read packages only
ecos runs FMI 3.0. SSP 1.0 has no arrays: the sets of these packages have the other parameters, and what
is in arrays is in the FMUs.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from it2hys.fmu.controller import IDENTIFIER as CONTROLLER
from it2hys.fmu.controller import controller_fmu, suitable_gains
from it2hys.fmu.model_description import DEFAULT_TICKS, IDENTIFIERS
from it2hys.fmu.packaging import SUFFIX, fmu_archive, package_bytes
from it2hys.model.parameters import ParameterSet, format_ssv
from it2hys.model.ssv import SSV_NAMESPACE, format_entries
from it2hys.model.variables import Variable, load_controller, load_table
from it2hys.support.files import write_together

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
NAMESPACES = {"ssc": SSC, "ssd": SSD, "ssv": SSV_NAMESPACE}
#: Ends the name of a package whose system has no connectors of its own.
COMPONENTS_ALONE = "_components"


@dataclass(frozen=True)
class Component:
    """An FMU of a system: its identifier, and its parameter set in `resources/`."""

    identifier: str
    parameters: str

    def fmu(self, fmi: int = 2) -> str:
        """Return its file in `resources/`."""
        return f"{self.identifier}{SUFFIX[fmi]}.fmu"

    def variable(self, name: str) -> Variable:
        """Return a variable of the FMU."""
        known = load_table().variables + load_controller().variables
        models = {identifier: model for model, identifier in IDENTIFIERS.items()}
        model = models.get(self.identifier, "controller")
        return next(v for v in known if v.name == name and model in v.models)


INVERSE = Component(IDENTIFIERS["inverse"], "parameters.ssv")
PLANT = Component(IDENTIFIERS["plant"], "parameters.ssv")
CONTROL = Component(CONTROLLER, "controller.ssv")


@dataclass(frozen=True)
class System:
    """Connected FMUs.

    Attributes
    ----------
    components : dict of str to Component
        In the order in which they should step.
    connections : tuple of (str, str)
        From and to, as ``component.variable``; without a dot, a connector of the system itself.
    """

    components: Mapping[str, Component]
    connections: tuple[tuple[str, str], ...]

    @property
    def inner(self) -> tuple[tuple[str, str], ...]:
        """The connections between components."""
        return tuple(ends for ends in self.connections if all("." in end for end in ends))

    @property
    def connectors(self) -> dict[str, tuple[str, Variable]]:
        """The system's own connectors by name: kind, and the variable that each belongs to."""
        found = {}
        for source, target in self.connections:
            if "." not in source:
                found[source] = ("input", self._variable(target))
            elif "." not in target:
                found[target] = ("output", self._variable(source))
        return found

    def connected(self, component: str) -> list[Variable]:
        """Return the variables of a component that are connected, inside or to the system's own."""
        ends = dict.fromkeys(end for ends in self.connections for end in ends)
        return [self._variable(end) for end in ends if end.partition(".")[0] == component]

    def _variable(self, end: str) -> Variable:
        component, _, name = end.partition(".")
        return self.components[component].variable(name)


#: Systems by file name. The loop closes on what the sensor gives.
SYSTEMS = {
    "feedforward": System(
        {"inverse": INVERSE, "plant": PLANT},
        (
            ("reference", "inverse.reference"),
            ("inverse.voltage", "plant.voltage"),
            ("plant.displacement", "displacement"),
            ("plant.measured", "measured"),
            ("inverse.voltage", "voltage"),
            ("inverse.saturated", "saturated"),
        ),
    ),
    "feedback": System(
        {"inverse": INVERSE, "controller": CONTROL, "plant": PLANT},
        (
            ("reference", "inverse.reference"),
            ("reference", "controller.reference"),
            ("inverse.voltage", "controller.feedforward"),
            ("plant.measured", "controller.displacement"),
            ("controller.voltage", "plant.voltage"),
            ("plant.displacement", "displacement"),
            ("plant.measured", "measured"),
            ("controller.voltage", "voltage"),
            ("inverse.saturated", "saturated"),
            ("controller.limited", "limited"),
        ),
    ),
}


def write_ssp(
    parameters: ParameterSet, directory: str | Path, fmi: Collection[int] = (2,)
) -> list[Path]:
    """Write `feedforward.ssp` (inverse, plant) and `feedback.ssp` (with a PI controller between).

    The controller's gains suit the plant (`it2hys.fmu.controller.suitable_gains`); another set of them
    can be put into `resources/controller.ssv`. The systems have the input `reference` and the outputs
    `displacement`, `measured`, `voltage` and `saturated`. For masters that read no connectors of a
    system, `feedforward_components.ssp` and `feedback_components.ssp` have those of the FMUs alone:
    there the reference is that of the inverse, and in the feedback system that of the controller too.
    With FMUs of FMI 3.0 these are `feedforward_fmi3_components.ssp` and `feedback_fmi3_components.ssp`.

    Parameters
    ----------
    parameters : ParameterSet
        Of plant and inverse.
    directory : path
        Created if it does not exist.
    fmi : collection of {2, 3}
        Versions of FMI.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the directory cannot be written to.
    """
    contents = {}
    for version in sorted(fmi):
        fmus, sets = _contents(parameters, version)
        ends = ("", COMPONENTS_ALONE) if version == 2 else (COMPONENTS_ALONE,)
        for name in (system + SUFFIX[version] + end for system in SYSTEMS for end in ends):
            contents[f"{name}.ssp"] = format_ssp(name, fmus, sets, parameters["sampleTime"])
    return write_together(directory, contents)


def _contents(parameters: ParameterSet, fmi: int) -> tuple[dict[str, bytes], dict[str, str]]:
    """Return FMUs and parameter sets by file name."""
    fmus = package_bytes(parameters, fmi=fmi)
    found = {component.fmu(fmi): fmus[component.identifier] for component in (INVERSE, PLANT)}
    types = {name: v.type for name, v in load_table().parameters().items()}
    scalars = {n: v for n, v in parameters.items() if "[" not in n and types[n].base != "Integer"}
    return {**found, CONTROL.fmu(fmi): controller_fmu(fmi)}, {
        "parameters.ssv": (
            format_ssv(parameters) if fmi == 2 else format_entries(scalars, types, parameters.name)
        ),
        "controller.ssv": format_controller_ssv(suitable_gains(parameters), parameters.name),
    }


def system_name(name: str) -> tuple[str, int]:
    """Return the system of a package, and its version of FMI, of the package's name."""
    system = name.removesuffix(COMPONENTS_ALONE)
    return system.removesuffix(SUFFIX[3]), 3 if system.endswith(SUFFIX[3]) else 2


def format_ssp(
    name: str, fmus: Mapping[str, bytes], sets: Mapping[str, str], sample_time: float
) -> bytes:
    """Return an SSP.

    Parameters
    ----------
    name : str
        "feedforward" or "feedback"; with "_fmi3" behind it, of FMUs of FMI 3.0; and with
        `COMPONENTS_ALONE` behind it, without the system's own connectors.
    fmus : mapping of str to bytes
        FMUs by file name; those that the system has not are left out.
    sets : mapping of str to str
        Parameter sets by file name, as SSV.
    sample_time : float
        In s; the default experiment lasts 2000 of them.
    """
    known, fmi = system_name(name)
    system = SYSTEMS[known]
    components = system.components.values()
    return fmu_archive(
        {
            "SystemStructure.ssd": format_ssd(name, system, sample_time),
            **{f"resources/{c.fmu(fmi)}": fmus[c.fmu(fmi)] for c in components},
            **{f"resources/{c.parameters}": sets[c.parameters].encode() for c in components},
        }
    )


def format_controller_ssv(values: Mapping[str, float], name: str) -> str:
    """Return a parameter set of the controller as SSV."""
    types = {v.name: v.type for v in load_controller().variables}
    return format_entries(values, types, name)


def format_ssd(name: str, system: System, sample_time: float) -> bytes:
    """Return SystemStructure.ssd; arguments as for `format_ssp`."""
    alone = name.endswith(COMPONENTS_ALONE)
    attributes = {"name": name, "version": "1.0"}
    root = etree.Element(f"{{{SSD}}}SystemStructureDescription", attributes, nsmap=NAMESPACES)
    outer = _add(root, SSD, "System", name=name)
    if not alone:
        own = system.connectors.items()
        _add_connectors(outer, ((label, kind, variable) for label, (kind, variable) in own))
    elements = _add(outer, SSD, "Elements")
    for label, component in system.components.items():
        element = _add(
            elements, SSD, "Component", name=label, type="application/x-fmu-sharedlibrary",
            source=f"resources/{component.fmu(system_name(name)[1])}",
        )  # fmt: skip
        _add_connectors(element, ((v.name, v.causality, v) for v in system.connected(label)))
        bindings = _add(element, SSD, "ParameterBindings")
        _add(bindings, SSD, "ParameterBinding", source=f"resources/{component.parameters}")
    connections = _add(outer, SSD, "Connections")
    for ends in system.inner if alone else system.connections:
        _add(connections, SSD, "Connection", **_end("start", ends[0]), **_end("end", ends[1]))
    _add_units(root, system)
    stop = DEFAULT_TICKS * sample_time
    _add(root, SSD, "DefaultExperiment", startTime="0.0", stopTime=repr(stop))
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def _add(parent: etree._Element, namespace: str, tag: str, **attributes: str) -> etree._Element:
    return etree.SubElement(parent, f"{{{namespace}}}{tag}", attributes)


def _add_connectors(parent: etree._Element, connectors: Iterable[tuple[str, str, Variable]]) -> None:
    """Add connectors, given as name, kind and the variable that has their type."""
    group = _add(parent, SSD, "Connectors")
    for name, kind, variable in connectors:
        connector = _add(group, SSD, "Connector", name=name, kind=kind)
        unit = {"unit": variable.type.unit} if variable.type.unit else {}
        _add(connector, SSC, variable.type.base, **unit)


def _add_units(root: etree._Element, system: System) -> None:
    """Add the definitions of the connectors' units."""
    connected = [v for label in system.components for v in system.connected(label)]
    used = {v.type.unit for v in connected if v.type.unit}
    units = _add(root, SSD, "Units")
    for name in sorted(used):
        exponents = load_controller().units[name].items()
        unit = _add(units, SSC, "Unit", name=name)
        _add(unit, SSC, "BaseUnit", **{k: str(v) for k, v in exponents if k != "display"})


def _end(side: str, end: str) -> dict[str, str]:
    """Return the attributes of one end of a connection; the system's own has no element."""
    component, dot, connector = end.rpartition(".")
    element = {f"{side}Element": component} if dot else {}
    return {**element, f"{side}Connector": connector}
