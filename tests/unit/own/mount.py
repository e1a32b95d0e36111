"""Second resonance: the mount rings with the stage."""

import math

import casadi as ca

from it2hys import OwnEffect, OwnParameter


class Mount(OwnEffect):
    """A share of the displacement rings."""

    name = "mount"
    side = "behind"
    description = "a second resonance, of the mount"
    experiment = "a chirp up to twice the resonance"
    states = 2
    parameters = (
        OwnParameter("gain", unit="1", low=-0.5, high=0.5, guesses=(0.05,), description="Share"),
        OwnParameter("frequency", unit="Hz", low=50.0, high=2000.0, guesses=(100.0, 300.0)),
        OwnParameter("damping", unit="1", low=0.01, high=0.7, guesses=(0.05,), description="Damping"),
    )

    def step(self, values, state, x, around):
        """Return the displacement, and the last two of what rings."""
        angle = 2 * math.pi * values["mount.frequency"] * values["sampleTime"]
        radius = ca.exp(-values["mount.damping"] * angle)
        a1 = 2 * radius * ca.cos(angle * ca.sqrt(1 - values["mount.damping"] ** 2))
        a2 = -radius * radius
        u = a1 * state[0] + a2 * state[1] + (1 - a1 - a2) * x
        return x + values["mount.gain"] * (u - x), [u, state[0]]


EFFECT = Mount()
