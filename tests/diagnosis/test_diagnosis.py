"""The loop on seeded records of an independent simulator: what it names, and what it leaves alone.

The cases are those of `cases.suite`, most with their records cut short so that a diagnosis takes
seconds; all of them at full length are `benchmarks/diagnosis.py`. A case is one test, so that processes
that share the tests do not diagnose it twice.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from diagnosis.cases import Case, short, suite

from it2hys.diagnosis import Diagnosis, diagnose
from it2hys.diagnosis.outcome import Judgement
from it2hys.diagnosis.residuals import left_over
from it2hys.errors import InputError
from it2hys.identification import Options
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS
from it2hys.records import Record
from it2hys.records.clues import Clue, Clues, Extent

TRAINING = 3
CASES = {case.name: case for case in suite()}
#: Cases that are diagnosed and told the truth, and those of short records: one of each other effect.
TOLD = ("hum 1",)
#: A third of the starts of the paper's model, which is no more than where these diagnoses begin.
FEW_STARTS = Options(starts=12)
SHORT = [case for case in short() if case.truth[0] != "hum"]


def records(case: Case, samples: int) -> list[list[Record]]:
    """Return training, validation and test records, cut to so many samples."""

    def cut(record: Record) -> Record:
        arrays = {n: v[:samples] for n, v in vars(record).items() if isinstance(v, np.ndarray)}
        return replace(record, **arrays)

    roles = (case.train[:TRAINING], case.validation, case.test)
    return [[cut(record) for record in role] for role in roles]


def most_others(case: Case) -> list[str]:
    """Return effects to leave out, others for every case: a diagnosis takes as long as it has to try.

    Beside all others a case is diagnosed by `benchmarks/diagnosis.py`.
    """
    others = [e for e in EFFECTS if e not in case.truth]
    return [e for i, e in enumerate(others) if (i + case.seed) % 5]


def unseen_error(judgements: Sequence[Judgement]) -> float:
    return float(np.sqrt(np.mean([j.e_rms**2 for j in judgements if j.role == "test"])))


# --- what holds for every diagnosis --------------------------------------------------------------


def assert_sound(diagnosis: Diagnosis, train: Sequence[Record]) -> None:
    assert_evidence_is_whole(diagnosis)
    assert_steps_lead_to_the_end(diagnosis, train)
    assert_groups_are_open_questions(diagnosis)
    assert_parameters_belong_to_it(diagnosis)


def assert_evidence_is_whole(diagnosis: Diagnosis) -> None:
    assert [e.effect for e in diagnosis.evidence] == list(EFFECTS)
    for e in diagnosis.evidence:
        assert e.why
        assert e.accepted == (e.effect in diagnosis.effects), e
        assert np.isnan(e.p_value) == np.isnan(e.statistic) == (e.signature == ""), e
        assert np.isnan(e.p_value) or 0.0 <= e.p_value <= 1.0, e
        tried = not e.why.startswith(("not tried", "declared"))
        assert np.isfinite(e.held_out_gain) == np.isfinite(e.held_out_p_value) == tried, e
        if e.accepted:
            assert e.held_out_gain >= 0.05 and e.held_out_p_value < 0.05 / 144, e


def assert_steps_lead_to_the_end(diagnosis: Diagnosis, train: Sequence[Record]) -> None:
    stages = diagnosis.stages
    assert stages[0].label == "before"
    assert (len(stages) > 1) == bool(diagnosis.effects)
    if diagnosis.effects:
        assert stages[-1].label == " + ".join(diagnosis.effects)
        assert stages[-1].e_rms < 0.95 * stages[0].e_rms
    for stage in stages:
        assert [len(r) for r in stage.residuals] == [len(r) for r in train]
        for residual, first in zip(stage.residuals, stages[0].residuals, strict=True):
            counts = np.isfinite(residual)  # start-up and outliers do not
            assert np.mean(counts) >= 0.5 and np.array_equal(counts, np.isfinite(first))


def assert_groups_are_open_questions(diagnosis: Diagnosis) -> None:
    """Check that what cannot be told apart is not named, but the experiment that would decide is."""
    why = {e.effect: e.why for e in diagnosis.evidence}
    for group, experiment in zip(diagnosis.indistinguishable, diagnosis.experiments, strict=True):
        assert not {*group} & {*diagnosis.effects, *diagnosis.declared}
        assert all(effect in experiment and "cannot tell" in why[effect] for effect in group)


def assert_parameters_belong_to_it(diagnosis: Diagnosis) -> None:
    for judgements in (diagnosis.before, diagnosis.after):
        assert [j.role for j in judgements] == ["train"] * TRAINING + ["validation"] * 2 + ["test"] * 2
        assert all(np.isfinite([j.e_mr, j.e_rms]).all() and j.noise > 0.0 for j in judgements)
    on = {name for name, effect in EFFECTS.items() if effect.is_on(diagnosis.parameters)}
    # a part of a sample of delay belongs to how fast effects are sampled
    assert {*diagnosis.effects, *diagnosis.declared} == on - ({"delay"} - {*diagnosis.effects})
    for name, (low, high) in diagnosis.intervals.items():
        assert np.isnan(low) or low <= diagnosis.parameters[name] <= high, name


def assert_creep_at_one_rest_is_said(diagnosis: Diagnosis, fitted: Sequence[Record]) -> None:
    begins = {round(float(r.voltage[0]), 6) for r in fitted}
    said = any("takes longer than the longest" in warning for warning in diagnosis.warnings)
    assert said == ("creep" in diagnosis.effects and len(begins) == 1)


def assert_cold_starts_are_the_packaged_set(diagnosis: Diagnosis, test: Sequence[Record]) -> None:
    """Check the errors from a cold start by runs of the parameters as packaged."""
    judged = [j for j in diagnosis.after if j.role == "test"]
    for judgement, record in zip(judged, test, strict=True):
        first = record.displacement[0] - judgement.offset
        told = diagnosis.parameters.replace(initialDisplacement=float(first))
        reading = compiled.chain_free_run(told, record.voltage, record.force, record.temperature)[1]
        error = (record.displacement - judgement.offset - reading)[judgement.used]
        assert judgement.cold_start == pytest.approx(np.sqrt(np.mean(error**2)))


# --- cases ---------------------------------------------------------------------------------------


def test_every_effect_of_the_catalogue_is_found_by_a_test():
    assert {e for case in (*SHORT, *map(CASES.get, TOLD)) for e in case.truth} == {*EFFECTS}


@pytest.mark.parametrize("case", SHORT, ids=lambda case: case.name)
def test_an_effect_is_found_in_short_records(case):
    train = case.train[:TRAINING]
    found = diagnose(train, case.validation, case.test, options=FEW_STARTS, excluded=most_others(case))
    # whether nothing else is named, and how near to the noise, is the gate's to say: so short records
    # leave room for a second name, even where the truth is told
    assert {*case.truth} <= {*found.effects}
    assert_sound(found, train)
    assert_cold_starts_are_the_packaged_set(found, case.test)
    assert_creep_at_one_rest_is_said(found, train)
    assert unseen_error(found.after) < 0.5 * unseen_error(found.before)


@pytest.mark.parametrize("name", TOLD)
def test_what_is_there_is_named_and_nothing_else(name):
    case = CASES[name]
    roles = records(case, 1200)
    left_out = most_others(case)
    found = diagnose(*roles, options=FEW_STARTS, excluded=left_out)
    assert set(found.effects) == set(case.truth)
    assert_sound(found, roles[0])
    assert unseen_error(found.after) < 1.5 * case.noise_rms
    told = diagnose(*roles, declared=case.truth, options=FEW_STARTS, excluded=left_out)
    assert told.declared == case.truth and told.effects == ()
    assert_sound(told, roles[0])
    assert unseen_error(found.after) < 1.1 * unseen_error(told.after)


@pytest.mark.parametrize(
    ("seeds", "name"), [(580_000, "lag 2"), (580_000, "saturation 5"), (600_000, "lag+hum")]
)
def test_what_is_declared_is_fitted_to_the_noise(seeds, name):
    """Strong lags were fitted from constants that lead elsewhere, a limit from a model not fitted."""
    case = next(case for case in suite(seeds) if case.name == name)
    others = [e for e in EFFECTS if e not in case.truth]
    roles = case.train, case.validation, case.test
    told = diagnose(*roles, declared=case.truth, excluded=others, options=FEW_STARTS)
    assert unseen_error(told.after) < 1.3 * case.noise_rms


def test_where_nothing_is_nothing_is_named_and_noise_is_left():
    case = CASES["none 1"]
    roles = records(case, 1500)
    found = diagnose(*roles, options=FEW_STARTS, excluded=most_others(case))
    assert found.effects == ()
    assert not found.unexplained, found.left_over
    assert len(found.left_over) == 1  # of the test records, too, nothing is to be told
    assert_sound(found, roles[0])
    assert unseen_error(found.after) < 1.1 * case.noise_rms


def test_an_effect_outside_the_catalogue_is_left_unexplained_and_described():
    case = CASES["outside: jumps"]
    roles = records(case, 1200)
    found = diagnose(*roles, options=FEW_STARTS, excluded=most_others(case))
    assert found.effects == ()
    assert found.unexplained
    assert len(found.left_over) >= 3 and "noise" in found.left_over[0]
    assert found.left_over[-1].startswith("On the test records, which decided nothing")
    assert_sound(found, roles[0])


@pytest.mark.parametrize(
    "left_out",
    [lambda k: k < 1250, lambda k: (k > 800) & (k < 2100), lambda k: k % 20 < 9],
    ids=["a start-up", "a stretch", "the top of every cycle"],
)
def test_samples_that_are_left_out_do_not_make_noise_look_like_more(left_out):
    """Half of a record may be a start-up, or beyond the range: what is left is noise as before."""
    rng = np.random.default_rng(0)
    count = 2500
    used = ~left_out(np.arange(count))
    quiet = np.zeros(count)
    voltage = 50.0 - 50.0 * np.cos(0.02 * np.arange(count))
    noise = 7e-9 * rng.standard_normal(count)
    clue = Clue(voltage, quiet, quiet, 1.5e-7 * voltage + noise, noise, used)
    extent = Extent(1e-4, count * 1e-4, (0.0, 100.0), (0.0, 15e-6))
    left = left_over(Clues(extent, [clue]), [7e-9])
    assert left.records[0].noise == pytest.approx(7e-9, rel=0.1)
    assert left.records[0].p_steady > 1e-3 and not left.significant


# --- refusals ------------------------------------------------------------------------------------


def test_a_declared_load_needs_a_force():
    train = [replace(r, force=None) for r in records(CASES["none 1"], 1000)[0]]
    with pytest.raises(InputError, match="force_N"):
        diagnose(train, declared=["load"])


def test_records_of_two_sample_times_are_refused():
    first, second, *_ = records(CASES["none 1"], 1000)[0]
    slow = replace(second, sample_time=2 * first.sample_time, time=2 * second.time)
    with pytest.raises(InputError, match="sample"):
        diagnose([first, slow])


def test_no_training_record_is_refused():
    with pytest.raises(InputError, match="no training record"):
        diagnose([])
