"""Figures of merit of a model output against a measured one: eqs. (24) and (25)."""

from __future__ import annotations

from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from it2hys.errors import InputError

#: Multiple of the noise above which the multiple itself is not given.
_MANY_TIMES = 1000.0
#: A noise below this, m, is not worth a figure.
_NO_NOISE = 1e-12
#: Beyond so many per cent the figure says nothing more.
_MANY_PERCENT = 1000.0


@np.errstate(all="ignore")
def max_relative_error(y: ArrayLike, y_hat: ArrayLike) -> float:
    """Return e_mr, the largest error relative to the range of the measurement, eq. (24).

    Parameters
    ----------
    y : array_like, shape (n,)
        Measured output, in any unit.
    y_hat : array_like, shape (n,)
        Model output, in the unit of `y`.

    Returns
    -------
    float
        max abs(y - y_hat) / (max y - min y), as a fraction (not in per cent).

    Raises
    ------
    InputError
        Where the shapes differ, the arrays are empty or not finite, or `y` is constant.
    """
    return OutputError(y, y_hat).max_relative_error()


@np.errstate(all="ignore")
def rms_error(y: ArrayLike, y_hat: ArrayLike) -> float:
    """Return e_rms, the root of the mean squared error, eq. (25).

    Parameters
    ----------
    y : array_like, shape (n,)
        Measured output, in any unit.
    y_hat : array_like, shape (n,)
        Model output, in the unit of `y`.

    Returns
    -------
    float
        sqrt(mean (y - y_hat)^2), in the unit of `y`.

    Raises
    ------
    InputError
        Where the shapes differ, or the arrays are empty or not finite.
    """
    return OutputError(y, y_hat).rms_error()


class Errors(NamedTuple):
    """Both figures of merit: (24) as a fraction and (25) in m."""

    e_mr: float
    e_rms: float


@np.errstate(all="ignore")
def errors(y: ArrayLike, y_hat: ArrayLike) -> Errors:
    """Return both figures of a model output `y_hat` against a measured one `y`."""
    compared = OutputError(y, y_hat)
    return Errors(compared.max_relative_error(), compared.rms_error())


class OutputError:
    """The difference of a measured and a model output, taken once for both figures of merit.

    Parameters and errors raised are those of `max_relative_error`. Where numbers overflow, numpy warns,
    unless it is told not to.
    """

    def __init__(self, y: ArrayLike, y_hat: ArrayLike) -> None:
        self._y, self._y_hat = _comparable(y, y_hat)
        self._error = self._y - self._y_hat

    def max_relative_error(self) -> float:
        """Return e_mr; see `max_relative_error`."""
        largest = self._judged(max(self._error.max(), -self._error.min()))
        measured_range = self._y.max() - self._y.min()
        if measured_range == 0.0:
            raise InputError("e_mr is undefined: the measured output is constant, its range is zero")
        return float(largest / measured_range)

    def rms_error(self) -> float:
        """Return e_rms; see `rms_error`."""
        return self._judged(sqrt(np.square(self._error).sum() / self._error.size))

    def _judged(self, figure: float) -> float:
        """Return a figure of both outputs; one that is finite says that they are."""
        if not isfinite(figure):
            for name, values in (("measured", self._y), ("model", self._y_hat)):
                finite = np.isfinite(values)
                if not finite.all():
                    bad = int(np.argmin(finite.ravel()))
                    raise InputError(f"the {name} output is not finite, first at sample {bad}")
        return figure


def _comparable(y: ArrayLike, y_hat: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    y, y_hat = np.asarray(y, dtype=float), np.asarray(y_hat, dtype=float)
    # Broadcasting would silently compare a column with a row.
    if y.shape != y_hat.shape:
        raise InputError(
            f"the measured output has shape {y.shape}, the model output {y_hat.shape}: "
            "both must be equal"
        )
    if y.size == 0:
        raise InputError("no samples to compare: both outputs are empty")
    return y, y_hat


def times_the_noise(ratio: float) -> str:
    """Return in words how many times the noise an error is."""
    return f"{ratio:.1f} times the noise" if ratio < _MANY_TIMES else "over a thousand times the noise"


def noise_size(rms: float) -> str:
    """Return a noise, in m rms, in words."""
    return f"{1e6 * rms:.2g} µm rms" if rms > _NO_NOISE else "no noise is visible"


def small_figure(value: float) -> str:
    """Return a figure with four decimals, or with two digits where those would show next to nothing."""
    return f"{value:.4f}" if abs(value) >= 1e-3 else f"{value:.2g}"


def change_in_percent(share: float) -> str:
    """Return a change as a share of what it was before, in per cent with its sign."""
    many = abs(100.0 * share) > _MANY_PERCENT
    return f"over {np.sign(share) * _MANY_PERCENT:+.0f}" if many else f"{100.0 * share:+.1f}"
