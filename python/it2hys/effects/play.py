"""Rate-independent memory in front of the core: play operators, Prandtl-Ishlinskii.

For it speaks a residual whose loop area does not depend on frequency: it is there in the slowest
cycles, where every lag closes; and minor loops within a cycle that remember where the voltage turned.
"""

import casadi as ca

from it2hys.effects import Extent, Scalar, Start, Surroundings, Values

MAX_COUNT = 16


def is_on(parameters: Values) -> bool:
    """Return whether there are play operators."""
    return parameters["playCount"] > 0


def size(parameters: Values) -> int:
    """Return the number of states: an output per operator."""
    return int(parameters["playCount"])


def _elements(values: Values, count: int) -> list[tuple[Scalar, Scalar]]:
    return [(values[f"play[{j}].threshold"], values[f"play[{j}].weight"]) for j in range(1, count + 1)]


def rest(values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
    """Return the input and the states on the initial loading curve: from 0 straight to the output."""
    elements = _elements(values, int(values["playCount"]))
    side = ca.if_else(y < 0, -1.0, 1.0)
    total, slope, x = ca.fabs(y), 1.0, ca.fabs(y)
    for threshold, weight in elements:
        engaged = x > threshold
        total = ca.if_else(engaged, total + weight * threshold, total)
        slope = ca.if_else(engaged, slope + weight, slope)
        x = total / slope
    return side * x, [side * ca.fmax(x - threshold, 0.0) for threshold, _ in elements]


def step(
    values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[Scalar, list[Scalar]]:
    """Return the core's input and the operators' outputs."""
    y, outputs = x, []
    for (threshold, weight), last in zip(_elements(values, len(state)), state, strict=True):
        output = ca.fmin(ca.fmax(last, x - threshold), x + threshold)
        y = y + weight * output
        outputs.append(output)
    return y, outputs


def starts(extent: Extent, count: int = 6) -> dict[str, Start]:
    """Start with equal weights at thresholds spread over half the span, beyond which none engages."""
    half = 0.5 * extent.voltage_span
    result = {}
    for j in range(1, count + 1):
        result[f"play[{j}].threshold"] = Start(half * j / (count + 1), 0.0, half)
        result[f"play[{j}].weight"] = Start(0.3 / count, -0.9 / count, 5.0)
    return result
