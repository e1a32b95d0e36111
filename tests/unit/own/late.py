"""A part of the voltage comes two ticks late, which no inverse makes up for; some of it never comes."""

from it2hys import OwnEffect, OwnParameter


class Late(OwnEffect):
    """A share of the voltage is that of two ticks before."""

    name = "late"
    side = "before"
    description = "a part that is late"
    states = 2
    parameters = (OwnParameter("share", low=-0.5, high=1.0, guesses=(0.4,), description="Share"),)
    inverse = None

    def step(self, values, state, x, around):
        """Return the voltage, and the last two."""
        share = values["late.share"]
        return (1 - share) * x + 0.9 * share * state[1], [x, state[0]]

    def latency(self, values):
        """Return by how much the most of it is late."""
        return 2 * values["late.share"] * values["sampleTime"]


EFFECT = Late()
