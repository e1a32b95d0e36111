"""Scenarios: experiments described in TOML files, checked here and run by name.

A scenario makes records on the simulated test stand, identifies a model or takes Table 1, may drive
the stand through the inverse FMU or compare estimators, and sets its errors beside the paper's.
What every key means stands below it; the documentation is made from that.
"""

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, StrictBool, StrictFloat, StrictInt, model_validator

from it2hys.designs.limits import Wanted
from it2hys.errors import InputError
from it2hys.reports.answers import ROLES
from it2hys.stand import PARTS as STAND_PARTS
from it2hys.stand import Stand, excitations
from it2hys.support.keys import read_toml
from it2hys.support.tables import Table, read_table

SAMPLE_TIME = 1e-4
#: Samples that a record may have: fits hold all of them in memory, several times.
MOST_SAMPLES = 10_000_000
MODELS = ("identified", "diagnosed", "table 1")


class Paper(Table):
    """Published figures, where there are any: (24) in %, (25) in µm, and the figure's number."""

    e_mr_percent: StrictFloat | None = None
    """(24), in %."""
    e_rms_um: StrictFloat | None = None
    """(25), in µm."""
    proportional_e_mr_percent: StrictFloat | None = None
    """(24) of a proportional feedforward, in %."""
    figure: StrictInt | None = None
    """Number of the figure."""


class Signal(Table, extra="allow"):
    """A signal of `it2hys.stand.excitations` with its duration in s and its other arguments."""

    signal: Literal[*excitations.SIGNALS]
    """A function of `it2hys.stand.excitations`; its arguments, but for time, are further keys."""
    duration: StrictFloat
    """Duration, s."""
    paper: Paper = Paper()
    """The paper's figures for it."""

    @property
    def time(self) -> np.ndarray:
        """Times of the ticks, s."""
        return excitations.time_grid(self.duration, SAMPLE_TIME)

    def values(self) -> np.ndarray:
        """Return the signal, V; references in m."""
        return excitations.SIGNALS[self.signal](self.time, **self.model_extra)

    @model_validator(mode="after")
    def _evaluate(self) -> "Signal":
        samples = self.duration / SAMPLE_TIME
        if samples > MOST_SAMPLES:
            raise ValueError(
                f"duration is {self.duration:g} s: {samples:.3g} samples every {SAMPLE_TIME:g} s; "
                f"at most {MOST_SAMPLES:,} are allowed, so shorten it"
            )
        try:
            self.values()
        except (TypeError, InputError) as error:
            raise ValueError(f"signal {self.signal!r}: {error}") from None
        return self


class RecordEntry(Signal):
    """A record to be made on the stand, and its role."""

    name: str
    """Name of the record."""
    role: Literal[*ROLES]
    """`train` (fitted), `validation` (decides between models) or `test` (only reported on)."""


class Tracking(Signal):
    """A reference to be tracked; errors leave out `lead_in` seconds."""

    lead_in: StrictFloat = 0.0
    """Seconds at the start that errors leave out."""


class NextEntry(Table):
    """The record that is designed from what the others leave open, and measured in their place."""

    name: str = "designed"
    """Name of the record."""
    duration: StrictFloat | None = None
    """Duration, s; that of the training records by default."""
    rate: StrictFloat | None = None
    """Fastest change, V/s."""
    band: tuple[StrictFloat, StrictFloat] | None = None
    """Band of the references to come, Hz."""

    def wanted(self) -> Wanted:
        """Return the limits: duration, s, fastest change, V/s, and band of later references, Hz."""
        return Wanted(duration=self.duration, rate=self.rate, band=self.band)


class StandEntry(Table):
    """Parts that the simulated stand lacks, and its noise in m rms."""

    without: tuple[Literal[*STAND_PARTS], ...] = ()
    """Parts of the simulated stand that are left out."""
    noise: StrictFloat = Stand().noise
    """Noise of the sensor, m rms."""

    def stand(self) -> Stand:
        """Return the stand."""
        return Stand(noise=self.noise, **dict.fromkeys(self.without))


def _in_order(records: tuple[RecordEntry, ...]) -> tuple[RecordEntry, ...]:
    return tuple(sorted(records, key=lambda record: list(ROLES).index(record.role)))


class Scenario(Table):
    """A checked scenario; records are in the order of their roles."""

    name: str = Field("", init=False)
    title: str | None = None
    """Title of the report; the name of the file by default."""
    text: str = ""
    """First paragraph of the report."""
    seed: StrictInt = 0
    """Seed of noise and random starts."""
    model: Literal[*MODELS] = MODELS[0]
    """`"diagnosed"` adds the effects that the identified model lacks."""
    rules: StrictInt | None = None
    """Number of rules; chosen on the validation records by default."""
    stand: Annotated[StandEntry, AfterValidator(StandEntry.stand)] = Stand()
    """The simulated stand."""
    records: Annotated[tuple[RecordEntry, ...], AfterValidator(_in_order)] = Field(alias="record")
    """Records that are made on the stand."""
    tracking: Tracking | None = None
    """A reference that the stand is to follow, driven by the inverse FMU."""
    next: NextEntry | None = None
    """With `"diagnosed"`: a record is designed from what the training records leave open, measured
    on the stand in their place, and diagnosed from the first model."""
    estimators: StrictBool = False
    """Compare all solvers."""

    @model_validator(mode="after")
    def _can_be_identified(self) -> "Scenario":
        if self.model != "table 1" and not any(r.role == "train" for r in self.records):
            raise ValueError("record: a model can only be identified with a record of role 'train'")
        if self.next and self.model != "diagnosed":
            raise ValueError(
                'next: a record is designed after a diagnosis only; set model = "diagnosed"'
            )
        return self


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
        scenario = read_table(Scenario, table)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    title = path.stem if scenario.title is None else scenario.title
    return scenario.model_copy(update={"name": path.stem, "title": title})
