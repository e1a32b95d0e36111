"""First-order lag of the amplifier, exact pole and no zero."""

from it2hys.model.effect import Effect, Memory, Scalar, Start, Surroundings, Values
from it2hys.records.clues import Extent
from it2hys.support.lazy import Lazy

ca = Lazy("casadi")


class Lag(Effect):
    """First-order lag of the amplifier: a low-pass filter of the voltage."""

    memory = Memory.AIMED
    #: The last output.
    states = 1
    sampled = True

    def is_on(self, parameters: Values) -> bool:
        """Return whether there is a lag."""
        return parameters["lag.timeConstant"] > 0.0

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the lagging voltage and the state."""
        y = state[0] + _part(values) * (x - state[0])
        return y, [y]

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the voltage that goes ahead, and the state."""
        return state[0] + (y - state[0]) / _part(values), [y]

    def starts(self, extent: Extent) -> dict[str, Start]:
        """Start at two ticks; slower than a tenth of the record is creep or drift."""
        slowest = max(0.1 * extent.duration, 10.0 * extent.sample_time)
        ts = extent.sample_time
        return {"lag.timeConstant": Start(2.0 * ts, 0.05 * ts, slowest)}


def _part(values: Values) -> Scalar:
    """Return the part of the way that is gone in a tick."""
    return -ca.expm1(-values["sampleTime"] / values["lag.timeConstant"])


EFFECT = Lag()
