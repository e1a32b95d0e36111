"""Models of the library's parts with their defaults only begin at rest and stay physical."""

import numpy as np
import pytest
from combined import COMBINATIONS, PARTS, assert_physical, source_of
from test_simulation import run


def test_there_are_all_that_fit():
    found = {"-".join(p.name for p in c) for c in COMBINATIONS}
    assert len(found) == len(COMBINATIONS) > 20
    assert {"amplifier-actuator", "inverse-plant", "charger-actuator-guide"} <= found
    assert {"inverse-amplifier-actuator", "controller-plant", "actuator-guide-sensor"} <= found
    assert {"actuator-stack", "amplifier-actuator-stack", "actuator-stack-guide"} <= found


def named(parts):
    """Return a case; one of two parts is in the gate where it is in one of three, too."""
    marks = [pytest.mark.gate] if any({*parts} < {*others} for others in COMBINATIONS) else []
    return pytest.param(parts, id="-".join(p.name for p in parts), marks=marks)


@pytest.mark.slow
@pytest.mark.parametrize("parts", [named(parts) for parts in COMBINATIONS])
def test_defaults_begin_in_equilibrium_and_stay_physical(parts):
    assert_physical(parts, run(source_of(parts), 30))


@pytest.mark.slow
def test_the_default_amplifier_drives_the_default_actuator_over_all_its_range():
    """0..10 V at the input, 0..150 V at the stack: beyond the set's range, and bounded."""
    parts = tuple(p for p in PARTS if p.name in ("amplifier", "actuator"))
    source = source_of(parts).replace("amplifier.u = 0;", "amplifier.u = 5 - 5*cos(125*time);")
    at = run(source, 600)
    assert at("actuator.v").max() > 149.0
    assert at("actuator.s_rel").max() < 26e-6
    assert at("actuator.s_rel").min() > -1e-6
    assert np.abs(at("actuator.i")).max() < 0.31
