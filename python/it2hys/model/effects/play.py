"""Rate-independent memory in front of the core: play operators, Prandtl-Ishlinskii."""

from collections.abc import Mapping

import numpy as np

from it2hys.model.effect import Effect, History, Memory, Scalar, Start, Surroundings, Values
from it2hys.records.clues import Extent
from it2hys.support.lazy import Lazy

ca = Lazy("casadi")

#: Operators that a fit begins with, and those beyond half the voltage's span, for initial curves.
COUNT, INITIAL = 10, 3

#: Last turning points that are tried, as shares of the way from the lowest to the highest voltage.
_TURNS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25)


class Play(Effect):
    """Rate-independent memory of the voltage's turning points: a weighted sum of play operators."""

    memory = Memory.LONG
    per_record = ("initialDemagnetisation", "initialExcursion")

    def is_on(self, parameters: Values) -> bool:
        """Return whether there are play operators."""
        return parameters["playCount"] > 0

    def size(self, parameters: Values) -> int:
        """Return the number of states: an output per operator."""
        return int(parameters["playCount"])

    def rest(self, values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
        """Return input and states at rest at the output y, after the history.

        Demagnetised, driven to the turning point, and from there to where the output is y.
        """
        new = values["initialDemagnetisation"]
        turn = new + values["initialExcursion"]
        thresholds = [threshold for threshold, _ in _elements(values, int(values["playCount"]))]
        turned = [_moved(new, threshold, turn) for threshold in thresholds]
        x, _ = self.inverse(values, turned, y, None)
        return x, [_moved(p, threshold, x) for p, threshold in zip(turned, thresholds, strict=True)]

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the core's input and the operators' outputs."""
        y, outputs = x, []
        for (threshold, weight), last in zip(_elements(values, len(state)), state, strict=True):
            output = _moved(last, threshold, x)
            y = y + weight * output
            outputs.append(output)
        return y, outputs

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the voltage, by a walk from where no operator moves to the segment that holds y."""
        elements = _elements(values, len(state))
        held = y
        for (_, weight), output in zip(elements, state, strict=True):
            held = held - weight * output
        side = ca.if_else(held > state[0], 1.0, -1.0)
        x, slope, goes_on = held, 1.0, 1.0
        for (threshold, weight), output in zip(elements, state, strict=True):
            corner = output + side * threshold
            goes_on = ca.logic_and(goes_on, side * (x - corner) > 0.0)
            held = ca.if_else(goes_on, held + weight * corner, held)
            slope = ca.if_else(goes_on, slope + weight, slope)
            x = ca.if_else(goes_on, held / slope, x)
        return x, state

    def ordered(self, values: Mapping) -> dict:
        """Return the values with the operators in the order of their thresholds."""
        count = int(values.get("playCount", 0))
        ordered = dict(values)
        for j, (threshold, weight) in enumerate(sorted(_elements(values, count)), start=1):
            ordered[f"play[{j}].threshold"], ordered[f"play[{j}].weight"] = threshold, weight
        return ordered

    def starts(self, extent: Extent, count: int = COUNT) -> dict[str, Start]:
        """Start with equal weights, and without a turning point before the record.

        The thresholds are held (see `thresholds`): with enough of them a fit of the weights alone
        comes as near to any memory, and is far better posed.
        """
        low, high = extent.voltage
        far = 2.0 * extent.voltage_span
        # new at 0 V, or demagnetised in the records' range
        demagnetised = Start(0.0, min(low, 0.0), max(high, 0.0))
        weights = {f"play[{j}].weight": Start(0.3 / count, 0.0, 5.0) for j in range(1, count + 1)}
        return {
            **weights,
            "initialDemagnetisation": demagnetised,
            "initialExcursion": Start(0.0, -far, far),
        }

    def starts_of(self, values: Mapping, extent: Extent) -> dict[str, Start]:
        """Return starts of as many operators."""
        return self.starts(extent, int(values["playCount"]))

    def roughness(self, values: Mapping, units: Mapping[str, float]) -> np.ndarray:
        """Return the second differences of the density of operators, as mean weight per operator.

        A stack's memory has a smooth density over the thresholds. A few loops do not determine each
        weight by itself: weights that go up and down fit them, and fail on others.
        """
        count = int(values["playCount"])
        if count < 3 or "play[1].weight" not in units:
            return super().roughness(values, units)
        elements = range(1, count + 1)
        width = np.gradient(np.array([0.0, *(values[f"play[{j}].threshold"] for j in elements)]))[1:]
        names = list(units)
        places = [names.index(f"play[{j}].weight") for j in elements]
        own = [units[f"play[{j}].weight"] for j in elements]
        density = np.zeros((count, len(units)))
        density[np.arange(count), places] = np.array(own) * np.mean(width) / width
        return np.diff(density, 2, axis=0)

    def histories(self, voltage: np.ndarray) -> list[History]:
        """Return rests and excursions before a record.

        The stack was new or demagnetised at 0 V or at the record's first voltage, and may then have
        been driven somewhere within or a little beyond the record's range. An excursion has to show.
        """
        low, high = voltage.min(), voltage.max()
        turns = [low + share * (high - low) for share in _TURNS]
        likely = [(rest, turn - rest) for rest in (0.0, voltage[0]) for turn in (rest, *turns)]
        return [
            History(dict(zip(self.per_record, history, strict=True)), history[1] != 0.0)
            for history in dict.fromkeys(likely)
        ]


def thresholds(extent: Extent, initial: bool = False) -> dict[str, float]:
    """Return thresholds over half the voltage's span, closer where small.

    In loops none beyond it engages. On the initial curve of a stage that was new or demagnetised at 0 V
    all up to the voltage do: with `initial`, some are put up to the farthest voltage from there, too.
    """
    half, farthest = 0.5 * extent.voltage_span, reach(extent)
    values = half * (np.arange(1, COUNT + 1) / (COUNT + 1)) ** 1.5
    if initial:
        values = [*values, *np.linspace(half, farthest, INITIAL, endpoint=False)]
    return {f"play[{j}].threshold": float(r) for j, r in enumerate(values, start=1)}


def reach(extent: Extent) -> float:
    """Return the largest threshold that records may engage, V: on the initial curve from 0 V."""
    farthest = max(map(abs, extent.voltage))
    return float(np.clip(farthest, 0.5 * extent.voltage_span, extent.voltage_span))


def _elements(values: Values, count: int) -> list[tuple[Scalar, Scalar]]:
    return [(values[f"play[{j}].threshold"], values[f"play[{j}].weight"]) for j in range(1, count + 1)]


def _moved(p: Scalar, threshold: Scalar, x: Scalar) -> Scalar:
    """Return an operator's output once the input is x."""
    return ca.fmin(ca.fmax(p, x - threshold), x + threshold)


EFFECT = Play()
