"""Thermal path: what moves warms the stage, as does what is lost on the way; so does the room."""

import casadi as ca

from it2hys import Memory, OwnEffect, OwnParameter


class Heat(OwnEffect):
    """A first-order path from speed and power to a share of the displacement."""

    name = "heat"
    side = "behind"
    description = "a stage that its own losses warm"
    experiment = "a fast sine that is switched on and off"
    channel = "temperature_degC"
    memory = Memory.LONG
    states = 2
    parameters = (
        OwnParameter("gain", low=-0.05, high=0.05, guesses=(0.01,), description="Share at full speed"),
        OwnParameter("time", unit="s", low=1e-3, high=10.0, guesses=(0.1,), description="Time"),
        OwnParameter("room", unit="1/K", low=-0.01, high=0.01, guesses=(1e-3,), description="Share"),
    )

    def step(self, values, state, x, around):
        """Return the displacement, and warmth and displacement of the tick."""
        zero = values["displacementZero"]
        speed = (x - state[1]) / 1e-6
        part = values["sampleTime"] / values["heat.time"]
        warm = state[0] + part * (speed * speed - state[0])
        loss = 0.5 * (speed * around.voltage / 60.0) ** 2  # it warms the next tick
        swing = 1.0 + values["heat.room"] * (around.temperature - 293.15)
        y = zero + (x - zero) * swing + values["heat.gain"] * 1e-6 * ca.tanh(warm)
        return y, [warm + part * loss, x]


EFFECT = Heat()
