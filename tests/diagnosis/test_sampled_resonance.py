"""A resonance is continuous: the product's sampled one against that of the independent simulator."""

import numpy as np
import pytest
from diagnosis import simulator as sim

from it2hys.model.effect import Surroundings
from it2hys.model.stages import EFFECTS
from it2hys.records.clues import Extent

TS = 1e-4
FREQUENCY, DAMPING = 930.0, 0.02
AROUND = Surroundings(0.0, 293.15, 0.0)
EXTENT = Extent(TS, 0.5, (0.0, 120.0), (0.0, 15e-6), (-10.0, 10.0), (288.0, 298.0))


def steps(count=1000):
    """Return steps and a sweep that excite the resonance."""
    ticks = np.arange(count)
    sweep = np.sin(2.0 * np.pi * (0.01 + 0.06 * ticks / count) * ticks)
    return np.where(ticks // 250 % 2, 4.0, 0.0) + np.where(ticks > 750, sweep, 0.0)


def sampled(x, delay, zero):
    """Return the product's resonance with a delay in ticks."""
    resonance = EFFECTS["resonance"]
    values = {
        "sampleTime": TS, "resonance.frequency": FREQUENCY, "resonance.damping": DAMPING,
        "resonance.samplingZero": zero, "resonance.samplingDelay": delay * TS,
    }  # fmt: skip
    _, state = resonance.rest(values, x[0])
    y = []
    for value in x:
        output, state = resonance.step(values, state, value, AROUND)
        y.append(float(output))
    return np.array(y)


@pytest.mark.parametrize("straight", [True, False], ids=["straight", "held"])
def test_with_a_part_of_a_tick_and_its_zero_it_is_the_continuous_one(straight):
    """Where the input is held, a part of a tick is all that it needs; otherwise the zero, too."""
    grid = sim.Grid(TS, 20, straight=straight)
    x = steps()
    around = sim.Surroundings(grid, np.arange(len(x)) * TS)
    truth = grid.sample(sim.Resonance(FREQUENCY, DAMPING).apply(grid.refine(x[None]), around))[0]

    def error(delay, zero):
        return float(np.std(sampled(x, delay, zero) - truth))

    poles = min(error(delay, 0.0) for delay in np.linspace(0.0, 2.0, 41))
    if straight:
        zero = EFFECTS["resonance"].starts(EXTENT)["resonance.samplingZero"].value
        assert error(0.789, zero) < 0.15 * poles and error(0.789, zero) < 0.01 * np.std(truth)
    else:
        assert poles < 0.002 * np.std(truth)
