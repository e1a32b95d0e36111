"""What a page keeps of long records: every peak, whatever its signal, and every line of a spectrum."""

from __future__ import annotations

import numpy as np
import pytest

from it2hys.reports.courses import SIGNALS, make_course, read_courses, thinned, write_courses

TS = 1e-3
COUNT = 60_000
MOST = 4000


def course_of(count=COUNT, seed=0):
    """Return a course of noise, each signal with a peak up and a peak down of one sample."""
    rng = np.random.default_rng(seed)
    signals = {name: rng.standard_normal(count) for name in SIGNALS}
    peaks = {name: rng.choice(count, 2, replace=False) for name in SIGNALS}
    for name, (up, down) in peaks.items():
        signals[name][up], signals[name][down] = 20.0, -20.0
    return make_course(TS, np.arange(count) * TS, **signals), peaks


@pytest.mark.parametrize("seed", range(5))
def test_no_peak_of_any_signal_is_lost(seed):
    course, peaks = course_of(seed=seed)
    thin = thinned(course, MOST)
    assert len(thin.time) <= MOST
    for name in SIGNALS:
        kept = dict(zip(thin.time, getattr(thin, name), strict=True))
        up, down = peaks[name] * TS
        assert (kept[up], kept[down]) == (20.0, -20.0)


def test_no_peak_of_an_error_is_lost_in_any_stretch():
    """It need not be one of the signals: these go up and down together."""
    course, _ = course_of()
    measured = course.before + 0.1 * np.random.default_rng(1).standard_normal(COUNT)
    signals = {name: getattr(course, name) for name in SIGNALS} | {"measured": measured}
    thin = thinned(make_course(TS, course.time, **signals), MOST)
    error, kept = measured - course.before, thin.error_before
    for begin in range(0, COUNT, COUNT // 10):
        stretch = slice(begin, begin + COUNT // 10)
        inside = (thin.time >= course.time[begin]) & (thin.time <= course.time[stretch][-1])
        assert kept[inside].max() == error[stretch].max() and kept[inside].min() == error[stretch].min()


def test_samples_are_the_records_own_and_a_short_record_is_whole():
    course, _ = course_of()
    thin = thinned(course, MOST)
    places = np.rint(thin.time / TS).astype(int)
    assert np.all(np.diff(places) > 0)
    np.testing.assert_array_equal(thin.measured, course.measured[places])
    short, _ = course_of(1000)
    assert thinned(short, MOST) is short


def test_what_is_not_known_hides_nothing():
    course, _ = course_of()
    asked = course.inverse_after.copy()
    asked[: COUNT // 2] = np.nan
    asked[COUNT // 2 + 5] = 50.0
    signals = {name: getattr(course, name) for name in SIGNALS} | {"inverse_after": asked}
    assert np.nanmax(thinned(make_course(TS, course.time, **signals), MOST).inverse_after) == 50.0


def test_a_line_stands_out_of_a_long_spectrum():
    course, _ = course_of()
    hum = 3.0 * np.sin(2 * np.pi * 123.4 * course.time)
    signals = {name: getattr(course, name) for name in SIGNALS} | {"measured": course.before + hum}
    found = make_course(TS, course.time, **signals)
    assert len(found.frequency) <= 1500
    assert found.frequency[np.argmax(found.spectrum_before)] == pytest.approx(123.4, rel=0.01)


def test_courses_are_read_as_they_were_written(tmp_path):
    courses = {name: course_of(800, seed)[0] for seed, name in enumerate(("a", "b", "c d/é"))}
    write_courses(tmp_path, courses)
    for name, course in read_courses(tmp_path, list(courses)).items():
        for field in ("time", *SIGNALS, "frequency", "spectrum_after"):
            np.testing.assert_allclose(
                getattr(course, field), getattr(courses[name], field), rtol=1e-6, atol=1e-12
            )


def test_as_many_records_as_one_likes_stay_small(tmp_path):
    course, _ = course_of()
    write_courses(tmp_path, {f"r{i}": course for i in range(60)})
    assert (tmp_path / "courses.npz").stat().st_size < 6_000_000
