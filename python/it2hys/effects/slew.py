"""Slew limit of the amplifier.

For it speaks a residual that is confined to spells in which |du/dt| was above one level, grows while
they last and, in large signals of high frequency only, turns sines into triangles.
"""

import casadi as ca
import numpy as np

from it2hys.effects import Clues, Extent, Scalar, Signature, Start, Surroundings, Values
from it2hys.effects.statistics import UM, Ground, absorbed, by_record, readable, rms, walked

#: What the effect is, in plain words.
MEANING = "the amplifier's voltage cannot change faster than at a certain rate"
#: What would show the effect apart from others.
EXPERIMENT = (
    "sines of one frequency and rising amplitude (beyond a slew limit they turn into triangles)"
)


def is_on(parameters: Values) -> bool:
    """Return whether there is a limit."""
    return parameters["slew.rate"] > 0.0


def size(parameters: Values) -> int:
    """Return the number of states: the last output."""
    return 1


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input at rest and the state."""
    return y, [y]


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the voltage, changed by the rate times the sample time at most, and the state."""
    most = values["slew.rate"] * values["sampleTime"]
    y = ca.fmin(ca.fmax(x, state[0] - most), state[0] + most)
    return y, [y]


def starts(extent: Extent) -> dict[str, Start]:
    """Start at the span in ten milliseconds; a tick for the span is no limit at all."""
    fastest = extent.voltage_span / extent.sample_time
    start = min(extent.voltage_span / 1e-2, 0.5 * fastest)
    return {"slew.rate": Start(start, 1e-6 * fastest, fastest)}


def guesses(clues: Clues) -> list[dict[str, float]]:
    """Return rates below those that the voltages ask for."""
    rates = np.concatenate([np.abs(np.diff(c.voltage)) for c in clues.records])
    rates = rates[rates > 1e-9 * clues.extent.voltage_span] / clues.extent.sample_time
    fastest = starts(clues.extent)["slew.rate"].high
    slowest = np.quantile(rates, 0.3)
    return [{"slew.rate": r} for r in np.geomspace(slowest, min(rates.max(), fastest), 24)[:-1]]


def signature(clues: Clues) -> Signature | None:
    """Return whether the residual is confined to spells in which the voltage changed too fast.

    The residual is regressed on what limits at several rates cut off the voltage, once the model's
    own means are taken out; errors are spectral and by blocks (HAC), the p-value is corrected for
    the number of rates. The statistic is the share of the residual's power that the best explains.
    """
    seen = readable(clues)
    rates = np.concatenate([np.abs(np.diff(c.voltage)) for c in clues.records])
    rates = rates[rates > 1e-9 * clues.extent.voltage_span]
    if seen is None or len(np.unique(rates)) < 2:
        return None
    levels = np.unique(np.quantile(rates, np.linspace(0.3, 0.99, 14)))
    start = np.array([np.full(len(levels), c.voltage[0]) for c in seen.records])
    limited = walked(seen, start, lambda y, x: y + np.clip(x - y, -levels, levels))
    cut = [y - c.voltage[:, None] for y, c in zip(limited, seen.records, strict=True)]
    bank = [by_record(seen, [x[:, j] for x in cut]) for j in range(len(levels))]
    chosen, trial = Ground(seen, [absorbed(seen)]).best(bank, positive=True)
    spell = [np.abs(x[:, chosen]) > 1e-6 * clues.extent.voltage_span for x in cut]
    inside, outside = (
        rms(
            np.concatenate(
                [c.residual[c.used & (s == side)] for c, s in zip(seen.records, spell, strict=True)]
            )
        )
        for side in (True, False)
    )
    text = (
        "The residual belongs to the spells in which a limit of "
        f"{levels[chosen] / clues.extent.sample_time:.3g} V/s would hold the voltage back: "
        f"{inside * UM:.2g} µm rms in them, {outside * UM:.2g} µm elsewhere."
    )
    return Signature(trial.share, trial.p_value, text)
