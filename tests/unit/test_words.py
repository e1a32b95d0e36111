"""How messages and pages write figures and their units."""

import ast
from pathlib import Path

import numpy as np
import pytest

import it2hys
from it2hys.reports.page import Answer, Page, Table, write_page
from it2hys.reports.validity import out_of_range_sentence
from it2hys.support.numerals import plain

PACKAGE = Path(it2hys.__file__).parent


def behind_figures(tree):
    """Yield the texts that stand behind a value within an f-string."""
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            for value, text in zip(node.values, node.values[1:], strict=False):
                if isinstance(value, ast.FormattedValue) and isinstance(text, ast.Constant):
                    yield text.value


def test_no_message_writes_um_behind_a_figure():
    texts = [
        f"{path.relative_to(PACKAGE)}: {text!r}"
        for path in PACKAGE.rglob("*.py")
        for text in behind_figures(ast.parse(path.read_text(encoding="utf-8")))
        if text.startswith(" um")
    ]
    assert texts == []


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (9.804, "9.8"), (4670.4, "4670"), (15123.0, "15100"), (2e-5, "2e-05"), (3e9, "3e+09")],
)
def test_a_figure_is_a_power_of_ten_only_far_from_one(value, text):
    assert plain(value) == text


def test_a_range_is_told_with_as_many_digits_as_it_is_worth():
    ends = {"voltageMin": 0.0, "voltageMax": 104.082345, "displacementMin": -1.57643e-6,
            "displacementMax": 16.857e-6}  # fmt: skip
    outside, voltage = np.array([False, True]), np.array([1.0, 105.01234])
    said = out_of_range_sentence(ends, outside, voltage, np.array([0.0, 15.4021e-6]))
    assert "0 to 104.1 V and -1.576 to 16.86 µm" in said and " um" not in said
    assert "105 to 105 V" in said


def test_a_page_does_not_part_a_figure_from_its_unit(tmp_path):
    table = Table(["a", "b"], [["0.0136 µm (0.09 %)", "± 0.0046"], ["12 N", "± 3"]])
    assert table.figures == [False, True]
    write_page(
        tmp_path, Page("t", answers=[Answer("q", ["Up to 360 Hz, for 2 minutes, `-n 5 V`."], table)])
    )
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    for text in ("0.0136\xa0µm (0.09\xa0%)", "±\xa00.0046", "12\xa0N", "360\xa0Hz, for 2 minutes"):
        assert text in page, text
