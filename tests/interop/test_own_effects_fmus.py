"""FMUs, C header and Modelica library with an effect of the user's own: they do all that ours do."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import casadi as ca
import fmpy
import numpy as np
import pytest
from casadi_runs import around, assert_same
from casadi_runs import run as run_casadi
from conftest import TS, Instance, package_models
from effects import gentle_reference, signals, surroundings
from fmpy import fmi2
from fmpy.validation import validate_fmu
from own_effects import NAMES, in_chain, with_own
from test_effects_fmus import run

import it2hys
from it2hys.export.embedded import write_embedded
from it2hys.fmu.own_library import compiler, fmi_headers
from it2hys.fmu.packaging import package
from it2hys.fmu.platforms import PLATFORMS
from it2hys.model import compiled
from it2hys.model.parameters import read_ssv

ROOT = Path(__file__).parents[2]
SAMPLES = 300


@pytest.fixture(scope="module")
def effects():
    with in_chain(*NAMES) as found:
        yield found


@pytest.fixture(scope="module")
def packaged(effects, tmp_path_factory):
    """Return the folder of all FMUs of a set with every effect of tests/unit/own."""
    folder = tmp_path_factory.mktemp("own")
    package(with_own(effects), folder, fmi=(2, 3))
    return folder


def test_fmus_c_chain_and_casadi_are_one_model(effects, tmp_path):
    parameters = with_own(effects)
    models, chain, others = (
        package_models(parameters, tmp_path),
        it2hys.casadi_chain(parameters),
        around(),
    )
    acting = {name: others[name] for name in ("force", "temperature")}
    voltage, reference = signals(SAMPLES, -5.0, 115.0), gentle_reference(SAMPLES)
    plant = run(models["plant"], ("displacement", "measured"), {"voltage": voltage, **acting})
    theirs = run_casadi(chain.step, chain.rest()["state"], voltage=voltage, **others)
    for name in ("displacement", "measured"):
        assert_same(plant[name], theirs[name])
    inverse = run(models["inverse"], ("voltage", "saturated"), {"reference": reference, **acting})
    theirs = run_casadi(chain.inverse, chain.rest()["inverse_state"], reference=reference, **others)
    assert_same(inverse["voltage"], theirs["voltage"])
    assert np.array_equal(inverse["saturated"], theirs["saturated"])


def slopes(function: ca.Function) -> ca.Function:
    """Return the derivatives of a tick's output by its input, force and temperature."""
    symbols = [ca.SX.sym(n, *function.size_in(n)) for n in function.name_in()]
    output = function(*symbols)[1]
    return ca.Function("slopes", symbols, [ca.horzcat(*(ca.jacobian(output, s) for s in symbols[1:4]))])


def test_derivatives_of_the_fmu_are_casadis(effects, tmp_path):
    parameters = with_own(effects)
    models, chain = package_models(parameters, tmp_path), it2hys.casadi_chain(parameters)
    force, temperature = surroundings(SAMPLES)
    for model, function, first, output, signal in (
        ("plant", chain.step, "state", "displacement", signals(SAMPLES, 20.0, 90.0)),
        ("inverse", chain.inverse, "inverse_state", "voltage", gentle_reference(SAMPLES)),
    ):
        state, names, derive = chain.rest()[first], function.name_in()[1:4], slopes(function)
        with Instance(models[model]) as instance:
            instance.initialize()
            known, unknown = instance.references(names), instance.references([output])
            for k in range(SAMPLES):
                inputs = [float(signal[k]), float(force[k]), float(temperature[k])]
                instance.assign(dict(zip(names, inputs, strict=True)))
                assert instance.step(k * TS, TS) <= fmi2.fmi2Warning
                exact = np.array(derive(state, *inputs, k * TS)).ravel()
                found = [
                    instance.fmu.getDirectionalDerivative(unknown, [reference], [1.0])[0]
                    for reference in known
                ]
                np.testing.assert_allclose(found, exact, rtol=1e-9, atol=1e-10 * np.abs(exact).max())
                state = function(state, *inputs, k * TS)[0]


