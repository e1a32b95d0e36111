"""Records of a stage under a controller: play, the paper's fuzzy model, a noisy sensor."""

from __future__ import annotations

import numpy as np
from diagnosis import simulator as sim

#: Ticks before a record in which the controller comes to the first reference.
_BEFORE = 1500
_LARGEST = 150.0


def regulate(
    reference: np.ndarray,
    rng: np.random.Generator,
    proportional: float,
    integral: float,
    *,
    ticks_late: int = 1,
    noise: float = 0.006,
    operators: int = 12,
) -> tuple[np.ndarray, np.ndarray]:
    """Return voltage, V, and reading, um, of a stage that a PI controller holds to a reference.

    Parameters
    ----------
    reference : ndarray, shape (N,)
        Desired displacement, um.
    rng : numpy.random.Generator
        Of the sensor's noise.
    proportional, integral : float
        Gains, V/um and V/um per tick.
    ticks_late : int
        Ticks from a reading to the voltage that answers it.
    noise : float
        Of the sensor, um rms.
    operators : int
        Of the play before the core.
    """
    play = sim.Play("exponential", 20.0, 0.6, sim.PAPER_VOLTAGE, operators)
    thresholds, weights = play.elements()
    memory = np.zeros(operators)
    y = float(sim.equilibrium(sim.TABLE_1, np.array([0.0]))[0])
    readings, summed = [y] * ticks_late, 0.0
    wanted = np.concatenate([np.full(_BEFORE, reference[0]), reference])
    voltage, reading = np.empty((2, len(wanted)))
    for k, target in enumerate(wanted):
        error = target - readings[-ticks_late]
        summed += integral * error
        voltage[k] = np.clip(proportional * error + summed, 0.0, _LARGEST)
        memory = np.clip(memory, voltage[k] - thresholds, voltage[k] + thresholds)
        acting = (1.0 - play.share) * voltage[k] + play.share * float(memory @ weights)
        y = float(sim.advance(sim.TABLE_1, np.array(y), np.array(acting)))
        reading[k] = y + noise * rng.standard_normal()
        readings.append(reading[k])
    return voltage[_BEFORE:], reading[_BEFORE:]
