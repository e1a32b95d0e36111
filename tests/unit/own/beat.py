"""A line on the reading whose amplitude grows with the displacement."""

import math

import casadi as ca

from it2hys import OwnEffect, OwnParameter


class Beat(OwnEffect):
    """A sine of time, in proportion to the displacement."""

    name = "beat"
    side = "reading"
    description = "a line that grows with the displacement"
    parameters = (
        OwnParameter("share", low=-0.01, high=0.01, guesses=(1e-3,), description="Amplitude"),
        OwnParameter("frequency", unit="Hz", low=1.0, high=1000.0, guesses=(60.0,), description="Line"),
    )

    def step(self, values, state, x, around):
        """Return the reading."""
        angle = 2 * math.pi * values["beat.frequency"] * around.time
        return x * (1 + values["beat.share"] * ca.sin(angle)), []


EFFECT = Beat()