@pytest.mark.parametrize("name", ["IT2Plant", "IT2Inverse", "IT2Plant_fmi3", "IT2Inverse_fmi3"])
def test_the_fmus_are_valid_and_show_what_is_inside(packaged, effects, name):
    path = packaged / f"{name}.fmu"
    assert validate_fmu(path) == []
    described = fmpy.read_model_description(path)
    names = {v.name: v for v in described.modelVariables}
    for effect in effects:
        for p in effect.parameters:
            variable = names[f"{effect.name}.{p.name}"]
            assert variable.unit == p.unit and variable.causality == "parameter"
            assert int(variable.valueReference) > int(names["nonlinearity.sextic"].valueReference)
    units = {unit.name: unit.baseUnit for unit in described.unitDefinitions}
    assert units["1/K"] is None and units["Hz"] is not None
    with zipfile.ZipFile(path) as archive:
        entries = set(archive.namelist())
        for effect in effects:
            assert archive.read(f"resources/{effect.name}.py") == effect.file.read_bytes()
            assert f"static real {effect.name}_step(" in archive.read("sources/it2hys.c").decode()
    # for every platform that the package has them for
    folders = [p.name for p in (compiled.packaged_native() / "binaries").iterdir()]
    version = 1 if name.endswith("_fmi3") else 0
    expected = {PLATFORMS[f][version] for f in folders} - {None}
    assert {e.split("/")[1] for e in entries if e.startswith("binaries/")} == expected


def test_fmpy_runs_both_versions_to_equal_numbers(packaged):
    start = {"voltage": 60.0, "mount.gain": 0.3}
    runs = [
        fmpy.simulate_fmu(
            packaged / f"{name}.fmu", stop_time=0.02, output_interval=TS, start_values=start
        )
        for name in ("IT2Plant", "IT2Plant_fmi3")
    ]
    assert np.array_equal(runs[0]["displacement"], runs[1]["displacement"])
    other = fmpy.simulate_fmu(
        packaged / "IT2Plant.fmu", stop_time=0.02, start_values={**start, "mount.gain": 0.0}
    )
    assert other["displacement"][-1] != runs[0]["displacement"][-1]


def test_the_set_is_read_again_with_its_files_alone(packaged, effects, tmp_path):
    assert dict(read_ssv(packaged / "parameters.ssv")) == dict(with_own(effects))
    command = [sys.executable, "-c", "import sys; from it2hys.cli import main; sys.exit(main())"]
    command += [
        "package",
        str(packaged / "parameters.ssv"),
        "-o",
        str(tmp_path / "again"),
        "--fmi",
        "2",
    ]
    environment = {n: v for n, v in os.environ.items() if n != "IT2HYS_OWN_EFFECTS"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    for effect in effects:
        assert f" --effect {packaged / effect.name}.py" in done.stderr
    assert not (tmp_path / "again").exists()
    for effect in effects:
        command += ["--effect", str(packaged / f"{effect.name}.py")]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "again" / "parameters.ssv").read_bytes() == (
        packaged / "parameters.ssv"
    ).read_bytes()


PROGRAM = r"""
#include <stdio.h>
#include "it2hys_model.h"
static struct chain chain;
static struct chain_state plant, inverse;
int main(void)
{
    double reference, force, temperature;
    it2hys_begin(&chain, &plant);
    it2hys_begin(&chain, &inverse);
    for (int k = 0; scanf("%lf %lf %lf", &reference, &force, &temperature) == 3; k++) {
        const double time = k * IT2HYS_PARAMETERS.sampleTime;
        const struct chain_surroundings around = { force, temperature, time };
        unsigned limits;
        const real voltage = chain_inverse(&chain, &inverse, reference, &around, &limits);
        const real y = chain_step(&chain, &plant, voltage, &around);
        printf("%.17g %.17g %.17g\n", voltage, y, chain_measure(&chain, y, time));
    }
    return 0;
}
"""


def test_the_c_header_is_the_same_model(effects, tmp_path):
    parameters = with_own(effects)
    write_embedded(parameters, tmp_path, compiled.native_directory())
    (tmp_path / "main.c").write_text(PROGRAM)
    command = [
        *compiler(),
        "-std=c99",
        "-O2",
        "-ffp-contract=off",
        "main.c",
        "it2hys.c",
        "-o",
        "main",
        "-lm",
    ]
    subprocess.run(command, cwd=tmp_path, check=True)
    reference, (force, temperature) = gentle_reference(SAMPLES), surroundings(SAMPLES)
    rows = "\n".join(
        " ".join(map(repr, map(float, row))) for row in zip(reference, force, temperature, strict=True)
    )
    done = subprocess.run([tmp_path / "main"], input=rows, capture_output=True, text=True, check=True)
    voltage, displacement, measured = np.array(
        [line.split() for line in done.stdout.splitlines()], float
    ).T
    expected = compiled.chain_inverse_run(parameters, reference, force, temperature)[0]
    assert_same(voltage, expected)
    run_in_c = compiled.chain_free_run(parameters, expected, force, temperature)
    assert_same(displacement, run_in_c[0])
    assert_same(measured, run_in_c[1])


