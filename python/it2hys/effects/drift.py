"""Drift with the temperature and with time.

For it speaks a residual that follows the temperature channel, or time, linearly and without memory,
whatever the voltage does; held voltages drift as moving ones do.
"""

import numpy as np

from it2hys.effects import Clues, Extent, Scalar, Signature, Start, Surroundings, Values
from it2hys.effects.statistics import UM, Ground, absorbed, readable

REFERENCE_TEMPERATURE = 293.15

#: What the effect is, in plain words.
MEANING = "the reading moves with temperature or time, whatever the voltage does"
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


def signature(clues: Clues) -> Signature | None:
    """Return whether the residual follows temperature or time, by one coefficient in all records.

    The residual is regressed on each, once the model's own means are taken out; errors are spectral
    and by blocks (HAC) and enlarged where records disagree, the p-value is corrected for the choice
    between the two. The statistic is the share of the residual's power that the better one
    explains.
    """
    seen = readable(clues)
    if seen is None:
        return None
    ground, found = Ground(seen, [absorbed(seen)]), []
    time = ground.test(lambda c: np.arange(len(c.residual)) * clues.extent.sample_time)
    found.append((time, "time", "s"))
    if (
        clues.extent.temperature is not None
        and clues.extent.temperature[0] < clues.extent.temperature[1]
    ):
        found.append((ground.test(lambda c: c.temperature), "the temperature", "K"))
    trial, cause, unit = min(found, key=lambda f: (f[0].p_value, -f[0].share))
    text = (
        f"The residual follows {cause} by {trial.coefficients[0] * UM:.3g} µm/{unit} (standard error "
        f"{trial.errors[0] * UM:.2g}), whatever the voltage does: {100 * trial.share:.0f} % of "
        "its power."
    )
    return Signature(trial.share, min(1.0, len(found) * trial.p_value), text)
