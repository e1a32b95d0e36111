"""`it2hys run`: what the demo shows, and what a model or an inverse that is of no use is called."""

import base64
import hashlib
import json
import re
from contextlib import redirect_stderr, redirect_stdout
from html import unescape
from io import StringIO
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from test_cli import FILES, Page, assert_self_contained, html_of, run

from it2hys.cosimulation.simulation import track
from it2hys.records import read_record, write_record
from it2hys.reports.answers import next_measurements
from it2hys.stand import Stand, excitations

SCENARIOS = Path(__file__).parents[2] / "scenarios"
SCHEMA = json.loads((SCENARIOS.parent / "docs" / "report.schema.json").read_text())
UM = 1e-6
# of the table that the demo ends with
TRACKING = ("tracking on the stand, e_mr %", "tracking on the stand, e_rms µm")
FREE_RUNS = ("free run of sine_20Hz, e_mr %", "free run of sum_100_50Hz, e_mr %")
COLUMNS = ("before", "after", "published", "line", "none")


def shortened(text: str) -> str:
    """Return the demo's scenario with a shorter record, two rules and two of its test records."""
    short = text.replace("rules = 3", "rules = 2").replace("duration = 0.4", "duration = 0.12")
    blocks = [b for b in short.split("\n\n") if "sine_40Hz" not in b and "triangle" not in b]
    assert short != text and len(blocks) == len(text.split("\n\n")) - 2
    return "\n\n".join(blocks)


class Outcome:
    """What a command printed, and the directory that it left."""

    def __init__(self, directory: Path, *arguments: object) -> None:
        printed, progress = StringIO(), StringIO()
        with redirect_stdout(printed), redirect_stderr(progress):
            assert run(*arguments, "-v", "-o", directory) == 0
        self.printed, self.progress = printed.getvalue(), progress.getvalue()
        self.directory = directory
        self.page = html_of(directory)
        self.report = json.loads((directory / "report.json").read_text(encoding="utf-8"))

    @property
    def first_words(self) -> str:
        """The first paragraph of the page."""
        return unescape(re.search(r"<p>(.*?)</p>", self.page, re.DOTALL)[1])

    def row(self, name: str) -> dict[str, float]:
        """Return a row of the demo's table, by column; NaN where it has no figure."""
        (line,) = [line for line in self.printed.splitlines() if line.startswith(name)]
        cells = [float("nan") if c == "–" else float(c) for c in line.removeprefix(name).split()]
        return dict(zip(COLUMNS, cells, strict=True))


# --- the demo ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    text = (SCENARIOS / "demo.toml").read_text(encoding="utf-8")
    (folder / "demo.toml").write_text(shortened(text), encoding="utf-8")
    # one worker: tests run beside each other already
    return Outcome(folder / "out", "run", folder / "demo.toml", "--workers", 1)


def test_the_demo_ends_with_table_conclusion_report_and_what_to_do_next(demo):
    places = [
        demo.printed.index(text)
        for text in (
            TRACKING[0],
            "\nDriven by the inverse FMU, the stage follows its reference to within ",
            f"\nreport: {demo.directory / 'report.html'}\n",
            f"do the same with your own records, CSVs like those in {demo.directory / 'records'}:\n"
            "  it2hys diagnose TRAIN.csv --test TEST.csv -o out/mystage\n",
        )
    ]
    assert places == sorted(places)
    assert demo.printed.endswith("-o out/mystage\n")


def test_what_the_model_lacks_is_found_and_lowers_every_error(demo):
    assert "play" in demo.report["effects"]
    assert "Found and added to the paper's model: play (" in demo.printed
    for name in (*TRACKING, *FREE_RUNS):
        row = demo.row(name)
        assert row["after"] < 0.5 * row["before"]
        assert row["after"] < min(row["published"], row["line"])
    for name in TRACKING:
        row = demo.row(name)
        assert row["after"] < 0.5 * row["none"]


def test_published_figures_stand_beside_ours(demo):
    figures = [demo.row(name)["published"] for name in (*TRACKING, *FREE_RUNS)]
    assert figures == [4.6, 0.32, 0.81, 1.23]


