"""A line on the reading that is not in the voltage."""

import math
from collections.abc import Callable, Mapping

import numpy as np

from it2hys.model.effect import Effect, Scalar, Start, Surroundings, Values
from it2hys.policy import PHYSICS
from it2hys.records.clues import Clues, Extent
from it2hys.support.lazy import Lazy

ca = Lazy("casadi")


class Hum(Effect):
    """A sine on the reading, such as the mains', which has no part in the inverse."""

    per_record = ("hum.phase",)

    def is_on(self, parameters: Values) -> bool:
        """Return whether there is a hum."""
        return parameters["hum.amplitude"] > 0.0

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the reading with the line."""
        angle = 2.0 * math.pi * values["hum.frequency"] * around.time + values["hum.phase"]
        return x + values["hum.amplitude"] * ca.sin(angle), []

    def starts(self, extent: Extent) -> dict[str, Start]:
        """Start at the mains' frequency; the line of the residual's spectrum is better."""
        nyquist, travel = 0.5 / extent.sample_time, extent.displacement_span
        return {
            "hum.amplitude": Start(0.001 * travel, 0.0, 0.1 * travel),
            "hum.frequency": Start(
                min(50.0, 0.5 * nyquist), PHYSICS.line_periods / extent.duration, nyquist
            ),
            # an angle has no end; a fit must be able to go round
            "hum.phase": Start(0.0, -100.0, 100.0),
        }

    def told_after(self, values: Values) -> float:
        """Return the period of the line: a part of one looks like a slow error of the model."""
        return 1.0 / values["hum.frequency"]

    def found_in_records(
        self, values: Mapping, clues: Callable[[Mapping], Clues]
    ) -> dict[str, np.ndarray]:
        """Return the line's phase in what is left over without it."""
        left = clues({**values, "hum.amplitude": 0.0})
        return {"hum.phase": np.angle(lines_in(left, values["hum.frequency"]))}


def lines_in(clues: Clues, frequency: float) -> np.ndarray:
    """Return the complex amplitudes of a line in the residuals, by least squares."""
    amplitudes = []
    for c in clues.records:
        angle = 2.0 * math.pi * frequency * np.arange(len(c.residual)) * clues.extent.sample_time
        columns = np.column_stack([np.sin(angle), np.cos(angle), np.ones(len(angle))])[c.used]
        sine, cosine, _ = np.linalg.lstsq(columns, c.residual[c.used])[0]
        amplitudes.append(complex(sine, cosine))
    return np.array(amplitudes)


EFFECT = Hum()
