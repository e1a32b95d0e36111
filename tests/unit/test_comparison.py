"""Two models are compared by blocks: calibrated where both are as good, sharp where one is better."""

import numpy as np
import pytest
from scipy.signal import lfilter

from it2hys.diagnosis.comparison import compare

DRAWS, RECORDS, SAMPLES = 200, 2, 1500
#: Pole of the errors' colour: correlated over some twenty samples.
POLE = 0.9


def coloured(rng, shape):
    """Return unit noise with the memory that errors of free runs have."""
    white = rng.standard_normal((shape[0], shape[1] + 200))
    return np.sqrt(1.0 - POLE**2) * lfilter([1.0], [1.0, -POLE], white)[:, 200:]


def pair(rng, share=0.0):
    """Return errors of two models: common, and their own; the second's are smaller by a share."""
    common, first, second = (coloured(rng, (RECORDS, SAMPLES)) for _ in range(3))
    return list(common + first), list((1.0 - share) * (common + second))


@pytest.fixture(scope="module")
def equally_good():
    rng = np.random.default_rng(1)
    return [compare(*pair(rng), seed=i) for i in range(DRAWS)]


def test_p_values_of_equally_good_models_are_about_uniform(equally_good):
    p = np.sort([c.p_value for c in equally_good])
    distance = np.max(np.abs(p - (np.arange(DRAWS) + 0.5) / DRAWS))
    # Kolmogorov's band at 1 in 1000: 1.95 / sqrt(n), of a test that does not reject too readily
    assert distance < 1.95 / np.sqrt(DRAWS)
    assert np.mean(p < 0.05) < 0.05 + 3 * np.sqrt(0.05 * 0.95 / DRAWS)


@pytest.mark.parametrize("times", [10, 20, 40])
def test_few_stretches_are_not_sure_of_a_gain(times):
    """A share of 0.01 to 0.03 of these would pass by a bootstrap, whose level holds for many blocks."""
    rng = np.random.default_rng(times)
    samples = 40 * times
    sure = 0
    for seed in range(400):
        white = rng.standard_normal((2, 1, samples + 200))
        before, after = lfilter([1.0], [1.0, -0.95], white)[..., 200:]
        sure += compare([*before], [*after], seed).p_value < 5e-4
    assert sure <= 3


def test_few_blocks_that_all_get_better_alike_make_a_gain_sure():
    """Of eight, signs alone would say so once in 256 times."""
    rng = np.random.default_rng(8)
    slow = rng.standard_normal(10).repeat(150)
    sure = compare([slow], [0.9 * slow])
    assert sure.p_value == 1e-4 and sure.interval[0] > 0.0
    one = np.where(np.arange(1500) < 150, 0.3, 1.0) * slow
    assert compare([slow], [one]).p_value > 0.01


def test_intervals_cover_no_gain_as_often_as_they_say(equally_good):
    covered = np.mean([c.interval[0] <= 0.0 <= c.interval[1] for c in equally_good])
    assert 0.95 - 3 * np.sqrt(0.05 * 0.95 / DRAWS) < covered < 1.0


def test_intervals_cover_a_real_gain():
    rng = np.random.default_rng(2)
    covered = [
        c.interval[0] <= 0.1 <= c.interval[1]
        for c in (compare(*pair(rng, 0.1), seed=i) for i in range(DRAWS))
    ]
    assert 0.95 - 3 * np.sqrt(0.05 * 0.95 / DRAWS) < np.mean(covered) < 1.0


def test_a_real_gain_is_found_and_its_loss_is_not():
    rng = np.random.default_rng(3)
    for _ in range(10):
        before, after = pair(rng, 0.3)
        there, back = compare(before, after), compare(after, before)
        assert there.p_value < 3e-4 and there.gain == pytest.approx(0.3, abs=0.1)
        assert back.p_value > 0.99 and back.gain < 0.0


def test_blocks_not_samples_are_what_counts():
    """The same mean gain is sure over white errors and chance over slow ones."""
    rng = np.random.default_rng(4)
    white = [rng.standard_normal(SAMPLES)], [0.9 * rng.standard_normal(SAMPLES)]
    slow = rng.standard_normal((2, 10)).repeat(SAMPLES // 10, axis=1)
    slow *= np.array([[1.0], [0.9]]) / np.sqrt(np.mean(slow**2, axis=1, keepdims=True))
    assert compare(*white).p_value < 0.01
    assert compare([slow[0]], [slow[1]]).gain == pytest.approx(0.1)
    assert compare([slow[0]], [slow[1]]).p_value > 0.05


def test_figures_are_those_of_all_samples_together():
    rng = np.random.default_rng(5)
    before = [rng.standard_normal(n) for n in (500, 2000)]
    after = [0.5 * b for b in before]
    c = compare(before, after)
    assert c.before == pytest.approx(np.sqrt(np.mean(np.concatenate(before) ** 2)), rel=1e-12)
    assert c.gain == pytest.approx(0.5, rel=1e-12)
    assert c.interval == pytest.approx((0.5, 0.5), rel=1e-12)
    assert c == compare(before, after)  # seeded


def test_a_model_is_not_better_than_itself():
    errors = [np.random.default_rng(6).standard_normal(400)]
    c = compare(errors, errors)
    assert c.gain == 0.0 and c.p_value == 1.0
