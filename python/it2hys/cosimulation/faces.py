"""What FMI 2.0 and FMI 3.0 say in different words: a thin face of FMPy's classes for each.

FMI 3.0 has arrays. Here their elements are variables, named as FMI 2.0 names them: those of `x` are
`x[1]`, `x[2]`, …, and those of `rule.q2`, whose length is `ruleCount`, are `rule[1].q2`, …
"""

from __future__ import annotations

import copy
import ctypes
import itertools
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from math import prod
from typing import ClassVar

from fmpy import fmi2, fmi3
from fmpy.fmi1 import _FMU
from fmpy.model_description import ModelDescription, ModelVariable

from it2hys.errors import InputError
from it2hys.model.compiled import library_function

#: Listens to what an FMU logs: its status and text.
Hear = Callable[[int, bytes], None]
_LISTENER = ctypes.CFUNCTYPE(None, ctypes.c_int, ctypes.c_char_p)
#: Elements of an array that are variables; a larger one has none, and cannot be set.
MOST_ELEMENTS = 10_000


class Face(ABC):
    """Calls of an FMU in the words of one version of FMI.

    Parameters
    ----------
    hear : callable
        Told what the FMU logs.
    """

    number: int
    #: Before the names of its functions and statuses.
    prefix: str
    #: Base of a type, which its functions are named by, and what it is in Python.
    types: ClassVar[Mapping[str, tuple[str, type]]]
    #: Functions of an instance, by their places in `struct stepper_turn` of stepper.c.
    functions: ClassVar[Mapping[str, str]] = {
        "step": "DoStep",
        "reset": "Reset",
        "enter": "EnterInitializationMode",
        "leave": "ExitInitializationMode",
    }
    #: Where variables of a base are in a step, by `enum held` of stepper.c. No others are connected.
    held: ClassVar[Mapping[str, int]]

    @abstractmethod
    def __init__(self, hear: Hear) -> None: ...

    @abstractmethod
    def instantiate(self, **where: str | None) -> _FMU:
        """Return a new instance, of a binary that FMPy's arguments name."""

    @abstractmethod
    def set_up(self, fmu: _FMU) -> None:
        """Do what is done before values are set."""

    @abstractmethod
    def enter_initialization(self, fmu: _FMU) -> None:
        """Enter initialization mode; the run begins at 0 s."""

    @staticmethod
    @abstractmethod
    def complete(description: ModelDescription) -> None:
        """Put scalars in the place of arrays in a model description."""


class Fmi2(Face):
    """FMI 2.0."""

    number, prefix = 2, "fmi2"
    functions: ClassVar = {**Face.functions, "setup": "SetupExperiment"}
    types: ClassVar = {
        "Real": ("Real", float),
        "Integer": ("Integer", int),
        "Enumeration": ("Integer", int),  # its items are handed over as integers
        "Boolean": ("Boolean", bool),
        "String": ("String", str),
    }
    held: ClassVar = {"Real": 0, "Integer": 1, "Boolean": 2}

    def __init__(self, hear: Hear) -> None:
        # kept, because the library holds a pointer to them
        self._callbacks = fmi2.fmi2CallbackFunctions()
        self._callbacks.logger = ctypes.cast(
            library_function("it2core_stepper_log"), fmi2.fmi2CallbackLoggerTYPE
        )
        self._listener = _LISTENER(hear)
        self._environment = ctypes.pointer(self._listener)
        self._callbacks.componentEnvironment = ctypes.cast(self._environment, ctypes.c_void_p)
        self._callbacks.allocateMemory = fmi2.defaultCallbacks.allocateMemory
        self._callbacks.freeMemory = fmi2.defaultCallbacks.freeMemory

    def instantiate(self, **where: str | None) -> _FMU:
        """Return a new instance."""
        fmu = fmi2.FMU2Slave(**where)
        fmu.instantiate(callbacks=self._callbacks, loggingOn=True)
        return fmu

    def set_up(self, fmu: _FMU) -> None:
        """Tell when the run begins."""
        fmu.setupExperiment(startTime=0.0)

    def enter_initialization(self, fmu: _FMU) -> None:
        """Enter initialization mode."""
        fmu.enterInitializationMode()

    @staticmethod
    def complete(description: ModelDescription) -> None:
        """Leave it as it is: there are no arrays."""


