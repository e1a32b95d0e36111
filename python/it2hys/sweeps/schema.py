"""Sweep scenarios: TOML files that say which FMUs run, on what signals, varied how, judged by what.

`scenarios/README.md` describes every key. Reading checks everything that can be known without the
FMUs; `it2hys.sweeps.cases` checks the rest against them, before any case runs.
"""

from __future__ import annotations

import inspect
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from it2hys.cosimulation.stepping import Connection
from it2hys.errors import InputError
from it2hys.stand import excitations
from it2hys.support.keys import Keys, known_names, read_toml
from it2hys.sweeps.measures import KINDS

DRAWN = ("random", "latin hypercube")
METHODS = ("grid", "list", *DRAWN)
SCALES = ("linear", "log")
FIGURES = ("heat map", "lines", "loops", "time course", "distribution")
#: Columns of a table that are no parameter and no metric.
RESERVED = ("case", "variant", "status", "message")
CSV = "csv"
#: Arguments of a CSV signal that are numbers, and what they are by default.
CSV_NUMBERS = {"factor": 1.0, "offset": 0.0, "time_factor": 1.0}
#: A normal distribution has 95 % within so many standard deviations.
NORMAL_95 = 1.959964
TABLE_1 = "table 1"


@dataclass(frozen=True)
class Fmu:
    """An FMU of a scenario: one of ours by its name, or a file; and its start values."""

    name: str
    source: str
    parameters: str
    start: Mapping[str, Any]


@dataclass(frozen=True)
class Source:
    """A signal: a function of `stand.excitations` and its arguments, or a column of a CSV file."""

    name: str
    signal: str
    arguments: Mapping[str, Any]

    @property
    def clock(self) -> str:
        """The argument that says how long a period is."""
        return "time_factor" if self.signal == CSV else "frequency"


@dataclass(frozen=True)
class Span:
    """A time in s, or in periods of a signal: of its frequency, or the length of a CSV."""

    seconds: float = 0.0
    periods: float = 0.0
    of: str = ""


@dataclass(frozen=True)
class Vary:
    """What is varied: targets, the column that says how, and where values come from."""

    place: str
    name: str
    targets: tuple[str, ...]
    method: str = "grid"
    values: tuple[float, ...] = ()
    range: tuple[float, float] | None = None
    normal: tuple[float, float] | None = None
    count: int = 0
    scale: str = "linear"
    factor: bool = False
    unit: str = ""


@dataclass(frozen=True)
class Variant:
    """One of several set-ups that are compared: other connections, other values."""

    name: str
    connections: tuple[Connection, ...]
    values: Mapping[str, Any]


@dataclass(frozen=True)
class Metric:
    """A number that judges a case."""

    name: str
    kind: str
    of: str
    against: str = ""


@dataclass(frozen=True)
class FigureEntry:
    """A figure of the report, drawn from columns of the table."""

    kind: str
    title: str = ""
    x: str = ""
    y: str = ""
    value: str = ""
    by: str = ""
    x_scale: str = "linear"
    y_scale: str = "linear"
    select: Mapping[str, float | str] = field(default_factory=dict)


@dataclass(frozen=True)
class SweepScenario:
    """A checked scenario; `folder` is where its relative paths begin."""

    name: str
    folder: Path
    title: str
    text: str
    seed: int
    samples: int
    duration: Span
    step: float
    lead_in: Span
    fmus: tuple[Fmu, ...]
    signals: tuple[Source, ...]
    variants: tuple[Variant, ...]
    vary: tuple[Vary, ...]
    metrics: tuple[Metric, ...]
    keep: tuple[str, ...]
    keep_every: int
    figures: tuple[FigureEntry, ...]


def is_sweep(table: Mapping) -> bool:
    """Tell whether a scenario's TOML is a sweep: it names FMUs."""
    return "fmu" in table


