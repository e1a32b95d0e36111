"""The paper's signals as printed, and the general blocks."""

import numpy as np
import pytest

from it2hys.errors import InputError
from it2hys.stand import excitations

TIME = excitations.time_grid(0.4, 1e-4)


def test_time_grid_counts_ticks_as_integers():
    grid = excitations.time_grid(0.3, 1e-4)
    assert len(grid) == 3000
    np.testing.assert_array_equal(grid, np.array([k * 1e-4 for k in range(3000)]))


@pytest.mark.parametrize(
    ("duration", "sample_time", "count"),
    [(1.0, 0.1, 10), (1.05, 0.1, 11), (0.05, 0.1, 1), (0.7, 0.1, 7), (100.0, 1e-4, 1_000_000)],
)
def test_time_grid_is_half_open(duration, sample_time, count):
    assert len(excitations.time_grid(duration, sample_time)) == count


def test_identification_is_equation_22():
    expected = (
        40.0 * np.sin(2.0 * np.pi * 50.0 * TIME - np.pi / 2.0)
        + 22.5 * np.sin(2.0 * np.pi * 25.0 * TIME - np.pi / 2.0)
        + 62.5
    )
    np.testing.assert_allclose(excitations.identification(TIME), expected, atol=1e-12)


@pytest.mark.parametrize("frequency", [20.0, 40.0])
def test_validation_sine_is_equation_26(frequency):
    expected = 52.5 * np.sin(2.0 * np.pi * frequency * TIME - np.pi / 2.0) + 52.5
    np.testing.assert_allclose(excitations.validation_sine(TIME, frequency), expected, atol=1e-12)


def test_triangle_defaults_are_equation_27():
    corners = np.arange(0.0, 0.4, 0.02)
    expected = np.interp(TIME, corners, np.where(np.arange(len(corners)) % 2, 105.0, 0.0))
    inside = corners[-1] > TIME
    np.testing.assert_allclose(excitations.triangle(TIME)[inside], expected[inside], atol=1e-9)


def test_tracking_reference_is_in_metres():
    expected = 1e-6 * (7.0 * np.sin(2.0 * np.pi * 20.0 * TIME - np.pi / 2.0) + 7.7)
    np.testing.assert_allclose(excitations.tracking_reference(TIME), expected, atol=1e-20)


@pytest.mark.parametrize(
    ("voltage", "high"),
    [
        (excitations.identification(TIME), 104.08203125),
        (excitations.validation_sine(TIME, 20.0), 105.0),
        (excitations.triangle(TIME), 105.0),
        (excitations.sum_100_50(TIME), 105.0),
        (excitations.decaying(TIME, 50.0, 0.1), None),
        (excitations.chirp(TIME, 5.0, 100.0, 0.4), 105.0),
    ],
)
def test_signals_start_at_the_lower_end_and_span_their_range(voltage, high):
    assert voltage[0] == pytest.approx(0.0, abs=1e-12)
    assert voltage.min() > -1e-12
    # Between the samples the peak may be higher by a little.
    if high is not None:
        assert voltage.max() == pytest.approx(high, rel=1e-3)


def test_sum_100_50_has_these_two_tones_only():
    spectrum = np.abs(np.fft.rfft(excitations.sum_100_50(TIME))) / len(TIME)
    frequencies = np.fft.rfftfreq(len(TIME), 1e-4)
    np.testing.assert_allclose(frequencies[spectrum > 1e-9], [0.0, 50.0, 100.0])


def test_steps_switch_at_the_tick_itself():
    time = excitations.time_grid(0.05, 1e-3)  # 0.03 / 0.01 is below 3 in floating point
    voltage = excitations.steps(time, [10.0, 20.0, 5.0, 7.0], hold=0.01)
    np.testing.assert_array_equal(voltage, np.repeat([10.0, 20.0, 5.0, 7.0, 7.0], 10))


def test_chirp_ends_at_its_stop_frequency():
    time = excitations.time_grid(2.0, 1e-4)
    voltage = excitations.chirp(time, 1.0, 50.0, 2.0, low=-1.0, high=1.0)
    crossings = time[:-1][np.diff(np.sign(voltage)) != 0]
    assert 0.5 / np.diff(crossings)[-1] == pytest.approx(50.0, rel=0.03)


def test_multisine_is_seeded_and_fills_its_range():
    first = excitations.multisine(TIME, [10.0, 35.0, 80.0], low=5.0, high=95.0, seed=3)
    again = excitations.multisine(TIME, [10.0, 35.0, 80.0], low=5.0, high=95.0, seed=3)
    other = excitations.multisine(TIME, [10.0, 35.0, 80.0], low=5.0, high=95.0, seed=4)
    np.testing.assert_array_equal(first, again)
    assert np.max(np.abs(first - other)) > 1.0
    assert (first.min(), first.max()) == pytest.approx((5.0, 95.0))


def test_decaying_dies_away_to_the_middle():
    time = excitations.time_grid(1.0, 1e-3)
    voltage = excitations.decaying(time, 10.0, 0.1, low=0.0, high=100.0)
    assert np.ptp(voltage[-100:]) < 0.02
    assert voltage[-1] == pytest.approx(50.0, abs=0.01)


@pytest.mark.parametrize(
    ("call", "phrase"),
    [
        (lambda: excitations.time_grid(-1.0, 1e-4), "duration must be positive"),
        (lambda: excitations.time_grid(1.0, 0.0), "sample_time must be positive"),
        (lambda: excitations.validation_sine(TIME, np.nan), "frequency must be positive"),
        (lambda: excitations.triangle(TIME, low=5.0, high=5.0), "low < high"),
        (lambda: excitations.steps(TIME, [], 0.1), "at least one level"),
        (lambda: excitations.chirp(TIME, 1.0, 2.0, 1.0, method="warp"), "unknown chirp method"),
        (lambda: excitations.multisine(TIME, []), "at least one frequency"),
        (lambda: excitations.multisine(TIME[:1], [1.0]), "at least two samples"),
        (lambda: excitations.decaying(TIME, 1.0, 0.0), "time_constant must be positive"),
    ],
)
def test_bad_arguments_are_named(call, phrase):
    with pytest.raises(InputError, match=phrase):
        call()
