"""What was before a record is sought anew once a model has what it lacked."""

import re
from dataclasses import replace

import numpy as np
import pytest
from conftest import TS, UM
from effects import signals, surroundings

from it2hys.diagnosis import diagnose, fitting, last_fit
from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.fitting import Bench
from it2hys.diagnosis.refinement import _scaled, _with_histories, finest, node_of
from it2hys.diagnosis.rest import begun_at_rest, resting
from it2hys.identification import Options
from it2hys.identification.criterion import ChainFit, Model, Trace
from it2hys.identification.inverse import References
from it2hys.identification.levenberg_marquardt import Minimum
from it2hys.identification.scaling import Scaling
from it2hys.identification.starts import _forgotten, at_rest
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import ParameterSet, table_1
from it2hys.records import Record
from it2hys.records.clues import Extent

SAMPLES, NOISE = 1500, 0.005 * UM
#: A third of the starts of the paper's model, which is no more than where these diagnoses begin.
FEW_STARTS = Options(starts=12)
EXTENT = Extent(TS, SAMPLES * TS, (0.0, 100.0), (0.0, 16 * UM))
PLAY = {
    "play[1].threshold": 3.0, "play[1].weight": 0.1, "play[2].threshold": 12.0, "play[2].weight": 0.15,
    "playCount": 2,
}  # fmt: skip
#: Creep with the logarithm of time: time constants, s, and gains.
SLOW, LOGARITHMIC = np.geomspace(0.02, 30.0, 14), np.full(14, 0.12 / 14)
#: One full loop, and two small ones near where they rest, in which the second operator never moves.
LOOPS = ((5.0, 95.0), (44.0, 50.0), (44.0, 50.0))


def alone(*effects: str) -> dict:
    """Return the arguments of a diagnosis that fits these effects and tries no other."""
    others = [e for e in EFFECTS if e not in effects]
    return {"declared": effects, "excluded": others, "options": FEW_STARTS}


def measured(model: Model, number: int, voltage: np.ndarray | None = None) -> Trace:
    """Return a record of a stage, with noise."""
    voltage = signals(SAMPLES, *LOOPS[number]) if voltage is None else voltage
    used = np.ones(SAMPLES, dtype=bool)
    drive = compiled.Drive.of(voltage, *surroundings(SAMPLES))
    references = References(voltage, used, NOISE, TS)
    empty = Trace(
        f"record {number}", "train", drive, np.zeros(SAMPLES), 1.0 * used, used, 40, NOISE, references
    )
    noise = NOISE * np.random.default_rng(number).standard_normal(SAMPLES)
    y = model.predict(empty, number) + noise
    return replace(empty, y=y, references=References(y, used, NOISE, TS))


def test_a_history_that_a_poorer_model_chose_is_left():
    own = {
        "initialDisplacement": np.array([5.0, 9.0, 9.0]) * UM,
        "initialDemagnetisation": np.zeros(3),
        "initialExcursion": np.zeros(3),
    }
    truth = Model({**table_1(), **PLAY}, ("play",), np.zeros(3), own)
    traces = [measured(truth, i) for i in range(3)]
    wrong = replace(truth, own={**own, "initialExcursion": np.array([0.0, 110.0, 110.0])})
    bench = Bench(traces, Scaling(8 * UM, 8 * UM, 50.0, 50.0), EXTENT, traces, parts=True)
    criterion = bench.criterion(wrong)
    fit = ChainFit(criterion, Minimum(criterion.pack(wrong), 1.0, True, 0, 0, ""))
    node = node_of(bench, frozenset({"play"}), fit)
    assert node.rms > 10.0 * NOISE
    assert _with_histories(bench, node).rms < 1.05 * NOISE


BENCH = {"scaling": Scaling(8 * UM, 8 * UM, 50.0, 50.0), "extent": EXTENT, "parts": True}


