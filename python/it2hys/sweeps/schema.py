"""Sweep scenarios: TOML files that say which FMUs run, on what signals, varied how, judged by what.

What every key means stands below it; the documentation is made from that. Reading checks everything
that can be known without the FMUs; `it2hys.sweeps.cases` checks the rest against them, before any
case runs.
"""

from __future__ import annotations

import inspect
import json
import math
from collections.abc import Callable, Mapping
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainValidator,
    StrictBool,
    StrictFloat,
    StrictInt,
    WrapValidator,
    model_validator,
)

from it2hys.cosimulation.stepping import Connection
from it2hys.errors import InputError
from it2hys.stand import excitations
from it2hys.support.keys import known_names, read_toml
from it2hys.support.tables import Table, read_table
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

T = TypeVar("T", bound=Table)


def _named(tables: dict[str, T]) -> tuple[T, ...]:
    """Return tables that have their names from the keys before them, such as ``fmu.NAME``."""
    return tuple(table.model_copy(update={"name": name}) for name, table in tables.items())


def _seconds(value: object) -> object:
    """Return what a time in s is as a table; a table stays as it is."""
    if isinstance(value, Mapping):
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError("it must be a number or a table")
    if value < 0.0:
        raise ValueError("it must not be negative")
    return Span.model_construct(seconds=float(value), periods=0.0, of="")


def _targets(value: object) -> object:
    if isinstance(value, str):
        return [value]
    if not isinstance(value, list):
        raise ValueError("it must be a text or a list")
    if not value:
        raise ValueError("name at least one target")
    return value


def _file_or_table(value: object, read: Callable[[object], dict]) -> str | dict:
    if not isinstance(value, str | Mapping):
        raise ValueError("it must be a text or a table")
    return value if isinstance(value, str) else read(value)


def _two(values: tuple[float, ...]) -> tuple[float, ...]:
    if len(values) != 2:
        raise ValueError("it must be a list of two numbers")
    return values


Numbers = tuple[StrictFloat, ...]
Pair = Annotated[Numbers, AfterValidator(_two)]
Targets = Annotated[tuple[str, ...], BeforeValidator(_targets)]
Scale = Literal[*SCALES]


class Fmu(Table):
    """An FMU of a scenario: one of ours by its name, or a file; and its start values."""

    name: str = Field("", init=False)
    source: str
    """`"IT2Plant"`, `"IT2Inverse"`, `"PIController"`, or the path of an FMU for co-simulation."""
    parameters: str | None = None
    """Another parameter set for this FMU: an SSV file or `"table 1"`."""
    start: dict[str, Any] = Field({})
    """Start values by variable."""


class CsvArguments(Table):
    """The keys of a signal that is read from a CSV file."""

    signal: Literal[CSV]
    """A column of a CSV as `it2hys simulate` reads it; interpolated, and held at its ends."""
    file: str
    """The CSV file."""
    column: str
    """The quantity whose column is read."""
    factor: StrictFloat = CSV_NUMBERS["factor"]
    """The signal is factor · column + offset, in SI units. Can be varied."""
    offset: StrictFloat = CSV_NUMBERS["offset"]
    """Added to the signal, in SI units; see `factor`. Can be varied."""
    time_factor: StrictFloat = CSV_NUMBERS["time_factor"]
    """Multiplies the times: 0.5 doubles the frequencies. Can be varied."""


