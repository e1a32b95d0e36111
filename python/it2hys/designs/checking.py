"""What a promise is worth: designed records simulated with noise, told apart as a diagnosis does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from it2hys.designs.hypotheses import Hypothesis
from it2hys.designs.promise import Ground, is_refused
from it2hys.diagnosis.chances import Gains
from it2hys.diagnosis.comparison import compare
from it2hys.diagnosis.diagnose import diagnose
from it2hys.diagnosis.fitting import Bench
from it2hys.identification.criterion import Model
from it2hys.identification.preparation import prepare
from it2hys.identification.traces import set_aside, to_trace
from it2hys.policy import SEARCH
from it2hys.records import Record

#: Iterations of a refit to a noisy record.
_ITERATIONS = 25


@dataclass(frozen=True)
class Simulated:
    """How often a model was told from another on simulated records of it.

    Parameters
    ----------
    truth, rival : str
    told, draws : int
    by : str
        "refits", or "diagnosis".
    """

    truth: str
    rival: str
    told: int
    draws: int
    by: str = "refits"

    @property
    def share(self) -> float:
        """Of the draws."""
        return self.told / self.draws

    @property
    def error(self) -> float:
        """Standard error of the share, by Wilson's formula, which has one where all were told."""
        n, p = self.draws, self.share
        return float(np.sqrt(p * (1.0 - p) / n + 0.25 / n**2) / (1.0 + 1.0 / n))


def record_of(ground: Ground, truth: Hypothesis, voltage: np.ndarray, seed: int) -> Record:
    """Return a record that a model makes of a voltage, (N,), with noise."""
    rng = np.random.default_rng([seed, len(voltage)])
    time = np.arange(len(voltage)) * ground.limits.sample_time
    y = ground.reading(truth, voltage) + ground.noise_draw(len(voltage), rng)
    return Record("designed", time, voltage, y, ground.limits.sample_time)


def simulate_pair(
    ground: Ground, usual: Hypothesis, rival: Hypothesis, voltage: np.ndarray, draws: int, seed: int
) -> Simulated:
    """Refit both models to noisy records of one, and compare them as the diagnosis does.

    The records are in turn of all sizes of its effect that are as likely. A rival that is no better
    than the model without the effects is not taken into account.
    """
    told, sizes = 0, (usual, *usual.sizes)
    for i in range(draws):
        truth = sizes[i % len(sizes)]
        record = record_of(ground, truth, voltage, seed + i)
        traces, deciding = set_aside([to_trace(prepare(record), "train", False)])
        bench = Bench(traces, ground.scaling, ground.extent, deciding, True)
        other, own = (
            bench.fit(model, _ITERATIONS).model for model in (ground.start(truth, rival), truth.model)
        )
        gains = Gains.of(bench.errors(other), bench.errors(own))
        told += (
            is_refused(other, rival)
            or gains.tell(bench.least_inverse_error(other))
            or _is_rejected(ground, truth, bench, other)
        )
    return Simulated(usual.name, rival.name, told, draws)


def _is_rejected(ground: Ground, truth: Hypothesis, bench: Bench, other: Model) -> bool:
    """Return whether a refitted rival predicts no better than the model without the effects."""
    if ground.neither is None:
        return False
    without = bench.fit(ground.start(truth, ground.neither), _ITERATIONS).model
    gains = compare(bench.errors(without).free, bench.errors(other).free)
    return gains.gain < SEARCH.least_gain or gains.p_value > ground.chance_beside_neither(gains.gain)


def diagnose_records(
    ground: Ground,
    usual: Hypothesis,
    voltage: np.ndarray,
    draws: int,
    seed: int,
    each: Callable[[str], None] = lambda text: None,
) -> Simulated:
    """Diagnose noisy records of a model from the one without the effects; count its name alone.

    The records are in turn of all sizes of its effect that are as likely.
    """
    assert ground.neither is not None
    told, sizes = 0, (usual, *usual.sizes)
    for i in range(draws):
        each(f"diagnosis of a simulated record of {usual.name}, {i + 1} of {draws}")
        record = record_of(ground, sizes[i % len(sizes)], voltage, seed + i)
        names = [h.name for h in ground.hypotheses]
        found = diagnose([record], model=ground.neither.parameters, planned=names)
        told += {*found.effects} == {*usual.own}
    return Simulated(usual.name, "all others", told, draws, "diagnosis")