def begun(excursions: tuple[float, ...], begins: tuple[float, ...]) -> Model:
    """Return a stage with play whose records begin after driven to turning points, V, and at um."""
    own = {
        "initialDisplacement": np.array(begins) * UM,
        "initialDemagnetisation": np.zeros(3),
        "initialExcursion": np.array(excursions),
    }
    return Model({**table_1(), **PLAY}, ("play",), np.zeros(3), own)


def test_records_begun_after_long_rest_are_fitted_as_such():
    """Starts that were fitted one by one took up a part of play, and foretold no other start."""
    truth = begun((0.0, 0.0, 0.0), (5.0, 9.0, 9.0))
    traces = [measured(truth, i) for i in range(3)]
    bench = Bench(traces=traces, deciding=traces, **BENCH)
    free = bench.fit(replace(truth, own={**truth.own, "initialExcursion": np.full(3, 8.0)}), 30)
    assert np.any(free.model.own["initialExcursion"])
    rested = bench.rested(free, 30).model
    assert rested.rested
    assert not np.any(rested.own["initialExcursion"])
    again = bench.fit(rested, 5).model
    assert not np.any(again.own["initialExcursion"])


def unfitted(bench: Bench, model: Model) -> ChainFit:
    """Return a model that was not fitted as a fit of cost 0, which none at rest comes near."""
    criterion = bench.criterion(model)
    return ChainFit(criterion, Minimum(criterion.pack(model), 0.0, True, 0, 0, ""))


def test_records_are_begun_at_rest_where_that_foretells_more(monkeypatch):
    """What a model misses makes starts of their own likelier, and a cold start 55 times the noise."""
    truth = begun((0.0, 0.0, 0.0), (5.0, 9.0, 9.0))
    traces = [measured(truth, i) for i in range(3)]
    bench = Bench(traces=traces, deciding=traces, **BENCH)
    heavy = replace(truth, values={**truth.values, "play[2].weight": 0.3})
    monkeypatch.setattr(fitting, "_loss", lambda *_: 1e6)
    rested = bench.rested(unfitted(bench, heavy), 30).model
    assert rested.rested
    assert rested.values["play[2].weight"] == pytest.approx(0.15, rel=0.05)
    good = unfitted(bench, truth)
    assert bench.rested(good, 30) is good


def test_a_model_found_with_its_records_at_rest_is_fitted_from_there(monkeypatch):
    """What starts of their own had made of it led to 2.4 times the error on held-out records."""
    truth = begun((0.0, 0.0, 0.0), (5.0, 9.0, 9.0))
    traces = [measured(truth, i) for i in range(3)]
    bench = Bench(traces=traces, deciding=traces, **BENCH)
    heavy = replace(truth, values={**truth.values, "play[2].weight": 0.3})

    def stay(self, model, iterations):
        criterion = self.criterion(model)
        point = criterion.pack(model)
        cost = 0.5 * float(np.sum(criterion.residual(point) ** 2))
        return ChainFit(criterion, Minimum(point, cost, True, 0, 0, ""))

    monkeypatch.setattr(Bench, "fit", stay)
    fit = replace(unfitted(bench, heavy), minimum=stay(bench, heavy, 0).minimum)
    weight = "play[2].weight"
    assert bench.rested(fit, 0).model.values[weight] == pytest.approx(0.3)
    assert bench.rested(fit, 0, truth).model.values[weight] == pytest.approx(0.3)
    assert bench.rested(fit, 0, at_rest(truth)).model.values[weight] == pytest.approx(0.15)


