"""Long records of slow walks: next to nothing in them tells a slow core from a delay."""

import numpy as np
import pytest
from diagnosis.cases import Case
from diagnosis.designed import measured

from it2hys.diagnosis import diagnose
from it2hys.model.chain import EFFECTS


def walk(seed, effects, length):
    """Return a case and its stage's record of a slow walk from level to level."""
    case = Case(seed, "a walk", effects, length=6000)
    greatest = max(float(r.voltage.max()) for r in case.train)
    generator = np.random.default_rng([seed, 7])
    levels = int(generator.integers(40, 110))
    heights = greatest * generator.uniform(0.0, 1.0, levels)
    heights[0] = 0.0
    voltage = np.interp(np.linspace(0, levels - 1, length), np.arange(levels), heights)
    return case, measured(case, voltage, "walk", 1, case.noise_rms)


@pytest.mark.gate
@pytest.mark.parametrize(("seed", "effects"), [(381_006, ("play",)), (381_010, ("play", "creep"))])
def test_a_core_that_is_slow_is_not_called_a_delay(seed, effects):
    """A delay in its place calms the inverse, and does as well in the free run."""
    case, record = walk(seed, effects, 45_000)
    others = [e for e in EFFECTS if e not in (*effects, "delay")]
    found = diagnose([record], declared=effects, excluded=others)
    assert found.effects == ()
    assert found.after[0].e_rms < 1.3 * case.noise_rms


@pytest.mark.gate
def test_processes_and_their_threads_share_a_long_record_to_the_same_bits():
    _, record = walk(381_010, ("play", "creep"), 26_000)
    others = [e for e in EFFECTS if e not in ("play", "creep", "lag")]
    alone, shared = (diagnose([record], excluded=others, workers=n) for n in (1, 2))
    assert shared.effects == alone.effects == ("play", "creep")
    assert {**shared.parameters} == {**alone.parameters}
    assert [s.e_rms for s in shared.stages] == [s.e_rms for s in alone.stages]
