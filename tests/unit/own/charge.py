"""Charge amplifier: a part of the voltage leaks away; where it rests is sought by Newton's method."""

import casadi as ca

from it2hys import OwnEffect, OwnParameter


class Charge(OwnEffect):
    """What leaks follows the voltage, the more the higher it is."""

    name = "charge"
    side = "before"
    description = "an amplifier that leaks"
    states = 1
    parameters = (
        OwnParameter("leak", low=-0.3, high=0.3, guesses=(0.05,), description="Share that leaks"),
        OwnParameter("time", unit="s", low=1e-3, high=1.0, guesses=(0.02,), description="Time"),
    )

    def step(self, values, state, x, around):
        """Return the voltage that is left, and what has leaked."""
        part = values["sampleTime"] / values["charge.time"]
        leaked = state[0] + part * (x + 0.1 * x * ca.tanh(x / 100.0) - state[0])
        return x - values["charge.leak"] * leaked, [leaked]


EFFECT = Charge()
