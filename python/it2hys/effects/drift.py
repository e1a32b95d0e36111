"""Drift with the temperature and with time.

For it speaks a residual that follows the temperature channel, or time, linearly and without memory,
whatever the voltage does; held voltages drift as moving ones do.
"""

import numpy as np

from it2hys.effects import Clues, Extent, Scalar, Start, Surroundings, Values

REFERENCE_TEMPERATURE = 293.15

#: What would show the effect apart from others.
EXPERIMENT = "a held voltage for as long as the records last, with the temperature recorded"


def is_on(parameters: Values) -> bool:
    """Return whether there is a drift."""
    return parameters["drift.temperatureCoefficient"] != 0.0 or parameters["drift.rate"] != 0.0


def size(parameters: Values) -> int:
    """Return the number of states: none."""
    return 0


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input at rest, at the reference temperature and time 0."""
    return y, []


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the displacement with drift; time is the tick's own."""
    by_temperature = values["drift.temperatureCoefficient"] * (
        around.temperature - REFERENCE_TEMPERATURE
    )
    return x + (by_temperature + values["drift.rate"] * around.time), []


def starts(extent: Extent) -> dict[str, Start]:
    """Start at none; bounds let a drift be as large as the travel."""
    travel = extent.displacement_span
    result = {"drift.rate": Start(0.0, -travel / extent.duration, travel / extent.duration)}
    if extent.temperature is not None and extent.temperature[0] < extent.temperature[1]:
        most = travel / (extent.temperature[1] - extent.temperature[0])
        result["drift.temperatureCoefficient"] = Start(0.0, -most, most)
    return result


def guesses(clues: Clues) -> list[dict[str, float]]:
    """Return the slopes by which the residual follows time and temperature."""
    names, columns, target = list(starts(clues.extent)), [], []
    for i, c in enumerate(clues.records):
        time = np.arange(len(c.residual)) * clues.extent.sample_time
        rows = {"drift.rate": time, "drift.temperatureCoefficient": c.temperature}
        constants = np.zeros((len(time), len(clues.records)))
        constants[:, i] = 1.0
        columns.append(np.column_stack([*(rows[n] for n in names), constants])[c.used])
        target.append(c.residual[c.used])
    slopes = np.linalg.lstsq(np.vstack(columns), np.concatenate(target))[0]
    return [dict(zip(names, (float(v) for v in slopes), strict=False))]
