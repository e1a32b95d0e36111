"""The one list of stages in Python, in the order of the chain; in C it is `fmu_src/core/stages.h`.

Another effect is a line here, its modules in `model/effects` and `diagnosis/evidence`, and its rows in
`variables.toml`; everything else loops over this list.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from enum import Enum
from importlib import import_module
from pathlib import Path

from it2hys.errors import InputError
from it2hys.model import compiled
from it2hys.model.effect import Effect
from it2hys.model.own_effect import OwnEffect, line_of
from it2hys.model.own_loading import load_effect
from it2hys.model.variables import DeclaredType, Variable, load_table, table_with


class Side(Enum):
    """Where in the chain a stage stands."""

    BEFORE = "before the core"
    BEHIND = "behind the core"
    READING = "between displacement and measured"


#: Effects by the name that reports use.
STAGES = {
    "delay": Side.BEFORE,
    "slew": Side.BEFORE,
    "saturation": Side.BEFORE,
    "lag": Side.BEFORE,
    "play": Side.BEFORE,
    "load": Side.BEHIND,
    "creep": Side.BEHIND,
    "resonance": Side.BEHIND,
    "drift": Side.BEHIND,
    "nonlinearity": Side.BEHIND,
    "hum": Side.READING,
}

EFFECTS: dict[str, Effect] = {
    name: import_module(f"it2hys.model.effects.{name}").EFFECT for name in STAGES
}


def _on(side: Side) -> dict[str, Effect]:
    return {name: EFFECTS[name] for name, own in STAGES.items() if own is side}


BEFORE_CORE, BEHIND_CORE, READING = map(_on, Side)

# --- effects of the user's own ------------------------------------------------------------------------

_BUILT_IN, _BUILT_IN_STAGES = dict(EFFECTS), dict(STAGES)
#: Environment variable by which worker processes find the effects.
VARIABLE = "IT2HYS_OWN_EFFECTS"
#: Nominal values give the size of a parameter that has no bounds.
_UNITS_OF_TYPES = {"m": "um"}


def own_effects() -> dict[str, OwnEffect]:
    """Return the effects of the user's own that are in the chain, by name."""
    return {name: e for name, e in EFFECTS.items() if isinstance(e, OwnEffect)}


def set_own_effects(effects: Sequence[OwnEffect], native: Path | None) -> None:
    """Put these effects of the user's own into the chain, in place of those that are there.

    They come last on their side, in this order: before the core next to it, so that what limits the
    voltage stays in front of them, and behind it next to the displacement. Their parameters come last
    in the table. `STAGES`, `EFFECTS` and the dictionaries of the sides are the same objects as before.

    Parameters
    ----------
    effects : sequence of OwnEffect
    native : path, optional
        Folder of the C core that was built with them (`it2hys.fmu.own_library`); None without effects.

    Raises
    ------
    InputError
        With file and line, if a name is taken.
    """
    taken = {*_BUILT_IN, *load_table().counts}
    for effect in effects:
        if effect.name in taken:
            raise InputError(f"{effect.file}:{line_of(effect)}: the name {effect.name!r} is taken")
        taken.add(effect.name)
    sides = {**_BUILT_IN_STAGES, **{e.name: Side[e.side.upper()] for e in effects}}
    known: dict[str, Effect] = {**_BUILT_IN, **{e.name: e for e in effects}}
    for stages in (STAGES, EFFECTS):
        stages.clear()
    for side in Side:
        STAGES.update({name: own for name, own in sides.items() if own is side})
    EFFECTS.update({name: known[name] for name in STAGES})
    for stages, side in zip((BEFORE_CORE, BEHIND_CORE, READING), Side, strict=True):
        stages.clear()
        stages.update(_on(side))
    table_with([v for e in effects for v in _variables(e)], [e.digest for e in effects])
    compiled.use_native(native)
    if effects:
        files = [str(e.file) for e in effects]
        os.environ[VARIABLE] = json.dumps({"files": files, "native": str(native)})
    else:
        os.environ.pop(VARIABLE, None)


def _variables(effect: OwnEffect) -> list[Variable]:
    """Return the rows of an effect's parameters; their places come later."""
    rows = []
    for i, p in enumerate(effect.parameters):
        words = effect.name.title().replace("_", "")
        kind = DeclaredType(
            f"{words}{p.name[0].upper()}{p.name[1:]}",
            unit=p.unit,
            displayUnit=_UNITS_OF_TYPES.get(p.unit),
            min=min(p.low, 0.0) if i == 0 else p.low,
            max=max(p.high, 0.0) if i == 0 else p.high,
            nominal=max(abs(p.low), abs(p.high)),
        )
        text = p.description or f"Parameter of {effect.description or effect.name}"
        if i == 0:
            text += "; 0 for none"
        rows.append(
            Variable(
                f"{effect.name}.{p.name}",
                0,
                ("plant", "inverse"),
                "parameter",
                kind,
                0.0 if i == 0 else float(p.guesses[0]),
                (),
                text,
                effect=effect.name,
            )
        )
    return rows


def _take_over() -> None:
    """Put the effects of the process that has started this one into the chain."""
    if text := os.environ.get(VARIABLE):
        told = json.loads(text)
        set_own_effects([load_effect(path) for path in told["files"]], Path(told["native"]))


_take_over()
