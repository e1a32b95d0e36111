"""One tick of the chain's inverse as a CasADi expression: what `chain_inverse` of chain.c computes.

What the effects lose cannot be undone. There the nearest voltage is asked for, and until the plant is
back at what was aimed at, both are followed: the effects with a short memory are kept twice (`Aim`).
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import casadi as ca

from it2hys.model import it2
from it2hys.model.effect import Memory, Scalar, Surroundings, Values
from it2hys.model.stages import BEFORE_CORE, BEHIND_CORE, EFFECTS

#: Values of a range are the same if no more than this share of it is between them, or last digits.
_SAME, _LAST_DIGITS = 1e-10, 64.0 * sys.float_info.epsilon


class Aim(NamedTuple):
    """Where core and effects are: their last output, and the states by the effect's name."""

    core: Scalar
    states: dict[str, list[Scalar]]


class _Range(NamedTuple):
    low: Scalar
    high: Scalar

    def nearest(self, value: Scalar) -> Scalar:
        return ca.fmin(ca.fmax(value, self.low), self.high)

    def widened(self) -> _Range:
        """Return what is read of something that rings: up to the height of a step beyond either end."""
        step = self.high - self.low
        return _Range(self.low - step, self.high + step)

    def is_near(self, a: Scalar, b: Scalar) -> Scalar:
        digits = _LAST_DIGITS * ca.fmax(ca.fabs(self.low), ca.fabs(self.high))
        return ca.fabs(a - b) <= _SAME * (self.high - self.low) + digits

    def differ(self, a: Scalar, b: Scalar) -> Scalar:
        return ca.logic_and(a != b, ca.logic_not(self.is_near(a, b)))


class _Cut(NamedTuple):
    """The voltage that may be given, what the amplifier makes of it, and whether it is another one."""

    voltage: Scalar
    passed: Scalar
    is_another: Scalar


def inverse_tick(
    rules: ca.SX, values: Values, aimed: Aim, reached: Aim, reference: Scalar, around: Surroundings
) -> tuple[Aim, Aim, Scalar, Scalar]:
    """Return what is aimed at and what the plant reaches then, voltage and whether it is saturated.

    Parameters
    ----------
    rules : casadi.SX, shape (L, 6)
    values : Mapping
        Parameters of the chain.
    aimed : Aim
        Of the last tick, with the states of all effects that are on.
    reached : Aim
        With those of a short memory.
    reference : casadi.SX
        Displacement, m.
    around : Surroundings
    """
    return _Tick(rules, values, aimed, reached, around).solve(reference)


