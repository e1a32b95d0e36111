"""`it2hys run next_experiment`: a record that cannot tell, the one designed from it, the right name."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from test_cli import html_of, run

DOCS = Path(__file__).parents[2] / "docs"
SCENARIO = Path(__file__).parents[2] / "scenarios" / "next_experiment.toml"


def shortened(text: str) -> str:
    """Return the scenario with shorter records, and one rule, which is quickly fitted."""
    short = text.replace("rules = 3", "rules = 1").replace("duration = 0.4", "duration = 0.15")
    short = short.replace("duration = 0.2\n\n", "duration = 0.12\n\n", 1)
    assert short.count("\n") == text.count("\n") and short != text
    return short


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    folder = tmp_path_factory.mktemp("next")
    (folder / "short.toml").write_text(shortened(SCENARIO.read_text(encoding="utf-8")))
    assert run("run", folder / "short.toml", "-o", folder / "out", "--workers", 1, "--quiet") == 0
    return folder / "out"


def report_of(out):
    return json.loads((out / "report.json").read_text(encoding="utf-8"))


def test_the_effect_that_the_first_record_left_open_is_named_and_no_rival_of_it(out):
    """The stand has hysteresis, which is play, and bends (`saturation`), for which the core may do."""
    report = report_of(out)
    assert {"play"} <= {*report["effects"]} <= {"play", "nonlinearity"}
    assert report["promised"]["told"] and report["promised"]["power"] >= 0.9
    assert set(report["promised"]["names"]) > {"play"}
    assert "could not decide between " in report["lead"]["texts"][0]


def test_what_was_promised_stands_beside_what_came_out(out):
    page = html_of(out)
    assert "Result: play was named" in page
    jsonschema.validate(report_of(out), json.loads((DOCS / "report.schema.json").read_text()))
    design = json.loads((out / "next" / "design.json").read_text(encoding="utf-8"))
    jsonschema.validate(design, json.loads((DOCS / "design.schema.json").read_text()))


def test_error_and_tracking_are_better_than_with_what_the_first_record_gave(out):
    report = report_of(out)
    before, after = (report["error"][when]["sum_100_50Hz"] for when in ("before", "after"))
    assert after["e_rms_um"] < 0.5 * before["e_rms_um"]
    assert report["tracking"]["after"]["e_mr_percent"] < report["tracking"]["before"]["e_mr_percent"]


def test_both_records_are_left_as_csv_and_the_second_is_the_designed_one(out):
    assert {p.name for p in (out / "records").iterdir()} >= {"first.csv", "designed.csv"}
    measured = np.loadtxt(out / "records" / "designed.csv", delimiter=",", skiprows=1)[:, 1]
    designed = np.loadtxt(out / "next" / "voltage.csv", delimiter=",", skiprows=1)[:, 1]
    assert np.array_equal(measured, designed)
