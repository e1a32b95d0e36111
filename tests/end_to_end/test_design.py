"""`it2hys design` as a whole: what it writes is played, diagnosed and set beside its promise."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from conftest import TS, UM
from test_cli import Page, assert_self_contained, html_of, run
from test_diagnose import stage_with

from it2hys.designs.hypotheses import question_of
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import read_ssv, table_1, write_ssv
from it2hys.records import Record, write_record
from it2hys.reports.courses import voltages_at_hand

SCHEMA = json.loads((Path(__file__).parents[2] / "docs" / "design.schema.json").read_text())
SCHEMA_OF_REPORT = Path(__file__).parents[2] / "docs" / "report.schema.json"
NOISE = 0.006 * UM
#: Leaves out of a diagnosis what is not asked for, to be quick.
OTHERS = ("--exclude", ",".join(e for e in EFFECTS if e not in ("delay", "lag", "resonance")))
LIMITS = ("--duration", 0.12, "--slew", 30_000, "--family", "steps")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Design a record that tells a delay from a lag, into `next`."""
    folder = tmp_path_factory.mktemp("design")
    write_ssv(table_1(), folder / "P.ssv")
    asked = ("design", folder / "P.ssv", "--between", "delay,lag", "--noise", 0.006, *LIMITS)
    assert run(*asked, "-o", folder / "next", "--quiet") == 0
    return folder


def design_of(folder):
    return json.loads((folder / "next" / "design.json").read_text(encoding="utf-8"))


def voltage_of(folder):
    return np.loadtxt(folder / "next" / "voltage.csv", delimiter=",", skiprows=1)


def test_it_leaves_a_voltage_to_play_within_the_limits(folder):
    assert {p.name for p in (folder / "next").iterdir()} == {
        "voltage.csv", "design.json", "design.html", "design.png",
    }  # fmt: skip
    header = (folder / "next" / "voltage.csv").read_text().split("\n", 1)[0]
    assert header == "time_s,voltage_V"
    time, voltage = voltage_of(folder).T
    assert np.allclose(np.diff(time), TS) and len(time) == 1200
    assert voltage.min() >= 0.0 and voltage.max() <= 110.0
    assert np.max(np.abs(np.diff(voltage))) <= 30_000 * TS * (1 + 1e-9)
    assert voltage[0] == voltage[-1] == 0.0


def test_design_json_follows_its_schema(folder):
    design = design_of(folder)
    jsonschema.validate(design, SCHEMA)
    assert design["decides"] and design["power"] >= 0.9
    assert set(design["others"]) == {"the paper's signal (22)", "a chirp"}
    assert all(s["told"] == s["draws"] for s in design["simulated"])


def test_the_page_says_first_what_to_play(folder):
    page = (folder / "next" / "design.html").read_text(encoding="utf-8")
    assert_self_contained(Page(page))
    first = page[page.index("<h3>") :]
    assert first.index("What to play") < first.index("Play this record") < first.index("What it tells")
    assert "tells delay from lag with probability" in first
    assert "at other sizes of its effect" in first and "it has to be told at" in page


def test_the_record_measured_has_the_name_that_was_promised(folder, tmp_path, capsys):
    """Played on a stage with a delay, the diagnosis names it, and says so beside the promise."""
    time, voltage = voltage_of(folder).T
    truth = read_ssv(folder / "P.ssv").replace(**{"delay.time": 2.5e-4})
    noise = NOISE * np.random.default_rng(2).standard_normal(len(time))
    y = compiled.chain_free_run(truth, voltage)[1] + noise
    write_record(tmp_path / "new.csv", Record("new", time, voltage, y, TS))
    given = ("--model", folder / "P.ssv", "--design", folder / "next" / "design.json", *OTHERS)
    assert run("diagnose", tmp_path / "new.csv", *given, "-o", tmp_path / "out", "--workers", 0) == 0
    said = capsys.readouterr().out
    assert "Result: delay was named" in said
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["effects"] == ["delay"] and report["promised"]["told"]
    assert report["promised"]["played_off_V"] < 1e-9
    (entry,) = report["promised"]["parameters"]
    assert entry["name"] == "delay.time" and 0.2 < entry["found"] / entry["promised"] < 5.0
    page = html_of(tmp_path / "out")
    assert "What the design promised" in page and "The record was designed for delay, lag" in page
    levels = {e["effect"]: e["level"] for e in report["evidence"] if e["level"]}
    assert levels["lag"] > 10.0 * levels["resonance"]


