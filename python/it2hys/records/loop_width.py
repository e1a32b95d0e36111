"""How wide a record's loop is: a piezo's own is narrow."""

from __future__ import annotations

import numpy as np

from it2hys.policy import READING
from it2hys.records.record import Record

#: Half of the band about the middle of the voltage's range in which the branches are read, as a share
#: of the range, and the fewest samples of each branch in it.
_BAND, _FEWEST = 0.05, 10


def wide_loop(record: Record) -> str:
    """Return a sentence on a loop that is too wide for a piezo's hysteresis, or nothing."""
    voltage, displacement = record.voltage, 1e6 * record.displacement
    low, high = voltage.min(), voltage.max()
    middle, rate = 0.5 * (low + high), np.gradient(voltage)
    near = (np.abs(voltage - middle) < _BAND * (high - low)) & ~record.outliers
    up, down = displacement[near & (rate > 0.0)], displacement[near & (rate < 0.0)]
    if min(len(up), len(down)) < _FEWEST:
        return ""
    rising, falling = float(np.mean(up)), float(np.mean(down))
    share = abs(rising - falling) / np.ptp(displacement[~record.outliers])
    if share < READING.wide_loop:
        return ""
    return (
        f"Record '{record.name}' has a very wide loop: at {middle:.3g} V the displacement is "
        f"{rising:.3g} µm on the way up and {falling:.3g} µm on the way down, {100 * share:.0f} % of "
        "its travel apart; a piezo's own hysteresis makes 10 to 20 %. The stage has a lag, a dead time "
        "or a resonance that is slow against the drive, or the record is not of a stage driven by a "
        "voltage: a damper's force over its velocity has such a loop, and this model is not for it."
    )
