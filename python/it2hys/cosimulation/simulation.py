"""Running FMUs over signals.

A row of a result belongs to one tick: the inputs at the tick's time and the outputs computed from
them. In co-simulation those outputs are read at the end of the step that begins at the tick.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from it2hys.cosimulation.slave import Slave
from it2hys.cosimulation.stepping import Connection, System
from it2hys.errors import InputError
from it2hys.support.keys import known_names
from it2hys.support.progress import Progress, silent

Values = Mapping[str, np.ndarray | float]
# ticks between two reports of progress
BLOCK = 10_000
INVERSE_CHAIN = (
    Connection("reference", "inverse.reference"),
    Connection("inverse.voltage", "plant.voltage"),
)


def sample_time(slave: Slave) -> float:
    """Return the sample time of an instance, s; raises InputError if it has none above 0."""
    step = slave.sample_time
    if step is None:
        raise InputError(f"{slave.path}: the FMU has no sampleTime to step at")
    if not step > 0.0:
        raise InputError(f"{slave.path}: sampleTime is {step:g}; it must be positive to step at")
    return step


def simulate(
    fmu: str | Path,
    inputs: Values,
    start_values: Mapping | None = None,
    progress: Progress = silent,
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
        Told the share done and what is being done.

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
            known = known_names(name, slave.names("input"))
            raise InputError(f"{slave.path}: the FMU has no input {name!r}; {known}")
        step = sample_time(slave)
        outputs = slave.names("output")
        system = System(
            {"fmu": slave},
            [Connection(name, f"fmu.{name}") for name in signals],
            [f"fmu.{name}" for name in outputs],
        )
        system.initialize({"fmu": start_values or {}}, {n: s[0] for n, s in signals.items() if ticks})
        blocks = []
        for k in range(0, ticks, BLOCK):
            progress(k / ticks, f"{slave.path.name}: {k} of {ticks} ticks")
            part = {n: s[k : k + BLOCK] for n, s in signals.items()}
            blocks.append(system.run(part, min(BLOCK, ticks - k), step))
        joined = {n: np.concatenate([b[f"fmu.{n}"] for b in blocks] or [np.empty(0)]) for n in outputs}
        return joined, slave.messages


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
    reference = np.asarray(reference, dtype=float)
    with ExitStack() as stack:
        feedforward = stack.enter_context(Slave(inverse, start_values))
        if callable(plant):
            inverse_alone = {"inverse": feedforward}
            result = _run_chain(inverse_alone, INVERSE_CHAIN[:1], reference, start_values)
            driven = np.array([plant(voltage) for voltage in result["inverse.voltage"].tolist()])
        else:
            slaves = {"inverse": feedforward, "plant": stack.enter_context(Slave(plant, start_values))}
            result = _run_chain(slaves, INVERSE_CHAIN, reference, start_values)
            driven = result["plant.displacement"]
    return {
        "voltage": result["inverse.voltage"],
        "displacement": driven,
        "saturated": result["inverse.saturated"],
    }


def _run_chain(
    slaves: Mapping[str, Slave],
    connections: Sequence[Connection],
    reference: np.ndarray,
    start_values: Mapping | None,
) -> dict[str, np.ndarray]:
    outputs = ["inverse.voltage", "inverse.saturated", "plant.displacement"]
    recorded = [name for name in outputs if name.partition(".")[0] in slaves]
    system = System(slaves, connections, recorded)
    first = {"reference": reference[0]} if len(reference) else {}
    system.initialize(dict.fromkeys(slaves, start_values or {}), first)
    step = sample_time(slaves["inverse"])
    return system.run({"reference": reference}, len(reference), step)
