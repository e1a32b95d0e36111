"""From a scenario to a plan: FMUs at hand, every case's values drawn, everything checked.

A plan is what a worker needs, all of it: it is pickled once for every worker, on this machine or
another. The values of all cases are drawn here, from the seed alone, so that no result depends on who
runs which case.
"""

from __future__ import annotations

import hashlib
import inspect
import json
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from fmpy.model_description import ModelDescription, ScalarVariable

from it2hys import excitations
from it2hys.controller import IDENTIFIER as CONTROLLER
from it2hys.controller import controller_fmu
from it2hys.errors import InputError
from it2hys.keys import known_names
from it2hys.model_description import IDENTIFIERS
from it2hys.packaging import package_bytes, package_version
from it2hys.parameters import read_ssv, table_1
from it2hys.records.units import UNITS
from it2hys.signals import read_signals
from it2hys.slave import BASE, read_description
from it2hys.stepping import Connection
from it2hys.sweeps.metrics import KINDS
from it2hys.sweeps.schema import CSV, TABLE_1, FigureEntry, Metric, Source, Span, SweepScenario, Vary

#: Ticks and cases of a chunk, the unit of work and of what is lost by an interruption.
CHUNK_TICKS, CHUNK_CASES = 1_000_000, 100
#: Targets that are no variable and no argument.
OWN = ("step", "duration")


@dataclass(frozen=True)
class Axis:
    """A column of what is varied, and the targets that it sets; `base` is multiplied by factors."""

    name: str
    targets: tuple[str, ...]
    bases: tuple[float, ...]
    unit: str


@dataclass(frozen=True)
class Setup:
    """A variant ready to run: FMUs in their order, connections, values by target."""

    name: str
    fmus: tuple[str, ...]
    connections: tuple[Connection, ...]
    values: Mapping[str, Any]


@dataclass(frozen=True)
class Plan:
    """All cases of a sweep.

    Attributes
    ----------
    files : dict of str to bytes
        FMU by name.
    signals : dict of str to Source
        A CSV signal has its time in s and values instead of the file's name.
    setups : tuple of Setup
        Variants.
    axes : tuple of Axis
        Columns of `matrix`.
    matrix : ndarray, shape (cases, axes)
        Value of every axis in every case.
    variant : ndarray of int, shape (cases,)
        Index into `setups`.
    alone : bool
        Whether an FMU can be instantiated only once in a process.
    """

    name: str
    title: str
    text: str
    duration: Span
    step: float
    lead_in: Span
    files: Mapping[str, bytes]
    signals: Mapping[str, Source]
    setups: tuple[Setup, ...]
    axes: tuple[Axis, ...]
    matrix: np.ndarray
    variant: np.ndarray
    metrics: tuple[Metric, ...]
    metric_units: tuple[str, ...]
    keep: tuple[str, ...]
    keep_units: tuple[str, ...]
    keep_every: int
    figures: tuple[FigureEntry, ...]
    alone: bool = False
    fingerprint: str = ""

    @property
    def cases(self) -> int:
        """Number of cases."""
        return len(self.matrix)

    def values(self, case: int) -> dict[str, float]:
        """Return what a case sets, by target."""
        values = dict(self.setups[self.variant[case]].values)
        for axis, value in zip(self.axes, self.matrix[case].tolist(), strict=True):
            for target, base in zip(axis.targets, axis.bases, strict=True):
                values[target] = value * base
        return values

    def seconds(self, span: Span, values: Mapping[str, float]) -> float:
        """Return a time in s, for the values of a case."""
        if not span.of:
            return span.seconds
        frequency = values.get(f"{span.of}.frequency")
        if frequency is None:
            frequency = argument(self.signals[span.of], "frequency")
        return span.periods / frequency

    def steps(self, values: Mapping[str, float]) -> tuple[float, int, int]:
        """Return communication step in s, number of steps, and how many metrics leave out."""
        step = values.get("step", self.step)
        duration = values.get("duration") or self.seconds(self.duration, values)
        count = len(excitations.time_grid(duration, step))
        return step, count, round(self.seconds(self.lead_in, values) / step)

    def chunks(self) -> list[range]:
        """Return the cases in runs of similar work, the same whoever works."""
        work = np.array([self.steps(self.values(case))[1] for case in range(self.cases)])
        chunks, first, ticks = [], 0, 0
        for case in range(self.cases):
            if case > first and (ticks + work[case] > CHUNK_TICKS or case - first >= CHUNK_CASES):
                chunks.append(range(first, case))
                first, ticks = case, 0
            ticks += work[case]
        return [*chunks, range(first, self.cases)]

    def slave_values(self, fmu: str, values: Mapping[str, float]) -> dict[str, float]:
        """Return what is set of one FMU in a case, by variable."""
        return {t.partition(".")[2]: v for t, v in values.items() if t.partition(".")[0] == fmu}


