"""The strain gauge with its conditioner, and the line hum that its reading may pick up."""

import math
from dataclasses import dataclass

import numpy as np

from it2hys.stand.checks import require_finite, require_positive
from it2hys.stand.linear import ModeBank


@dataclass(frozen=True)
class Gauge:
    """Strain gauge conditioner: 0 to 10 V, slightly bent, first-order bandwidth.

    The output range and the nonlinearity are the paper's. Its zero lies above 0 V, so that
    neither noise nor an undershoot runs into the end of the range. Zero is adjusted on the rig:
    no displacement reads as no displacement.

    Parameters
    ----------
    span : float
        Displacement over the whole output range, m.
    zero : float
        Output without displacement, V.
    nonlinearity : float
        Greatest deviation of the curve from the line through its ends, as a fraction of the
        range (a parabola).
    bandwidth : float
        -3 dB frequency, Hz; ``inf`` for none.

    Raises
    ------
    InputError
        If a value is out of its domain.
    """

    span: float = 20e-6
    zero: float = 1.0
    nonlinearity: float = 1e-3
    bandwidth: float = 5e3

    output_range = 10.0  # V

    def __post_init__(self):
        """Refuse values out of their domain."""
        require_finite(self, "span", "zero", "nonlinearity")
        require_positive(self, "span", "bandwidth")

    @property
    def sensitivity(self):
        """Nominal sensitivity, V/m."""
        return self.output_range / self.span

    def start(self, step):
        """Give the running filter at rest, or None without one; `step` is the fine step, s."""
        if math.isinf(self.bandwidth):
            return None
        return ModeBank([-2.0 * math.pi * self.bandwidth], [1.0], 0.0, step)

    def volts(self, displacement):
        """Give the output, V, for a filtered displacement, m (array)."""
        nominal = self.zero + self.sensitivity * displacement
        return nominal + self._bow(nominal) - self._bow(self.zero)

    def reading(self, volts):
        """Give the displacement, m, that the computer takes an output, V (array), for."""
        return (volts - self.zero) / self.sensitivity

    def _bow(self, volts):
        place = volts / self.output_range
        return self.nonlinearity * self.output_range * 4.0 * place * (1.0 - place)


@dataclass(frozen=True)
class Hum:
    """Mains hum in the reading.

    Parameters
    ----------
    amplitude : float
        Peak value, m of reading.
    frequency : float
        Line frequency, Hz.
    phase : float
        Phase at time 0, rad.

    Raises
    ------
    InputError
        If a value is not finite or the amplitude is negative.
    """

    amplitude: float = 20e-9
    frequency: float = 50.0
    phase: float = 0.0

    def __post_init__(self):
        """Refuse values out of their domain."""
        require_finite(self, "amplitude", "frequency", minimum=0.0)
        require_finite(self, "phase")

    def reading(self, time):
        """Give the hum, m, at times in s (array)."""
        return self.amplitude * np.sin(2.0 * np.pi * self.frequency * time + self.phase)