class _Tick:
    def __init__(
        self, rules: ca.SX, values: Values, aimed: Aim, reached: Aim, around: Surroundings
    ) -> None:
        self._rules, self._values, self._around = rules, values, around
        self._aimed, self._reached = aimed, reached
        self._voltages = _Range(values["voltageMin"], values["voltageMax"])
        self._displacements = _Range(values["displacementMin"], values["displacementMax"])
        self._before = [name for name in BEFORE_CORE if name in aimed.states]
        self._behind = [name for name in BEHIND_CORE if name in aimed.states]
        rings = any(EFFECTS[name].memory is Memory.AIMED for name in self._behind)
        self._references = self._displacements.widened() if rings else self._displacements

    def solve(self, reference: Scalar) -> tuple[Aim, Aim, Scalar, Scalar]:
        aim = self._references.nearest(reference)
        solve = self._with_effects if self._before or self._behind else self._of_core
        aimed, reached, voltage, limited = solve(aim)
        return aimed, reached, voltage, ca.logic_or(aim != reference, limited)

    def _of_core(self, aim: Scalar) -> tuple[Aim, Aim, Scalar, Scalar]:
        """Go on from what the plant reaches."""
        wanted = self._inverse_of_core(aim)
        voltage = self._voltages.nearest(wanted)
        core = ca.if_else(voltage == wanted, aim, self._step_of_core(self._aimed.core, voltage))
        after = Aim(core, self._aimed.states)
        return after, Aim(core, {}), voltage, self._voltages.differ(voltage, wanted)

    def _with_effects(self, aim: Scalar) -> tuple[Aim, Aim, Scalar, Scalar]:
        states, inputs = dict(self._aimed.states), {}
        # what acts behind the core does so when the voltage arrives
        latency = sum(EFFECTS[name].latency(self._values) for name in self._before + self._behind)
        later = self._around._replace(time=self._around.time + latency)
        core = self._back(self._behind, aim, later, states, inputs)
        driving = self._inverse_of_core(core)
        wanted = self._back(self._before, driving, self._around, states, inputs)
        cut = self._within_limits(wanted, states)

        plain = ca.logic_not(ca.logic_or(self._is_astray(), cut.is_another))
        plant = self._followed(cut.passed)
        is_back = ca.logic_or(plain, self._is_back(Aim(core, states), plant))
        for name in self._of(Memory.LONG):
            straight = self._stepped(name, self._aimed.states[name], inputs[name], driving)[1]
            states[name] = _chosen(plain, straight, plant.states[name])
        short = {n: _chosen(is_back, states[n], plant.states[n]) for n in self._of(Memory.AIMED)}
        reached = Aim(ca.if_else(is_back, core, plant.core), short)
        return Aim(core, states), reached, cut.voltage, ca.logic_not(is_back)

    def _of(self, memory: Memory) -> list[str]:
        return [n for n in self._before + self._behind if EFFECTS[n].memory is memory]

    def _inverse_of_core(self, y: Scalar) -> Scalar:
        return it2.inverse_expression(self._rules, self._aimed.core, y, self._displacements)

    def _step_of_core(self, y: Scalar, x: Scalar) -> Scalar:
        return it2.step_expression(self._rules, y, x, self._displacements)

    def _stepped(
        self, name: str, state: list[Scalar], x: Scalar, driving: Scalar
    ) -> tuple[Scalar, list[Scalar]]:
        around = self._around._replace(voltage=driving) if name in self._behind else self._around
        return EFFECTS[name].step(self._values, state, x, around)

    def _back(
        self, effects: list[str], y: Scalar, around: Surroundings, states: dict, inputs: dict
    ) -> Scalar:
        """Walk back over the effects that do not limit; note their states, and what each is to get."""
        for name in reversed(effects):
            effect = EFFECTS[name]
            if effect.has_inverse and not effect.limits:
                y, states[name] = effect.inverse(self._values, states[name], y, around)
            inputs[name] = y
        return y

    def _within_limits(self, wanted: Scalar, states: dict) -> _Cut:
        """Return the nearest voltage to the wanted one that may be given.

        The amplifier makes something else of it only while it, at rest at the start, is farther out of
        the range than it can come back in a tick.
        """
        x, is_another, followed = wanted, 0.0, False
        for name in (n for n in reversed(self._before) if EFFECTS[n].limits):
            own = _is_followed(name)
            allowed = self._voltages.nearest(x) if own else x
            is_another = ca.logic_or(is_another, self._voltages.differ(allowed, x))
            x, states[name] = EFFECTS[name].inverse(self._values, states[name], allowed, self._around)
            is_another = ca.logic_or(is_another, self._voltages.differ(x, allowed))
            followed = followed or own
        voltage = self._voltages.nearest(x)
        is_another = ca.logic_or(is_another, self._voltages.differ(voltage, x))
        return _Cut(voltage, x if followed else voltage, is_another)

    def _followed(self, x: Scalar) -> Aim:
        """Return where the plant gets to from what its amplifier lets through."""
        states: dict[str, list[Scalar]] = {}

        def walk(effects: list[str], x: Scalar, driving: Scalar) -> Scalar:
            for name in (n for n in effects if EFFECTS[n].has_inverse and not _is_followed(n)):
                own = self._reached.states.get(name, self._aimed.states[name])
                x, states[name] = self._stepped(name, own, x, driving)
            return x

        driving = walk(self._before, x, 0.0)
        core = self._step_of_core(self._reached.core, driving)
        walk(self._behind, core, driving)
        return Aim(core, states)

    def _is_astray(self) -> Scalar:
        """Return whether the plant is elsewhere than where was aimed at."""
        astray = self._reached.core != self._aimed.core
        for name, own in self._reached.states.items():
            for reached, aimed in zip(own, self._aimed.states[name], strict=True):
                astray = ca.logic_or(astray, reached != aimed)
        return astray

    def _is_back(self, aimed: Aim, plant: Aim) -> Scalar:
        back = self._displacements.is_near(plant.core, aimed.core)
        for name in self._of(Memory.AIMED):
            own = self._voltages if name in self._before else self._displacements
            for reached, wanted in zip(plant.states[name], aimed.states[name], strict=True):
                back = ca.logic_and(back, own.is_near(reached, wanted))
        return back


def _is_followed(name: str) -> bool:
    """Return whether the plant goes where the effect lets it: it limits, and has a state."""
    return EFFECTS[name].limits and EFFECTS[name].memory is not Memory.NONE


def _chosen(condition: Scalar, one: list[Scalar], other: list[Scalar]) -> list[Scalar]:
    return [ca.if_else(condition, a, b) for a, b in zip(one, other, strict=True)]
