"""Friction in the guide: two elements of Maxwell slip, each a spring behind a slider."""

import casadi as ca

from it2hys import OwnEffect, OwnParameter


class Friction(OwnEffect):
    """Springs that slip carry a share of the displacement."""

    name = "friction"
    side = "behind"
    description = "friction in the guide"
    experiment = "small loops about several displacements"
    states = 3
    parameters = (
        OwnParameter("stiffness", low=0.0, high=0.4, guesses=(0.1,), description="Share of springs"),
        OwnParameter("slip", unit="m", low=1e-8, high=1e-5, guesses=(1e-7, 1e-6), description="Slip"),
    )

    def step(self, values, state, x, around):
        """Return the displacement, and where the springs and the stage are."""
        stiffness, slip = values["friction.stiffness"], values["friction.slip"]
        springs = [
            ca.fmin(ca.fmax(state[i] + x - state[2], -share * slip), share * slip)
            for i, share in enumerate((1.0, 3.0))
        ]
        return x - stiffness * (0.6 * springs[0] + 0.4 * springs[1]), [*springs, x]

    def rest(self, values, y):
        """Return input and states: the springs are free."""
        return y, [0.0, 0.0, y]


EFFECT = Friction()
