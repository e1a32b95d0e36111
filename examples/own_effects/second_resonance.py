"""Second resonance: the mount rings with the stage that stands on it."""

import math

import casadi as ca

from it2hys import Memory, OwnEffect, OwnParameter

FREQUENCIES = (80.0, 120.0, 180.0, 270.0, 400.0, 600.0)  # Hz


class SecondResonance(OwnEffect):
    """The base gives way to the stage's inertia: y = x - gain (x - r), where r rings about x.

    r is the base's answer, through its spring and damper, to what is held for a tick.
    """

    name = "second_resonance"
    side = "behind"
    description = "the mount rings with the stage that stands on it"
    experiment = "a chirp through the mount's resonance, and steps with long holds"
    states = 3
    memory = Memory.AIMED  # the last ticks are all that it remembers
    sampled = True  # how the voltage is held shifts ringing by a part of a sample
    parameters = (
        OwnParameter("gain", "1", -0.8, 0.8, (0.1,), "Moved mass over the base's"),
        OwnParameter("frequency", "Hz", 10.0, 2000.0, FREQUENCIES, "Natural frequency of the mount"),
        OwnParameter("damping", "1", 1e-3, 0.5, (0.03,), "Damping of the mount"),
    )

    def step(self, values, state, x, around):
        """Return the displacement, the last two of what rings, and what it rings about."""
        own = {p.name: values[f"{self.name}.{p.name}"] for p in self.parameters}
        decay = 2 * math.pi * own["frequency"] * own["damping"] * values["sampleTime"]
        angle = decay * ca.sqrt(own["damping"] ** -2 - 1)
        a1, a2 = 2 * ca.exp(-decay) * ca.cos(angle), -ca.exp(-2 * decay)
        b1 = 1 - ca.exp(-decay) * (ca.cos(angle) - decay / angle * ca.sin(angle))
        r = a1 * state[0] + a2 * state[1] + b1 * x + (1 - a1 - a2 - b1) * state[2]
        return x - own["gain"] * (x - r), [r, state[0], x]

    def rest(self, values, y):
        """Return input and states at rest."""
        return y, [y, y, y]


EFFECT = SecondResonance()