def test_few_operators_and_starts_of_their_own_are_left_for_many_at_rest():
    """Three operators with starts of their own leave 2.7 times the noise."""
    thresholds = np.linspace(1.5, 48.0, 32)
    weights = 0.05 * np.exp(-thresholds / 8.0)
    fine = {"playCount": 32}
    for j, (threshold, weight) in enumerate(zip(thresholds, weights, strict=True), start=1):
        fine |= {f"play[{j}].threshold": float(threshold), f"play[{j}].weight": float(weight)}
    starts = begun((0.0, 0.0, 0.0), (5.0, 9.0, 9.0))
    truth = replace(starts, values={**table_1(), **fine})
    traces = [measured(truth, i) for i in range(3)]
    bench = Bench(traces=traces, deciding=traces, **BENCH)
    coarse = {"playCount": 3}
    for j, part in enumerate(np.array_split(np.arange(32), 3), start=1):
        coarse[f"play[{j}].threshold"] = float(np.mean(thresholds[part]))
        coarse[f"play[{j}].weight"] = float(np.sum(weights[part]))
    free = bench.fit(replace(starts, values={**table_1(), **coarse}), 30)
    node = node_of(bench, frozenset({"play"}), free)
    assert node.rms > 1.2 * NOISE
    found = finest(bench, node)
    assert found.rms < 1.03 * NOISE
    assert found.fit.model.rested
    assert found.fit.model.values["playCount"] == 32


def test_records_of_a_stage_that_was_driven_before_keep_their_own_starts():
    truth = begun((0.0, 110.0, 0.0), (5.0, 9.0, 9.0))
    # two loops alike, of which one remembers that it was come to from above
    loops = [signals(SAMPLES, *ends) for ends in ((5.0, 95.0), (44.0, 62.0), (44.0, 62.0))]
    traces = [measured(truth, i, voltage) for i, voltage in enumerate(loops)]
    bench = Bench(traces=traces, deciding=traces, **BENCH)
    free = bench.fit(truth, 30)
    assert bench.rested(free, 30) is free


@pytest.mark.parametrize(("elsewhere", "fast"), [(-6.0, 0.01), (-10.0, 0.003), (-10.0, 0.01)])
def test_what_no_start_describes_of_a_lead_in_is_not_made_up_for_behind_it(elsewhere, fast):
    """A fast term of creep elsewhere, um, than the slow one: 3.9, 2.0, 28 times the noise before."""
    creep = {"creepCount": 2, "creep[1].gain": 0.05, "creep[2].gain": 0.05}
    creep |= {"creep[1].timeConstant": fast, "creep[2].timeConstant": 3.0}
    own = {
        "initialDisplacement": np.array([5.0, 9.0, 9.0]) * UM,
        "initialCreep": np.array([0.0, 0.0, 3.0]) * UM,
        "initialCreepAge": np.zeros(3),
    }
    truth = Model({**table_1(), **creep}, ("creep",), np.zeros(3), own)
    *fitted, driven = (measured(truth, i, signals(SAMPLES, 5.0, 95.0)) for i in range(3))
    left = 0.05 * elsewhere * UM * np.exp(-np.arange(SAMPLES) * TS / fast)
    driven = replace(driven, y=driven.y + left)
    bench = Bench(traces=fitted, deciding=fitted, **BENCH)
    model = replace(truth, offsets=np.zeros(2), own={n: v[:2] for n, v in own.items()})
    driven = bench.with_lead_in(model, driven)
    error = bench.fit_own(model, [driven]).predict(driven, 0) - driven.y
    assert np.sqrt(np.mean(error[driven.judged] ** 2)) < 1.4 * NOISE


@pytest.mark.parametrize(("share", "left"), [(None, 3.0), (0.8, 2.5)], ids=["wide", "narrow"])
def test_a_memory_that_ends_at_once_is_found_by_operators_closer_together_or_apart(share, left):
    """A density held smooth up to where the records go left three times the noise.

    One that ended a tenth too early, after a step that was too long, had a core that made up for it.
    """
    count = 9
    thresholds = {f"play[{j}].threshold": 1.1 * (j - 0.5) for j in range(1, count + 1)}
    weights = {f"play[{j}].weight": 0.1 for j in range(1, count + 1)}
    rest = begun((0.0, 0.0, 0.0), (5.0, 9.0, 9.0))
    truth = replace(rest, values={**table_1(), "playCount": count, **thresholds, **weights})
    loops = [signals(SAMPLES, *ends) for ends in ((5.0, 60.0), (20.0, 45.0), (25.0, 31.0))]
    traces = [measured(truth, i, voltage) for i, voltage in enumerate(loops)]
    bench = Bench(traces=traces, deciding=traces, **BENCH)
    [even, *_] = EVIDENCE["play"].guesses(bench.clues(rest))
    if share is not None:
        even = {**truth.values, **EVIDENCE["play"].scaled(truth.values, bench.extent, share)}
    base = at_rest(replace(truth, values={**table_1(), **even}))
    node = node_of(bench, frozenset({"play"}), bench.fit(base, 60))
    scaled = _scaled(bench, node, "play")
    assert node.rms > left * NOISE
    assert scaled.rms < 1.5 * NOISE


