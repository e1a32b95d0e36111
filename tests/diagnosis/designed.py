"""The loop closed on the independent simulator: a record that cannot tell, a design, the next record.

A stage of `cases` has one effect of a pair. Its first record is one on which the two look alike, or
neither shows. From what that leaves, the next record is designed between the two, and all that the
first one leaves open beside them; it is played on the stage, and, for comparison, so are the paper's
signal and a chirp of the same length.
"""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass, replace

import numpy as np
from diagnosis import simulator as sim
from diagnosis.cases import Case

from it2hys.designs.designing import CHIRP, PAPER, chirp_signal, design, paper_signal
from it2hys.designs.hypotheses import between
from it2hys.designs.limits import Wanted
from it2hys.diagnosis import diagnose
from it2hys.records import Record

PAIRS = (
    ("delay", "lag"), ("play", "creep"), ("play", "lag"), ("lag", "resonance"),
    ("creep", "drift"), ("nonlinearity", "play"), ("saturation", "slew"),
)  # fmt: skip
#: Frequency of the first record at the sample time of `_QUICK`, Hz and s.
_SINE, _QUICK = 20.0, 1e-4
#: Steps up and down of a first record between two levels.
_LEVELS = 4
#: Samples in which the amplifier goes through the range at most. Steps in one would make a stage with
#: little damping ring over several times its travel; a slew limit may show in nothing slower.
_RISE, _AT_ONCE = 10, 1


@dataclass(frozen=True)
class Loop:
    """What came of one stage.

    Parameters
    ----------
    pair : tuple of str
    seed : int
    truth : str
        The effect that the stage has.
    length : int
        Samples of each record.
    noise : float
        That of the records, as a multiple of that of the suite's.
    first, first_open : tuple of str
        What was named on the first record, and what it was said not to tell apart.
    family : str
        Of the designed record.
    promised, paper_promised, chirp_promised : float
        Probability, told beforehand, of telling the truth from all others by the record that followed.
    designed, paper, chirp : tuple of str
        What was named on it.
    design_seconds, seconds : float
        Processor time of the design, and of all.
    failure : str
        The message of a run that ended with one.
    """

    pair: tuple[str, ...]
    seed: int
    truth: str
    length: int = 4000
    noise: float = 1.0
    first: tuple[str, ...] = ()
    first_open: tuple[str, ...] = ()
    family: str = ""
    promised: float = float("nan")
    paper_promised: float = float("nan")
    chirp_promised: float = float("nan")
    designed: tuple[str, ...] = ()
    paper: tuple[str, ...] = ()
    chirp: tuple[str, ...] = ()
    design_seconds: float = 0.0
    seconds: float = 0.0
    failure: str = ""

    @classmethod
    def read(cls, line: str) -> Loop:
        """Return what `line` of this class wrote."""
        return cls(**{k: tuple(v) if isinstance(v, list) else v for k, v in json.loads(line).items()})

    @property
    def line(self) -> str:
        """One line of JSON."""
        return json.dumps(asdict(self)) + "\n"

    def promise(self, kind: str) -> float:
        """Probability told beforehand of naming the truth on a record: designed, paper or chirp."""
        return self.promised if kind == "designed" else getattr(self, f"{kind}_promised")

    def is_right(self, named: tuple[str, ...]) -> bool:
        """Whether the truth was named, and nothing else."""
        return set(named) == {self.truth}

    @property
    def was_open(self) -> bool:
        """Whether the first record did not name the truth alone."""
        return not self.is_right(self.first)


def measured(case: Case, voltage: np.ndarray, name: str, seed: int, noise_rms: float) -> Record:
    """Return a record of a case's stage on a voltage, (N,), from long rest, with noise, m."""
    clock = np.arange(len(voltage)) * case.grid.sample_time
    around = sim.Surroundings(case.grid, clock[None])
    clean = 1e-6 * case.plant.run(voltage[None], around)[0]
    noise = noise_rms * np.random.default_rng([case.seed, seed]).standard_normal(len(voltage))
    return Record(name, clock, voltage, clean + noise, case.grid.sample_time)


def stage(pair: tuple[str, str], seed: int, length: int) -> Case:
    """Return a stage with one effect of a pair: the first for even seeds."""
    truth = pair[seed % 2]
    return Case(seed, f"{truth} of {pair}", (truth,), drift_by="time", length=length)


def first_voltage(case: Case, pair: tuple[str, str], length: int) -> np.ndarray:
    """Return the voltage of the first record, over the case's range, which is to leave a pair open.

    A sine of many periods cannot tell what delays, and no limit of the rate touches it. What rises once
    and slowly shows no memory, and creep and a drift with time lift it alike. Steps between two levels
    show nothing of what is between or beyond them.
    """
    greatest = max(float(r.voltage.max()) for r in case.train)
    clock = np.arange(length)
    shape = 0.5 * (1.0 - np.cos(2.0 * np.pi * _SINE * _QUICK * clock))
    if "creep" in pair:
        shape = 0.5 * (1.0 - np.cos(np.pi * clock / (length - 1)))
    elif case.truth[0] in ("saturation", "nonlinearity"):
        shape = 1.0 * (_LEVELS * clock // length % 2)
    return greatest * shape


def run_loop(
    pair: tuple[str, str],
    seed: int,
    length: int = 4000,
    noise: float = 1.0,
    compared: bool = True,
    families: tuple = (),
) -> Loop:
    """Close the loop on one stage; a failure is its outcome."""
    case = stage(pair, seed, length)
    loop, begin = Loop(pair, seed, case.truth[0], length, noise), time.process_time()
    noise_rms = noise * case.noise_rms
    try:
        voltage = first_voltage(case, pair, length)
        first = diagnose([measured(case, voltage, "first", 1, noise_rms)])
        open_ = tuple(e for group in first.indistinguishable for e in group)
        loop = replace(loop, first=first.effects, first_open=open_)
        # as from the report: between all that the first record leaves open
        rivals = (*pair, *(e for e in open_ if e not in pair))
        question = between(first.parameters, rivals, noise_rms)
        low, high = question.base.voltage_range
        sample_time = case.grid.sample_time
        rise = _AT_ONCE if "slew" in pair else _RISE
        rate = (high - low) / (rise * sample_time)
        wanted = Wanted(duration=length * sample_time, rate=rate)
        before = time.process_time()
        found = design(question, wanted, families, seed, draws=0)
        loop = replace(loop, design_seconds=time.process_time() - before)
        powers = {"promised": found.separations}
        powers |= {"paper_promised": found.others[PAPER], "chirp_promised": found.others[CHIRP]}
        promised = {n: min(s.power for s in p if s.truth == loop.truth) for n, p in powers.items()}
        loop = replace(loop, family=found.family, **promised)
        voltages = {"designed": found.voltage}
        if compared:
            limits = found.limits
            voltages |= {"paper": paper_signal(limits), "chirp": chirp_signal(limits)}
        for name, voltage in voltages.items():
            record = measured(case, voltage, name, 2, noise_rms)
            told = diagnose([record], model=question.base, planned=rivals)
            loop = replace(loop, **{name: told.effects})
    except Exception as error:  # whatever it is, the others go on and this one counts as failed
        loop = replace(loop, failure=f"{type(error).__name__}: {error}")
    return replace(loop, seconds=time.process_time() - begin)
