"""The next experiment: limits that are kept, rivals that are told apart, and what is promised of it."""

import itertools
import json
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
from conftest import TS, UM
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.stats import norm

from it2hys.designs.checking import Simulated, simulate_pair
from it2hys.designs.designing import (
    CHIRP,
    PAPER,
    Search,
    design,
    paper_signal,
    probability,
    takes_long,
)
from it2hys.designs.families import FAMILIES
from it2hys.designs.hypotheses import between, question_of, question_of_report, question_of_set
from it2hys.designs.limits import Limits, Wanted, limits_of
from it2hys.designs.promise import Ground, Left, Separation, above_chance, spread_of, worst
from it2hys.diagnosis.comparison import compare
from it2hys.errors import InputError
from it2hys.model.parameters import table_1, write_ssv
from it2hys.support.progress import silent

NOISE = 0.006 * UM
SHORT = Wanted(duration=0.12)
RINGING = {"resonance.frequency": 900.0, "resonance.damping": 0.1}


def limits(**wanted):
    base = table_1()
    return limits_of(Wanted(**wanted), base.voltage_range, base["sampleTime"])


# --- limits and families -------------------------------------------------------------------------

rigs = st.builds(
    lambda low, span, rate, samples, periods, lowest, decades: Limits(
        low,
        low + span,
        rate * span / (samples * 1e-4),
        1e-4,
        samples,
        periods,
        lowest,
        min(lowest * 10**decades, 4000.0),
    ),
    st.floats(-200.0, 200.0),
    st.floats(1.0, 300.0),
    st.floats(4.0, 4000.0),
    st.integers(200, 1500),
    st.integers(1, 3),
    st.floats(2.0, 50.0),
    st.floats(0.1, 3.0),
)


@settings(max_examples=120, deadline=None)
@given(rigs, st.sampled_from(sorted(FAMILIES)), st.data())
def test_every_record_of_every_family_keeps_every_limit_to_rounding(rig, name, data):
    family = FAMILIES[name]
    point = np.array(
        data.draw(st.lists(st.floats(0.0, 1.0), min_size=family.size, max_size=family.size))
    )
    voltage = family.voltage(point, rig)
    assert len(voltage) == rig.samples * rig.periods
    assert voltage.min() >= rig.low and voltage.max() <= rig.high
    slack = 1e-9 * max(rig.span, abs(rig.low), abs(rig.high))
    assert np.max(np.abs(np.diff(voltage))) <= rig.rate * rig.sample_time + slack
    assert abs(voltage[0] - rig.rest) <= slack and abs(voltage[-1] - rig.rest) <= slack
    assert np.array_equal(voltage, np.tile(voltage[: rig.samples], rig.periods))
    assert rig.holds(voltage)


@pytest.mark.parametrize("rate", [2e3, 1e6])
def test_what_the_limits_leave_less_of_is_said_of_each_part(rate):
    """A part of 100 V at 200 Hz was announced, of which a slow amplifier left some volts."""
    family = FAMILIES["steps and reversals"]
    point = np.full(family.size, 0.5)
    point[5:9] = 1.0, 1.0, 1.0, 0.5  # reversals at the highest frequency, of one amplitude
    rig = limits(rate=rate, band=(5.0, 200.0), duration=0.5)
    _, reversals = family.described(point, rig).split(", then for ")
    assert ("cut to the limits" in reversals) == (rate < 1e4)
    assert f"reversals of {rig.span:.3g} V, at 200 to 200 Hz" in reversals


def test_what_breaks_a_limit_is_seen():
    rig = limits(rate=2e4)
    voltage = FAMILIES["steps"].voltage(np.full(5, 0.5), rig)
    assert rig.holds(voltage)
    middle = len(voltage) // 2
    for change in (
        lambda v: np.where(np.arange(len(v)) == middle, v + 3.0, v),
        lambda v: v + 1e-3,
        lambda v: np.clip(v * 1.2, 0.0, 140.0),
    ):
        assert not rig.holds(change(voltage))


def test_sines_are_within_the_band_and_spectra_show_it():
    rig = limits(band=(20.0, 200.0))
    for share in (0.0, 0.5, 1.0):
        voltage = FAMILIES["multisine"].voltage(
            np.array([0.0, 1.0, share, 0.2, 0.5, 0.3, 1.0, 0.5]), rig
        )
        inner = voltage[400:-400] - voltage[400:-400].mean()
        power = np.abs(np.fft.rfft(inner * np.hanning(len(inner)))) ** 2
        frequency = np.fft.rfftfreq(len(inner), TS)
        assert power[frequency > 220.0].sum() < 1e-3 * power.sum()


