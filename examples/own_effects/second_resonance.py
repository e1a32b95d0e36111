"""Second resonance: the mount rings with the stage that stands on it."""

import math

import casadi as ca

from it2hys import OwnEffect, OwnParameter


class SecondResonance(OwnEffect):
    """The base gives way to the stage's inertia: y = x + gain (r - x), where r rings about x."""

    name = "second_resonance"
    side = "behind"
    description = "the mount rings with the stage that stands on it"
    experiment = "a chirp through the mount's resonance, and steps with long holds"
    states = 2
    sampled = True  # how the voltage is held shifts ringing by a part of a sample
    parameters = (
        OwnParameter("gain", low=-0.8, high=0.8, guesses=(0.1,), description="Moved mass over the base's"),
        OwnParameter(
            "frequency",
            unit="Hz",
            low=10.0,
            high=2000.0,
            guesses=(80.0, 120.0, 180.0, 270.0, 400.0, 600.0),
            description="Natural frequency of the mount",
        ),
        OwnParameter("damping", low=1e-3, high=0.5, guesses=(0.03,), description="Damping of the mount"),
    )

    def step(self, values, state, x, around):
        """Return the displacement, and the last two of what rings."""
        angle = 2 * math.pi * values["second_resonance.frequency"] * values["sampleTime"]
        damping = values["second_resonance.damping"]
        radius = ca.exp(-damping * angle)
        a1, a2 = 2 * radius * ca.cos(angle * ca.sqrt(1 - damping**2)), -(radius**2)
        r = a1 * state[0] + a2 * state[1] + (1 - a1 - a2) * x
        return x + values["second_resonance.gain"] * (r - x), [r, state[0]]

    def rest(self, values, y):
        """Return input and states at rest."""
        return y, [y, y]


EFFECT = SecondResonance()
