"""The one list of stages in Python, in the order of the chain; in C it is `fmu_src/core/stages.h`.

Another effect is a line here, its modules in `model/effects` and `diagnosis/evidence`, and its rows in
`variables.toml`; everything else loops over this list.
"""

from __future__ import annotations

from enum import Enum
from importlib import import_module

from it2hys.model.effect import Effect


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
