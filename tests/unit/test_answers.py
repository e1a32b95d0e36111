"""The answers at the top of a report where the pair does worse than the one before."""

from types import SimpleNamespace

import numpy as np
import pytest

from it2hys.identification.coverage import ONE_TONE
from it2hys.records import Record
from it2hys.reports.answers import feedforward, next_measurements, verdict
from it2hys.reports.summary import settled_training


def report(role, plant, inverse, noise=0.03):
    """Return a diagnosis with creep added; pairs are errors before and after, µm; 10 µm/V."""

    def entry(i):
        return {
            "role": role, "e_mr_percent": 1.0, "e_rms_um": plant[i], "samples": 100,
            "inverse_e_rms_um": inverse[i], "inverse_band_Hz": 5.0, "inverse_delay_s": 0.0,
            "inverse_clamped_percent": 0.0, "range_um": 40.0, "voltage_explains_percent": None,
            "explained_percent": None, "noise_rms_um": 0.3, "inverse_e_rms_V": inverse[i] / 10.0,
            "inverse_noise_rms_V": noise,
        }  # fmt: skip

    line = {"e_mr_percent": 20.0, "e_rms_um": 5.0, "samples": 100}
    return {
        "kind": "diagnosis",
        "names": {"before": "paper's model"},
        "effects": ["creep"],
        "error": {"before": {"one": entry(0)}, "after": {"one": entry(1)}},
        "straight_line": {"one": line},
        "range": {"displacement_um": [0.0, 40.0], "voltage_V": [0.0, 3.6]},
        "records": {"one": {"driven_up_to_Hz": None}},
        "warnings": [],
    }


@pytest.mark.parametrize(("driven", "said"), [(None, 5), (20.0, 5), (1.0, 1)])
def test_a_pair_is_promised_no_faster_references_than_it_was_fitted_and_judged_on(driven, said):
    """One loop at 0.4 Hz was said to make feedforward up to 23 Hz, which is where noise begins."""
    slow = {**report("test", (1.1, 0.5), (0.9, 0.4)), "records": {"one": {"driven_up_to_Hz": driven}}}
    first, *_ = feedforward(slow)
    assert f"and up to {said} Hz" in first
    assert ("as fast as the records are driven" in first) == (said < 5)


@pytest.mark.parametrize(("role", "careful"), [("train", True), ("test", False)])
def test_what_was_judged_on_the_one_loop_that_it_was_fitted_to_is_used_with_care(role, careful):
    looped = {**report(role, (1.1, 0.5), (0.9, 0.4)), "warnings": [f"{ONE_TONE}: add another."]}
    first, second, *_ = feedforward(looped)
    assert first.startswith("With care, ") == careful
    assert ("smaller ones is not known" in second) == careful


@pytest.mark.parametrize(
    ("plant", "inverse", "said"),
    [
        ((1.11, 1.28), (0.9, 0.9), "the plant is off by 1.28 µm rms instead of 1.11 µm."),
        ((1.11, 1.0), (0.9, 1.2), "the inverse is off by 1.20 µm rms instead of 0.900 µm."),
        ((1.11, 1.28), (0.9, 1.2), "instead of 1.11 µm and the inverse is off by"),
    ],
)
def test_what_is_worse_on_test_records_is_said_first(plant, inverse, said):
    (text,) = verdict(report("test", plant, inverse))
    assert text.startswith("On 1 test record, which decided nothing, creep makes it worse: ")
    assert said in text and "it2hys identify" in text


def test_a_pair_that_is_better_on_test_records_needs_no_such_word():
    assert verdict(report("test", (1.1, 0.5), (0.9, 0.4))) == []
    assert verdict(report("validation", (1.1, 1.3), (0.9, 1.2))) == []


def test_where_a_design_takes_long_its_command_stands_beside_what_would_do():
    asked = report("test", (1.1, 0.5), (0.9, 0.4))
    command = "it2hys design report.json -o DIR"
    later = {"promise": [], "command": command, "power": None}
    more = {"experiments": ["Record a chirp."], "unexplained": False, "next": later}
    first, second = next_measurements({**asked, **more, "left_over": []})
    assert first == "Record a chirp." and second.startswith(f"`{command}` in this folder designs")


def test_an_inverse_that_is_worse_than_the_one_before_is_used_with_care():
    first, second, *_ = feedforward(report("test", (1.1, 0.5), (0.9, 1.2)))
    assert first.startswith("With care, ") and "paper's model is the better one" in second
    assert feedforward(report("test", (1.1, 0.5), (0.9, 0.4)))[0].startswith("Yes, ")


def test_an_inverse_that_hardly_beats_a_straight_line_is_used_with_care():
    first, second, *_ = feedforward(report("test", (1.1, 0.5), (4.0, 2.6)))
    assert first.startswith("With care, ") and "more than half of a straight line's error" in second
    assert feedforward(report("test", (1.1, 0.5), (4.0, 2.4)))[0].startswith("Yes, ")


def test_an_inverse_that_enlarges_noise_is_used_with_care():
    first, second, *_ = feedforward(report("test", (1.1, 0.5), (2.0, 2.0), noise=0.18))
    assert first.startswith("With care, ")
    assert "makes 0.180 V of these 0.200 V: the inverse enlarges it 6.0 times" in second
    assert feedforward(report("test", (1.1, 0.5), (2.0, 2.0), noise=0.05))[0].startswith("Yes, ")


@pytest.mark.parametrize(("latency", "told"), [(0.016, True), (1e-7, False)])
def test_a_dead_time_is_told_where_it_shows_within_the_band(latency, told):
    """A fit that ends at its least shift, a thousandth of a sample, waits for nothing."""
    late = report("test", (1.1, 0.5), (0.9, 0.4))
    late["error"]["after"]["one"]["inverse_delay_s"] = latency
    said = any("no inverse makes up for that dead time" in text for text in feedforward(late))
    assert said is told


def test_the_pair_is_driven_no_farther_than_the_voltage_moves_the_stage():
    """A measured record of three axes: its inverse FMU refused to begin so far outside its range."""
    reading = 1e-5 * np.sin(np.arange(400))
    record = Record("a", np.arange(400) * 1e-4, np.zeros(400), reading, 1e-4)
    judged = SimpleNamespace(role="train", lead=100, y=0.05 * reading)
    (settled,) = settled_training(SimpleNamespace(records=[judged]), [record])
    assert len(settled) == 300
    assert np.ptp(settled.displacement) == pytest.approx(0.06 * np.ptp(reading), rel=1e-3)
