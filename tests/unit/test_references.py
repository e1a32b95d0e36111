"""What an inverse on measured data is fed with."""

import numpy as np
import pytest
from conftest import UM

from it2hys.identification.inverse import References

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
