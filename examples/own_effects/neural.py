"""Neural stage, a ceiling: how much could any smooth function of the recent voltage explain."""

import casadi as ca
import numpy as np

from it2hys import Memory, OwnEffect, OwnParameter

TICKS = (1.5, 6.0, 24.0)  # time constants of the filters that tell of the recent past
UNITS = (1, 2, 3)
AHEAD = (5e-7, 1e-6, 3e-6)  # m: how far x may be ahead of them
TRAVEL = 1e-5  # m
OUTPUT = 1e-7  # m: an output weight of 1
DECAY = 1e-3  # a weight of 1 costs as two samples that are off by the noise (policy.CORE.stiff)


def guesses():
    """Return small weights, other ones for each unit: equal units would stay equal."""
    rng = np.random.default_rng(0)
    return {f"{kind}{i}": 0.3 * float(rng.uniform(-1, 1)) for i in UNITS for kind in "abcde"}


class Neural(OwnEffect):
    """Units tanh(a u1 + b u2 + c u3 + d level + e), where u is how far x is ahead of its filters.

    What a unit says at rest is taken away, so that the network is a memory, and no static curve.
    """

    name = "neural"
    side = "behind"
    description = "a small neural network of the recent displacement, as a ceiling"
    experiment = "what is to be tracked, and all that is like it"
    states = len(TICKS)
    memory = Memory.LONG
    parameters = (
        *(OwnParameter(f"output{i}", "m", -3e-6, 3e-6, (OUTPUT,), "Of a unit") for i in UNITS),
        *(OwnParameter(n, "1", -10.0, 10.0, (guess,), "Weight") for n, guess in guesses().items()),
    )

    def step(self, values, state, x, around):
        """Return the displacement, and the filters."""
        own = {p.name: values[f"neural.{p.name}"] for p in self.parameters}
        after = [s - np.expm1(-1 / ticks) * (x - s) for s, ticks in zip(state, TICKS, strict=True)]
        ahead = [(x - s) / unit for s, unit in zip(after, AHEAD, strict=True)]
        level = (x - values["displacementZero"]) / TRAVEL - 0.5
        y = x
        for i in UNITS:
            still = own[f"d{i}"] * level + own[f"e{i}"]
            told = sum(own[f"{kind}{i}"] * u for kind, u in zip("abc", ahead, strict=True))
            y += own[f"output{i}"] * (ca.tanh(told + still) - ca.tanh(still))
        return y, after

    def rest(self, values, y):
        """Return input and states at rest."""
        return y, [y] * len(TICKS)

    def roughness(self, values, units):
        """Return a row for each weight: what is not small costs."""
        names = list(units)
        weights = [n for n in names if n.startswith("neural.")]
        rows = np.zeros((len(weights), len(names)))
        for row, name in zip(rows, weights, strict=True):
            row[names.index(name)] = DECAY * units[name] / (OUTPUT if "output" in name else 1.0)
        return rows


EFFECT = Neural()
