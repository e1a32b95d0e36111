"""The extent of records, and the residuals of a model on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Extent:
    """The ranges that the records of an identification span, in SI units.

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
    """The residual of a model on one record, in SI units; arrays have the shape (N,).

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
    """The residuals of a model on all records."""

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
