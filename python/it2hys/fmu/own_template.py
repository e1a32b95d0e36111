"""The file that `it2hys effect new` writes: an effect that works as it stands."""

_TEMPLATE = '''\
"""{title}: say in one line what it is.

This file is code, and is run by `it2hys ... --effect`. `it2hys effect check` tells whether it can be a
stage of the chain

    voltage -> [delay] -> [slew] -> [saturation] -> [lag] -> [play] -> [before] -> core
            -> [load] -> [creep] -> [resonance] -> [drift] -> [nonlinearity] -> [behind] -> displacement
            -> [hum] -> [reading] -> measured
"""

import casadi as ca

from it2hys import OwnEffect, OwnParameter


class {type}(OwnEffect):
    """A share of what comes in follows slowly, by a first-order lag."""

    name = "{name}"
    # "before" the core x is a voltage in V, "behind" it and in the "reading" a displacement in m
    side = "behind"
    description = "a part that follows slowly"
    experiment = "a step that is held for several time constants"
    # "force_N" or "temperature_degC", where records must have that column
    channel = None
    # numbers that it remembers from tick to tick
    states = 1
    # The first one switches the effect: 0 is off. Units are SI; a fit begins at each of the guesses and
    # stays within the bounds. Where both bounds are positive, it fits the logarithm.
    parameters = (
        OwnParameter("share", unit="1", low=-0.5, high=0.5, guesses=(0.05,), description="Share"),
        OwnParameter("time", unit="s", low=1e-4, high=10.0, guesses=(1e-3, 0.1), description="Time"),
    )
    # Up to two states are taken for a short memory. Where it lasts long, as in friction or heat, write
    # `from it2hys import Memory` above and here:
    # memory = Memory.LONG

    def step(self, values, state, x, around):
        """Return the output of a tick, and the next states.

        `values` has the parameters as "{name}.share", "sampleTime" (s) and "displacementZero" (m),
        `around` has force (N), temperature (K) and time (s) of the tick; behind the core also voltage
        (V), that at the actuator, for the next states of a long memory. All of these are CasADi
        expressions: use ca.exp, ca.tanh, ca.if_else(condition, a, b) and the like.
        """
        part = 1 - ca.exp(-values["sampleTime"] / values["{name}.time"])
        slow = state[0] + part * (x - state[0])
        return x + values["{name}.share"] * (slow - x), [slow]

    # Optional. Without it, the input is solved for where `step` is affine in x, and sought otherwise.
    # It returns the input, and the next states (with Memory.LONG: the states that it got). With
    # `inverse = None` the effect has no part in the inverse.
    #
    # def inverse(self, values, state, y, around):
    #     ...

    # Optional. Without it, all states are 0 at rest if `step` holds them there, and sought otherwise.
    # It returns the input and the states that hold the output y.
    #
    # def rest(self, values, y):
    #     return y, [y]


EFFECT = {type}()
'''


def template(name: str) -> str:
    """Return the file of an effect of that name."""
    words = name.split("_")
    return _TEMPLATE.format(
        name=name, type="".join(w.title() for w in words), title=" ".join(words).capitalize()
    )
