"""The search for the record that decides most: over families of voltages that a rig can play."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial

import numpy as np
from scipy.stats import qmc

from it2hys.designs.checking import Simulated, diagnose_records, simulate_pair
from it2hys.designs.families import FAMILIES, Family
from it2hys.designs.hypotheses import NEITHER, Hypothesis, Question
from it2hys.designs.limits import Limits, Wanted, limits_of
from it2hys.designs.promise import Ground, Left, Separation, worst
from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.errors import InputError
from it2hys.policy import DESIGN
from it2hys.stand.excitations import identification
from it2hys.support.keys import known_names
from it2hys.support.numerals import plain
from it2hys.support.progress import Progress, part, silent

#: Refits of records of the usual length that a search may take, and the fewest and most records.
_REFITS, _FEWEST, _MOST = 1000, 60, 260
#: Records for every family that may be played, at most.
_BY_FAMILY = 40
#: Refits of the coarse search that a report can wait for, and its records.
_COARSE_REFITS, _COARSE_FEWEST, _COARSE_MOST = 120, 24, 36
#: Score above which a record decides also where an effect is a fifth of its assumed size, and weight of
#: a nat of information on parameters.
_ENOUGH, _OF_PARAMETERS = 2.0 * float(np.log(5.0)), 0.1
#: Score below which a pair shows less than half of what it would have to.
_HOPELESS = -2.0 * float(np.log(2.0))
#: Power that is no less for a larger effect.
_CERTAIN = 0.999
#: Share of the records that are spread over the families; the rest refines the best ones.
_SPREAD = 0.6
#: Records that are refined, and that are promised thoroughly.
_REFINED = 3
#: Standard deviation of the first changes of a shape parameter, and factors of it after one for the
#: better and after any other.
_REACH, _WIDER, _NARROWER = 0.15, 1.5, 0.9
#: Simulated records for every pair.
_DRAWS = 10
#: Factors by which noise is tried to be smaller.
_QUIETER = np.geomspace(1.25, 1000.0, 31)
#: Length of the ramp from rest to the first voltage of a record at hand, samples.
_RAMP = 100
#: Point of the chirp that goes once through the band, over the whole range.
_WHOLE_CHIRP = np.array([0.0, 1.0, 1.0, 0.5, 1.0, 0.0])
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
        """Least probability of telling a pair of models apart, 0 of one on which nothing is known.

        Of one model alone it is 1.
        """
        return float(np.nan_to_num(worst(self.separations).power)) if self.separations else 1.0

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
            found = f"Play this record: {self.words}. It tells {told} at a noise of {noise}."
            return [" ".join([found, *self._as_good])]
        bad = worst(self.separations)
        rival = "the model with none of them" if bad.rival == NEITHER else bad.rival
        return [
            f"No record within these limits decides between {' and '.join(self.names)}. The best one "
            f"that was found tells {told} at a noise of {noise}: refitted, {rival} differs from "
            f"{bad.truth} by {bad.distance:.3g} times the noise over the whole record.",
            *self.needed,
        ]

    @property
    def _as_good(self) -> list[str]:
        """Return a sentence on the usual signals that decide, too, if there are any."""
        known = {n: worst(self.others[n]).power for n in (CHIRP, PAPER) if n in self.others}
        decide = [f"{n} ({probability(p)})" for n, p in known.items() if p >= DESIGN.decides]
        return [f"Of the same length, {' or '.join(decide)} would decide, too."] if decide else []


def probability(value: float | None) -> str:
    """Return a probability as it is said: never more certain than two digits."""
    if value is None or np.isnan(value):
        return "not known"
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
    return Search(question, limits, chosen, seed, coarse, progress).run(
        at_hand or {}, 0 if coarse else draws, checked
    )


def takes_long(question: Question) -> bool:
    """Return whether even the coarse design of a question takes longer than a report can wait.

    Raises
    ------
    InputError
        As `design` does.
    """
    wanted = Wanted()
    check_resolved(question, wanted)
    search = Search(question, _limits(question, wanted), [], 0, True, silent)
    return search.work > DESIGN.most_work


def _limits(question: Question, wanted: Wanted) -> Limits:
    base = question.base
    return limits_of(wanted, base.voltage_range, base["sampleTime"], question.duration, question.rate)


@dataclass(eq=False)
class Search:
    """One search: what its phases hand on."""

    question: Question
    limits: Limits
    families: list[Family]
    seed: int
    coarse: bool
    progress: Progress
    evaluated: int = 0

    @cached_property
    def ground(self) -> Ground:
        """The models, and what refits of them start from."""
        return Ground(self.question, self.limits)

    @cached_property
    def work(self) -> float:
        """Refits of records of the usual length that comparing one record takes."""
        length = self.limits.samples * self.limits.periods / DESIGN.duration_samples
        return max(1, len(self.ground.pairs)) * max(length, 0.25)

    @cached_property
    def budget(self) -> int:
        """How many records are compared: fewer where one takes longer."""
        if self.coarse:
            return int(np.clip(_COARSE_REFITS / self.work, _COARSE_FEWEST, _COARSE_MOST))
        most = min(_MOST, max(_FEWEST, _BY_FAMILY * len(self.families)))
        return int(np.clip(_REFITS / self.work, _FEWEST, most))

    @cached_property
    def _pairs(self) -> list[tuple[Hypothesis, Hypothesis]]:
        """All pairs that a record is sought for, first the one that the record before told least."""
        return list(self.ground.sought)

    @cached_property
    def _lefts(self) -> dict[tuple[str, str, bytes], Left]:
        """What thorough refits left, by pair and voltage."""
        return {}

    def run(self, at_hand: Mapping[str, np.ndarray], draws: int, checked: int) -> Design:
        """Search, promise, compare and check."""
        begin = time.perf_counter()
        self.progress(0.0, "fitting the rival models")
        family, point = self._best()
        voltage = family.voltage(point, self.limits)
        assert self.limits.holds(voltage)
        separations = self._separations(voltage)
        others, other_intervals = {}, {}
        intervals = self._intervals(voltage)
        for name, other in [] if self.coarse else self._others(at_hand):
            self.progress(0.72, f"judging {name}")
            others[name] = self._separations(other)
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

    # --- the search ------------------------------------------------------------------------------

    def _best(self) -> tuple[Family, np.ndarray]:
        """Return family and point of the best record: spread first, then refined, then looked into."""
        spread = int(_SPREAD * self.budget)
        sizes = np.array([f.size for f in self.families], dtype=float)
        counts = np.maximum(2, np.round(spread * sizes / sizes.sum())).astype(int)
        tried: list[tuple[float, int, np.ndarray]] = []
        for number, (family, count) in enumerate(zip(self.families, counts, strict=True)):
            sampler = qmc.LatinHypercube(family.size, seed=np.random.default_rng([self.seed, number]))
            points = sampler.random(count)
            if family.name == "chirp":
                points[0] = _WHOLE_CHIRP
            for point in points:
                least = tried[_REFINED - 1][0] if len(tried) >= _REFINED else -np.inf
                score = self._score(family, point, f"searching records: {family.name}", least)
                tried.append((score, number, point))
                tried.sort(key=lambda t: -t[0])
        each = (self.budget - spread) // _REFINED
        refined = [self._refined(*t, evaluations=each) for t in tried[:_REFINED]]
        refined.sort(key=lambda t: -t[0])
        best, chosen = -np.inf, refined[0]
        for record in refined:
            _, number, point = record
            worth = self.worth(self.families[number].voltage(point, self.limits), best, thorough=True)
            if worth > best:
                best, chosen = worth, record
        return self.families[chosen[1]], chosen[2]

    def _refined(
        self, score: float, number: int, point: np.ndarray, evaluations: int
    ) -> tuple[float, int, np.ndarray]:
        """Return a record that changes of one make of it, each kept where it is for the better."""
        family, reach = self.families[number], _REACH
        rng = np.random.default_rng([self.seed, number, self.evaluated])
        for _ in range(evaluations):
            trial = np.clip(point + reach * rng.standard_normal(family.size), 0.0, 1.0)
            found = self._score(family, trial, f"refining records: {family.name}", score)
            reach *= _WIDER if found > score else _NARROWER
            if found > score:
                score, point = found, trial
        return score, number, point

    def _score(self, family: Family, point: np.ndarray, text: str, least: float) -> float:
        self.evaluated += 1
        self.progress(0.05 + 0.6 * min(self.evaluated / self.budget, 1.0), text)
        return self.worth(family.voltage(point, self.limits), least)

    def worth(self, voltage: np.ndarray, least: float = -np.inf, thorough: bool = False) -> float:
        """Return how much a record decides: of the pair that it tells least, and of all.

        Where no record tells one pair, what it tells of the others decides on it: a diagnosis may still
        name what is there, if a rival has more parameters or lacks its signature. Beyond what decides
        by far, what it tells of all parameters counts instead: a record that shows nothing but the
        difference leaves the rest of the model open, and all that may be in its place.
        Of a record that is worth no more than `least` something is returned that is no more, either: it
        is known at the first pair that the record tells too little, and the others are not refitted.
        """
        if np.ptp(voltage) < 0.1 * self.limits.span or not self.ground.is_taken(voltage):
            return -np.inf
        if not self._pairs:
            return self.ground.information(voltage, of_effects=True)
        of_parameters = _OF_PARAMETERS * self.ground.information(voltage)
        quick = cache(partial(self.ground.left_over, voltage=voltage))
        left = partial(self._left, voltage) if thorough else quick
        scores = np.full(len(self._pairs), _ENOUGH)
        for place, pair in enumerate(self._pairs):
            score = self._judged(pair, left).score
            if score == -np.inf:  # a run is on its way to infinity
                return -np.inf
            scores[place] = np.clip(score, _HOPELESS, _ENOUGH)
            worth = float(np.min(scores) + np.mean(np.minimum(scores, 0.0))) + of_parameters
            if not worth > least:
                # what told the last record from a better one soonest is asked for first of the next
                self._pairs.insert(0, self._pairs.pop(place))
                break
        return worth

    def _judged(
        self, pair: tuple[Hypothesis, Hypothesis], left: Callable[..., Left], quieter: float = 1.0
    ) -> Separation:
        """Return how well a record tells a pair, from what models leave of the readings of others.

        Whether the rival comes up at all does not matter where it is told from the truth by far.
        """
        truth, rival = pair
        found = self.ground.judged(truth, rival, left(truth, rival), None, quieter)
        neither = self.ground.neither
        if not rival.own or neither is None or not -np.inf < found.score < _ENOUGH:
            return found
        return self.ground.judged(truth, rival, left(truth, rival), left(truth, neither), quieter)

    def _left(self, voltage: np.ndarray, truth: Hypothesis, rival: Hypothesis) -> Left:
        """Return what a thorough refit leaves, kept: of the best record it is asked for again."""
        key = (truth.name, rival.name, voltage.tobytes())
        if key not in self._lefts:
            self._lefts[key] = self.ground.left_over(truth, rival, voltage, thorough=True)
        return self._lefts[key]

    def _separations(self, voltage: np.ndarray, quieter: float = 1.0) -> tuple[Separation, ...]:
        """Return how well a record tells every pair, at a noise that is so many times smaller.

        The probability is the mean of those of all sizes that are as likely; of other parameters that
        are, the ones count by which it is told least.
        """
        left = partial(self._left, voltage)
        found = []
        for truth, rival in self.ground.pairs:
            usual, *others = self._of_sizes(truth, rival, left, quieter)
            mean = float(np.mean([s.power for s in (usual, *others)]))
            kinds = [self._judged((t, rival), left, quieter) for t in truth.variants]
            found.append(replace(worst([replace(usual, power=mean), *kinds]), truth=truth.name))
        return tuple(found)

    def _of_sizes(
        self, truth: Hypothesis, rival: Hypothesis, left: Callable[..., Left], quieter: float
    ) -> list[Separation]:
        """Return how well a record tells an effect of the usual size, and of the others.

        Where it tells the smaller one for certain, it tells the larger one.
        """
        found = [self._judged((truth, rival), left, quieter)]
        for other in truth.sizes:
            if len(found) > 1 and min(s.power for s in found) > _CERTAIN:
                break
            found.append(self._judged((other, rival), left, quieter))
        return found

    def _left_over(self, voltage: np.ndarray) -> dict[str, np.ndarray]:
        """Return what rivals leave of each other's readings."""
        courses = {
            f"{b.name} refitted, less {a.name}": self._left(voltage, a, b).course
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
        texts = []
        for factor in _QUIETER if not self.coarse else ():
            if worst(self._separations(voltage, factor)).power >= DESIGN.decides:
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
        longest = self.question.duration or 0.0
        if longest > self.limits.duration:
            texts.append(
                f"A longer record shows more, and takes longer to find: --duration {plain(longest, 4)} "
                "asks for one as long as the longest that was measured."
            )
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
        progress = part(self.progress, 0.7, 0.72)
        found = Search(self.question, free, self.families, self.seed, True, progress)
        family, point = found._best()
        voltage = family.voltage(point, free)
        promised = found._separations(voltage)
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


def paper_signal(limits: Limits) -> np.ndarray:
    """Return the paper's signal (22) over the range, as slow as the band asks for, V."""
    samples = limits.samples * limits.periods
    quickness = min(1.0, limits.highest / 50.0)
    shape = identification(np.arange(samples) * limits.sample_time * quickness)
    return limits.kept(limits.low + limits.span * (shape - shape.min()) / np.ptp(shape))


def chirp_signal(limits: Limits) -> np.ndarray:
    """Return a chirp through the band over the range, V."""
    whole = replace(limits, samples=limits.samples * limits.periods, periods=1)
    return FAMILIES["chirp"].voltage(_WHOLE_CHIRP, whole)


def _from_rest(voltage: np.ndarray, rest: float) -> np.ndarray:
    """Return a recorded voltage behind a ramp from rest."""
    ramp = np.linspace(rest, float(voltage[0]), _RAMP)
    return np.concatenate([ramp, np.full(_RAMP, voltage[0]), voltage])
