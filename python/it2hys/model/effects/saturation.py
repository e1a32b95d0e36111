"""Saturation of the amplifier."""

from it2hys.model.effect import Effect, Scalar, Start, Surroundings, Values
from it2hys.records.clues import Extent
from it2hys.support.lazy import Lazy

ca = Lazy("casadi")


class Saturation(Effect):
    """Lowest and highest voltage of the amplifier; a stage at rest is between them."""

    limits = True

    def is_on(self, parameters: Values) -> bool:
        """Return whether there are limits."""
        return parameters["saturation.minimum"] < parameters["saturation.maximum"]

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the voltage within the limits."""
        return ca.fmin(ca.fmax(x, values["saturation.minimum"]), values["saturation.maximum"]), []

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the nearest voltage that passes, which is what passes."""
        return self.step(values, state, y, around)

    def starts(self, extent: Extent) -> dict[str, Start]:
        """Start a tenth of the range within its ends; limits beyond the range cannot be seen."""
        low, high = extent.voltage
        middle, tenth = 0.5 * (low + high), 0.1 * extent.voltage_span
        return {
            "saturation.minimum": Start(low + tenth, low - tenth, middle),
            "saturation.maximum": Start(high - tenth, middle, high + tenth),
        }

    def nowhere(self, extent: Extent) -> dict[str, float]:
        """Return the limits as far off as they may be."""
        starts = self.starts(extent)
        return {
            "saturation.minimum": starts["saturation.minimum"].low,
            "saturation.maximum": starts["saturation.maximum"].high,
        }


EFFECT = Saturation()
