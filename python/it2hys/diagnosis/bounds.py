"""Named effects whose fit rests on a bound: the records ask for more than such an effect can be."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from it2hys.identification.criterion import ChainFit
from it2hys.model.variables import load_table
from it2hys.policy import PHYSICS

#: Distance in coordinates (a fit moves by about 1) within which a parameter is at its bound.
_TOUCHES = 1e-6


def resting_on_bounds(fit: ChainFit, effects: Sequence[str]) -> dict[str, list[str]]:
    """Return by effect the parameters of a fit that the records press against a bound other than 0.

    A gain or weight of 0 is a term that is not needed. How signals were sampled is nothing of a stage,
    and may rest on any bound. What does nothing at its bound is not pressed there: the time constant of
    such a term, the limit that no voltage reaches.

    Parameters
    ----------
    fit : ChainFit
    effects : sequence of str
        Those that are asked for.
    """
    criterion, point = fit.criterion, fit.minimum.coordinates
    place = criterion.places_of_common
    jacobian, residual = criterion.jacobian(point)
    free = (point - criterion.lower > _TOUCHES) & (criterion.upper - point > _TOUCHES)
    columns = _not_made_up_for(jacobian[:, place], jacobian[:, free])
    size = np.linalg.norm(columns, axis=0) * np.sqrt(np.mean(residual**2))
    pressed = -(columns.T @ residual) / np.where(size > 0.0, size, np.inf)
    low = (point - criterion.lower)[place] < _TOUCHES
    high = (criterion.upper - point)[place] < _TOUCHES
    held = low & high  # at its value, and at no bound
    rests = (low & (pressed < -PHYSICS.pressed)) | (high & (pressed > PHYSICS.pressed))
    known, values = load_table().parameters(), fit.model.values
    at_bound = [
        c for c, at in zip(criterion.common, rests & ~held, strict=True) if at and not c.of_sampling
    ]
    names = [c.name for c in at_bound if values[c.name]]
    by_effect = {e: [n for n in names if known[n].effect == e] for e in effects}
    return {effect: names for effect, names in by_effect.items() if names}


def touching_bounds(fit: ChainFit, effects: Sequence[str]) -> list[str]:
    """Return the parameters of effects that are at a bound other than 0, pressed there or not."""
    criterion, point = fit.criterion, fit.minimum.coordinates
    place, known, values = criterion.places_of_common, load_table().parameters(), fit.model.values
    near = np.minimum(point - criterion.lower, criterion.upper - point)[place] < _TOUCHES
    at_bound = [c for c, at in zip(criterion.common, near, strict=True) if at and not c.of_sampling]
    return [c.name for c in at_bound if values[c.name] and known[c.name].effect in effects]


def _not_made_up_for(columns: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Return the part of columns of a Jacobian, (M, N), that no change of the free parameters makes."""
    basis, sizes, _ = np.linalg.svd(free, full_matrices=False)
    basis = basis[:, sizes > np.finfo(float).eps * len(free) * np.max(sizes, initial=0.0)]
    return columns - basis @ (basis.T @ columns)


def bound_sentences(fit: ChainFit, effects: Sequence[str]) -> list[str]:
    """Return a sentence for each effect whose fit rests on a bound.

    Parameters
    ----------
    fit : ChainFit
    effects : sequence of str
        Those that were named.
    """
    return [
        f"The fit of {effect} rests on the bound of {names}: the records ask for more than this "
        "effect may be, or do not determine it. Do not read its parameters as the stage's: they may "
        "make up for something else that the model lacks."
        for effect, names in pressed_with_values(fit, effects).items()
    ]


def pressed_with_values(fit: ChainFit, effects: Sequence[str]) -> dict[str, str]:
    """Return by effect what rests on bounds, see `resting_on_bounds`, with the values, to be read."""
    values, resting = fit.model.values, resting_on_bounds(fit, effects)
    return {e: _listed([_text(n, values[n]) for n in names]) for e, names in resting.items()}


def _text(name: str, value: float) -> str:
    kind = load_table().parameters()[name].type
    if kind.displayUnit == "um":
        return f"{name} ({1e6 * value:.3g} µm)"
    return f"{name} ({value:.3g}{'' if kind.unit == '1' else ' ' + kind.unit})"


def _listed(texts: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(texts[:-1]), texts[-1]]))
