"""Delay of the voltage, straight between ticks."""

import math

from it2hys.model.effect import Effect, Memory, Scalar, Start, Surroundings, Values
from it2hys.records.clues import Extent

MAX_TICKS = 64
ROUNDING = 1e-9


class Delay(Effect):
    """Dead time of the voltage, which the inverse cannot make up for."""

    memory = Memory.LONGEST
    shift = "delay.time"

    def is_on(self, parameters: Values) -> bool:
        """Return whether there is a delay."""
        return parameters["delay.time"] > 0.0

    def size(self, parameters: Values) -> int:
        """Return the number of voltages kept: the whole ticks and one more."""
        return math.floor(parameters["delay.time"] / parameters["sampleTime"] + ROUNDING) + 1

    def rest(self, values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
        """Return the voltage at rest and the voltages kept; `size` of them are used."""
        return y, [y] * (MAX_TICKS + 1)

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the voltage a delay ago, and the voltages kept. Whole ticks are those of `state`."""
        ticks = len(state) - 1
        newer = state[ticks - 1] if ticks else x
        fraction = values["delay.time"] / values["sampleTime"] - ticks
        return newer + fraction * (state[ticks] - newer), [x, *state[:-1]]

    def latency(self, values: Values) -> Scalar:
        """Return the delay."""
        return values["delay.time"]

    def starts(self, extent: Extent) -> dict[str, Start]:
        """Start at one tick; whole ticks are the structure of the chain, so a fit tries several."""
        return {"delay.time": Start(extent.sample_time, 0.0, MAX_TICKS * extent.sample_time)}


EFFECT = Delay()
