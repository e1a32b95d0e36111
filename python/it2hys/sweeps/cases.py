"""From a scenario to a plan: FMUs at hand, every case's values drawn, everything checked."""

from __future__ import annotations

import hashlib
import json
import tempfile
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.model_description import ModelDescription

from it2hys.cosimulation.archive import unpack
from it2hys.cosimulation.slave import read_description
from it2hys.errors import InputError
from it2hys.fmu.controller import IDENTIFIER as CONTROLLER
from it2hys.fmu.controller import controller_fmu
from it2hys.fmu.model_description import IDENTIFIERS
from it2hys.fmu.packaging import package_bytes
from it2hys.model.parameters import read_ssv, table_1
from it2hys.records.signals import read_signals
from it2hys.records.units import UNITS
from it2hys.support.keys import known_names
from it2hys.support.version import package_version
from it2hys.sweeps.drawing import draw
from it2hys.sweeps.lookup import Lookup
from it2hys.sweeps.measures import KINDS
from it2hys.sweeps.plan import LARGEST_STEPS, Axis, Plan, Setup, by_owner, signal_values
from it2hys.sweeps.schema import CSV, CSV_NUMBERS, TABLE_1, Source, SweepScenario, Vary


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
    lookup = Lookup(scenario, descriptions, signals)
    setups = tuple(_setup(scenario, variant, lookup) for variant in scenario.variants)
    axes = tuple(_axis(vary, lookup) for vary in scenario.vary)
    matrix = draw(scenario)
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
    _check_times(plan)
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
                unpack(path, Path(directory, fmu.name))  # here, not in the first of many cases
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
                f"fmu.{name}: is the same FMU as fmu.{twin}, which can be instantiated only once per "
                "process"
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
    numbers = {key: source.arguments[key] for key in CSV_NUMBERS}
    series = {"time": signals.time - signals.time[0], "values": signals.values[column]}
    return Source.model_construct(name=source.name, signal=CSV, **numbers, **series)


def _setup(scenario: SweepScenario, variant: Any, lookup: Lookup) -> Setup:
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


def _axis(vary: Vary, lookup: Lookup) -> Axis:
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
    return Axis(vary.name, vary.targets, tuple(bases), unit, vary.method, vary.scale)


# --- checks of the whole -------------------------------------------------------------------------


def _check_times(plan: Plan) -> None:
    """Refuse a case that is longer than can be run, before any signal is made."""
    outputs = [*(m.of for m in plan.metrics), *(m.against for m in plan.metrics), *plan.keep]
    arrays = len({*plan.signals, *(name for name in outputs if name)})
    for cases, values in plan.timing():
        try:
            step, duration = np.broadcast_arrays(*plan.times(values))
        except (InputError, ZeroDivisionError) as error:
            raise InputError(f"duration: {error}") from None
        with np.errstate(all="ignore"):  # a step that is no number is told by the next check
            steps = np.atleast_1d(duration / step)
        if np.any(steps > LARGEST_STEPS):
            worst = int(np.argmax(steps))
            seconds, each = (float(np.atleast_1d(x)[worst]) for x in (duration, step))
            count, gigabytes = steps[worst], 8e-9 * steps[worst] * arrays
            need = f" need {gigabytes:.3g} GB of memory" if arrays else ""
            raise InputError(
                f"duration is {seconds:g} s (case {cases[worst]}): {count:.3g} steps of {each:g} s"
                f"{need}; at most {LARGEST_STEPS:,} can be run, so shorten duration or lengthen step"
            )


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
        times, owned = np.arange(min(count, 1000)) * step, by_owner(values)
        for name, source in plan.signals.items():
            try:
                signal_values(source, owned.get(name, {}), times, count * step)
            except (TypeError, ValueError, InputError) as error:
                raise InputError(f"signal.{name}: {error}") from None


def _check_figures(plan: Plan) -> None:
    numbers = [*(a.name for a in plan.axes), *(m.name for m in plan.metrics)]
    scalars = ["variant", *numbers]
    for number, figure in enumerate(plan.figures, start=1):
        traces = figure.kind in ("loops", "time course")
        known = {
            "x": plan.keep if figure.kind == "loops" else numbers,
            "y": plan.keep if figure.kind == "loops" else numbers,
            "value": plan.keep if traces else numbers,
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
        "times": [dict(plan.duration), dict(plan.lead_in), plan.step, plan.keep_every],
        "signals": [[s.name, s.signal, s.arguments] for s in plan.signals.values()],
        "setups": [asdict(s) for s in plan.setups],
        "axes": [[a.name, a.targets, a.bases, a.unit] for a in plan.axes],
        "metrics": [dict(m) for m in plan.metrics],
        "keep": plan.keep,
    }
    digest.update(json.dumps(parts, sort_keys=True, default=lambda x: np.asarray(x).tolist()).encode())
    digest.update(plan.matrix.tobytes())
    for name in sorted(plan.files):
        digest.update(name.encode() + hashlib.sha256(plan.files[name]).digest())
    fields = {f: getattr(plan, f) for f in plan.__dataclass_fields__ if f != "fingerprint"}
    return Plan(**fields, fingerprint=digest.hexdigest())