def test_the_tracking_is_that_of_the_fmu_on_the_stand(demo):
    time = excitations.time_grid(0.2, 1e-4)
    reference = excitations.tracking_reference(time)
    driven = track(demo.directory / "IT2Inverse.fmu", Stand().start(1).step, reference)
    kept = time >= 0.05 - 1e-9
    error = (reference - driven["displacement"])[kept]
    share = 100 * np.abs(error).max() / np.ptp(reference[kept])
    assert demo.row(TRACKING[0])["after"] == pytest.approx(share, abs=0.005)
    assert demo.report["tracking"]["after"]["e_mr_percent"] == pytest.approx(share, rel=1e-9)
    rms = np.sqrt(np.mean(error**2)) / UM
    assert demo.row(TRACKING[1])["after"] == pytest.approx(rms, abs=0.0005)


def test_the_line_is_the_training_records_and_drives_the_stand(demo):
    """Slope and offset of a line through the CSV give the table's column: model and feedforward."""
    skipped = {name: e["skipped_samples"] for name, e in demo.report["error"]["after"].items()}
    records = {name: read_record(demo.directory / "records" / f"{name}.csv") for name in skipped}
    train, sine = records["identification"], records["sine_20Hz"]
    kept = slice(skipped["identification"], None)
    line = np.polyfit(train.voltage[kept], train.displacement[kept], 1)
    measured = sine.displacement[skipped["sine_20Hz"] :]
    error = measured - np.polyval(line, sine.voltage[skipped["sine_20Hz"] :])
    share = 100 * np.abs(error).max() / np.ptp(measured)
    assert demo.row(FREE_RUNS[0])["line"] == pytest.approx(share, abs=0.005)
    time = excitations.time_grid(0.2, 1e-4)
    reference = excitations.tracking_reference(time)
    driven = Stand().run((reference - line[1]) / line[0], seed=1).measured
    error = (reference - driven)[time >= 0.05 - 1e-9]
    assert demo.row(TRACKING[1])["line"] == pytest.approx(np.sqrt(np.mean(error**2)) / UM, abs=0.0005)


def test_the_page_begins_with_the_conclusion_the_overview_and_the_table(demo):
    assert demo.first_words.startswith("Driven by the inverse FMU, the stage follows its reference")
    page = Page((demo.directory / "report.html").read_text(encoding="utf-8"))
    assert_self_contained(page)
    overview = (demo.directory / "overview.png").read_bytes()
    assert page.images[0].endswith(base64.b64encode(overview).decode())
    first_table = demo.page[demo.page.index("<table>") : demo.page.index("</table>")]
    cells = re.findall(r"<td[^>]*>(.*?)</td>", first_table)
    columns = len(COLUMNS) + 1
    rows = {cells[i]: cells[i + 1 : i + columns] for i in range(0, len(cells), columns)}
    assert list(rows) == [*TRACKING, *FREE_RUNS]
    for name, values in rows.items():
        (line,) = [line for line in demo.printed.splitlines() if line.startswith(name)]
        assert line.removeprefix(name).split() == values
    # the pictures stand beside the answers, on the first screen
    assert max(demo.page.index("<img"), demo.page.index("<table>")) < demo.page.index("<h2>")


def test_the_demo_leaves_fmus_report_and_its_records(demo):
    assert {path.name for path in demo.directory.iterdir()} >= {*FILES, "records", "overview.png"}
    names = {"identification", "sine_20Hz", "sum_100_50Hz"}
    assert {path.stem for path in (demo.directory / "records").iterdir()} == names
    time = excitations.time_grid(0.12, 1e-4)
    stand = Stand().record(excitations.identification(time), "identification", seed=1)
    record = read_record(demo.directory / "records" / "identification.csv")
    np.testing.assert_allclose(record.displacement, stand.displacement, rtol=1e-12)


def test_the_report_names_the_records_beside_it_and_their_hashes(demo):
    jsonschema.validate(demo.report, SCHEMA)
    inputs = {entry["name"]: entry for entry in demo.report["inputs"]}
    assert set(inputs) == {"identification", "sine_20Hz", "sum_100_50Hz", "demo.toml"}
    for name, entry in inputs.items():
        if name != "demo.toml":
            assert entry["file"] == f"records/{name}.csv"
            content = (demo.directory / entry["file"]).read_bytes()
            assert entry["sha256"] == hashlib.sha256(content).hexdigest()


