"""Saturation of the amplifier.

For it speaks a residual that is confined to |u| beyond one level, where the displacement no longer
answers to the voltage at all; the tops of large cycles are flat.
"""

import casadi as ca
import numpy as np

from it2hys.effects import Clues, Extent, Scalar, Signature, Start, Surroundings, Values
from it2hys.effects._statistics import UM, Ground, absorbed, readable, rms


def is_on(parameters: Values) -> bool:
    """Return whether there are limits."""
    return parameters["saturation.minimum"] < parameters["saturation.maximum"]


def size(parameters: Values) -> int:
    """Return the number of states: none."""
    return 0


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input at rest, taken to be within the limits."""
    return y, []


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the voltage within the limits."""
    return ca.fmin(ca.fmax(x, values["saturation.minimum"]), values["saturation.maximum"]), []


def starts(extent: Extent) -> dict[str, Start]:
    """Start a tenth of the range within its ends; limits beyond the range cannot be seen."""
    low, high = extent.voltage
    middle, tenth = 0.5 * (low + high), 0.1 * extent.voltage_span
    return {
        "saturation.minimum": Start(low + tenth, low - tenth, middle),
        "saturation.maximum": Start(high - tenth, middle, high + tenth),
    }


def guesses(clues: Clues) -> list[dict[str, float]]:
    """Return limits at the upper end, at the lower end and at both."""
    low, high = clues.extent.voltage
    span, bounds = high - low, starts(clues.extent)
    none = bounds["saturation.minimum"].low, bounds["saturation.maximum"].high
    shares = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4)
    limits = [(none[0], high - s * span) for s in shares]
    limits += [(low + s * span, none[1]) for s in shares]
    limits += [(low + s * span, high - t * span) for s in shares[1::2] for t in shares[1::2]]
    return [{"saturation.minimum": a, "saturation.maximum": b} for a, b in limits]


def signature(clues: Clues) -> Signature | None:
    """Return whether the residual is confined to voltages beyond a level, where it falls behind them.

    The residual is regressed on what lies beyond several levels at the upper and at the lower end, once
    the model's own means are taken out; errors are spectral and by blocks (HAC), the p-value is corrected
    for the number of levels. The statistic is the share of the residual's power that the best explains.
    """
    seen, span = readable(clues), clues.extent.voltage_span
    if seen is None or span <= 0.0:
        return None
    shares = (0.03, 0.05, 0.08, 0.11, 0.14, 0.18, 0.22, 0.28)
    levels = [(clues.extent.voltage[1] - s * span, 1.0) for s in shares]
    levels += [(clues.extent.voltage[0] + s * span, -1.0) for s in shares]
    bank = [
        lambda c, v=v, side=side: -side * np.maximum(side * (c.voltage - v), 0.0) for v, side in levels
    ]
    chosen, trial = Ground(seen, [absorbed(seen)]).best(bank, positive=True)
    level, side = levels[chosen]
    beyond, within = (
        rms(
            np.concatenate(
                [c.residual[c.used & ((side * (c.voltage - level) > 0.0) == b)] for c in seen.records]
            )
        )
        for b in (True, False)
    )
    text = (
        f"{'Above' if side > 0.0 else 'Below'} {level:.3g} V the displacement falls behind the model the "
        f"further the voltage goes: residual {beyond * UM:.2g} um rms there, {within * UM:.2g} um elsewhere."
    )
    return Signature(trial.share, trial.p_value, text)
