"""An effect with an inverse, a rest and a latency of its own."""

from it2hys import OwnEffect, OwnParameter


class Gain(OwnEffect):
    """The displacement follows a part of its way."""

    name = "gain"
    side = "behind"
    description = "a reading that follows"
    states = 1
    parameters = (
        OwnParameter("part", low=-0.5, high=0.5, guesses=(0.1,), description="Part of the last one"),
    )

    def step(self, values, state, x, around):
        """Return the displacement, twice."""
        y = x + values["gain.part"] * (state[0] - x)
        return y, [y]

    def inverse(self, values, state, y, around):
        """Return the displacement before, and the next state."""
        part = values["gain.part"]
        return (y - part * state[0]) / (1 - part), [y]

    def rest(self, values, y):
        """Return input and state."""
        return y, [y]

    def latency(self, values):
        """Return what is lost of time."""
        return 0.1 * values["sampleTime"]


EFFECT = Gain()
