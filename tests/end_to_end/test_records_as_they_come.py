"""Records as people have them: the commands say what is odd in them, and go on or refuse."""

import json
from dataclasses import replace

import numpy as np
import pytest
from conftest import TS, UM
from diagnosis import voltages
from test_cli import html_of, run
from test_diagnose import measure, report_of, stage_with, write_all

from it2hys.model import compiled
from it2hys.model.chain import EFFECTS
from it2hys.records import Record, write_record

SAMPLES = 800


def identify(train, out, *options):
    return run("identify", *train, "--rules", 1, "-o", out, *options)


def diagnose(train, out, *options):
    return run("diagnose", *train, "--rules", 1, "-o", out, "--workers", 1, *options)


def diagnose_loop(train, out, *options):
    """Look for play alone: of a diagnosis, whatever it finds."""
    others = ",".join(e for e in EFFECTS if e != "play")
    return diagnose(train, out, "--exclude", others, *options)


def with_columns(path, names, *columns):
    """Add columns to a file, as another program would."""
    header, *lines = path.read_text(encoding="utf-8").splitlines()
    added = [",".join(f"{c[k]:.3f}" for c in columns) for k in range(len(lines))]
    rows = [f"{line},{more}" for line, more in zip(lines, added, strict=True)]
    path.write_text("\n".join([f"{header},{','.join(names)}", *rows]) + "\n", encoding="utf-8")


# --- columns that are not used -------------------------------------------------------------------


@pytest.fixture(scope="module")
def annotated(tmp_path_factory):
    """Write records with a temperature and a counter that no option names."""
    folder = tmp_path_factory.mktemp("annotated")
    write_all(folder, stage_with(), has_force=False)
    for seed, name in enumerate("abvt"):
        heat = 20.0 + 0.5 * np.sin(np.linspace(0.0, 5.0 + seed, SAMPLES))
        with_columns(folder / f"{name}.csv", ["Temp (°C)", "counter"], heat, np.arange(SAMPLES))
    return folder


@pytest.mark.parametrize("command", [identify, diagnose_loop])
def test_unused_columns_are_named_with_what_to_do(annotated, command, tmp_path, capsys):
    assert command([annotated / "a.csv", annotated / "b.csv"], tmp_path / "out") == 0
    said, report = capsys.readouterr().out, report_of(tmp_path / "out")
    (warning,) = [w for w in report["warnings"] if "not used" in w]
    assert warning.startswith("Columns 'Temp (°C)', 'counter' of records 'a', 'b' are not used.")
    assert "--column 'temperature=Temp (°C):degC'" in warning and "drift" in warning
    assert warning in said
    assert warning in html_of(tmp_path / "out").replace("&#39;", "'")
    assert report["records"]["a"]["unused_columns"] == ["Temp (°C)", "counter"]


def test_the_advice_is_taken(annotated, tmp_path):
    option = ("--column", "temperature=Temp (°C):degC")
    assert identify([annotated / "a.csv"], tmp_path / "out", *option, "--quiet") == 0
    (warning,) = [w for w in report_of(tmp_path / "out")["warnings"] if "not used" in w]
    assert warning.startswith("Column 'counter' of record 'a' is not used.")
    assert "Temp" not in warning


# --- closed loop ---------------------------------------------------------------------------------


def regulated(name, draw, seed):
    """Return a record of play before a first-order core under a PI controller, tick by tick."""
    rng, time = np.random.default_rng(seed), np.arange(1000) * TS
    reference = 2.0 + 0.1 * draw(rng, time, 105.0)
    thresholds, weights = np.array([0.0, 4.0, 8.0, 14.0]), np.array([0.6, 0.2, 0.15, 0.1])
    memory, y, reading, summed = np.zeros(4), 1.0, 1.0, 0.0
    voltage, displacement = np.empty((2, len(time)))
    for k, wanted in enumerate(reference):
        error = wanted - reading
        summed += 0.3 * error
        voltage[k] = 0.3 * error + summed
        memory = np.clip(memory, voltage[k] - thresholds, voltage[k] + thresholds)
        y = 0.9 * y + 0.015 * float(weights @ memory) + 0.1
        displacement[k] = reading = y + 0.006 * rng.standard_normal()
    return Record(name, time, voltage, UM * displacement, TS)


