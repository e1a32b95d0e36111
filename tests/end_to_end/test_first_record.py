"""One record and no options, as most people begin: a result or one message, never a traceback."""

import json
import re

import numpy as np
import pytest
from diagnosis import simulator as sim
from test_cli import TIME, UM, assert_refused, html_of, run

from it2hys.cosimulation.simulation import simulate
from it2hys.diagnosis import windows
from it2hys.identification import excerpts
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import table_1
from it2hys.records import read_record

TS, TOP = 1e-4, 105.0


def stairs(count):
    levels = TOP * np.concatenate([np.arange(0, 13), np.arange(11, -1, -1)]) / 12
    return levels[np.arange(count) * len(levels) // count]


def random_steps(count):
    rng = np.random.default_rng(count)
    ends = np.cumsum(rng.integers(20, 80, count // 20 + 2))
    levels = np.concatenate([[0.0], rng.uniform(0.0, TOP, len(ends))])
    return levels[np.searchsorted(ends, np.arange(count), side="right")]


def triangle_with_holds(count):
    return TOP * np.interp(
        np.arange(count) / 500 % 1, [0, 0.2, 0.4, 0.7, 0.85, 1], [0, 1, 1, 0.3, 0.3, 0]
    )


def wave(*frequencies):
    def draw(count):
        phases = [2 * np.pi * f * np.arange(count) * TS for f in frequencies]
        return 0.5 * TOP * (1.0 - np.mean(np.cos(phases), axis=0))

    return draw


def chirp(count):
    time = np.arange(count) * TS
    return 0.5 * TOP * (1.0 - np.cos(2 * np.pi * (5.0 * time + 75.0 * time**2 / time[-1])))


DRIVES = {
    "sine": wave(50.0),
    "sum": wave(50.0, 25.0),
    "triangle with holds": triangle_with_holds,
    "chirp": chirp,
    "stairs": stairs,
    "random steps": random_steps,
}


def displacement_of(voltage, noise=0.006):
    """Return what a stage with memory and creep reads, um, by the independent simulator."""
    effects = {
        "play": sim.Play("exponential", 15.0, 0.5, TOP, 12),
        "creep": sim.Creep.logarithmic(0.08, 0.02, 1.0),
    }
    around = sim.Surroundings(sim.Grid(TS, 2), np.arange(len(voltage))[None] * TS)
    clean = sim.Plant(sim.TABLE_1, effects).run(voltage[None], around)[0]
    return clean + noise * np.random.default_rng(0).standard_normal(len(voltage))


def simple_displacement_of(voltage):
    """Return what a stage without any effect reads, um: of one rule, which is quickly fitted."""
    rules = np.array([[5e-6, 15e-6, 8e-6, 0.9, 1.5e-8, 1e-7]])
    noise = np.random.default_rng(0).standard_normal(len(voltage))
    return compiled.free_run(rules, voltage, 1e-6) / UM + 0.006 * noise


def write(path, voltage, displacement, pattern="{:.5f},{:.5f},{:.5f}\n"):
    columns = zip((np.arange(len(voltage)) * TS).tolist(), voltage, displacement, strict=True)
    path.write_text(TIME + "".join(pattern.format(*map(float, row)) for row in columns))
    return path


def report_of(out):
    return json.loads((out / "report.json").read_text()), html_of(out)


# --- records of every length ---------------------------------------------------------------------


@pytest.mark.parametrize("name", DRIVES)
def test_any_drive_is_identified(name, tmp_path):
    voltage = DRIVES[name](1000)
    path = write(tmp_path / "one.csv", voltage, displacement_of(voltage))
    assert run("identify", path, "--rules", 1, "-o", tmp_path / "out", "--quiet") == 0
    report, _ = report_of(tmp_path / "out")
    assert (
        report["error"]["after"]["one"]["e_rms_um"] < 0.2 * np.ptp(read_record(path).displacement) / UM
    )


def test_no_window_of_a_search_falls_into_what_is_set_aside(tmp_path, monkeypatch):
    """In small what records of 15,000 samples and more are in full: they ended in a ValueError."""
    monkeypatch.setattr(excerpts, "_WINDOW", 60)
    voltage = DRIVES["sine"](900)
    path = write(tmp_path / "one.csv", voltage, simple_displacement_of(voltage))
    arguments = ("--rules", 1, "--workers", 1, "-o", tmp_path / "out", "--quiet")
    assert run("diagnose", path, *arguments) == 0
    before, after = (report_of(tmp_path / "out")[0]["error"][k]["one"] for k in ("before", "after"))
    assert after["e_rms_um"] <= 1.01 * before["e_rms_um"]


@pytest.mark.parametrize(
    ("enough", "said", "least"),
    [
        pytest.param(2700, r"\d windows", 450, id="windows"),
        pytest.param(800, "one sample in 3", 900, id="every third", marks=pytest.mark.gate),
    ],
)
def test_a_long_record_is_searched_in_part_and_judged_as_a_whole(
    tmp_path, monkeypatch, enough, said, least
):
    for name, value in dict(_WHOLE=900, _FEWEST=900, _MOST=900, _SHORTEST=100, _ENOUGH=enough).items():
        monkeypatch.setattr(windows, name, value)
    voltage = DRIVES["sine"](2700)
    hum = 0.1 * np.sin(2 * np.pi * 120.0 * np.arange(2700) * TS)
    path = write(tmp_path / "one.csv", voltage, simple_displacement_of(voltage) + hum)
    out = tmp_path / "out"
    others = ",".join(e for e in EFFECTS if e not in ("hum", "creep"))
    options = ("--rules", 1, "--workers", 1, "--exclude", others, "--quiet")
    assert run("diagnose", path, *options, "-o", out) == 0
    report, page = report_of(out)
    text = rf"Effects were sought on {said} of the training records, (\d+) of their 2700"
    assert least <= int(re.search(text, page)[1]) <= 900
    assert any(re.match(text, warning) for warning in report["warnings"])
    # the error is that of the packaged FMU over all samples
    entry, record = report["error"]["after"]["one"], read_record(path)
    outputs, _ = simulate(out / "IT2Plant.fmu", {"voltage": record.voltage}, entry["start"])
    error = record.displacement - outputs["measured"] - entry["offset_um"] * UM
    error = error[entry["skipped_samples"] :]
    assert len(error) > 1500 and "hum" in report["effects"]
    assert np.sqrt(np.mean(error**2)) / UM == pytest.approx(entry["e_rms_um"], rel=1e-6)
    assert entry["e_rms_um"] == pytest.approx(0.006, rel=0.1)


def test_an_identification_says_what_its_search_saw(tmp_path, monkeypatch):
    monkeypatch.setattr(excerpts, "_WINDOW", 100)
    voltage = random_steps(3000)
    path = write(tmp_path / "one.csv", voltage, displacement_of(voltage))
    assert run("identify", path, "--rules", 1, "-o", tmp_path / "out", "--quiet") == 0
    assert "on windows of 100 samples, about 800 of 3000;" in report_of(tmp_path / "out")[1]


# --- records without noise -----------------------------------------------------------------------


def assert_no_absurd_figures(text):
    found = re.findall(r"(\d[\d.e+]*) (?:times the noise|%)", text)
    assert not [figure for figure in found if abs(float(figure)) > 1e4], found


def ellipse():
    phase = 2 * np.pi * 20 * np.arange(3000) * TS
    return 52.5 - 52.5 * np.cos(phase), 7.5 - 7.5 * np.cos(phase - 0.2), "{:.5f},{:.5f},{:.5f}\n"


def own_simulation():
    voltage = wave(50.0)(1000)
    return voltage, compiled.chain_free_run(table_1(), voltage)[0] / UM, "{!r},{!r},{!r}\n"


@pytest.mark.parametrize(
    ("command", "make"),
    [
        (["identify"], ellipse),
        (["diagnose", "--workers", "1"], ellipse),
        (["identify"], own_simulation),
    ],
)
def test_a_record_without_noise_is_judged_by_its_resolution(command, make, tmp_path, capsys):
    voltage, displacement, pattern = make()
    path = write(tmp_path / "one.csv", voltage, displacement, pattern)
    assert run(*command, path, "--rules", 2, "-o", tmp_path / "out") == 0
    report, page = report_of(tmp_path / "out")
    for text in (
        capsys.readouterr().out,
        re.sub(r'src="data:[^"]*"', "", page),
        str(report["warnings"]),
    ):
        assert_no_absurd_figures(text)
    least = 1e-5 / np.sqrt(12) if make is ellipse else 1e-7 * np.ptp(displacement)
    assert report["noise_rms_um"] >= 0.9 * least  # of what is left behind a start-up


# --- records that hold next to nothing -------------------------------------------------------------

COUNT = 700
SINE = wave(50.0)(COUNT)
LATE = np.arange(COUNT) >= COUNT // 4
BARE = {
    "a single step": (50.0 * LATE, 7.0 * LATE, 0.01),
    "a single step without noise": (50.0 * LATE, 7.0 * LATE, 0.0),
    "a step at once": (50.0 * (np.arange(COUNT) > 0), 7.0 * (np.arange(COUNT) > 0), 0.01),
    "a pulse": (50.0 * (np.arange(COUNT) // 5 == 70), 6.0 * (np.arange(COUNT) // 6 == 59), 0.01),
    "a ramp": (np.linspace(0.0, 100.0, COUNT), np.linspace(0.0, 15.0, COUNT), 0.01),
    "two values": (50.0 * (np.arange(COUNT) // 20 % 2), 7.0 * (np.arange(COUNT) // 20 % 2), 0.0),
    "alternating": (50.0 * (np.arange(COUNT) % 2), 7.0 * (np.arange(COUNT) % 2), 0.01),
    "rest, then a sine": (np.where(LATE[::-1], 0.0, SINE), np.where(LATE[::-1], 0.0, 0.15 * SINE), 0.0),
    "a straight line": (SINE, 0.15 * SINE, 0.0),
    "coarse": (SINE, np.where(SINE > 50.0, 7.0, 0.0), 0.0),
    "a drift alone": (SINE, np.linspace(0.0, 8.0, COUNT), 0.0),
    "far from zero": (SINE, 0.15 * SINE + 2.5e6, 0.01),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("command", [["identify"], ["diagnose", "--workers", "1"]], ids=lambda c: c[0])
@pytest.mark.parametrize("name", BARE)
def test_what_holds_next_to_nothing_ends_with_a_result_or_one_message(name, command, tmp_path, capsys):
    voltage, displacement, noise = BARE[name]
    displacement = displacement + noise * np.random.default_rng(0).standard_normal(COUNT)
    path = write(tmp_path / "one.csv", voltage, displacement)
    code = run(*command, path, "--rules", 1, "-o", tmp_path / "out", "--quiet")
    assert code in (0, 2)
    assert (tmp_path / "out").exists() == (code == 0)
    assert len(capsys.readouterr().err.strip().splitlines()) == (1 if code else 0)


# --- options that no model takes -------------------------------------------------------------------


@pytest.mark.parametrize("command", ["identify", "diagnose"])
@pytest.mark.parametrize(
    ("option", "value", "phrase"),
    [
        ("--rules", "0", "whole number from 1 to 16, not 0"),
        ("--rules", "-2", "whole number from 1 to 16, not -2"),
        ("--rules", "17", "whole number from 1 to 16, not 17"),
        ("--seed", "-1", "--seed -1: must be a whole number from 0 up"),
    ],
)
def test_a_number_that_no_model_takes_is_refused(command, option, value, phrase, tmp_path, capsys):
    path = write(tmp_path / "one.csv", SINE, 0.15 * SINE)
    assert_refused(capsys, [command, path, option, value, "-o", tmp_path / "out"], phrase)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_half_a_rule_is_bad_usage(command, tmp_path, capsys):
    path = write(tmp_path / "one.csv", SINE, 0.15 * SINE)
    with pytest.raises(SystemExit) as caught:
        run(command, path, "--rules", "2.5", "-o", tmp_path / "out")
    assert caught.value.code == 2
    assert "--rules: invalid int value: '2.5'" in capsys.readouterr().err


# --- records that no stage gave ----------------------------------------------------------------------

WRONG = {
    "reversed": (
        SINE,
        -displacement_of(SINE),
        "falls by 1[234].* µm while the voltage rises from 0 to",
    ),
    "butterfly": (SINE - 52.5, (SINE - 52.5) ** 2 / 300, "falls and rises again while the voltage"),
    "noise": (SINE, np.random.default_rng(0).standard_normal(COUNT), "explains .* no more than chance"),
}


@pytest.mark.parametrize("command", ["identify", "diagnose"])
@pytest.mark.parametrize("role", [(), ("--test",)], ids=["fitted", "test"])
@pytest.mark.parametrize("name", WRONG)
def test_a_record_that_no_stage_gave_is_refused_before_any_fit(name, role, command, tmp_path, capsys):
    voltage, displacement, phrase = WRONG[name]
    right = write(tmp_path / "right.csv", SINE, displacement_of(SINE))
    wrong = write(tmp_path / "wrong.csv", voltage, displacement)
    files = [right, *role, wrong] if role else [wrong]
    assert run(command, *files, "-o", tmp_path / "out") == 2
    message = capsys.readouterr().err.strip()
    assert re.search(rf"wrong\.csv: .*{phrase}", message) and "\n" not in message
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", [["identify"], ["diagnose", "--workers", "1"]], ids=lambda c: c[0])
def test_an_inverted_displacement_is_said_in_the_reports(command, tmp_path, capsys):
    path = write(tmp_path / "one.csv", SINE, -simple_displacement_of(SINE))
    options = ("--rules", 1, "--invert-displacement", "-o", tmp_path / "out")
    assert run(*command, path, *options) == 0
    assert "The displacement was inverted" in capsys.readouterr().out
    report, page = report_of(tmp_path / "out")
    assert report["records"]["one"]["displacement_inverted"] is True
    assert "The displacement was inverted" in page
    outputs, _ = simulate(tmp_path / "out" / "IT2Plant.fmu", {"voltage": SINE})
    assert (
        np.corrcoef(outputs["displacement"], read_record(path, invert_displacement=True).displacement)[
            0, 1
        ]
        > 0.9
    )
