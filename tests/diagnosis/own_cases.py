"""Seeded cases for effects that a user writes: what each of the worked examples has to do.

An example is a file of `examples/own_effects` and the physics of `own_physics` that it is written for.
Without the file a diagnosis has to leave the records unexplained; with it, to name it; and where the
records have no such physics, it must not. `run` makes one diagnosis of these.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from diagnosis.cases import Case
from diagnosis.outcomes import Line

from it2hys.diagnosis import Diagnosis, diagnose
from it2hys.fmu.own_library import use_effects

FILES = Path(__file__).parents[2] / "examples" / "own_effects"
#: The physics that each example is written for. Nobody knows what the network is for.
PHYSICS = {
    "second_resonance": "second resonance",
    "friction": "friction",
    "thermal_path": "self-heating",
    "neural": "drag",
}
KINDS = ("absent", "given", "not there")
#: What else is in records without the physics of any example: nothing, and effects of the catalogue.
OTHERS = ((), (), ("play",), (), ("creep",), (), ("resonance",), (), ("drift",), ("nonlinearity",))
TRAINING, SAMPLE_TIME = 4, 1e-4
#: Samples of a record with the physics of an example, and of one without.
LENGTH, SHORTER = 2000, 1200
#: First seed of a range; those from 60000 on were looked at while the examples were written.
LOOKED_AT, FIRST = 60_000, 70_000


@dataclass(frozen=True)
class OwnCase:
    """One diagnosis.

    Parameters
    ----------
    kind : str
        `absent`: with the physics of an example, without its file. `given`: with both. `not there`:
        with the files of all examples, without any of their physics.
    example : str
        Empty where the physics of none is there.
    case : Case
    """

    kind: str
    example: str
    case: Case

    @property
    def name(self) -> str:
        """Unique."""
        return f"{self.example or self.case.name}, {self.kind}, {self.case.seed}"

    @property
    def files(self) -> list[Path]:
        """What the diagnosis is given."""
        examples = {"absent": [], "given": [self.example], "not there": [*PHYSICS]}[self.kind]
        return [FILES / f"{example}.py" for example in examples]

    def diagnosed(self) -> Diagnosis:
        """Return the diagnosis; afterwards the chain is what it was before."""
        case = self.case
        use_effects(self.files)
        try:
            return diagnose(case.train[:TRAINING], case.validation, case.test)
        finally:
            use_effects([])


def with_physics(example: str, seed: int, beside: tuple[str, ...] = ()) -> Case:
    """Return a case with the physics of an example beside other effects, in short records."""
    physics = PHYSICS[example]
    return Case(
        seed, physics, beside, outside=True, anomaly=physics, sample_time=SAMPLE_TIME, length=LENGTH
    )


def without_physics(number: int, seed: int) -> Case:
    """Return a case without that of any example, in short records."""
    truth = OTHERS[number % len(OTHERS)]
    name = "+".join(truth) or "none"
    return Case(seed, name, truth, sample_time=SAMPLE_TIME, length=SHORTER)


def suite(count: int, first: int = FIRST) -> Iterator[OwnCase]:
    """Yield so many seeds of each kind, those of one seed together.

    Every other second resonance has a first one beside it.
    """
    for i in range(count):
        yield OwnCase("not there", "", without_physics(i, first + 5 * i))
        for j, example in enumerate(PHYSICS, start=1):
            first_one = ("resonance",) if example == "second_resonance" and i % 2 else ()
            case = with_physics(example, first + 5 * i + j, first_one)
            yield OwnCase("given", example, case)
            yield OwnCase("absent", example, case)


@dataclass(frozen=True)
class OwnOutcome(Line):
    """What came of one diagnosis.

    Parameters
    ----------
    name, kind, example : str
    named, indistinguishable : tuple of str
    unexplained : bool
    described : int
        Sentences that say what is left.
    noise : float
        True noise, m rms.
    before, after : float
        Error on the test records, m rms, behind their lead-ins.
    inverse_before, inverse_after, inverse_noise : float
        Of the inverse driven by what was measured there, and what noise makes of it, V rms.
    cpu : float
        Processor time, s.
    failure : str
        The message of a run that ended with one.
    """

    name: str
    kind: str
    example: str
    named: tuple[str, ...] = ()
    indistinguishable: tuple[str, ...] = ()
    unexplained: bool = False
    described: int = 0
    noise: float = np.nan
    before: float = np.nan
    after: float = np.nan
    inverse_before: float = np.nan
    inverse_after: float = np.nan
    inverse_noise: float = np.nan
    cpu: float = np.nan
    failure: str = ""

    @property
    def is_right(self) -> bool:
        """Whether it did what the kind of case asks for."""
        if self.failure:
            return False
        if self.kind == "absent":
            return self.unexplained and self.described > 0
        if self.kind == "given":
            return self.example in self.named
        return not {*self.named, *self.indistinguishable} & {*PHYSICS}


def run(own: OwnCase) -> OwnOutcome:
    """Make one diagnosis; a failure is its outcome."""
    outcome = OwnOutcome(own.name, own.kind, own.example)
    start = time.process_time()
    try:
        found = own.diagnosed()
    except Exception as error:  # whatever it is, the others go on and the case counts as failed
        return replace(outcome, failure=f"{type(error).__name__}: {error}")
    tests = [[j for j in judged if j.role == "test"] for judged in (found.before, found.after)]
    return replace(
        outcome,
        named=found.effects,
        indistinguishable=tuple(e for group in found.indistinguishable for e in group),
        unexplained=bool(found.unexplained),
        described=len(found.left_over),
        noise=own.case.noise_rms,
        before=_rms([j.e_rms for j in tests[0]]),
        after=_rms([j.e_rms for j in tests[1]]),
        inverse_before=_rms([j.inverse.e_rms for j in tests[0]]),
        inverse_after=_rms([j.inverse.e_rms for j in tests[1]]),
        inverse_noise=_rms([j.inverse.noise for j in tests[1]]),
        cpu=time.process_time() - start,
    )


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
