"""The coordinates in which the parameters of effects are fitted.

Those that are positive and may differ by decades (time constants, rates, frequencies) are fitted by
their logarithm, the others in units of a tenth of what their bounds allow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from it2hys.model.effect import Start
from it2hys.model.stages import EFFECTS, READING

_SHARE = 0.1


def by_record() -> tuple[str, ...]:
    """Return the parameters whose value differs from record to record.

    How it begins, and a line's phase, which nothing in the voltage tells.
    """
    return ("initialDisplacement", *(n for e in EFFECTS.values() for n in e.per_record))


def of_reading() -> tuple[str, ...]:
    """Return those of them that are nothing of the stage, but of how it is recorded."""
    return tuple(n for e in READING.values() for n in e.per_record)


@dataclass(frozen=True)
class Coordinate:
    """How one parameter of an effect is fitted.

    Parameters
    ----------
    name : str
        FMU variable name.
    bounds : tuple of float
        In SI units.
    logarithmic : bool
        Whether the coordinate is the logarithm.
    of_sampling : bool
        Whether it tells how signals were sampled, and nothing of the stage.
    seen : float
        Largest value that the records show, in SI units.
    """

    name: str
    bounds: tuple[float, float]
    logarithmic: bool
    of_sampling: bool = False
    seen: float = math.inf

    @classmethod
    def of(cls, name: str, start: Start) -> Coordinate:
        """Return the coordinate of a parameter with these bounds."""
        return cls(name, (start.low, start.high), start.low > 0.0, start.of_sampling, start.seen)

    @property
    def unit(self) -> float:
        """Change in SI units that is 1 in a linear coordinate."""
        return _SHARE * (self.bounds[1] - self.bounds[0])

    def of_value(self, value: float) -> float:
        """Return the coordinate of a value, moved into the bounds."""
        value = float(np.clip(value, *self.bounds))
        return np.log(value) if self.logarithmic else value / self.unit

    def value(self, coordinate: float) -> float:
        """Return the value in SI units."""
        value = float(np.exp(coordinate) if self.logarithmic else coordinate * self.unit)
        return min(max(value, self.bounds[0]), self.bounds[1])  # NumPy takes ten times as long

    def slope(self, coordinate: float) -> float:
        """Return d value / d coordinate."""
        return self.value(coordinate) if self.logarithmic else self.unit
