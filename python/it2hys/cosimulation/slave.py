"""One instance of an FMU through FMPy: unpacking, initialization, values, single steps."""

import ctypes
import math
import tempfile
from collections.abc import Mapping
from contextlib import ExitStack
from itertools import chain
from pathlib import Path

import fmpy
from fmpy import fmi2
from fmpy.model_description import ModelDescription, ScalarVariable, SimpleType

from it2hys.cosimulation.archive import check_archive, is_plain_name, unpack
from it2hys.cosimulation.faces import FACES, MOST_ELEMENTS
from it2hys.errors import InputError
from it2hys.support.keys import known_names
from it2hys.support.numerals import parse_number

# messages kept of one run: a foreign FMU may log every step
LARGEST_LOG = 20
#: The same in all versions of FMI.
WARNING, FATAL = fmi2.fmi2Warning, fmi2.fmi2Fatal


class _Explained:
    """Turns FMPy's exceptions about a slave into the FMU's own words."""

    def __init__(self, slave: "Slave") -> None:
        self._slave = slave

    def __enter__(self) -> None:
        pass

    def __exit__(self, _type: object, error: BaseException | None, _traceback: object) -> None:
        if not isinstance(error, Exception) or isinstance(error, InputError):
            return
        if getattr(error, "status", None) == FATAL:
            self._slave.abandon()
        raise self._slave.fault(str(error)) from None


