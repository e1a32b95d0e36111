"""Masters written in Rust, fmi-sim and fmusim, simulate FMUs of both versions to the numbers of FMPy.

They are programs, sought on the PATH and in build/rust/bin. fmi-sim comes by `cargo install fmi-sim
--version 0.7.0 --locked --root build/rust` (it needs libclang), fmusim from github.com/modelica/fmusim.
"""

import csv
import os
import re
import shutil
import subprocess
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from conftest import INPUT, MODELS, TS, Unpacked, package_models
from effects import INVERTIBLE, gentle_reference, signals, surroundings, with_effects
from test_effects_fmus import run

SAMPLES = 200
RUST = Path(__file__).parents[2] / "build" / "rust" / "bin"
PLACES = os.pathsep.join([os.environ.get("PATH", ""), str(RUST)])
OUTPUTS = {"plant": ("displacement", "measured", "outOfRange"), "inverse": ("voltage", "saturated")}
#: Effects on, and an inverse that can follow.
PARAMETERS = with_effects(INVERTIBLE, 42)


def program(name: str) -> str:
    """Return a program's path; skips where it is not there."""
    path = shutil.which(name, path=PLACES)
    if path is None:
        pytest.skip(f"no {name} on the PATH or in build/rust/bin")
    return path


def run_program(*command: object) -> None:
    done = subprocess.run(
        [*map(str, command)], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module", params=[2, 3], ids=["fmi2", "fmi3"])
def version(request):
    return request.param


@pytest.fixture(scope="module")
def unpacked(version, tmp_path_factory):
    """Return both FMUs of a version of FMI, by model."""
    return package_models(PARAMETERS, tmp_path_factory.mktemp(f"fmi{version}"), version)


@pytest.fixture(scope="module")
def of_fmi_2(tmp_path_factory):
    """Return both FMUs of FMI 2.0, by model: what FMPy says of them is what is expected."""
    return package_models(PARAMETERS, tmp_path_factory.mktemp("expected"))


def inputs(model: str) -> dict[str, np.ndarray]:
    """Return the inputs of a model at every tick."""
    force, temperature = surroundings(SAMPLES + 1)
    main = {"plant": lambda n: signals(n, -5.0, 115.0), "inverse": gentle_reference}[model]
    return {INPUT[model]: main(SAMPLES + 1), "force": force, "temperature": temperature}


def write_inputs(path: Path, model: str) -> Path:
    """Write the inputs as CSV."""
    columns = inputs(model)
    rows = zip(np.arange(SAMPLES + 1) * TS, *columns.values(), strict=True)
    lines = [",".join(["time", *columns]), *(",".join(repr(float(v)) for v in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def expected(unpacked: Unpacked, model: str) -> dict[str, np.ndarray]:
    """Return what the FMU of FMI 2.0 gives after each step, run through FMPy."""
    return run(unpacked, OUTPUTS[model], {name: v[:SAMPLES] for name, v in inputs(model).items()})


def assert_same(path: Path, wanted: Mapping[str, np.ndarray], rtol: float = 0.0) -> None:
    """Check the rows of a CSV file behind its first, which is before the first step."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    words = {"false": 0.0, "true": 1.0}
    for name, values in wanted.items():
        found = [words[row[name]] if row[name] in words else float(row[name]) for row in rows[1:]]
        np.testing.assert_allclose(found, values, rtol=rtol, err_msg=name)


def without_units(fmu: Path, copy: Path) -> Path:
    """Write a copy of an FMU whose description has no units.

    fmi-sim 0.7.0 refuses every FMU of FMI 3.0 that has them: 'unknown field "unit"'.
    """
    with zipfile.ZipFile(fmu) as read, zipfile.ZipFile(copy, "w") as written:
        for name in read.namelist():
            content = read.read(name)
            if name == "modelDescription.xml":
                content = re.sub(rb"<UnitDefinitions>.*?</UnitDefinitions>", b"", content, flags=re.S)
                content = re.sub(rb' (unit|displayUnit)="[^"]*"', b"", content)
            written.writestr(name, content)
    return copy


@pytest.mark.parametrize("model", MODELS)
def test_fmi_sim_simulates_to_the_bits_of_fmpy(model, version, unpacked, of_fmi_2, tmp_path):
    fmu = unpacked[model].path
    if version == 3:
        fmu = without_units(fmu, tmp_path / fmu.name)
    run_program(
        program("fmi-sim"), "--model", fmu,
        "-i", write_inputs(tmp_path / "in.csv", model), "-o", tmp_path / "out.csv",
        "co-simulation", "--step", TS, "--output-interval", TS, "-s", 0, "-f", SAMPLES * TS,
    )  # fmt: skip
    assert_same(tmp_path / "out.csv", expected(of_fmi_2[model], model))


def fmusim(fmu: Path, model: str, folder: Path, *more: object, interval: float = TS) -> Path:
    """Simulate by fmusim; return the CSV file of the outputs."""
    run_program(
        program("fmusim"), "simulate", fmu, "--interface-type", "cs", "--stop-time", SAMPLES * TS,
        "--output-interval", interval,
        "--input-file", write_inputs(folder / "in.csv", model),
        "--output-file", folder / "out.csv", *more,
    )  # fmt: skip
    return folder / "out.csv"


@pytest.mark.parametrize("model", MODELS)
def test_fmusim_simulates_to_the_bits_of_fmpy(model, unpacked, of_fmi_2, tmp_path):
    found = fmusim(unpacked[model].path, model, tmp_path)
    assert_same(found, expected(of_fmi_2[model], model))


@pytest.mark.parametrize("model", MODELS)
def test_fmusim_finds_nothing(model, unpacked):
    run_program(program("fmusim"), "validate", unpacked[model].path)


@pytest.mark.parametrize("version", [3], indirect=True, ids=["fmi3"])
@pytest.mark.parametrize("model", MODELS)
def test_in_a_long_step_fmusim_gives_the_input_at_every_tick(model, unpacked, of_fmi_2, tmp_path):
    """By `intermediateUpdate`, which FMI 3.0 has."""
    found = fmusim(unpacked[model].path, model, tmp_path, "--intermediate-update", interval=10 * TS)
    # it writes down what it reads within a step, too, where it knows the time but for rounding
    assert_same(found, expected(of_fmi_2[model], model), rtol=1e-12)