def test_the_slowest_of_what_limits_the_rate_counts_and_is_said():
    cases = {
        "as given": {"rate": 3e3, "bandwidth": 500.0},
        "current": {"rate": 3e4, "current": 0.01, "capacitance": 2e-6},
        "rise time": {"rate": 1e9, "bandwidth": 20.0},
    }
    rates = {"as given": 3e3, "current": 5e3, "rise time": 110.0 * 20.0 / 0.35}
    for why, wanted in cases.items():
        found = limits(**wanted)
        assert found.rate == pytest.approx(rates[why])
        assert any("slew rate" in text and why in text for text in found.said)


def test_periods_are_equal_and_the_record_is_as_long_as_asked_for():
    rig = limits(duration=0.4, periods=4)
    assert (rig.samples, rig.periods, rig.duration) == (1000, 4, pytest.approx(0.4))


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        ({"voltage": (80.0, 20.0)}, "lowest must be below"),
        ({"voltage": (0.0, 300.0)}, "the model holds for 0 to 110 V"),
        ({"rate": 100.0}, "the limits exclude each other"),
        ({"rate": 0.0}, "slew rate must be positive"),
        ({"current": 0.1}, "--capacitance"),
        ({"capacitance": 1e-6}, "--current"),
        ({"sample_time": 2e-4}, "play and record at that rate"),
        ({"duration": 0.01}, "needs at least 800"),
        ({"duration": 1e6}, "at most"),
        ({"periods": 0}, "periods must be positive"),
        ({"band": (300.0, 200.0)}, "lowest must be below the highest"),
        ({"band": (300.0, 500.0), "bandwidth": 100.0}, "must begin below 100 Hz"),
        ({"band": (0.1, 1.0)}, "a longer --duration"),
    ],
)
def test_limits_that_exclude_each_other_are_refused_in_one_message(wanted, said):
    with pytest.raises(InputError, match=said) as error:
        limits(**wanted)
    assert "\n" not in str(error.value)


# --- what is to be decided -----------------------------------------------------------------------


def test_rivals_have_one_effect_each_and_those_of_the_set_as_they_are():
    base = table_1().replace(**{"lag.timeConstant": 7e-4, **RINGING})
    question = between(base, ["lag", "delay", "play"], NOISE)
    assert [h.name for h in question.hypotheses] == ["lag", "delay", "play"]
    assert question.hypotheses[0].parameters["lag.timeConstant"] == 7e-4
    for h in question.hypotheses:
        assert set(h.effects) == {h.name, "resonance"}
        assert h.said.startswith(h.name)
    assert question.neither.effects == ("resonance",)
    question = between(table_1(), ["lag", "resonance"], NOISE)
    said = question.hypotheses[1].said
    assert " Hz, resonance.damping = 0.5, a usual size" in said  # a ratio has no unit


@pytest.mark.parametrize(
    ("effects", "said"),
    [
        (["delay", "delay"], "at least two effects, each once"),
        (["delay"], "at least two"),
        (["delay", "lagg"], "did you mean|known are|no effect 'lagg'"),
        (["load", "lag"], "force column"),
    ],
)
def test_names_that_ask_nothing_are_refused(effects, said):
    with pytest.raises(InputError, match=said):
        between(table_1(), effects, NOISE)


def test_a_set_without_effects_leaves_nothing_to_determine():
    with pytest.raises(InputError, match="--between"):
        question_of_set(table_1())


def test_a_sample_time_that_is_too_coarse_for_an_effect_is_refused_by_its_name():
    quick = table_1().replace(**{"lag.timeConstant": 0.5e-4})
    with pytest.raises(InputError, match="too coarse for lag"):
        design(between(quick, ["lag", "play"], NOISE), SHORT)
    with pytest.raises(InputError, match="too coarse for delay"):
        design(between(table_1(), ["delay", "play"], NOISE), Wanted(sample_time=1e-3))


REPORT = {
    "noise_rms_um": 0.006,
    "records": {"a": {"samples": 1500, "sample_time_s": TS, "fastest_V_per_s": 3e4}},
    "indistinguishable": [],
    "parameters": {"rule[1].q1": {"determined": True}},
    "effects": [],
}