class Slave:
    """One instance of an FMU for co-simulation, initialised and ready to step.

    Use as a context manager. Messages of the FMU since its last initialization are collected in
    `messages`, and `warned` tells whether there was a warning among them. An instance is used again by
    `initialize`.

    Parameters
    ----------
    path : path
        The FMU.
    start_values : mapping, optional
        Parameters and inputs by name, in SI units, set before initialization.

    Raises
    ------
    InputError
        If the file is no FMU for co-simulation, has no such variable, or refuses the values.
    """

    def __init__(self, path: str | Path, start_values: Mapping | None = None) -> None:
        self.path = Path(path)
        self.messages: list[str] = []
        self.warned = False
        self._stack = ExitStack()
        self._fmu = None
        self._sample_time: float | None = None
        self._sample_time_set = False
        self._explained = _Explained(self)
        try:
            self._open()
            self.initialize(start_values)
        except BaseException:
            self.close()
            raise

    def _open(self) -> None:
        self.description = read_description(self.path)
        self.variables = {v.name: v for v in self.description.modelVariables}
        # removed at the end of the process, too
        directory = tempfile.TemporaryDirectory(prefix="it2hys-", ignore_cleanup_errors=True)
        self._directory = self._stack.enter_context(directory)
        unpack(self.path, self._directory)
        self._arrays: dict[int, list[str]] = {}
        for name, variable in self.variables.items():
            if variable.dimensions:
                self._arrays.setdefault(variable.valueReference, []).append(name)
        self._elements: dict[int, list] = {}  # of arrays, as they were set
        self.face = FACES[self.description.fmiVersion](self._hear)
        self._stack.callback(self._free)

    def _instantiate(self) -> None:
        self._fmu = self.face.instantiate(
            guid=self.description.guid,
            unzipDirectory=self._directory,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=self.path.stem,
            libraryPath=self._library(),
        )

    def _library(self) -> str | None:
        """Return the binary for this very processor, where there is one; FMPy looks for x86's alone."""
        identifier = self.description.coSimulation.modelIdentifier
        name = f"{identifier}{fmpy.sharedLibraryExtension}"
        library = Path(self._directory, "binaries", fmpy.platform_tuple, name)
        return str(library) if library.is_file() else None

    def _hear(self, status: int, message: bytes) -> None:
        self.warned |= status == WARNING
        if len(self.messages) < LARGEST_LOG:
            self.messages.append(message.decode(errors="replace").strip())

    def fault(self, text: str) -> InputError:
        """Return an error in the FMU's own words, or in the given ones if it has said nothing."""
        return InputError(f"{self.path}: {self.messages[-1] if self.messages else text}")

    def abandon(self) -> None:
        """Leave the instance alone after a fatal status, which forbids even to free it."""
        self._fmu = None

    def _free(self) -> None:
        if self._fmu is not None:
            self._fmu.freeInstance()

    def close(self) -> None:
        """Free the instance and its files."""
        self._stack.close()

    def __enter__(self) -> "Slave":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- initialization ------------------------------------------------------------------------

    def initialize(self, start_values: Mapping | None = None) -> None:
        """Initialize, the first time or again: nothing of an earlier run is left."""
        self.begin(start_values)
        self.ready()

    def renew(self, start_values: Mapping) -> None:
        """Forget an earlier run, before the instance is reset and these values are set.

        An instance is made where there is none: at first, and after a fatal status.
        """
        self.messages.clear()
        self.warned = False
        given = "sampleTime" in start_values
        if self._sample_time_set or given:
            self._sample_time, self._sample_time_set = None, given
        self._elements.clear()
        if self._fmu is None:
            with self._explained:
                self._instantiate()

    def begin(self, start_values: Mapping | None = None) -> None:
        """Enter initialization mode: outputs can be read, inputs be set, until `ready`."""
        used = self._fmu is not None
        self.renew(start_values or {})
        with self._explained:
            if used:
                self._fmu.reset()
            self.face.set_up(self._fmu)
            self.set(start_values or {})
            self.face.enter_initialization(self._fmu)

    def ready(self) -> None:
        """Leave initialization mode."""
        with self._explained:
            self._fmu.exitInitializationMode()

    # --- variables -----------------------------------------------------------------------------

    def names(self, causality: str) -> list[str]:
        """Return the names of the variables of one causality, in the FMU's order."""
        return [n for n, v in self.variables.items() if v.causality == causality]

    def variable(self, name: str) -> ScalarVariable:
        """Return FMPy's description of a variable; raises InputError if there is none."""
        if name not in self.variables:
            known = known_names(name, list(self.variables))
            raise InputError(f"{self.path}: the FMU has no variable {name!r}; {known}")
        return self.variables[name]

    @property
    def model(self) -> str:
        """Name of the model."""
        return self.description.modelName

    @property
    def sample_time(self) -> float | None:
        """The parameter `sampleTime` in s; None for an FMU that has none."""
        if "sampleTime" not in self.variables:
            return None
        if self._sample_time is None or self.variables["sampleTime"].causality != "parameter":
            self._sample_time = self.get("sampleTime")
        return self._sample_time

    def set(self, values: Mapping) -> None:
        """Set variables by name; those of one type together."""
        by_base: dict[str, dict[int, list]] = {}
        if "sampleTime" in values:
            self._sample_time, self._sample_time_set = None, True
        for name, value in values.items():
            variable = self.variable(name)
            base, convert = self._typed(variable)
            numbers = [convert(value)]
            if variable.dimensions:  # an array is set as a whole
                numbers = self._elements_with(variable, *numbers)
            by_base.setdefault(base, {})[variable.valueReference] = numbers
        with self._explained:
            for base, numbers_of in by_base.items():
                setter = getattr(self._fmu, f"set{base}")
                setter(list(numbers_of), list(chain.from_iterable(numbers_of.values())))

    def get(self, name: str) -> float | int | bool:
        """Return the value of a variable."""
        variable = self.variable(name)
        getter = getattr(self._fmu, f"get{self._typed(variable)[0]}")
        with self._explained:
            if not variable.dimensions:
                return getter([variable.valueReference])[0]
            elements = getter([variable.valueReference], math.prod(variable.shape))
            return elements[self._place(variable)]

    def _typed(self, variable: ScalarVariable) -> tuple[str, type]:
        """Return what the FMI functions of a variable are named by, and what it is in Python."""
        if variable.type not in self.face.types:
            raise InputError(
                f"{self.path}: {variable.name} is of the type {variable.type}, which is not taken here"
            )
        return self.face.types[variable.type]

    def _place(self, element: ScalarVariable) -> int:
        """Return the place of an element in its array."""
        return self._arrays[element.valueReference].index(element.name)

    def _elements_with(self, element: ScalarVariable, value: float | int | bool | str) -> list:
        """Return an array with a new value of one element; the others are as set before, or begin."""
        reference = element.valueReference
        if reference not in self._elements:
            starts = [self.variables[name].start for name in self._arrays[reference]]
            if None in starts:
                raise InputError(
                    f"{self.path}: {element.name} is of an array without start values, or of more than "
                    f"{MOST_ELEMENTS} elements; it cannot be set"
                )
            _, convert = self._typed(element)
            self._elements[reference] = [
                start == "true" if convert is bool else convert(parse_number(start)) for start in starts
            ]
        self._elements[reference][self._place(element)] = value
        return self._elements[reference]

    # --- steps ---------------------------------------------------------------------------------

    @property
    def instance(self) -> int:
        """Address of the instance, for compiled code."""
        return self._fmu.component

    def function(self, name: str) -> int:
        """Return the address of an FMI function, for compiled code."""
        return ctypes.cast(getattr(self._fmu.dll, name), ctypes.c_void_p).value

    def tick(self, k: int, values: Mapping) -> None:
        """Run tick `k` with the given inputs."""
        self.step(k * self.sample_time, self.sample_time, values)

    def step(self, time: float, size: float, values: Mapping) -> None:
        """Set inputs and make one communication step from `time`, s."""
        self.set(values)
        with self._explained:
            self._fmu.doStep(time, size)


