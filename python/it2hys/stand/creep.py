"""Creep of the ceramic: displacement goes on with the logarithm of time after a step.

References
----------
H. Jung and D.-G. Gweon, Creep characteristics of piezoelectric actuators, Review of Scientific
Instruments 71 (2000) 1896-1900 (1 to 2 % per decade). K. Kuhnen, Modeling, identification and
compensation of complex hysteretic and log(t)-type creep nonlinearities, Control and Intelligent
Systems 33 (2005) 134-147 (log-spaced relaxations).
"""

import math
from dataclasses import dataclass

import numpy as np

from it2hys.stand.checks import require, require_finite, require_positive
from it2hys.stand.linear import ModeBank


@dataclass(frozen=True)
class Creep:
    """Many relaxations of equal weight whose time constants are spaced evenly in log time.

    Added to a displacement that steps at time 0, they make it grow by `per_decade` of the step
    in each decade of time between the shortest and the longest time constant.

    Parameters
    ----------
    per_decade : float
        Growth per decade of time, as a fraction of the step.
    shortest, longest : float
        Range of time constants, s.
    terms_per_decade : int
        Density of the time constants; at 3 the ripple about the straight line is negligible.

    Raises
    ------
    InputError
        If a value is out of its domain.
    """

    per_decade: float = 0.015
    shortest: float = 1e-3
    longest: float = 3e3
    terms_per_decade: int = 3

    def __post_init__(self):
        """Refuse values out of their domain."""
        require_finite(self, "per_decade", minimum=0.0)
        require_finite(self, "shortest", "longest")
        require_positive(self, "shortest", "terms_per_decade")
        require(self, self.shortest < self.longest, "shortest must lie below longest")

    def start(self, step):
        """Give the running creep at rest (a bank to `advance`); `step` is the fine step, s."""
        decades = math.log10(self.longest / self.shortest)
        intervals = max(1, round(decades * self.terms_per_decade))
        time_constants = np.geomspace(self.shortest, self.longest, intervals + 1)
        gains = np.full(time_constants.size, self.per_decade * decades / intervals)
        return ModeBank(-1.0 / time_constants, gains, 1.0, step)