class Source(Table, extra="allow"):
    """A signal: a function of `stand.excitations` and its arguments, or a column of a CSV file."""

    name: str = Field("", init=False)
    signal: Literal[*excitations.SIGNALS, CSV]
    """A function of `it2hys.stand.excitations`, with its arguments, but for time, as further keys;
    or `"csv"`."""

    @property
    def arguments(self) -> Mapping[str, Any]:
        """The keys beside `name` and `signal`: the arguments of the signal."""
        return self.model_extra

    @property
    def clock(self) -> str:
        """The argument that says how long a period is."""
        return "time_factor" if self.signal == CSV else "frequency"

    @model_validator(mode="after")
    def _check_arguments(self) -> Source:
        if self.signal == CSV:
            given = CsvArguments(signal=CSV, **self.arguments)
            return Source.model_construct(**given.model_dump())
        known = list(inspect.signature(excitations.SIGNALS[self.signal]).parameters)[1:]
        for key in self.arguments:
            if key not in known:
                raise ValueError(f"{self.signal!r} has no argument {key!r}; {known_names(key, known)}")
        return self


class Span(Table):
    """A time in s, or in periods of a signal: of its frequency, or the length of a CSV."""

    seconds: float = Field(0.0, init=False)
    periods: StrictFloat = Field(ge=0)
    """Number of periods."""
    of: str
    """The signal whose periods these are: of its `frequency`, or the length of a CSV."""


class ConnectionEntry(Table):
    """A connection as it is written."""

    source: str = Field(alias="from")
    """A signal, or an output `FMU.variable`."""
    target: str = Field(alias="to")
    """The input `FMU.variable` that gets factor · from + offset."""
    factor: StrictFloat = 1.0
    """Factor of the signal; see `to`."""
    offset: StrictFloat = 0.0
    """Added to the signal; see `to`."""

    def connection(self) -> Connection:
        """Return the connection."""
        return Connection(**dict(self))


Connections = tuple[Annotated[ConnectionEntry, AfterValidator(ConnectionEntry.connection)], ...]


class Intervals(Table):
    """Parameters that are drawn from intervals, given ones or those of an identification."""

    targets: Targets = Field(alias="of")
    """Names of FMUs whose parameters are drawn."""
    intervals: Annotated[dict[str, Pair], WrapValidator(_file_or_table)]
    """The `report.json` of `it2hys identify`, or `{ "rule[1].q1" = [low, high] }`. Every parameter
    with an interval is drawn: normally from the 95 % interval of a report, evenly from a given
    one, each by itself."""
    method: Literal[*DRAWN] = DRAWN[1]
    """How the `samples` draws are made."""
    only: tuple[str, ...] = ()
    """Parameters or fields (`["q2"]`) that are drawn; all by default."""
    width: StrictFloat = Field(1.0, gt=0)
    """Factor by which the intervals are widened."""


class Vary(Table):
    """What is varied: targets, the column that says how, and where values come from."""

    place: str = Field("", init=False)
    targets: Targets = Field(alias="of")
    """Target or list of targets: `FMU.variable`, `SIGNAL.argument`, `"step"` or `"duration"`."""
    name: str = Field(default_factory=lambda data: data["targets"][0])
    """Column of the table; the first target by default."""
    method: Literal[*METHODS] = METHODS[0]
    """`"grid"`: all with all; `"list"`: the lists go together, row by row; `"random"` and `"latin
    hypercube"`: `samples` draws. Grids, lists and draws are crossed."""
    values: Numbers = ()
    """List of numbers; drawn from evenly by the random methods."""
    range: Pair | None = None
    """Ends of the range, `[low, high]`."""
    normal: Pair | None = None
    """`[mean, standard deviation]` of the normal distribution that is drawn from."""
    count: StrictInt = 0
    """Number of points of a grid over a range."""
    scale: Scale = SCALES[0]
    """How points are spread over a range."""
    factor: StrictBool = False
    """`true`: the numbers multiply the value that the target has otherwise."""
    unit: str = ""
    """Unit of the column; the target's own by default."""
    intervals: None = None  #: known, but then it is `Intervals`

    @model_validator(mode="after")
    def _check(self) -> Vary:
        drawn = self.method in DRAWN
        given = [bool(self.values), self.range is not None, self.normal is not None]
        if sum(given) != 1:
            raise ValueError("give one of values, range and normal")
        if self.normal is not None and not drawn:
            raise ValueError("normal needs the method 'random' or 'latin hypercube'")
        if self.normal is not None and self.normal[1] < 0.0:
            raise ValueError("normal is [mean, standard deviation]; the latter is negative")
        if self.range is not None:
            low, high = self.range
            if not low <= high:
                raise ValueError(f"range is [{low:g}, {high:g}]; it must be [low, high]")
            if self.scale == "log" and low <= 0.0:
                raise ValueError("range must be positive where scale is 'log'")
            if not drawn and self.count < 2:
                raise ValueError(f"count is {self.count}; a range needs at least 2 values")
        return self


