"""Weights of the records in a joint fit: by noise, and by what they repeat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from it2hys.identification.criterion import Trace
from it2hys.identification.noise import find_period
from it2hys.identification.preparation import Prepared

#: Weights that differ by less than this factor are left equal.
_NEGLIGIBLE = 1.5


def repetitions(prepared: Prepared) -> float:
    """Return how often a record repeats the same period, 1 where its drive is not periodic."""
    voltage = prepared.record.voltage[prepared.skip :]
    period = find_period(voltage)
    return 1.0 if period is None else len(voltage) / period


def weigh(
    traces: Sequence[Trace], prepared: Sequence[Prepared], misfit: float, unit: float
) -> list[Trace] | None:
    """Return the records weighted by what every record tells, or None if all are alike.

    Parameters
    ----------
    traces, prepared : sequence
        The training records.
    misfit : float
        Root mean square of what the model does not describe, beyond the noise, m.
    unit : float
        Displacement in m that is 1 in scaled units.

    Notes
    -----
    Averaging n equal periods lowers the noise but not the model's own error, which is the same in
    each. A period's mean has the variance noise^2 / n + misfit^2, so each of its n repetitions gets
    the weight 1 / (noise^2 + n misfit^2): noise decides for a good model, novelty for a poor one.
    """
    variance = np.array([p.noise.rms**2 + repetitions(p) * misfit**2 for p in prepared])
    floor = (1e-9 * unit) ** 2
    weights = 1.0 / np.sqrt(variance + floor)
    if weights.max() < _NEGLIGIBLE * weights.min():
        return None
    counts = np.array([np.count_nonzero(t.weight) for t in traces])
    weights /= np.sqrt(np.average(weights**2, weights=counts))
    return [replace(t, weight=w * (t.weight > 0)) for t, w in zip(traces, weights, strict=True)]
