"""Mechanics of the stack: one vibration mode, stiffness against a force, thermal expansion."""

import math
from dataclasses import dataclass

from it2hys.stand.checks import require, require_finite, require_positive
from it2hys.stand.linear import ModeBank


@dataclass(frozen=True)
class Mechanics:
    """Mass, spring and damper between the free displacement of the ceramic and the tip.

    ``y'' + 2 zeta w y' + w^2 y = w^2 (free - force / stiffness)``. The paper does not state
    these values; the stiffness is typical of a stack of 7 x 7 x 20 mm, and the frequency is that
    of a loaded stage.

    Parameters
    ----------
    frequency : float
        Undamped natural frequency, Hz.
    damping : float
        Damping ratio zeta, 0 < zeta < 1.
    stiffness : float
        Static stiffness, N/m; ``inf`` if the force shall have no effect.

    Raises
    ------
    InputError
        If a value is out of its domain.
    """

    frequency: float = 2.5e3
    damping: float = 0.05
    stiffness: float = 60e6

    def __post_init__(self):
        """Refuse values out of their domain."""
        require_finite(self, "frequency")
        require_positive(self, "frequency", "stiffness")
        require(self, 0.0 < self.damping < 1.0, "damping must lie between 0 and 1")

    def start(self, step):
        """Give the running mode at rest (a bank to `advance`); `step` is the fine step, s."""
        omega = 2.0 * math.pi * self.frequency
        ringing = omega * math.sqrt(1.0 - self.damping**2)
        pole = complex(-self.damping * omega, ringing)
        # Residue of the transfer function at the pole, doubled for its conjugate, at rate zero.
        gain = -(omega**2) / (1j * ringing * pole)
        return ModeBank([pole], [gain], 0.0, step)


@dataclass(frozen=True)
class ThermalExpansion:
    """Displacement proportional to the temperature's distance from a reference.

    Parameters
    ----------
    coefficient : float
        Displacement over temperature, m/K.
    reference : float
        Temperature without displacement, K.

    Raises
    ------
    InputError
        If a value is not finite.
    """

    coefficient: float = 0.15e-6
    reference: float = 293.15

    def __post_init__(self):
        """Refuse values out of their domain."""
        require_finite(self, "coefficient", "reference")

    def displacement(self, temperature):
        """Give the displacement, m, at a temperature, K (float or array)."""
        return self.coefficient * (temperature - self.reference)