def read_description(path: Path) -> ModelDescription:
    """Read the model description of an FMU that can be stepped here.

    Raises
    ------
    InputError
        If the file is missing, is no FMU, is one that could write or load what is outside of it,
        or one of another kind: not FMI 2.0 or 3.0, not for co-simulation, or without a binary for
        this platform.
    """
    check_archive(path)
    try:
        description = fmpy.read_model_description(str(path), validate=False)
        platforms = fmpy.supported_platforms(str(path))
    except Exception as error:
        raise InputError(f"{path}: not an FMU: {error}") from None
    if description.fmiVersion not in FACES:
        raise InputError(
            f"{path}: this is an FMU of FMI {description.fmiVersion}; "
            f"FMI {' or '.join(FACES)} is needed here"
        )
    if description.coSimulation is None:
        raise InputError(f"{path}: not an FMU for co-simulation")
    identifier = description.coSimulation.modelIdentifier or ""
    if not is_plain_name(identifier):
        raise InputError(f"{path}: modelIdentifier is {identifier!r}; it must be the name of a binary")
    if not {fmpy.platform, fmpy.platform_tuple} & set(platforms):
        raise InputError(f"{path}: this FMU has no binary for this platform, {fmpy.platform}")
    for variable in description.modelVariables:
        _check_numbers(path, f"variable {variable.name!r}", variable)
    for declared in description.typeDefinitions:
        _check_numbers(path, f"type {declared.name!r}", declared)
    try:
        FACES[description.fmiVersion].complete(description)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return description


def _check_numbers(path: Path, owner: str, holder: ScalarVariable | SimpleType) -> None:
    """Refuse attributes that must be numbers and are not."""
    if holder.type in ("Boolean", "String", "Binary", "Clock"):
        return
    several = getattr(holder, "dimensions", None)
    for name in ("start", "min", "max", "nominal"):
        text = getattr(holder, name, None)
        try:
            for number in [] if text is None else text.split() if several else [text]:
                parse_number(number)
        except ValueError:
            raise InputError(f"{path}: {owner}: {name} is {text!r}; it must be a number") from None