def play_operators(voltage: np.ndarray) -> np.ndarray:
    """Return the displacement of a stage made of many play operators, new at 0 V, in m."""
    threshold = np.linspace(0.0, 60.0, 100)
    weight, output = 2.4e-9 * np.exp(-threshold / 30.0), np.zeros(100)
    displacement = np.empty(len(voltage))
    for k, x in enumerate(voltage):
        output = np.clip(output, x - threshold, x + threshold)
        displacement[k] = weight @ output
    return displacement


def first_loops(rate: float, faster: float, late: int) -> Record:
    """Return a record of a stage that was new at 0 V and answers so many samples late."""
    t = np.arange(1500) / rate
    pi = faster * np.pi
    voltage = 50.0 + 35.0 * np.sin(1.2 * pi * t) + 12.0 * np.sin(3.4 * pi * t + 1.0)
    displacement = play_operators(voltage)
    displacement = np.concatenate([np.full(late, displacement[0]), displacement])[: len(t)]
    noise = 5e-4 * np.ptp(displacement) * np.random.default_rng(5).standard_normal(len(t))
    return Record("initial", t, voltage, displacement + noise, t[1])


def test_the_initial_curve_of_a_stage_from_0_v_is_fitted():
    """Loops engage operators up to half the voltage's span; on its first way up it is all of it."""
    record = first_loops(300.0, 1.0, 0)
    noise = 5e-4 * np.ptp(record.displacement)
    (judged,) = diagnose([record], **alone("play")).records
    assert judged.e_rms < 2.0 * noise  # 17 without
    assert judged.cold_start < 2.0 * noise


@pytest.mark.gate
def test_a_delay_behind_that_curve_is_no_work_of_the_core():
    """The records hardly tell a slow core from a delay; its inverse does."""
    record = first_loops(1000.0, 10.0 / 3.0, 10)
    found = diagnose([record], **alone("play", "delay"))
    (judged,) = found.records
    assert judged.e_rms < 2.0 * 5e-4 * np.ptp(record.displacement)  # 18 before
    assert judged.inverse.e_rms < 5e-3 * np.ptp(record.voltage)  # 3.2e-2 before
    assert abs(found.parameters["delay.time"] - 0.010) < 0.0015  # 0 before


def test_fmus_begin_as_a_stage_does_that_nothing_was_done_to():
    """Of two records that begin at 0 V, the first was driven before; a cold start is from rest."""
    driven, new = from_zero(driven=True), from_zero(driven=False)
    _, judged = diagnose([driven, new], **alone("play")).records
    assert judged.cold_start < 1.2 * judged.e_rms


def test_the_only_record_from_0_v_is_no_rest_where_the_stage_was_moving():
    """Creep of what was before goes on in it: a stage at rest would be off by all of that."""
    creep = {"creepCount": 1, "creep[1].gain": 0.05, "creep[1].timeConstant": 1.0}
    rest = resting(ParameterSet({**table_1(), **creep, "sampleTime": TS}, "creep").validate())
    own = {n: np.zeros(3) for n in ("initialCreep", "initialCreepAge", "initialDisplacement")}
    model = Model({**rest}, ("creep",), np.zeros(3), own)
    traces = [measured(model, i) for i in range(3)]
    start = {"initialDisplacement": rest["initialDisplacement"], "initialCreep": 5 * UM}
    assert begun_at_rest(rest, {1: start}, traces, model.offsets) == rest
    settled = {**start, "initialCreep": 0.01 * UM}
    assert begun_at_rest(rest, {1: settled}, traces, model.offsets) == rest.replace(**settled)
    # of one record alone nothing else is known
    assert begun_at_rest(rest, {0: start}, traces[:1], model.offsets) == rest.replace(**start)


