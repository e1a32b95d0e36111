"""Long records of slow walks: next to nothing in them tells a slow core from a delay."""

import numpy as np
import pytest
from diagnosis.cases import Case
from diagnosis.designed import measured

from it2hys.diagnosis import diagnose
from it2hys.model.chain import EFFECTS

LENGTH = 45_000


@pytest.mark.gate
@pytest.mark.parametrize(("seed", "effects"), [(381_006, ("play",)), (381_010, ("play", "creep"))])
def test_a_core_that_is_slow_is_not_called_a_delay(seed, effects):
    """A delay in its place calms the inverse, and does as well in the free run."""
    case = Case(seed, "a walk", effects, length=6000)
    greatest = max(float(r.voltage.max()) for r in case.train)
    generator = np.random.default_rng([seed, 7])
    levels = int(generator.integers(40, 110))
    heights = greatest * generator.uniform(0.0, 1.0, levels)
    heights[0] = 0.0
    voltage = np.interp(np.linspace(0, levels - 1, LENGTH), np.arange(levels), heights)
    record = measured(case, voltage, "walk", 1, case.noise_rms)
    others = [e for e in EFFECTS if e not in (*effects, "delay")]
    found = diagnose([record], declared=effects, excluded=others)
    assert found.effects == ()
    assert found.after[0].e_rms < 1.3 * case.noise_rms