def _vary(table: object) -> Vary | Intervals:
    kind = Intervals if isinstance(table, Mapping) and "intervals" in table else Vary
    return kind.model_validate(table)


class Variant(Table):
    """One of several set-ups that are compared: other connections, other values."""

    name: str
    """Name of the set-up in the table."""
    connections: Connections | None = None
    """Its connections; those of the scenario by default."""
    values: dict[str, Any] = Field({}, alias="set")
    """Values by target."""


class Metric(Table):
    """A number that judges a case."""

    kind: Literal[*KINDS]
    """Kind of the metric; see the table of kinds."""
    name: str = Field(default_factory=lambda data: data["kind"])
    """Column of the table; the kind by default."""
    of: str
    """The output that is judged."""
    against: str = ""
    """The signal or output that it is compared with, for kinds that compare."""

    @model_validator(mode="after")
    def _check(self) -> Metric:
        if KINDS[self.kind].compares and not self.against:
            raise ValueError(f"{self.kind} compares: key 'against' is missing")
        if self.against and not KINDS[self.kind].compares:
            raise ValueError(f"{self.kind} compares with nothing; leave out 'against'")
        return self


class FigureEntry(Table):
    """A figure of the report, drawn from columns of the table."""

    kind: Literal[*FIGURES]
    """Kind of the figure; see the table of kinds."""
    title: str = ""
    """Title of the figure."""
    x: str = ""
    """Column of the horizontal axis."""
    y: str = ""
    """Column of the vertical axis."""
    value: str = ""
    """Column that is shown."""
    by: str = ""
    """Column with a line, or a colour, for every value."""
    x_scale: Scale = SCALES[0]
    """Scale of the horizontal axis."""
    y_scale: Scale = SCALES[0]
    """Scale of the vertical axis."""
    select: dict[str, Any] = Field({})
    """Draw the cases with these values of columns, such as `{ frequency = 20.0 }`, or the nearest
    there are."""

    @model_validator(mode="after")
    def _check(self) -> FigureEntry:
        needed = {"heat map": ("x", "y", "value"), "lines": ("x", "value"), "loops": ("x", "y")}
        for key in needed.get(self.kind, ("value",)):
            if not getattr(self, key):
                raise ValueError(f"key {key!r} is missing; a figure {self.kind!r} needs it")
        return self