def from_zero(driven: bool) -> Record:
    """Return a record that begins at 0 V, of a stage that is new or was driven to 90 V before."""
    t = np.arange(1500) / 500.0
    voltage = 40.0 * (1.0 - np.cos(2.2 * np.pi * t)) + 10.0 * (1.0 - np.cos(7.4 * np.pi * t))
    voltage[:10] = 0.0
    before = 45.0 * (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, 200))) if driven else []
    displacement = play_operators(np.concatenate([before, voltage]))[-len(t) :]
    noise = 5e-4 * np.ptp(displacement) * np.random.default_rng(6).standard_normal(len(t))
    return Record("driven" if driven else "new", t, voltage, displacement + noise, t[1])


def test_creep_that_has_forgotten_in_part_what_was_before_is_begun_with():
    """What was before a record has left the fast terms of creep, and not the slow ones."""
    records = [creeping(before, seed) for seed, before in enumerate((40.0, 65.0, 15.0, 60.0, 20.0))]
    found = diagnose(records[:3], [], records[3:], **alone("creep"))
    for record, judged in zip(records, found.records, strict=True):
        assert judged.e_rms < 1.3 * 5e-4 * np.ptp(record.displacement)  # up to 2.8 without its age


def test_what_the_first_model_made_up_for_by_record_is_left_to_the_effect():
    """A stage at rest at several voltages: constants of records look like creep that they lack."""
    records = [creeping(None, seed, phase) for seed, phase in enumerate((0.0, 1.5, 3.0, 0.7, 2.2))]
    found = diagnose(records[:3], [], records[3:], **alone("creep"))
    assert found.parameters["initialCreep"] == 0.0
    for record, judged in zip(records, found.records, strict=True):
        assert judged.offset == 0.0  # up to 28 times the noise before
        assert judged.cold_start < 1.3 * 5e-4 * np.ptp(record.displacement)


def test_creep_slower_than_records_from_one_rest_is_said_with_its_size():
    """What goes on for longer is the same in all of them; what they show tells how large it is."""
    values = {"creepCount": len(SLOW)}
    for i, (gain, constant) in enumerate(zip(LOGARITHMIC, SLOW, strict=True), start=1):
        values |= {f"creep[{i}].gain": gain, f"creep[{i}].timeConstant": constant}
    evidence = EVIDENCE["creep"]
    one = [creeping(None, 0), creeping(None, 0, pace=2.0)]
    said = evidence.not_shown(values, one, one)
    assert "begin at 10 V" in said and "longest of them (4 s)" in said
    share = float(re.search(r"by ([0-9.]+) % of the way", said)[1])
    assert share == pytest.approx(100 * LOGARITHMIC[0] / np.log10(SLOW[1] / SLOW[0]), rel=0.05)
    assert said.endswith("A record that begins after a rest at another voltage would show it.")
    other = creeping(None, 0, 1.5)
    assert evidence.not_shown(values, [*one, other], one) == ""
    # one that decides was not fitted: the model may miss what it shows
    said = evidence.not_shown(values, one, [*one, other])
    assert f"begins at {other.voltage[0]:.3g} V: as a training record it may show more" in said


def test_creep_goes_on_behind_records_of_one_rest_as_at_their_end():
    """No record shows it, and one that rested at another voltage moves by all of it."""
    fitted = [creeping(None, seed, pace=pace) for seed, pace in enumerate((1.0, 1.5))]
    found = diagnose(fitted, [], [creeping(None, 2, 1.5)], **alone("creep"))
    assert any("takes it to go on as creep does" in w for w in found.warnings)
    *_, judged = found.after
    noise = 5e-4 * np.ptp(creeping(None, 2, 1.5).displacement)
    assert judged.cold_start < 2.0 * noise  # 1.16 now
    assert judged.e_rms < 1.2 * noise


