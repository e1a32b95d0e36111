"""Thermal path: what the stack dissipates warms the stage, which expands."""

import casadi as ca

from it2hys import Memory, OwnEffect, OwnParameter

TIMES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0)  # s


class ThermalPath(OwnEffect):
    """A share of the energy U dQ that goes in and out is lost, and its charge Q follows x.

    One heat capacity and one resistance make a lag of the power.
    """

    name = "thermal_path"
    side = "behind"
    description = "what the stack dissipates warms the stage, which expands"
    experiment = "a fast sine of full stroke for several time constants, then a hold as long"
    states = 2
    memory = Memory.LONG
    parameters = (
        OwnParameter("gain", "s/V", -1e-2, 1e-2, (1e-6,), "Expansion per power, which is in V m/s"),
        OwnParameter("time", "s", 0.005, 1000.0, TIMES, "Time constant of the path"),
    )

    def step(self, values, state, x, around):
        """Return the displacement, what it was before, and the power that has passed the path."""
        before, power = state
        part = -ca.expm1(-values["sampleTime"] / values["thermal_path.time"])
        passing = ca.fabs(around.voltage * (x - before)) / values["sampleTime"]
        return x + values["thermal_path.gain"] * power, [x, power + part * (passing - power)]

    def rest(self, values, y):
        """Return input and states at rest: nothing is dissipated."""
        return y, [y, 0.0]


EFFECT = ThermalPath()
