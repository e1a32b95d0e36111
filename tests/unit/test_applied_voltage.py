"""The voltage that an inverse can know of: what the stages before the core let through."""

import numpy as np
import pytest

from it2hys.identification.inverse import applied_voltage
from it2hys.model import compiled
from it2hys.model.compiled import Drive
from it2hys.model.parameters import table_1

VOLTAGE = 40.0 - 40.0 * np.cos(np.arange(600) / 50.0)
LOSSES = {"saturation.minimum": 10.0, "saturation.maximum": 60.0, "delay.time": 3e-4}


def test_it_is_cut_off_and_late():
    late = np.concatenate([np.full(3, VOLTAGE[0]), VOLTAGE[:-3]])
    found = applied_voltage({**table_1(), **LOSSES}, Drive.of(VOLTAGE))
    np.testing.assert_allclose(found, np.clip(late, 10.0, 60.0), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("weight", [0.1, -0.9])
def test_what_the_core_makes_of_it_without_the_play_is_not_asked_for(weight):
    """A core that was fitted behind play gets other voltages without it, and may diverge there."""
    play = {"playCount": 1, "play[1].threshold": 0.0, "play[1].weight": weight}
    wild = {**table_1(), "rule[1].q1": 9.0, "rule[2].q1": 9.0, "rule[3].q1": 9.0}
    run, _, _ = compiled.chain_predict(compiled.pack_chain(wild), Drive.of(VOLTAGE))
    assert not np.isfinite(run).all()
    found = applied_voltage({**wild, **play}, Drive.of(VOLTAGE))
    np.testing.assert_allclose(found, VOLTAGE, rtol=0.0, atol=1e-12)
