"""Amplifier whose gain falls towards its ends, without memory."""

import casadi as ca

from it2hys import OwnEffect, OwnParameter


class Bend(OwnEffect):
    """A soft curve of the voltage."""

    name = "bend"
    side = "before"
    description = "an amplifier that bends"
    parameters = (
        OwnParameter("share", low=0.0, high=0.8, guesses=(0.2,), description="Share that bends"),
        OwnParameter("scale", unit="V", low=20.0, high=200.0, guesses=(80.0,), description="Voltage"),
    )

    def step(self, values, state, x, around):
        """Return the voltage."""
        share, scale = values["bend.share"], values["bend.scale"]
        return (1 - share) * x + share * scale * ca.tanh(x / scale), []


EFFECT = Bend()
