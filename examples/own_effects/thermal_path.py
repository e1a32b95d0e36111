"""Thermal path: what the stack dissipates warms the stage, which expands."""

import casadi as ca

from it2hys import Memory, OwnEffect, OwnParameter

UNIT = 1e-5  # m: strokes are counted in it
TIMES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0)  # s


class ThermalPath(OwnEffect):
    """A dielectric dissipates a share of the energy that goes in and out, f C U^2 tan(delta) in all.

    Its charge follows the displacement, its energy the square of that. One heat capacity and one
    resistance make a lag of the power.
    """

    name = "thermal_path"
    side = "behind"
    description = "what the stack dissipates warms the stage, which expands"
    experiment = "a fast sine of full stroke for several time constants, then a hold as long"
    states = 2
    memory = Memory.LONG
    parameters = (
        OwnParameter("gain", "m.s", -1e-6, 1e-6, (1e-9,), "Expansion per stroke rate"),
        OwnParameter("time", "s", 0.005, 1000.0, TIMES, "Time constant of the path"),
    )

    def step(self, values, state, x, around):
        """Return the displacement, its last energy and the power that has passed the path."""
        energy, power = ((x - values["displacementZero"]) / UNIT) ** 2, state[1]
        part = -ca.expm1(-values["sampleTime"] / values["thermal_path.time"])
        dissipated = ca.fabs(energy - state[0]) / values["sampleTime"]
        return x + values["thermal_path.gain"] * power, [energy, power + part * (dissipated - power)]

    def rest(self, values, y):
        """Return input and states at rest: nothing is dissipated."""
        return y, [((y - values["displacementZero"]) / UNIT) ** 2, 0.0]


EFFECT = ThermalPath()