def argument(source: Source, name: str) -> Any:
    """Return an argument of a signal, given or by default; raises InputError if it has none."""
    if name in source.arguments:
        return source.arguments[name]
    if source.signal != CSV:
        parameter = inspect.signature(excitations.SIGNALS[source.signal]).parameters.get(name)
        if parameter is not None and parameter.default is not inspect.Parameter.empty:
            return parameter.default
    raise InputError(f"signal.{source.name}: {source.signal!r} is given no {name}")


def signal_values(
    source: Source, values: Mapping[str, float], times: np.ndarray, duration: float
) -> np.ndarray:
    """Return a signal at some times for the values of a case.

    A CSV signal is interpolated linearly and held beyond its ends; a chirp lasts as long as the run
    unless it says otherwise.
    """
    if source.signal == CSV:
        return np.interp(times, source.arguments["time"], source.arguments["values"])
    function = excitations.SIGNALS[source.signal]
    arguments = dict(source.arguments)
    for target, value in values.items():
        name, _, key = target.partition(".")
        if name == source.name:
            arguments[key] = int(value) if key == "seed" else value
    if "duration" in inspect.signature(function).parameters:
        arguments.setdefault("duration", duration)
    return function(times, **arguments)


# --- making a plan -------------------------------------------------------------------------------


def make_plan(scenario: SweepScenario) -> Plan:
    """Package or read the FMUs, draw the cases, check everything.

    Raises
    ------
    InputError
        If a file cannot be read, an FMU is of another kind, a variable or an argument does not exist
        or cannot be set so, a value is out of range, or a signal cannot be made.
    """
    files = _fmu_files(scenario)
    descriptions = _describe(scenario, files)
    signals = {s.name: _load(s, scenario.folder) for s in scenario.signals}
    lookup = _Lookup(scenario, descriptions, signals)
    setups = tuple(_setup(scenario, variant, lookup) for variant in scenario.variants)
    axes = tuple(_axis(vary, lookup) for vary in scenario.vary)
    matrix = _draw(scenario)
    variant = np.repeat(np.arange(len(setups)), len(matrix))
    for metric in scenario.metrics:
        lookup.check_output(f"metric {metric.name!r}: of", metric.of, setups)
        if metric.against:
            lookup.check_output(f"metric {metric.name!r}: against", metric.against, setups)
    for name in scenario.keep:
        lookup.check_output("keep", name, setups)
    plan = Plan(
        name=scenario.name, title=scenario.title, text=scenario.text,
        duration=scenario.duration, step=scenario.step, lead_in=scenario.lead_in,
        files=files, signals=signals, setups=setups, axes=axes,
        matrix=np.tile(matrix, (len(setups), 1)), variant=variant,
        metrics=scenario.metrics,
        metric_units=tuple(
            lookup.unit(m.of) if KINDS[m.kind].unit == "same" else KINDS[m.kind].unit
            for m in scenario.metrics
        ),
        keep=scenario.keep, keep_units=tuple(lookup.unit(name) for name in scenario.keep),
        keep_every=scenario.keep_every, figures=scenario.figures,
        alone=_check_instances(files, descriptions),
    )  # fmt: skip
    _check_signals(plan)
    _check_figures(plan)
    return _with_fingerprint(plan)


