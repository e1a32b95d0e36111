"""The record: a uniformly sampled measurement in SI units."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from it2hys.errors import InputError
from it2hys.records.units import UNITS

#: Quantities whose sign a reversed sensor inverts, and the note on a record whose sign was inverted.
SIGNED = ("displacement", "reference")
INVERTED = (
    "The displacement was inverted: it has the opposite sign of what was measured, and so have the "
    "references that the inverse takes."
)


@dataclass(frozen=True, eq=False)
class Record:
    """A uniformly sampled measurement in SI units.

    Attributes
    ----------
    name : str
        Name by which reports call the record.
    time : numpy.ndarray, shape (n,)
        Time stamps, s; may start anywhere.
    voltage : numpy.ndarray, shape (n,)
        Drive voltage, V.
    displacement : numpy.ndarray, shape (n,)
        Measured displacement, m.
    sample_time : float
        Sample time Ts, s.
    force, temperature, reference : numpy.ndarray, shape (n,), or None
        Compressive load, N; temperature, K; desired displacement, m.
    path : pathlib.Path or None
        File that the record was read from.
    notes : tuple of str
        Findings that do not forbid the use of the record, as sentences.
    outliers : numpy.ndarray of bool, shape (n,)
        True where the displacement is not to be trusted: a spike, a clipped or stuck reading, a
        sample filled in by resampling. A fit gives these samples the weight zero.
    inverted : bool
        Whether the sign of `displacement` and `reference` is not the one that was measured.
    unused : tuple of str
        Columns of the file that hold none of the signals.

    Raises
    ------
    InputError
        Where the signals are not one-dimensional and of one length, or the sample time is not
        positive and finite.
    """

    name: str
    time: np.ndarray
    voltage: np.ndarray
    displacement: np.ndarray
    sample_time: float
    force: np.ndarray | None = None
    temperature: np.ndarray | None = None
    reference: np.ndarray | None = None
    path: Path | None = None
    notes: tuple[str, ...] = ()
    # None stands for no outlier; always an array once constructed
    outliers: np.ndarray = None  # type: ignore[assignment]
    inverted: bool = False
    unused: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Turn the signals into arrays of float and check that they belong together."""
        for quantity in UNITS:
            values = getattr(self, quantity)
            if values is not None:
                object.__setattr__(self, quantity, np.asarray(values, dtype=float))
        mask = np.zeros(self.time.shape, bool) if self.outliers is None else self.outliers
        object.__setattr__(self, "outliers", np.asarray(mask, dtype=bool))
        for name, values in self._arrays().items():
            if values.ndim != 1 or len(values) != len(self.time):
                raise InputError(
                    f"record '{self.name}': {name} has shape {values.shape}, time has {self.time.shape}"
                )
        if not (np.isfinite(self.sample_time) and self.sample_time > 0.0):
            raise InputError(
                f"record '{self.name}': the sample time must be positive, got {self.sample_time}"
            )

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.time)

    def slice(self, start: int | None = None, stop: int | None = None, step: int = 1) -> Record:
        """Return the samples start .. stop - 1, or each step-th of them, counted as Python's slices do.

        Parameters
        ----------
        start, stop : int or None
            Sample numbers; negative ones count from the end, None is the end itself.
        step : int
            Distance between samples; at least 1.

        Returns
        -------
        Record
            A record whose arrays are views into this one.
        """
        part = slice(start, stop, step)
        parts: dict[str, Any] = {name: values[part] for name, values in self._arrays().items()}
        return replace(self, sample_time=step * self.sample_time, **parts)

    def invert(self) -> Record:
        """Return the record with the sign of the displacement, and of the reference, flipped."""
        flipped: dict[str, Any] = {
            name: -values for name, values in self._arrays().items() if name in SIGNED
        }
        return replace(self, notes=(*self.notes, INVERTED), inverted=not self.inverted, **flipped)

    def _arrays(self) -> dict[str, np.ndarray]:
        found = {item.name: getattr(self, item.name) for item in fields(self)}
        return {name: value for name, value in found.items() if isinstance(value, np.ndarray)}
