"""Two effects that are alike change places: what is exchanged, and between which."""

import numpy as np
from own_effects import in_chain, with_own

from it2hys.diagnosis.variants import in_other_roles
from it2hys.identification.criterion import Model
from it2hys.model.parameters import table_1
from it2hys.model.stages import EFFECTS


def test_what_two_that_ring_have_alike_is_exchanged():
    """`mount` of tests/unit/own has a gain of its own, the built-in one a zero; both stay."""
    with in_chain("mount") as own:
        first = {
            "resonance.frequency": 337.0,
            "resonance.damping": 0.04,
            "resonance.samplingZero": -0.2,
        }
        second = {"mount.frequency": 316.0, "mount.damping": 0.05, "mount.gain": 0.3}
        values = {**with_own(own), **first, **second, "creepCount": 1}
        model = Model(values, ("mount", "creep", "resonance"), np.zeros(1), {})
        (other,) = in_other_roles(model)
        assert {n for n in values if values[n] != other.values[n]} == {
            *("mount.frequency", "mount.damping", "resonance.frequency", "resonance.damping")
        }
        assert other.values["resonance.frequency"] == 316.0 and other.values["mount.damping"] == 0.04
        assert other.effects == model.effects
        (back,) = in_other_roles(other)
        assert back.values == values


def test_effects_of_the_catalogue_have_roles_of_their_own():
    """A line in the reading and a resonance have frequencies, but no place in common."""
    assert in_other_roles(Model(dict(table_1()), tuple(EFFECTS), np.zeros(1), {})) == []
