"""Whether the displacement runs ahead of its voltage, which no stage does.

A stage lags: in the plane of voltage and displacement its loops are run through such that the
work ``integral of voltage d(displacement)`` is positive, whether the lag comes of hysteresis,
creep, inertia or delay. Exchanged columns turn the sign of every loop.
"""

import numpy as np

from it2hys.policy import RESPONSE


def samples_ahead(voltage: np.ndarray, displacement: np.ndarray) -> int:
    """Return by about how many samples the displacement leads; 0 where that is not certain.

    The record is cut where the voltage passes its mean. Between two such cuts the voltage goes
    out and comes back, so a single-valued curve, however bent, encloses no area; a drift of the
    displacement adds areas of alternating signs, and noise areas of random ones. Nothing is said
    of records with a negative correlation: a reversed sensor that leads looks like a true one
    above the resonance.

    Parameters
    ----------
    voltage, displacement : numpy.ndarray, shape (n,)
        The signals, neither of them constant, in any unit.

    Returns
    -------
    int
        The lead, to be understood as that of a sine of the record's mean period.
    """
    if np.corrcoef(voltage, displacement)[0, 1] < RESPONSE.ahead_correlation:
        return 0
    cuts = _mean_crossings(voltage)
    if len(cuts) <= RESPONSE.ahead_loops or np.diff(cuts).mean() < RESPONSE.ahead_samples:
        return 0
    # The displacement at tick k may have been read at either end of the interval in which
    # voltage[k] acted. Pairing it with the later end is half a sample in its favour.
    change = np.diff(displacement)
    area = _between((voltage[1:] - voltage.mean()) * change, cuts)
    rectangle = _ranges(voltage, cuts) * _ranges(displacement, cuts)
    agreeing = rectangle[area < 0.0].sum()
    if agreeing == 0.0 or agreeing < RESPONSE.ahead_agreement * rectangle.sum():
        return 0
    if -area.sum() < RESPONSE.ahead * rectangle.sum():
        return 0
    # Two sines of angular frequency w per sample and a phase p apart: tan(p) is w times this ratio.
    w = np.pi / np.diff(cuts).mean()
    product = _between(np.diff(voltage) * change, cuts)
    return round(np.arctan2(-area.sum() * w, product.sum()) / w + 0.5)


def _mean_crossings(values: np.ndarray) -> np.ndarray:
    """Return the first samples on either side of the mean, after a clear crossing (not noise)."""
    centred = values - values.mean()
    clear = np.flatnonzero(np.abs(centred) > 0.05 * np.ptp(values))
    return clear[1:][np.diff(np.sign(centred[clear])) != 0.0]


def _between(steps: np.ndarray, cuts: np.ndarray) -> np.ndarray:
    """Return the sum of the steps from each cut to the next; steps[k] leads to sample k + 1."""
    return np.diff(np.cumsum(steps)[cuts - 1])


def _ranges(values: np.ndarray, cuts: np.ndarray) -> np.ndarray:
    """Return the peak-to-peak value from each cut to the next, both included."""
    last = values[cuts[1:]]
    highest = np.maximum(np.maximum.reduceat(values, cuts)[:-1], last)
    lowest = np.minimum(np.minimum.reduceat(values, cuts)[:-1], last)
    return highest - lowest