def _fmu_files(scenario: SweepScenario) -> dict[str, bytes]:
    """Return every FMU as bytes: ours packaged with their parameter set, others as they are."""
    packaged: dict[str, dict[str, bytes]] = {}
    files = {}
    for fmu in scenario.fmus:
        if fmu.source == CONTROLLER:
            files[fmu.name] = controller_fmu()
        elif fmu.source in IDENTIFIERS.values():
            if fmu.parameters not in packaged:
                packaged[fmu.parameters] = _package(fmu.name, fmu.parameters, scenario.folder)
            files[fmu.name] = packaged[fmu.parameters][fmu.source]
        else:
            path = scenario.folder / fmu.source
            try:
                files[fmu.name] = path.read_bytes()
            except OSError:
                ours = ", ".join([*IDENTIFIERS.values(), CONTROLLER])
                raise InputError(
                    f"fmu.{fmu.name}: source: {path}: no such file; give a path or one of {ours}"
                ) from None
    return files


def _package(name: str, parameters: str, folder: Path) -> dict[str, bytes]:
    try:
        chosen = table_1() if parameters == TABLE_1 else read_ssv(folder / parameters)
    except InputError as error:
        raise InputError(f"fmu.{name}: parameters: {error}") from None
    return package_bytes(chosen)


def _describe(scenario: SweepScenario, files: Mapping[str, bytes]) -> dict[str, ModelDescription]:
    descriptions = {}
    with tempfile.TemporaryDirectory(prefix="it2hys-") as directory:
        for fmu in scenario.fmus:
            path = Path(directory, f"{fmu.name}.fmu")
            path.write_bytes(files[fmu.name])
            try:
                descriptions[fmu.name] = read_description(path)
            except InputError as error:
                text = str(error).removeprefix(f"{path}: ")
                raise InputError(f"fmu.{fmu.name}: {fmu.source}: {text}") from None
    return descriptions


def _check_instances(files: Mapping[str, bytes], descriptions: Mapping[str, ModelDescription]) -> bool:
    """Tell whether an FMU can be instantiated once in a process only; refuse it if it is used twice."""
    single = [
        name for name, d in descriptions.items() if d.coSimulation.canBeInstantiatedOnlyOncePerProcess
    ]
    for name in single:
        twin = next((n for n in files if n != name and files[n] == files[name]), None)
        if twin:
            raise InputError(
                f"fmu.{name}: is the same as fmu.{twin}, and can be instantiated only once per process"
            )
    return bool(single)


def _load(source: Source, folder: Path) -> Source:
    """Read a CSV signal's file."""
    if source.signal != CSV:
        return source
    column = source.arguments["column"]
    if column not in UNITS or column == "time":
        known = known_names(column, [q for q in UNITS if q != "time"])
        raise InputError(f"signal.{source.name}: column is {column!r}; {known}")
    try:
        signals = read_signals(folder / source.arguments["file"], [column])
    except InputError as error:
        raise InputError(f"signal.{source.name}: file: {error}") from None
    time = signals.time - signals.time[0]
    return Source(source.name, CSV, {"time": time, "values": signals.values[column]})


