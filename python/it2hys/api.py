"""The commands as functions for notebooks and scripts, on arrays and data frames.

The functions are imported from the package itself: ``from it2hys import simulate, track``. Signals are
in SI units (V, m, s, N, K) and named as the FMUs' variables. What comes in as a mapping of arrays comes
out as one, a data frame (polars or pandas) as a data frame of its kind.
"""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from it2hys import diagnosis, identification
from it2hys.cosimulation import simulation
from it2hys.cosimulation.slave import Slave
from it2hys.designs import designing
from it2hys.designs.hypotheses import question_of, question_of_set
from it2hys.designs.limits import Wanted
from it2hys.errors import InputError
from it2hys.fmu import packaging
from it2hys.fmu.own_library import only_used, use_effects
from it2hys.model.casadi_chain import casadi_chain
from it2hys.model.parameters import ParameterSet, read_ssv
from it2hys.records import Record, check_response, check_roles, read_record
from it2hys.results import (
    DesignedRecord,
    DiagnosedModel,
    IdentifiedModel,
    designed,
    diagnosed,
    identified,
)
from it2hys.support.progress import Progress, progress_bar

__all__ = [
    "DesignedRecord",
    "DiagnosedModel",
    "IdentifiedModel",
    "casadi_chain",
    "design",
    "diagnose",
    "identify",
    "package",
    "simulate",
    "sweep",
    "track",
]

#: A data frame of polars or pandas, or a mapping of columns.
Frame = Any
#: An FMU's path, or a parameter set that is packaged for the call.
Model = str | Path | ParameterSet


def identify(
    train: Frame | Sequence[Frame],
    validate: Sequence[Frame] = (),
    test: Sequence[Frame] = (),
    rules: int | None = None,
    seed: int = 0,
    invert_displacement: bool = False,
    solver: str = identification.SOLVERS[0],
    starts: int = 36,
    max_iterations: int = 600,
    progress: bool | Progress = False,
) -> IdentifiedModel:
    """Identify the paper's model from records.

    Parameters
    ----------
    train : record or sequence of records
        Records that are fitted. A record is a data frame or a mapping of arrays with units in its
        columns' names, such as ``time_s``, ``voltage_V`` and ``displacement_um``, or the path of such
        a CSV.
    validate, test : sequence of records, optional
        Records that decide on the number of rules, and records that are only reported on.
    rules : int, optional
        Number of rules; chosen on the validation records by default.
    seed : int
        Seed of the random starts.
    invert_displacement : bool
        Flip the sign of the displacement of all records: that of a sensor which counts the other way.
    solver : str
        Solver of the fits on whole records, one of `identification.SOLVERS`.
    starts, max_iterations : int
        Limits of the number of starts, and of the iterations of a fit on the whole records.
    progress : bool or callable
        Show a bar, or call this with the share done, 0 to 1, and what is being done.

    Returns
    -------
    IdentifiedModel
        `parameters` is the parameter set, `records` its errors on every record; `to_frame()` gives
        their errors as a data frame, `plot()` a loop.

    Raises
    ------
    InputError
        If a record or the model that it gives is not usable.

    Examples
    --------
    A record of a model with one rule, and the model back:

    >>> import numpy as np
    >>> from it2hys.model import compiled
    >>> from it2hys import identify
    >>> time = np.arange(600) * 1e-4
    >>> voltage = 50 - 50 * np.cos(2 * np.pi * 50 * time)
    >>> rules = np.array([[5e-6, 15e-6, 8e-6, 0.9, 1.5e-8, 1e-7]])
    >>> displacement = compiled.free_run(rules, voltage, 1e-6)
    >>> noise = 1e-9 * np.random.default_rng(0).standard_normal(len(time))
    >>> record = {"time_s": time, "voltage_V": voltage, "displacement_m": displacement + noise}
    >>> found = identify(record, rules=1)
    >>> bool(abs(found.parameters["rule[1].q1"] - 0.9) < 1e-3)
    True
    """
    records = _records(train, validate, test, invert_displacement)
    options = identification.Options(seed, starts, max_iterations, solver)
    with _shown(progress) as show:
        found = identification.identify(*records, rules, options, show)
    return identified(found, [record for role in records for record in role])


