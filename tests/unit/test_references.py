"""What an inverse on measured data is fed with."""

import numpy as np
import pytest
from conftest import UM

from it2hys.identification.inverse import References, ask_inverse, noise_of_inverse
from it2hys.model import compiled
from it2hys.model.compiled import Drive
from it2hys.model.parameters import table_1

NOISE = 0.002 * UM
#: Samples at which the filter does not end.
MIDDLE = slice(1000, -1000)


def references(count, added=0.0):
    time = np.arange(count) * 1e-4
    noise = NOISE * np.random.default_rng(count).standard_normal(count)
    # the fastest of the motion is small: cut at its frequency, it hardly changes
    motion = 5 * UM * np.sin(2 * np.pi * 7.0 * time) + NOISE * np.sin(2 * np.pi * 60.0 * time)
    y = motion + noise + added
    return References(y, np.ones(count, dtype=bool), NOISE, 1e-4)


@pytest.mark.parametrize("count", [20_000, 200_000, 1_000_000])
def test_noise_alone_is_filtered_however_long_the_record(count):
    assert not np.any(references(count).band.whole[MIDDLE])


def test_what_is_faster_than_the_band_stays_as_measured():
    jump = 0.05 * UM * (np.arange(20_000) >= 11_000)
    whole = MIDDLE.start + np.flatnonzero(references(20_000, jump).band.whole[MIDDLE])
    assert whole[0] <= 11_000 <= whole[-1] and len(whole) < 2000


def test_one_ring_does_not_fill_a_long_record_with_noise():
    """The stage of a record of 10 s rang for 10 ms: the inverse made 1.8 V of the noise, not 0.25 V."""
    count, begin = 40_000, 15_000
    behind = np.arange(count - begin) * 1e-4
    ring = np.zeros(count)
    ring[begin:] = 2.0 * UM * np.exp(-behind / 2e-3) * np.cos(2 * np.pi * 900.0 * behind)
    noisy, quiet = references(count, ring), references(count).whole
    error = noisy.local.displacement - noisy.displacement
    motion = 5 * UM * np.sin(2 * np.pi * 7.0 * np.arange(count) * 1e-4)
    assert noisy.local.band > 900.0
    # where it rings nothing of it is lost, and far from it little noise is left
    assert np.sqrt(np.mean(error[begin : begin + 100] ** 2)) < NOISE
    left = (quiet - motion)[25_000:-1000], (noisy.local.displacement - motion)[25_000:-1000]
    assert np.std(left[1] - NOISE * np.sin(0.012 * np.pi * np.arange(25_000, 39_000))) < 0.4 * NOISE
    assert np.std(left[0]) > NOISE


def test_a_spike_of_the_noise_lets_through_little_of_it():
    spike = 7.0 * NOISE * (np.arange(20_000) == 9_000)
    reference = references(20_000, spike).local
    assert np.count_nonzero(reference.whole[MIDDLE]) <= 30
    parts = sum(p.weight for p in reference.parts)
    np.testing.assert_allclose(parts, 1.0, rtol=1e-12)


@pytest.mark.parametrize("frequency", [50.0, 30.0])
def test_a_line_beyond_the_band_is_taken_off_as_little_as_it_is_in_the_reference(frequency):
    """At 200 samples a second the mains' line is beyond it: its model spoilt the inverse."""
    values = {**table_1(), "sampleTime": 5e-3, "hum.amplitude": 0.06 * UM, "hum.frequency": frequency}
    voltage = 50.0 - 40.0 * np.cos(2.0 * np.pi * 0.5 * np.arange(4000) * 5e-3)
    packed = compiled.pack_chain(values)
    _, reading = compiled.chain_free_run(packed, voltage)
    noise = 0.006 * UM
    reading = reading + noise * np.random.default_rng(0).standard_normal(4000)
    trusted = np.ones(4000, dtype=bool)
    record = References(reading, trusted, noise, 5e-3)
    for name in ("local", "band", "wide"):
        asked, _ = ask_inverse(values, Drive.of(voltage), record, name)
        inside = getattr(record, name).inside
        noise_alone = noise_of_inverse(values, Drive.of(voltage), record, name)
        error = (asked - voltage)[inside]
        assert np.mean(error**2) < 1.2 * np.mean(noise_alone[inside] ** 2)  # 40 and more before
