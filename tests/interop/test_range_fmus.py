"""Whatever is asked of Table 1's FMUs, the plant stays put, and follows its inverse where that can."""

import numpy as np
import pytest
from conftest import UM
from hypothesis import given, settings
from hypothesis import strategies as st

from it2hys.cosimulation.simulation import simulate, track
from it2hys.errors import InputError

#: Ten seconds.
TICKS = 100_000
RANGE = 16 * UM


@given(
    start=st.floats(-0.1, 0.1) | st.floats(-64 * UM, 80 * UM),
    limit=st.floats(0.0, 220.0) | st.floats(0.0, 2000.0),
    kind=st.sampled_from(["up", "down", "random", "steps"]),
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=25)
def test_the_plant_stays_put(models, start, limit, kind, seed):
    rng = np.random.default_rng(seed)
    voltage = {
        "up": lambda: np.full(TICKS, limit),
        "down": lambda: np.full(TICKS, -limit),
        "random": lambda: rng.uniform(-limit, limit, TICKS),
        "steps": lambda: np.repeat(rng.uniform(-limit, limit, TICKS // 500), 500),
    }[kind]()
    try:
        outputs, messages = simulate(
            models["plant"].path, {"voltage": voltage}, {"initialDisplacement": start}
        )
    except InputError as refused:  # at initialization, not in the run
        assert "initialDisplacement" in str(refused)
        assert not -64 * UM <= start <= 80 * UM
        return
    displacement = outputs["displacement"]
    assert np.isfinite(displacement).all()
    assert np.abs(displacement).max() <= (5.0 if limit <= 220.0 else 25.0) * RANGE * (1 + 1e-9)
    outside = outputs["outOfRange"] != 0
    assert outside[(voltage < -1e-6) | (voltage > 110.0 + 1e-6)].all()
    assert len(messages) <= 2 + 1  # once for each of the two ranges, and the instance
    assert any("outOfRange" in m for m in messages) == outside.any()


@given(
    start=st.floats(-64 * UM, 80 * UM),
    references=st.lists(
        st.floats(0.0, RANGE) | st.sampled_from([0.0, RANGE, -1 * UM, RANGE + UM]),
        min_size=10,
        max_size=60,
    ),
)
@settings(max_examples=25)
def test_the_plant_follows_its_inverse_where_that_is_not_saturated(models, start, references):
    reference = np.array(references)
    result = track(
        models["inverse"].path, models["plant"].path, reference, {"initialDisplacement": start}
    )
    within = (reference >= 0.0) & (reference <= RANGE)
    reached = result["saturated"] == 0
    assert within[reached].all()
    # where it is not, the reference is beyond its range or the voltage at an end of its own
    at_end = np.isin(result["voltage"], (0.0, 110.0))
    assert (reached | at_end)[within].all()
    error = np.abs(result["displacement"] - reference)
    assert (error[reached] < 1e-9 * RANGE).all()


@pytest.mark.parametrize("voltage", [122.3, 130.0, 150.0, 2000.0])
def test_a_constant_voltage_beyond_what_10_has_an_equilibrium_for_settles(models, voltage):
    outputs, _ = simulate(models["plant"].path, {"voltage": np.full(TICKS, voltage)})
    last = outputs["displacement"][-1]
    assert RANGE < last < 14 * RANGE
    assert outputs["displacement"][-1000] == pytest.approx(last, rel=1e-12)