def diagnose(
    train: Frame | Sequence[Frame],
    validate: Sequence[Frame] = (),
    test: Sequence[Frame] = (),
    model: str | Path | ParameterSet | None = None,
    declared: Sequence[str] = (),
    rules: int = diagnosis.RULES,
    seed: int = 0,
    workers: int = 1,
    invert_displacement: bool = False,
    exclude: Sequence[str] = (),
    sensor_curve: bool = False,
    progress: bool | Progress = False,
    own_effects: Sequence[str | Path] | None = None,
) -> DiagnosedModel:
    """Find the effects that records contain and a model lacks, and add them to it.

    Parameters
    ----------
    train : record or sequence of records
        Records that are fitted, as for `identify`; they may have columns such as
        ``force_N`` and ``temperature_degC``.
    validate, test : sequence of records, optional
        Records that decide whether an effect is added, and records that are only reported on.
    model : ParameterSet or path of an SSV file, optional
        The model to start from; by default the paper's, identified on the training records.
    declared : sequence of str
        Effects that are in the model from the start.
    rules : int
        Number of rules of the model that is identified.
    seed : int
        Seed of the random starts.
    workers : int
        Processes that share the fits; a script that asks for several must do so under
        ``if __name__ == "__main__"``.
    invert_displacement : bool
        As for `identify`.
    exclude : sequence of str
        Effects that are kept out of the model.
    sensor_curve : bool
        Attribute a static curve that is found to the sensor: FMUs that `package` writes leave it out.
    progress : bool or callable
        As for `identify`.
    own_effects : sequence of path, optional
        Python files with effects of your own (`it2hys.OwnEffect`), which are run and tested as
        the built-in effects are. They stay in the chain for later calls, such as `package` of what was
        found, until other files are given; an empty sequence removes them.

    Returns
    -------
    DiagnosedModel
        `effects` names what was found, `parameters` is the set with it, `after` its errors on every
        record, `evidence` which effects were tried and why each was added or not; `to_frame()` gives
        the errors before and after as a data frame, `plot()` a loop.

    Raises
    ------
    InputError
        If a record or the given model is not usable, or an effect is not known.

    Examples
    --------
    A stage with one rule, loaded by a force that its model knows nothing of:

    >>> import numpy as np
    >>> from it2hys.model import compiled
    >>> from it2hys import diagnose
    >>> time = np.arange(800) * 1e-4
    >>> voltage = 50 - 50 * np.cos(2 * np.pi * 50 * time)
    >>> force = 10 - 10 * np.cos(2 * np.pi * 17 * time)
    >>> rules = np.array([[5e-6, 15e-6, 8e-6, 0.9, 1.5e-8, 1e-7]])
    >>> displacement = compiled.free_run(rules, voltage, 1e-6) - 2e-8 * force
    >>> noise = 5e-9 * np.random.default_rng(0).standard_normal(len(time))
    >>> record = {
    ...     "time_s": time,
    ...     "voltage_V": voltage,
    ...     "force_N": force,
    ...     "displacement_m": displacement + noise,
    ... }
    >>> found = diagnose(record, rules=1)
    >>> found.effects
    ('load',)
    >>> round(found.parameters["load.compliance"] * 1e9)
    20
    """
    _use(own_effects)
    records = _records(train, validate, test, invert_displacement)
    if isinstance(model, str | Path):
        model = read_ssv(model)
    with _shown(progress) as show:
        found = diagnosis.diagnose(
            *records,
            model,
            declared,
            rules,
            identification.Options(seed=seed),
            show,
            workers,
            exclude,
            sensor_curve,
        )
    return diagnosed(found, [record for role in records for record in role])


