"""Drift with the temperature and with time."""

from it2hys.model.effect import Effect, Scalar, Start, Surroundings, Values
from it2hys.records.clues import Extent

REFERENCE_TEMPERATURE = 293.15


class Drift(Effect):
    """Drift of the displacement with temperature and with time."""

    def is_on(self, parameters: Values) -> bool:
        """Return whether there is a drift."""
        return parameters["drift.temperatureCoefficient"] != 0.0 or parameters["drift.rate"] != 0.0

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the displacement with drift."""
        return x + _offset(values, around), []

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the displacement without drift."""
        return y - _offset(values, around), []

    def starts(self, extent: Extent) -> dict[str, Start]:
        """Start at none; bounds let a drift be as large as the travel."""
        travel = extent.displacement_span
        result = {"drift.rate": Start(0.0, -travel / extent.duration, travel / extent.duration)}
        if extent.temperature is not None and extent.temperature[0] < extent.temperature[1]:
            most = travel / (extent.temperature[1] - extent.temperature[0])
            result["drift.temperatureCoefficient"] = Start(0.0, -most, most)
        return result


def _offset(values: Values, around: Surroundings) -> Scalar:
    above = around.temperature - REFERENCE_TEMPERATURE
    return values["drift.temperatureCoefficient"] * above + values["drift.rate"] * around.time


EFFECT = Drift()