#: What the project's own effects pass, here with one of the user's own in the list.
EVERYONES = (
    "tests/unit/test_effects.py::test_each_effect_is_the_same_in_casadi_and_c_and_shows[mount]",
    "tests/unit/test_effects.py::test_casadi_derives_by_every_parameter_of_an_effect[mount]",
    "tests/unit/test_effects.py::test_starts_lie_within_their_bounds_and_make_a_usable_set[mount]",
    "tests/unit/test_casadi_chain.py::test_plant_and_inverse_are_the_compiled_ones[mount]",
    "tests/unit/test_chain_sensitivity.py::test_every_derivative_is_casadis[mount]",
    "tests/interop/test_effects_fmus.py::test_both_fmus_are_the_c_chain_to_the_last_bit[mount]",
    "tests/interop/test_effects_fmus.py::test_the_result_does_not_depend_on_how_time_is_cut[mount]",
    "tests/interop/test_effects_fmus.py::test_a_saved_state_goes_on_bit_for_bit[mount]",
    "tests/interop/test_effects_fmus.py::test_directional_derivatives_are_those_of_a_step[mount]",
    "tests/interop/test_effects_fmus.py::test_the_xml_lists_what_the_set_has[mount]",
    "tests/interop/test_fmi3.py::test_a_run_gives_the_bits_of_the_fmu_of_fmi_2",
    "tests/interop/test_capabilities.py",
    "tests/interop/test_fmpy_derivatives.py",
    "tests/interop/test_sources.py::test_sources_compile_without_warnings_and_compute_the_same_bits",
)  # fmt: skip


def test_it_passes_what_everyones_effects_pass():
    command = [sys.executable, "-m", "pytest", "-q", "-n0", "-p", "no:cacheprovider", "-rs", *EVERYONES]
    if len(list((compiled.packaged_native() / "binaries").iterdir())) > 1:
        command.append("tests/interop/test_platforms.py")
    with in_chain("mount"):
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and " passed" in done.stdout, done.stdout[-5000:] + done.stderr[-2000:]


@pytest.mark.skipif(sys.platform == "win32", reason="the fuzz driver is POSIX")
def test_the_fuzzer_finds_nothing(effects, tmp_path):
    """The calls of FMI 2.0 in any order on FMUs with all of them, with the sanitizers."""
    native, fuzz = compiled.native_directory(), ROOT / "fmu_src" / "fuzz"
    generated, source = native.parent / "generated", native / "source"
    folders = [generated, *(source / f for f in ("core", "fmi", "models")), ROOT / "fmu_src" / "tests"]
    include = [*(f"-I{f}" for f in folders), "-isystem", str(fmi_headers())]
    flags = [
        "-std=c99",
        "-O1",
        "-g",
        "-D_GNU_SOURCE",
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
    ]
    tests, models = ROOT / "fmu_src" / "tests", source / "models"
    files = [
        (native / "sources" / "it2hys.c", []),
        (fuzz / "fuzz_calls.c", []),
        (fuzz / "fuzz_driver.c", []),
    ]
    for name, kind in (("IT2Plant", "PLANT"), ("IT2Inverse", "INVERSE")):
        own = [
            f"-DFMI2_FUNCTION_PREFIX={name}_", f"-DAPI={kind}", f'-DAPI_IDENTIFIER="{name}"',
            f"-DAPI_KIND=FMU_{kind}", f"-DAPI_HASH=FMU_TABLE_HASH_{kind}",
        ]  # fmt: skip
        files += [(models / f"{name}.c", own), (tests / "fmi2_api.c", own)]
    objects = [str(tmp_path / f"{i}.o") for i in range(len(files))]
    for (name, more), output in zip(files, objects, strict=True):
        command = [*compiler(), *flags, *more, *include, "-c", str(name), "-o", output]
        subprocess.run(command, check=True)
    subprocess.run(
        [*compiler(), *flags, *objects, "-o", str(tmp_path / "fuzz"), "-lm", "-ldl"], check=True
    )
    command = [tmp_path / "fuzz", "-n", "20000", "-t", "5", fuzz / "corpus" / "calls.hex"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-3000:]