class _Lookup:
    """Finds what targets and outputs name, and says which name is wrong."""

    def __init__(
        self,
        scenario: SweepScenario,
        descriptions: Mapping[str, ModelDescription],
        signals: Mapping[str, Source],
    ) -> None:
        self.scenario, self.signals = scenario, signals
        self.variables = {
            fmu: {v.name: v for v in description.modelVariables}
            for fmu, description in descriptions.items()
        }
        self.starts = {fmu.name: fmu.start for fmu in scenario.fmus}

    def variable(self, place: str, name: str) -> ScalarVariable:
        """Return a variable named ``fmu.variable``."""
        fmu, _, variable = name.partition(".")
        if fmu not in self.variables:
            known = known_names(fmu, [*self.variables, *self.signals])
            raise InputError(f"{place}: there is no FMU or signal {fmu!r}; {known}")
        if variable not in self.variables[fmu]:
            inputs = [n for n, v in self.variables[fmu].items() if v.causality != "output"]
            known = known_names(variable, inputs if len(inputs) < 40 else inputs[:40])
            raise InputError(f"{place}: the FMU {fmu!r} has no variable {variable!r}; {known}")
        return self.variables[fmu][variable]

    def check_output(self, place: str, name: str, setups: Sequence[Setup]) -> None:
        """Check a signal's name, or an output that every variant has."""
        if "." not in name:
            if name not in self.signals:
                known = known_names(name, list(self.signals))
                raise InputError(f"{place}: there is no signal {name!r}; {known}; outputs are FMU.name")
            return
        if self.variable(place, name).type == "String":
            raise InputError(f"{place}: {name} is a String; only numbers can be recorded")
        for setup in setups:
            if name.partition(".")[0] not in setup.fmus:
                raise InputError(
                    f"{place}: {name} does not exist in the variant {setup.name!r}, "
                    "whose connections leave that FMU out"
                )

    def unit(self, name: str) -> str:
        """Return the SI unit of an output; of a signal, that of the input it goes to."""
        if "." in name:
            variable = self.variable("unit", name)
            return (
                variable.unit or (variable.declaredType.unit if variable.declaredType else None) or "1"
            )
        targets = [c.target for v in self.scenario.variants for c in v.connections if c.source == name]
        return self.unit(targets[0]) if targets else "1"

    def target_unit(self, target: str) -> str:
        """Return the unit of what is varied."""
        name, _, key = target.partition(".")
        if name not in self.signals:
            return "s" if target in OWN else self.unit(target)
        if "frequency" in key:
            return "Hz"
        if key in ("low", "high"):
            return self.unit(name)
        return "s" if key in ("hold", "time_constant", "duration") else "1"

    def check_target(self, place: str, target: str, values: Sequence[float]) -> float:
        """Check that a target exists and takes some values; return what it is without them."""
        name, _, key = target.partition(".")
        if target in OWN:
            self._check_range(place, target, values, (np.nextafter(0.0, 1.0), None))
            span = self.scenario.duration.seconds
            return self.scenario.step if target == "step" else span
        if name in self.signals:
            base = argument_of_kind(place, self.signals[name], key)
            return base
        variable = self.variable(place, target)
        if variable.causality not in ("parameter", "input") or variable.variability == "constant":
            raise InputError(f"{place}: {target} is {variable.causality}; it cannot be set")
        if BASE.get(variable.type, variable.type) == "String":
            raise InputError(f"{place}: {target} is a String; only numbers can be set")
        self._check_range(place, target, values, _bounds(variable))
        start = self.starts[name].get(key, variable.start)
        return float(start == "true") if start in ("true", "false") else float(start or 0.0)

    @staticmethod
    def _check_range(place: str, target: str, values: Sequence[float], bounds: tuple) -> None:
        low, high = bounds
        for value in values:
            if isinstance(value, bool):
                continue
            if not isinstance(value, int | float) or not np.isfinite(value):
                raise InputError(f"{place}: {target} is {value!r}; it must be a finite number")
            if (low is not None and value < low) or (high is not None and value > high):
                text = (
                    f"{'-∞' if low is None else f'{low:g}'} to {'∞' if high is None else f'{high:g}'}"
                )
                raise InputError(f"{place}: {target} is {value:g}; it must be {text}")


def argument_of_kind(place: str, source: Source, key: str) -> float:
    """Return the value of a signal's argument that is a number, NaN where it is not given."""
    if source.signal == CSV:
        raise InputError(
            f"{place}: the signal {source.name!r} is from a CSV and has no argument {key!r}"
        )
    known = list(inspect.signature(excitations.SIGNALS[source.signal]).parameters)[1:]
    if key not in known:
        raise InputError(
            f"{place}: the signal {source.name!r} ({source.signal}) has no argument {key!r}; "
            f"{known_names(key, known)}"
        )
    try:
        value = argument(source, key)
    except InputError:
        return float("nan")
    return float(value) if isinstance(value, int | float) else float("nan")


def _bounds(variable: ScalarVariable) -> tuple[float | None, float | None]:
    def number(name: str) -> float | None:
        for holder in (variable, variable.declaredType):
            text = getattr(holder, name, None)
            if text is not None:
                return float(text)
        return None

    return number("min"), number("max")


