"""What the versions of FMI say in different words: all that a model description has of its version.

`it2hys.fmu.model_description` writes the rest, which is the same in both.

FMI 3.0 has arrays: a group of parameters is one of each field, as long as a structural parameter says.
`rule[1].centre`, `rule[2].centre`, … of FMI 2.0 are `rule.centre` there, at the value reference of the
first.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from lxml import etree

from it2hys.model.variables import DeclaredType, Variable

#: FMI 3.0's names for our base types.
BASES = {"Real": "Float64", "Integer": "UInt64", "Boolean": "Boolean"}
Start = Mapping[str, float | int | bool]


@dataclass(frozen=True)
class Content:
    """What a model description says in any version of FMI.

    Attributes
    ----------
    identifier, token, description : str
        Model identifier, GUID and a sentence.
    variables : sequence of Variable
        The scalars of FMI 2.0, in the order of their value references.
    start : mapping
        Start values by name; those of the table are used where there is none.
    rows : int
        Value references of the binary's table; FMI 3.0's time is behind them.
    sample_time : float
        In s.
    units : mapping
        Definitions by name.
    counts : mapping
        Name of the parameter that says how many elements a group has, by group.
    derivatives, interpolates : bool
        Are there derivatives, and does a step take those of its inputs?
    source_files : sequence of str
        C files in `sources/`.
    """

    identifier: str
    token: str
    description: str
    variables: Sequence[Variable]
    start: Start
    rows: int
    sample_time: float
    units: Mapping[str, Mapping]
    source_files: Sequence[str]
    counts: Mapping[str, str] = field(default_factory=dict)
    derivatives: bool = True
    interpolates: bool = True

    def start_of(self, variable: Variable) -> float | int | bool | None:
        """Return the start value of a variable."""
        return self.start.get(variable.name, variable.start)

    def known_at_start(self, output: Variable) -> list[Variable]:
        """Return what an output depends on before the first tick.

        These are parameters, but not those of an effect of which this FMU has no element: how the play
        operators began, for instance.
        """
        without = set(self.counts) - {v.group for v in self.variables}
        return [
            v
            for v in self.variables
            if (v.name in output.depends or v.group in output.depends) and v.effect not in without
        ]

    @property
    def outputs(self) -> list[Variable]:
        """The outputs."""
        return [v for v in self.variables if v.causality == "output"]


class Version(ABC):
    """A version of FMI: the differences from the others."""

    number: int
    name: str
    #: Of the root element: what the token is called.
    token: str

    @abstractmethod
    def capabilities(self, content: Content) -> dict[str, str]:
        """Return the capability flags of co-simulation."""

    @abstractmethod
    def add_source_files(self, slave: etree._Element, content: Content) -> None:
        """List the C files, where they stand in the model description."""

    @abstractmethod
    def add_type(self, parent: etree._Element, declared: DeclaredType) -> None:
        """Add a declared type."""

    @abstractmethod
    def add_variables(self, parent: etree._Element, content: Content) -> None:
        """Add the variables."""

    @abstractmethod
    def add_structure(self, parent: etree._Element, content: Content) -> None:
        """Say what depends on what.

        At a communication point an output is held since the last tick: it depends on no input that is
        set there, so there is no algebraic loop.
        """


class Fmi2(Version):
    """FMI 2.0."""

    number, name, token = 2, "2.0", "guid"

    def capabilities(self, content: Content) -> dict[str, str]:
        """Return the capability flags of co-simulation."""
        return {
            "canHandleVariableCommunicationStepSize": "true",
            "canInterpolateInputs": text_of(content.interpolates),
            "maxOutputDerivativeOrder": "0",
            "canRunAsynchronuously": "false",
            "canBeInstantiatedOnlyOncePerProcess": "false",
            "canNotUseMemoryManagementFunctions": "true",
            "canGetAndSetFMUstate": "true",
            "canSerializeFMUstate": "true",
            "providesDirectionalDerivative": text_of(content.derivatives),
        }

    def add_source_files(self, slave: etree._Element, content: Content) -> None:
        """List the C files."""
        files = etree.SubElement(slave, "SourceFiles")
        for name in content.source_files:
            etree.SubElement(files, "File", name=name)

    def add_type(self, parent: etree._Element, declared: DeclaredType) -> None:
        """Add a declared type."""
        simple = etree.SubElement(parent, "SimpleType", name=declared.name)
        etree.SubElement(simple, declared.base, **_type_attributes(declared))

    def add_variables(self, parent: etree._Element, content: Content) -> None:
        """Add the variables, all scalars."""
        for variable in content.variables:
            scalar = etree.SubElement(parent, "ScalarVariable", **_common_attributes(variable))
            typed = _typed_attributes(variable)
            if variable.causality != "output":
                typed["start"] = text_of(content.start_of(variable))
            if variable.type.base == "Integer":  # a count: the FMU has no more than its set
                typed["max"] = typed["start"]
            etree.SubElement(scalar, variable.type.base, **typed)

    def add_structure(self, parent: etree._Element, content: Content) -> None:
        """Say what depends on what, by the places of variables."""
        place = {v: str(i) for i, v in enumerate(content.variables, start=1)}
        outputs = etree.SubElement(parent, "Outputs")
        initial = etree.SubElement(parent, "InitialUnknowns")
        for output in content.outputs:
            etree.SubElement(outputs, "Unknown", index=place[output], dependencies="")
            known = " ".join(place[v] for v in content.known_at_start(output))
            etree.SubElement(initial, "Unknown", index=place[output], dependencies=known)


class Fmi3(Version):
    """FMI 3.0."""

    number, name, token = 3, "3.0", "instantiationToken"

    def capabilities(self, content: Content) -> dict[str, str]:
        """Return the capability flags of co-simulation."""
        return {
            "needsExecutionTool": "false",
            "canBeInstantiatedOnlyOncePerProcess": "false",
            "canGetAndSetFMUState": "true",
            "canSerializeFMUState": "true",
            "providesDirectionalDerivatives": text_of(content.derivatives),
            "providesAdjointDerivatives": text_of(content.derivatives),
            "providesPerElementDependencies": "false",
            "canHandleVariableCommunicationStepSize": "true",
            "fixedInternalStepSize": text_of(content.sample_time),
            "maxOutputDerivativeOrder": "0",
            "recommendedIntermediateInputSmoothness": "0",
            "providesIntermediateUpdate": "true",
            "mightReturnEarlyFromDoStep": "true",
            "canReturnEarlyAfterIntermediateUpdate": "true",
            "hasEventMode": "false",
            "providesEvaluateDiscreteStates": "false",
        }

    def add_source_files(self, slave: etree._Element, content: Content) -> None:
        """Add nothing: buildDescription.xml lists them."""

    def add_type(self, parent: etree._Element, declared: DeclaredType) -> None:
        """Add a declared type."""
        tag = f"{BASES[declared.base]}Type"
        etree.SubElement(parent, tag, name=declared.name, **_type_attributes(declared))

    def add_variables(self, parent: etree._Element, content: Content) -> None:
        """Add the time, scalars, and arrays with the structural parameters that say their lengths."""
        etree.SubElement(
            parent,
            "Float64",
            name="time",
            valueReference=str(content.rows),
            description="Time",
            causality="independent",
            variability="continuous",
        )
        for elements in _by_field(content.variables):
            first = elements[0]
            attributes = {**_common_attributes(first), **_typed_attributes(first)}
            if first.type.base == "Integer":
                attributes["causality"] = "structuralParameter"
            if first.causality == "input":
                attributes["intermediateUpdate"] = "true"
            if first.causality != "output":
                attributes["start"] = " ".join(text_of(content.start_of(v)) for v in elements)
            if first.group:
                attributes["name"] = f"{first.group}.{first.field}"
            element = etree.SubElement(parent, BASES[first.type.base], **attributes)
            if first.group:
                count = next(v for v in content.variables if v.name == content.counts[first.group])
                etree.SubElement(element, "Dimension", valueReference=str(count.value_reference))

    def add_structure(self, parent: etree._Element, content: Content) -> None:
        """Say what depends on what, by value references."""
        for output in content.outputs:
            reference = str(output.value_reference)
            etree.SubElement(parent, "Output", valueReference=reference, dependencies="")
        for output in content.outputs:
            known = [v for v in content.known_at_start(output) if v.index in (None, 1)]
            etree.SubElement(
                parent,
                "InitialUnknown",
                valueReference=str(output.value_reference),
                dependencies=" ".join(str(v.value_reference) for v in known),
            )


#: Versions by number.
VERSIONS: dict[int, Version] = {version.number: version for version in (Fmi2(), Fmi3())}


def text_of(value: object) -> str:
    """Return a value as XML has it."""
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else repr(value)


def _by_field(variables: Iterable[Variable]) -> list[list[Variable]]:
    """Return scalars alone, and the elements of an array together, in the order of the first ones."""
    found: dict[object, list[Variable]] = {}
    for v in variables:
        found.setdefault((v.group, v.field) if v.group else v.value_reference, []).append(v)
    return list(found.values())


def _common_attributes(variable: Variable) -> dict[str, str]:
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
    return attributes


def _typed_attributes(variable: Variable) -> dict[str, str]:
    typed = {"declaredType": variable.type.name}
    if variable.type.unit:
        typed["unit"] = variable.type.unit
    if variable.type.displayUnit:
        typed["displayUnit"] = variable.type.displayUnit
    return typed


def _type_attributes(declared: DeclaredType) -> dict[str, str]:
    if declared.base == "Boolean":
        return {}
    return {
        key: text_of(value)
        for key in ("quantity", "unit", "displayUnit", "min", "max", "nominal")
        if (value := getattr(declared, key)) is not None
    }
