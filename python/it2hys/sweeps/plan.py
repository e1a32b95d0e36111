"""A plan: what a worker needs to run any case of a sweep, all of it.

It is pickled once for every worker, on this machine or another. The values of all cases are in it, so
that no result depends on who runs which case.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from it2hys import excitations
from it2hys.errors import InputError
from it2hys.stepping import Connection
from it2hys.sweeps.schema import CSV, FigureEntry, Metric, Source, Span

#: Ticks and cases of a chunk, the unit of work and of what is lost by an interruption.
CHUNK_TICKS, CHUNK_CASES = 1_000_000, 100


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