def test_a_report_without_rivals_is_refused_unless_parameters_are_open(tmp_path):
    path = tmp_path / "report.json"
    path.write_text(json.dumps(REPORT))
    with pytest.raises(InputError, match="nothing to decide") as error:
        question_of(path)
    assert str(path) in str(error.value)
    stage = table_1().replace(**{"lag.timeConstant": 5e-4})
    write_ssv(stage, tmp_path / "parameters.ssv")
    open_report = {**REPORT, "parameters": {"rule[1].q1": {"determined": False}}}
    path.write_text(json.dumps(open_report))
    question = question_of(path)
    assert question.neither is None and question.hypotheses[0].effects == ("lag",)


def test_a_report_hands_on_its_rivals_its_noise_and_what_its_records_were():
    rivals = [
        {"own": own, "effects": own, "parameters": dict(table_1().replace(**values))}
        for own, values in (
            ([], {}),
            (["delay"], {"delay.time": 3e-4}),
            (["lag"], {"lag.timeConstant": 4e-4}),
        )
    ]
    group = [["delay", "lag"]]
    question = question_of_report({**REPORT, "indistinguishable": group, "rivals": rivals}, table_1)
    assert [h.name for h in question.hypotheses] == ["delay", "lag"]
    assert question.hypotheses[1].parameters["lag.timeConstant"] == 4e-4
    assert question.noise == pytest.approx(NOISE)
    assert (question.duration, question.rate) == (pytest.approx(0.15), 3e4)


@pytest.mark.parametrize("text", ["{}", "[1]", "not JSON"])
def test_a_file_that_is_no_report_is_refused(tmp_path, text):
    path = tmp_path / "report.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"report\.json"):
        question_of(path)


def test_a_usual_size_is_known_of_a_model_at_the_edge_of_its_range():
    """A core moved to make room for creep would be beyond where it contracts."""
    question = between(table_1().replace(displacementMax=18.0 * UM), ["creep", "drift"], NOISE)
    assert {h.name for h in question.hypotheses} == {"creep", "drift"}


# --- what is promised ----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ground():
    question = between(table_1(), ["delay", "lag"], NOISE)
    return Ground(question, limits(duration=0.12))


def pair(ground, truth, rival):
    return next((a, b) for a, b in ground.pairs if (a.name, b.name) == (truth, rival))


def separation(ground, truth, rival, voltage, thorough=False):
    return ground.judged(truth, rival, ground.left_over(truth, rival, voltage, thorough))


def test_a_rival_with_the_same_readings_is_as_near_as_rounding(ground):
    """A model that is refitted to its own readings leaves nothing."""
    truth, _ = pair(ground, "lag", "delay")
    twin = replace(truth, name="delay")
    left = ground.left_over(truth, twin, ground.probe, thorough=True)
    assert np.max(np.abs(left.course)) < 0.5 * NOISE


def test_every_pair_is_looked_at_both_ways_and_against_neither(ground):
    names = {(a.name, b.name) for a, b in ground.pairs}
    assert names == {(a, b) for a in ("delay", "lag") for b in ("delay", "lag", "neither") if a != b}


def test_a_limit_at_either_end_of_the_voltage_is_as_likely():
    """What shows one end alone was promised to tell a limit, and the stage had the other one."""
    question = between(table_1(), ["saturation", "lag"], NOISE)
    ground = Ground(question, limits(duration=0.12))
    usual, other = next((h, *h.variants) for h in ground.hypotheses if h.name == "saturation")
    lower, upper = (p.parameters["saturation.minimum"] > 0.0 for p in (usual, other))
    assert lower != upper
    assert "saturation.maximum" in usual.said.partition("is as likely")[0].rpartition("; ")[2]
    told = {(a.name, b.name) for a, b in ground.sought}
    assert {(other.name, "lag"), (other.name, "neither")} < told
    assert not any(
        b.name == other.name or {a.own, b.own} == {("saturation",)} for a, b in ground.sought
    )
    # of the middle of the range, none of them tells anything
    middle = 55.0 + 20.0 * np.sin(np.linspace(0.0, 12.0 * np.pi, ground.limits.samples))
    assert all(
        ground.judged(t, ground.neither, ground.left_over(t, ground.neither, middle)).power < 0.2
        for t in (usual, other)
    )