def test_a_record_that_decides_and_rested_elsewhere_shows_how_much_creep_goes_on():
    """It was taken to go on as at the records' end, where it ended with them, whatever that showed."""
    ended = np.where(SLOW < 4.0, 2.0 * LOGARITHMIC, 0.0)
    fitted = [creeping(None, seed, gains=ended, pace=pace) for seed, pace in enumerate((1.0, 1.5))]
    deciding, test = (creeping(None, 2 + i, 2.5 + 0.5 * i, gains=ended) for i in range(2))
    noise = 5e-4 * np.ptp(test.displacement)
    told, untold = (
        diagnose(fitted, validation, [test], **alone("creep")).after[-1].cold_start
        for validation in ([deciding], [])
    )
    assert told < 3.0 * noise  # 2.2 now
    assert untold > 10.0 * noise


def test_creep_that_goes_on_by_less_than_at_the_records_end_goes_on_by_that():
    """All of it makes the records less likely; it was left out as a whole then."""
    terms = {"times": np.array([0.02, 0.35, 12.0]), "gains": np.array([0.02, 0.045, 0.0155])}
    fitted = [creeping(None, seed, pace=pace, **terms) for seed, pace in enumerate((1.0, 1.5))]
    test = creeping(None, 2, 2.5, **terms)
    judged = diagnose(fitted, [], [test], **alone("creep")).after[-1]
    assert judged.cold_start < 2.0 * 5e-4 * np.ptp(test.displacement)  # 1.4 now, 7.7 before


def test_creep_of_stages_at_rest_at_two_voltages_foretells_rest_at_a_third():
    """Few terms, at the times where records show the most, miss how much there is in all of it."""
    fitted = [creeping(None, 3, 1.5), creeping(None, 4, 1.8, pace=1.5)]
    foretold = creeping(None, 5, pace=1.2)
    begins = [r.voltage[0] for r in fitted]
    assert foretold.voltage[0] < min(begins) - np.ptp(begins)
    found = diagnose(fitted, [], [foretold], **alone("creep"))
    noise = 5e-4 * np.ptp(foretold.displacement)
    assert [j.cold_start < 2.0 * noise for j in found.after] == [True] * 3  # 3.6, 1.7 and 10.6 before
    # what is held is no result of the fit
    assert found.parameters["creepCount"] > 6
    assert np.all(np.isfinite(found.intervals["creep[1].gain"]))
    assert not any(name.endswith("timeConstant") for name in found.intervals)


def test_what_goes_on_is_fitted_to_its_end(monkeypatch):
    """After ten iterations it seemed worse than nothing once, and was left out."""
    ends = []

    def noted(bench, fit, going_on=last_fit._going_on):
        ends.append(going_on(bench, fit))
        return ends[-1]

    monkeypatch.setattr(last_fit, "_going_on", noted)
    records = [creeping(None, 2, 1.5, gains=2.0 * LOGARITHMIC, pace=p) for p in (0.5, 0.75)]
    diagnose(records, [], [], **alone("creep"))
    (end,) = ends
    assert end.criterion.held
    assert end.minimum.converged
    assert end.minimum.iterations > 10


def of_terms(gains, constants) -> dict[str, float]:
    """Return the values of terms of creep."""
    values = {"creepCount": len(gains)}
    for i, (gain, constant) in enumerate(zip(gains, constants, strict=True), start=1):
        values |= {f"creep[{i}].gain": gain, f"creep[{i}].timeConstant": constant}
    return values


def going_on(values: dict) -> tuple[np.ndarray, np.ndarray]:
    """Return gains and time constants with the term that goes on, which is the last and held."""
    more, held = EVIDENCE["creep"].going_on(values, EXTENT)
    count = more["creepCount"]
    assert held == [f"creep[{count}].gain", f"creep[{count}].timeConstant"]
    assert more["creepCount"] == sum(name.endswith(".gain") for name in more)
    return tuple(
        np.array([more[f"creep[{i}].{name}"] for i in range(1, count + 1)])
        for name in ("gain", "timeConstant")
    )