def design(
    source: str | Path | ParameterSet,
    between: Sequence[str] = (),
    noise: float | None = None,
    voltage: tuple[float, float] | None = None,
    slew_rate: float | None = None,
    bandwidth: float | None = None,
    current: float | None = None,
    capacitance: float | None = None,
    duration: float | None = None,
    periods: int = 1,
    band: tuple[float, float] | None = None,
    families: Sequence[str] = (),
    seed: int = 0,
    draws: int = 10,
    checked: int = 0,
    progress: bool | Progress = False,
) -> DesignedRecord:
    """Find the record to measure next: the voltage that decides most between models.

    Parameters
    ----------
    source : ParameterSet or path
        A parameter set or its SSV file, or the `report.json` of a diagnosis.
    between : sequence of str
        Effects to decide between; of a report by default those that its records cannot tell apart.
        Without any the parameters of the model's effects are to be determined.
    noise : float, optional
        Noise of the displacement, m rms; that of the report by default.
    voltage : tuple of float, optional
        Lowest and highest voltage, V; the model's range by default.
    slew_rate, bandwidth : float, optional
        Fastest change, V/s, and bandwidth of the amplifier, Hz.
    current, capacitance : float, optional
        Largest current of the amplifier, A, and capacitance of the actuator, F.
    duration : float, optional
        Duration of the record, s.
    periods : int
        Number of equal periods of the record, to average over.
    band : tuple of float, optional
        Band of the references that the model will be used for, Hz.
    families : sequence of str
        Families of voltages that may be played; all by default.
    seed : int
        Seed of the search; the same seed gives the same record.
    draws, checked : int
        Number of simulated records of every model that are refitted, and that are diagnosed.
    progress : bool or callable
        As for `identify`.

    Returns
    -------
    DesignedRecord
        `voltage` and `time` are what to play, `sentences` what it promises, `separations` the
        probability of telling each pair of models apart, `intervals` the 95 % intervals of the
        parameters after it; `to_frame()` gives the voltage as a data frame, `plot()` draws it.

    Raises
    ------
    InputError
        If there is nothing to decide, or the limits exclude each other.

    Examples
    --------
    Is it a delay, or a lag? Held steps of 80 ms tell:

    >>> from it2hys import design
    >>> from it2hys.model.parameters import table_1
    >>> found = design(
    ...     table_1(), ["delay", "lag"], noise=5e-9, duration=0.08, families=["steps"], draws=0
    ... )
    >>> found.decides
    True
    >>> float(found.voltage[0]), float(found.voltage[-1]), len(found.voltage)
    (0.0, 0.0, 800)
    """
    if isinstance(source, ParameterSet):
        question = question_of_set(source, between, noise)
    else:
        question = question_of(source, between, noise)
    wanted = Wanted(voltage, slew_rate, bandwidth, current, capacitance, None, duration, periods, band)
    with _shown(progress) as show:
        found = designing.design(
            question, wanted, families, seed, draws=draws, checked=checked, progress=show
        )
    return designed(found)


def package(
    parameters: str | Path | ParameterSet | identification.Fitted,
    directory: str | Path,
    ssp: bool = False,
    fmi: Collection[int] = (2, 3),
    own_effects: Sequence[str | Path] | None = None,
) -> list[Path]:
    """Write a parameter set as FMUs, and as SSP packages if asked for.

    Parameters
    ----------
    parameters : ParameterSet, result of `identify` or `diagnose`, or path
        A path is that of an SSV file.
    directory : path
        Created if it does not exist.
    ssp : bool
        Write the systems of inverse, plant and controller, too.
    fmi : collection of {2, 3}
        Versions of FMI; the FMUs of FMI 3.0 are named apart.
    own_effects : sequence of path, optional
        As for `diagnose`; where the set has such effects.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the set cannot be used or the directory not be written to.

    Examples
    --------
    >>> import tempfile
    >>> from it2hys import package
    >>> from it2hys.model.parameters import table_1
    >>> folder = tempfile.TemporaryDirectory()
    >>> [path.name for path in package(table_1(), folder.name)]
    ['IT2Plant.fmu', 'IT2Inverse.fmu', 'IT2Plant_fmi3.fmu', 'IT2Inverse_fmi3.fmu', 'parameters.ssv']
    >>> folder.cleanup()
    """
    _use(own_effects)
    if isinstance(parameters, identification.Fitted):
        parameters = parameters.packaged
    elif not isinstance(parameters, ParameterSet):
        parameters = read_ssv(parameters)
    parameters = ParameterSet(dict(parameters), parameters.name)  # with the effects there are now
    with only_used(parameters) as used:
        written = packaging.package(used, directory, fmi=fmi)
        if ssp:
            from it2hys.fmu.ssp import write_ssp

            written += write_ssp(used, directory, fmi)
    return written


def _use(own_effects: Sequence[str | Path] | None) -> None:
    if own_effects is not None:
        use_effects(own_effects)