def test_half_and_twice_of_a_usual_size_are_truths_too(ground):
    """A delay of half of what was assumed was promised to be told, and stayed open with a lag."""
    delay = next(h for h in ground.hypotheses if h.name == "delay")
    half, twice = (s.parameters["delay.time"] / delay.parameters["delay.time"] for s in delay.sizes)
    assert 0.35 < half < 0.75 and 1.4 < twice < 2.9
    assert {a.name for a, _ in ground.sought} > {delay.name, delay.sizes[0].name}
    assert " and ".join(s.name.removeprefix("delay of ") for s in delay.sizes) in delay.said


@pytest.mark.parametrize("effect", ["play", "creep"])
def test_what_has_terms_has_sizes_too(effect):
    """All strengths change together, none beyond what there may be of it."""
    usual = next(h for h in between(table_1(), [effect, "lag"], NOISE).hypotheses if h.name == effect)
    strengths = {"play": "play[%d].weight", "creep": "creep[%d].gain"}[effect]
    ratios = [
        {s.parameters[strengths % i] / usual.parameters[strengths % i] for i in (1, 2, 3)}
        for s in usual.sizes
    ]
    assert ratios and all(max(r) == pytest.approx(min(r)) for r in ratios)
    assert min(ratios[0]) == pytest.approx(0.5, rel=0.2)


def test_a_size_within_a_sample_is_no_truth():
    slow = table_1().replace(sampleTime=1e-3)
    delay = between(slow, ["delay", "lag"], NOISE).hypotheses[0]
    assert all(s.parameters["delay.time"] > 1e-3 for s in delay.sizes)


def test_a_promise_is_the_mean_of_those_for_all_sizes(ground):
    loud = Ground(replace(ground.question, noise=12.0 * NOISE), ground.limits)
    search = Search(loud.question, loud.limits, [FAMILIES["steps"]], 0, True, silent)
    voltage = FAMILIES["steps"].voltage(np.array([0.3, 0.6, 0.5, 0.5, 0.0]), loud.limits)
    (promised,) = (s for s in search._separations(voltage) if (s.truth, s.rival) == ("delay", "lag"))
    usual, rival = pair(loud, "delay", "lag")
    powers = [
        search._judged((t, rival), partial(search._left, voltage)).power for t in (usual, *usual.sizes)
    ]
    assert powers[1] < powers[2] and promised.power == pytest.approx(np.mean(powers))


def test_power_falls_with_the_noise_and_is_a_test_level_without_a_difference(ground):
    truth, rival = pair(ground, "delay", "lag")
    voltage = FAMILIES["steps"].voltage(np.full(5, 0.5), ground.limits)
    powers = []
    for factor in (1.0, 10.0, 100.0, 1000.0):
        question = replace(ground.question, noise=factor * NOISE)
        powers.append(separation(Ground(question, ground.limits), truth, rival, voltage).power)
    assert powers[0] > 0.99 and powers[-1] < 0.01
    assert all(a >= b - 1e-6 for a, b in itertools.pairwise(powers))


def test_a_voltage_that_stands_still_promises_nothing(ground):
    truth, rival = pair(ground, "delay", "lag")
    still = np.full(ground.limits.samples, ground.limits.rest)
    assert separation(ground, truth, rival, still).power < 0.01


@pytest.mark.parametrize("factor", [1.0, 12.0])
def test_promised_power_is_what_simulated_records_give(ground, factor):
    """Refits to noisy records, compared as a diagnosis does, at a noise where all are told and less."""
    quiet = Ground(replace(ground.question, noise=factor * NOISE), ground.limits)
    truth, rival = pair(quiet, "lag", "delay")
    voltage = FAMILIES["steps"].voltage(np.array([0.3, 0.6, 0.5, 0.5, 0.0]), quiet.limits)
    promised = separation(quiet, truth, rival, voltage, thorough=True).power
    found = simulate_pair(quiet, truth, rival, voltage, 8, seed=5)
    assert abs(found.share - promised) <= 3.0 * found.error + 0.1


def no_spread(count: int) -> np.ndarray:
    """Return that of a fit whose parameter is known."""
    return np.zeros((count, 1))


