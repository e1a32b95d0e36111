"""Mechanical resonance, exact poles and no zeros.

For it speaks ringing at one frequency after steps and corners, and a coherent peak of the residual's
transfer from the voltage there, at every amplitude; below it, the residual grows with the square of
frequency and is in phase.
"""

import math

import casadi as ca
import numpy as np
from scipy.signal import find_peaks

from it2hys.effects import Clues, Extent, Scalar, Start, Surroundings, Values

#: What would show the effect apart from others.
EXPERIMENT = "small steps, or a small chirp through the band (a resonance rings at one frequency)"


def is_on(parameters: Values) -> bool:
    """Return whether there is a resonance."""
    return parameters["resonance.frequency"] > 0.0


def size(parameters: Values) -> int:
    """Return the number of states: the last two outputs."""
    return 2


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input at rest and the states."""
    return y, [y, y]


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the resonating displacement and the last two."""
    damping = values["resonance.damping"]
    angle = 2.0 * math.pi * values["resonance.frequency"] * values["sampleTime"]
    radius = ca.exp(-damping * angle)
    a1 = 2.0 * radius * ca.cos(angle * ca.sqrt(1.0 - damping * damping))
    a2 = -radius * radius
    y = a1 * state[0] + a2 * state[1] + (1.0 - a1 - a2) * x
    return y, [y, state[0]]


def starts(extent: Extent) -> dict[str, Start]:
    """Start at a quarter of the Nyquist frequency; the peak of the residual's spectrum is better."""
    nyquist = 0.5 / extent.sample_time
    return {
        "resonance.frequency": Start(0.25 * nyquist, 1e-3 * nyquist, 0.98 * nyquist),
        "resonance.damping": Start(0.05, 1e-3, 0.95),
    }


def guesses(clues: Clues) -> list[dict[str, float]]:
    """Return frequencies over the whole band, and those at which the residual peaks."""
    nyquist = 0.5 / clues.extent.sample_time
    frequency, power = clues.spectrum(400)
    peaks, _ = find_peaks(np.log(power + np.finfo(float).tiny), distance=10)
    highest = peaks[np.argsort(power[peaks])[::-1][:6]]
    spread = np.geomspace(0.01, 0.9, 40) * nyquist
    frequencies = [*spread, *frequency[highest]]
    return [
        {"resonance.frequency": f, "resonance.damping": d}
        for f in frequencies
        if f > 2e-3 * nyquist
        for d in (0.02, 0.1, 0.5)
    ]
