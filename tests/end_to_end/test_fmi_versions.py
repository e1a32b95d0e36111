"""`simulate` and `sweep` with FMUs of FMI 2.0, of FMI 3.0 and of both: the same bits."""

import zipfile
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from conftest import make_set, package_models
from effects import with_effects
from foreign_fmu import build_foreign_3

from it2hys.cli import main
from it2hys.cosimulation import faces
from it2hys.cosimulation.slave import Slave
from it2hys.cosimulation.stepping import Connection, System
from it2hys.errors import InputError
from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import table_1

TICKS = 600
SETS = {"table_1": table_1, "five_rules": lambda: make_set(5, 5, "five rules"),
        "all_effects": lambda: with_effects(EFFECTS, seed=3)}  # fmt: skip
SWEEP = """
duration = 0.05
connections = [
  {{ from = "reference", to = "inverse.reference" }},
  {{ from = "inverse.voltage", to = "plant.voltage" }},
]
keep = ["plant.displacement", "inverse.voltage"]
[fmu.inverse]
source = "{inverse}"
start = {{ initialDisplacement = 1e-6, "rule[1].q3" = 1.75e-6 }}
[fmu.plant]
source = "{plant}"
start = {{ initialDisplacement = 1e-6 }}
[signal.reference]
signal = "sine"
frequency = 50.0
low = 1e-6
high = 9e-6
[[vary]]
name = "q2"
of = "plant.rule[2].q2"
values = [0.9, 1.0, 1.1]
factor = true
[[metric]]
kind = "e_rms"
of = "plant.displacement"
against = "reference"
[[metric]]
kind = "time true"
of = "inverse.saturated"
"""


@pytest.fixture(scope="module", params=SETS)
def both(request, tmp_path_factory):
    """Return the FMUs of one set by version and model."""
    folder = tmp_path_factory.mktemp(request.param)
    return {v: package_models(SETS[request.param](), folder, v) for v in (2, 3)}


