"""What a report says first: computed from the records, on the samples that count."""

from dataclasses import dataclass

import numpy as np
import pytest

from it2hys.records import Record
from it2hys.records.figures_of_merit import Errors, errors
from it2hys.reports.verdict import (
    feedforward_verdict,
    model_verdict,
    straight_line,
    straight_line_errors,
)

UM = 1e-6
SAMPLES = 400
SLOPE, OFFSET = 0.15 * UM, 2 * UM
ADVICE = "Do something else."


@dataclass
class Result:
    name: str
    role: str
    e_mr: float
    e_rms: float
    offset: float
    used: np.ndarray


def loop(name, width, offset=OFFSET, seed=0):
    """Return a record of a straight stage whose loop has a width, m."""
    phase = np.linspace(0, 6 * np.pi, SAMPLES)
    noise = 0.001 * UM * np.random.default_rng(seed).standard_normal(SAMPLES)
    voltage = 50 - 50 * np.cos(phase)
    displacement = SLOPE * voltage + offset + width * np.sin(phase) + noise
    return Record(name, np.arange(SAMPLES) * 1e-4, voltage, displacement, 1e-4)


def judged(record, role, error, offset=0.0, used=None):
    """Return a result of a model that is off by so much, m, now above and now below."""
    used = np.ones(SAMPLES, dtype=bool) if used is None else used
    wrong = record.displacement + error * np.where(np.arange(SAMPLES) % 2, 1.0, -1.0)
    return Result(
        record.name, role, *errors(record.displacement[used], wrong[used]), offset, used
    )  # fmt: skip


def verdict(*pairs):
    records, results = zip(*pairs, strict=True)
    return model_verdict(results, straight_line_errors(records, results), ADVICE)


def case(name, role, width, error, **options):
    record = loop(name, width)
    return record, judged(record, role, error, **options)


def test_a_model_that_is_better_than_a_line_gets_no_verdict():
    train, test = case("train", "train", UM, 0.1 * UM), case("test", "test", UM, 0.1 * UM)
    assert verdict(train, test) == []


def test_a_model_that_is_worse_than_a_line_is_called_so_with_figures_and_advice():
    (text,) = verdict(case("train", "train", UM, 0.1 * UM), case("late", "test", UM, 1.5 * UM))
    assert text.startswith("This model does no better than a straight line on late (e_mr ")
    assert "e_rms 1.5 µm, line 0.70" in text
    assert text.endswith(ADVICE)


def test_the_error_by_which_a_model_is_worse_is_named():
    record = loop("spiky", UM)
    result = judged(record, "test", 0.1 * UM)
    result.e_mr = 1.0
    (text,) = verdict((record, result))
    assert text.startswith("By its largest error this model does no better")
    result.e_mr, result.e_rms = 0.01, UM
    (text,) = verdict((record, result))
    assert text.startswith("By its rms error this model does no better")


@pytest.mark.parametrize(
    ("bad", "roles", "is_said"),
    [
        ("train", ("train", "test"), False),
        ("validation", ("train", "validation", "test"), False),
        ("test", ("train", "validation", "test"), True),
        ("train", ("train", "validation"), False),
        ("validation", ("train", "validation"), True),
        ("train", ("train",), True),
    ],
)
def test_the_test_records_count_before_the_others(bad, roles, is_said):
    pairs = [case(role, role, UM, 2 * UM if role == bad else 0.1 * UM) for role in roles]
    assert bool(verdict(*pairs)) is is_said


def test_three_records_are_named_and_the_others_counted():
    bad = [case(f"bad{i}", "test", UM, 2 * UM) for i in range(5)]
    (text,) = verdict(case("train", "train", UM, 0.1 * UM), *bad, case("good", "test", UM, 0.1 * UM))
    assert "bad0 (" in text and "bad2 (" in text and "and 2 more" in text
    assert "bad3" not in text and "good" not in text


def test_an_error_that_is_no_number_is_not_better():
    record = loop("endless", UM)
    result = judged(record, "test", 0.1 * UM)
    result.e_mr = result.e_rms = np.inf
    assert verdict((record, result))


def test_the_line_is_fitted_to_the_training_records_alone():
    train, test = loop("train", UM), loop("test", UM)
    steeper = Record("test", test.time, test.voltage, 3 * test.displacement, 1e-4)
    results = [judged(train, "train", UM), judged(steeper, "test", UM)]
    assert straight_line([train, steeper], results) == pytest.approx((SLOPE, OFFSET), rel=0.02)


def test_without_training_records_the_line_is_fitted_to_what_there_is():
    record = loop("test", UM)
    line = straight_line([record], [judged(record, "test", UM)])
    assert line == pytest.approx((SLOPE, OFFSET), rel=0.02)


def test_the_line_is_judged_where_the_model_is():
    """A spike and a start-up that the model is not judged on do not speak against the line."""
    record = loop("spoilt", 0.5 * UM)
    spoilt = record.displacement.copy()
    spoilt[:50] += 20 * UM
    spoilt[300] += 50 * UM
    record = Record("spoilt", record.time, record.voltage, spoilt, 1e-4)
    used = np.ones(SAMPLES, dtype=bool)
    used[:50] = used[300] = False
    ((e_mr, e_rms),) = straight_line_errors([record], [judged(record, "train", UM, used=used)])
    assert e_rms == pytest.approx(0.5 * UM / np.sqrt(2), rel=0.05)
    assert e_mr == pytest.approx(0.5 / 15, rel=0.2)


@pytest.mark.parametrize(("offset", "error"), [(0.3 * UM, 0.0), (0.0, 3 * UM)])
def test_records_differ_by_a_constant_for_the_line_if_they_do_for_the_model(offset, error):
    records = [loop("train", 0.0), loop("moved", 0.0, offset=OFFSET + 3 * UM)]
    results = [judged(r, role, UM, offset) for r, role in zip(records, ("train", "test"), strict=True)]
    assert straight_line_errors(records, results)[1].e_rms == pytest.approx(error, abs=0.01 * UM)


@pytest.mark.parametrize(
    ("inverse", "beginning"),
    [
        (Errors(0.05, 0.5 * UM), None),
        (Errors(0.09, 0.5 * UM), "By its largest error the inverse as feedforward is worse than none"),
        (Errors(0.05, 0.9 * UM), "By its rms error the inverse as feedforward is worse than none"),
        (Errors(0.09, 0.9 * UM), "The inverse as feedforward is worse than none"),
    ],
)
def test_feedforward_that_is_worse_than_none_is_called_so(inverse, beginning):
    texts = feedforward_verdict(inverse, Errors(0.07, 0.7 * UM), ADVICE)
    if beginning is None:
        assert texts == []
        return
    (text,) = texts
    assert text.startswith(beginning) and text.endswith(ADVICE)
    assert "none 7 %" in text and "none 0.7 µm" in text