def _setup(scenario: SweepScenario, variant: Any, lookup: _Lookup) -> Setup:
    """Return a variant with the values that FMUs start from; FMUs that no connection names stay out."""
    label = f"variant {variant.name!r}: set" if variant.name else "set"
    values = {}
    for fmu in scenario.fmus:
        for key, value in fmu.start.items():
            lookup.check_target(f"fmu.{fmu.name}: start", f"{fmu.name}.{key}", [value])
            values[f"{fmu.name}.{key}"] = value
    for target, value in variant.values.items():
        lookup.check_target(label, target, [value])
        values[target] = value
    place = f"variant {variant.name!r}: connections" if variant.name else "connections"
    named = set()
    for connection in variant.connections:
        for name in (connection.source, connection.target):
            if "." in name:
                lookup.variable(place, name)
                named.add(name.partition(".")[0])
        if lookup.variable(place, connection.target).causality != "input":
            raise InputError(f"{place}: {connection.target} is no input")
    targets = [c.target for c in variant.connections]
    for target in targets:
        if targets.count(target) > 1:
            raise InputError(f"{place}: the input {target} is connected twice")
    fmus = tuple(f.name for f in scenario.fmus if f.name in named or len(scenario.fmus) == 1)
    return Setup(variant.name, fmus, variant.connections, values)


def _axis(vary: Vary, lookup: _Lookup) -> Axis:
    known = vary.values or vary.range or vary.normal[:1]
    bases = []
    for target in vary.targets:
        place = f"{vary.place}of"
        base = lookup.check_target(place, target, ())
        if vary.factor and not np.isfinite(base):
            raise InputError(f"{place}: {target} has no value yet that a factor could multiply")
        bases.append(base if vary.factor else 1.0)
        lookup.check_target(vary.place.rstrip(": "), target, [v * bases[-1] for v in known])
        for variant in lookup.scenario.variants:
            if target in variant.values:
                raise InputError(f"{place}: {target} is set by the variant {variant.name!r}, too")
    unit = vary.unit or ("1" if vary.factor else lookup.target_unit(vary.targets[0]))
    return Axis(vary.name, vary.targets, tuple(bases), unit)


# --- drawing the cases ---------------------------------------------------------------------------


def _draw(scenario: SweepScenario) -> np.ndarray:
    """Return the value of every axis in every case of one variant, shape (cases, axes).

    Grid axes are crossed with each other, with the rows of the list axes, and with the samples; the
    last varies fastest.
    """
    groups = {m: [i for i, v in enumerate(scenario.vary) if v.method == m] for m in
              ("grid", "list", "random", "latin hypercube")}  # fmt: skip
    blocks: list[tuple[list[int], np.ndarray]] = []
    for i in groups["grid"]:
        blocks.append(([i], _grid(scenario.vary[i])[:, None]))
    if groups["list"]:
        columns = [_grid(scenario.vary[i]) for i in groups["list"]]
        lengths = {len(c) for c in columns}
        if len(lengths) > 1:
            raise InputError(
                f"vary: lists that go together have {sorted(lengths)} values; they must have as many"
            )
        blocks.append((groups["list"], np.column_stack(columns)))
    drawn = [*groups["random"], *groups["latin hypercube"]]
    if drawn:
        blocks.append((drawn, _samples(scenario, groups)))
    rows = list(product(*(range(len(b)) for _, b in blocks)))
    matrix = np.empty((len(rows), len(scenario.vary)))
    for (places, block), picks in zip(blocks, zip(*rows, strict=True), strict=True):
        matrix[:, places] = block[list(picks)]
    return matrix


def _grid(vary: Vary) -> np.ndarray:
    if vary.values:
        return np.array(vary.values)
    space = np.geomspace if vary.scale == "log" else np.linspace
    return space(*vary.range, vary.count)


