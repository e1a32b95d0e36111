"""Each threshold says what it is and where it comes from, and the page has them all."""

import importlib.util
import json
from dataclasses import FrozenInstanceError
from pathlib import Path

import pytest

from it2hys.policy import SEARCH, thresholds

ROOT = Path(__file__).parents[2]


def test_every_threshold_has_a_unit_a_meaning_and_a_source():
    for name, value, unit, meaning, source in thresholds():
        assert isinstance(value, int | float) and value > 0, name
        assert unit and len(meaning.split()) >= 3 and len(source.split()) >= 2, name


def test_a_threshold_is_not_changed_in_passing():
    with pytest.raises(FrozenInstanceError):
        SEARCH.least_gain = 0.5


def test_the_page_is_that_of_the_thresholds_and_of_the_last_counts():
    """Run `python benchmarks/thresholds.py --page` after a change of `it2hys.policy`."""
    path = ROOT / "benchmarks" / "thresholds.py"
    spec = importlib.util.spec_from_file_location("thresholds_benchmark", path)
    benchmark = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(benchmark)
    counted = json.loads(benchmark.COUNTS.read_text(encoding="utf-8"))
    assert benchmark.PAGE.read_text(encoding="utf-8") == benchmark.page(counted)