def simulate(
    fmu: Model,
    inputs: Frame,
    start_values: Mapping | None = None,
    progress: bool | Progress = False,
) -> Frame:
    """Run an FMU over input signals, one tick per row.

    Parameters
    ----------
    fmu : path or ParameterSet
        The FMU; of a parameter set, the plant.
    inputs : mapping of str to ndarray, shape (N,), or data frame
        Inputs by name, sampled at the FMU's `sampleTime`; a column ``time`` is left alone.
    start_values : mapping, optional
        Parameters by name.
    progress : bool or callable
        As for `identify`.

    Returns
    -------
    mapping of str to ndarray, shape (N,), or data frame
        ``time`` in s and the outputs; row k belongs to tick k.

    Raises
    ------
    InputError
        If the FMU cannot be run or refuses a value.

    Examples
    --------
    >>> import numpy as np
    >>> import polars as pl
    >>> from it2hys import simulate
    >>> from it2hys.model.parameters import table_1
    >>> voltage = 52.5 - 52.5 * np.cos(2 * np.pi * 20 * np.arange(500) * 1e-4)
    >>> result = simulate(table_1(), pl.DataFrame({"voltage": voltage}))
    >>> result.columns
    ['time', 'displacement', 'measured', 'outOfRange']
    >>> round(result["displacement"].max() * 1e6, 1)
    15.5
    """
    signals = {name: values for name, values in _columns(inputs).items() if name != "time"}
    with _path(fmu, "IT2Plant") as path:
        with _shown(progress) as show:
            outputs, _ = simulation.simulate(path, signals, start_values, show)
        with Slave(path, start_values) as slave:
            step = simulation.sample_time(slave)
    time = np.arange(len(next(iter(signals.values()), ()))) * step
    return _like(inputs, {"time": time, **outputs})


def track(
    inverse: Model, plant: Model, reference: Frame | np.ndarray, start_values: Mapping | None = None
) -> Frame:
    """Run a reference through an inverse FMU and its voltage through a plant FMU, tick for tick.

    Parameters
    ----------
    inverse, plant : path or ParameterSet
        The FMUs. Two parameter sets that differ show what feedforward does to another plant.
    reference : ndarray, shape (N,), or data frame with a column ``reference``
        Desired displacement, m.
    start_values : mapping, optional
        Parameters of both FMUs; `initialDisplacement` is the first of the reference by default.

    Returns
    -------
    mapping of str to ndarray, shape (N,), or data frame
        ``time`` in s, ``reference`` and ``displacement`` in m, ``voltage`` in V, and ``saturated``.

    Raises
    ------
    InputError
        If an FMU cannot be run or refuses a value.

    Examples
    --------
    >>> import numpy as np
    >>> from it2hys import track
    >>> from it2hys.model.parameters import table_1
    >>> reference = 7.7e-6 - 7e-6 * np.cos(2 * np.pi * 20 * np.arange(1000) * 1e-4)
    >>> result = track(table_1(), table_1(), reference)
    >>> bool(np.abs(result["displacement"] - reference).max() < 1e-15)
    True
    """
    columns = {"reference": reference} if isinstance(reference, np.ndarray) else _columns(reference)
    if "reference" not in columns:
        raise InputError(f"no column 'reference'; there are {', '.join(columns)}")
    desired = np.asarray(columns["reference"], dtype=float)
    start = {"initialDisplacement": float(desired[0])} if len(desired) else {}
    start |= dict(start_values or {})
    with _path(inverse, "IT2Inverse") as first, _path(plant, "IT2Plant") as second:
        result = simulation.track(first, second, desired, start)
        with Slave(first, start) as slave:
            time = np.arange(len(desired)) * simulation.sample_time(slave)
    return _like(reference, {"time": time, "reference": desired, **result})


