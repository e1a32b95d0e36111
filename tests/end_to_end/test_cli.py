"""Whole commands: their output is opened and checked, bad input leaves nothing behind."""

import json
import re
import subprocess
import sys
import zipfile
from datetime import date
from html.parser import HTMLParser

import numpy as np
import pytest
from conftest import YAN9A, needs_measured_records
from fmpy.validation import validate_fmu

from it2hys.cli import main
from it2hys.cosimulation.simulation import simulate
from it2hys.identification import SOLVERS
from it2hys.model import compiled
from it2hys.model.parameters import format_ssv, read_ssv, table_1
from it2hys.records import Record, read_record, write_record
from it2hys.stand import Stand, excitations

UM = 1e-6
FILES = {"parameters.ssv", "IT2Plant.fmu", "IT2Inverse.fmu", "report.html", "report.json"}


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    """Two records of the simulated stand as CSV, and the directory of their identification."""
    folder = tmp_path_factory.mktemp("stage")
    time = excitations.time_grid(0.08, 1e-4)
    for seed, (name, voltage) in enumerate(
        [
            ("train", excitations.identification(time)),
            ("test", excitations.validation_sine(time, 40.0)),
        ]
    ):
        write_record(folder / f"{name}.csv", Stand().record(voltage, name, seed=seed))
    code = run(
        "identify", folder / "train.csv", "--test", folder / "test.csv", "--rules", 2,
        "-o", folder / "out", "--quiet",
    )  # fmt: skip
    assert code == 0
    return folder


def run(*arguments):
    return main([str(a) for a in arguments])


def replay(record, entry, plant):
    """Return the error that a user finds who runs the plant FMU on the record's voltage."""
    start = {"initialDisplacement": entry["initial_displacement_um"] * UM}
    outputs, _ = simulate(plant, {"voltage": record.voltage}, start)
    error = record.displacement - outputs["displacement"] - entry["offset_um"] * UM
    return error[entry["skipped_samples"] :]


def assert_reported_errors_hold(record, entry, plant):
    error = replay(record, entry, plant)
    kept = record.displacement[entry["skipped_samples"] :]
    assert np.sqrt(np.mean(error**2)) / UM == pytest.approx(entry["e_rms_um"], rel=1e-9)
    assert 100 * np.abs(error).max() / np.ptp(kept) == pytest.approx(entry["e_mr_percent"], rel=1e-9)


def html_of(directory):
    """Return a report's page without its scripts, whose words are not its own; all spaces alike."""
    page = (directory / "report.html").read_text(encoding="utf-8")
    return re.sub(r"<(script|style)\b.*?</\1>", "", page, flags=re.DOTALL).replace("\xa0", " ")


