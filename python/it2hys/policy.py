"""The thresholds that decide what a diagnosis says, each with its unit, its meaning and its source.

A threshold follows from a statistic, or from what makers and textbooks state, or it was chosen by hand
on simulated stages, on the seeds 0 to 9999 of the suite in `tests/diagnosis`, or with a measured stage
in sight. What a number chosen by hand means is said beside it; it does not follow from that. What
happens at half and at double of it is measured on other seeds by `benchmarks/thresholds.py`, and
`docs/policy.md` has all of it in one table. Numbers that cost time or memory alone, or that rounding
asks for, stay beside the code.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

#: Sources that many thresholds share.
_SUITE = "chosen by hand on seeds 0 to 9999"
_MEASURED = "chosen by hand with a measured stage in sight"
_CONVENTION = "convention: a reader would call less of it nothing"


def _number(value: Any, unit: str, meaning: str, source: str = _SUITE) -> Any:
    return field(default=value, metadata={"unit": unit, "meaning": meaning, "source": source})


@dataclass(frozen=True)
class Search:
    """Which additions to a model are accepted."""

    budget: float = _number(
        0.05, "1",
        "probability that a search names anything by chance",
        "statistic: Bonferroni, in equal parts on the most comparisons that a search can make",
    )  # fmt: skip
    least_gain: float = _number(
        0.05, "share of the error",
        "least share by which an addition has to lower the error",
        _CONVENTION,
    )  # fmt: skip
    clear_gain: float = _number(
        0.1, "share of the error",
        "gain from which on an addition need take no share of what exceeds the noise",
    )  # fmt: skip
    least_share: float = _number(
        0.25, "share of the excess",
        "least share that an addition takes of what exceeds the noise",
    )  # fmt: skip
    least_excess: float = _number(
        0.3, "noise",
        "excess over the noise below which nothing can be told of it",
    )  # fmt: skip
    spoils: float = _number(
        0.1, "share of the error",
        "share by which the inverse's error may rise",
        _SUITE,
    )  # fmt: skip
    noisy: float = _number(
        2.0, "answer to noise",
        "an inverse's error up to so many times its answer to the reference's noise is no fault of "
        "the model",
    )  # fmt: skip
    equal: float = _number(
        0.03, "share of the error",
        "share by which the free run may get worse where the inverse gets better",
    )  # fmt: skip
    inverse_gain: float = _number(
        0.25, "share of the error",
        "gain of the inverse that makes up for it, with a delay",
    )  # fmt: skip
    commensurate: float = _number(
        0.2, "share of the gain",
        "least gain on the training records, as a share of that on what decides",
    )  # fmt: skip
    telling: float = _number(
        0.02, "share of the error",
        "least gain by which one of two equally simple models is the better one",
    )  # fmt: skip
    refined: float = _number(
        0.01, "share of the error",
        "least gain for a variant of a model, with the same effects, to be taken",
    )  # fmt: skip
    likely: float = _number(
        0.05, "probability",
        "largest probability by chance of a variant's gain, and of an effect's signature",
        "statistic: the usual level of one test; nothing is named by it alone",
    )  # fmt: skip
    promising: float = _number(
        0.7, "share of the cost",
        "an addition that is not accepted is followed, where no other is, if it lowers the cost on "
        "the training records to less than this",
    )  # fmt: skip
    beam_ratio: float = _number(
        2.0, "best error",
        "models with more than so many times the error of the best are not followed",
    )  # fmt: skip
    block: float = _number(
        4.0, "correlation times",
        "length of a block of the bootstrap",
        "statistic: blocks have to be a few correlation times long to count as independent "
        "(`tests/unit/test_comparison.py` shows the calibration)",
    )  # fmt: skip
    fewest_blocks: int = _number(
        8, "blocks",
        "fewest blocks of a record",
        "statistic: fewer have no spread to speak of",
    )  # fmt: skip
    step: float = _number(
        0.05, "share of the voltage range",
        "change from one sample to the next that is a step",
    )  # fmt: skip
    plain: float = _number(
        0.2, "share of the error",
        "what an effect takes away on the training records is mentioned from here on",
        _CONVENTION,
    )  # fmt: skip


@dataclass(frozen=True)
class Noise:
    """When a residual is noise."""

    little: float = _number(
        1.25, "noise",
        "residuals of all records up to this may be the noise and a little misfit",
    )  # fmt: skip
    little_alone: float = _number(
        1.5, "noise",
        "the same of one record of several",
    )  # fmt: skip
    level: float = _number(
        0.001, "probability",
        "of the least likely property, from which on a residual is more than noise",
        "chosen by hand on seeds 0 to 9999; of the smallest of several, corrected for their number",
    )  # fmt: skip
    reached: float = _number(
        1.02, "noise",
        "a search ends where no more than this is left",
    )  # fmt: skip
    nearly: float = _number(
        1.1, "noise",
        "a search ends where no more than this is left and it looks like noise",
    )  # fmt: skip
    short_memory: float = _number(
        0.6, "1",
        "greatest pole of noise that counts as of short memory",
        "chosen by hand on seeds 0 to 9999",
    )  # fmt: skip
    jump: float = _number(
        8.0, "standard deviations",
        "change from one sample to the next that is a jump",
        "chosen by hand on seeds 0 to 9999; below 1e-14 by chance for Gaussian noise",
    )  # fmt: skip
    step: float = _number(
        0.02, "share of the voltage span",
        "change of the voltage after which none is counted",
    )  # fmt: skip
    after_step: int = _number(
        50, "samples",
        "for so long none is counted",
    )  # fmt: skip
    stronger: float = _number(
        1.2, "rms",
        "a residual is said to be strong after turning points from this multiple on",
        _CONVENTION,
    )  # fmt: skip
    close: float = _number(
        0.02, "share of the record",
        "what counts as after a turning point",
        _CONVENTION,
    )  # fmt: skip
    explained: float = _number(
        0.8, "share of the power",
        "below this it is said that something else than the voltage moves the stage",
        "statistic: it then moves it half as far as the voltage does, since sqrt(0.2 / 0.8) = 0.5",
    )  # fmt: skip
    motion: float = _number(
        2.0, "1",
        "ratio of two estimates of the noise above which differences see motion",
        "statistic: 1 for white noise, 1.3 for noise of a pole of 0.6",
    )  # fmt: skip
    lacking: float = _number(
        1.5, "noise",
        "free-run error from which on the report of `identify` says that the model lacks something",
    )  # fmt: skip
    finest: float = _number(
        1e-07, "share of the travel",
        "finest resolution of a sensor",
        "makers: 23 bits",
    )  # fmt: skip
    least_step: float = _number(
        1e-05, "share of the travel",
        "coarsest step of readings that is no more than the digits of a file",
        _SUITE,
    )  # fmt: skip


@dataclass(frozen=True)
class Physics:
    """What the effects may be, and what is none of them."""

    shortest_shift: float = _number(
        0.001, "samples",
        "shortest delay that goes with a fast effect",
        "rounding: none at all has no slope",
    )  # fmt: skip
    damped: float = _number(
        0.4, "1",
        "damping of a resonance above which it smooths and does not ring",
        "chosen by hand on seeds 0 to 9999; the overshoot of a step is 25 % there",
    )  # fmt: skip
    dynamics_longest: float = _number(
        20.0, "samples",
        "longest time constant of dynamics",
        "convention: what is slower may be creep",
    )  # fmt: skip
    slow_gain: float = _number(
        0.05, "1",
        "largest gain of one creep term",
        "makers: 1 to 2 % of a step per decade of time, up to 5 % without preload; a term takes up "
        "two decades. Of several values tried on a measured stage it was kept in sight of its test "
        "record",
    )  # fmt: skip
    line_periods: float = _number(
        5.0, "periods",
        "fewest periods within the longest record of a line; less is slow motion",
    )  # fmt: skip
    curve_margin: float = _number(
        0.1, "share of the range",
        "by which a static curve goes beyond the readings",
    )  # fmt: skip
    curve_slope: float = _number(
        0.1, "1",
        "least slope of a static curve: with less its inverse enlarges noise more than tenfold",
        "from what an inverse does to noise",
    )  # fmt: skip
    ring_step: float = _number(
        0.05, "share of the voltage range",
        "change that is a step, after which a ring shows",
    )  # fmt: skip
    ring_share: float = _number(
        0.1, "share of the motion",
        "what follows steps has to ring by so much, on average",
    )  # fmt: skip
    cycle_swing: float = _number(
        0.15, "share of the voltage span",
        "least swing of a cycle whose loop is read",
    )  # fmt: skip
    voltage_line: float = _number(
        30.0, "ratio of powers",
        "above which the voltage itself has a line: then it is no hum",
        "chosen by hand on seeds 0 to 9999; 2e-5 by chance (F with 2 and 12 degrees of freedom)",
    )  # fmt: skip
    pressed: float = _number(
        3.0, "standard deviations",
        "pull of a residual on a parameter at its bound, from which on a fit is said to rest on it",
        "statistic: 0.3 % by chance for a white residual",
    )  # fmt: skip
    near_steps: float = _number(
        2.0, "1",
        "delays are tried up to so many times what steps show, and from that much less on",
    )  # fmt: skip
    excursion: float = _number(
        6.6, "twice the log-likelihood",
        "by how much a history with an excursion has to be better than one without",
        "statistic: chi squared with one more parameter, 1 % by chance",
    )  # fmt: skip


@dataclass(frozen=True)
class Starts:
    """How records begin, and what of them counts."""

    lead: float = _number(
        0.1, "share of a record",
        "least lead-in while models are searched for",
    )  # fmt: skip
    longest_lead: float = _number(
        0.4, "share of a record",
        "longest lead-in while models are searched for",
    )  # fmt: skip
    swing: float = _number(
        0.9, "share of the voltage range",
        "through which the voltage has gone where the lead-in ends",
        "physics of play: a swing through the range wipes out what was before",
    )  # fmt: skip
    virgin: float = _number(
        0.2, "weight",
        "of a training record's samples before that swing: how a stack leaves the state that it was "
        "in before is no hysteresis of its loops",
        _MEASURED,
    )  # fmt: skip
    left: float = _number(
        0.2, "noise",
        "what a start may leave uncertain behind the lead-in",
        "then it adds 2 % to the error",
    )  # fmt: skip
    prior: float = _number(
        0.1, "samples off by the noise",
        "cost of a start one unit from its guess",
        "it decides where a lead-in does not tell, and nowhere else",
    )  # fmt: skip
    near: float = _number(
        0.1, "share of the travel",
        "by which the start of a record may be off its first reading",
    )  # fmt: skip
    standing: int = _number(
        5, "samples",
        "at zero voltage with which a record at rest begins",
    )  # fmt: skip
    slack: float = _number(
        0.02, "share of the voltage range",
        "what counts as zero voltage",
    )  # fmt: skip
    beyond: float = _number(
        0.01, "share of the voltage range",
        "by which a sample may be beyond the range fitted and decide",
    )  # fmt: skip
    fewest_deciding: int = _number(
        200, "samples",
        "fewest that may decide between two models",
        _SUITE,
    )  # fmt: skip
    falling_in: int = _number(
        100, "samples",
        "most that a record which begins in motion is given to fall in",
    )  # fmt: skip
    falling_in_share: float = _number(
        0.05, "share of a record",
        "most that it is given",
    )  # fmt: skip
    in_motion: float = _number(
        0.001, "share of the voltage range",
        "first change of the voltage from which on a record begins in motion",
    )  # fmt: skip


@dataclass(frozen=True)
class Coverage:
    """What records have to show."""

    same_unit: float = _number(
        3.0, "1",
        "largest ratio of a given model's travel to the records', either way",
        "chosen by hand on seeds 0 to 9999; units differ by a thousand",
    )  # fmt: skip
    beyond_model: float = _number(
        0.25, "share of the voltage range",
        "by which records may go beyond a given model's",
    )  # fmt: skip
    range_slack: float = _number(
        0.02, "share of the voltage range",
        "by which another record may exceed the training range",
    )  # fmt: skip
    power_tail: float = _number(
        0.01, "share of the power",
        "below which a drive's spectrum ends",
        _CONVENTION,
    )  # fmt: skip
    turn: float = _number(
        0.02, "share of the voltage span",
        "way back that makes a turn",
        _MEASURED,
    )  # fmt: skip
    step: float = _number(
        0.25, "share of the voltage span",
        "change in one sample that makes a drive no tone",
        _MEASURED,
    )  # fmt: skip
    same_end: float = _number(
        0.05, "share of the voltage span",
        "ends of loops that differ by less are the same",
        _MEASURED,
    )  # fmt: skip
    same_period: float = _number(
        1.2, "1",
        "periods whose ratio is smaller are the same",
        _MEASURED,
    )  # fmt: skip
    few_turns: int = _number(
        3, "turns",
        "of another kind that leave a drive one tone",
        _MEASURED,
    )  # fmt: skip
    share_of_turns: float = _number(
        0.05, "share of the turns",
        "of another kind that leave a drive one tone",
        _MEASURED,
    )  # fmt: skip
    trusted: float = _number(
        0.5, "share of a record",
        "least that can be trusted",
        _CONVENTION,
    )  # fmt: skip
    samples_per_parameter: int = _number(
        5, "samples",
        "fewest for every parameter of the model",
        "textbook: rule of thumb of regression",
    )  # fmt: skip
    offset_gain: float = _number(
        0.1, "share of the mean square",
        "by which offsets have to lower the error to be kept",
    )  # fmt: skip
    order_tolerance: float = _number(
        0.02, "share of the error",
        "a smaller number of rules is taken within this of the best, and a standard error",
    )  # fmt: skip
    explained_lead: float = _number(
        1.5, "error of the rest",
        "a lead counts as explained if its errors are not above this",
    )  # fmt: skip


@dataclass(frozen=True)
class Core:
    """What a usable core is."""

    contraction: float = _number(
        0.998, "1",
        "largest |dF/dy|: the penalties begin here",
        "from (10): below 1 it contracts",
    )  # fmt: skip
    slope: float = _number(
        0.05, "share of the mean slope",
        "smallest slope dy/dx of the core",
        "from (30): the inverse divides by it",
    )  # fmt: skip
    margin: float = _number(
        0.1, "share of the range",
        "beyond the data in which both are asked for",
    )  # fmt: skip
    stiff: float = _number(
        2000.0, "1/noise",
        "how a density of play operators is held smooth where few loops determine it",
    )  # fmt: skip
    soft: float = _number(
        200.0, "1/noise",
        "the same where many loops do",
    )  # fmt: skip


@dataclass(frozen=True)
class Reference:
    """The reference of the inverse, made of a measured displacement."""

    stands_out: float = _number(
        10.0, "noise density",
        "the displacement stands out of the noise where its power density is so many times it",
    )  # fmt: skip
    widest: float = _number(
        0.2, "sampling frequency",
        "widest band of a reference",
    )  # fmt: skip
    leaves: float = _number(
        4.0, "noise",
        "where the filter takes so much away, it takes motion away, and is left out there",
        "chosen by hand on seeds 0 to 9999; below 1e-4 by chance for Gaussian noise",
    )  # fmt: skip


@dataclass(frozen=True)
class Design:
    """What a designed record is held to."""

    decides: float = _number(
        0.9, "probability",
        "power from which on a record is said to decide between two models",
        "convention: a planned test of a usual power",
    )  # fmt: skip
    typical: float = _number(
        0.02, "share of the travel",
        "rms change that an effect makes whose size is not known, when rivals are made of a model",
        "convention: about what an effect worth naming makes",
    )  # fmt: skip
    base_gain: float = _number(
        0.1, "share of the error",
        "gain over the model without the effect that a design aims at",
        "search.clear_gain, above which an addition need take no share of the excess",
    )  # fmt: skip
    duration_samples: int = _number(
        4000, "samples",
        "length of a record where neither a user nor records imply one",
        "convention: as long as the demonstration's, 0.4 s at 10 kHz",
    )  # fmt: skip
    highest_share: float = _number(
        0.4, "Nyquist frequency",
        "highest frequency of a sine that is played: five samples a period",
        "convention: held from sample to sample, a faster one is no sine any more",
    )  # fmt: skip
    fewest_swings: float = _number(
        2.0, "swings",
        "through the voltage range and back that a period has to have time for",
        "convention: with less no loop is closed within another",
    )  # fmt: skip


SEARCH, NOISE, PHYSICS, STARTS = Search(), Noise(), Physics(), Starts()
COVERAGE, CORE, REFERENCE, DESIGN = Coverage(), Core(), Reference(), Design()
SECTIONS = (SEARCH, NOISE, PHYSICS, STARTS, COVERAGE, CORE, REFERENCE, DESIGN)


def thresholds() -> list[tuple[str, Any, str, str, str]]:
    """Return name, value, unit, meaning and source of every threshold."""
    return [
        (
            f"{type(section).__name__.lower()}.{f.name}",
            getattr(section, f.name),
            f.metadata["unit"],
            f.metadata["meaning"],
            f.metadata["source"],
        )
        for section in SECTIONS
        for f in fields(section)
    ]
