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
import test_effects_fmus
from casadi_runs import around, assert_same
from casadi_runs import run as run_casadi
from conftest import MODELS, TS, Instance, Master, Unpacked, package_models, trajectory
from effects import gentle_reference, signals, surroundings
from fmi3 import Instance as Instance3
from fmi3 import swing
from fmpy import fmi2
from fmpy.validation import validate_fmu
from own_effects import NAMES, in_chain, with_own
from test_capabilities import FLAGS, PROMISES
from test_effects_fmus import run
from test_sources import STRICT, build

import it2hys
from it2hys.export.embedded import write_embedded
from it2hys.fmu.model_description import IDENTIFIERS
from it2hys.fmu.own_library import compiler, fmi_headers, run_all
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


@pytest.fixture(scope="module")
def models(packaged):
    """Return these FMUs of FMI 2.0, unpacked, by model."""
    return {
        model: Unpacked(packaged / f"{identifier}.fmu", packaged / identifier)
        for model, identifier in IDENTIFIERS.items()
    }


@pytest.fixture(scope="module")
def chain(effects):
    """Return their chain in CasADi."""
    return it2hys.casadi_chain(with_own(effects))


def test_fmus_c_chain_and_casadi_are_one_model(models, chain):
    others = around()
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


def test_derivatives_of_the_fmu_are_casadis(models, chain):
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


# --- what the project's own effects pass, too ----------------------------------------------------


@pytest.fixture(scope="module")
def case(effects, mounted):
    """Return the set with the second resonance and its FMUs, with all of NAMES in the chain."""
    return mounted


@pytest.mark.parametrize(
    "promise",
    [
        test_effects_fmus.test_both_fmus_are_the_c_chain_to_the_last_bit,
        test_effects_fmus.test_the_result_does_not_depend_on_how_time_is_cut,
        test_effects_fmus.test_a_saved_state_goes_on_bit_for_bit,
        test_effects_fmus.test_directional_derivatives_are_those_of_a_step,
        test_effects_fmus.test_the_xml_lists_what_the_set_has,
    ],
    ids=lambda promise: promise.__name__.removeprefix("test_"),
)
def test_they_do_what_fmus_with_effects_do(case, promise):
    promise(case)


@pytest.mark.parametrize("which", MODELS)
@pytest.mark.parametrize("flag", FLAGS)
def test_their_flags_are_kept(mounted, which, flag):
    unpacked = mounted[1][which]
    PROMISES[flag, dict(unpacked.flags)[flag]](unpacked)


@pytest.mark.parametrize("which", MODELS)
def test_the_fmu_of_fmi_3_gives_their_numbers(mounted, effects, which, tmp_path):
    """To rounding: it has a play operator and a creep term that change nothing besides."""
    parameters, models = mounted
    signal = swing(which)
    with Master(models[which]) as master:
        expected = master.run(signal)
    with Instance3(package_models(parameters, tmp_path, 3)[which]) as instance:
        assert_same(instance.initialize().run(signal), expected)


def test_their_sources_compile_without_warnings_and_compute_the_same_bits(mounted, tmp_path):
    unpacked = mounted[1]["plant"]
    library = build(unpacked, tmp_path / "own.so", *STRICT)
    assert trajectory(unpacked, library) == trajectory(unpacked)


FUZZ, MODEL_TESTS = ROOT / "fmu_src" / "fuzz", ROOT / "fmu_src" / "tests"


@pytest.fixture(scope="module")
def chain_object(effects, tmp_path_factory):
    """Return the chain with all of them, compiled with the sanitizers for all targets."""
    output = tmp_path_factory.mktemp("fuzz") / "it2hys.o"
    compile_for_fuzzing([(compiled.native_directory() / "sources" / "it2hys.c", (), output)])
    return output


FUZZED = (
    "-std=c99",
    "-O1",
    "-g",
    "-D_GNU_SOURCE",
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
)


def compile_for_fuzzing(jobs) -> None:
    """Compile C files, each with definitions of its own, to objects."""
    native = compiled.native_directory()
    source = native / "source"
    folders = [
        native.parent / "generated",
        *(source / f for f in ("core", "fmi", "models")),
        MODEL_TESTS,
    ]
    include = [*(f"-I{f}" for f in folders), "-isystem", str(fmi_headers())]
    run_all(
        [*compiler(), *FUZZED, *more, *include, "-c", str(path), "-o", str(output)]
        for path, more, output in jobs
    )


@pytest.mark.skipif(sys.platform == "win32", reason="the fuzz driver is POSIX")
@pytest.mark.parametrize("version", [2, 3])
def test_the_fuzzer_finds_nothing(effects, chain_object, version, tmp_path):
    """The calls of FMI in any order on FMUs with all of them, with the sanitizers."""
    models = compiled.native_directory() / "source" / "models"
    target, end = ("calls", "") if version == 2 else ("fmi3", "_fmi3")
    sources = [(FUZZ / f"fuzz_{target}.c", ()), (FUZZ / "fuzz_driver.c", ())]
    for name, kind in (("IT2Plant", "PLANT"), ("IT2Inverse", "INVERSE")):
        own = (
            f"-DFMI{version}_FUNCTION_PREFIX={name}_", f"-DAPI={kind}{'3' if end else ''}",
            f'-DAPI_IDENTIFIER="{name}"', f"-DAPI_KIND=FMU_{kind}", f"-DAPI_HASH=FMU_TABLE_HASH_{kind}",
        )  # fmt: skip
        sources += [(models / f"{name}{end}.c", own), (MODEL_TESTS / f"fmi{version}_api.c", own)]
    jobs = [(path, more, tmp_path / f"{i}.o") for i, (path, more) in enumerate(sources)]
    compile_for_fuzzing(jobs)
    objects = [str(chain_object), *(str(output) for _, _, output in jobs)]
    program = tmp_path / "fuzz"
    run_all([[*compiler(), *FUZZED, *objects, "-o", str(program), "-lm", "-ldl"]])
    command = [program, "-n", "20000", "-t", "2", FUZZ / "corpus" / f"{target}.hex"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-3000:]
