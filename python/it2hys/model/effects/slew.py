"""Slew limit of the amplifier."""

from it2hys.model.effect import Effect, Memory, Scalar, Start, Surroundings, Values
from it2hys.records.clues import Extent
from it2hys.support.lazy import Lazy

ca = Lazy("casadi")


class Slew(Effect):
    """Largest rate at which the amplifier's voltage can change."""

    memory = Memory.SHORT
    #: The last output.
    states = 1
    limits = True
    words = "slew limit"
    sampled = True

    def is_on(self, parameters: Values) -> bool:
        """Return whether there is a limit."""
        return parameters["slew.rate"] > 0.0

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the voltage as far as it may change, and the state."""
        most = values["slew.rate"] * values["sampleTime"]
        y = ca.fmin(ca.fmax(x, state[0] - most), state[0] + most)
        return y, [y]

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the nearest voltage that passes, which is what passes."""
        return self.step(values, state, y, around)

    def starts(self, extent: Extent) -> dict[str, Start]:
        """Start at the span in ten milliseconds; a tick for the span is no limit at all."""
        fastest = extent.voltage_span / extent.sample_time
        start = min(extent.voltage_span / 1e-2, 0.5 * fastest)
        return {"slew.rate": Start(start, 1e-6 * fastest, fastest)}


EFFECT = Slew()
