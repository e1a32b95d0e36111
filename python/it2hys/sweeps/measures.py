"""The metrics of a sweep: numbers of one output, or of one output against a signal."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import isfinite, sqrt

import numpy as np
import scipy

from it2hys.errors import InputError
from it2hys.model.compiled import address, library_function
from it2hys.records.figures_of_merit import max_relative_error, rms_error

#: A gain has fallen by 3 dB where it is below this share of its low-frequency value.
HALF_POWER = 1.0 / np.sqrt(2.0)
#: Frequencies with less than this share of the largest power are not excited.
EXCITED = 1e-3
#: Fourier components that a gain is smoothed over.
NEIGHBOURS = 9
#: Share of a record that is faded in and out, so that its ends leak into no other frequency.
TAPER = 0.1


def bandwidth(reference: np.ndarray, output: np.ndarray, step: float) -> float:
    """Return the frequency at which the gain from reference to output has fallen by 3 dB.

    The gain is that of the Fourier transforms, at the frequencies that the reference excites. Single
    lines are those of a multisine over whole periods, and exact; a dense spectrum, such as a chirp's,
    is tapered and smoothed over neighbours. The lowest frequency counts as low; between frequencies
    the gain is interpolated.

    Parameters
    ----------
    reference, output : ndarray, shape (N,)
        Sampled every `step` seconds.
    step : float
        In s.

    Returns
    -------
    float
        In Hz; NaN if the gain stays above -3 dB over the whole band that the reference excites.

    Raises
    ------
    InputError
        If the reference is constant.
    """
    if np.ptp(reference) == 0.0:
        raise InputError("bandwidth needs a reference that varies")
    plain = _transforms(reference, output, np.ones(len(reference)), 1)
    apart = np.diff(np.flatnonzero(plain[2])) > 1
    if 2 * np.count_nonzero(apart) >= len(apart):
        gains, excited = plain[1:]
    else:
        _, gains, excited = _transforms(
            reference, output, scipy.signal.windows.tukey(len(reference), TAPER), NEIGHBOURS
        )
    frequency = np.fft.rfftfreq(len(reference), step)[1:][excited]
    relative = gains[excited] / gains[excited][0]
    fallen = np.flatnonzero(relative < HALF_POWER)
    if not len(fallen):
        return float("nan")
    around = [fallen[0] - 1, fallen[0]]
    return float(np.interp(-HALF_POWER, -relative[around], frequency[around]))


def _transforms(
    reference: np.ndarray, output: np.ndarray, window: np.ndarray, neighbours: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return power of the reference, gain to the output, and where there is power, by frequency."""
    r, y = (np.fft.rfft((x - x.mean()) * window)[1:] for x in (reference, output))
    smooth = np.ones(neighbours)
    power = np.abs(r) ** 2
    cross = np.abs(np.convolve(np.conj(r) * y, smooth, mode="same"))
    gains = cross / np.maximum(np.convolve(power, smooth, mode="same"), np.finfo(float).tiny)
    return power, gains, power > EXCITED * power.max()


def loop_area(voltage: np.ndarray, displacement: np.ndarray) -> float:
    """Return the area of a hysteresis loop as a share of the rectangle around it.

    Parameters
    ----------
    voltage, displacement : ndarray, shape (N,)
        Whole periods of a periodic input, and the output.

    Returns
    -------
    float
        Mean of the periods; NaN if one of the two is constant.
    """
    box = np.ptp(voltage) * np.ptp(displacement)
    above = voltage > 0.5 * (voltage.min() + voltage.max())
    periods = np.count_nonzero(~above & np.roll(above, -1))
    area = 0.5 * np.sum(displacement * (np.roll(voltage, -1) - np.roll(voltage, 1)))
    return float(abs(area) / (periods * box)) if box and periods else float("nan")


class _Range(ctypes.Structure):
    """`struct course_range` of fmu_src/python/course_summary.c."""

    _fields_ = tuple((name, ctypes.c_double) for name in ("low", "high", "zero"))


class _Error(ctypes.Structure):
    """`struct course_error` of fmu_src/python/course_summary.c."""

    _fields_ = tuple((name, ctypes.c_double) for name in ("largest", "squares", "low", "high"))


_ADDRESS, _COUNT = ctypes.c_void_p, ctypes.c_int64
#: Result and arguments of the functions of fmu_src/python/course_summary.c.
_FUNCTIONS = {
    "range": (None, _ADDRESS, _COUNT, ctypes.POINTER(_Range)),
    "error": (None, _ADDRESS, _ADDRESS, _COUNT, ctypes.POINTER(_Error)),
    "true": (_COUNT, _ADDRESS, _COUNT),
}


