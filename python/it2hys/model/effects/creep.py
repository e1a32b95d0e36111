"""Creep: first-order terms, driven by the displacement above the sensor's zero and added to it."""

import math
from collections.abc import Mapping

import numpy as np

from it2hys.model.effect import Bounds, Effect, Memory, Scalar, Start, Surroundings, Values
from it2hys.policy import PHYSICS
from it2hys.records.clues import Extent
from it2hys.support.lazy import Lazy

ca = Lazy("casadi")

#: Terms that a fit begins with.
COUNT = 3


class Creep(Effect):
    """Slow motion after a change: first-order terms, each added by its gain."""

    memory = Memory.LONG
    per_record = ("initialCreep", "initialCreepAge")

    def is_on(self, parameters: Values) -> bool:
        """Return whether there are creep terms."""
        return parameters["creepCount"] > 0

    def size(self, parameters: Values) -> int:
        """Return the number of states: one per term."""
        return int(parameters["creepCount"])

    def rest(self, values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
        """Return the input and the states, `initialCreep` above it `initialCreepAge` ago.

        At 0 they are those after long rest.
        """
        zero, slope, ahead = values["displacementZero"], 1.0, []
        y = y - zero
        for i in range(1, int(values["creepCount"]) + 1):
            kept = _exp(-values["initialCreepAge"] / values[f"creep[{i}].timeConstant"])
            ahead.append(values["initialCreep"] * kept)
            y = y - values[f"creep[{i}].gain"] * ahead[-1]
            slope = slope + values[f"creep[{i}].gain"]
        return zero + y / slope, [y / slope + a for a in ahead]

    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the displacement with creep and the states; a state at a tick includes its input."""
        zero, states = values["displacementZero"], []
        x = x - zero
        y = x
        for i, last in enumerate(state, start=1):
            states.append(last + _part(values, i) * (x - last))
            y = y + values[f"creep[{i}].gain"] * states[-1]
        return zero + y, states

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the displacement without creep: given the states, creep is affine in it."""
        zero, slope = values["displacementZero"], 1.0
        y = y - zero
        for i, last in enumerate(state, start=1):
            gain, part = values[f"creep[{i}].gain"], _part(values, i)
            y = y - gain * (last - part * last)
            slope = slope + gain * part
        return zero + y / slope, state

    def starts(self, extent: Extent, count: int = COUNT) -> dict[str, Start]:
        """Start at 2 % per term, time constants spread evenly in their logarithm over the record."""
        fastest = PHYSICS.dynamics_longest * extent.sample_time
        slowest = max(extent.duration, 10.0 * fastest)
        spread = np.geomspace(fastest, slowest, count + 2)[1:-1]
        result = {}
        for i, time_constant in enumerate(spread, start=1):
            result[f"creep[{i}].gain"] = Start(0.02, 0.0, PHYSICS.slow_gain)
            # a slower term is a slope in the records: a larger gain goes with a larger time constant
            result[f"creep[{i}].timeConstant"] = Start(
                float(time_constant), fastest, 10.0 * slowest, seen=slowest
            )
        result["initialCreep"] = Start(0.0, -extent.displacement_span, extent.displacement_span)
        result["initialCreepAge"] = Start(0.0, 0.0, slowest)
        return result

    def starts_of(self, values: Mapping, extent: Extent) -> dict[str, Start]:
        """Return starts of as many terms."""
        return self.starts(extent, int(values["creepCount"]))

    def bounds_of_record(
        self, name: str, bounds: Bounds, begins: np.ndarray, travel: tuple[float, float]
    ) -> Bounds:
        """Return how far ahead the states may be: creep has not been beyond the travel."""
        if name == "initialCreepAge":
            return bounds
        return travel[0] - begins, travel[1] - begins


def _exp(exponent: Scalar) -> Scalar:
    """Return the exponential, of a number without CasADi: FMUs are packaged where there is none."""
    return math.exp(exponent) if isinstance(exponent, float) else ca.exp(exponent)


def _part(values: Values, term: int) -> Scalar:
    """Return the part of its way that a term goes in a tick."""
    return -ca.expm1(-values["sampleTime"] / values[f"creep[{term}].timeConstant"])


EFFECT = Creep()
