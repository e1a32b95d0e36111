"""Piezo hysteresis: an interval type-2 fuzzy model and its closed-form inverse, as FMUs.

Data flow one way: from records (`records`) a parameter set is identified (`identification`); the
effects that it lacks are added (`diagnosis`); the set is packaged as FMUs (`fmu`), which run in
co-simulation (`cosimulation`), in one case or in many (`sweeps`). The functions of `api`, for
notebooks and scripts, are imported from here.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from it2hys.errors import InputError

if TYPE_CHECKING:  # for checkers and editors; `__getattr__` loads them
    from it2hys.api import DesignedRecord as DesignedRecord
    from it2hys.api import DiagnosedModel as DiagnosedModel
    from it2hys.api import IdentifiedModel as IdentifiedModel
    from it2hys.api import casadi_chain as casadi_chain
    from it2hys.api import design as design
    from it2hys.api import diagnose as diagnose
    from it2hys.api import identify as identify
    from it2hys.api import package as package
    from it2hys.api import simulate as simulate
    from it2hys.api import sweep as sweep
    from it2hys.api import track as track
    from it2hys.model.effect import Memory as Memory
    from it2hys.model.own_effect import OwnEffect as OwnEffect
    from it2hys.model.own_effect import OwnParameter as OwnParameter

    __version__: str

# loaded when first asked for, so that the command line starts quickly
_API = (
    "DesignedRecord",
    "DiagnosedModel",
    "IdentifiedModel",
    "casadi_chain",
    "design",
    "diagnose",
    "identify",
    "package",
    "simulate",
    "sweep",
    "track",
)

__all__ = ["InputError", "__version__", *_API, "Memory", "OwnEffect", "OwnParameter"]


#: What a file with an effect of one's own begins with.
_OWN = {
    "Memory": "it2hys.model.effect",
    "OwnEffect": "it2hys.model.own_effect",
    "OwnParameter": "it2hys.model.own_effect",
}


def __getattr__(name: str) -> object:
    if name == "__version__":
        from it2hys.support.version import package_version

        return package_version()
    if name in _OWN:
        return getattr(import_module(_OWN[name]), name)
    if name not in _API:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from it2hys import api

    return getattr(api, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
