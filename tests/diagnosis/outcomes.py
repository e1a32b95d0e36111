"""What comes of a case: its diagnosis, and a model told the truth on the same records."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Self

import numpy as np
from diagnosis.cases import Case

from it2hys.diagnosis import Diagnosis, diagnose
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS, active_effects
from it2hys.reports.pair_report import at_rest, scaled_reference


class Line:
    """A dataclass as a line of JSON."""

    @classmethod
    def read(cls, line: str) -> Self:
        """Return what `line` of this class wrote."""
        values = json.loads(line)
        return cls(**{k: tuple(v) if isinstance(v, list) else v for k, v in values.items()})

    @property
    def line(self) -> str:
        """One line of JSON."""
        return json.dumps(asdict(self)) + "\n"


@dataclass(frozen=True)
class Outcome(Line):
    """What came of one case.

    Parameters
    ----------
    name, kind : str
        Kind is what was undeclared, joined by "+"; "none", or "outside".
    seeds : int
        First of its range of seeds.
    there, named, indistinguishable : tuple of str
        Effects to be named, and those that were, and those that were said not to be told apart.
    unexplained : bool
    noise : float
        True noise, m rms.
    cold : tuple of bool
        Of each test record whether the error is that from a cold start; otherwise it is that behind the
        lead-in.
    errors, best : tuple of float
        Of each test record, m rms: of the packaged FMU, and of one of a model told the truth. Empty
        where there is none.
    inverse, inverse_best, inverse_noise : tuple of float
        The same of the inverse on the measured displacement, V rms, and what noise makes of it.
    held_back : float
        Share of the tracking reference at which the inverse found cannot follow it; NaN where a limit
        of the amplifier is in the model.
    cpu : float
        Processor time of the diagnosis, s.
    seconds : dict of str to float
        Of each phase.
    failure, failure_of_truth : str
        The message of a run that ended with one.
    """

    name: str
    kind: str
    seeds: int
    there: tuple[str, ...]
    named: tuple[str, ...] = ()
    indistinguishable: tuple[str, ...] = ()
    unexplained: bool = False
    noise: float = np.nan
    cold: tuple[bool, ...] = ()
    errors: tuple[float, ...] = ()
    best: tuple[float, ...] = ()
    inverse: tuple[float, ...] = ()
    inverse_best: tuple[float, ...] = ()
    inverse_noise: tuple[float, ...] = ()
    held_back: float = np.nan
    cpu: float = np.nan
    seconds: dict[str, float] | None = None
    failure: str = ""
    failure_of_truth: str = ""

    @property
    def is_right(self) -> bool:
        """Whether exactly what is there was named."""
        return not self.failure and set(self.named) == set(self.there)

    @property
    def false(self) -> set[str]:
        """What was named and is not there."""
        return {*self.named} - {*self.there}

    @property
    def over_noise(self) -> float:
        """Error over the true noise; infinite where the diagnosis failed."""
        return np.inf if self.failure else _rms(self.errors) / self.noise

    @property
    def over_truth(self) -> float:
        """Error over that of a model told the truth; NaN where there is none."""
        return np.inf if self.failure else _rms(self.errors) / _rms(self.best)

    @property
    def truth_over_noise(self) -> float:
        """Error of a model told the truth over the true noise; NaN where there is none."""
        return _rms(self.best) / self.noise

    @property
    def inverse_over_truth(self) -> float:
        """Error of the inverse over that of a model told the truth; NaN where there is none."""
        return np.inf if self.failure else _rms(self.inverse) / _rms(self.inverse_best)


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if values else np.nan


def run_case(case: Case, first: int) -> Outcome:
    """Diagnose one case, and fit a model told the truth; a failure of either is its outcome."""
    outcome = diagnosed(case, first)
    if outcome.failure or case.outside:
        return outcome
    try:
        return replace(outcome, **_told_the_truth(case))
    except Exception as error:
        return replace(outcome, failure_of_truth=f"{type(error).__name__}: {error}")


def diagnosed(case: Case, first: int) -> Outcome:
    """Diagnose one case; a failure is its outcome."""
    kind = "outside" if case.outside else "+".join(case.undeclared) or "none"
    outcome = Outcome(case.name, kind, first, case.undeclared)
    try:
        outcome = replace(outcome, noise=case.noise_rms, cold=_from_cold_start(case))
        start = time.process_time()
        found = diagnose(case.train, case.validation, case.test, declared=case.declared)
        return replace(outcome, **_measured(case, found), cpu=time.process_time() - start)
    except Exception as error:  # whatever it is, the suite goes on and the case counts as failed
        return replace(outcome, failure=f"{type(error).__name__}: {error}")


def _from_cold_start(case: Case) -> tuple[bool, ...]:
    """Tell of which test records the first displacement says how they begin.

    Of a line it does not: its phase is each record's own.
    """
    return tuple(rest and "hum" not in case.truth for rest in case.tests_begin_at_rest)


def _measured(case: Case, found: Diagnosis) -> dict:
    judged = [j for j in found.after if j.role == "test"]
    return {
        "named": found.effects,
        "indistinguishable": tuple(e for group in found.indistinguishable for e in group),
        "unexplained": bool(found.unexplained),
        "errors": _packaged_errors(case, found),
        "inverse": tuple(float(j.inverse.e_rms) for j in judged),
        "inverse_noise": tuple(float(j.inverse.noise) for j in judged),
        "held_back": _held_back(case, found),
        "seconds": found.seconds,
    }


def _packaged_errors(case: Case, found: Diagnosis) -> tuple[float, ...]:
    """Return the errors of the FMU as packaged on the test records, m rms."""
    judged = [j for j in found.after if j.role == "test"]
    cold = _from_cold_start(case)
    return tuple(float(j.cold_start if c else j.e_rms) for j, c in zip(judged, cold, strict=True))


def _told_the_truth(case: Case) -> dict:
    others = [name for name in EFFECTS if name not in case.truth]
    told = diagnose(case.train, case.validation, case.test, declared=case.truth, excluded=others)
    inverse = tuple(float(j.inverse.e_rms) for j in told.after if j.role == "test")
    return {"best": _packaged_errors(case, told), "inverse_best": inverse}


def _held_back(case: Case, found: Diagnosis) -> float:
    if {"slew", "saturation"} & {*active_effects(found.parameters)}:
        return np.nan
    reference = scaled_reference(case.train)
    start = found.parameters.replace(**at_rest(reference[0]))
    return float(np.mean(compiled.chain_inverse_run(start, reference)[1]))