def _samples(scenario: SweepScenario, groups: Mapping[str, list[int]]) -> np.ndarray:
    """Return samples of the drawn axes, the random ones before the Latin hypercube's."""
    count, columns = scenario.samples, []
    for i in groups["random"]:
        # every axis has a stream of its own: another axis does not change its draws
        name = int.from_bytes(hashlib.sha256(scenario.vary[i].name.encode()).digest()[:8])
        uniform = np.random.default_rng([scenario.seed, name]).random(count)
        columns.append(_quantile(scenario.vary[i], uniform))
    hypercube = groups["latin hypercube"]
    if hypercube:
        sampler = scipy.stats.qmc.LatinHypercube(
            len(hypercube), rng=np.random.default_rng(scenario.seed)
        )
        for i, uniform in zip(hypercube, sampler.random(count).T, strict=True):
            columns.append(_quantile(scenario.vary[i], uniform))
    return np.column_stack(columns)


def _quantile(vary: Vary, uniform: np.ndarray) -> np.ndarray:
    if vary.values:
        index = np.minimum((uniform * len(vary.values)).astype(int), len(vary.values) - 1)
        return np.array(vary.values)[index]
    if vary.normal:
        return vary.normal[0] + vary.normal[1] * scipy.special.ndtri(np.clip(uniform, 1e-12, 1 - 1e-12))
    low, high = vary.range
    return low * (high / low) ** uniform if vary.scale == "log" else low + (high - low) * uniform


# --- checks of the whole -------------------------------------------------------------------------


def _check_signals(plan: Plan) -> None:
    """Make every signal at the ends of every axis, and see that metrics have samples left."""
    ends = {0}
    for column in plan.matrix.T:
        ends |= {int(column.argmin()), int(column.argmax())}
    per_variant = plan.cases // len(plan.setups)
    for case in sorted(
        {e % per_variant + i * per_variant for e in ends for i in range(len(plan.setups))}
    ):
        values = plan.values(case)
        try:
            step, count, skipped = plan.steps(values)
        except (InputError, ZeroDivisionError) as error:
            raise InputError(f"duration: {error}") from None
        if skipped >= count:
            raise InputError(f"lead_in: leaves nothing of the {count} steps of case {case}")
        times = np.arange(min(count, 1000)) * step
        for name, source in plan.signals.items():
            try:
                signal_values(source, values, times, count * step)
            except (TypeError, ValueError, InputError) as error:
                raise InputError(f"signal.{name}: {error}") from None


def _check_figures(plan: Plan) -> None:
    scalars = ["variant", *(a.name for a in plan.axes), *(m.name for m in plan.metrics)]
    for number, figure in enumerate(plan.figures, start=1):
        traces = figure.kind in ("loops", "time course")
        known = {
            "x": plan.keep if figure.kind == "loops" else scalars,
            "y": plan.keep if figure.kind == "loops" else scalars,
            "value": plan.keep if traces else scalars,
            "by": scalars,
        }
        for key, names in known.items():
            name = getattr(figure, key)
            if name and name not in names:
                raise InputError(f"figure {number}: {key} is {name!r}; {known_names(name, names)}")
        for name in figure.select:
            if name not in scalars:
                known = known_names(name, scalars)
                raise InputError(f"figure {number}: select: there is no column {name!r}; {known}")


def _with_fingerprint(plan: Plan) -> Plan:
    """Return the plan with a hash of all that its table depends on; texts and figures are not."""
    digest = hashlib.sha256(package_version().encode())
    parts = {
        "times": [asdict(plan.duration), asdict(plan.lead_in), plan.step, plan.keep_every],
        "signals": [[s.name, s.signal, s.arguments] for s in plan.signals.values()],
        "setups": [asdict(s) for s in plan.setups],
        "axes": [asdict(a) for a in plan.axes],
        "metrics": [asdict(m) for m in plan.metrics],
        "keep": plan.keep,
    }
    digest.update(json.dumps(parts, sort_keys=True, default=lambda x: np.asarray(x).tolist()).encode())
    digest.update(plan.matrix.tobytes())
    for name in sorted(plan.files):
        digest.update(name.encode() + hashlib.sha256(plan.files[name]).digest())
    fields = {f: getattr(plan, f) for f in plan.__dataclass_fields__ if f != "fingerprint"}
    return Plan(**fields, fingerprint=digest.hexdigest())