def test_a_closed_loop_is_said_and_makes_no_creep(tmp_path, capsys):
    draws = (voltages.two_sines, voltages.staircase, voltages.staircase)
    for seed, (name, draw) in enumerate(zip("abv", draws, strict=True)):
        write_record(tmp_path / f"{name}.csv", regulated(name, draw, seed))
    train = [tmp_path / "a.csv", tmp_path / "b.csv"]
    # what has nothing to do with it is left out to be quick
    others = "delay,slew,saturation,lag,resonance,drift,nonlinearity,hum"
    options = ("--validate", tmp_path / "v.csv", "--exclude", others)
    assert diagnose(train, tmp_path / "out", *options) == 0
    report, said = report_of(tmp_path / "out"), capsys.readouterr().out
    loops = [w for w in report["warnings"] if "closed loop" in w]
    assert [w.split("'")[1] for w in loops] == ["a", "b", "v"]
    for words in ("controller off", "standard errors", "cause and effect"):
        assert words in loops[0] and words in said
    assert "creep" not in report["effects"]
    (creep,) = [e for e in report["evidence"] if e["effect"] == "creep"]
    assert "closed loop" in creep["why"] and "--declared creep" in creep["why"]


# --- quantised, and without noise ----------------------------------------------------------------


@pytest.mark.parametrize("command", [identify, diagnose_loop])
def test_a_quantised_reading_is_said_beside_noise_and_error(command, tmp_path, capsys):
    step = 0.08
    for seed, name in enumerate("ab"):
        exact = measure(stage_with(), name, seed, has_force=False)
        coarse = UM * step * np.round(exact.displacement / UM / step)
        write_record(tmp_path / f"{name}.csv", replace(exact, displacement=coarse))
    assert command([tmp_path / "a.csv", tmp_path / "b.csv"], tmp_path / "out") == 0
    report, said = report_of(tmp_path / "out"), capsys.readouterr().out
    warnings = [w for w in report["warnings"] if "quantised" in w]
    assert len(warnings) == 2 and "in steps of 0.08 µm" in warnings[0] and warnings[0] in said
    assert report["records"]["a"]["sensor_step_um"] == pytest.approx(step, rel=1e-6)
    assert report["noise_rms_um"] == pytest.approx(step / np.sqrt(12.0), rel=0.3)
    assert "0.0000" not in said


@pytest.mark.parametrize("command", [identify, diagnose])
def test_a_record_without_noise_works(command, tmp_path, capsys):
    for seed, name in enumerate("ab"):
        exact = measure(stage_with(), name, seed, has_force=False)
        clean = compiled.chain_free_run(stage_with().replace(initialDisplacement=UM), exact.voltage)[1]
        write_record(tmp_path / f"{name}.csv", replace(exact, displacement=clean))
    assert command([tmp_path / "a.csv", tmp_path / "b.csv"], tmp_path / "out") == 0
    report = report_of(tmp_path / "out")
    assert 0.0 < report["noise_rms_um"] < 1e-3
    assert np.isfinite(json.loads(json.dumps(report["noise_rms_um"])))
    assert not [w for w in report["warnings"] if "quantised" in w]
    assert report.get("effects", []) == []
    table = capsys.readouterr().out.split("Errors")[0]
    assert " nan" not in table


# --- steps that ring -----------------------------------------------------------------------------


def test_a_ring_after_steps_of_the_training_records_alone_is_named(tmp_path):
    stage = stage_with(**{"resonance.frequency": 980.0, "resonance.damping": 0.008})
    time = np.arange(1200) * TS
    draws = {"steps": voltages.staircase, "slow": voltages.slow_sine, "check": voltages.slow_sine}
    for seed, (name, draw) in enumerate(draws.items()):
        rng = np.random.default_rng(seed)
        voltage = draw(rng, time, 105.0)
        start = stage.replace(initialDisplacement=UM + 0.15 * UM * voltage[0])
        reading = compiled.chain_free_run(start, voltage)[1] + 0.006 * UM * rng.standard_normal(1200)
        write_record(tmp_path / f"{name}.csv", Record(name, time, voltage, reading, TS))
    train = [tmp_path / "steps.csv", tmp_path / "slow.csv"]
    held_out = ("--validate", tmp_path / "check.csv")
    assert diagnose(train, tmp_path / "out", *held_out, "--quiet") == 0
    report = report_of(tmp_path / "out")
    assert report["effects"] == ["resonance"]
    found = report["parameters"]["resonance.frequency"]["value"]
    assert found == pytest.approx(980.0, rel=0.01)


# --- what no stage gave --------------------------------------------------------------------------


def damper(seed, kind):
    """Return velocity, m/s, and force, kN, of a damper by Bouc and Wen."""
    rng, time = np.random.default_rng(seed), np.arange(1000) * 2e-3
    top = rng.uniform(2.0, 4.0)
    phase = 2.0 * np.pi * (top * time if kind == "sine" else 0.5 * time + top * time**2 / 4.0)
    velocity = 0.3 * np.sin(phase)
    slope, beta = rng.uniform([60.0, 30.0], [140.0, 90.0])
    gamma = rng.uniform(0.3, 0.9) * beta
    memory, kept = 0.0, np.empty(len(time))
    for k, v in enumerate(velocity):
        for _ in range(10):
            memory += 2e-4 * (slope * v - beta * abs(v) * memory - gamma * v * abs(memory))
        kept[k] = memory
    force = velocity / 0.3 * rng.uniform(0.2, 0.8) + kept / np.abs(kept).max()
    return time, velocity, 5.0 * force + 0.01 * rng.standard_normal(len(time))