def sweep(
    scenario: str | Path | Mapping,
    directory: str | Path | None = None,
    workers: int = 0,
    dask: str | None = None,
    progress: bool | Progress = False,
) -> Frame:
    """Run all cases of a sweep scenario.

    Parameters
    ----------
    scenario : str, path or mapping
        Name or path of a scenario file, or its keys as a dictionary.
    directory : path, optional
        Where the table and its report are left; a run that was interrupted there is resumed. Without
        it nothing is left.
    workers : int
        Processes; with 0 the cases run in this one. A script that asks for more must do so under
        ``if __name__ == "__main__":``.
    dask : str, optional
        Address of a Dask scheduler, instead.
    progress : bool or callable
        As for `identify`.

    Returns
    -------
    polars.DataFrame
        A row for every case: what was varied, the metrics, the outputs that are kept, `status` and
        `message`.

    Raises
    ------
    InputError
        If the scenario, the directory or the cluster is not usable.

    Examples
    --------
    >>> from it2hys import sweep
    >>> table = sweep({
    ...     "duration": 0.05,
    ...     "fmu": {"plant": {"source": "IT2Plant"}},
    ...     "signal": {"voltage": {"signal": "sine", "frequency": 20.0}},
    ...     "connections": [{"from": "voltage", "to": "plant.voltage"}],
    ...     "vary": [{"name": "amplitude", "of": "voltage.high", "values": [30, 60, 90]}],
    ...     "metric": [{"name": "travel", "kind": "range", "of": "plant.displacement"}],
    ... })
    >>> (table["travel"] * 1e6).round(1).to_list()
    [4.9, 10.1, 13.8]
    """
    import polars as pl

    from it2hys.experiments.scenario_files import find_scenario
    from it2hys.sweeps import parse_sweep, read_sweep, run_sweep

    if isinstance(scenario, Mapping):
        parsed = parse_sweep(scenario)
    else:
        path = Path(scenario)
        parsed = read_sweep(path if path.suffix == ".toml" else find_scenario(str(scenario)))
    with tempfile.TemporaryDirectory(prefix="it2hys-") as folder:
        with _shown(progress) as show:
            outcome = run_sweep(parsed, directory or folder, workers, dask, progress=show)
        return pl.read_parquet(outcome.results)


# --- what goes in and out ------------------------------------------------------------------------


def _shown(progress: bool | Progress) -> AbstractContextManager[Progress]:
    """Return a bar as notebooks show it, the caller's own progress, or none."""
    if isinstance(progress, bool):
        return progress_bar(quiet=not progress, kind="bar")
    return nullcontext(progress)


def _columns(frame: Frame) -> dict[str, np.ndarray]:
    """Return the columns of a data frame or of a mapping."""
    names = frame.columns if hasattr(frame, "columns") else frame
    return {str(name): np.asarray(frame[name]) for name in names}


def _like(given: Frame, columns: dict[str, np.ndarray]) -> Frame:
    """Return columns as a data frame of the kind that was given, or as they are."""
    return type(given)(columns) if hasattr(given, "columns") else columns


@contextmanager
def _path(model: Model, identifier: str) -> Iterator[Path]:
    if not isinstance(model, ParameterSet):
        yield Path(model)
        return
    with tempfile.TemporaryDirectory(prefix="it2hys-") as folder:
        path = Path(folder, f"{identifier}.fmu")
        path.write_bytes(packaging.package_bytes(model)[identifier])
        yield path


def _records(
    train: Frame | Sequence[Frame],
    validate: Sequence[Frame],
    test: Sequence[Frame],
    invert_displacement: bool,
) -> tuple[list[Record], list[Record], list[Record]]:
    """Return training, validation and test records."""
    single = isinstance(train, str | Path | Record | Mapping) or hasattr(train, "columns")
    roles = ([train] if single else train, validate, test)
    with tempfile.TemporaryDirectory(prefix="it2hys-") as folder:
        fitted, deciding, tested = (
            [
                _record(item, f"{role}_{i}", Path(folder), invert_displacement)
                for i, item in enumerate(items, start=1)
            ]
            for role, items in zip(("train", "validate", "test"), roles, strict=True)
        )
    check_roles(fitted, deciding, tested)
    return fitted, deciding, tested


def _record(item: Frame, name: str, folder: Path, invert_displacement: bool) -> Record:
    """Return a record; a frame is held to the rules of a CSV file by being made one."""
    if isinstance(item, Record):
        record = item.invert() if invert_displacement else item
        check_response(record)
        return record
    if isinstance(item, str | Path):
        return read_record(Path(item), invert_displacement=invert_displacement)
    columns = _columns(item)
    table = np.column_stack(list(columns.values()))
    lines = [",".join(columns), *(",".join(map(repr, row)) for row in table.tolist())]
    path = folder / f"{name}.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    try:
        return read_record(path, invert_displacement=invert_displacement)
    except InputError as error:
        raise InputError(str(error).replace(str(path), name)) from None
