"""The thresholds that decide what is read and what is said, each with its unit, meaning and source.

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
_UNRECORDED = "chosen by hand; on which records was not written down"
_UNLIKELY = "chosen by hand, well beyond usual stages; no maker's figure was looked up"


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
    planned: float = _number(
        0.5, "share of the budget",
        "what is spent on the effects that a record was designed for, alone beside the model; the rest "
        "is for all other comparisons",
        "statistic: comparisons that were fixed before anything was measured, in equal parts on them",
    )  # fmt: skip
    together: float = _number(
        0.01, "share of the budget",
        "what more may be spent on tests of an effect's signature and its gain together",
        _CONVENTION,
    )  # fmt: skip
    confirming: float = _number(
        0.01, "probability",
        "largest p-value of a gain that halves an error, and of the free run's where the inverse's is "
        "halved",
        "chosen on a measured record that turns twelve times (0.0006, where creep was missing); two "
        "independent errors of 10 to 100 correlation times passed as halved in 3 of 22,000 draws",
    )  # fmt: skip
    least_gain: float = _number(
        0.05, "share of the error",
        "least share by which an addition has to lower the error",
        _CONVENTION,
    )  # fmt: skip
    clear_gain: float = _number(
        0.1, "share of the error",
        "gain from which on an addition is accepted whatever its share of the excess (the error above "
        "the noise)",
    )  # fmt: skip
    large: float = _number(
        0.4, "share of the error",
        "gain from which on the level of a comparison rises, up to `confirming` where an error is "
        "halved",
        "chosen on a measured record (49.7 % of the inverse, where a delay was missing) and on seed "
        "180000 (46 %); two independent errors of 10 correlation times pass in 0.25 % of the draws, of "
        "20 in 0.07 %, where a step at a half passes 0.13 % and 0.07 %",
    )  # fmt: skip
    indispensable: float = _number(
        0.5, "share of the error",
        "gain above which an addition is accepted though its own fit or another effect's rests on its "
        "bounds then, or though creep under way does nearly the same; above it on fitted and held-out "
        "records, its signature and its gain are one test; above it in both held-out errors, no share "
        "of it is asked of the training records; above it on fitted records, these tell rivals apart",
        "the larger part; 0.2 on a measured stage, where it was an artefact, and 0.94 on seed 63001, "
        "where it was a resonance",
    )  # fmt: skip
    least_share: float = _number(
        0.25, "share of the excess",
        "least share of the excess (the error above the noise) that an addition must remove; of the "
        "error on fitted records, what a resonance must remove that few of the others show",
    )  # fmt: skip
    least_excess: float = _number(
        0.3, "noise",
        "least excess that is reckoned with; a smaller one cannot be measured",
    )  # fmt: skip
    spoils: float = _number(
        0.1, "share of the error",
        "share by which an addition may raise the inverse's error",
        _SUITE,
    )  # fmt: skip
    beyond: float = _number(
        0.05, "share of the voltage span",
        "by how much an inverse that is compared may ask for more than the range of the records",
        "chosen on a measured stage that rings, and on records of a stage that was driven and of "
        "a new one: 0.02 and 0.1 do as well, 0 and no limit do not",
    )  # fmt: skip
    noisy: float = _number(
        2.0, "error by least error",
        "an inverse's error is no fault of the model up to this multiple of what it would be if the "
        "stage were the model: of what the noise and the band of its reference alone cause",
    )  # fmt: skip
    equal: float = _number(
        0.03, "share of the error",
        "difference of free-run errors that counts as none, so that the inverse decides, and no "
        "variant with the same effects is taken; as much again for every further time that the "
        "inverse's error is halved",
        "chosen by hand on seeds 0 to 9999; for variants on a measured stage: 0.01 let rounding decide "
        "how fine its memory was, with 12 % more error on another record",
    )  # fmt: skip
    near: float = _number(
        0.15, "share of the error",
        "a model with another effect in place of one that was chosen is fitted anew, too, if its error "
        "is larger by no more than this",
        "chosen on beats of a stage with play and a lag (seed 391010), whose lag had ended at an error "
        "that was larger by 0.033",
    )  # fmt: skip
    inverse_gain: float = _number(
        0.25, "share of the error",
        "least gain of the inverse by which a delay, or a variant of a model, is accepted although the "
        "free run is only equal",
    )  # fmt: skip
    sharpest: float = _number(
        0.01, "share of the samples",
        "of a record's samples those at which its voltage turns most sharply: behind them it shows "
        "whether the displacement waits",
        "0.003 and 0.03 do as well on a measured record and on seeds 370003, 380100 to 381010",
    )  # fmt: skip
    behind: int = _number(
        8, "samples",
        "how many behind such a turn count",
        "chosen by hand on the same records; no other number was tried",
    )  # fmt: skip
    at_once: float = _number(
        0.05, "1",
        "chance at which a delay, by which only the inverse gets better, is refused because behind "
        "those turns the displacement moves at once",
        "the usual level of one test; twice the logarithm of the ratio of likelihoods was -6 to -20 "
        "where a delay was not there (seeds 370003, 381006, 381010), 29 and 77 where one was (380100, "
        "380103), 0 on a measured record",
    )  # fmt: skip
    inverse_small: float = _number(
        0.005, "share of the travel",
        "error of the inverse up to which no faster core is sought, nor a delay beside a model that "
        "leaves but noise",
        "convention: what its user would call as good as exact",
    )  # fmt: skip
    faster: float = _number(
        0.5, "1",
        "share of the slope of the core by its last output to which it is held where its inverse is "
        "poor, and again as long as that is as good",
        "chosen by hand on stages made for it: play and a dead time; 0.6, 0.3, 0.1 did as well",
    )  # fmt: skip
    same_delay: float = _number(
        0.9, "share of a delay",
        "part of a delay from which on an effect that needs it, too, is no rival of that delay",
        "chosen by hand on seeds 95000 (all of it was needed, the delay was the truth) and 96005 (two "
        "thirds, a lag was)",
    )  # fmt: skip
    far_better: float = _number(
        0.3, "share of the cost",
        "cost from which on a fit with play operators that only an initial curve engages counts, as a "
        "part of that without them",
        "chosen by hand on stages made for it (0.04 to 0.25) and on seeds 80000 (play+creep: 0.36, and "
        "twice the error on other signals)",
    )  # fmt: skip
    commensurate: float = _number(
        0.2, "share of the gain",
        "least gain on the training records, as a share of the gain on held-out data; or "
        "`search.least_share` of what exceeds their noise",
        "chosen by hand on seeds 0 to 9999; the second on one stage of seeds 280000: a curve took "
        "9 % of the training records' error, all of their excess, and 71 % of the others'",
    )  # fmt: skip
    telling: float = _number(
        0.02, "share of the error",
        "least gain by which one of two equally simple models counts as better, where its p-value is "
        "no more than the budget shared among the effects",
    )  # fmt: skip
    likely: float = _number(
        0.05, "probability",
        "largest p-value of a variant's gain, of an effect's signature, of the gain of what is as good "
        "as an accepted addition, and so its rival, and of the gain of one rival over another where "
        "the fitted records tell them apart",
        "statistic: the usual level of one test; nothing is named by it alone",
    )  # fmt: skip
    promising: float = _number(
        0.7, "share of the cost",
        "where no addition is accepted, the search continues from what lowers the cost on the training "
        "records most, and from what fits as well, if it falls below this share",
    )  # fmt: skip
    beam_ratio: float = _number(
        2.0, "best error",
        "the search does not continue from models with a larger error than this multiple of the best",
    )  # fmt: skip
    block: float = _number(
        4.0, "correlation times",
        "length of a block by which errors are compared",
        "statistic: blocks have to be a few correlation times long to count as independent "
        "(`tests/unit/test_comparison.py` shows the calibration)",
    )  # fmt: skip
    fewest_blocks: int = _number(
        8, "blocks",
        "fewest blocks of a record",
        "statistic: the spread of fewer blocks cannot be estimated",
    )  # fmt: skip
    few_blocks: int = _number(
        20, "blocks",
        "most blocks of all records that are compared by the sizes of their errors, and not by the "
        "signs of what these differ by",
        "statistic: 12 blocks of one size that agree reach the level of a search, 20 where two do "
        "not; either test holds its level (`tests/unit/test_comparison.py`)",
    )  # fmt: skip
    told: float = _number(
        8.0, "noise",
        "largest difference from what every n-th sample of a long record tells of the others, up to "
        "which a search works on those alone",
        "statistic: below 1e-14 by chance for Gaussian noise",
    )  # fmt: skip
    line: float = _number(
        40.0, "mean power density",
        "largest power density of that difference",
        "statistic: below 1e-17 by chance for each frequency of Gaussian noise",
    )  # fmt: skip
    same: float = _number(
        1.5, "noise",
        "change up to which a stage that waits has not moved, or a period is that before: a search "
        "leaves it out",
        _UNRECORDED,
    )  # fmt: skip
    same_voltage: float = _number(
        0.01, "share of its span",
        "change of the voltage up to which it is the same there",
        _CONVENTION,
    )  # fmt: skip
    step: float = _number(
        0.05, "share of the voltage range",
        "change of the voltage from one sample to the next that counts as a step",
    )  # fmt: skip
    plain: float = _number(
        0.2, "share of the error",
        "gain on the training records from which on the report mentions it",
        _CONVENTION,
    )  # fmt: skip


@dataclass(frozen=True)
class Noise:
    """When a residual is noise."""

    little: float = _number(
        1.25, "noise",
        "rms residual of all records up to which it may be noise and a small misfit",
    )  # fmt: skip
    little_alone: float = _number(
        1.5, "noise",
        "the same for one record of several",
    )  # fmt: skip
    level: float = _number(
        0.001, "probability",
        "smallest p-value of a residual's properties below which it is more than noise",
        "chosen by hand on seeds 0 to 9999; the p-value is corrected for the number of properties",
    )  # fmt: skip
    reached: float = _number(
        1.02, "noise",
        "rms residual at which a search ends",
    )  # fmt: skip
    nearly: float = _number(
        1.1, "noise",
        "rms residual at which a search ends if the residual is indistinguishable from noise; and by "
        "how much an estimate of the noise may be above what a model leaves",
    )  # fmt: skip
    short_memory: float = _number(
        0.6, "1",
        "largest pole (memory from sample to sample) that noise is assumed to have",
        "chosen by hand on seeds 0 to 9999",
    )  # fmt: skip
    jump: float = _number(
        8.0, "standard deviations",
        "change of the residual from one sample to the next that counts as a jump",
        "chosen by hand on seeds 0 to 9999; below 1e-14 by chance for Gaussian noise",
    )  # fmt: skip
    step: float = _number(
        0.02, "share of the voltage span",
        "change of the voltage after which no jump is counted",
    )  # fmt: skip
    after_step: int = _number(
        50, "samples",
        "time after such a change in which no jump is counted",
    )  # fmt: skip
    stronger: float = _number(
        1.2, "rms",
        "multiple of its rms from which on a residual is called stronger at a place of the loop",
        _CONVENTION,
    )  # fmt: skip
    close: float = _number(
        0.02, "share of the record",
        "time that counts as after a turning point",
        _CONVENTION,
    )  # fmt: skip
    explained: float = _number(
        0.8, "share of the power",
        "share explained below which the report says that not only the voltage moves the stage",
        "statistic: the rest then moves it half as far as the voltage does, since sqrt(0.2 / 0.8) = "
        "0.5",
    )  # fmt: skip
    motion: float = _number(
        2.0, "1",
        "ratio of two estimates of the noise above which the one by differences contains motion",
        "statistic: 1 for white noise, 1.3 for noise with a pole of 0.6",
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
        "largest step of readings that is taken for rounding in the file",
        _SUITE,
    )  # fmt: skip


@dataclass(frozen=True)
class Physics:
    """Bounds of the effects, and properties of records that are none of them."""

    shortest_shift: float = _number(
        0.001, "samples",
        "shortest delay that a fit begins with beside a fast effect",
        "rounding: a delay of exactly zero has no derivative",
    )  # fmt: skip
    damped: float = _number(
        0.4, "1",
        "damping of a resonance above which it smooths instead of ringing",
        "chosen by hand on seeds 0 to 9999; the overshoot of a step is 25 % there",
    )  # fmt: skip
    dynamics_longest: float = _number(
        10.0, "samples",
        "longest time constant that counts as fast dynamics",
        "what is slower may be creep; chosen on seeds 90000, 140000 and 150000 (20 missed creep that 5 "
        "did not) and on a stand with hysteresis alone (at 5 creep was named beside it)",
    )  # fmt: skip
    slow_gain: float = _number(
        0.1, "1",
        "largest gain of one creep term, and largest creep within a decade of time",
        "makers: 1 to 2 % of a step per decade of time, up to 5 % without preload; a term covers "
        "two decades",
    )  # fmt: skip
    goes_on: float = _number(
        3.0, "durations of the longest record",
        "time constant with which creep goes on behind records that all begin at one voltage",
        "statistic: within a record such a term forgets as much as the decade behind it on average",
    )  # fmt: skip
    unseen: float = _number(
        0.3, "e-folds",
        "standard deviation of a time constant of creep beyond the longest record, which shows no "
        "gain of its own",
        "chosen by hand on seeds 90000 and 150000",
    )  # fmt: skip
    line_periods: float = _number(
        5.0, "periods",
        "fewest periods of a line within the longest record; fewer are slow motion",
    )  # fmt: skip
    curve_bow: float = _number(
        0.2, "share of the travel",
        "largest coefficient of the square and the cube of a static curve",
        "a sensor bows less; as large as each may be alone without the curve falling",
    )  # fmt: skip
    curve_shape: float = _number(
        0.6, "share of the travel",
        "the same of the higher powers, which cancel each other in part",
        "a curve with three waves, 4 % of the travel high, has 0.37 and 0.26 of them",
    )  # fmt: skip
    curve_slope: float = _number(
        0.1, "1",
        "least slope of a static curve: with less, its inverse amplifies noise more than tenfold",
        "from what an inverse does to noise",
    )  # fmt: skip
    ring_step: float = _number(
        0.05, "share of the voltage range",
        "change of the voltage that counts as a step which excites ringing",
    )  # fmt: skip
    ring_share: float = _number(
        0.1, "share of the motion",
        "least mean amplitude of ringing after steps",
    )  # fmt: skip
    ring_most: float = _number(
        0.5, "share of the motion",
        "share of what follows steps from which on a ring is a test of its own",
        "the larger part; on a measured record with one jump it was 0.55 to 0.75",
    )  # fmt: skip
    ring_damping: float = _number(
        0.1, "1",
        "damping of a ring up to which that is told from a single pulse",
        "convention: three cycles that are seen; 0.02 to 0.03 on a measured record",
    )  # fmt: skip
    cycle_swing: float = _number(
        0.15, "share of the voltage span",
        "least swing of a cycle whose loop width is evaluated",
    )  # fmt: skip
    voltage_line: float = _number(
        30.0, "ratio of powers",
        "power of a line in the voltage, over its neighbours, above which a line is not taken for hum",
        "chosen by hand on seeds 0 to 9999; 2e-5 by chance (F with 2 and 12 degrees of freedom)",
    )  # fmt: skip
    pressed: float = _number(
        3.0, "standard deviations",
        "pull of the residual on a parameter at its bound above which the report says that the fit "
        "rests on it",
        "statistic: 0.3 % by chance for a white residual",
    )  # fmt: skip
    near_steps: float = _number(
        2.0, "1",
        "delays are tried from the one that steps show divided by this, up to it times this",
    )  # fmt: skip
    excursion: float = _number(
        6.6, "twice the log-likelihood",
        "gain of the likelihood by which a start with an excursion is preferred to one without",
        "statistic: chi squared with one more parameter, 1 % by chance",
    )  # fmt: skip


@dataclass(frozen=True)
class Starts:
    """How records begin, and which of their samples count."""

    lead: float = _number(
        0.1, "share of a record",
        "shortest lead-in during the search",
    )  # fmt: skip
    longest_lead: float = _number(
        0.4, "share of a record",
        "longest lead-in during the search, and longest first part left out as it rings from before",
    )  # fmt: skip
    swing: float = _number(
        0.9, "share of the voltage range",
        "swing that the voltage has gone through when the lead-in ends",
        "physics of play: a swing through the range wipes out what was before",
    )  # fmt: skip
    virgin: float = _number(
        0.2, "weight",
        "weight of a training record's samples before that swing: how a stack leaves its former state "
        "is not the hysteresis of its loops",
        _MEASURED,
    )  # fmt: skip
    left: float = _number(
        0.2, "noise",
        "largest error after the lead-in that an uncertain start may cause",
        "statistic: it adds 2 % to the error",
    )  # fmt: skip
    late: float = _number(
        1.5, "1",
        "largest mean square in the second half of a lead-in, over noise and model error; ratio of "
        "mean squares, of its halves or of two starts, above which a start is fitted to that half",
        "chosen by hand on seeds 90000 and 160000; 1.2 and 2 do as well; taken over for the ratio, for "
        "which no other value was tried",
    )  # fmt: skip
    slow: float = _number(
        0.4, "noise",
        "largest slow error in the second half of a lead-in, beyond chance and model error",
        "chosen by hand on seeds 90000, 140000 and 160000 (driven before)",
    )  # fmt: skip
    prior: float = _number(
        0.1, "samples off by the noise",
        "cost of a start that is one unit off its guess",
        "small enough to matter only where the lead-in does not determine the start",
    )  # fmt: skip
    rested: float = _number(
        0.01, "probability",
        "p-value above which records count as begun after long rest, and not as fitted one by one",
        "statistic: ratio of likelihoods of the independent samples of each record; on seeds 90000, "
        "with all samples, records begun at rest had 0.1 and more but once (0.0009)",
    )  # fmt: skip
    near: float = _number(
        0.1, "share of the travel",
        "largest distance of a record's start from its first reading",
    )  # fmt: skip
    standing: int = _number(
        5, "samples",
        "time at zero voltage at the start of a record by which it counts as beginning at rest",
    )  # fmt: skip
    still: float = _number(
        2.0, "noise",
        "largest movement at zero voltage of a stage that rests there, and largest distance of "
        "two that rest alike",
        "chosen by hand on seeds 70000 and 90000 (driven before, off equilibrium)",
    )  # fmt: skip
    slack: float = _number(
        0.02, "share of the voltage range",
        "largest voltage that counts as zero",
    )  # fmt: skip
    beyond: float = _number(
        0.01, "share of the voltage range",
        "largest distance beyond the fitted range at which a sample still decides",
    )  # fmt: skip
    fewest_deciding: int = _number(
        200, "samples",
        "fewest samples that may decide between two models",
        _SUITE,
    )  # fmt: skip
    falling_in: int = _number(
        100, "samples",
        "longest first part left out of a record that begins in motion",
    )  # fmt: skip
    falling_in_share: float = _number(
        0.05, "share of a record",
        "the same, as a share of the record; the shorter one holds",
    )  # fmt: skip
    rings: float = _number(
        5.0, "noise",
        "least height of the ringing from before a record by which its first part is left out",
        "as large as an effect has to be on the suite to be found",
    )  # fmt: skip
    in_motion: float = _number(
        0.001, "share of the voltage range",
        "first change of the voltage above which a record counts as beginning in motion",
    )  # fmt: skip


@dataclass(frozen=True)
class Coverage:
    """Requirements on records."""

    same_unit: float = _number(
        3.0, "1",
        "largest ratio of a given model's travel to the records', or the reverse, in one unit",
        "chosen by hand on seeds 0 to 9999; units differ by a thousand",
    )  # fmt: skip
    beyond_model: float = _number(
        0.25, "share of the voltage range",
        "largest excess of the records' voltage over a given model's range",
    )  # fmt: skip
    range_slack: float = _number(
        0.02, "share of the voltage range",
        "largest excess of another record over the training range without a warning",
    )  # fmt: skip
    power_tail: float = _number(
        0.01, "share of the power",
        "share of a drive's power that lies above what counts as its highest frequency",
        _CONVENTION,
    )  # fmt: skip
    turn: float = _number(
        0.02, "share of the voltage span",
        "least return of the voltage that counts as a turning point",
        _MEASURED,
    )  # fmt: skip
    step: float = _number(
        0.25, "share of the voltage span",
        "change in one sample above which a drive is not a single tone",
        _MEASURED,
    )  # fmt: skip
    same_end: float = _number(
        0.05, "share of the voltage span",
        "largest difference of the ends of loops that count as the same",
        _MEASURED,
    )  # fmt: skip
    same_period: float = _number(
        1.2, "1",
        "largest ratio of periods that count as the same",
        _MEASURED,
    )  # fmt: skip
    few_turns: int = _number(
        3, "turns",
        "most other ways from turn to turn, if fewer than half, of a drive that counts as one tone",
        _MEASURED,
    )  # fmt: skip
    share_of_turns: float = _number(
        0.05, "share of the turns",
        "the same, as a share of all turning points",
        _MEASURED,
    )  # fmt: skip
    trusted: float = _number(
        0.5, "share of a record",
        "least share of usable samples; also of a lead-in, within the range that was fitted",
        _CONVENTION,
    )  # fmt: skip
    samples_per_parameter: int = _number(
        5, "samples",
        "fewest samples for each parameter of the model",
        "textbook: rule of thumb of regression",
    )  # fmt: skip
    offset_gain: float = _number(
        0.1, "share of the mean square",
        "least gain by which a constant for each record is kept",
    )  # fmt: skip
    order_tolerance: float = _number(
        0.02, "share of the error",
        "the smallest number of rules is taken whose error is above the best by no more than this and "
        "a standard error",
    )  # fmt: skip
    explained_lead: float = _number(
        1.5, "error of the rest",
        "largest error of a record's first part by which it counts as explained",
    )  # fmt: skip


@dataclass(frozen=True)
class Core:
    """When a core is admissible: it contracts and can be inverted."""

    contraction: float = _number(
        0.998, "1",
        "largest |dF/dy|; penalties begin above it",
        "from (10): below 1 it contracts",
    )  # fmt: skip
    slope: float = _number(
        0.05, "share of the mean slope",
        "smallest slope dy/dx of the core",
        "from (30): the inverse divides by it",
    )  # fmt: skip
    margin: float = _number(
        0.1, "share of the range",
        "margin beyond the data in which both must hold",
    )  # fmt: skip
    at_once: float = _number(
        0.05, "1",
        "|dF/dy| up to which a core answers at once, and no faster one is tried",
        "convention: what is left of a step after one sample",
    )  # fmt: skip
    stiff: float = _number(
        2000.0, "1/noise",
        "stiffness by which the density of play operators is smoothed where few loops determine it",
    )  # fmt: skip
    soft: float = _number(
        200.0, "1/noise",
        "the same, where many loops determine it",
    )  # fmt: skip


@dataclass(frozen=True)
class Reference:
    """The reference of the inverse, made from a measured displacement."""

    stands_out: float = _number(
        10.0, "noise density",
        "multiple of the noise's power density above which the displacement's belongs to the band",
    )  # fmt: skip
    widest: float = _number(
        0.2, "sampling frequency",
        "widest band of a reference",
    )  # fmt: skip
    leaves: float = _number(
        0.01, "probability",
        "that a filter which removes nothing but a record's noise changes any of its samples so much; "
        "where it changes more, it removes motion and is not applied",
        "statistic: Gaussian noise",
    )  # fmt: skip
    worth: float = _number(
        0.5, "error of a straight line",
        "an inverse's error above which the report says to use it with care",
        "convention: it then takes away less than half of what no model at all leaves",
    )  # fmt: skip
    enlarged: float = _number(
        2.0, "noise",
        "what an inverse makes of the displacement's noise, by the plant's gain, above which the "
        "report says to use it with care",
        _CONVENTION,
    )  # fmt: skip
    seen: float = _number(
        0.01, "share of the range",
        "least error of an inverse at which that is said",
        _CONVENTION,
    )  # fmt: skip
    widens: float = _number(
        1e-3, "probability",
        "that noise alone widens the band of a part of a record",
        "statistic: chi squared with two degrees of freedom",
    )  # fmt: skip


@dataclass(frozen=True)
class Design:
    """Requirements on a designed record."""

    decides: float = _number(
        0.9, "probability",
        "power from which on a record is said to decide between two models",
        "convention: the usual power of a planned test",
    )  # fmt: skip
    typical: float = _number(
        0.02, "share of the travel",
        "rms change of the displacement by a rival's effect whose size is not known",
        "convention: about that of an effect worth naming",
    )  # fmt: skip
    base_gain: float = _number(
        0.1, "share of the error",
        "gain over the model without the effect that a design aims at",
        "search.clear_gain, above which an addition need take no share of the excess",
    )  # fmt: skip
    duration_samples: int = _number(
        4000, "samples",
        "length of a record where the user gives none and the records are no shorter",
        "convention: as long as the demonstration's, 0.4 s at 10 kHz",
    )  # fmt: skip
    most_work: float = _number(
        20.0, "refits of a record of that length",
        "what a report takes to compare one record with another, at most; beyond, it names the command",
        "time: at 20 a report waits for about a minute, at 112 it waited for seven",
    )  # fmt: skip
    highest_share: float = _number(
        0.4, "Nyquist frequency",
        "highest frequency of a sine that is played: five samples per period",
        "convention: held from sample to sample, a faster one is not a sine",
    )  # fmt: skip
    fewest_swings: float = _number(
        2.0, "swings",
        "fewest swings through the voltage range and back that a period must have time for",
        "convention: with fewer, no loop is closed within another",
    )  # fmt: skip


@dataclass(frozen=True)
class Response:
    """When a displacement answers the voltage as a stage's does; other records are refused, or said."""

    plain: float = _number(
        0.5, "share of the displacement",
        "share that the voltage explains from which on the displacement plainly follows it",
        "convention: the larger part",
    )  # fmt: skip
    chance: float = _number(
        1e-3, "probability",
        "that the displacement is related to the voltage by chance, below which it is related",
        "statistic: 0.1 % by chance",
    )  # fmt: skip
    regular: float = _number(
        1e-4, "share of the displacement",
        "what its own past leaves of a displacement below which that is no noise, whatever it is",
        _UNRECORDED,
    )  # fmt: skip
    shows: float = _number(
        0.03, "share of the displacement",
        "least share that the mean at each voltage accounts for, for its shape to mean anything",
        _UNRECORDED,
    )  # fmt: skip
    matters: float = _number(
        0.2, "share of what the voltage explains",
        "the same; the larger one holds",
        _UNRECORDED,
    )  # fmt: skip
    folded: float = _number(
        0.1, "share of a branch",
        "what no monotone branch explains, from which on a loop may be a butterfly",
        "chosen by hand on measured records: up to 0.001 on three stages, from 0.14 on butterflies",
    )  # fmt: skip
    even: float = _number(
        0.3, "share of both branches",
        "what is the same at opposite voltages, from which on such a loop is a butterfly",
        "chosen by hand on measured records: up to 0.005 on three stages, from 0.43 on butterflies",
    )  # fmt: skip
    falls: float = _number(
        0.15, "share of the mean's shape",
        "what none that falls explains of it, up to which a sensor may be reversed",
        _UNRECORDED,
    )  # fmt: skip
    not_rises: float = _number(
        0.5, "share of the mean's shape",
        "what none that rises explains of it, above which a sensor may be reversed",
        _UNRECORDED,
    )  # fmt: skip
    fewest_in_cycle: int = _number(
        50, "samples",
        "fewest samples in a cycle of a reversed sensor",
        "physics: at the end of a stage's band dead time and inertia delay it by half a cycle",
    )  # fmt: skip
    lead: float = _number(
        0.03, "share of a cycle",
        "largest lead of a reversed sensor",
        "physics: above a resonance a stage lags by a little less than half a cycle",
    )  # fmt: skip
    ahead: float = _number(
        0.03, "share of the rectangles around loops",
        "area of the loops by which a displacement has to lead to run ahead of its voltage",
        _UNRECORDED,
    )  # fmt: skip
    ahead_agreement: float = _number(
        0.95, "share of the loops",
        "least share, weighted with their rectangles, that tell the same",
        _UNRECORDED,
    )  # fmt: skip
    ahead_loops: int = _number(
        3, "loops",
        "most loops that tell nothing of it",
        _UNRECORDED,
    )  # fmt: skip
    ahead_samples: int = _number(
        15, "samples",
        "fewest samples in a loop on average that tell of it",
        "physics: at the end of a fast sine's band a lag may be most of a period, and look like a lead",
    )  # fmt: skip
    ahead_correlation: float = _number(
        0.5, "1",
        "least correlation of voltage and displacement that tells of it",
        "physics: below it phases pass 60 degrees, and a lead may as well be a lag",
    )  # fmt: skip
    jump: float = _number(
        6.0, "standard deviations",
        "surprise of the voltage above which it is a step or a corner, and no answer of a controller",
        "statistic: p below 1e-8 by chance",
    )  # fmt: skip
    no_surprise: float = _number(
        1e-5, "standard deviations",
        "what its own past and the voltage leave of a displacement, up to which it shows no noise that "
        "a controller could answer",
        _UNRECORDED,
    )  # fmt: skip
    sure: float = _number(
        6.0, "standard errors",
        "size of an answer of the voltage above which it is no chance",
        "statistic: p below 1e-8, for each of ten answers",
    )  # fmt: skip
    lacking: float = _number(
        4.0, "standard errors",
        "by which no more than one part of a record may lack half of the answer",
        "statistic: p below 1e-4, for each of ten parts",
    )  # fmt: skip
    answered: float = _number(
        0.05, "share of the voltage's surprise",
        "least share that the first answer explains",
        _UNRECORDED,
    )  # fmt: skip


