"""The gate of the diagnosis: where it closes, what it keeps of a run that was ended, on which seeds."""

import importlib.util
import json
import sys
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path

import pytest
from diagnosis.cases import CHOSEN_ON, RANGE, suite
from diagnosis.outcomes import Outcome, run_case

SPEC = importlib.util.spec_from_file_location(
    "diagnosis_gate", Path(__file__).parents[2] / "benchmarks" / "diagnosis.py"
)
gate = sys.modules[SPEC.name] = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(gate)

GOOD = Outcome(
    "play 1", "play", RANGE, ("play",), ("play",), noise=5e-9, cold=(True, True),
    errors=(5e-9, 5e-9), best=(5e-9, 5e-9), inverse=(0.1, 0.1), inverse_best=(0.1, 0.1),
    inverse_noise=(0.05, 0.05), held_back=0.0, cpu=30.0, seconds={"search": 20.0},
)  # fmt: skip
OUTSIDE = replace(
    GOOD, name="outside: jumps", kind="outside", there=(), named=(), unexplained=True,
    errors=(5e-8, 5e-8), best=(), inverse_best=(),
)  # fmt: skip


def outcomes(good=100, *others):
    return [*(replace(GOOD, name=f"play {i}") for i in range(good)), OUTSIDE, *others]


def said(good, *others):
    return gate.shortfalls(gate.summarise(outcomes(good, *others)))


# --- where it closes -----------------------------------------------------------------------------


def test_what_holds_passes():
    assert said(100) == []


@pytest.mark.parametrize(
    ("good", "few", "other", "word"),
    [
        (100, 2, replace(GOOD, named=()), "exactly right"),
        (100, 0, replace(GOOD, named=("play", "creep")), "false name"),
        (100, 0, replace(OUTSIDE, named=("hum",)), "false name"),
        (95, 5, replace(GOOD, errors=(5e-9, 8.5e-9)), "in 95% it must be"),
        (100, 0, replace(GOOD, errors=(5e-9, 2.2e-8)), "worst case"),
        (95, 5, replace(GOOD, inverse=(0.1, 0.15)), "told the truth in"),
        (95, 5, replace(GOOD, unexplained=True), "called unexplained"),
        (100, 0, replace(OUTSIDE, unexplained=False), "outside the catalogue"),
        (100, 0, replace(GOOD, failure="InputError: too short"), "worst case"),
        (100, 0, replace(GOOD, failure_of_truth="InputError: too short"), "ended with a message"),
    ],
)
def test_it_closes_just_below_each_limit(good, few, other, word):
    """So many cases of the kind pass, and one more does not."""
    assert said(good, *[other] * few) == []
    assert any(word in sentence for sentence in said(good, *[other] * (few + 1)))


def test_errors_of_what_the_catalogue_lacks_do_not_count():
    figures = gate.summarise(outcomes(10))
    assert figures["error_over_noise"]["of"] == 10
    assert figures["error_over_noise"]["max"] == pytest.approx(1.0)


def test_effects_are_counted_right_missed_and_false():
    others = (replace(GOOD, named=("creep",)), replace(GOOD, named=("play", "creep")))
    effects = gate.summarise(outcomes(3, *others))["effects"]
    assert effects["play"] == {"right": 4, "missed": 1, "false": 0}
    assert effects["creep"] == {"right": 0, "missed": 0, "false": 2}


# --- what is kept --------------------------------------------------------------------------------


def test_a_run_that_was_ended_goes_on_where_it_was(tmp_path, monkeypatch):
    cases = list(suite(RANGE))[:4]
    path = tmp_path / "runs" / "done.jsonl"
    path.parent.mkdir()
    kept = replace(GOOD, name=cases[1].name, cpu=77.0)
    elsewhere = replace(GOOD, name=cases[2].name, seeds=2 * RANGE)
    path.write_text(kept.line + elsewhere.line + GOOD.line[:40])  # killed while it wrote
    monkeypatch.setattr(gate, "make_pool", lambda count: InThisProcess())
    monkeypatch.setattr(gate, "run_case", lambda case, first: replace(GOOD, name=case.name))
    done = gate.run_all(cases, RANGE, path)
    assert [o.name for o in done] == [case.name for case in cases]
    assert [o.cpu for o in done] == [30.0, 77.0, 30.0, 30.0]
    assert len(path.read_text().splitlines()) == 5
    monkeypatch.setattr(gate, "run_case", lambda case, first: 1 / 0)
    assert gate.run_all(cases, RANGE, path) == done


class InThisProcess:
    def submit(self, call, *arguments):
        future = Future()
        future.set_result(call(*arguments))
        return future

    def shutdown(self, **_):
        pass


def test_a_case_that_cannot_be_diagnosed_counts_as_failed(monkeypatch):
    def fail(*_, **__):
        raise ArithmeticError("what nobody thought of")

    monkeypatch.setattr("diagnosis.outcomes.diagnose", fail)
    outcome = run_case(next(suite(RANGE)), RANGE)
    assert outcome.failure == "ArithmeticError: what nobody thought of"
    assert not outcome.is_right and outcome.over_noise == float("inf")
    assert Outcome.read(outcome.line).failure == outcome.failure


# --- which seeds ---------------------------------------------------------------------------------


def line_of(sources, seeds, **others):
    return {"commit": "abcdef0", "sources": sources, "seeds": seeds, "wanted": "*", **others}


def test_seeds_are_new_for_other_sources_and_stay_for_the_same(tmp_path):
    path = tmp_path / "history.jsonl"
    first = max(CHOSEN_ON) + RANGE
    assert gate.fresh_seeds(path, "one") == first
    figures = gate.summarise(outcomes(2))
    assert "was added" in gate.remember(path, line_of("one", first), figures)
    assert gate.fresh_seeds(path, "one") == first
    assert gate.fresh_seeds(path, "two") == first + RANGE
    (line,) = map(json.loads, path.read_text().splitlines())
    assert line["seeds"] == first and line["cases"] == 3 and line["exactly_right"] == 1.0
    assert line["error_over_noise"]["median"] == 1.0


def test_seeds_that_were_seen_and_runs_that_stand_there_are_not_reported_again(tmp_path):
    path = tmp_path / "history.jsonl"
    figures = gate.summarise(outcomes(2))
    first = max(CHOSEN_ON) + RANGE
    gate.remember(path, line_of("one", first), figures)
    for line in (line_of("one", first), line_of("two", first), line_of("one", CHOSEN_ON[0])):
        assert "was added" not in gate.remember(path, line, figures)
    assert len(path.read_text().splitlines()) == 1


def test_cases_are_spread_evenly_or_chosen_by_name():
    whole = [case.name for case in suite(RANGE)]
    few = [case.name for case in gate.chosen(RANGE, "6")]
    assert len(few) == 6 and few[0] == whole[0] and few[-1] == whole[-1]
    assert all(case.seed >= RANGE for case in gate.chosen(RANGE, "6"))
    assert [case.name for case in gate.chosen(RANGE, "play [12]")] == ["play 1", "play 2"]


def test_other_sources_are_told_from_these(tmp_path, monkeypatch):
    here = gate.digest()
    (tmp_path / "python" / "it2hys").mkdir(parents=True)
    (tmp_path / "python" / "it2hys" / "chain.py").write_text("EFFECTS = {}\n")
    monkeypatch.setattr(gate, "ROOT", tmp_path)
    there = gate.digest()
    (tmp_path / "python" / "it2hys" / "chain.py").write_text("EFFECTS = []\n")
    assert len({here, there, gate.digest()}) == 3
    assert gate.commit() == "unknown"