@pytest.mark.parametrize(("seed", "kind"), [(0, "sine"), (1, "sweep"), (2, "sweep")])
def test_a_damper_is_unexplained_in_its_owner_s_words(seed, kind, tmp_path, capsys):
    time, velocity, force = damper(seed, kind)
    rows = np.column_stack([time, velocity, force])
    np.savetxt(
        tmp_path / "damper.csv", rows, "%.6f", ",", header="time_s,velocity,force_kN", comments=""
    )
    columns = ("--column", "voltage=velocity:V", "--column", "displacement=force_kN:um")
    # identified, it is said to be no stage's; what a search makes of it is in the next test
    assert identify([tmp_path / "damper.csv"], tmp_path / "out", *columns) == 0
    (warning,) = [w for w in report_of(tmp_path / "out")["warnings"] if "wide loop" in w]
    assert "damper's force over its velocity" in warning and "of its travel apart" in warning
    assert warning in capsys.readouterr().out


def test_a_diagnosis_of_a_damper_calls_it_unexplained(tmp_path):
    time, velocity, force = damper(3, "sweep")
    write_record(tmp_path / "damper.csv", Record("damper", time, velocity, UM * force, 2e-3))
    # what is quickest of all that a loop may be taken for
    others = "delay,slew,saturation,lag,creep,resonance,drift,hum"
    options = ("--exclude", others, "--quiet")
    assert diagnose([tmp_path / "damper.csv"], tmp_path / "out", *options) == 0
    report = report_of(tmp_path / "out")
    assert report["unexplained"] is True
    assert any("damper" in w for w in report["warnings"])


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_a_butterfly_is_refused_before_anything_is_written(seed, command, tmp_path, capsys):
    rng, time = np.random.default_rng(seed), np.arange(1500) * 1e-3
    coercive = rng.uniform(0.3, 0.6) * 150.0
    drive = 150.0 * np.sin(2.0 * np.pi * 4.0 * time)
    fields, domains = np.abs(rng.normal(coercive, 0.15 * coercive, 60)), -np.ones(60)
    strain = np.empty(len(time))
    for k, field in enumerate(drive):
        domains = np.where(field > fields, 1.0, np.where(field < -fields, -1.0, domains))
        strain[k] = (domains.mean() + 0.25 * field / 150.0) ** 2
    reading = 8.0 * strain / np.ptp(strain) + 0.02 * rng.standard_normal(len(time))
    write_record(tmp_path / "b.csv", Record("b", time, drive, UM * reading, 1e-3))
    out = tmp_path / "out"
    assert run(command, tmp_path / "b.csv", "-o", out) == 2
    message = capsys.readouterr().err
    assert "b.csv" in message and "butterfly loop" in message
    assert "drive the stage on one side of zero volts" in message
    assert not out.exists()


# --- what the voltage explains -------------------------------------------------------------------


def test_a_displacement_that_other_inputs_move_is_said_to_be_so_first(tmp_path, capsys):
    time = np.arange(1000) * TS
    for seed, name in enumerate("ab"):
        rng = np.random.default_rng(seed)
        # three axes at once, up to the highest frequencies: a quarter of it is this one's
        drives = 50.0 + 10.0 * rng.standard_normal((3, 1000))
        reading = 0.05 * (drives[0] + 1.2 * drives[1] - 1.2 * drives[2])
        reading += 0.006 * rng.standard_normal(1000)
        write_record(tmp_path / f"{name}.csv", Record(name, time, drives[0], UM * reading, TS))
    assert diagnose([tmp_path / "a.csv", tmp_path / "b.csv"], tmp_path / "out") == 0
    said, report = capsys.readouterr().out, report_of(tmp_path / "out")
    for error in report["error"]["after"].values():
        assert error["voltage_explains_percent"] == pytest.approx(26.0, abs=8.0)
    sentence = "of the displacement of record 'a', whatever its lag, memory or curve"
    assert sentence in said
    page = html_of(tmp_path / "out").replace("&#39;", "'")
    assert page.index(sentence) < page.index("How good the pair is")
    assert "No: most of what was measured is not the voltage's doing" in said


def test_the_voltage_explains_nearly_all_of_a_stage(annotated, tmp_path):
    assert diagnose([annotated / "a.csv"], tmp_path / "out", "--quiet") == 0
    (error,) = report_of(tmp_path / "out")["error"]["after"].values()
    assert error["explained_percent"] > 99.9 and error["voltage_explains_percent"] > 99.0