@cache
def _function(name: str) -> Callable:
    function = library_function(f"it2core_course_{name}")
    function.restype, *function.argtypes = _FUNCTIONS[name]
    return function


def count_true(course: np.ndarray) -> int:
    """Return how many values of a course are not 0."""
    course = np.ascontiguousarray(course, dtype=np.float64)
    return _function("true")(address(course), course.size)


class MetricData:
    """What metrics are computed from, and what those of one output share.

    Parameters
    ----------
    output : ndarray, shape (N,)
        From the end of the lead-in on.
    against : ndarray, shape (N,), optional
        What it is compared with.
    step : float
        Between samples, s.
    """

    def __init__(self, output: np.ndarray, against: np.ndarray | None, step: float) -> None:
        self.output = np.ascontiguousarray(output, dtype=np.float64)
        self.against, self.step = against, step
        self._range: _Range | None = None
        self._error: _Error | None = None

    def _compared(self) -> _Error:
        """Return how far the output is from what it is compared with."""
        if self._error is None:
            against, self._error = np.ascontiguousarray(self.against, dtype=np.float64), _Error()
            if against.shape != self.output.shape:
                raise InputError(
                    f"shapes differ, {self.output.shape} and {against.shape}: both must be equal"
                )
            _function("error")(address(self.output), address(against), self.output.size, self._error)
        return self._error

    def e_mr(self) -> float:
        """Return the largest error over the range of what the output is compared with, (24)."""
        error = self._compared()
        if isfinite(error.squares) and error.high > error.low:
            return error.largest / (error.high - error.low)
        return max_relative_error(self.against, self.output)  # which says what is wrong

    def e_rms(self) -> float:
        """Return the root of the mean squared error, (25)."""
        squares = self._compared().squares
        if isfinite(squares):
            return sqrt(squares / self.output.size)
        return rms_error(self.against, self.output)

    def limits(self) -> tuple[float, float]:
        """Return the least and the greatest value; raises InputError if a sample is not finite."""
        if self._range is None:
            self._range = _Range()
            _function("range")(address(self.output), self.output.size, self._range)
        if self._range.zero != 0.0:
            bad = int(np.argmin(np.isfinite(self.output)))
            raise InputError(f"the output is not finite, first at sample {bad} of those judged")
        return self._range.low, self._range.high

    def finite(self) -> np.ndarray:
        """Return the output; raises InputError if a sample of it is not finite."""
        self.limits()
        return self.output

    def range(self) -> float:
        """Return the greatest less the least value of the output."""
        low, high = self.limits()
        return high - low

    def gain(self) -> float:
        """Return the range of the output over that of what it is compared with."""
        other = np.ptp(self.against)
        return float(self.range() / other) if other else float("nan")


@dataclass(frozen=True)
class Kind:
    """A kind of metric.

    Attributes
    ----------
    function : callable
        From what is judged to the number.
    compares : bool
        Whether it needs something to compare with.
    unit : str
        Of the number; ``"same"`` for the output's own.
    text : str
        What it is, for the documentation.
    """

    function: Callable[[MetricData], float]
    compares: bool
    unit: str
    text: str


def _of_one(function: Callable[[np.ndarray], float]) -> Callable:
    return lambda judged: float(function(judged.finite()))


KINDS: dict[str, Kind] = {
    "e_mr": Kind(MetricData.e_mr, True, "share", "(24), largest error over range"),
    "e_rms": Kind(MetricData.e_rms, True, "same", "(25), rms error"),
    "gain": Kind(MetricData.gain, True, "1", "range over the range of `against`"),
    "loop area": Kind(
        lambda it: loop_area(it.against, it.finite()),
        True,
        "share",
        "area of the loop over `against`, as a share of the rectangle around it",
    ),
    "bandwidth": Kind(
        lambda it: bandwidth(it.against, it.finite(), it.step),
        True,
        "Hz",
        "frequency at which the gain has fallen by 3 dB; empty if it does not",
    ),
    "time true": Kind(
        lambda it: float(count_true(it.output) * it.step), False, "s", "time that it is not 0"
    ),
    "mean": Kind(_of_one(np.mean), False, "same", "mean"),
    "std": Kind(_of_one(np.std), False, "same", "standard deviation"),
    "rms": Kind(_of_one(lambda y: np.sqrt(np.mean(y * y))), False, "same", "root of the mean square"),
    "min": Kind(lambda it: it.limits()[0], False, "same", "least value"),
    "max": Kind(lambda it: it.limits()[1], False, "same", "greatest value"),
    "range": Kind(MetricData.range, False, "same", "greatest less least value"),
    "final": Kind(_of_one(lambda y: y[-1]), False, "same", "last value"),
    "change": Kind(_of_one(lambda y: y[-1] - y[0]), False, "same", "last value less the first judged"),
}
