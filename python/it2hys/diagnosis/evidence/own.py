"""Evidence on an effect of the user's own: what follows from its declaration.

Its signature is a residual that looks as the effect's response to the signal: what it adds to the
signal, and how that changes with each of its parameters, at one of its guesses.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from itertools import product

import casadi as ca
import numpy as np

from it2hys.diagnosis.evidence.base import EffectEvidence, Signature
from it2hys.diagnosis.evidence.statistics import (
    Columns,
    Ground,
    absorbed,
    by_record,
    lagged,
    modelled,
    readable,
)
from it2hys.model.effect import Surroundings
from it2hys.model.own_effect import ENDS, OwnEffect, symbols_of
from it2hys.records.clues import Clue, Clues

#: Lags, in ticks, by which a core may answer what comes in front of it.
_OF_CORE = (3.0, 10.0)
#: Directions of the answer with less than this share of the greatest one are none of their own.
_LEAST_DIRECTION = 1e-3


class OwnEvidence(EffectEvidence):
    """A residual that looks as the effect's answer to the signal would.

    Parameters
    ----------
    effect : OwnEffect
    """

    guessed_by_shape = True  # of a strength there is one guess in most files
    smooths = True  # it may

    def __init__(self, effect: OwnEffect):
        self._effect = effect
        self.meaning = effect.description or effect.name
        self.experiment = effect.experiment or f"a voltage whose response shows {self.meaning}"
        self.channel = effect.channel and effect.channel.split("_")[0]
        # whatever answers the voltage alone may look like another phase lag, or another core
        self.of_any_loop = self.imitated = effect.channel is None
        self._answer = _answer(effect)

    def guesses(self, clues: Clues) -> list[dict[str, float]]:
        """Return all combinations of the parameters' guesses; nothing without its channel."""
        if self._lacks_channel(clues):
            return []
        names = [f"{self._effect.name}.{p.name}" for p in self._effect.parameters]
        return [
            dict(zip(names, values, strict=True))
            for values in product(*(p.guesses for p in self._effect.parameters))
        ]

    def signature(self, clues: Clues) -> Signature | None:
        """Return whether the residual looks as the effect's answer does; None without its channel.

        The answer is what the effect adds to the signal, and its derivatives by the parameters, at a
        guess. The residual is regressed on them, once the model's own means are taken out; errors are
        spectral and by blocks (HAC), the p-value is corrected for the number of guesses. The statistic
        is the share of the residual's power that the best of them explains.
        """
        seen = readable(clues)
        if seen is None or self._lacks_channel(clues):
            return None
        guesses = self.guesses(seen)
        bank = [self._columns(seen, guess) for guess in guesses]
        chosen, trial = Ground(seen, [absorbed(seen)]).best(bank)
        # a guess tells where there are several
        at = [
            f"{name} = {value:g} {'' if p.unit == '1' else p.unit}".strip()
            for p, (name, value) in zip(self._effect.parameters, guesses[chosen].items(), strict=True)
            if len(p.guesses) > 1
        ]
        text = (
            f"What '{self._effect.name}' adds to the signal explains {100 * trial.share:.0f} % of the "
            f"residual's power{', from the guess ' + ', '.join(at) if at else ''}."
        )
        return Signature(trial.share, trial.p_value, text)

    def _lacks_channel(self, clues: Clues) -> bool:
        if self.channel is None:
            return False
        ends = getattr(clues.extent, self.channel)
        return ends is None or ends[0] == ends[1]

    def _columns(self, seen: Clues, guess: Mapping[str, float]) -> Columns:
        """Return the independent directions of the answer at a guess."""
        answers = [self._of_record(seen, clue, guess) for clue in seen.records]
        if self._effect.side == "before":
            answers = [
                np.hstack([a, *(np.apply_along_axis(lagged, 0, a, ticks) for ticks in _OF_CORE)])
                for a in answers
            ]
        # a guess at which it diverges tells nothing
        answers = [np.nan_to_num(a, nan=0.0, posinf=0.0, neginf=0.0) for a in answers]
        stacked = np.vstack(answers)
        length = np.linalg.norm(stacked - stacked.mean(axis=0), axis=0)
        kept = length > np.sqrt(np.finfo(float).tiny)
        if not np.any(kept):
            return by_record(seen, answers)
        _, sizes, directions = np.linalg.svd(stacked[:, kept] / length[kept], full_matrices=False)
        mixed = directions[sizes > _LEAST_DIRECTION * sizes[0]].T / length[kept][:, None]
        return by_record(seen, [a[:, kept] @ mixed for a in answers])

    def _of_record(self, seen: Clues, clue: Clue, guess: Mapping[str, float]) -> np.ndarray:
        """Return the answer over one record, (N, 1 + parameters), from rest at its first sample."""
        signal = clue.voltage if self._effect.side == "before" else modelled(clue)
        time = seen.extent.sample_time * np.arange(len(signal))
        ends = seen.extent.voltage if self._effect.side == "before" else seen.extent.displacement
        known = [*guess.values(), seen.extent.sample_time, seen.extent.zero, *ends]
        around = Surroundings(clue.force, clue.temperature, time, clue.voltage)
        return self._answer(known, signal, *around)


@cache
def own_evidence(effect: OwnEffect) -> OwnEvidence:
    """Return the evidence on an effect of the user's own."""
    return OwnEvidence(effect)


def _answer(effect: OwnEffect):
    """Return a function that gives what an effect adds to a signal, and that by each parameter.

    The derivatives run along with the states, from rest, which does not depend on the parameters
    where the effect adds nothing there.
    """
    values, state, x, around = symbols_of(effect)
    # the range in which the input at rest is sought
    values |= {name: ca.SX.sym(name) for name in ENDS[effect.side]}
    own = ca.vertcat(*list(values.values())[: len(effect.parameters)])
    output, following = effect.step(values, list(state), x, Surroundings(*around))
    states, after = ca.vertcat(*state), ca.vertcat(*following)
    moved = ca.SX.sym("moved", effect.states, len(effect.parameters))
    by_own = ca.jacobian(output, own)
    moved_after = ca.SX(effect.states, len(effect.parameters))
    if effect.states:
        by_own += ca.jacobian(output, states) @ moved
        moved_after = ca.jacobian(after, own) + ca.jacobian(after, states) @ moved
    known = ca.vertcat(*values.values())
    signals = ca.vertcat(x, *around)
    everything = ca.veccat(states, moved)
    step = ca.Function(
        "answer",
        [everything, signals, known],
        [ca.veccat(after, moved_after), ca.horzcat(output - x, by_own).T],
    )
    rest = ca.Function("rest", [known, x], [ca.vertcat(*effect.rest(values, x)[1])])

    def answer(known: list[float], signal: np.ndarray, *others: np.ndarray) -> np.ndarray:
        first = np.array(rest(known, signal[0])).ravel()
        begin = np.concatenate([first, np.zeros(effect.states * len(effect.parameters))])
        run = step.mapaccum(len(signal))
        added = run(begin, np.vstack([signal, *others]), ca.repmat(ca.DM(known), 1, len(signal)))[1]
        return np.array(added).reshape(1 + len(effect.parameters), len(signal)).T

    return answer
