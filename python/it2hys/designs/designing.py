"""The search for the record that decides most: over families of voltages that a rig can play."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from it2hys.designs.checking import Simulated, diagnose_records, simulate_pair
from it2hys.designs.families import FAMILIES, Family
from it2hys.designs.hypotheses import NEITHER, Question
from it2hys.designs.limits import Limits, Wanted, limits_of
from it2hys.designs.promise import Ground, Separation, worst
from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.errors import InputError
from it2hys.policy import DESIGN
from it2hys.stand.excitations import identification
from it2hys.support.keys import known_names
from it2hys.support.numerals import plain
from it2hys.support.progress import Progress, silent

#: Refits of records of the usual length that a search may take, and the fewest and most records.
_REFITS, _FEWEST, _MOST = 1000, 60, 260
#: Records for every family that may be played, at most.
_BY_FAMILY = 40
#: Refits of the coarse search that a report can wait for, and its records.
_COARSE_REFITS, _COARSE_FEWEST, _COARSE_MOST = 120, 24, 36
#: Score above which a record decides with certainty, and weight of a nat of information on parameters.
_ENOUGH, _OF_PARAMETERS = 0.7, 0.1
#: Share of the records that are spread over the families; the rest refines the best ones.
_SPREAD = 0.6
#: Records that are refined, and that are promised thoroughly.
_REFINED = 3
#: Simulated records for every pair.
_DRAWS = 10
#: Factors by which noise is tried to be smaller.
_QUIETER = np.geomspace(1.25, 1000.0, 31)
#: Length of the ramp from rest to the first voltage of a record at hand, samples.
_RAMP = 100
PAPER, CHIRP = "the paper's signal (22)", "a chirp"


@dataclass(frozen=True, eq=False)
class Design:
    """A record to play, and what it will decide.

    Parameters
    ----------
    question : Question
    limits : Limits
    family, words : str
        What is played: its family, and it in words with the rig's units.
    voltage : ndarray, shape (N,)
        In V, every `limits.sample_time`, from rest to rest.
    readings : dict of str to ndarray, shape (N,)
        What the models read on it without noise, m.
    left : dict of str to ndarray, shape (N,)
        What a model leaves of another's readings once it is refitted to them, m, by what it is.
    separations : tuple of Separation
        Of every pair of models.
    intervals : dict of str to dict
        By model, expected 95 % intervals of its parameters by FMU name, SI units.
    others : dict of str to tuple of Separation
        The same of other voltages, by what they are.
    other_intervals : dict of str to dict
        The same of other voltages, by what they are.
    simulated : tuple of Simulated
        How often simulated records told.
    needed : tuple of str
        What would be needed where the record does not decide.
    seed : int
    seconds : float
        The search took.
    evaluated : int
        Records that were compared.
    """

    question: Question
    limits: Limits
    family: str
    words: str
    voltage: np.ndarray
    readings: dict[str, np.ndarray]
    left: dict[str, np.ndarray]
    separations: tuple[Separation, ...]
    intervals: dict[str, dict[str, tuple[float, float]]]
    others: dict[str, tuple[Separation, ...]]
    other_intervals: dict[str, dict[str, dict[str, tuple[float, float]]]]
    simulated: tuple[Simulated, ...]
    needed: tuple[str, ...]
    seed: int
    seconds: float
    evaluated: int

    @property
    def time(self) -> np.ndarray:
        """Times of the samples, (N,), s."""
        return np.arange(len(self.voltage)) * self.limits.sample_time

    @property
    def names(self) -> tuple[str, ...]:
        """Between what it decides."""
        return tuple(h.name for h in self.question.hypotheses)

    @property
    def power(self) -> float:
        """Least probability of telling a pair of models apart; 1 where there is one alone."""
        return min((s.power for s in self.separations), default=1.0)

    @property
    def decides(self) -> bool:
        """Whether every pair is told apart with the probability that a planned test has."""
        return self.power >= DESIGN.decides

    @cached_property
    def sentences(self) -> list[str]:
        """The promise, in words."""
        noise = f"{1e6 * self.question.noise:.2g} µm"
        if len(self.names) == 1:
            return [
                f"Play this record: {self.words}. Of the records compared, it determines the "
                f"parameters of {self.names[0]} best, at a noise of {noise}."
            ]
        told = f"{told_apart(self.names)} with probability {probability(self.power)}"
        if self.decides:
            return [f"Play this record: {self.words}. It tells {told} at a noise of {noise}."]
        bad = worst(self.separations)
        rival = "the model with none of them" if bad.rival == NEITHER else bad.rival
        return [
            f"No record within these limits decides between {' and '.join(self.names)}. The best one "
            f"that was found tells {told} at a noise of {noise}: refitted, {rival} differs from "
            f"{bad.truth} by {bad.distance:.3g} times the noise over the whole record.",
            *self.needed,
        ]


def probability(value: float) -> str:
    """Return a probability as it is said: never more certain than two digits."""
    return "above 0.99" if value > 0.99 else "below 0.01" if value < 0.01 else f"{value:.2f}"


def told_apart(names: Sequence[str]) -> str:
    """Return what a record tells, behind the verb: delay from lag; or three of them apart."""
    if len(names) == 2:
        return " from ".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]} apart"


def check_resolved(question: Question, wanted: Wanted) -> None:
    """Refuse a sample time that is too coarse for an effect.

    Raises
    ------
    InputError
        If an effect between which is to be decided acts within a sample.
    """
    sample_time = wanted.sample_time or question.base["sampleTime"]
    for hypothesis in question.hypotheses:
        for effect in hypothesis.own:
            values = {**hypothesis.parameters, "sampleTime": sample_time}
            if EVIDENCE[effect].is_within_a_sample(values):
                raise InputError(
                    f"a sample time of {sample_time:g} s is too coarse for {effect}, which acts within "
                    f"a sample ({hypothesis.said or 'as in the parameter set'}): sample faster"
                )


def design(
    question: Question,
    wanted: Wanted | None = None,
    families: Sequence[str] = (),
    seed: int = 0,
    at_hand: Mapping[str, np.ndarray] | None = None,
    draws: int = _DRAWS,
    checked: int = 0,
    coarse: bool = False,
    progress: Progress = silent,
) -> Design:
    """Find the voltage that decides most between models, within what a rig can play.

    Parameters
    ----------
    question : Question
        Between what to decide; of one model alone its parameters are to be determined.
    wanted : Wanted, optional
        Limits of the rig.
    families : sequence of str
        Kinds of voltages that may be played, of `FAMILIES`; by default all.
    seed : int
        The same one gives the same record.
    at_hand : mapping of str to ndarray, optional
        Voltages that were recorded, V, to compare with.
    draws : int
        Simulated records for every pair.
    checked : int
        Simulated records for every model that the diagnosis itself is run on; each takes up to minutes.
    coarse : bool
        Look at few records, promise no intervals and compare with nothing: what a report has time for.
    progress : callable
        Told the share done and what is being done.

    Raises
    ------
    InputError
        If the limits exclude each other, a family is not known, or the sample time is too coarse.
    """
    wanted = wanted or Wanted()
    check_resolved(question, wanted)
    limits = _limits(question, wanted)
    if unknown := [name for name in families if name not in FAMILIES]:
        raise InputError(
            f"no family of voltages {unknown[0]!r}; {known_names(unknown[0], list(FAMILIES))}"
        )
    chosen = [FAMILIES[name] for name in families or FAMILIES]
    return _Search(question, limits, chosen, seed, coarse, progress).run(
        at_hand or {}, 0 if coarse else draws, checked
    )


def _limits(question: Question, wanted: Wanted) -> Limits:
    base = question.base
    return limits_of(wanted, base.voltage_range, base["sampleTime"], question.duration, question.rate)


@dataclass(eq=False)
class _Search:
    """One search: what its phases hand on."""

    question: Question
    limits: Limits
    families: list[Family]
    seed: int
    coarse: bool
    progress: Progress

    def run(self, at_hand: Mapping[str, np.ndarray], draws: int, checked: int) -> Design:
        """Search, promise, compare and check."""
        begin = time.perf_counter()
        self.ground, self.evaluated = Ground(self.question, self.limits), 0
        self.budget = self._budget(self.ground, len(self.families))
        self.progress(0.0, "fitting the rival models")
        family, point = self._best()
        voltage = family.voltage(point, self.limits)
        assert self.limits.holds(voltage)
        separations = self._separations(self.ground, voltage, thorough=True)
        others, other_intervals = {}, {}
        intervals = self._intervals(voltage)
        for name, other in [] if self.coarse else self._others(at_hand):
            self.progress(0.72, f"judging {name}")
            others[name] = self._separations(self.ground, other, thorough=True)
            other_intervals[name] = self._intervals(other)
        needed = self._needed(voltage, separations)
        simulated = self._simulated(voltage, draws, checked)
        return Design(
            self.question,
            self.limits,
            family.name,
            family.described(point, self.limits),
            voltage,
            {h.name: self.ground.reading(h, voltage) for h in self.ground.hypotheses},
            self._left_over(voltage),
            separations,
            intervals,
            others,
            other_intervals,
            simulated,
            needed,
            self.seed,
            time.perf_counter() - begin,
            self.evaluated,
        )

    def _budget(self, ground: Ground, families: int) -> int:
        """Return how many records are compared: fewer where one takes longer."""
        length = self.limits.samples * self.limits.periods / DESIGN.duration_samples
        work = max(1, len(ground.pairs)) * max(length, 0.25)
        if self.coarse:
            return int(np.clip(_COARSE_REFITS / work, _COARSE_FEWEST, _COARSE_MOST))
        return int(np.clip(_REFITS / work, _FEWEST, min(_MOST, max(_FEWEST, _BY_FAMILY * families))))

    # --- the search ------------------------------------------------------------------------------

    def _best(self) -> tuple[Family, np.ndarray]:
        """Return family and point of the best record: spread first, then refined, then looked into."""
        spread = int(_SPREAD * self.budget)
        sizes = np.array([f.size for f in self.families], dtype=float)
        counts = np.maximum(2, np.round(spread * sizes / sizes.sum())).astype(int)
        tried: list[tuple[float, int, np.ndarray]] = []
        for number, (family, count) in enumerate(zip(self.families, counts, strict=True)):
            sampler = qmc.LatinHypercube(family.size, seed=np.random.default_rng([self.seed, number]))
            for point in sampler.random(count):
                score = self._score(family, point, f"searching records: {family.name}")
                tried.append((score, number, point))
        tried.sort(key=lambda t: -t[0])
        each = (self.budget - spread) // _REFINED
        refined = [self._refined(*t, evaluations=each) for t in tried[:_REFINED]]
        refined.sort(key=lambda t: -t[0])
        looked = [
            (self._worth(self.families[n].voltage(point, self.limits), True), n, point)
            for _, n, point in refined
        ]
        _, number, point = max(looked, key=lambda t: t[0])
        return self.families[number], point

    def _refined(
        self, score: float, number: int, point: np.ndarray, evaluations: int
    ) -> tuple[float, int, np.ndarray]:
        """Return a record that a simplex search makes of one, if it is better."""
        family, best = self.families[number], (score, point)

        def cost(p: np.ndarray) -> float:
            nonlocal best
            found = self._score(family, p, f"refining records: {family.name}")
            if found > best[0]:
                best = (found, np.clip(p, 0.0, 1.0))
            return -found if np.isfinite(found) else 1e6

        simplex = np.vstack([point, *(point + d for d in _corners(point))])
        options = {"maxfev": evaluations, "initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-3}
        minimize(cost, point, method="Nelder-Mead", bounds=[(0.0, 1.0)] * family.size, options=options)
        return best[0], number, best[1]

    def _score(self, family: Family, point: np.ndarray, text: str) -> float:
        self.evaluated += 1
        self.progress(0.05 + 0.6 * min(self.evaluated / self.budget, 1.0), text)
        return self._worth(family.voltage(point, self.limits), False)

    def _worth(self, voltage: np.ndarray, thorough: bool) -> float:
        """Return how much a record decides: of the pair that it tells least.

        Beyond what decides by far, what it tells of all parameters counts instead: a record that shows
        nothing but the difference leaves the rest of the model open, and all that may be in its place.
        """
        if np.ptp(voltage) < 0.1 * self.limits.span or not self.ground.is_taken(voltage):
            return -np.inf
        if not self.ground.pairs:
            return self.ground.information(voltage, of_effects=True)
        score = worst(self._separations(self.ground, voltage, thorough)).score
        if not np.isfinite(score):
            return -np.inf
        return min(score, _ENOUGH) + _OF_PARAMETERS * self.ground.information(voltage)

    @staticmethod
    def _separations(ground: Ground, voltage: np.ndarray, thorough: bool) -> tuple[Separation, ...]:
        return tuple(ground.separation(a, b, voltage, thorough) for a, b in ground.pairs)

    def _left_over(self, voltage: np.ndarray) -> dict[str, np.ndarray]:
        """Return what rivals leave of each other's readings."""
        courses = {
            f"{b.name} refitted, less {a.name}": self.ground.left_over(
                a, b, voltage, thorough=True
            ).course
            for a, b in self.ground.pairs
            if b.own
        }
        return {name: course for name, course in courses.items() if course is not None}

    # --- the promise -----------------------------------------------------------------------------

    def _intervals(self, voltage: np.ndarray) -> dict[str, dict[str, tuple[float, float]]]:
        if self.coarse:
            return {}
        return {h.name: self.ground.intervals(h, voltage, self.seed) for h in self.ground.hypotheses}

    def _others(self, at_hand: Mapping[str, np.ndarray]) -> list[tuple[str, np.ndarray]]:
        """Return other voltages of the same length: the paper's, a chirp, and those at hand."""
        limits = self.limits
        return [
            (PAPER, paper_signal(limits)),
            (CHIRP, chirp_signal(limits)),
            *((name, _from_rest(voltage, limits.rest)) for name, voltage in at_hand.items()),
        ]

    def _needed(self, voltage: np.ndarray, separations: tuple[Separation, ...]) -> tuple[str, ...]:
        """Return what would be needed where a record does not decide."""
        if not separations or worst(separations).power >= DESIGN.decides:
            return ()
        self.progress(0.7, "finding what would be needed")
        lefts = [((a, b), self.ground.left_over(a, b, voltage, True)) for a, b in self.ground.pairs]
        texts = []
        for factor in _QUIETER if not self.coarse else ():
            found = tuple(self.ground.judged(*pair, left, factor) for pair, left in lefts)
            if worst(found).power >= DESIGN.decides:
                noise = 1e6 * self.question.noise / factor
                texts.append(
                    f"With {factor:.2g} times less noise ({noise:.2g} µm), by a quieter sensor or "
                    f"by averaging {int(np.ceil(factor**2))} periods, this record would decide."
                )
                break
        else:
            texts.append(
                "" if self.coarse else "No lower noise would make this record decide: refitted, the "
                "models differ at too few of the samples that decide, or not at all."
            )  # fmt: skip
        texts.append(self._with_a_faster_amplifier())
        for effect in {e for h in self.question.hypotheses for e in h.own}:
            if channel := EVIDENCE[effect].channel:
                texts.append(f"A {channel} channel in the records would show {effect} by itself.")
        return tuple(t for t in texts if t)

    def _with_a_faster_amplifier(self) -> str:
        """Return whether a record without limits of the amplifier would decide."""
        base = self.question.base
        free = limits_of(
            Wanted(
                voltage=(self.limits.low, self.limits.high),
                duration=self.limits.duration,
                periods=self.limits.periods,
            ),
            base.voltage_range,
            base["sampleTime"],
        )
        if free.rate <= 1.01 * self.limits.rate and free.highest <= 1.01 * self.limits.highest:
            return ""
        found = _Search(self.question, free, self.families, self.seed, True, silent)
        found.ground, found.evaluated = Ground(self.question, free), 0
        found.budget = _COARSE_FEWEST
        family, point = found._best()
        voltage = family.voltage(point, free)
        promised = self._separations(found.ground, voltage, thorough=True)
        if worst(promised).power < DESIGN.decides:
            return "A faster amplifier would not help: with one, too, no record was found that decides."
        rate = float(np.max(np.abs(np.diff(voltage)))) / free.sample_time
        return (
            f"A faster amplifier would help: with {plain(rate)} V/s and sines up to "
            f"{plain(free.highest)} Hz, {family.described(point, free)} decides."
        )

    def _simulated(self, voltage: np.ndarray, draws: int, checked: int) -> tuple[Simulated, ...]:
        """Return how often simulated records tell the models apart."""
        pairs = [(a, b) for a, b in self.ground.pairs if b.own] if draws else []
        results = []
        for i, (a, b) in enumerate(pairs):
            self.progress(0.75 + 0.2 * i / len(pairs), f"simulated records of {a.name}")
            results.append(simulate_pair(self.ground, a, b, voltage, draws, self.seed))
        if checked and self.ground.neither is not None:

            def each(text: str) -> None:
                self.progress(0.96, text)

            for hypothesis in self.ground.hypotheses:
                results.append(
                    diagnose_records(self.ground, hypothesis, voltage, checked, self.seed, each)
                )
        return tuple(results)


def _corners(point: np.ndarray, step: float = 0.15) -> np.ndarray:
    """Return steps to the other corners of a simplex, each towards the farther bound."""
    return np.diag(np.where(point > 0.5, -step, step))


def paper_signal(limits: Limits) -> np.ndarray:
    """Return the paper's signal (22) over the range, as slow as the band asks for, V."""
    samples = limits.samples * limits.periods
    quickness = min(1.0, limits.highest / 50.0)
    shape = identification(np.arange(samples) * limits.sample_time * quickness)
    return limits.kept(limits.low + limits.span * (shape - shape.min()) / np.ptp(shape))


def chirp_signal(limits: Limits) -> np.ndarray:
    """Return a chirp through the band over the range, V."""
    whole = replace(limits, samples=limits.samples * limits.periods, periods=1)
    return FAMILIES["chirp"].voltage(np.array([0.0, 1.0, 1.0, 0.5, 1.0, 0.0]), whole)


def _from_rest(voltage: np.ndarray, rest: float) -> np.ndarray:
    """Return a recorded voltage behind a ramp from rest."""
    ramp = np.linspace(rest, float(voltage[0]), _RAMP)
    return np.concatenate([ramp, np.full(_RAMP, voltage[0]), voltage])
