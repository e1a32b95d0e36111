"""Reading a file with an effect of the user's own.

The file is code, and is run. What cannot be a stage of the chain is refused here, with file and line.
"""

from __future__ import annotations

import hashlib
import importlib.util
import re
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from it2hys.errors import InputError
from it2hys.model.effect import Memory
from it2hys.model.own_effect import (
    AT_REST,
    ENDS,
    SHARED,
    TYPICAL,
    OwnEffect,
    OwnParameter,
    line_of,
    not_at_rest,
    sample_values,
    symbols_of,
)
from it2hys.support.lazy import Lazy

if TYPE_CHECKING:
    import casadi as ca
else:
    ca = Lazy("casadi")


CHANNELS = (None, "force_N", "temperature_degC")
_NAME = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
_FIELD = re.compile(r"[a-z][A-Za-z0-9]*")
_STATES_WANTED = "it returns the next ones where memory is Memory.AIMED, otherwise those that it got"
#: Words of C, and of the structs and lists that an effect's name stands in.
_RESERVED = frozenset(
    re.findall(
        r"\w+",
        "auto break case char const continue default do double else enum extern float for goto if "
        "inline int long register restrict return short signed sizeof static struct switch typedef "
        "union unsigned void volatile while bool true false real chain core stage rule state effects "
        "reading active before behind all displacement voltage latency walked retraced reached none "
        "aimed longest amplifier returning place own fmu main",
    )
)


def load_effect(path: str | Path) -> OwnEffect:
    """Run a file and return its effect, checked.

    Parameters
    ----------
    path : path
        A Python file with `EFFECT`, an instance of a subclass of `OwnEffect`. It is run.

    Raises
    ------
    InputError
        With file and line, if the file cannot be run, has no effect, or one that cannot be a stage.
    """
    path = Path(path).resolve()
    try:
        text = path.read_bytes()
    except OSError:
        raise InputError(f"{path}: no such file, or it cannot be read") from None
    name = f"it2hys_own_{hashlib.sha256(str(path).encode() + text).hexdigest()[:16]}"
    specification = importlib.util.spec_from_file_location(name, path)
    assert specification and specification.loader
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module
    try:
        exec(compile(text, str(path), "exec"), vars(module))
    except SyntaxError as error:
        raise InputError(f"{path}:{error.lineno}: {error.msg}") from None
    except Exception as error:
        raise InputError(_raised(path, error, "running the file")) from None
    effect = getattr(module, "EFFECT", None)
    if not isinstance(effect, OwnEffect):
        what = "it has none" if effect is None else f"it is {effect!r}"
        raise InputError(
            f"{path}:1: EFFECT must be an instance of a subclass of it2hys.OwnEffect; {what} "
            "(`it2hys effect new NAME` writes a file that works)"
        )
    effect.file, effect.text = path, text
    _Check(effect).everything()
    return effect


