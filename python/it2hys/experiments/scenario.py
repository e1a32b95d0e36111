"""Scenarios: experiments described in TOML files, checked here and run by name.

A scenario makes records on the simulated test stand, identifies a model or takes Table 1, may drive
the stand through the inverse FMU or compare estimators, and sets its errors beside the paper's.
`scenarios/README.md` describes every key.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import numpy as np

from it2hys.errors import InputError
from it2hys.reports.identification_report import ROLES
from it2hys.stand import PARTS as STAND_PARTS
from it2hys.stand import Stand, excitations
from it2hys.support.keys import Keys, read_toml

SAMPLE_TIME = 1e-4
MODELS = ("identified", "diagnosed", "table 1")


@dataclass(frozen=True)
class Paper:
    """Published figures, where there are any: (24) in %, (25) in um, and the figure's number."""

    e_mr_percent: float | None = None
    e_rms_um: float | None = None
    proportional_e_mr_percent: float | None = None
    figure: int | None = None


@dataclass(frozen=True)
class Signal:
    """A signal of `it2hys.stand.excitations` with its duration in s and its other arguments."""

    signal: str
    duration: float
    arguments: Mapping[str, float]
    paper: Paper = field(default_factory=Paper)

    @property
    def time(self) -> np.ndarray:
        """Times of the ticks, s."""
        return excitations.time_grid(self.duration, SAMPLE_TIME)

    def values(self) -> np.ndarray:
        """Return the signal, V; references in m."""
        return excitations.SIGNALS[self.signal](self.time, **self.arguments)


@dataclass(frozen=True)
class RecordEntry:
    """A record to be made on the stand, and its role."""

    name: str
    role: str
    signal: Signal


@dataclass(frozen=True)
class Tracking:
    """A reference to be tracked; errors leave out `lead_in` seconds."""

    signal: Signal
    lead_in: float = 0.0


@dataclass(frozen=True)
class Scenario:
    """A checked scenario."""

    name: str
    title: str
    text: str
    seed: int
    model: str
    rules: int | None
    stand: Stand
    records: tuple[RecordEntry, ...]
    tracking: Tracking | None
    estimators: bool


def read_scenario(path: Path) -> Scenario:
    """Read and check a scenario file; every signal is evaluated once.

    Raises
    ------
    InputError
        If the file is missing, is not TOML, or has a key that is unknown, missing or of the wrong
        kind. The message names the file and the key.
    """
    table = read_toml(path)
    if "fmu" in table:
        raise InputError(f"{path}: a sweep of FMUs; `it2hys sweep` runs it")
    try:
        return _scenario(path.stem, table)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _scenario(name: str, table: Mapping) -> Scenario:
    entry = Keys("", table)
    scenario = Scenario(
        name=name,
        title=entry.take("title", str, name),
        text=entry.take("text", str, ""),
        seed=entry.take("seed", int, 0),
        model=entry.choose("model", MODELS, MODELS[0]),
        rules=entry.take("rules", int, None),
        stand=_stand(entry.take("stand", dict, {})),
        records=tuple(
            _record(f"record {i}: ", record)
            for i, record in enumerate(entry.take("record", list), start=1)
        ),
        tracking=_tracking(entry.take("tracking", dict, None)),
        estimators=entry.take("estimators", bool, False),
    )
    entry.done()
    if scenario.model != "table 1" and not any(r.role == "train" for r in scenario.records):
        raise InputError("record: a model can only be identified with a record of role 'train'")
    order = list(ROLES)
    return replace(scenario, records=tuple(sorted(scenario.records, key=lambda r: order.index(r.role))))


def _stand(table: Mapping) -> Stand:
    entry = Keys("stand: ", table)
    without = entry.take("without", list, [])
    noise = entry.take("noise", float, Stand().noise)
    entry.done()
    for part in without:
        if part not in STAND_PARTS:
            raise InputError(
                f"stand: unknown part {part!r} in without; known are {', '.join(STAND_PARTS)}"
            )
    return replace(Stand(noise=noise), **dict.fromkeys(without))


def _record(place: str, table: Mapping) -> RecordEntry:
    entry = Keys(place, table)
    name, role = entry.take("name", str), entry.choose("role", tuple(ROLES))
    return RecordEntry(name, role, _signal(place, entry))


def _tracking(table: Mapping | None) -> Tracking | None:
    if table is None:
        return None
    entry = Keys("tracking: ", table)
    lead_in = entry.take("lead_in", float, 0.0)
    return Tracking(_signal("tracking: ", entry), lead_in)


def _signal(place: str, entry: Keys) -> Signal:
    """Take the keys of a signal; those that are not ours are the arguments of its function."""
    name = entry.choose("signal", tuple(excitations.SIGNALS))
    duration = entry.take("duration", float)
    paper = _paper(place, entry.take("paper", dict, {}))
    signal = Signal(name, duration, entry.rest(), paper)
    try:
        signal.values()
    except (TypeError, InputError) as error:
        raise InputError(f"{place}signal {name!r}: {error}") from None
    return signal


def _paper(place: str, table: Mapping) -> Paper:
    entry = Keys(f"{place}paper: ", table)
    kinds = {f.name: int if f.name == "figure" else float for f in fields(Paper)}
    paper = Paper(**{name: entry.take(name, kind, None) for name, kind in kinds.items()})
    entry.done()
    return paper
