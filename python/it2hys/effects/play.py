"""Rate-independent memory in front of the core: play operators, Prandtl-Ishlinskii.

For it speaks a residual whose loop area does not depend on frequency: it is there in the slowest
cycles, where every lag closes; and minor loops within a cycle that remember where the voltage turned.
"""

import casadi as ca
import numpy as np

from it2hys.effects import Clues, Extent, Scalar, Signature, Start, Surroundings, Values
from it2hys.effects.statistics import UM, Ground, absorbed, by_record, loop_widths, readable, walked

MAX_COUNT = 16
#: Operators that a fit begins with.
COUNT = 10

#: What the effect is, in plain words.
MEANING = "memory of the voltage's turning points, with loops that are as wide slow as fast"
#: What would show the effect apart from others.
EXPERIMENT = (
    "slow loops of several amplitudes, each at two frequencies (memory keeps the area of its loops)"
)


def is_on(parameters: Values) -> bool:
    """Return whether there are play operators."""
    return parameters["playCount"] > 0


def size(parameters: Values) -> int:
    """Return the number of states: an output per operator."""
    return int(parameters["playCount"])


def _elements(values: Values, count: int) -> list[tuple[Scalar, Scalar]]:
    return [(values[f"play[{j}].threshold"], values[f"play[{j}].weight"]) for j in range(1, count + 1)]


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return input and states at rest at the output y, after the history.

    Play operators know differences of voltages only: the history is walked with rest at 0.
    """
    offset = values["initialRestOffset"]
    turn = offset + values["initialExcursion"]
    above, held, slope = [], y, 1.0
    for threshold, weight in _elements(values, int(values["playCount"])):
        above.append(_moved(_moved(offset, threshold, turn), threshold, 0.0))
        held = held - weight * above[-1]
        slope = slope + weight
    x = held / slope
    return x, [x + p for p in above]


def _moved(p: Scalar, threshold: Scalar, x: Scalar) -> Scalar:
    """Return an operator's output once the input is x."""
    return ca.fmin(ca.fmax(p, x - threshold), x + threshold)


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the core's input and the operators' outputs."""
    y, outputs = x, []
    for (threshold, weight), last in zip(_elements(values, len(state)), state, strict=True):
        output = _moved(last, threshold, x)
        y = y + weight * output
        outputs.append(output)
    return y, outputs


def starts(extent: Extent, count: int = COUNT) -> dict[str, Start]:
    """Start with equal weights, and without a turning point before the record.

    The thresholds are held (see `thresholds`): with enough of them a fit of the weights alone comes as
    near to any memory, and is far better posed.
    """
    low, high = extent.voltage
    far = 2.0 * extent.voltage_span
    # new at 0 V or demagnetised in the records' range, and at rest anywhere in that
    offsets = Start(0.0, min(low, 0.0) - high, max(high, 0.0) - low)
    weights = {f"play[{j}].weight": Start(0.3 / count, 0.0, 5.0) for j in range(1, count + 1)}
    return {
        **weights,
        "initialRestOffset": offsets,
        "initialExcursion": Start(0.0, -far, far),
    }


def thresholds(extent: Extent, count: int = COUNT) -> dict[str, float]:
    """Return thresholds over half the voltage's span, beyond which none engages; closer where small."""
    share = np.arange(1, count + 1) / (count + 1)
    values = 0.5 * extent.voltage_span * share**1.5
    return {f"play[{j}].threshold": float(r) for j, r in enumerate(values, start=1)}


def guesses(clues: Clues, count: int = COUNT) -> list[dict[str, float]]:
    """Return equal weights, for hardly any, a weak and a strong memory."""
    held = {"playCount": count, **thresholds(clues.extent, count)}
    return [
        {**held, **{f"play[{j}].weight": total / count for j in range(1, count + 1)}}
        for total in (0.01, 0.1, 0.4)
    ]


def signature(clues: Clues) -> Signature | None:
    """Return whether the residual remembers where the voltage turned, however slow or fast it moves.

    The residual is regressed on the outputs of three play operators, which know no time, once the
    model's own means are taken out; errors are spectral and by blocks (HAC). The statistic is the
    share of the residual's power that they explain. Loops are told of the slowest cycles: in fast
    ones the model, fitted without play, has made up for them.
    """
    seen = readable(clues)
    if seen is None or clues.extent.voltage_span <= 0.0:
        return None
    thresholds = np.array([0.04, 0.12, 0.25]) * clues.extent.voltage_span
    start = np.array(
        [np.clip(0.0, c.voltage[0] - thresholds, c.voltage[0] + thresholds) for c in seen.records]
    )
    outputs = walked(seen, start, lambda y, x: np.clip(y, x - thresholds, x + thresholds))
    trial = Ground(seen, [absorbed(seen)]).test(by_record(seen, outputs))
    frequency, width = loop_widths(seen)
    text = f"Play of the voltage explains {100 * trial.share:.0f} % of the residual's power"
    if len(width) >= 4:
        slow = frequency <= np.quantile(frequency, 0.25)
        text += (
            f"; in the slowest cycles (up to {np.max(frequency[slow]):.3g} Hz), where lags close, the "
            f"residual's loops over the voltage are {np.median(width[slow]) * UM:.2g} µm wide"
        )
    return Signature(trial.share, trial.p_value, text + ".")
