"""Instances of FMUs of FMI 3.0 behind FMPy for the tests."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from conftest import CALM, INPUT, OUTPUT, TS, Unpacked
from fmpy import fmi3
from fmpy.fmi1 import FMICallException

OK, WARNING, DISCARD, ERROR = range(4)


class Instance:
    """One instance behind FMPy's `FMU3Slave`, with its messages; frees itself.

    Parameters
    ----------
    unpacked : Unpacked
    early : bool
        Value of `earlyReturnAllowed`.
    update : callable, optional
        Called with this instance and the time in intermediate update mode; may return when to end
        the step.
    library : Path, optional
        Other than the FMU's own binary.
    """

    def __init__(
        self,
        unpacked: Unpacked,
        early: bool = False,
        update: Callable[["Instance", float], float | None] | None = None,
        library: Path | None = None,
        events: bool = False,
    ) -> None:
        self.unpacked, self.messages, self._update = unpacked, [], update
        self.fmu = fmi3.FMU3Slave(
            guid=unpacked.description.instantiationToken,
            unzipDirectory=str(unpacked.directory),
            modelIdentifier=unpacked.identifier,
            instanceName="instance",
            libraryPath=str(library) if library else None,
        )
        try:
            self.fmu.instantiate(
                loggingOn=True,
                earlyReturnAllowed=early,
                eventModeUsed=events,
                logMessage=self._log,
                intermediateUpdate=self._updated if update else None,
            )
            self.made = True
        except Exception:
            self.made = False
            self.fmu.component = None

    def _log(self, _env: object, status: int, category: bytes, text: bytes) -> None:
        self.messages.append((status, category.decode(), text.decode()))

    def _updated(self, _env, time, settable, gettable, finished, can_end, asked, end) -> None:
        assert settable and gettable and finished
        wanted = self._update(self, time)
        if wanted is not None and can_end:
            asked[0], end[0] = True, wanted

    def status_of(self, call: Callable, *arguments: object) -> int:
        """Return the status of a call, which FMPy raises if it is above a warning."""
        try:
            return call(*arguments) or OK
        except FMICallException as error:
            return error.status

    def reference(self, name: str) -> int:
        """Return a value reference."""
        return self.unpacked.variables[name].valueReference

    def assign(self, values: dict) -> None:
        """Set variables by name; arrays from sequences."""
        for name, value in values.items():
            numbers = list(np.atleast_1d(value))
            setter = getattr(self.fmu, f"set{self.unpacked.variables[name].type}")
            setter([self.reference(name)], numbers)

    def get(self, name: str, count: int | None = None) -> object:
        """Return the value of a variable; of an array that has `count` elements, their list."""
        getter = getattr(self.fmu, f"get{self.unpacked.variables[name].type}")
        values = getter([self.reference(name)], 1 if count is None else count)
        return values[0] if count is None else values

    def configure(self, counts: dict[str, int]) -> None:
        """Set structural parameters in configuration mode."""
        self.fmu.enterConfigurationMode()
        self.assign(counts)
        self.fmu.exitConfigurationMode()

    def initialize(self, start: dict | None = None, **times: float) -> "Instance":
        """Go through initialization with start values; return self."""
        self.assign(start or {})
        self.fmu.enterInitializationMode(**times)
        self.fmu.exitInitializationMode()
        return self

    def step(self, time: float, size: float) -> tuple[bool, bool, float]:
        """Make a step; return terminateSimulation, earlyReturn and lastSuccessfulTime."""
        event, *rest = self.fmu.doStep(time, size)
        assert not event
        return tuple(rest)

    def run(self, signal: Sequence[float], first: int = 0) -> list[float]:
        """Return the output of every tick for the input at every tick."""
        model, read = self.unpacked.model, []
        for k, value in enumerate(signal, start=first):
            self.assign({INPUT[model]: float(value)})
            self.step(k * TS, TS)
            read.append(self.get(OUTPUT[model]))
        return read

    def close(self) -> None:
        """Free the instance."""
        if self.fmu.component:
            self.fmu.freeInstance()
        self.fmu.component = None

    def __enter__(self) -> "Instance":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def swing(model: str, count: int = 300) -> np.ndarray:
    """Return an input that visits most of the range."""
    return CALM[model] * (1 - np.cos(2 * np.pi * 3 * np.arange(count) / count))