def test_what_cannot_decide_is_a_finding(tmp_path, capsys):
    write_ssv(table_1(), tmp_path / "P.ssv")
    asked = ("design", tmp_path / "P.ssv", "--between", "delay,lag", "--noise", 3.0, *LIMITS)
    assert run(*asked, "-o", tmp_path / "out") == 1
    said = capsys.readouterr().out
    assert "No record within these limits decides" in said
    assert "times less noise" in said or "No lower noise" in said
    assert not json.loads((tmp_path / "out" / "design.json").read_text())["decides"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--between", "delay,lag", "--slew", 100), "exclude each other"),
        (("--between", "delay,lag", "--voltage", "50,300"), "the model holds for"),
        (("--between", "delay,lag", "--current", 0.1), "--capacitance"),
        (("--between", "delay,lag", "--noise", 0), "--noise"),
        (("--between", "delay,lag", "--sample-time", 0.001), "too coarse for"),
        (("--between", "delay,lag", "--family", "square"), "no family"),
        (("--between", "delay,echo"), "echo"),
        ((), "--between"),
    ],
)
def test_bad_input_is_refused_before_any_work(tmp_path, capsys, options, said):
    write_ssv(table_1(), tmp_path / "P.ssv")
    assert run("design", tmp_path / "P.ssv", *options, "-o", tmp_path / "out") == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_diagnosis_that_cannot_tell_ends_with_the_record_that_does(tmp_path, capsys):
    """On one loop many effects look alike: figure, promise and command of the next record."""
    time = np.arange(1000) * TS
    voltage = 50.0 - 50.0 * np.cos(2 * np.pi * 40 * time)
    stage = stage_with(**{"lag.timeConstant": 6e-4})
    noise = NOISE * np.random.default_rng(2).standard_normal(len(time))
    y = compiled.chain_free_run(stage.replace(initialDisplacement=UM), voltage)[1] + noise
    write_record(tmp_path / "one.csv", Record("one", time, voltage, y, TS))
    out = tmp_path / "out"
    options = ("--rules", 1, "--workers", 0, *OTHERS)
    assert run("diagnose", tmp_path / "one.csv", *options, "-o", out) == 0
    report = json.loads((out / "report.json").read_text(encoding="utf-8"))
    jsonschema.validate(report, json.loads(SCHEMA_OF_REPORT.read_text(encoding="utf-8")))
    assert {"delay", "lag"} <= {*report["indistinguishable"][0]}
    assert report["next"]["promise"][0].startswith(("Play this record", "No record within"))
    page = html_of(out)
    measure = page[page.index("What to measure next") :]
    assert "it2hys design report.json -o DIR" in measure and (out / "next.png").is_file()
    said = capsys.readouterr().out
    assert f"design {out / 'report.json'} -o DIR" in said
    at_hand = voltages_at_hand(out / "report.json", TS)
    kept = report["error"]["after"]["one"]["skipped_samples"]
    assert np.allclose(at_hand["one"], voltage[kept:], rtol=1e-6)  # a course has seven digits
    assert voltages_at_hand(out / "parameters.ssv", TS) == {}
    first = read_ssv(out / "parameters.ssv")
    question = question_of(out / "report.json")
    assert {h.name for h in question.hypotheses} == {*report["indistinguishable"][0]}
    assert question.duration == pytest.approx(0.1)
    assert question.noise == pytest.approx(1e-6 * report["noise_rms_um"])
    assert question.base["rule[1].q1"] == first["rule[1].q1"]


def test_a_design_that_is_none_is_refused(tmp_path, folder, capsys):
    (tmp_path / "design.json").write_text("{}")
    write_record(
        tmp_path / "a.csv",
        Record("a", np.arange(900) * TS, 50 - 50 * np.cos(np.arange(900) / 20), UM * np.ones(900)
               + 1e-7 * np.sin(np.arange(900) / 20), TS),
    )  # fmt: skip
    assert run("diagnose", tmp_path / "a.csv", "--allow-lead", "--design", tmp_path / "design.json",
               "-o", tmp_path / "out") == 2  # fmt: skip
    assert "give a design.json" in capsys.readouterr().err