def uneven(blocks: np.ndarray, above: float) -> np.ndarray:
    """Return a difference, so large in each block, that is `above` deviations above chance."""
    shape = np.repeat(blocks, 75) * np.tile([1.0, -1.0, 0.5], 25 * len(blocks))
    return shape * brentq(lambda size: known_above_chance(size * shape) - above, 1e-3, 1e3)


def known_above_chance(difference: np.ndarray) -> float:
    """Return by how much a model is better than one that is off, where nothing had to be fitted."""
    return above_chance(difference, np.zeros_like(difference), no_spread(len(difference)))


@pytest.mark.parametrize(
    "blocks",
    [
        np.ones(8),
        np.geomspace(0.2, 5.0, 8),
        np.array([1, 0, 0, 1, 1, 1, 1, 1.0]),
        np.ones(40),
        np.geomspace(0.2, 5.0, 40),
        np.array([0.0, 1.0] * 20),
    ],
)
def test_a_comparison_finds_a_difference_as_far_above_chance_as_foreseen(blocks):
    """Whether all of a record shows it alike, or some of it by far more than the rest."""
    difference, rng = uneven(blocks, 2.5), np.random.default_rng(11)
    noises = rng.standard_normal((30, len(difference)))
    found = [norm.isf(compare([noise + difference], [noise]).p_value) for noise in noises]
    assert abs(np.median(found) - 2.5) < 0.7


def test_a_difference_that_grows_over_a_record_is_no_chance_where_all_blocks_show_it():
    """What it differs by from block to block is not what it differs by from noise."""
    difference = uneven(np.geomspace(0.2, 5.0, 8), 4.5)
    for noise in np.random.default_rng(13).standard_normal((10, len(difference))):
        assert compare([noise + difference], [noise]).p_value < 3e-4


def test_what_one_block_alone_shows_is_chance_however_large_it_is():
    alone = np.where(np.arange(600) < 75, 1.0, 0.0)
    for size in (1e2, 1e3):
        assert known_above_chance(size * alone) < 1.5
    noise = np.random.default_rng(12).standard_normal(600)
    assert compare([noise + 1e3 * alone], [noise]).p_value > 0.05


def test_a_fit_is_as_far_off_where_it_decides_as_what_it_is_fitted_to_tells():
    """A straight line through half a record: by the textbook, and by fits to noise."""
    x, rng = np.linspace(-1.0, 1.0, 400), np.random.default_rng(14)
    jacobian, fitted = np.column_stack([np.ones(400), x]), x < 0.0
    spread = spread_of(100.0 * jacobian, fitted, ~fitted)
    coefficients = np.polyfit(x[fitted], rng.standard_normal((200, 2000)), 1)
    off = np.std(np.polyval(coefficients[:, None], x[~fitted][:, None]), axis=1)
    assert np.allclose(np.sqrt(np.sum(spread**2, axis=1)), off, rtol=0.06)


def test_a_difference_like_what_the_fits_do_not_know_is_not_promised_to_be_seen(ground):
    truth, rival = pair(ground, "delay", "lag")
    deciding = np.arange(1200) < 600
    left = Left(np.full(1200, 5.0 * NOISE), deciding, False, no_spread(600))
    assert ground.judged(truth, rival, left).power > 0.99
    unsure = replace(left, spread=np.full((600, 1), 5.0))
    assert 0.5 < ground.judged(truth, rival, unsure).power < 0.9


def test_a_rival_that_is_no_better_than_the_model_without_effects_is_told_apart(ground):
    """The diagnosis takes none into account that does not come up in its search."""
    truth, rival = pair(ground, "delay", "lag")
    deciding, shape = np.arange(1200) < 600, np.tile([1.0, -1.0, 0.5, -0.5], 300) * NOISE
    near = Left(0.25 * shape, deciding, False, no_spread(600))
    alone = ground.judged(truth, rival, near)
    assert alone.rejected == 0.0 and alone.power < 0.5
    as_near, far = (replace(near, course=factor * shape) for factor in (0.26, 3.0))
    assert ground.judged(truth, rival, near, far).power == pytest.approx(alone.power, abs=0.01)
    beside = ground.judged(truth, rival, near, as_near)
    assert beside.rejected > 0.99 and beside.power > 0.99 and beside.score > alone.score


def test_what_is_not_known_of_a_voltage_on_which_a_model_runs_away_is_said_so(ground):
    truth, rival = pair(ground, "delay", "lag")
    nothing = ground.judged(truth, rival, Left(None, np.zeros(0, bool), False, np.empty((0, 0))))
    assert np.isnan(nothing.power) and probability(nothing.power) == "not known"