def _raised(path: Path, error: BaseException, doing: str) -> str:
    """Return what was raised, and the last line of the file that led to it."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == str(path)]
    line = frames[-1].lineno if frames else 1
    words = str(error).strip().splitlines()
    said = f"values[{error}] is not known" if isinstance(error, KeyError) else (words or [""])[-1]
    if "truth value" in said:
        said = "an expression has no truth value; use casadi.if_else instead of if"
    return f"{path}:{line}: {doing} raises {type(error).__name__}: {said}"


def check_name(name: str) -> None:
    """Refuse what cannot be the name of an effect."""
    if not _is_name(name):
        raise InputError(f"{name!r} must be a lower-case identifier, and no word of C")


def _is_name(name: object) -> bool:
    return isinstance(name, str) and bool(_NAME.fullmatch(name)) and name not in _RESERVED


class _Check:
    """What makes an effect a stage."""

    def __init__(self, effect: OwnEffect) -> None:
        self._effect = effect

    def everything(self) -> None:
        try:
            self._declarations()
        except (AttributeError, TypeError) as error:
            self._refuse(None, f"a declaration is missing or of another kind: {error}")
        self._step()
        self._rest()
        self._inverse()

    def _refuse(self, function: str | None, text: str) -> NoReturn:
        """Refuse the effect, with the line of the method or of the class."""
        raise InputError(f"{self._effect.file}:{line_of(self._effect, function)}: {text}")

    def _called(self, function: str, *arguments: object) -> tuple:
        try:
            result = getattr(self._effect, function)(*arguments)
        except InputError:
            raise
        except Exception as error:
            own = [f"{self._effect.name}.{p.name}" for p in self._effect.parameters]
            more = f" (known are {', '.join([*own, *SHARED])})" if isinstance(error, KeyError) else ""
            raise InputError(_raised(self._effect.file, error, function) + more) from None
        if not isinstance(result, tuple) or len(result) != 2:
            what = "output and next states" if function == "step" else "input and states"
            self._refuse(
                function, f"{function} returns {_kind(result)}; it must return two things: {what}"
            )
        first, states = result
        if not isinstance(states, list | tuple):
            self._refuse(
                function, f"{function} returns {_kind(states)} for the states; it must be a list"
            )
        return first, list(states)

    def _declarations(self) -> None:
        effect = self._effect
        if not _is_name(effect.name):
            self._refuse(
                None, f"name is {effect.name!r}; it must be a lower-case identifier, and no word of C"
            )
        if effect.side not in ENDS:
            self._refuse(
                None, f"side is {effect.side!r}; it must be one of {', '.join(map(repr, ENDS))}"
            )
        if effect.channel not in CHANNELS:
            self._refuse(None, f"channel is {effect.channel!r}; it must be one of {CHANNELS}")
        if not isinstance(effect.states, int) or not 0 <= effect.states <= 64:
            self._refuse(None, f"states is {effect.states!r}; it must be a whole number from 0 to 64")
        if effect.side == "reading" and effect.states:
            self._refuse(
                None, 'an effect in the "reading" cannot have states; put it "behind" the core'
            )
        if effect.states and effect.has_inverse and effect.memory not in (Memory.AIMED, Memory.LONG):
            self._refuse(None, f"memory is {effect.memory}; it must be Memory.AIMED or Memory.LONG")
        for name in ("limits", "per_record", "shift", "sampling_delay"):
            if getattr(effect, name):
                self._refuse(None, f"an effect of your own cannot have {name}; remove it")
        if not effect.parameters:
            self._refuse(None, "parameters is empty; the first one switches the effect: 0 is off")
        names = [p.name for p in effect.parameters]
        for p in effect.parameters:
            self._parameter(p, names)
        first = effect.parameters[0]
        if all(guess == 0.0 for guess in first.guesses):
            self._refuse(None, f"the first guess of {first.name} is 0, where the effect is off")

    def _parameter(self, p: OwnParameter, names: list[str]) -> None:
        if not _FIELD.fullmatch(p.name) or p.name in _RESERVED or names.count(p.name) > 1:
            self._refuse(
                None,
                f"parameter {p.name!r}: its name must be given once, be of letters and digits, the "
                "first a small letter, and no word of C",
            )
        numbers = [p.low, p.high, *p.guesses]
        if (
            not p.guesses
            or not np.all(np.isfinite(np.array(numbers, dtype=float)))
            or not p.low < p.high
        ):
            self._refuse(
                None,
                f"parameter {p.name!r} needs bounds, low < high, and one guess at least, all finite",
            )
        if not all(p.low <= guess <= p.high for guess in p.guesses):
            self._refuse(
                None, f"parameter {p.name!r}: guesses {p.guesses} must lie from {p.low:g} to {p.high:g}"
            )

    def _step(self) -> None:
        effect = self._effect
        values, state, x, around = symbols_of(effect)
        output, following = self._called("step", values, list(state), x, around)
        if len(following) != effect.states:
            self._refuse(
                "step",
                f"step returns {len(following)} next states, and states is {effect.states}; "
                "the number of states cannot change",
            )
        expressions = [self._scalar("step", e) for e in (output, *following)]
        given = [*values.values(), *state, x, *map(ca.SX, around)]
        self._closed("step", expressions, given)
        if effect.side == "reading" and ca.depends_on(expressions[0], ca.vertcat(around[0], around[1])):
            self._refuse(
                "step", "an effect in the reading depends on the displacement and the time alone"
            )
        if ca.depends_on(ca.vertcat(*expressions), around.voltage):
            self._voltage(ca.depends_on(expressions[0], around.voltage))
        self._finite(ca.Function("step", [ca.vertcat(*given)], [ca.vertcat(*expressions)]))

    def _voltage(self, in_output: bool) -> None:
        """Refuse an effect that uses the voltage at the actuator where it is not known yet."""
        effect = self._effect
        if effect.side != "behind":
            self._refuse("step", f'around.voltage is known "behind" the core, not "{effect.side}" it')
        if in_output:
            self._refuse(
                "step",
                "the output depends on around.voltage, which the inverse has yet to find; "
                "let only the next states depend on it",
            )
        if effect.has_inverse and effect.memory is not Memory.LONG:
            self._refuse(
                None,
                "the next states depend on around.voltage, which the inverse has yet to find "
                "where they are a short memory; write memory = Memory.LONG",
            )

    def _scalar(self, function: str, value: Any) -> ca.SX:
        try:
            expression = ca.SX(value)
        except Exception:  # CasADi refuses by exceptions of many kinds
            expression = ca.SX(0, 0)
        if expression.shape != (1, 1):
            self._refuse(
                function, f"{function} returns {_kind(value)} where a number or an SX is wanted"
            )
        return expression

    def _closed(self, function: str, expressions: list[ca.SX], given: list[ca.SX]) -> None:
        known = [str(g) for g in given]
        for symbol in ca.symvar(ca.vertcat(*expressions)):
            if not any(ca.is_equal(symbol, g) for g in given):
                self._refuse(
                    function,
                    f"{function} depends on {symbol}, which is none of its arguments; "
                    f"a stage knows no more than {', '.join(known)}",
                )

    def _finite(self, function: ca.Function) -> None:
        effect = self._effect
        places, voltages = (np.linspace(*TYPICAL[side], 9) for side in (effect.side, "before"))
        state = [0.0] * effect.states
        for own in sample_values(effect):
            for x, voltage in zip(places, voltages, strict=True):
                around = AT_REST._replace(voltage=voltage)
                out = np.array(function([*own.values(), *state, x, *around])).ravel()
                if not np.all(np.isfinite(out)):
                    at = ", ".join(f"{n} = {v:g}" for n, v in own.items() if n not in SHARED)
                    what = "output" if not np.isfinite(out[0]) else "next states"
                    self._refuse(
                        "step",
                        f"step: the {what} is not finite at x = {x:g}, all states 0, with {at}",
                    )

    def _rest(self) -> None:
        effect = self._effect
        values, *_ = symbols_of(effect)
        y = ca.SX.sym("y")
        ends = dict(zip(ENDS[effect.side], TYPICAL[effect.side], strict=True))
        x, state = self._called("rest", {**values, **ends}, y)
        if len(state) != effect.states:
            self._refuse("rest", f"rest returns {len(state)} states, and states is {effect.states}")
        expressions = [self._scalar("rest", e) for e in (x, *state)]
        self._closed("rest", expressions, [*values.values(), y])
        # without states it rests where the inverse says, or at an end of what can be reached
        if not effect.states and not effect.rest_is_given:
            return
        if where := not_at_rest(effect, effect.rest):
            text = f"rest is not at rest {where}: step does not hold output and states there"
            mend = "" if effect.rest_is_given else "; give rest(self, values, y): input and states"
            self._refuse("rest", text + mend)

    def _inverse(self) -> None:
        effect = self._effect
        if not effect.has_inverse:
            return
        values, state, x, around = symbols_of(effect)
        y, next_states = effect.step(values, list(state), x, around)
        if not ca.depends_on(ca.SX(y), x):
            self._refuse(
                "step",
                "the output does not depend on the input of the same tick, so that the effect has no "
                "inverse; write inverse = None into the class if it is to have no part in it",
            )
        if not effect.inverse_is_given:
            return
        low, high = (ca.SX.sym(n) for n in ENDS[effect.side])
        more = dict(zip(ENDS[effect.side], (low, high), strict=True))
        back, states = self._called("inverse", {**values, **more}, list(state), ca.SX(y), around)
        if len(states) != effect.states:
            self._refuse(
                "inverse", f"inverse returns {len(states)} states, and states is {effect.states}"
            )
        expressions = [self._scalar("inverse", e) for e in (back, *states)]
        given = [*values.values(), *more.values(), *state, x, *map(ca.SX, around)]
        self._closed("inverse", expressions, given)
        if ca.depends_on(ca.vertcat(*expressions), around.voltage):
            self._refuse("inverse", "inverse depends on around.voltage, which it has yet to find")
        wanted = next_states if effect.memory is Memory.AIMED else state
        off = ca.vertcat(back - x, *(a - b for a, b in zip(states, wanted, strict=True)))
        function = ca.Function("inverse", [ca.vertcat(*given)], [off])
        ends = TYPICAL[effect.side]
        for own in sample_values(effect, 3):
            for place in np.linspace(*ends, 5):
                out = np.array(
                    function([*own.values(), *ends, *[0.0] * effect.states, place, *AT_REST])
                ).ravel()
                if not np.all(np.abs(out) <= 1e-7 * ends[1]):
                    note = "" if abs(out[0]) > 1e-7 * ends[1] else f" in a state ({_STATES_WANTED})"
                    self._refuse(
                        "inverse",
                        f"inverse does not undo step: at x = {place:g} it is off by "
                        f"{np.abs(out).max():g}{note}",
                    )


def _kind(value: object) -> str:
    if isinstance(value, tuple | list):
        return f"{len(value)} things"
    return f"a {type(value).__name__}"
