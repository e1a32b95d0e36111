"""Running FMUs through FMPy, tick by tick.

A row of a result belongs to one tick: the inputs at the tick's time and the outputs computed from
them. In co-simulation those outputs are read at the end of the step that begins at the tick.
"""

import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

import fmpy
import numpy as np
from fmpy import fmi2

from it2hys.errors import InputError

Values = Mapping[str, np.ndarray | float]


class Slave:
    """One instance of one of our FMUs, initialised and ready to step.

    Use as a context manager. Messages of the FMU are collected in `messages`.

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
        self._stack = ExitStack()
        try:
            self._open(start_values or {})
        except BaseException:
            self.close()
            raise

    def _open(self, start_values: Mapping) -> None:
        description = _read_description(self.path)
        if description.coSimulation is None:
            raise InputError(f"{self.path}: not an FMU for co-simulation")
        self.variables = {v.name: v for v in description.modelVariables}
        directory = tempfile.mkdtemp(prefix="it2hys-")
        self._stack.callback(shutil.rmtree, directory, ignore_errors=True)
        fmpy.extract(str(self.path), directory)
        # kept, because the library holds a pointer to them
        self._callbacks = fmi2.fmi2CallbackFunctions()
        self._callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(self._log)
        self._fmu = fmi2.FMU2Slave(
            guid=description.guid,
            unzipDirectory=directory,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=self.path.stem,
        )
        with self._explained():
            self._fmu.instantiate(callbacks=self._callbacks, loggingOn=True)
            self._stack.callback(self._free)
            self._fmu.setupExperiment(startTime=0.0)
            self._set(start_values)
            self._fmu.enterInitializationMode()
            self._fmu.exitInitializationMode()
        self.sample_time = self.get("sampleTime")

    def _log(self, _environment, _name, status: int, _category, message: bytes) -> None:
        if status != fmi2.fmi2OK:
            self.messages.append(message.decode().replace("%%", "%"))

    @contextmanager
    def _explained(self) -> Iterator[None]:
        """Turn FMPy's exceptions into the FMU's own words."""
        try:
            yield
        except InputError:
            raise
        except Exception as error:
            said = self.messages[-1] if self.messages else str(error)
            raise InputError(f"{self.path}: {said}") from None

    def _free(self) -> None:
        self._fmu.freeInstance()

    def close(self) -> None:
        """Free the instance and its files."""
        self._stack.close()

    def __enter__(self) -> "Slave":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def names(self, causality: str) -> list[str]:
        """Return the names of the variables of one causality, in the FMU's order."""
        return [n for n, v in self.variables.items() if v.causality == causality]

    def _set(self, values: Mapping) -> None:
        for name, value in values.items():
            if name not in self.variables:
                raise InputError(f"{self.path}: the FMU has no variable {name!r}")
            variable = self.variables[name]
            getattr(self._fmu, f"set{variable.type}")([variable.valueReference], [value])

    def get(self, name: str) -> float | int | bool:
        """Return the value of a variable."""
        variable = self.variables[name]
        return getattr(self._fmu, f"get{variable.type}")([variable.valueReference])[0]

    def tick(self, k: int, values: Values) -> None:
        """Run tick `k` with the given inputs."""
        with self._explained():
            self._set(values)
            self._fmu.doStep(k * self.sample_time, self.sample_time)


def _read_description(path: Path) -> fmpy.model_description.ModelDescription:
    try:
        return fmpy.read_model_description(str(path), validate=False)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except Exception as error:
        raise InputError(f"{path}: not an FMU: {error}") from None


def simulate(
    fmu: str | Path,
    inputs: Values,
    start_values: Mapping | None = None,
    progress: Callable[[Iterator[int]], Iterator[int]] = iter,
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Run an FMU over input signals, one tick per sample.

    Parameters
    ----------
    fmu : path
        The FMU.
    inputs : mapping of str to ndarray, shape (N,)
        Inputs by name, in SI units, sampled at the FMU's `sampleTime`.
    start_values : mapping, optional
        Parameters by name.
    progress : callable, optional
        Wraps the iteration over ticks, as `tqdm.tqdm` does.

    Returns
    -------
    outputs : dict of str to ndarray, shape (N,)
        Outputs by name; element k belongs to tick k.
    messages : list of str
        What the FMU logged.

    Raises
    ------
    InputError
        If the FMU cannot be run or refuses a value.
    """
    signals = {name: np.asarray(value, dtype=float) for name, value in inputs.items()}
    lengths = {len(s) for s in signals.values()}
    if len(lengths) != 1:
        raise InputError(f"input signals must have one length, not {sorted(lengths)}")
    ticks = lengths.pop()
    with Slave(fmu, start_values) as slave:
        for name in set(signals) - set(slave.names("input")):
            raise InputError(f"{slave.path}: the FMU has no input {name!r}")
        outputs = {name: np.empty(ticks) for name in slave.names("output")}
        for k in progress(range(ticks)):
            slave.tick(k, {name: float(signal[k]) for name, signal in signals.items()})
            for name, output in outputs.items():
                output[k] = slave.get(name)
        return outputs, slave.messages


def track(
    inverse: str | Path,
    plant: str | Path | Callable[[float], float],
    reference: np.ndarray,
    start_values: Mapping | None = None,
) -> dict[str, np.ndarray]:
    """Run a reference through the inverse FMU and its voltage through a plant, tick for tick.

    Parameters
    ----------
    inverse : path
        The inverse FMU.
    plant : path or callable
        The plant FMU, or a function from the voltage of a tick to the displacement in m.
    reference : ndarray, shape (N,)
        Desired displacement in m.
    start_values : mapping, optional
        Parameters for the FMUs, such as ``initialDisplacement``.

    Returns
    -------
    dict of str to ndarray, shape (N,)
        `voltage` in V, `displacement` in m and `saturated`.
    """
    result = {name: np.empty(len(reference)) for name in ("voltage", "displacement", "saturated")}
    with ExitStack() as stack:
        feedforward = stack.enter_context(Slave(inverse, start_values))
        if not callable(plant):
            plant = _plant_function(stack.enter_context(Slave(plant, start_values)))
        for k, desired in enumerate(reference):
            feedforward.tick(k, {"reference": float(desired)})
            voltage = feedforward.get("voltage")
            result["voltage"][k] = voltage
            result["saturated"][k] = feedforward.get("saturated")
            result["displacement"][k] = plant(voltage)
    return result


def _plant_function(slave: Slave) -> Callable[[float], float]:
    ticks = iter(range(2**62))

    def run(voltage: float) -> float:
        slave.tick(next(ticks), {"voltage": voltage})
        return slave.get("displacement")

    return run