def test_terms_as_slow_as_each_other_hand_on_no_more_than_they_have():
    """By least squares alone one of them became 338 times the displacement, another 0."""
    longest = EXTENT.duration
    constants = np.array([0.03, 1.0, 1.00006]) * longest
    gains, _ = going_on(of_terms([0.02] * 3, constants))
    assert len(gains) == 4
    assert np.all((gains[:3] >= 0.0) & (gains[:3] <= 0.02))
    # they were 0.06 in all, and go on by as much as they grow within the last decade
    growth = np.exp(-0.1 * longest / constants) - np.exp(-longest / constants)
    assert gains[3] == pytest.approx(0.02 * np.sum(growth), rel=1e-12)


def test_a_term_slower_than_the_records_is_one_of_those_that_go_on():
    """It was fitted to be twice as large as creep was in all: 6.9 times the noise elsewhere."""
    longest = EXTENT.duration
    before = of_terms([0.007, 0.009, 0.001, 0.022], np.array([0.03, 0.15, 1.0, 3.5]) * longest)
    gains, constants = going_on(before)
    assert len(gains) == 4
    assert constants[-1] == pytest.approx(3.0 * longest)
    assert gains[-1] < 0.013
    # within the records it does the same, but for what is there at once
    time = np.linspace(0.1, 1.0, 50)[:, None] * longest
    after = (1.0 - np.exp(-time / constants)) @ gains
    was = sum(
        before[f"creep[{i}].gain"] * (1.0 - np.exp(-time[:, 0] / before[f"creep[{i}].timeConstant"]))
        for i in range(1, 5)
    )
    assert np.std(after - was) < 0.02 * np.ptp(was)


def test_creep_that_no_fitted_record_shows_is_not_unexplained(monkeypatch: pytest.MonkeyPatch):
    """Where it does not go on so, it is said with its size, and does not count."""
    monkeypatch.setattr(type(EVIDENCE["creep"]), "going_on", lambda *_: None)
    fitted = [creeping(None, seed, pace=pace) for seed, pace in enumerate((1.0, 2.0))]
    found = diagnose(fitted, [creeping(None, 2, 1.5)], **alone("creep"))
    assert any("longest of them" in w for w in found.warnings)
    assert not found.unexplained, found.left_over
    (size,) = re.findall(r"leaves out ([0-9.]+) µm rms of record", found.left_over[0])
    *_, judged = found.records
    assert float(size) == pytest.approx(1e6 * judged.e_rms, rel=0.2)


def test_a_lead_in_lasts_until_the_voltage_moves():
    """While it is held, creep and what play remembers look alike, and a model's error like both."""
    own = {name: np.zeros(1) for name in ("initialDemagnetisation", "initialExcursion")}
    own |= {"initialDisplacement": np.array([5.0]) * UM}
    model = Model({**table_1(), **PLAY}, ("play",), np.zeros(1), own)
    voltage = signals(SAMPLES, *LOOPS[0])
    held = np.concatenate([np.full(400, voltage[0]), voltage[:-400]])
    trace = measured(model, 0, held)
    bench = Bench([trace], Scaling(8 * UM, 8 * UM, 50.0, 50.0), EXTENT, [trace], parts=True)
    assert bench.with_lead_in(model, trace).lead > 400


def test_a_lead_in_lasts_for_a_period_of_a_line():
    """A part of one looks like a slow error of the model, which the phase then makes up for."""
    own = {"hum.phase": np.zeros(1), "initialDisplacement": np.array([5.0]) * UM}
    line = {"hum.amplitude": 30.0 * NOISE, "hum.frequency": 1.0 / (200.0 * TS)}
    model = Model({**table_1(), **line}, ("hum",), np.zeros(1), own)
    trace = measured(model, 0)
    bench = Bench([trace], Scaling(8 * UM, 8 * UM, 50.0, 50.0), EXTENT, [trace], parts=True)
    assert 200 <= bench.with_lead_in(model, trace).lead <= 300