class Page(HTMLParser):
    """A page: what it leaves open, its pictures, what it loads."""

    def __init__(self, text):
        super().__init__()
        self.open, self.images, self.loads = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        if tag == "img":
            self.images.append(attrs["src"])
        self.loads += [attrs[name] for name in ("src", "href") if tag != "img" and name in attrs]
        if tag not in ("img", "meta", "br", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def assert_self_contained(page):
    assert page.open == []
    assert [source for source in page.loads if not source.startswith("data:")] == []
    assert all(source.startswith("data:image/png;base64,") for source in page.images)


def test_identify_writes_what_design_promises(stage):
    written = {path.name for path in (stage / "out").iterdir()}
    assert written >= FILES
    assert {p for p in written if p.endswith(".png")} >= {"train_time.png", "test_loop.png"}
    assert not [name for name in written if name.startswith(".")]


def test_report_json_has_the_settled_keys(stage):
    report = json.loads((stage / "out" / "report.json").read_text())
    assert report["effects"] == [] and report["evidence"] == []
    assert report["unexplained"] is True
    assert report["noise_rms_um"] == pytest.approx(0.006, rel=0.3)
    for when in ("before", "after"):
        assert {k: v["role"] for k, v in report["error"][when].items()} == {
            "train": "train",
            "test": "test",
        }
    parameters = read_ssv(stage / "out" / "parameters.ssv")
    for name, entry in report["parameters"].items():
        assert entry["value"] == parameters[name]
        assert set(entry) >= {"value", "ci95", "unit"}


@pytest.mark.parametrize("name", ["train", "test"])
def test_the_plant_fmu_gives_the_reported_errors(stage, name):
    report = json.loads((stage / "out" / "report.json").read_text())
    entry = report["error"]["after"][name]
    assert_reported_errors_hold(
        read_record(stage / f"{name}.csv"), entry, stage / "out" / "IT2Plant.fmu"
    )


def test_the_report_is_one_self_contained_page(stage):
    page = Page((stage / "out" / "report.html").read_text())
    assert_self_contained(page)
    assert len(page.images) >= 3


def test_the_report_says_that_the_model_lacks_something(stage):
    assert "far above" in html_of(stage / "out")


def contents(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_without_terminals_the_fmus_are_the_same_but_for_them(tmp_path):
    """What FMILibrary 3.0.5 refuses is gone: the folder with its fmiVersion of 3.0."""
    assert run("build", "-o", tmp_path / "a", "--quiet") == 0
    assert run("build", "-o", tmp_path / "b", "--quiet", "--no-terminals") == 0
    path = tmp_path / "b" / "parameters.ssv"
    assert run("package", path, "-o", tmp_path / "c", "--quiet", "--no-terminals") == 0
    for name in ("IT2Plant.fmu", "IT2Inverse.fmu"):
        full, without = contents(tmp_path / "a" / name), contents(tmp_path / "b" / name)
        left_out = set(full) - set(without)
        assert left_out == {"terminalsAndIcons/icon.png", "terminalsAndIcons/terminalsAndIcons.xml"}
        assert without == {n: content for n, content in full.items() if n in without}
        assert (tmp_path / "b" / name).read_bytes() == (tmp_path / "c" / name).read_bytes()
        assert validate_fmu(str(tmp_path / "b" / name)) == []


def test_build_then_package_gives_the_same_fmus(tmp_path):
    assert run("build", "-o", tmp_path / "a", "--quiet") == 0
    assert run("package", tmp_path / "a" / "parameters.ssv", "-o", tmp_path / "b", "--quiet") == 0
    for name in ("IT2Plant.fmu", "IT2Inverse.fmu", "parameters.ssv"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_simulate_inverse_then_plant_returns_the_reference(tmp_path):
    run("build", "-o", tmp_path, "--quiet")
    time = excitations.time_grid(0.1, 1e-4)
    reference = excitations.tracking_reference(time) / UM
    rows = "\n".join(f"{t!r},{y!r}" for t, y in zip(time.tolist(), reference.tolist(), strict=True))
    (tmp_path / "r.csv").write_text(f"time_s,reference_um\n{rows}\n")
    for fmu, source, target in (("IT2Inverse", "r", "u"), ("IT2Plant", "u", "y")):
        code = run(
            "simulate", tmp_path / f"{fmu}.fmu", "--input", tmp_path / f"{source}.csv",
            "-o", tmp_path / f"{target}.csv", "--quiet",
        )  # fmt: skip
        assert code == 0
    result = np.genfromtxt(tmp_path / "y.csv", delimiter=",", names=True)
    np.testing.assert_allclose(result["displacement_um"], reference, rtol=1e-9)


def test_simulate_says_how_much_of_a_run_is_beyond_the_model(tmp_path, capsys):
    """A sine of 10 Hz, 0..130 V, with which Table 1 was at 3e114 um once, and no word of it."""
    run("build", "-o", tmp_path, "--quiet")
    time = excitations.time_grid(0.5, 1e-4)
    voltage = 65.0 - 65.0 * np.cos(2 * np.pi * 10 * time)
    rows = "\n".join(f"{t!r},{v!r}" for t, v in zip(time.tolist(), voltage.tolist(), strict=True))
    (tmp_path / "u.csv").write_text(f"time_s,voltage_V\n{rows}\n")
    arguments = [
        "simulate", tmp_path / "IT2Plant.fmu", "--input", tmp_path / "u.csv", "-o", tmp_path / "y.csv",
    ]  # fmt: skip
    capsys.readouterr()
    assert run(*arguments, "--quiet") == 0
    said = capsys.readouterr()
    result = np.genfromtxt(tmp_path / "y.csv", delimiter=",", names=True)
    outside = int(np.count_nonzero(result["outOfRange"]))
    assert 0 < outside < len(time)
    assert result["displacement_um"].max() < 20.0
    assert said.out == ""
    assert f"{outside} of {len(time)} samples are outside the range of the model" in said.err
    assert "0 to 110 V and 0 to 16 µm" in said.err
    assert "to 130 V" in said.err
    assert len(said.err.splitlines()) == 3  # each range left, once, and how often
    assert run(*arguments, "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["samples"], said["samples_out_of_range"]) == (len(time), outside)
    assert len(said["messages"]) == 3
    (tmp_path / "u.csv").write_text("time_s,voltage_V\n0,50\n1e-4,50\n2e-4,50\n")
    assert run(*arguments, "--quiet") == 0
    assert capsys.readouterr().err == ""


def assert_refused(capsys, arguments, *words):
    assert run(*arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    message = captured.err.strip().splitlines()
    assert len(message) == 1, captured.err
    for word in words:
        assert word in message[0]


TIME = "time_s,voltage_V,displacement_um\n"


def test_a_bad_record_is_refused_and_nothing_is_written(tmp_path, capsys):
    """What makes one bad is tried in tests/unit/test_records.py."""
    (tmp_path / "bad.csv").write_text(TIME + "0,1,1\n1e-4,NaN,3\n")
    arguments = ["identify", tmp_path / "bad.csv", "-o", tmp_path / "out"]
    assert_refused(capsys, arguments, "bad.csv", "line 3", "voltage_V")
    assert not (tmp_path / "out").exists()


def test_a_bad_parameter_set_is_refused_and_nothing_is_written(tmp_path, capsys):
    """What makes one bad is tried in tests/unit/test_parameters.py."""
    (tmp_path / "p.ssv").write_text(format_ssv(table_1()).replace('"4.3427e-06"', '"1e-4"'))
    arguments = ["package", tmp_path / "p.ssv", "-o", tmp_path / "out"]
    assert_refused(capsys, arguments, "p.ssv", "rule[1].sigmaUpper")
    assert not (tmp_path / "out").exists()


def test_a_record_in_two_roles_is_refused(stage, tmp_path, capsys):
    train = stage / "train.csv"
    assert_refused(capsys, ["identify", train, "--test", train, "-o", tmp_path / "o"], "twice")


def test_an_output_directory_that_is_a_file_is_refused(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert_refused(capsys, ["build", "-o", tmp_path / "file"], "file")


@pytest.mark.parametrize(
    ("toml", "words"),
    [
        ("titel = 'x'", ["record", "titel"]),
        (
            "titel='x'\n[[record]]\nname='a'\nrole='train'\nduration=0.1\nsignal='triangle'",
            ["titel", "title"],
        ),
        ("title = 'x'", ["record"]),
        ("[[record]]\nname = 'a'\nrole = 'train'\nduration = 0.1", ["signal"]),
        ("[[record]]\nname='a'\nrole='no'\nduration=0.1\nsignal='triangle'", ["role"]),
        ("[[record]]\nname='a'\nrole='train'\nduration=0.1\nsignal='noise'", ["noise"]),
        ("[[record]]\nname='a'\nrole='train'\nduration=0.1\nsignal='triangle'\nhz=3", ["hz"]),
        ("[[record]]\nname='a'\nrole='train'\nduration=0.1\nsignal='triangle'\npaper={figur=3}",
         ["record 1: paper: unknown key 'figur'; did you mean 'figure'?"]),
        ("record=[]\nstand={without=['creep', 'gravity']}",
         ["stand.without has 'gravity'; each must be one of dac, amplifier"]),
        ("record=[]\ntracking=3", ["tracking is 3; it must be a table"]),
        ("record=[]\nrules=3.0", ["rules is 3.0; it must be a whole number"]),
        ("record=[]", ["record: a model can only be identified with a record of role 'train'"]),
        ("= 3", ["TOML"]),
    ],
)  # fmt: skip
def test_a_bad_scenario_is_refused_before_anything_runs(toml, words, tmp_path, capsys):
    (tmp_path / "s.toml").write_text(toml)
    assert_refused(capsys, ["run", tmp_path / "s.toml", "-o", tmp_path / "o"], "s.toml", *words)
    assert not (tmp_path / "o").exists()


def test_an_unknown_scenario_lists_the_known_ones(capsys):
    assert_refused(capsys, ["run", "dmeo"], "dmeo", "demo")


@pytest.mark.parametrize(
    "arguments", [[], ["identify"], ["frobnicate"], ["identify", "none.csv", "-o", "x"]]
)
def test_bad_usage_exits_with_2(arguments, tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "it2hys", *arguments],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


@needs_measured_records
def test_measured_records_give_two_fmus_and_honest_errors(tmp_path):
    code = run(
        "identify", YAN9A / "train.csv", YAN9A / "minor_loops.csv",
        "--test", YAN9A / "test.csv", "--rules", 2, "-o", tmp_path, "--quiet",
    )  # fmt: skip
    assert code == 0
    report = json.loads((tmp_path / "report.json").read_text())
    entry = report["error"]["after"]["test"]
    assert entry["e_rms_um"] < 0.56  # the paper's model reaches 0.55
    assert entry["noise_rms_um"] == pytest.approx(0.07, abs=0.02)
    assert report["unexplained"] is True
    assert_reported_errors_hold(read_record(YAN9A / "test.csv"), entry, tmp_path / "IT2Plant.fmu")


@pytest.fixture(scope="module")
def clean():
    """Record the identification signal on the simulated stand."""
    time = excitations.time_grid(0.06, 1e-4)
    return Stand().record(excitations.identification(time), "clean", seed=3)


def write_rows(path, time, record, displacement=None):
    displacement = record.displacement if displacement is None else displacement
    table = np.column_stack([time, record.voltage, displacement / UM])
    body = "\n".join(f"{t:.7f},{x!r},{y!r}" for t, x, y in table.tolist())
    path.write_text(TIME + body + "\n")
    return path


def identify_quickly(path, out, *options):
    return run("identify", path, "--rules", 1, "-o", out, "--quiet", *options)


def test_one_per_cent_of_missing_samples_is_refused_or_mended(clean, tmp_path, capsys):
    path = write_rows(tmp_path / "r.csv", clean.time, clean)
    lines = path.read_text().splitlines(keepends=True)
    missing = set(range(100, 600, 100))
    path.write_text("".join(line for i, line in enumerate(lines) if i not in missing))
    assert_refused(capsys, ["identify", path, "-o", tmp_path / "a"], "line 101", "--resample")
    assert identify_quickly(path, tmp_path / "b", "--resample") == 0
    assert "resampl" in html_of(tmp_path / "b").lower()


def test_an_outlier_is_named_and_does_not_move_the_model(clean, tmp_path):
    spiked = clean.displacement.copy()
    spiked[300] += 5e-6
    errors = []
    for name, displacement in (("clean", clean.displacement), ("spiked", spiked)):
        path = write_rows(tmp_path / f"{name}.csv", clean.time, clean, displacement)
        assert identify_quickly(path, tmp_path / name) == 0
        report = json.loads((tmp_path / name / "report.json").read_text())
        errors.append(report["error"]["after"][name]["e_rms_um"])
    assert errors[1] == pytest.approx(errors[0], rel=0.05)
    assert "302" in html_of(tmp_path / "spiked")  # the spike's line


def test_simulating_at_another_rate_is_refused(tmp_path, capsys):
    run("build", "-o", tmp_path, "--quiet")
    (tmp_path / "u.csv").write_text("time_s,voltage_V\n0,1\n0.001,2\n0.002,3\n")
    fmu, source, target = (tmp_path / name for name in ("IT2Plant.fmu", "u.csv", "y.csv"))
    assert_refused(capsys, ["simulate", fmu, "--input", source, "-o", target], "u.csv", "sampleTime")
    assert not (tmp_path / "y.csv").exists()


def test_table_1_as_published_is_a_scenario_that_calls_it_of_no_use_here(tmp_path, capsys):
    assert run("run", "table_1", "-o", tmp_path / "t") == 0
    assert_self_contained(Page((tmp_path / "t" / "report.html").read_text(encoding="utf-8")))
    text = html_of(tmp_path / "t")
    assert len(list((tmp_path / "t").glob("*.png"))) >= 11
    assert {p.name for p in (tmp_path / "t").glob("*.fmu")} == {"IT2Plant.fmu", "IT2Inverse.fmu"}
    for said in (text[text.index("<p>") : text.index("</p>")], capsys.readouterr().out):
        assert "no better than a straight line" in said and "another specimen" in said


# --- solvers -------------------------------------------------------------------------------------

#: What `diagnose` says of a record, `identify` does too.
SAID_OF_A_RECORD = {
    "role", "e_mr_percent", "e_rms_um", "noise_rms_um", "lead_in_s", "start", "offset_um",
    "cold_start_e_rms_um", "inverse_e_rms_V", "inverse_e_rms_um", "inverse_delay_s",
}  # fmt: skip


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Return the path of a short record of a model with one rule, at a strain gauge's noise."""
    time = excitations.time_grid(0.05, 1e-4)
    voltage = 50.0 - 50.0 * np.cos(2 * np.pi * 50 * time)
    rules = np.array([[5e-6, 15e-6, 8e-6, 0.9, 1.5e-8, 1e-7]])
    noise = 6e-9 * np.random.default_rng(0).standard_normal(len(time))
    y = compiled.free_run(rules, voltage, 1e-6) + noise
    path = tmp_path_factory.mktemp("short") / "short.csv"
    write_record(path, Record("short", time, voltage, y, 1e-4))
    return path


@pytest.mark.parametrize("solver", SOLVERS)
def test_every_solver_is_reached_and_finds_the_model(short, tmp_path, solver):
    assert identify_quickly(short, tmp_path, "--solver", solver, "--starts", 3) == 0
    report = json.loads((tmp_path / "report.json").read_text())
    entry = report["error"]["after"]["short"]
    assert entry["e_rms_um"] == pytest.approx(0.006, rel=0.1)
    assert report["parameters"]["rule[1].q1"]["value"] == pytest.approx(0.9, abs=2e-3)


def test_an_unknown_solver_is_refused_with_the_names_before_the_work(short, tmp_path, capsys):
    arguments = ["identify", short, "--solver", "magic", "-o", tmp_path / "out"]
    assert_refused(capsys, arguments, "unknown solver 'magic'", *SOLVERS)
    assert not (tmp_path / "out").exists()


def test_a_limit_that_stops_the_fit_is_told_and_nothing_is_written(short, tmp_path, capsys):
    arguments = ["identify", short, "--rules", 3, "--starts", 3, "--max-iterations", 1, "--quiet"]
    arguments += ["-o", tmp_path / "out"]
    assert_refused(capsys, arguments, "did not converge", "limit of iterations")
    assert not (tmp_path / "out").exists()


def test_identify_says_of_a_record_what_diagnose_does(stage):
    report = json.loads((stage / "out" / "report.json").read_text())
    for name in ("train", "test"):
        entry = report["error"]["after"][name]
        assert set(entry) >= SAID_OF_A_RECORD
        assert entry["lead_in_s"] == pytest.approx(entry["skipped_samples"] * 1e-4)
        begin = pytest.approx(entry["initial_displacement_um"] * UM, rel=1e-12)
        assert entry["start"] == {"initialDisplacement": begin}
        assert entry["e_rms_um"] <= 1.02 * entry["cold_start_e_rms_um"]
        record = read_record(stage / f"{name}.csv")
        gain = np.ptp(record.displacement) / np.ptp(record.voltage)
        # the error by the plant's gain, whichever side it is read on
        assert entry["inverse_e_rms_um"] == pytest.approx(
            entry["inverse_e_rms_V"] * gain / UM, rel=0.35
        )
    assert (stage / "out" / "test_inverse.png").exists()


def test_the_command_line_begins_without_numpy():
    """It sets the number of threads of linear algebra first, and answers `--help` at once."""
    late = {"numpy", "scipy", "casadi", "pydantic"}
    code = f"import sys, it2hys.cli; print(sorted({late} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_fmus_say_what_they_were_identified_from(stage):
    report = json.loads((stage / "out" / "report.json").read_text())
    for name in ("IT2Plant", "IT2Inverse"):
        with zipfile.ZipFile(stage / "out" / f"{name}.fmu") as fmu:
            page = fmu.read("documentation/index.html").decode()
        begin = page.index("What it was identified from")
        said = page[begin : page.index("<h2>", begin)]
        assert f"it2hys identify</code> on {date.today().isoformat()[:4]}" in said
        for record, entry in report["error"]["after"].items():
            row = re.search(rf"<tr><td>{record}</td>.*</tr>", said)[0]
            for number in (entry["e_rms_um"], entry["e_mr_percent"], entry["offset_um"]):
                assert f">{number:.3g}</td>" in row
