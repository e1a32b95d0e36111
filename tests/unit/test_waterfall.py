"""How an error falls, as bars: each begins where the one before has ended."""

import numpy as np
import pytest

from it2hys.reports.figures import Fall, waterfall


def bars(axis):
    return [(bar.get_y(), bar.get_y() + bar.get_height()) for bar in axis.patches]


def test_bars_go_down_from_the_first_model_to_the_last_and_the_noise():
    fall = Fall("Plant", [("first", 1.0), ("+ play", 0.4), ("+ creep", 0.1)], 0.05)
    (axis,) = waterfall([fall]).axes
    assert bars(axis) == [
        pytest.approx(b) for b in ((0.0, 1.0), (0.4, 1.0), (0.1, 0.4), (0.0, 0.1), (0.0, 0.05))
    ]
    names = [label.get_text() for label in axis.get_xticklabels()]
    assert names == ["first", "+ play", "+ creep", "now", "noise"]
    assert [t.get_text() for t in axis.texts] == ["1", "−0.6", "−0.3", "0.1", "0.05"]


def test_an_effect_that_raises_this_error_is_seen_to_do_so():
    fall = Fall("Inverse", [("first", 1.0), ("+ delay", 1.2)], np.nan)
    (axis,) = waterfall([fall]).axes
    assert bars(axis) == [pytest.approx(b) for b in ((0.0, 1.0), (1.0, 1.2), (0.0, 1.2))]
    colours = [bar.get_facecolor() for bar in axis.patches]
    down = waterfall([Fall("Plant", [("first", 1.0), ("+ delay", 0.2)], 0.1)]).axes[0].patches[1]
    assert colours[1] != down.get_facecolor()
    assert axis.texts[1].get_text() == "+0.2"