class SweepScenario(Table):
    """A checked scenario; relative paths begin in `folder`, and `file` is empty for a dictionary."""

    name: str = Field("", init=False)
    folder: Path = Field(Path(), init=False)
    file: str = Field("", init=False)
    title: str | None = None
    """Title of the report; the name of the file by default."""
    text: str = ""
    """First paragraph of the report."""
    seed: StrictInt = 0
    """Seed of the random draws."""
    samples: StrictInt = Field(100, ge=1)
    """Number of draws."""
    duration: Annotated[Span, BeforeValidator(_seconds)]
    """Duration of a case: s, or `{ periods = 4.0, of = "SIGNAL" }`."""
    step: StrictFloat = Field(1e-4, gt=0, allow_inf_nan=False)
    """Communication step, s."""
    lead_in: Annotated[Span, BeforeValidator(_seconds)] = _seconds(0.0)
    """Time at the start that metrics leave out; written like `duration`."""
    parameters: str = TABLE_1
    """Parameter set of this project's FMUs: an SSV file or `"table 1"`."""
    fmus: Annotated[dict[str, Fmu], AfterValidator(_named)] = Field(alias="fmu")
    """The FMUs, by name."""
    signals: Annotated[dict[str, Source], AfterValidator(_named)] = Field((), alias="signal")
    """The signals, by name."""
    connections: Connections = ()
    """Connections of signals and outputs to inputs."""
    variants: tuple[Variant, ...] = Field((), alias="variant")
    """Set-ups that are compared; one by default."""
    vary: tuple[Annotated[Vary | Intervals, PlainValidator(_vary)], ...] = ()
    """Axes that are varied."""
    metrics: tuple[Metric, ...] = Field((), alias="metric")
    """Metrics that judge a case."""
    keep: tuple[str, ...] = ()
    """Outputs and signals whose traces the table keeps."""
    keep_every: StrictInt = Field(1, ge=1)
    """The traces keep one sample in so many steps."""
    figures: tuple[FigureEntry, ...] = Field((), alias="figure")
    """Figures of the report; one for every metric by default."""

    @property
    def fmu_files(self) -> list[Path]:
        """The FMUs that are files; ours go by their names."""
        paths = (self.folder / fmu.source for fmu in self.fmus)
        return [path for path in paths if path.is_file()]


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
        return parse_sweep(table, path.stem, path.parent).model_copy(update={"file": str(path)})
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def parse_sweep(table: Mapping, name: str = "sweep", folder: Path = Path(".")) -> SweepScenario:
    """Check a scenario given as a dictionary with the keys of a scenario file."""
    read = read_table(SweepScenario, table)
    columns = [_columns(f"vary {i}: ", vary, folder) for i, vary in enumerate(read.vary, start=1)]
    changes = {
        "name": name,
        "folder": folder,
        "title": name if read.title is None else read.title,
        "fmus": _filled(read.fmus, "parameters", read.parameters),
        "variants": _filled(read.variants or (Variant(name=""),), "connections", read.connections),
        "vary": tuple(chain.from_iterable(columns)),
    }
    scenario = read.model_copy(update=changes)
    _check(scenario)
    return scenario


def _filled(tables: tuple[T, ...], key: str, value: object) -> tuple[T, ...]:
    """Return tables with what the scenario says where they do not say it themselves."""
    return tuple(t.model_copy(update={key: value}) if getattr(t, key) is None else t for t in tables)


def _check(scenario: SweepScenario) -> None:
    """Check what is between keys."""
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
    length = span.seconds or span.periods
    if key == "duration" and not 0.0 < length < math.inf:
        raise InputError(f"{key} is {length}; it must be positive and finite")


def check_csv_number(key: str, value: object) -> None:
    """Check one of `CSV_NUMBERS`."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not math.isfinite(value):
        raise InputError(f"{key} is {value!r}; it must be a finite number")
    if key == "time_factor" and not value > 0.0:
        raise InputError(f"{key} is {value:g}; it must be positive")


def _columns(place: str, vary: Vary | Intervals, folder: Path) -> list[Vary]:
    if isinstance(vary, Vary):
        return [vary.model_copy(update={"place": place})]
    return [
        Vary.model_construct(
            place=place,
            name=name,
            targets=tuple(f"{fmu}.{name}" for fmu in vary.targets),
            method=vary.method,
            **draw,
        )
        for name, draw in _draws(place, vary, folder).items()
    ]


def _draws(place: str, vary: Intervals, folder: Path) -> dict[str, dict]:
    """Return how every parameter is drawn from its interval.

    From a given interval evenly, from the 95 % interval of an identification normally. What an
    identification could not determine has no interval and is left alone. `only` names parameters, or
    fields of all rules; `width` scales the intervals.
    """
    intervals, only, width = vary.intervals, vary.only, vary.width
    if isinstance(intervals, Mapping):
        spans = intervals
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
