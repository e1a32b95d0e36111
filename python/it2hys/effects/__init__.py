"""The effects of the chain (`fmu_src/core/chain.h`) as CasADi expressions, one module per effect.

Each module has
    is_on(parameters)            whether a parameter set has the effect
    size(parameters)             number of its states
    rest(values, y)              input and states at rest at the output y
    step(values, state, x, around)   output and next states; the operations are those of the C core
    starts(extent)               start values and bounds for a fit, from the extent of the records
    guesses(clues)               values to start a fit from, from what a model without it leaves over
    MEANING                      what it is, in plain words, as a clause
    EXPERIMENT                   what would show it apart from others
    signature(clues)             what of that looks as this effect alone would make it, and how surely
and says in its docstring what in a record speaks for it. `values` maps FMU variable names to numbers
or CasADi symbols; counts and switches are always numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np

#: A number or an expression.
Scalar = ca.SX | float
Values = Mapping[str, Scalar]


class Surroundings(NamedTuple):
    """What acts on the chain beside the voltage, at one tick."""

    force: Scalar
    temperature: Scalar
    time: Scalar


class Start(NamedTuple):
    """Where a fit of one parameter begins, and its bounds, in SI units."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Extent:
    """What the records of an identification span, in SI units.

    Attributes
    ----------
    sample_time : float
    duration : float
        Of the longest record.
    voltage, displacement : tuple of float
        Lowest and highest value.
    force, temperature : tuple of float or None
        Lowest and highest value; None where no record has the channel.
    zero : float
        What the sensor reads while the stage rests at zero voltage for long.
    """

    sample_time: float
    duration: float
    voltage: tuple[float, float]
    displacement: tuple[float, float]
    force: tuple[float, float] | None = None
    temperature: tuple[float, float] | None = None
    zero: float = 0.0

    @property
    def voltage_span(self) -> float:
        """Highest minus lowest voltage."""
        return self.voltage[1] - self.voltage[0]

    @property
    def displacement_span(self) -> float:
        """Highest minus lowest displacement."""
        return self.displacement[1] - self.displacement[0]


@dataclass(frozen=True, eq=False)
class Clue:
    """What a model leaves over of one record, in SI units; arrays have the shape (N,).

    Attributes
    ----------
    voltage, force, temperature : ndarray
    displacement, residual : ndarray
        Measured, less the record's constant, and what the model left of it (measured minus model).
    used : ndarray of bool
        Samples to be trusted.
    """

    voltage: np.ndarray
    force: np.ndarray
    temperature: np.ndarray
    displacement: np.ndarray
    residual: np.ndarray
    used: np.ndarray


@dataclass(frozen=True, eq=False)
class Clues:
    """What a model leaves over of all records.

    Attributes
    ----------
    extent : Extent
    records : list of Clue
    """

    extent: Extent
    records: list[Clue]

    def spectrum(self, points: int) -> tuple[np.ndarray, np.ndarray]:
        """Return frequencies in Hz and the residual's mean power there, each of shape (points,)."""
        frequency = np.linspace(0.0, 0.5 / self.extent.sample_time, points)
        power = np.zeros(points)
        for clue in self.records:
            window = np.hanning(len(clue.residual))
            residual = np.where(clue.used, clue.residual, 0.0)
            transform = np.fft.rfft((residual - np.mean(residual)) * window)
            own = np.fft.rfftfreq(len(residual), self.extent.sample_time)
            power += np.interp(frequency, own, np.abs(transform) ** 2) / np.sum(window**2)
        return frequency, power / len(self.records)


@dataclass(frozen=True)
class Signature:
    """How much of a residual looks as one effect would make it.

    Attributes
    ----------
    statistic : float
        What `p_value` comes from, see the effect's `signature`; larger speaks for the effect.
    p_value : float
        Probability of such a statistic in noise, coloured or not, corrected for what was tried on the
        way (thresholds, frequencies), not for the number of effects.
    text : str
        What was found, as a sentence with units.
    """

    statistic: float
    p_value: float
    text: str
