"""How a packaged set begins: at rest at zero voltage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import brentq

from it2hys.diagnosis.fitting import UNLIMITED
from it2hys.identification.criterion import Model, Trace
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet
from it2hys.policy import STARTS
from it2hys.records import Record


def begins_at_zero(record: Record, voltage_range: tuple[float, float]) -> bool:
    """Return whether a record begins at zero voltage, or as near to it as its range goes, and stays."""
    low, high = voltage_range
    first = record.voltage[: STARTS.standing]
    return bool(np.all(np.abs(first - np.clip(0.0, low, high)) <= STARTS.slack * (high - low)))


def resting(parameters: ParameterSet, voltage: float = 0.0) -> ParameterSet:
    """Return the set that begins at long rest at a voltage, V, or as near to it as the range goes."""
    wanted = float(np.clip(voltage, *parameters.voltage_range))

    def excess(displacement: float) -> float:
        start = {**parameters, "initialDisplacement": displacement, **UNLIMITED}
        return float(compiled.chain_inverse_run(start, np.array([displacement]))[0][0]) - wanted

    low, high = parameters.displacement_range
    if excess(low) >= 0.0:
        return parameters.replace(initialDisplacement=low)
    if excess(high) <= 0.0:
        return parameters.replace(initialDisplacement=high)
    return parameters.replace(initialDisplacement=float(brentq(excess, low, high)))


def begun_at_rest(
    rest: ParameterSet, starts: Mapping[int, dict], traces: Sequence[Trace], offsets: np.ndarray
) -> ParameterSet:
    """Return a set begun as records begin at zero voltage; at rest where none does.

    A stage that was still moving there by more than noise was driven shortly before: its record does
    not count, unless it is the only one. Of the others those nearest to a new stage at rest do, and of
    their starts the one that suits all of them is taken.

    Parameters
    ----------
    rest : ParameterSet
        The set begun at rest, see `resting`.
    starts : Mapping of int to dict
        How the records begin that begin at zero voltage, by their place among the traces.
    traces : sequence of Trace
    offsets : ndarray, shape (R,)
        The constant of each record, m.
    """
    begun = {i: rest.replace(**_within_range(s, rest.displacement_range)) for i, s in starts.items()}
    if len(begun) == len(traces) == 1:
        return begun[0]
    little = STARTS.still * max(t.noise for t in traces)
    still = np.full(len(traces[0].y), np.clip(0.0, *rest.voltage_range))
    at_rest = compiled.chain_free_run(rest, still)[0]
    apart = {i: compiled.chain_free_run(s, still)[0] - at_rest for i, s in begun.items()}
    distance = {i: np.sqrt(np.mean(a**2)) for i, a in apart.items() if np.std(a) <= little}
    alike = [i for i in distance if distance[i] <= min(distance.values()) + little]

    def error(start: ParameterSet) -> float:
        return sum(_cold_error(start, traces[i], float(offsets[i])) for i in alike)

    return min((begun[i] for i in alike), key=error, default=rest)


def cold_error(model: Model, traces: Sequence[Trace]) -> float:
    """Return the sum of the mean square errors, m^2, of records that begin at rest.

    The model is told their first readings.
    """
    start = ParameterSet(model.values, "begun at rest")
    return sum(_cold_error(start, trace, 0.0) for trace in traces)


def _cold_error(start: ParameterSet, trace: Trace, offset: float) -> float:
    """Return the mean square error, m^2, of a record from a start that is told its first reading."""
    drive = trace.drive
    told = start.replace(initialDisplacement=float(trace.y[0]) - offset)
    reading = compiled.chain_free_run(told, drive.voltage, drive.force, drive.temperature)[1]
    return float(np.mean((reading + offset - trace.y)[trace.judged] ** 2))


def _within_range(start: dict[str, float], displacement: tuple[float, float]) -> dict[str, float]:
    """Return a start with its displacement within a range, m."""
    return {**start, "initialDisplacement": float(np.clip(start["initialDisplacement"], *displacement))}
