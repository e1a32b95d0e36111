"""What a diagnosis searches of long records: windows where the voltage travels, of every record."""

import numpy as np
import pytest

from it2hys.diagnosis.windows import Window, searched_text, step_of, windows_of
from it2hys.identification.noise import NoiseEstimate
from it2hys.identification.preparation import Prepared
from it2hys.records import Record

NOISE = NoiseEstimate(1e-9, "given")


def prepared(voltage, skip=0, added=0.0, noise=NOISE):
    time = np.arange(len(voltage)) * 1e-4
    return Prepared(Record("long", time, voltage, 1e-7 * voltage + added, 1e-4), skip, noise)


def sine(count):
    """Return a sine that grows: it never does again what it has done."""
    return 50.0 - np.linspace(30.0, 50.0, count) * np.cos(2 * np.pi * 20e-4 * np.arange(count))


def stairs(count, steps=24):
    return 100.0 / steps * (np.arange(count) * steps // count)


def test_records_that_are_short_in_all_are_searched_whole():
    records = [prepared(sine(n)) for n in (12_000, 8_000, 5_000)]
    windows = windows_of(records)
    assert [w.prepared for w in windows] == records
    assert searched_text(windows, windows) == ""


@pytest.mark.parametrize("count", [60_001, 150_000, 1_000_000])
@pytest.mark.parametrize(("draw", "fewest", "most"), [(sine, 10_000, 16_000), (stairs, 35_000, 60_000)])
def test_windows_of_a_long_record_do_not_overlap_and_begin_with_it(draw, fewest, most, count):
    record = prepared(draw(count))
    windows = windows_of([record])
    firsts, ends = [w.first for w in windows], [w.first + len(w) for w in windows]
    assert firsts[0] == 0 and ends[-1] <= count
    assert all(end <= first for end, first in zip(ends, firsts[1:], strict=False))
    assert len(windows) >= 5 and fewest <= sum(map(len, windows)) <= most
    for w in windows:
        np.testing.assert_array_equal(
            w.prepared.record.voltage, record.record.voltage[w.first : w.first + len(w)]
        )


@pytest.mark.parametrize("period", [60, 500, 2500, 10_000])
def test_windows_have_as_many_turning_points_as_a_search_needs(period):
    """Where they are few in a record, windows are longer: memory shows where the voltage turns."""
    growing = np.linspace(30.0, 50.0, 50_000)
    voltage = 50.0 - growing * np.cos(2 * np.pi * np.arange(50_000) / period)
    windows = windows_of([prepared(voltage)])
    turns = sum(len(w) for w in windows) * 2 / period
    assert turns >= 40 or sum(map(len, windows)) == 50_000


def test_steps_far_apart_are_in_the_windows_not_always_at_the_same_place():
    windows = windows_of([prepared(stairs(1_000_000))])
    places = [np.flatnonzero(np.diff(w.prepared.record.voltage)) / len(w) for w in windows]
    with_step = [p[0] for p in places if len(p)]
    assert len(with_step) >= 3
    assert np.ptp(with_step) > 0.3


def test_what_is_left_out_as_a_start_up_is_in_no_window():
    windows = windows_of([prepared(sine(200_000), skip=70_000)])
    assert windows[0].first == 70_000
    assert all(w.prepared.skip == 0 for w in windows)


def begun_late(count, period):
    """Return a voltage that waits, jumps, and goes to and fro."""
    waiting = np.zeros(count // 3)
    swing = 50.0 - 40.0 * np.cos(2 * np.pi * np.arange(count - len(waiting)) / period)
    return np.concatenate([waiting, swing])


def test_a_stage_that_waits_and_repeats_is_searched_where_it_does_what_it_has_not_done():
    """What it does again tells nothing more."""
    noise = 1e-9 * np.random.default_rng(2).standard_normal(60_000)
    (window,) = windows_of([prepared(begun_late(60_000, 5000), added=noise)])
    jump = 20_000
    assert jump - 3000 < window.first < jump - 500
    # the first period, which others repeat, and one that repeats it
    assert jump + 2 * 5000 <= window.first + len(window) < jump + 2.2 * 5000
    record = prepared(begun_late(60_000, 5000), added=noise)
    text = searched_text([window], [Window(0, 0, record)])
    assert text.startswith(f"Effects were sought on a part of the training records, {len(window)} of")


@pytest.mark.parametrize("added", ["creep from the beginning", "creep", "drift of a part of the noise"])
def test_what_creeps_or_drifts_is_searched_to_its_end(added):
    time = np.arange(60_000)
    left = {
        "creep from the beginning": 1e-7 * np.log1p(time / 5000),
        "creep": 1e-7 * np.log1p(np.maximum(time - 20_000, 0) / 5000),
        # from one period to the next
        "drift of a part of the noise": 5e-9 * time / 60_000,
    }
    noise = 1e-9 * np.random.default_rng(2).standard_normal(60_000)
    windows = windows_of([prepared(begun_late(60_000, 5000), added=left[added] + noise)])
    assert windows[0].first == 0 and windows[-1].first + len(windows[-1]) == 60_000


def test_every_record_has_a_window():
    windows = windows_of([prepared(sine(n)) for n in (200_000, 700, 5_000)])
    assert {w.record for w in windows} == {0, 1, 2}
    assert len(next(w for w in windows if w.record == 1)) == 700


def test_what_was_searched_is_said():
    record = prepared(sine(100_000))
    windows = windows_of([record])
    text = searched_text(windows, [Window(0, 0, record)])
    assert f"{len(windows)} windows" in text
    assert f"{sum(map(len, windows))} of their 100000 samples" in text
    slow = windows_of([record], 8)
    assert searched_text(slow, [Window(0, 0, record)]).startswith(
        "Effects were sought on one sample in 8 of the training records, 12500 of their 100000 samples;"
    )


# --- every n-th sample ------------------------------------------------------------------------------


def ring(count):
    time = np.arange(count) * 1e-4
    return 5e-8 * np.where(time > 2.0, np.exp(-200 * (time - 2.0)) * np.sin(1.2e4 * time), 0.0)


def line(count, frequency):
    return 3e-10 * np.sin(2 * np.pi * frequency * np.arange(count))


def noise(count):
    return 1e-9 * np.random.default_rng(5).standard_normal(count)


def test_every_nth_sample_of_a_slow_record_tells_as_much_and_keeps_what_was_before():
    record = prepared(sine(50_000), added=noise(50_000), skip=6)
    assert step_of([record]) == 4
    (window,) = windows_of([record], 4)
    assert (window.first, len(window), window.prepared.skip) == (0, 12_500, 2)
    np.testing.assert_array_equal(window.prepared.record.time, record.record.time[::4])
    assert window.prepared.record.sample_time == 4e-4
    assert window.prepared.noise is record.noise


@pytest.mark.parametrize(
    ("record", "others"),
    [
        (prepared(sine(50_000), added=noise(50_000) + ring(50_000)), ()),
        (prepared(sine(50_000), added=noise(50_000) + line(50_000, 0.31)), ()),
        (prepared(stairs(50_000), added=noise(50_000)), ()),
        (prepared(sine(50_000), noise=NoiseEstimate(0.0, "given")), ()),
        (prepared(sine(50_000)), (prepared(stairs(5_000)),)),
        (prepared(sine(25_000)), ()),
    ],
    ids=[
        "rings",
        "a line of the noise's size",
        "steps",
        "without noise",
        "steps that decide",
        "not long",
    ],
)
def test_what_is_fast_or_short_keeps_all_samples(record, others):
    assert step_of([record], others) == 1


def test_a_line_may_be_as_fast_as_what_every_second_kept_sample_shows():
    assert step_of([prepared(sine(50_000), added=noise(50_000) + line(50_000, 0.1))]) == 2


@pytest.mark.parametrize(("count", "step"), [(50_000, 4), (200_000, 16), (1_000_000, 40)])
def test_noise_is_no_line_however_long_the_record(count, step):
    slow = 50.0 - 50.0 * np.cos(2e-3 * np.arange(count))
    assert step_of([prepared(slow, added=noise(count))]) == step


@pytest.mark.filterwarnings("error")
def test_a_record_whose_voltage_stands_still_is_told_by_its_displacement():
    still = prepared(np.full(20_000, 50.0), added=noise(20_000))
    assert step_of([prepared(sine(50_000), added=noise(50_000)), still]) == 5
    falling = prepared(np.full(20_000, 50.0), added=noise(20_000) + stairs(20_000) * 1e-8)
    assert step_of([prepared(sine(50_000), added=noise(50_000)), falling]) == 1


def test_windows_of_every_nth_sample_are_where_they_say():
    record = prepared(sine(400_000))
    windows = windows_of([record], 4)
    assert len(windows) > 4
    for w in windows:
        own = record.record.voltage[w.first :: 4][: len(w)]
        np.testing.assert_array_equal(w.prepared.record.voltage, own)
