"""Every operation that CasADi has for numbers, added up."""

import casadi as ca

from it2hys import OwnEffect, OwnParameter

FUNCTIONS = (
    ca.sin, ca.cos, ca.tan, ca.atan, ca.exp, ca.tanh, ca.sinh, ca.cosh, ca.asinh, ca.floor, ca.ceil,
    ca.fabs, ca.sign, ca.erf, ca.expm1,
)  # fmt: skip


class Every(OwnEffect):
    """A curve of no use."""

    name = "every"
    side = "behind"
    description = "every operation"
    inverse = None
    parameters = (OwnParameter("gain", unit="m", low=-1e-6, high=1e-6, guesses=(1e-7,)),)

    def step(self, values, state, x, around):
        """Return the displacement with all of them."""
        z, gain = x / 3e-5, values["every.gain"]
        many = [f(z) for f in FUNCTIONS]
        many += [ca.log(z * z + 1), ca.log1p(z * z), ca.sqrt(z * z + 1), 1 / (z + 3), -z, 2 * z, z * z]
        many += [ca.asin(z / 9), ca.acos(z / 9), ca.acosh(z * z + 2), ca.atanh(z / 9), ca.atan2(z, 2)]
        many += [ca.hypot(z, 1), ca.fmod(z, 0.3), ca.remainder(z, 0.7), ca.copysign(z, -1)]
        many += [ca.fmin(z, 0.2), ca.fmax(z, 0.2), (z * z + 1) ** 0.3, (z * z + 1) ** (1e6 * gain)]
        many += [ca.if_else(ca.logic_and(z > 0.1, ca.logic_or(z < 0.3, z == 4)), z, 2)]
        many += [ca.if_else(ca.logic_not(z <= 0.2), 1, z != 2)]
        return x + gain * sum(many), []


EFFECT = Every()
