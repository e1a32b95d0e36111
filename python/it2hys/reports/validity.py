"""Samples beyond the range that a model holds for, in words."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

_UM = 1e6


def out_of_range_sentence(
    ends: Mapping[str, float],
    outside: np.ndarray,
    voltage: np.ndarray,
    displacement: np.ndarray,
) -> str | None:
    """Return how many samples of a run are beyond the range, which range that is, and how far they are.

    Parameters
    ----------
    ends : mapping of str to float
        `voltageMin`, `voltageMax`, `displacementMin` and `displacementMax`, such as a `ParameterSet`.
    outside : ndarray of bool, shape (N,)
        `outOfRange` of the plant FMU.
    voltage, displacement : ndarray, shape (N,)
        In V and m.

    Returns
    -------
    str or None
        None where no sample is.
    """
    outside = np.asarray(outside, dtype=bool)
    if not outside.any():
        return None
    x, y = np.asarray(voltage)[outside], _UM * np.asarray(displacement)[outside]
    low, high = _UM * ends["displacementMin"], _UM * ends["displacementMax"]
    return (
        f"{np.count_nonzero(outside)} of {len(outside)} samples are outside the range of the model, "
        f"{ends['voltageMin']:.4g} to {ends['voltageMax']:.4g} V and {low:.4g} to {high:.4g} µm of "
        f"its core: there the voltage is {x.min():.4g} to {x.max():.4g} V and the displacement, which "
        f"is extrapolated, {y.min():.4g} to {y.max():.4g} µm."
    )