@pytest.mark.parametrize("model", ["plant", "inverse"])
def test_simulate_gives_the_numbers_of_the_other_version(both, tmp_path, monkeypatch, model):
    monkeypatch.chdir(tmp_path)
    time = np.arange(TICKS) * 1e-4
    wave = 1 - np.cos(2 * np.pi * 20 * time)
    name, scale = {"plant": ("voltage_V", 35.0), "inverse": ("reference_um", 5.0)}[model]
    rows = zip(time.tolist(), (scale * wave).tolist(), (300 + wave).tolist(), strict=True)
    lines = [f"time_s,{name},temperature_K", *(f"{t!r},{x!r},{k!r}" for t, x, k in rows)]
    Path("u.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    options = ["--set", "rule[2].q2=1.3e-8", "--set", "initialDisplacement=1e-6", "--quiet"]
    for version, models in both.items():
        fmu = str(models[model].path)
        assert main(["simulate", fmu, "--input", "u.csv", "-o", f"y{version}.csv", *options]) == 0
    assert Path("y3.csv").read_bytes() == Path("y2.csv").read_bytes()
    table = pl.read_csv("y3.csv")
    assert len(table) == TICKS
    assert table["displacement_um" if model == "plant" else "voltage_V"].n_unique() > TICKS / 3


@pytest.mark.parametrize("versions", [(3, 3), (2, 3), (3, 2)])
def test_a_sweep_of_either_version_or_both_has_the_same_table(both, tmp_path, monkeypatch, versions):
    tables = []
    for inverse, plant in ((2, 2), versions):
        folder = tmp_path / f"{inverse}{plant}"
        folder.mkdir()
        monkeypatch.chdir(folder)
        paths = {"inverse": both[inverse]["inverse"].path, "plant": both[plant]["plant"].path}
        Path("sweep.toml").write_text(SWEEP.format(**paths), encoding="utf-8")
        assert main(["sweep", "sweep.toml", "-o", "out", "--workers", "1", "--quiet"]) == 0
        said = pl.col("message").str.replace_all("fmi3", "fmi2")  # names of functions
        tables.append(pl.read_parquet("out/results.parquet").with_columns(said))
    assert tables[0].equals(tables[1], null_equal=True)
    assert tables[1]["status"].to_list() == ["ok"] * 3
    assert tables[1]["e_rms"].n_unique() == 3


def test_a_structural_parameter_is_refused_in_the_fmus_words(both, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("u.csv").write_text("time_s,voltage_V\n0,0\n0.0001,1\n", encoding="utf-8")
    fmu = str(both[3]["plant"].path)
    assert main(["simulate", fmu, "--input", "u.csv", "-o", "y.csv", "--set", "ruleCount=4"]) == 2
    assert "ruleCount is a structural parameter" in capsys.readouterr().err


# --- an FMU of FMI 3.0 that is nothing like ours -----------------------------------------------


@pytest.fixture(scope="module")
def foreign(tmp_path_factory):
    """Return the path of an FMU with variables of many types."""
    return build_foreign_3(tmp_path_factory.mktemp("foreign"))


def test_types_arrays_and_messages_of_a_foreign_fmu(foreign):
    connections = [Connection(*pair.split()) for pair in ("x a.x", "n a.n", "on a.on", "a.odd b.on")]
    steps = 60
    signals = {
        "x": np.linspace(0, 3, steps),
        "n": np.arange(steps) % 3,
        "on": (np.arange(steps) % 4 > 0).astype(float),
    }
    with Slave(foreign) as a, Slave(foreign) as b:
        system = System({"a": a, "b": b}, connections, ["a.y", "a.count", "a.odd", "b.y"])
        system.initialize({"a": {"part.gain[2]": 2.0, "mode": 5}, "b": {"mode": 1}})
        assert [a.get(f"part.gain[{k}]") for k in (1, 2)] == [1.0, 2.0]
        rows = system.run(signals, steps, 0.1)
        time, count = np.arange(steps) * 0.1, np.cumsum(signals["n"])
        expected = np.where(signals["on"] > 0, signals["x"] + 2.0 * time + 5.0, 0.0)
        assert rows["a.y"].tobytes() == expected.tobytes()
        np.testing.assert_array_equal(rows["a.count"], count)
        np.testing.assert_array_equal(rows["a.odd"], count % 2)
        np.testing.assert_array_equal(rows["b.y"], rows["a.odd"])
        system.initialize()
        assert a.get("part.gain[2]") == 0.0 and not a.warned
        system.run({**signals, "n": np.full(steps, 20.0)}, steps, 0.1)
        assert a.warned and a.messages[0] == "that is a lot" and not b.warned


def test_an_array_too_large_for_elements_is_not_set(foreign, monkeypatch):
    monkeypatch.setattr(faces, "MOST_ELEMENTS", 1)
    with pytest.raises(InputError, match=r"no variable 'part.gain\[1\]'"):
        Slave(foreign, {"part.gain[1]": 2.0})
    with pytest.raises(InputError, match=r"part.gain is of an array without start values, or of more"):
        Slave(foreign, {"part.gain": 2.0})


def test_a_foreign_fmu_that_asks_to_end_ends_the_run(foreign):
    with Slave(foreign) as slave:
        system = System({"a": slave}, [Connection("x", "a.x")], ["a.y"])
        system.initialize()
        with pytest.raises(InputError, match=r"fmi3DoStep asks to end the simulation at 2 s"):
            system.run({"x": np.where(np.arange(50) < 20, 1.0, -1.5)}, 50, 0.1)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<CoSimulation ", "<ModelExchange ", "not an FMU for co-simulation"),
        ('start="1 0"', 'start="1 0 3"', "variable 'part.gain': start has 3 values, not 2"),
        ('start="1 0"', 'start="1 much"', "variable 'part.gain': start is '1 much'"),
        ('<Float64 name="y"', '<Int8 name="y"', "fmu.y is an Int8; variables of Float64, Int32"),
        ('"local"', '"output"', "fmu.blob is a Binary; variables of Float64, Int32, Boolean can be"),
    ],
)  # fmt: skip
def test_what_cannot_be_simulated_is_refused_in_one_message(
    foreign, tmp_path, monkeypatch, capsys, old, new, said
):
    monkeypatch.chdir(tmp_path)
    Path("u.csv").write_text("time_s,voltage_V\n0,0\n0.1,1\n", encoding="utf-8")
    with zipfile.ZipFile(foreign) as whole, zipfile.ZipFile("other.fmu", "w") as other:
        for name in whole.namelist():
            data = whole.read(name)
            if name == "modelDescription.xml":
                text = data.decode().replace('name="x"', 'name="voltage"')
                text = text.replace("<Binary", SAMPLE_TIME + "<Binary")
                assert old in text
                data = text.replace(old, new).encode()
            other.writestr(name, data)
    assert main(["simulate", "other.fmu", "--input", "u.csv", "-o", "y.csv", "--quiet"]) == 2
    error = capsys.readouterr().err
    assert said in error and len(error.strip().splitlines()) == 1
    assert not Path("y.csv").exists()


SAMPLE_TIME = (
    '<Float64 name="sampleTime" valueReference="50" causality="parameter" variability="fixed" '
    'start="0.1"/>'
)
