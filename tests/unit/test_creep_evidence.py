"""Terms of creep: how one more is added."""

import numpy as np
import pytest

from it2hys.diagnosis.evidence.creep import EVIDENCE
from it2hys.model.chain import EFFECTS
from it2hys.records.clues import Extent

EXTENT = Extent(5e-3, 20.0, (0.0, 100.0), (0.0, 13e-6))
CONSTANTS, GAINS = (0.22, 1.3, 23.0), (0.05, 0.04, 0.06)


def terms(constants, gains):
    values = {f"creep[{i}].timeConstant": t for i, t in enumerate(constants, start=1)}
    values |= {f"creep[{i}].gain": g for i, g in enumerate(gains, start=1)}
    return {"creepCount": len(constants), **values}


def of(values, name):
    return np.array([values[f"creep[{i}].{name}"] for i in range(1, values["creepCount"] + 1)])


def test_one_term_more_is_slower_or_all_are_spread_anew():
    """Of four terms three had been found, each apart from where it is: a slower one found no place."""
    slower, spread = EVIDENCE.extended(terms(CONSTANTS, GAINS), EXTENT)
    np.testing.assert_array_equal(of(slower, "timeConstant"), [*CONSTANTS, EXTENT.duration])
    np.testing.assert_array_equal(of(slower, "gain")[:3], GAINS)
    np.testing.assert_allclose(np.diff(np.log(of(spread, "timeConstant")), 2), 0.0, atol=1e-12)
    assert of(spread, "timeConstant")[0] < 0.5 * min(CONSTANTS)
    assert of(spread, "timeConstant")[-1] == pytest.approx(max(CONSTANTS))
    assert of(spread, "gain").sum() == pytest.approx(sum(GAINS))


def test_no_term_is_quicker_than_creep_is():
    _, spread = EVIDENCE.extended(terms((0.06, 0.5, 5.0), GAINS), EXTENT)
    least = EFFECTS["creep"].starts(EXTENT)["creep[1].timeConstant"].low
    assert of(spread, "timeConstant")[0] == pytest.approx(least)


def test_there_are_no_more_terms_than_the_model_has_room_for():
    assert EVIDENCE.extended(terms(np.geomspace(0.1, 10.0, 16), [0.01] * 16), EXTENT) == []


@pytest.mark.parametrize(
    ("apart", "said"), [(1.0, "14 % of a step"), (10.0, ""), (1.3, "14 % of a step")]
)
def test_terms_at_one_time_are_more_creep_than_a_stage_has(apart, said):
    """Two of 10 % at 0.07 s did the work of a delay in a measured record; each was within its bound."""
    beyond = EVIDENCE.beyond(terms([0.07, 0.07 * apart], [0.1, 0.1]))
    assert said in beyond
    assert bool(beyond) == bool(said)
