"""The inverse on the reading of a stage that rings: it goes beyond where the stage comes to rest."""

import numpy as np
import pytest
from casadi_runs import around, assert_same, run
from conftest import UM

import it2hys
from it2hys.identification.inverse import applied_voltage
from it2hys.model import compiled
from it2hys.model.compiled import Drive
from it2hys.model.parameters import ParameterSet, table_1

TICKS = 400


def ringing(delay: float = 0.0) -> ParameterSet:
    """Return Table 1 up to 13 um on a stage that rings at 500 Hz, read `delay` ticks late."""
    ring = {
        "resonance.frequency": 500.0,
        "resonance.damping": 0.02,
        "resonance.samplingZero": -0.1,
        "resonance.samplingDelay": delay * 1e-4,
    }
    return table_1().replace(**ring, displacementMax=13 * UM).validate()


def steps() -> np.ndarray:
    """Return voltages that are held, the first of them that of rest, V."""
    rest = compiled.chain_inverse_run(ringing(), np.array([0.0]))[0][0]
    return np.repeat([rest, 85.0, 5.0, 60.0, 20.0], TICKS)


def test_a_ring_beyond_the_range_is_no_reference_out_of_reach():
    parameters, voltage = ringing(), steps()
    reading, _ = compiled.chain_free_run(parameters, voltage)
    assert reading.max() > 15 * UM and reading.min() < -0.8 * UM
    found, saturated = compiled.chain_inverse_run(parameters, reading)
    np.testing.assert_allclose(found, voltage, atol=1e-6)
    assert not saturated.any()


def test_casadi_takes_the_same_references():
    reading, _ = compiled.chain_free_run(ringing(), steps())
    reference = np.concatenate([reading, reading - 20 * UM, reading + 20 * UM, reading])
    chain, others = it2hys.casadi_chain(ringing()), around(len(reference))
    found = run(chain.inverse, chain.rest()["inverse_state"], reference=reference, **others)
    voltage, saturated = compiled.chain_inverse_run(
        ringing(), reference, others["force"], others["temperature"]
    )
    assert_same(found["voltage"], voltage)
    assert np.array_equal(found["saturated"] != 0.0, saturated)
    assert saturated[len(reading) : 3 * len(reading)].any()


def test_a_reference_farther_out_than_a_ring_is_clamped():
    voltage, saturated = compiled.chain_inverse_run(ringing(), np.full(TICKS, 40 * UM))
    assert saturated.all() and voltage.max() <= 110.0


@pytest.mark.parametrize("delay", [0.0, 0.5, 1.0, 1.5])
def test_a_reading_that_comes_late_is_no_error_of_the_inverse(delay):
    """What a stage behind the core delays, no inverse makes up for, and no figure counts."""
    parameters, voltage = ringing(delay), steps()
    reading, _ = compiled.chain_free_run(parameters, voltage)
    error = compiled.chain_inverse_run(parameters, reading)[0] - applied_voltage(
        parameters, Drive.of(voltage)
    )
    assert np.sqrt(np.mean(error**2)) < 0.02
