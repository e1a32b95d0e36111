"""An effect of the user's own: one more stage of the chain, written in CasADi in a Python file.

Such a file is code, and is run (`it2hys.model.own_loading`). `EFFECT` in it is an instance of a
subclass of `OwnEffect`, which declares its parameters and states, and gives `step`. The rest follows
from that: how it is fitted, where it is at rest, and its inverse.
"""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from it2hys.model.effect import Effect, Memory, Scalar, Start, Surroundings, Values
from it2hys.records.clues import Extent
from it2hys.support.lazy import Lazy

if TYPE_CHECKING:
    import casadi as ca
else:
    ca = Lazy("casadi")


#: Values of the chain that a stage may use beside its own parameters.
SHARED = ("sampleTime", "displacementZero")
#: Ends of the range in which the input is sought, by side.
ENDS = {
    "before": ("voltageMin", "voltageMax"),
    "behind": ("displacementMin", "displacementMax"),
    "reading": ("displacementMin", "displacementMax"),
}
#: Reference temperature, K: no force, this and the time 0 hold where a stage rests; and any voltage.
AT_REST = Surroundings(0.0, 293.15, 0.0)
#: The input is sought within the range and this share of it beyond each end.
BEYOND = 0.5
#: Steps of the search for the input: halving alone takes 53 to the last digit.
SEARCH_STEPS = 60
#: Steps of this share of the bracket are rounding.
ROUNDING = 4.0 * sys.float_info.epsilon
#: Newton steps to where a stage rests; one where it is affine, and one that makes up for rounding.
REST_STEPS, AFFINE_REST_STEPS = 30, 2
#: More states than this are a long memory, unless the effect says otherwise.
FEW_STATES = 2


@dataclass(frozen=True)
class OwnParameter:
    """A parameter of an effect of the user's own.

    Parameters
    ----------
    name : str
        Letters and digits, the first a small letter; `gain` of the effect `mount` is `mount.gain`.
    unit : str
        SI unit, or "1".
    low, high : float
        Bounds of a fit, and of the FMUs' parameter. A parameter whose bounds are both positive is
        fitted by its logarithm.
    guesses : tuple of float
        Values within the bounds that a fit begins at.
    description : str
        For readers.
    of_sampling : bool
        Whether it tells how signals were sampled: a fit may then rest on its bounds, which say nothing
        of the stage.
    """

    name: str
    unit: str = "1"
    low: float = 0.0
    high: float = 1.0
    guesses: tuple[float, ...] = ()
    description: str = ""
    of_sampling: bool = False