def test_what_to_measure_next_does_not_deny_what_is_left_of_the_test_records(demo):
    left = [text for text in demo.report["left_over"] if text.startswith("On the test records")]
    assert left
    said = next_measurements({**demo.report, "unexplained": False})
    assert any("More records like the test records" in text for text in said)
    assert not any("Nothing is needed" in text for text in said)
    explained = next_measurements({**demo.report, "left_over": []})
    assert not any("More records like" in text for text in explained)


def test_the_page_of_a_run_is_drawn_again(demo):
    (demo.directory / "report.html").unlink()
    assert run("report", demo.directory, "--quiet") == 0
    assert html_of(demo.directory) == demo.page


def test_a_line_of_progress_says_what_is_being_done(demo):
    parts = (
        "measuring",
        "the paper's model",
        "searching effects: model + play",
        "feedforward",
        "report",
    )
    places = [demo.progress.index(text) for text in parts]
    assert places == sorted(places)


# --- models and inverses that are of no use ------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Make records: of the stand, to be fitted and to be judged on, and of a stage without a loop."""
    folder = tmp_path_factory.mktemp("records")
    time = excitations.time_grid(0.06, 1e-4)
    for seed, (name, stand, voltage) in enumerate(
        [
            ("train", Stand(), excitations.identification(time)),
            ("test", Stand(), excitations.validation_sine(time, 50.0)),
            ("straight", Stand(hysteresis=None), excitations.validation_sine(time, 50.0)),
        ]
    ):
        write_record(folder / f"{name}.csv", stand.record(voltage, name, seed=seed))
    return folder


def identify(folder: Path, *tests: str) -> Outcome:
    paths = [folder / f"{name}.csv" for name in tests]
    out = folder / "_".join(tests)
    return Outcome(out, "identify", folder / "train.csv", "--test", *paths, "--rules", 1)


@pytest.fixture(scope="module")
def identified(folder):
    """Identify the stand's model, judged on a record of the stand."""
    return identify(folder, "test")


def test_identify_says_first_that_its_model_is_no_better_than_a_line(folder):
    """A line describes a stage without a loop, and a model of a stage with one does not."""
    outcome = identify(folder, "test", "straight")
    errors = {when: outcome.report["error"][when]["straight"] for when in ("before", "after")}
    assert errors["after"]["e_rms_um"] > errors["before"]["e_rms_um"]
    for text in (outcome.first_words, outcome.printed):
        assert "his model does no better than a straight line on straight (e_mr " in text
        assert "it2hys diagnose" in text
    assert outcome.printed.index("no better") < outcome.printed.index("was identified on")


def test_identify_says_nothing_of_a_line_where_its_model_is_better(identified):
    errors = {when: identified.report["error"][when]["test"] for when in ("before", "after")}
    assert errors["after"]["e_mr_percent"] < errors["before"]["e_mr_percent"]
    assert errors["after"]["e_rms_um"] < errors["before"]["e_rms_um"]
    assert "no better than" not in identified.page + identified.printed
    first = "The interval type-2 fuzzy model with 1 rule was identified on 1 training record."
    assert identified.first_words.startswith(first)


def test_the_text_of_a_report_is_whole_sentences(identified):
    paragraphs = [unescape(p) for p in re.findall(r"<p>(.*?)</p>", identified.page, re.DOTALL)]
    assert any("The fit ended: " in p for p in paragraphs)
    for text in paragraphs:
        assert text.endswith((".", ":")), text
        assert "(s)" not in text and " um" not in text
        assert not re.search(r"[a-z] The ", text), text


def test_a_run_says_first_that_its_feedforward_is_worse_than_none(tmp_path):
    text = (SCENARIOS / "tracking.toml").read_text(encoding="utf-8")
    (tmp_path / "t.toml").write_text(text.replace("duration = 0.12", "duration = 0.06"))
    outcome = Outcome(tmp_path / "out", "run", tmp_path / "t.toml")
    rows = re.findall(r"^(inverse FMU|none).*?(\S+) +(\S+)$", outcome.printed, re.MULTILINE)
    (_, ours, _), (_, none, _) = rows
    assert float(ours) > float(none)  # else this shows nothing
    for text in (outcome.first_words, outcome.printed):
        assert "the inverse as feedforward is worse than none: e_mr " in text
        assert "it2hys diagnose" in text


def test_a_run_of_a_good_model_says_nothing_of_the_kind(demo):
    assert "worse than none" not in demo.page + demo.printed
    assert "no better than" not in demo.page + demo.printed
