"""Mechanical resonance, exact poles, at most one zero, and a delay of up to two ticks.

A resonance whose input runs straight between samples has, sampled, the zero -0.27 (of a double
integrator: -2 + sqrt(3)) and another one, which a delay of 0.79 ticks makes up for. For one whose input
is held, half a tick of delay makes up for all, and one more where a tick's reading is taken before its
voltage acts. Which is true of a record is not known: it is fitted. That delay is behind the core: what
drives the core, which is not linear, comes on time.
"""

import math

from it2hys.model.effect import Effect, Memory, Scalar, Start, Surroundings, Values
from it2hys.records.clues import Extent
from it2hys.support.lazy import Lazy

ca = Lazy("casadi")

#: Sampling zero of a double integrator whose input runs straight between samples.
STRAIGHT = -2.0 + math.sqrt(3.0)
#: A fit goes no lower: there is no reason to, and the inverse decays by this factor a tick.
LOWEST_ZERO = -0.4
#: Ticks of delay that the states can give, and those that a fit begins with: of an input that is held.
MAX_TICKS, HELD = 2, 0.5


class Resonance(Effect):
    """Mechanical resonance: the displacement rings about its input after a fast change."""

    memory = Memory.AIMED
    #: The last two outputs and the last input.
    states = 3
    sampled = True
    sampling_delay = "resonance.samplingDelay"

    def is_on(self, parameters: Values) -> bool:
        """Return whether there is a resonance."""
        return parameters["resonance.frequency"] > 0.0

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the resonating displacement, and the next states."""
        a1, a2, b0, b1 = _coefficients(values)
        y = a1 * state[0] + a2 * state[1] + b0 * x + b1 * state[2]
        ticks = values["resonance.samplingDelay"] / values["sampleTime"]
        first, second = ca.fmin(ticks, 1.0), ca.fmax(ca.fmin(ticks, MAX_TICKS) - 1.0, 0.0)
        later = y + first * (state[0] - y) + second * (state[1] - state[0])
        return later, [y, state[0], x]

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the displacement that makes it ring so, and the next states."""
        a1, a2, b0, b1 = _coefficients(values)
        x = (y - a1 * state[0] - a2 * state[1] - b1 * state[2]) / b0
        return x, [y, state[0], x]

    def latency(self, values: Values) -> Scalar:
        """Return the delay."""
        return values["resonance.samplingDelay"]

    def starts(self, extent: Extent) -> dict[str, Start]:
        """Start at a quarter of the Nyquist frequency; the peak of the spectrum is better."""
        nyquist = 0.5 / extent.sample_time
        return {
            "resonance.frequency": Start(0.25 * nyquist, 1e-3 * nyquist, 0.98 * nyquist),
            "resonance.damping": Start(0.05, 1e-3, 0.95),
            "resonance.samplingZero": Start(STRAIGHT, LOWEST_ZERO, 0.0, of_sampling=True),
            "resonance.samplingDelay": Start(
                HELD * extent.sample_time, 0.0, MAX_TICKS * extent.sample_time, of_sampling=True
            ),
        }


def _coefficients(values: Values) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return those of the last output and of the one before, of the input and of the last one."""
    angle = 2.0 * math.pi * values["resonance.frequency"] * values["sampleTime"]
    a1, a2 = poles(angle, values["resonance.damping"])
    zero = values["resonance.samplingZero"]
    b0 = (1.0 - a1 - a2) / (1.0 - zero)
    return a1, a2, b0, -zero * b0


def poles(angle: Scalar, damping: Scalar) -> tuple[Scalar, Scalar]:
    """Return a1 and a2 of y[k] = a1 y[k-1] + a2 y[k-2] + (1 - a1 - a2) x[k], without the zero.

    Parameters
    ----------
    angle : float, ndarray or casadi.SX
        2 pi times the frequency times the sample time, rad.
    damping : float, ndarray or casadi.SX
        Between 0 and 1.
    """
    radius = ca.exp(-damping * angle)
    return 2.0 * radius * ca.cos(angle * ca.sqrt(1.0 - damping * damping)), -radius * radius


EFFECT = Resonance()