def test_a_slow_error_late_in_a_lead_in_tells_that_the_past_is_not_forgotten():
    """It is far less than what a mean square shows, and goes on behind the lead-in."""
    for seed in range(20):
        late = NOISE * np.random.default_rng(seed).standard_normal(400)
        assert _forgotten(late, NOISE**2, 0.0)
        assert not _forgotten(late + 0.6 * NOISE, NOISE**2, 0.0)
        assert not _forgotten(late + NOISE * np.linspace(-1.2, 1.2, 400), NOISE**2, 0.0)
        # as much as the model misses anyhow
        assert _forgotten(late + 0.6 * NOISE, NOISE**2, 0.36 * NOISE**2)


def test_what_is_missed_in_the_lead_ins_is_not_expected_behind_them():
    model = Model(table_1(), (), np.zeros(1), {"initialDisplacement": np.array([5.0]) * UM})
    trace = measured(model, 0)
    unlike = trace.y.copy()
    unlike[: trace.lead] += 1.0 * UM
    trace = replace(trace, y=unlike)
    bench = Bench([trace], Scaling(8 * UM, 8 * UM, 50.0, 50.0), EXTENT, [trace], parts=True)
    assert bench._misfit(model).power < 0.2 * NOISE**2


def test_creep_of_a_dozen_samples_is_fitted():
    drawn = np.array([0.022, 0.3, 3.0]), np.array([0.06, 0.02, 0.03]), 2.0
    records = [creeping(None, seed, phase, *drawn) for seed, phase in enumerate((0.0, 1.5, 3.0, 0.7))]
    found = diagnose(records[:3], [], records[3:], **alone("creep"))
    for record, judged in zip(records, found.records, strict=True):
        assert judged.cold_start < 1.2 * 5e-4 * np.ptp(record.displacement)  # up to 3.2 from 20


def test_a_lead_in_lasts_until_the_start_is_met():
    """How the stage comes from where it was is nothing that the model could begin with."""
    own = {name: np.zeros(1) for name in ("initialDemagnetisation", "initialExcursion")}
    own |= {"initialDisplacement": np.array([5.0]) * UM}
    model = Model({**table_1(), **PLAY}, ("play",), np.zeros(1), own)
    trace = measured(model, 0)
    coming = trace.y + 20 * NOISE * np.exp(-np.arange(SAMPLES) / 100.0)
    bench = Bench([trace], Scaling(8 * UM, 8 * UM, 50.0, 50.0), EXTENT, [trace], parts=True)
    lead = bench.with_lead_in(model, replace(trace, y=coming)).lead
    assert lead >= bench.with_lead_in(model, trace).lead + 200


def creeping(
    before: float | None,
    seed: int,
    phase: float = 0.0,
    times: np.ndarray = SLOW,
    gains: np.ndarray = LOGARITHMIC,
    pace: float = 1.0,
) -> Record:
    """Return a record of a stage that creeps.

    Until shortly before it stood for long at a voltage, or at its first one.
    """
    rate = 500.0
    t = np.arange(2000) / rate
    slow = 20.0 * np.cos(2.2 * pace * np.pi * t + phase)
    voltage = 40.0 - slow - 10.0 * np.cos(7.4 * pace * np.pi * t + 0.3 * seed)
    before = voltage[0] if before is None else before
    driven = np.concatenate([np.full(100, voltage[0]), voltage])
    states = np.full(len(times), before)
    core, displacement = voltage[0], np.empty(len(driven))
    for k, x in enumerate(driven):
        core += 0.6 * (x - core)
        states += -np.expm1(-1.0 / rate / times) * (core - states)
        displacement[k] = 0.15e-6 * (core + gains @ states)
    displacement = displacement[100:]
    noise = 5e-4 * np.ptp(displacement) * np.random.default_rng(seed).standard_normal(len(t))
    return Record(f"{seed}, before {before:g} V", t, voltage, displacement + noise, t[1])