def read_sweep(path: Path) -> SweepScenario:
    """Read and check a scenario file.

    Raises
    ------
    InputError
        If the file is missing, is not TOML, or has a key that is unknown, missing or unusable. The
        message names the file and the key.
    """
    table = read_toml(path)
    try:
        if not is_sweep(table):
            raise InputError("no [fmu.NAME]: not a sweep; `it2hys run` runs experiments on the stand")
        return parse_sweep(table, path.stem, path.parent)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def parse_sweep(table: Mapping, name: str = "sweep", folder: Path = Path(".")) -> SweepScenario:
    """Check a scenario given as a dictionary with the keys of a scenario file."""
    entry = Keys("", table)
    parameters = entry.take("parameters", str, TABLE_1)
    scenario = SweepScenario(
        name=name,
        folder=folder,
        title=entry.take("title", str, name),
        text=entry.take("text", str, ""),
        seed=entry.take("seed", int, 0),
        samples=entry.take("samples", int, 100),
        duration=_span("duration", entry.take("duration", float | dict)),
        step=entry.take("step", float, 1e-4),
        lead_in=_span("lead_in", entry.take("lead_in", float | dict, 0.0)),
        fmus=tuple(_fmu(n, t, parameters) for n, t in entry.take("fmu", dict).items()),
        signals=tuple(_source(n, t) for n, t in entry.take("signal", dict, {}).items()),
        variants=(Variant("", _connections("", entry.take("connections", list, [])), {}),),
        vary=tuple(
            v for i, t in enumerate(entry.take("vary", list, []), start=1) for v in _vary(i, t, folder)
        ),
        metrics=tuple(_metric(i, t) for i, t in enumerate(entry.take("metric", list, []), start=1)),
        keep=tuple(_texts("keep", entry.take("keep", list, []))),
        keep_every=entry.take("keep_every", int, 1),
        figures=tuple(_figure(i, t) for i, t in enumerate(entry.take("figure", list, []), start=1)),
    )
    variants = [
        _variant(i, t, scenario.variants[0].connections)
        for i, t in enumerate(entry.take("variant", list, []), start=1)
    ]
    entry.done()
    scenario = replace(scenario, variants=tuple(variants) or scenario.variants)
    _check(scenario)
    return scenario


def _check(scenario: SweepScenario) -> None:
    """Check what is between keys."""
    _positive("step", scenario.step)
    for key in ("samples", "keep_every"):
        if getattr(scenario, key) < 1:
            raise InputError(f"{key} is {getattr(scenario, key)}; it must be at least 1")
    names = [f.name for f in scenario.fmus] + [s.name for s in scenario.signals]
    for name in names:
        if not name.isidentifier() or name in ("step", "duration"):
            raise InputError(
                f"{name!r} is no usable name of an FMU or a signal; use letters, digits, _"
            )
        if names.count(name) > 1:
            raise InputError(f"an FMU and a signal are both named {name!r}")
    for key in ("duration", "lead_in"):
        _check_span(key, getattr(scenario, key), scenario)
    columns = [v.name for v in scenario.vary] + [m.name for m in scenario.metrics]
    for name in columns:
        if name in RESERVED or name in scenario.keep or columns.count(name) > 1:
            raise InputError(f"two columns would be named {name!r}; give one another name")
    labels = [v.name for v in scenario.variants]
    if len(set(labels)) < len(labels):
        raise InputError("variant: two variants have one name")
    for variant in scenario.variants:
        for connection in variant.connections:
            _check_connection(connection, scenario)


def _check_connection(connection: Connection, scenario: SweepScenario) -> None:
    fmus, signals = ([x.name for x in group] for group in (scenario.fmus, scenario.signals))
    source, target = connection.source.partition("."), connection.target.partition(".")
    if not source[1] and source[0] not in signals:
        raise InputError(
            f"connections: there is no signal {source[0]!r}; {known_names(source[0], signals)}"
        )
    for name, dot, _ in (source, target):
        if dot and name not in fmus:
            raise InputError(f"connections: there is no FMU {name!r}; {known_names(name, fmus)}")
    if not target[1]:
        raise InputError(f"connections: to is {connection.target!r}; it must be FMU.input")


def _check_span(key: str, span: Span, scenario: SweepScenario) -> None:
    if span.of and span.of not in [s.name for s in scenario.signals]:
        known = known_names(span.of, [s.name for s in scenario.signals])
        raise InputError(f"{key}: there is no signal {span.of!r}; {known}")
    if key == "duration":
        _positive(key, span.seconds or span.periods)


def _positive(key: str, value: float) -> None:
    if not 0.0 < value < float("inf"):
        raise InputError(f"{key} is {value}; it must be positive and finite")


def _span(key: str, value: float | Mapping) -> Span:
    if not isinstance(value, Mapping):
        if value < 0.0:
            raise InputError(f"{key} is {value}; it must not be negative")
        return Span(seconds=value)
    entry = Keys(f"{key}: ", value)
    span = Span(periods=entry.take("periods", float), of=entry.take("of", str))
    entry.done()
    if span.periods < 0.0:
        raise InputError(f"{key}: periods is {span.periods}; it must not be negative")
    return span