class OwnEffect(Effect):
    """A stage of the user's own.

    A subclass declares the attributes and gives `step`; `inverse`, `rest` and `latency` (`Effect`)
    where those that follow from `step` do not suit; `inverse = None` for an effect that has no part
    in the inverse. The first parameter switches the effect: 0 is off.

    Attributes
    ----------
    name : str
        A lower-case identifier.
    side : {"before", "behind", "reading"}
        Next to the core before it, last behind it, or between displacement and measured. There it has
        neither states nor a part in the inverse.
    description : str
        A clause for readers.
    experiment : str
        The experiment that would show it, as a clause.
    channel : str or None
        Column that records must have: "force_N" or "temperature_degC".
    states : int
        Number of states.
    parameters : tuple of OwnParameter
    memory : Memory
        `Memory.AIMED` where the state is that of a tick or two, as a resonance's: the inverse keeps
        what it aimed at. `Memory.LONG` where it remembers for long, as friction or heat: the inverse
        keeps what the plant reached. By default AIMED for up to two states.
    file : Path
        Where it was read from.
    """

    name: ClassVar[str]
    side: ClassVar[str]
    description: ClassVar[str] = ""
    experiment: ClassVar[str] = ""
    channel: ClassVar[str | None] = None
    parameters: ClassVar[tuple[OwnParameter, ...]] = ()
    file: Path = Path()
    text: bytes = b""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if "memory" not in vars(cls):
            cls.memory = Memory.AIMED if cls.states <= FEW_STATES else Memory.LONG
        if not cls.states:
            cls.memory = Memory.NONE
        elif cls.inverse is None:  # nothing of it is kept in the inverse
            cls.memory = Memory.LONGEST

    @property
    def has_inverse(self) -> bool:
        """Whether the effect has a part in the inverse."""
        return self.side != "reading" and self.inverse is not None

    @property
    def switch(self) -> str:
        """Parameter that is 0 where the effect is off."""
        return f"{self.name}.{self.parameters[0].name}"

    @property
    def digest(self) -> str:
        """SHA-256 of the file."""
        return hashlib.sha256(self.text).hexdigest()

    def is_on(self, parameters: Values) -> bool:
        """Return whether a parameter set has the effect."""
        return bool(parameters[self.switch] != 0.0)

    def starts(self, extent: Extent) -> dict[str, Start]:
        """Start at the first guesses."""
        return {
            f"{self.name}.{p.name}": Start(p.guesses[0], p.low, p.high, p.of_sampling)
            for p in self.parameters
        }

    def rest(self, values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
        """Return input and states at rest at the output y.

        By default the input is the output and all states are 0, if that is at rest; otherwise it is
        sought from there by Newton's method. Without states it is that of the inverse.
        """
        if self.rest_steps and not self.states:
            return solved(self, values, [], y, AT_REST), []
        x: Scalar = y
        state: list[Scalar] = [0.0] * self.states
        for _ in range(self.rest_steps):
            x, *following = rest_step(self, values, y, [x, *state])
            state = list(following)
        return x, state

    @property
    def rest_steps(self) -> int:
        """Newton steps that `rest` takes by default."""
        if "_rest_steps" not in vars(self):
            self._rest_steps = _rest_steps(self)
        return self._rest_steps

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the input that makes the output y, and the next states where the memory is short.

        By default it is solved for where `step` is affine in its input, and sought by Newton's method
        over the range otherwise, in which `step` has to rise, and a part of it beyond. Where nothing
        makes that output it is as far beyond, so that the chain's inverse is saturated.
        """
        x = solved(self, values, state, y, around)
        return x, self.step(values, state, x, around)[1] if self.memory is Memory.AIMED else state

    @property
    def inverse_is_given(self) -> bool:
        """Whether the file has an inverse of its own."""
        return type(self).inverse is not OwnEffect.inverse

    @property
    def rest_is_given(self) -> bool:
        """Whether the file says where it rests."""
        return type(self).rest is not OwnEffect.rest

    @property
    def latency_is_given(self) -> bool:
        """Whether the file has a latency."""
        return type(self).latency is not Effect.latency


# --- what follows from step -----------------------------------------------------------------------


def slope_of(
    effect: OwnEffect, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
) -> tuple[ca.SX, ca.SX, bool]:
    """Return the output and its derivative by the input, and whether `step` is affine in the input."""
    symbol = ca.SX.sym("x")
    y = ca.SX(effect.step(values, state, symbol, around)[0])
    slope = ca.jacobian(y, symbol)
    affine = not ca.depends_on(slope, symbol)
    return ca.substitute(y, symbol, x), ca.substitute(slope, symbol, x), affine


def solved(
    effect: OwnEffect, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
) -> Scalar:
    """Return the input that makes the output y; as own_solve of fmu_src/core/own_stage.h."""
    at, slope, affine = slope_of(effect, values, state, y, around)
    if affine:
        return y - (at - y) / slope
    curve = _curve(effect, values, state, around)
    minimum, maximum = (ca.SX(values[name]) for name in ENDS[effect.side])
    beyond, rounding = BEYOND * (maximum - minimum), ROUNDING * (maximum - minimum)
    first, last = minimum - beyond, maximum + beyond
    is_below, is_above = curve(minimum)[0] > y, curve(maximum)[0] < y
    low = ca.if_else(is_below, first, ca.if_else(is_above, maximum, minimum))
    high = ca.if_else(is_below, minimum, ca.if_else(is_above, last, maximum))
    x, step = ca.fmin(ca.fmax(y, low), high), high - low
    for _ in range(SEARCH_STEPS):
        value, slope = curve(x)
        excess = value - y
        newton = -excess / slope
        high = ca.if_else(excess > 0.0, x, high)
        low = ca.if_else(excess > 0.0, low, x)
        inside = ca.logic_and(x + newton >= low, x + newton <= high)
        halves = ca.fabs(newton) <= 0.5 * ca.fabs(step)
        well = ca.logic_or(ca.logic_and(inside, halves), ca.fabs(newton) <= rounding)
        step = ca.if_else(well, newton, 0.5 * (low + high) - x)
        x = x + step
    value, slope = curve(x)
    # its derivatives are those of the root
    root = x - ca.if_else(slope > 0.0, (value - y) / slope, 0.0)
    is_least = ca.logic_and(is_below, curve(first)[0] >= y)
    is_most = ca.logic_and(is_above, curve(last)[0] <= y)
    return ca.if_else(is_least, first, ca.if_else(is_most, last, root))


def _curve(
    effect: OwnEffect, values: Values, state: list[Scalar], around: Surroundings
) -> Callable[[Scalar], tuple[ca.SX, ca.SX]]:
    """Return the output and its slope as a function of the input, all else held."""
    symbol = ca.SX.sym("x")
    y = ca.SX(effect.step(values, state, symbol, around)[0])
    slope = ca.jacobian(y, symbol)
    held = ca.vertcat(*(s for s in ca.symvar(ca.vertcat(y, slope)) if not ca.is_equal(s, symbol)))
    function = ca.Function("curve", [symbol, held], [y, slope])

    def at(x: Scalar) -> tuple[ca.SX, ca.SX]:
        value, slope = function(x, held)
        return value, slope

    return at


def rest_step(effect: OwnEffect, values: Values, y: Scalar, at: Sequence[Scalar]) -> list[ca.SX]:
    """Return input and states one Newton step nearer to rest at the output y."""
    symbols = ca.SX.sym("u", 1 + effect.states)
    x, *state = ca.vertsplit(symbols)
    output, following = effect.step(values, list(state), x, AT_REST)
    excess = ca.vertcat(output - y, *(a - b for a, b in zip(following, state, strict=True)))
    moved = symbols - ca.solve(ca.jacobian(excess, symbols), excess)
    return ca.vertsplit(ca.substitute(moved, symbols, ca.vertcat(*at)))


def symbols_of(effect: OwnEffect) -> tuple[dict[str, ca.SX], list[ca.SX], ca.SX, Surroundings]:
    """Return symbols for what `step` gets: values by name, states, input and surroundings."""
    names = [*(f"{effect.name}.{p.name}" for p in effect.parameters), *SHARED]
    values = {name: ca.SX.sym(name) for name in names}
    state = [ca.SX.sym(f"state{i}") for i in range(effect.states)]
    return values, state, ca.SX.sym("x"), Surroundings(*(ca.SX.sym(n) for n in Surroundings._fields))


def sample_values(effect: OwnEffect, count: int = 8, seed: int = 0) -> list[dict[str, float]]:
    """Return values of the parameters: at the guesses, and anywhere within the bounds."""
    rng = np.random.default_rng(seed)
    shared = {"sampleTime": 1e-4, "displacementZero": 0.0}
    guesses = max(len(p.guesses) for p in effect.parameters)
    at_guesses = [
        {p.name: p.guesses[min(i, len(p.guesses) - 1)] for p in effect.parameters}
        for i in range(guesses)
    ]
    anywhere = [{p.name: _anywhere(p, rng) for p in effect.parameters} for _ in range(count)]
    return [
        {**{f"{effect.name}.{name}": float(v) for name, v in own.items()}, **shared}
        for own in (*at_guesses, *anywhere)
    ]


def _anywhere(parameter: OwnParameter, rng: np.random.Generator) -> float:
    low, high = parameter.low, parameter.high
    return float(np.exp(rng.uniform(*np.log([low, high]))) if low > 0.0 else rng.uniform(low, high))


#: Ranges of the paper's stage, in SI units, over which an effect is checked.
TYPICAL = {"before": (0.0, 120.0), "behind": (0.0, 16e-6), "reading": (0.0, 16e-6)}


def not_at_rest(effect: OwnEffect, rest: Callable[[Values, ca.SX], tuple]) -> str | None:
    """Return where that is not at rest, of all that is tried, or None if it is."""
    values, *_ = symbols_of(effect)
    y, voltage = ca.SX.sym("y"), ca.SX.sym("voltage")
    x, state = rest({**values, **dict(zip(ENDS[effect.side], TYPICAL[effect.side], strict=True))}, y)
    output, following = effect.step(values, list(state), x, AT_REST._replace(voltage=voltage))
    off = ca.vertcat(output - y, *(a - b for a, b in zip(following, state, strict=True)))
    scale = ca.vertcat(y, x, *state)
    names = list(values)
    function = ca.Function("rest", [ca.vertcat(*values.values()), y, voltage], [off, scale])
    low, high = TYPICAL[effect.side]
    places, voltages = np.linspace(low + 0.1 * (high - low), high, 4), (0.0, TYPICAL["before"][1])
    for own in sample_values(effect):
        for place, driving in product(places, voltages):
            known = [own[n] for n in names]
            excess, at = (np.array(a).ravel() for a in function(known, place, driving))
            most = 1e-9 * (high - low) if effect.states == 0 else 1e-9 * max(high, np.abs(at).max())
            if not np.all(np.abs(excess) <= most):
                at_values = [f"{n} = {v:g}" for n, v in own.items() if n not in SHARED]
                return f"at {place:g} with {', '.join(at_values)}"
    return None


def _rest_steps(effect: OwnEffect) -> int:
    """Return the Newton steps that rest takes: none where nothing has to move."""
    if not not_at_rest(effect, lambda values, y: (y, [0.0] * effect.states)):
        return 0
    values, state, x, _ = symbols_of(effect)
    output, following = effect.step(values, list(state), x, AT_REST)
    at = ca.vertcat(x, *state)
    return AFFINE_REST_STEPS if ca.is_linear(ca.vertcat(output, *following), at) else REST_STEPS


def line_of(effect: OwnEffect, function: str | None = None) -> int:
    """Return the line of a method in an effect's file, or where that is not there, of the class."""
    method = vars(type(effect)).get(function) if function else None
    if method is not None and hasattr(method, "__code__"):
        return method.__code__.co_firstlineno
    lines = effect.text.decode(errors="replace").splitlines()
    name = type(effect).__name__
    return next((i for i, text in enumerate(lines, 1) if re.match(rf"\s*class {name}\b", text)), 1)
