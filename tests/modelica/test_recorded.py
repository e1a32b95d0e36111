"""What `recorded.py` has written is what it would write now."""

import re

import pytest
import recorded
from effects import with_effects
from library import CLASSES

from it2hys.export.modelica import format_record
from it2hys.model.chain import EFFECTS


def test_the_table_is_what_the_demos_stand_measures():
    assert recorded.TABLE.read_text(encoding="utf-8") == recorded.table(), "run recorded.py"


@pytest.mark.parametrize("name", recorded.NAMES)
def test_a_found_set_is_written_as_sets_are_now(name):
    """A parameter that has come since is in it. What it says is tested where its example runs."""
    text = CLASSES[f"IT2Hysteresis.Parameters.{name}"].read_text(encoding="utf-8")
    now = format_record(with_effects(tuple(EFFECTS), seed=1), name)
    fields = [set(re.findall(r"^    (\w+)=(?!\")", t, re.MULTILINE)) for t in (text, now)]
    groups = {"playThreshold", "playWeight", "creepGain", "creepTimeConstant"}
    assert fields[0] | groups == fields[1] | groups, "run recorded.py"
