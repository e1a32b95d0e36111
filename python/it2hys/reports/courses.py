"""The samples that a page draws: thinned records that keep every peak, and the residual's spectrum.

They stand in one file beside `report.json`, so that the page can be drawn again without the records.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from itertools import pairwise
from pathlib import Path

import numpy as np
import scipy  # its parts are loaded when used: the report of a sweep needs none

from it2hys.errors import InputError
from it2hys.support.files import write_atomically

#: File name of the courses.
COURSES = "courses.npz"
#: Samples of all records together, and of one at least and at most: what a page of 8 MB can hold.
_ALL, _FEWEST, _MOST = 120_000, 1_000, 40_000
#: Points of a spectrum, and segments of a record that it is averaged over, half overlapping.
_SPECTRUM, _SEGMENTS = 1_500, 4
#: Stands between the name of a record and that of a signal in the file.
_SEPARATOR = "/"


@dataclass(frozen=True, eq=False)
class Course:
    """A record, and what the models before and after make of it, behind the lead-in.

    Parameters
    ----------
    time, voltage, measured : ndarray, shape (N,)
        s, V and m.
    before, after : ndarray, shape (N,)
        Free runs, m.
    inverse_before, inverse_after : ndarray, shape (N,)
        Voltage that the inverse asks for less the one that was applied, V; NaN where nothing is judged.
    frequency : ndarray, shape (F,)
        Hz.
    spectrum_before, spectrum_after : ndarray, shape (F,)
        One-sided amplitude density of the free runs' errors, m/sqrt(Hz).
    """

    time: np.ndarray
    voltage: np.ndarray
    measured: np.ndarray
    before: np.ndarray
    after: np.ndarray
    inverse_before: np.ndarray
    inverse_after: np.ndarray
    frequency: np.ndarray
    spectrum_before: np.ndarray
    spectrum_after: np.ndarray

    @property
    def error_before(self) -> np.ndarray:
        """Measured less the model before, m."""
        return self.measured - self.before

    @property
    def error_after(self) -> np.ndarray:
        """Measured less the model after, m."""
        return self.measured - self.after


#: Signals of a course: one value a sample.
SIGNALS = ("voltage", "measured", "before", "after", "inverse_before", "inverse_after")
_SPECTRA = ("frequency", "spectrum_before", "spectrum_after")


def make_course(sample_time: float, time: np.ndarray, **signals: np.ndarray) -> Course:
    """Return the course of a record with the spectra of its errors.

    Parameters
    ----------
    sample_time : float
        s.
    time : ndarray, shape (N,)
        s.
    **signals : ndarray, shape (N,)
        By the names in `SIGNALS`.
    """
    errors = [signals["measured"] - signals[when] for when in ("before", "after")]
    spectra = [amplitude_density(error, sample_time) for error in errors]
    return Course(time, **signals, **dict(zip(_SPECTRA, _peaks(*spectra), strict=True)))


def amplitude_density(residual: np.ndarray, sample_time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies, Hz, and the one-sided amplitude density, unit/sqrt(Hz); NaN as 0."""
    known = np.isfinite(residual)
    filled = np.where(known, residual - np.mean(residual[known]), 0.0)
    segment = max(8, len(filled) // _SEGMENTS)
    frequency, power = scipy.signal.welch(filled, 1.0 / sample_time, nperseg=segment)
    # neither the mean nor, at the Nyquist frequency, half a line
    return frequency[1:-1], np.sqrt(power[1:-1])


def _peaks(before: tuple, after: tuple) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return frequency and both spectra, the greatest of those that a logarithmic axis shows as one."""
    frequency = before[0]
    if len(frequency) <= _SPECTRUM:
        return frequency, before[1], after[1]
    edges = np.geomspace(frequency[0], frequency[-1], _SPECTRUM)
    first = np.unique(np.searchsorted(frequency, edges[:-1]))
    return frequency[first], *(np.maximum.reduceat(s, first) for s in (before[1], after[1]))


def thinned(course: Course, most: int) -> Course:
    """Return the course with so many samples at most, about, those that show every peak among them.

    Of every stretch of time the least and the greatest of each signal and of each error are kept, and
    samples that are spread evenly.
    """
    count = len(course.time)
    if count <= most:
        return course
    channels = [getattr(course, name) for name in SIGNALS]
    channels += [course.error_before, course.error_after]
    stretches = max(1, most // (2 * len(channels) + 4))
    kept = [np.linspace(0, count - 1, 4 * stretches).astype(int)]
    edges = np.linspace(0, count, stretches + 1).astype(int)
    for values in channels:
        for worst, pick in ((np.inf, np.argmin), (-np.inf, np.argmax)):
            known = np.where(np.isfinite(values), values, worst)
            kept.append(np.array([a + pick(known[a:b]) for a, b in pairwise(edges) if b > a]))
    places = np.unique(np.concatenate(kept))
    samples = {name: getattr(course, name)[places] for name in ("time", *SIGNALS)}
    return Course(**samples, **{name: getattr(course, name) for name in _SPECTRA})


def write_courses(directory: Path, courses: Mapping[str, Course]) -> None:
    """Write courses by the names of their records."""
    most = int(np.clip(_ALL // max(len(courses), 1), _FEWEST, _MOST))
    arrays = {}
    for name, course in courses.items():
        thin = thinned(course, most)
        for field in ("time", *SIGNALS, *_SPECTRA):
            values = getattr(thin, field)
            # a reading has less than seven digits; time stamps may have more
            kept = values if field == "time" else values.astype(np.float32)
            arrays[f"{name}{_SEPARATOR}{field}"] = kept
    buffer = BytesIO()
    np.savez_compressed(buffer, **arrays)
    write_atomically(directory / COURSES, buffer.getvalue())


def read_courses(directory: Path, names: Sequence[str]) -> dict[str, Course]:
    """Return the courses of records.

    Raises
    ------
    InputError
        If the file is not there, or lacks one of them.
    """
    path = directory / COURSES
    try:
        with np.load(path, allow_pickle=False) as stored:
            return {
                name: Course(
                    **{f: stored[f"{name}{_SEPARATOR}{f}"] for f in ("time", *SIGNALS, *_SPECTRA)}
                )
                for name in names
            }
    except FileNotFoundError:
        raise InputError(
            f"{path}: no such file; it is written beside report.json, for the figures"
        ) from None
    except (KeyError, ValueError, OSError, EOFError):
        raise InputError(
            f"{path}: damaged, or not of this report.json; make the report again from its records"
        ) from None


def voltages_at_hand(report: Path, sample_time: float) -> dict[str, np.ndarray]:
    """Return the voltages of the two longest records of a report, V, by name, as far as they are whole.

    Parameters
    ----------
    report : Path
        A `report.json`; beside another file there are none.
    sample_time : float
        s; a course that was thinned for the page has another one.
    """
    path = report.with_name(COURSES)
    if report.suffix != ".json" or not path.is_file():
        return {}
    found = {}
    with np.load(path, allow_pickle=False) as stored:
        for key in stored.files:
            name, _, signal_name = key.rpartition(_SEPARATOR)
            if signal_name == "voltage":
                steps = np.diff(stored[f"{name}{_SEPARATOR}time"])
                if np.allclose(steps, sample_time, rtol=1e-3):
                    found[name] = stored[key].astype(float)
    longest = sorted(found, key=lambda name: -len(found[name]))[:2]
    return {name: found[name] for name in longest}