@dataclass(frozen=True)
class Reading:
    """What a file may hold to be read as a record of a piezo stage, and what is noted about it."""

    largest_voltage: float = _number(
        2e3, "V",
        "largest voltage; above it the unit is wrong",
        _UNLIKELY,
    )  # fmt: skip
    smallest_stroke: float = _number(
        1e-9, "m",
        "smallest travel; below it the unit is wrong",
        _UNLIKELY,
    )  # fmt: skip
    largest_stroke: float = _number(
        3e-3, "m",
        "largest travel; above it the unit is wrong",
        _UNLIKELY,
    )  # fmt: skip
    usual_from: float = _number(
        0.1e-6, "m",
        "travel below which the reader is asked to check the unit",
        _UNLIKELY,
    )  # fmt: skip
    usual_to: float = _number(
        1e-3, "m",
        "travel above which the reader is asked to check the unit",
        _UNLIKELY,
    )  # fmt: skip
    farthest: float = _number(
        0.09, "m",
        "largest displacement on either side of zero",
        "the bounds of displacements in variables.toml, 0.1 m, less a margin for what a fit adds",
    )  # fmt: skip
    fewest_samples: int = _number(
        50, "samples",
        "fewest samples of a record",
        _UNRECORDED,
    )  # fmt: skip
    jitter: float = _number(
        0.01, "sample time",
        "by which a time stamp may be off a uniform grid, besides the rounding of its digits",
        "convention: a reader would call less of it nothing",
    )  # fmt: skip
    longest_gap: int = _number(
        20, "samples",
        "most missing samples in a row that are filled by interpolation",
        _UNRECORDED,
    )  # fmt: skip
    missing: float = _number(
        0.05, "share of the record",
        "most missing samples in all that are filled",
        _UNRECORDED,
    )  # fmt: skip
    stands_out: float = _number(
        8.0, "standard deviations",
        "second difference above which a sample that is off alone is an outlier",
        "statistic: below 1e-14 by chance for Gaussian noise",
    )  # fmt: skip
    least_outlier: float = _number(
        1e-3, "share of the travel",
        "the same, at least, where there is no noise",
        _UNRECORDED,
    )  # fmt: skip
    standing: int = _number(
        5, "samples",
        "fewest equal samples in a row that count as standing still",
        _UNRECORDED,
    )  # fmt: skip
    stuck: float = _number(
        0.02, "share of the voltage range",
        "change of the voltage above which a displacement that stands still meanwhile is stuck: a "
        "quantised reading repeats itself on less",
        _UNRECORDED,
    )  # fmt: skip
    falling: float = _number(
        0.5, "1",
        "negative correlation of voltage and displacement from which on the sign is to be checked",
        _UNRECORDED,
    )  # fmt: skip
    wide_loop: float = _number(
        0.4, "share of the travel",
        "width of the loop in the middle of the voltage's range from which on it is called very wide",
        "makers: 10 to 15 % for stacks in open loop, soft ceramics reach 20 %; twice that is no "
        "hysteresis of a stack alone",
    )  # fmt: skip


