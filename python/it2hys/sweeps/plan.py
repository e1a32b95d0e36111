"""A plan: everything that a worker needs to run any case of a sweep.

It is pickled once for every worker, on this machine or another. The values of all cases are in it, so
that no result depends on who runs which case.
"""

from __future__ import annotations

import inspect
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from it2hys.cosimulation.stepping import Connection
from it2hys.errors import InputError
from it2hys.stand import excitations
from it2hys.sweeps.schema import CSV, CSV_NUMBERS, FigureEntry, Metric, Source, Span, check_csv_number

#: Ticks and cases of a chunk, the unit of work and of what is lost by an interruption.
CHUNK_TICKS, CHUNK_CASES = 1_000_000, 100
#: Cases of a sweep and steps of a case that can be run: a case's signals and outputs are in memory.
LARGEST_CASES, LARGEST_STEPS = 10_000_000, 100_000_000


@dataclass(frozen=True)
class Axis:
    """A column of what is varied, and the targets that it sets; `base` is multiplied by factors.

    `method` and `scale` are those of its scenario; no number of the table depends on them any more.
    """

    name: str
    targets: tuple[str, ...]
    bases: tuple[float, ...]
    unit: str
    method: str = "grid"
    scale: str = "linear"


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
        return self._set(self.setups[self.variant[case]], self.matrix[case].tolist())

    @property
    def timed(self) -> set[str]:
        """Targets that the step and the number of steps of a case depend on."""
        spans = [self.signals[span.of] for span in (self.duration, self.lead_in) if span.of]
        return {"step", "duration", *(f"{source.name}.{source.clock}" for source in spans)}

    def timing(self) -> Iterator[tuple[np.ndarray, dict[str, Any]]]:
        """Yield the cases of every variant, and those of their values that times depend on.

        A value is one for all, or an array with one for each.
        """
        wanted = self.timed
        for index, setup in enumerate(self.setups):
            cases = np.flatnonzero(self.variant == index)
            values = self._set(setup, self.matrix[cases].T, wanted)
            yield cases, {target: value for target, value in values.items() if target in wanted}

    def _set(
        self, setup: Setup, numbers: Iterable, wanted: Collection[str] | None = None
    ) -> dict[str, Any]:
        """Return what is set by target, for the numbers of the axes."""
        values = dict(setup.values)
        for axis, number in zip(self.axes, numbers, strict=True):
            for target, base in zip(axis.targets, axis.bases, strict=True):
                if wanted is None or target in wanted:
                    values[target] = number * base
        return values

    def seconds(self, span: Span, values: Mapping[str, Any]) -> Any:
        """Return a time in s, for the values of a case, or for arrays of them."""
        if not span.of:
            return span.seconds
        source = self.signals[span.of]
        number = values.get(f"{source.name}.{source.clock}")
        if number is None:
            number = argument(source, source.clock)
        if source.signal == CSV:
            time = source.arguments["time"]
            return span.periods * (time[-1] + time[1] - time[0]) * number
        return span.periods / number

    def times(self, values: Mapping[str, Any]) -> tuple[Any, Any]:
        """Return communication step and duration in s."""
        step = values.get("step", self.step)
        duration = values.get("duration")
        return step, self.seconds(self.duration, values) if duration is None else duration

    def steps(self, values: Mapping[str, Any]) -> tuple[Any, Any, Any]:
        """Return communication step in s, number of steps, and how many metrics leave out."""
        step, duration = self.times(values)
        count = excitations.tick_count(duration, step)
        return step, count, np.rint(self.seconds(self.lead_in, values) / step).astype(np.int64)

    def lengths(self) -> np.ndarray:
        """Return the number of steps of every case, shape (cases,)."""
        lengths = np.empty(self.cases, dtype=np.int64)
        for cases, values in self.timing():
            lengths[cases] = self.steps(values)[1]
        return lengths

    def chunks(self) -> list[range]:
        """Return the cases in runs of similar work, the same whoever works."""
        work = self.lengths().tolist()
        chunks, first, ticks = [], 0, 0
        for case in range(self.cases):
            if case > first and (ticks + work[case] > CHUNK_TICKS or case - first >= CHUNK_CASES):
                chunks.append(range(first, case))
                first, ticks = case, 0
            ticks += work[case]
        return [*chunks, range(first, self.cases)]


def by_owner(values: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return what is set of every FMU and signal, by its name there, for values by target."""
    owned: dict[str, dict[str, Any]] = {}
    for target, value in values.items():
        owner, _, name = target.partition(".")
        owned.setdefault(owner, {})[name] = value
    return owned


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
    source: Source, own: Mapping[str, float], times: np.ndarray, duration: float
) -> np.ndarray:
    """Return a signal at some times, with what a case sets of it.

    A CSV signal is interpolated linearly and held beyond its ends; a chirp lasts as long as the run
    unless it says otherwise.
    """
    arguments = dict(source.arguments)
    for key, value in own.items():
        arguments[key] = int(value) if key == "seed" else value
    if source.signal == CSV:
        for key in CSV_NUMBERS:
            check_csv_number(key, arguments[key])
        read = np.interp(times / arguments["time_factor"], arguments["time"], arguments["values"])
        return arguments["factor"] * read + arguments["offset"]
    function = excitations.SIGNALS[source.signal]
    if "duration" in inspect.signature(function).parameters:
        arguments.setdefault("duration", duration)
    return function(times, **arguments)