def _fmu(name: str, table: object, parameters: str) -> Fmu:
    entry = Keys(f"fmu.{name}: ", table)
    fmu = Fmu(
        name,
        entry.take("source", str),
        entry.take("parameters", str, parameters),
        entry.take("start", dict, {}),
    )
    entry.done()
    return fmu


def _source(name: str, table: object) -> Source:
    entry = Keys(f"signal.{name}: ", table)
    signal = entry.choose("signal", (*excitations.SIGNALS, CSV))
    arguments = entry.rest()
    if signal == CSV:
        entry = Keys(f"signal.{name}: ", arguments)
        arguments = {
            "file": entry.take("file", str),
            "column": entry.take("column", str),
            **{key: entry.take(key, float, default) for key, default in CSV_NUMBERS.items()},
        }
        entry.done()
        return Source(name, signal, arguments)
    known = list(inspect.signature(excitations.SIGNALS[signal]).parameters)[1:]
    for key in arguments:
        if key not in known:
            raise InputError(
                f"signal.{name}: {signal!r} has no argument {key!r}; {known_names(key, known)}"
            )
    return Source(name, signal, arguments)


def check_csv_number(key: str, value: object) -> None:
    """Check one of `CSV_NUMBERS`."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not math.isfinite(value):
        raise InputError(f"{key} is {value!r}; it must be a finite number")
    if key == "time_factor" and not value > 0.0:
        raise InputError(f"{key} is {value:g}; it must be positive")


def _connections(place: str, entries: list) -> tuple[Connection, ...]:
    connections = []
    for i, table in enumerate(entries, start=1):
        entry = Keys(f"{place}connections {i}: ", table)
        connections.append(
            Connection(
                entry.take("from", str),
                entry.take("to", str),
                entry.take("factor", float, 1.0),
                entry.take("offset", float, 0.0),
            )
        )
        entry.done()
    return tuple(connections)


def _variant(number: int, table: object, connections: tuple[Connection, ...]) -> Variant:
    entry = Keys(f"variant {number}: ", table)
    name = entry.take("name", str)
    own = entry.take("connections", list, None)
    variant = Variant(
        name,
        connections if own is None else _connections(f"variant {number}: ", own),
        entry.take("set", dict, {}),
    )
    entry.done()
    return variant


def _vary(number: int, table: object, folder: Path) -> list[Vary]:
    place = f"vary {number}: "
    entry = Keys(place, table)
    of = entry.take("of", str | list)
    targets = tuple(_texts(f"{place}of", of if isinstance(of, list) else [of]))
    if not targets:
        raise InputError(f"{place}of is empty; name what is varied")
    intervals = entry.take("intervals", str | dict, None)
    if intervals is not None:
        method = entry.choose("method", DRAWN, DRAWN[1])
        only = tuple(_texts(f"{place}only", entry.take("only", list, [])))
        width = entry.take("width", float, 1.0)
        entry.done()
        draws = _draws(place, intervals, only, width, folder)
        return [
            Vary(place, name, tuple(f"{fmu}.{name}" for fmu in targets), method, **draw)
            for name, draw in draws.items()
        ]
    vary = Vary(
        place=place,
        name=entry.take("name", str, targets[0]),
        targets=targets,
        method=entry.choose("method", METHODS, METHODS[0]),
        values=tuple(_numbers(f"{place}values", entry.take("values", list, []))),
        range=_pair(place, "range", entry.take("range", list, None)),
        normal=_pair(place, "normal", entry.take("normal", list, None)),
        count=entry.take("count", int, 0),
        scale=entry.choose("scale", SCALES, SCALES[0]),
        factor=entry.take("factor", bool, False),
        unit=entry.take("unit", str, ""),
    )
    entry.done()
    _check_vary(vary)
    return [vary]


def _draws(
    place: str, intervals: str | Mapping, only: tuple[str, ...], width: float, folder: Path
) -> dict[str, dict]:
    """Return how every parameter is drawn from its interval.

    From a given interval evenly, from the 95 % interval of an identification normally. What an
    identification could not determine has no interval and is left alone. `only` names parameters, or
    fields of all rules; `width` scales the intervals.
    """
    if not width > 0.0:
        raise InputError(f"{place}width is {width}; it must be positive")
    if isinstance(intervals, Mapping):
        spans = {n: _pair(place, f"intervals.{n}", v) for n, v in intervals.items()}
        values = {n: 0.5 * (low + high) for n, (low, high) in spans.items()}
    else:
        found = _identified(place, folder / intervals)
        spans = {n: e["ci95"] for n, e in found.items() if None not in e["ci95"]}
        values = {n: found[n]["value"] for n in spans}
    known = {*spans, *(n.rpartition(".")[2] for n in spans)}
    for name in only:
        if name not in known:
            raise InputError(
                f"{place}only: no interval of {name!r}; {known_names(name, sorted(known))}"
            )
    draws = {}
    for name, (low, high) in spans.items():
        half = 0.5 * width * (high - low)
        if not half >= 0.0:
            raise InputError(f"{place}intervals.{name} is [{low:g}, {high:g}]; it must be [low, high]")
        if only and name not in only and name.rpartition(".")[2] not in only:
            continue
        if isinstance(intervals, Mapping):
            draws[name] = {"range": (values[name] - half, values[name] + half)}
        else:
            draws[name] = {"normal": (values[name], half / NORMAL_95)}
    return draws


def _identified(place: str, path: Path) -> dict:
    """Return the parameters of an identification's report.json."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))["parameters"]
    except OSError:
        raise InputError(f"{place}intervals: {path}: no such file, or it cannot be read") from None
    except (ValueError, KeyError, TypeError):
        raise InputError(f"{place}intervals: {path} is no report.json of `it2hys identify`") from None


