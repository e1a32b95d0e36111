"""The twelfth effect: a displacement that is ahead by a share of its last change."""

from it2hys.model.effect import Effect, Memory, Scalar, Start, Surroundings, Values
from it2hys.records.clues import Extent


class Tilt(Effect):
    """Its state is the last input."""

    memory = Memory.AIMED
    states = 1

    def is_on(self, parameters: Values) -> bool:
        """Return whether there is a tilt."""
        return parameters["tilt.gain"] != 0.0

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the displacement ahead, and its input."""
        return x + values["tilt.gain"] * (x - state[0]), [x]

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the displacement that is not ahead."""
        gain = values["tilt.gain"]
        x = (y + gain * state[0]) / (1.0 + gain)
        return x, [x]

    def starts(self, extent: Extent) -> dict[str, Start]:
        """Start at a little."""
        return {"tilt.gain": Start(0.05, -0.4, 2.0)}


EFFECT = Tilt()
