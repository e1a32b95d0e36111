"""The whole chain from voltage to displacement and reading, and its inverse, as CasADi functions.

    voltage -> [delay] -> [slew] -> [saturation] -> [lag] -> [play] -> IT2 core
            -> [load] -> [creep] -> [resonance] -> [drift] -> [nonlinearity] -> displacement
            -> [hum] -> measured

A parameter set says which effects are on, how many elements they have and how many whole ticks the
delay has: that is the chain's structure. Within it every Real parameter is an argument, so that CasADi
derives every derivative. `it2hys.model.compiled` computes the same numbers in C.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import casadi as ca
import numpy as np

from it2hys.model import it2
from it2hys.model.chain_inverse import Aim, inverse_tick
from it2hys.model.compiled import REST_TEMPERATURE
from it2hys.model.effect import Memory, Scalar, Surroundings
from it2hys.model.parameters import RULE_FIELDS, ParameterSet
from it2hys.model.stages import BEFORE_CORE, BEHIND_CORE, EFFECTS, READING
from it2hys.model.variables import load_table


def active_effects(parameters: ParameterSet) -> list[str]:
    """Return the names of the effects that a set has, in the order of the chain."""
    return [name for name, effect in EFFECTS.items() if effect.is_on(parameters)]


class Chain:
    """The chain that a parameter set describes.

    Parameters
    ----------
    parameters : ParameterSet
        Gives the structure, and the values where none are given.

    Attributes
    ----------
    names : list of str
        The Real parameters, in the order of the functions' argument `p`.
    effects : list of str
        The effects that are on, in the order of the chain.
    """

    def __init__(self, parameters: ParameterSet) -> None:
        known = load_table().parameters()
        self.parameters = parameters
        self.names = [n for n in parameters if known[n].type.base == "Real"]
        self.effects = active_effects(parameters)
        self._sizes = {name: EFFECTS[name].size(parameters) for name in self.effects}

        # whose last ticks the inverse keeps twice: as it aimed at, and as the plant reached
        self._aimed = [n for n in self.effects if EFFECTS[n].memory is Memory.AIMED]

    @property
    def state_size(self) -> int:
        """Number of states: the core's, then those of the effects."""
        return 1 + sum(self._sizes.values())

    @property
    def inverse_state_size(self) -> int:
        """Number of states of the inverse: those that it aims at, then those that the plant reached."""
        return self.state_size + 1 + sum(self._sizes[name] for name in self._aimed)

    def vector(self, parameters: ParameterSet | None = None) -> np.ndarray:
        """Return the argument `p` of a set of the same structure; by default of the chain's own."""
        parameters = parameters or self.parameters
        return np.array([parameters[name] for name in self.names])

    @cached_property
    def step(self) -> ca.Function:
        """(p, state, voltage, force, temperature, time) -> (next state, displacement, measured)."""
        p, values = self._symbols()
        state = ca.SX.sym("state", self.state_size)
        inputs = [ca.SX.sym(name) for name in ("voltage", "force", "temperature", "time")]
        following, displacement, measured = self._step(values, state, inputs)
        return ca.Function(
            "chain_step",
            [p, state, *inputs],
            [following, displacement, measured],
            ["p", "state", "voltage", "force", "temperature", "time"],
            ["next_state", "displacement", "measured"],
        )

    @cached_property
    def rest(self) -> ca.Function:
        """P -> state at rest at `initialDisplacement`, before the first tick."""
        p, values = self._symbols()
        return ca.Function("chain_rest", [p], [self._rest(values)], ["p"], ["state"])

    @cached_property
    def inverse(self) -> ca.Function:
        """(p, state, reference, force, temperature, time) -> (next state, voltage, saturated)."""
        p, values = self._symbols()
        state = ca.SX.sym("state", self.inverse_state_size)
        reference, *around = (ca.SX.sym(n) for n in ("reference", "force", "temperature", "time"))
        own, reached = ca.vertsplit(state, [0, self.state_size, self.inverse_state_size])
        before = Aim(own[0], dict(zip(self.effects, self._split(own), strict=True)))
        plant = Aim(reached[0], dict(zip(self._aimed, self._split(reached, self._aimed), strict=True)))
        after, arrived, voltage, saturated = inverse_tick(
            self._rules(values), values, before, plant, reference, Surroundings(*around)
        )
        following = ca.vertcat(
            self._join(after.core, after.states), self._join(arrived.core, arrived.states, self._aimed)
        )
        return ca.Function(
            "chain_inverse",
            [p, state, reference, *around],
            [following, voltage, saturated],
            ["p", "state", "reference", "force", "temperature", "time"],
            ["next_state", "voltage", "saturated"],
        )

    @cached_property
    def inverse_rest(self) -> ca.Function:
        """P -> state of the inverse at rest at `initialDisplacement`, where the plant is as well."""
        p, values = self._symbols()
        state = self._rest(values)
        states = dict(zip(self.effects, self._split(state), strict=True))
        twice = ca.vertcat(state, self._join(state[0], states, self._aimed))
        return ca.Function("chain_inverse_rest", [p], [twice], ["p"], ["state"])

    def free_run(
        self,
        voltage: np.ndarray,
        force: np.ndarray | float = 0.0,
        temperature: np.ndarray | float = REST_TEMPERATURE,
        parameters: ParameterSet | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Simulate from rest, as `compiled.chain_free_run` does; returns displacement, measured."""
        p = self.vector(parameters)
        samples = len(voltage)
        time = np.arange(samples) * (parameters or self.parameters)["sampleTime"]
        inputs = np.array(
            [np.broadcast_to(c, (samples,)) for c in (voltage, force, temperature, time)], dtype=float
        )
        state, displacement, measured = self.rest(p), np.empty(samples), np.empty(samples)
        for k in range(samples):
            state, y, reading = self.step(p, state, *inputs[:, k])
            displacement[k], measured[k] = float(y), float(reading)
        return displacement, measured

    def _symbols(self) -> tuple[ca.SX, dict[str, Scalar]]:
        """Return the argument `p`, and every parameter by name: symbols, but numbers for counts."""
        p = ca.SX.sym("p", len(self.names))
        return p, {**self.parameters, **dict(zip(self.names, ca.vertsplit(p), strict=True))}

    def _rules(self, values: dict[str, Scalar]) -> ca.SX:
        rows = range(1, int(values["ruleCount"]) + 1)
        return ca.vertcat(*(ca.horzcat(*(values[f"rule[{i}].{f}"] for f in RULE_FIELDS)) for i in rows))

    def _step(
        self, values: dict[str, Scalar], state: ca.SX, inputs: list[ca.SX]
    ) -> tuple[ca.SX, ca.SX, ca.SX]:
        x, around = inputs[0], Surroundings(*inputs[1:])
        states = dict(zip(self.effects, self._split(state), strict=True))

        def walk(effects: dict, x: Scalar, around: Surroundings) -> Scalar:
            for name in (n for n in effects if n in states):
                x, states[name] = EFFECTS[name].step(values, states[name], x, around)
            return x

        limits = values["displacementMin"], values["displacementMax"]
        driving = walk(BEFORE_CORE, x, around)
        core = it2.step_expression(self._rules(values), state[0], driving, limits)
        displacement = walk(BEHIND_CORE, core, around._replace(voltage=driving))
        measured = walk(READING, displacement, around)
        return self._join(core, states), displacement, measured

    def _rest(self, values: dict[str, Scalar]) -> ca.SX:
        states = {}

        def back(effects: dict, y: Scalar) -> Scalar:
            for name in (n for n in reversed(effects) if n in self.effects):
                y, full = EFFECTS[name].rest(values, y)
                states[name] = full[: self._sizes[name]]
            return y

        core = back(BEHIND_CORE, values["initialDisplacement"])
        limits = values["displacementMin"], values["displacementMax"]
        back(BEFORE_CORE, it2.inverse_expression(self._rules(values), core, core, limits))
        return self._join(core, states)

    def _split(self, state: ca.SX, effects: Sequence[str] | None = None) -> list[list[ca.SX]]:
        """Return the effects' states, in their order; by default of all that are on."""
        parts, first = [], 1
        for name in self.effects if effects is None else effects:
            last = first + self._sizes[name]
            parts.append([state[i] for i in range(first, last)])
            first = last
        return parts

    def _join(
        self, core: Scalar, states: dict[str, list[Scalar]], effects: Sequence[str] | None = None
    ) -> ca.SX:
        names = self.effects if effects is None else effects
        return ca.vertcat(core, *(s for name in names for s in states.get(name, [])))