def _check_vary(vary: Vary) -> None:
    place, drawn = vary.place, vary.method in DRAWN
    given = [bool(vary.values), vary.range is not None, vary.normal is not None]
    if sum(given) != 1:
        raise InputError(f"{place}give one of values, range and normal")
    if vary.normal is not None and not drawn:
        raise InputError(f"{place}normal needs the method 'random' or 'latin hypercube'")
    if vary.normal is not None and vary.normal[1] < 0.0:
        raise InputError(f"{place}normal is [mean, standard deviation]; the latter is negative")
    if vary.range is not None:
        low, high = vary.range
        if not low <= high:
            raise InputError(f"{place}range is [{low:g}, {high:g}]; it must be [low, high]")
        if vary.scale == "log" and low <= 0.0:
            raise InputError(f"{place}range must be positive where scale is 'log'")
        if not drawn and vary.count < 2:
            raise InputError(f"{place}count is {vary.count}; a range needs at least 2 values")


def _metric(number: int, table: object) -> Metric:
    place = f"metric {number}: "
    entry = Keys(place, table)
    kind = entry.choose("kind", tuple(KINDS))
    metric = Metric(
        entry.take("name", str, kind), kind, entry.take("of", str), entry.take("against", str, "")
    )
    entry.done()
    if KINDS[kind].compares and not metric.against:
        raise InputError(f"{place}{kind} compares: key 'against' is missing")
    if metric.against and not KINDS[kind].compares:
        raise InputError(f"{place}{kind} is of one output; leave out 'against'")
    return metric


def _figure(number: int, table: object) -> FigureEntry:
    place = f"figure {number}: "
    entry = Keys(place, table)
    figure = FigureEntry(
        kind=entry.choose("kind", FIGURES),
        title=entry.take("title", str, ""),
        x=entry.take("x", str, ""),
        y=entry.take("y", str, ""),
        value=entry.take("value", str, ""),
        by=entry.take("by", str, ""),
        x_scale=entry.choose("x_scale", SCALES, SCALES[0]),
        y_scale=entry.choose("y_scale", SCALES, SCALES[0]),
        select=entry.take("select", dict, {}),
    )
    entry.done()
    needed = {"heat map": ("x", "y", "value"), "lines": ("x", "value"), "loops": ("x", "y")}
    for key in needed.get(figure.kind, ("value",)):
        if not getattr(figure, key):
            raise InputError(f"{place}key {key!r} is missing; a figure {figure.kind!r} needs it")
    return figure


def _texts(place: str, values: list) -> list[str]:
    for value in values:
        if not isinstance(value, str):
            raise InputError(f"{place} has {value!r}; it must be a list of texts")
    return values


def _numbers(place: str, values: list) -> list[float]:
    for value in values:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{place} has {value!r}; it must be a list of numbers")
    return [float(v) for v in values]


def _pair(place: str, key: str, values: list | None) -> tuple[float, float] | None:
    if values is None:
        return None
    if not isinstance(values, list) or len(values) != 2:
        raise InputError(f"{place}{key} is {values!r}; it must be a list of two numbers")
    return tuple(_numbers(f"{place}{key}", values))