def test_a_design_of_which_nothing_is_known_promises_nothing(found):
    """Its file is JSON all the same."""
    nothing = replace(found.separations[0], power=np.nan, score=-np.inf)
    unknown = replace(found, separations=(nothing, *found.separations[1:]))
    assert unknown.power == 0.0 and not unknown.decides


def test_a_share_of_all_draws_has_an_error_too():
    assert 0.0 < Simulated("a", "b", 8, 8).error < Simulated("a", "b", 4, 8).error < 0.25


# --- the search ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def found():
    question = between(table_1(), ["delay", "lag"], NOISE)
    return design(question, SHORT, ("steps", "multisine"), seed=3, draws=2)


def worth_of(scores):
    """Return what a record is worth that tells pairs so well."""
    search = Search(None, limits(), [], 0, False, silent)
    search.ground = SimpleNamespace(
        sought=[(name, Mock(own=())) for name in scores],
        neither=None,
        is_taken=lambda voltage: True,
        information=lambda voltage: 0.0,
        left_over=lambda truth, rival, voltage: truth,
        judged=lambda truth, rival, left, *others: SimpleNamespace(score=scores[left]),
    )
    return search.worth(np.linspace(0.0, 110.0, 1200))


def test_where_one_pair_is_beyond_all_records_the_others_decide():
    """Of two records, the one was chosen that told a lag from a resonance by a little above nothing."""
    assert worth_of({"lag": -6.0, "delay": 1.0}) > worth_of({"lag": -5.0, "delay": -1.0})
    assert worth_of({"lag": -0.5, "delay": 0.4}) > worth_of({"lag": -0.6, "delay": 3.0})
    assert worth_of({"lag": 1.0, "delay": 1.0}) > worth_of({"lag": 0.5, "delay": 3.0})


def test_a_record_on_which_a_model_runs_away_is_worth_nothing():
    assert worth_of({"lag": 3.0, "delay": -np.inf}) == -np.inf


def test_a_design_decides_by_more_than_the_papers_signal(found):
    assert found.decides and found.power > 0.9
    assert worst(found.separations).score > worst(found.others[PAPER]).score
    assert len(found.voltage) == 1200 and found.limits.holds(found.voltage)
    assert "delay from lag" in found.sentences[0] and "Play this record" in found.sentences[0]
    assert all(s.told == s.draws == 2 for s in found.simulated)


@pytest.mark.parametrize(("power", "said"), [(0.95, True), (0.5, False), (np.nan, False)])
def test_a_usual_signal_that_decides_too_is_said(found, power, said):
    """Where noise is small a chirp tells as much, and is simpler to play."""
    chirp = tuple(replace(s, power=power) for s in found.others[CHIRP])
    text = replace(found, others={CHIRP: chirp}).sentences[0]
    assert ("Of the same length, a chirp (0.95) would decide, too." in text) == said


def test_a_design_says_what_its_parameters_will_be_known_to(found):
    low, high = found.intervals["delay"]["delay.time"]
    truth = found.question.hypotheses[0].parameters["delay.time"]
    assert low < truth < high and high - low < 0.1 * truth


def test_a_report_does_not_wait_for_the_design_between_many_effects():
    assert not takes_long(between(table_1(), ["delay", "lag", "play"], NOISE))
    assert takes_long(between(table_1(), ["delay", "lag", "play", "creep", "resonance"], NOISE))


def test_a_design_is_no_longer_than_usual_unless_that_is_asked_for(ground):
    """For the owner of one loop of 50,000 samples a design did not end within 17 minutes."""
    question = replace(ground.question, duration=50_000 * TS)
    usual, long = (
        limits_of(wanted, question.base.voltage_range, TS, question.duration)
        for wanted in (Wanted(), Wanted(duration=50_000 * TS))
    )
    assert usual.samples == 4000 and "the usual length" in usual.said[1]
    assert long.samples == 50_000 and "as given" in long.said[1]
    open_one = Separation("delay", "lag", 0.1, 0.0, 0.05, -2.0)
    search = Search(question, usual, [FAMILIES["steps"]], 0, True, silent)
    told = search._needed(np.zeros(usual.samples), (open_one,))
    assert any("--duration 5 asks for one as long" in text for text in told)


