"""Second resonance: the mount rings with the stage that stands on it."""

import math

import casadi as ca

from it2hys import Memory, OwnEffect, OwnParameter

FREQUENCIES = (80.0, 120.0, 180.0, 270.0, 400.0, 600.0)  # Hz


class SecondResonance(OwnEffect):
    """The base gives way to the stage's inertia: y = x - gain q, where q rings and x'' drives it.

    q'' + 2 D w q' + w^2 q = x''. x jumps or bends where a tick begins; to its end q rings freely.
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
        OwnParameter("straight", "1", 0.0, 1.0, (0.5,), "0: x is held; 1: it runs straight", True),
    )

    def step(self, values, state, x, around):
        """Return the displacement; and q, its speed less that of x, and x."""
        own = {p.name: values[f"{self.name}.{p.name}"] for p in self.parameters}
        w = 2 * math.pi * own["frequency"] * values["sampleTime"]  # speeds and angles are per tick
        decay, angle = own["damping"] * w, ca.sqrt(1 - own["damping"] ** 2) * w
        cos, sin = ca.exp(-decay) * ca.cos(angle), ca.exp(-decay) * ca.sin(angle) / angle
        slope = own["straight"] * (x - state[2])
        jump = x - state[2] - slope
        q, speed = state[0] + jump, state[1] + slope - 2 * decay * jump
        speed, q = (cos - decay * sin) * speed - w**2 * sin * q, (cos + decay * sin) * q + sin * speed
        return x - own["gain"] * q, [q, speed - slope, x]

    def rest(self, values, y):
        """Return input and states at rest."""
        return y, [0, 0, y]


EFFECT = SecondResonance()