class Fmi3(Face):
    """FMI 3.0: without events, early returns, and updates within a step."""

    number, prefix = 3, "fmi3"
    types: ClassVar = {
        **{f"Float{bits}": (f"Float{bits}", float) for bits in (32, 64)},
        **{f"Int{bits}": (f"Int{bits}", int) for bits in (8, 16, 32, 64)},
        **{f"UInt{bits}": (f"UInt{bits}", int) for bits in (8, 16, 32, 64)},
        "Enumeration": ("Int64", int),  # its items are handed over as integers
        "Boolean": ("Boolean", bool),
        "String": ("String", str),
    }  # fmt: skip
    held: ClassVar = {"Float64": 0, "Int32": 1, "Boolean": 3}

    def __init__(self, hear: Hear) -> None:
        self._hear = hear

    def instantiate(self, **where: str | None) -> _FMU:
        """Return a new instance."""
        fmu = fmi3.FMU3Slave(**where)
        fmu.instantiate(loggingOn=True, logMessage=self._log)
        return fmu

    def _log(self, _environment: object, status: int, _category: bytes, text: bytes) -> None:
        if status != fmi3.fmi3OK:  # some FMUs tell of every call
            self._hear(status, text)

    def set_up(self, fmu: _FMU) -> None:
        """Do nothing: entering initialization mode tells when the run begins."""

    def enter_initialization(self, fmu: _FMU) -> None:
        """Enter initialization mode."""
        fmu.enterInitializationMode(startTime=0.0)

    @staticmethod
    def complete(description: ModelDescription) -> None:
        """Put elements in the place of arrays."""
        description.modelVariables = [
            v for variable in description.modelVariables for v in _elements(variable)
        ]


#: By the version in a model description.
FACES: dict[str, type[Face]] = {"2.0": Fmi2, "3.0": Fmi3}


def _elements(array: ModelVariable) -> list[ModelVariable]:
    """Return the elements of an array, each with its own start; a scalar is its only one."""
    if not array.dimensions:
        return [array]
    shape = tuple(array.shape or ())
    indices = itertools.product(*(range(1, length + 1) for length in shape))
    size = prod(shape)
    if size > MOST_ELEMENTS:
        whole = copy.copy(array)
        whole.start = None  # not to be read as a number
        return [whole]
    starts = (array.start or "").split() if isinstance(array.start, str) else []
    if len(starts) == 1:
        starts *= size
    if starts and len(starts) != size:
        raise InputError(f"variable {array.name!r}: start has {len(starts)} values, not {size}")
    group, dot, field = array.name.partition(".")
    counted = dot and [d.variable.name for d in array.dimensions if d.variable] == [f"{group}Count"]
    made = []
    for k, index in enumerate(indices):
        element = copy.copy(array)
        place = f"[{','.join(map(str, index))}]"
        element.name = f"{group}{place}.{field}" if counted else f"{array.name}{place}"
        element.start = starts[k] if starts else None
        made.append(element)
    return made


def untransferable(face: type[Face], variable: ModelVariable) -> str | None:
    """Return what forbids to connect or record a variable; None if nothing does."""
    if variable.dimensions:
        return "is an element of an array; scalar variables can be connected and recorded"
    base = face.types.get(variable.type, ("", object))[0]
    if base not in face.held:
        article = "an" if variable.type[0] in "AEIOU" else "a"
        known = ", ".join(face.held)
        return f"is {article} {variable.type}; variables of {known} can be connected and recorded"
    return None