@dataclass(frozen=True)
class Telling:
    """What the pages of results put into words."""

    far_above: float = _number(
        2.0, "noise",
        "free-run error above which an identified model is said to lack something",
        "statistic: what the model leaves then is larger than the noise, sqrt(3) times",
    )  # fmt: skip
    off_model: float = _number(
        0.1, "share of the model's travel",
        "how far displacements that belong to the stage may be beyond those of the model",
        _UNRECORDED,
    )  # fmt: skip
    worse: float = _number(
        1.05, "ratio of errors",
        "from which on an error is called larger than another",
        _CONVENTION,
    )  # fmt: skip
    late: float = _number(
        0.01, "rad",
        "phase at the end of the reference's band by which a dead time is told",
        "convention: 1 % of a sine's amplitude",
    )  # fmt: skip
    other_voltage: float = _number(
        0.01, "share of its span",
        "by which a record's voltage may be off the designed one before it is called another one",
        _CONVENTION,
    )  # fmt: skip


SEARCH, NOISE, PHYSICS, STARTS = Search(), Noise(), Physics(), Starts()
COVERAGE, CORE, REFERENCE, DESIGN, RESPONSE = Coverage(), Core(), Reference(), Design(), Response()
READING, TELLING = Reading(), Telling()
SECTIONS = (
    SEARCH, NOISE, PHYSICS, STARTS, COVERAGE, CORE, REFERENCE, DESIGN, RESPONSE, READING, TELLING,
)  # fmt: skip


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