def test_the_same_seed_gives_the_same_record_and_another_one_another(found):
    first, again, other = (
        design(found.question, SHORT, ("steps",), seed, draws=0, coarse=True) for seed in (3, 3, 4)
    )
    assert np.array_equal(again.voltage, first.voltage)
    assert not np.array_equal(other.voltage, first.voltage)


def test_a_record_is_worth_the_same_whether_or_not_worse_ones_are_dropped_early(found):
    """All pairs are looked at of what is better than the best before, and of no other record."""
    family, points = FAMILIES["steps"], np.random.default_rng(7).random((6, 5))
    voltages = [family.voltage(point, found.limits) for point in points]
    searches = [Search(found.question, found.limits, [family], 0, True, silent) for _ in range(2)]
    whole = [searches[0].worth(voltage) for voltage in voltages]
    best = -np.inf
    for voltage, worth in zip(voltages, whole, strict=True):
        told = searches[1].worth(voltage, best)
        assert told == worth if worth > best else worth <= told <= best
        best = max(best, worth)
    assert len({*whole}) == len(whole) and whole[0] < best


def test_parameters_of_one_model_are_determined_better_than_by_the_papers_signal():
    stage = table_1().replace(**{"lag.timeConstant": 5e-4, **RINGING})
    question = question_of_set(stage, noise=NOISE)
    told = design(question, SHORT, ("steps", "chirp"), draws=0)
    assert told.decides and not told.separations
    ground = Ground(question, told.limits)
    paper = ground.information(paper_signal(told.limits), of_effects=True)
    assert ground.information(told.voltage, of_effects=True) > paper + 0.5
    own, others = told.intervals["the model"], told.other_intervals[PAPER]["the model"]
    for name in ("lag.timeConstant", "resonance.frequency"):
        assert np.ptp(own[name]) < np.ptp(others[name])


def test_where_nothing_can_decide_it_says_what_would_be_needed():
    """A delay of a tick and a lag of as much, behind a slow amplifier and a noise of micrometres."""
    base = table_1().replace(**{"delay.time": 1.1e-4})
    question = replace(between(base, ["delay", "lag"], NOISE), noise=1.0 * UM)
    told = design(question, Wanted(duration=0.1, rate=1e4), ("steps", "multisine"), draws=0)
    assert not told.decides
    text = " ".join(told.sentences)
    assert "No record within these limits decides" in text
    assert "times less noise" in text or "No lower noise" in text
    assert "faster amplifier" in text


def test_a_record_that_hardly_moves_the_stage_is_none_that_a_diagnosis_takes(ground):
    """It would take it for one in another unit: pulses of a sample over all of the range."""
    ticks = np.arange(ground.limits.samples)
    swing = np.cos(2 * np.pi * 20 * ticks * TS)
    assert ground.is_taken(55.0 - 55.0 * swing * np.cos(2 * np.pi * 3 * ticks * TS))
    assert not ground.is_taken(np.where(ticks % 200 == 100, 110.0, 0.0))


def test_a_record_of_one_amplitude_at_one_frequency_is_none_that_decides(ground):
    """A diagnosis calls delay, lag and play inseparable there, as on a triangle cut out of steps."""
    ticks = np.arange(ground.limits.samples)
    assert not ground.is_taken(55.0 - 55.0 * np.cos(2 * np.pi * 20 * ticks * TS))


def test_an_unknown_family_is_refused():
    with pytest.raises(InputError, match="no family"):
        design(between(table_1(), ["delay", "lag"], NOISE), SHORT, ("sawtooth",))


def test_a_rival_that_does_no_more_than_a_delay_is_told_from_it():
    """A diagnosis takes no resonance that a delay of a sample makes up for, however well it fits."""
    base = table_1().replace(**{"delay.time": 1.1e-4})
    question = between(base, ["delay", "resonance"], NOISE)
    ground = Ground(question, limits(duration=0.12))
    truth, rival = pair(ground, "delay", "resonance")
    voltage = FAMILIES["steps"].voltage(np.full(5, 0.5), ground.limits)
    found = separation(ground, truth, rival, voltage, thorough=True)
    assert found.refused and found.power == 1.0 and found.distance < 5.0
    truth, rival = pair(ground, "resonance", "delay")
    found = separation(ground, truth, rival, voltage, thorough=True)
    assert not found.refused and found.distance > 50.0
