"""Friction in the guide: elements between stack and stage that stick, and slip beyond a distance."""

import casadi as ca

from it2hys import Memory, OwnEffect, OwnParameter

ELEMENTS = (1, 2, 3, 4)
GUESSES = {1: (0.05e-6, 0.15e-6), 2: (0.4e-6,), 3: (1e-6,), 4: (2e-6,)}


class Friction(OwnEffect):
    """Maxwell slip: each element holds the stage back by a share of how far it is stretched."""

    name = "friction"
    side = "behind"
    description = "friction in the guide holds the stage back where it turns"
    experiment = "slow triangles of several amplitudes, and small ones about several places"
    states = len(ELEMENTS)
    memory = Memory.LONG
    parameters = tuple(
        p
        for i in ELEMENTS
        for p in (
            OwnParameter(f"share{i}", "1", 1e-4, 0.6, (0.03,), f"Stiffness {i} over the stack's"),
            OwnParameter(f"slip{i}", "m", 1e-8, 2e-5, GUESSES[i], f"Distance at which {i} slips"),
        )
    )

    def step(self, values, state, x, around):
        """Return the displacement, and where the elements are held."""
        y, held = x, []
        for i, place in zip(ELEMENTS, state, strict=True):
            slip = values[f"friction.slip{i}"]
            stretch = ca.fmax(-slip, ca.fmin(slip, x - place))
            y -= values[f"friction.share{i}"] * stretch
            held.append(x - stretch)
        return y, held

    def rest(self, values, y):
        """Return input and states at rest: nothing is stretched."""
        return y, [y] * len(ELEMENTS)


EFFECT = Friction()
