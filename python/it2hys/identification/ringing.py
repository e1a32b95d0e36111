"""How long a record goes on ringing from what was before it."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter, lfiltic

from it2hys.policy import STARTS

#: First samples of a record in which its ringing is sought, and periods over which its height is taken.
_SOUGHT, _PERIODS = 400, 3
#: Shortest period, in samples, and least radius of the poles of what rings.
_SHORTEST, _LEAST_RADIUS = 2.5, 0.8


def ringing_out(voltage: np.ndarray, displacement: np.ndarray, noise: float) -> int:
    """Return after how many samples the ringing from before a record has sunk into its noise.

    No model that begins at rest can follow it, and it is larger than all that a fit may gain. 0 where
    there is none: where nothing rings, where all of it comes of the record's own voltage, or where it
    does not die away as a stage does, but goes on as a line does.

    Parameters
    ----------
    voltage, displacement : ndarray, shape (N,)
        In V and m.
    noise : float
        In m rms.
    """
    poles = _poles(voltage[:_SOUGHT], displacement[:_SOUGHT])
    if poles is None:
        return 0
    period, free = poles
    length = int(np.ceil(_PERIODS * period))
    longest = int(STARTS.longest_lead * len(voltage))
    end = min(_first_step(voltage), longest)
    heights = [_height(displacement[k : k + length], period) for k in range(0, end - length, length)]
    if not heights or heights[0] < STARTS.rings * noise:
        return 0
    if _height(free[:length], period) < 0.5 * heights[0]:
        return 0
    gone = np.flatnonzero(np.array(heights) <= noise)
    if len(gone):
        return int(gone[0]) * length
    # a step ends it, or the record is too short to tell it from a line
    return end if end < longest and _dies(heights) else 0


def _poles(x: np.ndarray, y: np.ndarray) -> tuple[float, np.ndarray] | None:
    """Return the period in samples of what rings and its free part, (N,); None where nothing does.

    A linear model of second order, fitted to one step ahead, has the poles of a resonance; what it
    leaves over when it begins at rest is the free part.
    """
    if len(y) < 10:
        return None
    rows = np.column_stack([y[1:-1], y[:-2], x[2:], x[1:-1], x[:-2], np.ones(len(y) - 2)])
    scale = np.maximum(np.abs(rows).max(axis=0), np.finfo(float).tiny)
    a1, a2, b0, b1, b2, constant = np.linalg.lstsq(rows / scale, y[2:], rcond=1e-12)[0] / scale
    if not (-1.0 < a2 < -(_LEAST_RADIUS**2) and a1**2 + 4.0 * a2 < 0.0):
        return None
    period = 2.0 * np.pi / np.arccos(a1 / (2.0 * np.sqrt(-a2)))
    if not _SHORTEST <= period <= len(y) / (2 * _PERIODS):
        return None
    rest = ((b0 + b1 + b2) * x[0] + constant) / (1.0 - a1 - a2)
    driven = np.convolve(np.concatenate([[x[0], x[0]], x]), [b0, b1, b2], "valid") + constant
    past = lfiltic([1.0], [1.0, -a1, -a2], [rest, rest])
    return float(period), y - lfilter([1.0], [1.0, -a1, -a2], driven, zi=past)[0]


def _height(part: np.ndarray, period: float) -> float:
    """Return the amplitude of a period in a part of a signal that also moves slowly."""
    k = np.arange(len(part))
    angle, slow = 2.0 * np.pi * k / period, np.linspace(-1.0, 1.0, len(part))
    rows = np.column_stack([np.cos(angle), np.sin(angle), np.ones(len(part)), slow, slow**2])
    return float(np.hypot(*np.linalg.lstsq(rows, part, rcond=None)[0][:2]))


def _first_step(voltage: np.ndarray) -> int:
    """Return at which sample the voltage first steps, which makes a stage ring anew."""
    steps = np.abs(np.diff(voltage)) > STARTS.slack * np.ptp(voltage)
    return int(np.argmax(steps)) if steps.any() else len(voltage)


def _dies(heights: list[float]) -> bool:
    """Return whether amplitudes fall as those of a stage do: by half or more, each below the last."""
    return len(heights) > 1 and heights[-1] < 0.5 * heights[0] and bool(np.all(np.diff(heights) < 0.0))
