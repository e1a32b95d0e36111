"""Mechanical resonance, exact poles and no zeros."""

import math

from it2hys.model.effect import Effect, Memory, Scalar, Start, Surroundings, Values
from it2hys.records.clues import Extent
from it2hys.support.lazy import Lazy

ca = Lazy("casadi")


class Resonance(Effect):
    """The displacement rings about its input, which it reaches at rest."""

    memory = Memory.AIMED
    sampled = True

    def is_on(self, parameters: Values) -> bool:
        """Return whether there is a resonance."""
        return parameters["resonance.frequency"] > 0.0

    def size(self, parameters: Values) -> int:
        """Return the number of states: the last two outputs."""
        return 2

    def rest(self, values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
        """Return the input at rest and the states."""
        return y, [y, y]

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the resonating displacement and the last two."""
        a1, a2 = _coefficients(values)
        y = a1 * state[0] + a2 * state[1] + (1.0 - a1 - a2) * x
        return y, [y, state[0]]

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the displacement that makes it ring so, and the last two outputs."""
        a1, a2 = _coefficients(values)
        return (y - a1 * state[0] - a2 * state[1]) / (1.0 - a1 - a2), [y, state[0]]

    def starts(self, extent: Extent) -> dict[str, Start]:
        """Start at a quarter of the Nyquist frequency; the peak of the spectrum is better."""
        nyquist = 0.5 / extent.sample_time
        return {
            "resonance.frequency": Start(0.25 * nyquist, 1e-3 * nyquist, 0.98 * nyquist),
            "resonance.damping": Start(0.05, 1e-3, 0.95),
        }


def _coefficients(values: Values) -> tuple[Scalar, Scalar]:
    """Return those of the last output and of the one before."""
    angle = 2.0 * math.pi * values["resonance.frequency"] * values["sampleTime"]
    return poles(angle, values["resonance.damping"])


def poles(angle: Scalar, damping: Scalar) -> tuple[Scalar, Scalar]:
    """Return a1 and a2 of y[k] = a1 y[k-1] + a2 y[k-2] + (1 - a1 - a2) x[k].

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
