"""The FMU of FMI 3.0 as a file: its parts agree, checkers accept it, its flags are kept promises."""

import ctypes
import struct
import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pytest
from compilers import (
    HEADERS,
    compiler,
    declared_functions,
    declared_functions_of_fmi3,
    environment_for_cmake,
)
from conftest import CALM, INPUT, MODELS, OUTPUT, TS, Unpacked, make_set, package_models
from conftest import Instance as Instance2
from effects import with_effects
from fmi3 import ERROR, Instance, swing
from fmpy.build import build_platform_binary
from fmpy.model_description import read_build_description
from fmpy.validation import validate_fmu
from lxml import etree
from test_fmu_files import fmutool_findings
from test_sources import exported

from it2hys.cli import main
from it2hys.fmu.controller import controller_fmu
from it2hys.fmu.packaging import with_every_array
from it2hys.fmu.platforms import PLATFORMS
from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import format_ssv, table_1
from it2hys.model.variables import load_table

SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi3"
SETS = {
    "table_1": table_1(),
    "one_rule": make_set(1, 1, "one rule", sampleTime=2e-4, initialDisplacement=1e-6),
    "all_effects": with_effects(EFFECTS, seed=3),
}


@pytest.fixture(scope="module")
def packaged_fmi3(tmp_path_factory):
    """Return sets as packaged and their FMUs of FMI 3.0, by name."""
    return {
        name: (
            with_every_array(parameters),
            package_models(parameters, tmp_path_factory.mktemp(name), 3),
        )
        for name, parameters in SETS.items()
    }


@pytest.fixture(params=[f"{s}-{m}" for s in SETS for m in MODELS])
def any_fmu(request, packaged_fmi3):
    """Return a parameter set and one of its FMUs: every set and model in turn."""
    name, model = request.param.split("-")
    parameters, fmus = packaged_fmi3[name]
    return parameters, fmus[model]


@pytest.fixture(scope="module")
def controllers(tmp_path_factory) -> tuple[Unpacked, Unpacked]:
    """Return the controllers of FMI 2.0 and of FMI 3.0."""
    directory = tmp_path_factory.mktemp("controllers")
    for version in (2, 3):
        (directory / f"c{version}.fmu").write_bytes(controller_fmu(version))
    return Unpacked(directory / "c2.fmu", directory / "2"), Unpacked(
        directory / "c3.fmu", directory / "3"
    )


def root_of(fmu: Unpacked) -> etree._Element:
    return etree.parse(fmu.directory / "modelDescription.xml").getroot()


# --- checkers ----------------------------------------------------------------------------------


def test_fmpy_finds_nothing(any_fmu):
    assert validate_fmu(str(any_fmu[1].path)) == []


def test_fmpy_finds_nothing_in_the_controller(controllers):
    assert validate_fmu(str(controllers[1].path)) == []


def test_fmutool_finds_nothing(any_fmu, controllers, capfd, caplog):
    for fmu in (any_fmu[1], controllers[1]):
        assert fmutool_findings(fmu.path, caplog, "3.0") == []


def test_no_array_is_empty_at_first(any_fmu):
    """What the standard wants (Array variables and structural parameters), and FMPy does not check."""
    parameters, fmu = any_fmu
    structural = [v for v in fmu.description.modelVariables if v.causality == "structuralParameter"]
    assert [v.name for v in structural] == ["ruleCount", "playCount", "creepCount"]
    assert all(v.type == "UInt64" and int(v.start) > 0 for v in structural)
    arrays = [v for v in fmu.description.modelVariables if v.dimensions]
    assert len(arrays) == 10
    for variable in arrays:
        assert variable.shape == (parameters.counts[variable.name.split(".")[0]],)
        assert len(variable.start.split()) == variable.shape[0]


# --- XML, binary, resources and the FMU of FMI 2.0 agree ---------------------------------------


def test_the_variables_are_those_of_fmi_2_with_groups_as_arrays(any_fmu):
    parameters, fmu = any_fmu
    expected = {}
    for v in load_table().of_model(fmu.model, parameters.counts):
        if v.index in (None, 1):
            expected[f"{v.group}.{v.field}" if v.group else v.name] = v
    found = {v.name: v for v in fmu.description.modelVariables}
    time = found.pop("time")
    assert (time.causality, time.valueReference) == ("independent", len(load_table().variables))
    assert list(found) == list(expected)
    types = {"Real": "Float64", "Integer": "UInt64", "Boolean": "Boolean"}
    for name, variable in found.items():
        row = expected[name]
        assert variable.valueReference == row.value_reference
        assert variable.type == types[row.type.base]
        assert variable.declaredType.name == row.type.name
        assert (variable.unit, variable.displayUnit) == (row.type.unit, row.type.displayUnit)
        assert variable.variability == row.variability
    assert (fmu.directory / "resources" / "parameters.ssv").read_text() == format_ssv(parameters)


def test_the_binary_starts_from_the_xmls_start_values_bit_for_bit(any_fmu):
    """Which FMI 3.0 lets a master read as soon as there is an instance."""
    parameters, fmu = any_fmu
    with Instance(fmu) as instance:
        assert instance.made, instance.messages
        for variable in fmu.description.modelVariables:
            if variable.start is None:
                continue
            starts = [float(text) for text in variable.start.split()]
            values = instance.get(variable.name, len(starts))
            assert struct.pack(f"<{len(starts)}d", *values) == struct.pack(f"<{len(starts)}d", *starts)
            for i, value in enumerate(values, start=1):
                name = variable.name.replace(".", f"[{i}].") if variable.dimensions else variable.name
                assert name not in parameters or parameters[name] == value


@pytest.mark.parametrize("which", MODELS)
def test_initial_unknowns_are_those_of_fmi_2(which, packaged_fmi3, tmp_path):
    name = "all_effects"
    two = package_models(SETS[name], tmp_path)[which].description
    three = packaged_fmi3[name][1][which].description
    references = {v.valueReference for v in three.modelVariables}

    def known(description):
        return {
            u.variable.name: [d.valueReference for d in u.dependencies]
            for u in description.initialUnknowns
        }

    assert known(three) == {
        output: [r for r in found if r in references] for output, found in known(two).items()
    }
    assert [u.dependencies for u in three.outputs] == [[] for _ in two.outputs]


def test_the_terminals_name_variables_that_exist(any_fmu):
    _, fmu = any_fmu
    root = etree.parse(fmu.directory / "terminalsAndIcons" / "terminalsAndIcons.xml").getroot()
    etree.XMLSchema(etree.parse(SCHEMAS / "fmi3TerminalsAndIcons.xsd")).assertValid(root)
    members = [m.get("variableName") for m in root.iter("TerminalMemberVariable")]
    assert members and set(members) <= set(fmu.variables)
    assert (fmu.directory / "terminalsAndIcons" / "icon.png").is_file()
    assert {p.name for p in fmu.directory.iterdir()} == {
        "modelDescription.xml", "binaries", "documentation", "extra", "resources", "sources",
        "terminalsAndIcons",
    }  # fmt: skip


def test_the_page_speaks_of_this_version(any_fmu, controllers):
    for fmu in (any_fmu[1], controllers[1]):
        page = (fmu.directory / "documentation" / "index.html").read_text(encoding="utf-8")
        assert "fmi3DoStep" in page and "intermediate update" in page
        assert "fmi2" not in page and "FMI 2" not in page
    page = (controllers[0].directory / "documentation" / "index.html").read_text(encoding="utf-8")
    assert "fmi2DoStep" in page and "fmi3" not in page


def test_platforms_are_tuples(any_fmu):
    _, fmu = any_fmu
    found = {p.name for p in (fmu.directory / "binaries").iterdir()}
    assert fmpy.platform_tuple in found
    assert found <= {of_fmi3 for _, of_fmi3 in PLATFORMS.values()}
    if len(found) > 1:  # else this build was for the host alone
        assert found == {
            "x86_64-linux", "aarch64-linux", "x86_64-windows", "x86-windows", "aarch64-windows",
            "x86_64-darwin", "aarch64-darwin",
        }  # fmt: skip


# --- sources -----------------------------------------------------------------------------------


def test_the_sources_say_how_they_are_built(any_fmu):
    _, fmu = any_fmu
    there = sorted(p.name for p in (fmu.directory / "sources").glob("*.c"))
    for configuration in read_build_description(fmu.directory):
        assert configuration.modelIdentifier == fmu.identifier
        assert [sorted(s.sourceFiles) for s in configuration.sourceFileSets] == [there]
    assert root_of(fmu).find("CoSimulation/SourceFiles") is None


@pytest.mark.parametrize("which", MODELS)
def test_the_sources_compile_to_the_same_bits_and_fmi_3_alone(which, packaged_fmi3, tmp_path):
    """With warnings as errors; no header of FMI 2.0 is needed."""
    fmu = packaged_fmi3["all_effects"][1][which]
    sources = fmu.directory / "sources"
    library = tmp_path / "own.so"
    warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wno-c11-extensions"]
    command = [
        *compiler(), "-std=c99", "-O1", "-ffp-contract=off", *warnings,
        "-shared", "-fPIC", "-I", str(sources), "-isystem", str(HEADERS),
        *map(str, sources.glob("*.c")), "-lm", "-ldl", "-o", str(library),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "fmi2" not in "".join(p.read_text(encoding="utf-8") for p in sources.glob("IT2*"))
    assert declared_functions_of_fmi3() <= exported(library)
    assert not exported(library) & declared_functions()
    signal, read = swing(which), []
    for place in (None, library):
        with Instance(fmu, library=place) as instance:
            read.append(instance.initialize().run(signal))
    assert read[0] == read[1]


def test_fmpy_compiles_the_sources(packaged_fmi3, tmp_path, monkeypatch):
    fmu = packaged_fmi3["table_1"][1]["plant"]
    folder = tmp_path / "fmu"
    fmpy.extract(str(fmu.path), str(folder))
    (tmp_path / "build").mkdir()
    for name, value in environment_for_cmake().items():
        monkeypatch.setenv(name, value)
    binary = (
        folder / "binaries" / fmpy.platform_tuple / f"{fmu.identifier}{fmpy.sharedLibraryExtension}"
    )
    binary.unlink()
    build_platform_binary(folder, build_dir=tmp_path / "build")
    assert binary.is_file()
    assert exported(binary) == declared_functions_of_fmi3()


# --- the controller and the command ------------------------------------------------------------


def test_the_controller_gives_the_bits_of_that_of_fmi_2(controllers):
    two, three = controllers
    start = {"proportionalGain": 2e5, "integralGain": 1e9}
    error = 1e-6 * np.sin(np.arange(200) / 7.0)
    with Instance2(two) as a, Instance(three) as b:
        a.initialize(start)
        b.initialize(start)
        for k, value in enumerate(error.tolist()):
            for instance in (a, b):
                instance.assign({"reference": value})
                instance.step(k * TS, TS)
            assert a.get("voltage") == b.get("voltage")
            assert a.get("limited") == b.get("limited")
        assert b.status_of(b.fmu.getDirectionalDerivative, [3], [0], [1.0]) == ERROR
    with Instance(three) as instance:
        assert instance.status_of(instance.fmu.enterConfigurationMode) == ERROR


CHOICES = [([], (2, 3)), (["--fmi", "2"], (2,)), (["--fmi", "3"], (3,))]


@pytest.mark.parametrize(("arguments", "versions"), CHOICES)
def test_the_commands_write_both_versions_or_one(arguments, versions, tmp_path):
    assert main(["build", "-o", str(tmp_path / "a"), "--quiet", *arguments]) == 0
    path = tmp_path / "a" / "parameters.ssv"
    assert main(["package", str(path), "-o", str(tmp_path / "b"), "--quiet", *arguments]) == 0
    expected = {"parameters.ssv"}
    for version in versions:
        expected |= {f"{name}{'_fmi3' * (version == 3)}.fmu" for name in ("IT2Plant", "IT2Inverse")}
    for folder in ("a", "b"):
        assert {p.name for p in (tmp_path / folder).iterdir()} == expected
    for name in expected - {"parameters.ssv"}:
        found = fmpy.read_model_description(str(tmp_path / "a" / name))
        assert found.fmiVersion == ("3.0" if "_fmi3" in name else "2.0")
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_the_command_knows_no_other_version(tmp_path, capsys):
    with pytest.raises(SystemExit) as caught:
        main(["build", "-o", str(tmp_path), "--fmi", "1"])
    assert caught.value.code == 2
    assert "invalid choice: 1 (choose from 2, 3)" in capsys.readouterr().err


# --- every flag is a promise that is kept ------------------------------------------------------


def start_of(fmu: Unpacked) -> dict[str, float]:
    return {INPUT[fmu.model]: CALM[fmu.model], "initialDisplacement": CALM["inverse"]}


def library_stands_alone(fmu: Unpacked) -> None:
    with Instance(fmu) as instance:
        assert instance.initialize().run([CALM[fmu.model]])


def many_instances(fmu: Unpacked) -> None:
    signal = swing(fmu.model, 30)
    with Instance(fmu) as alone:
        expected = alone.initialize().run(signal)
    with Instance(fmu) as one, Instance(fmu) as other:
        other.initialize({"initialDisplacement": 3e-6}).run(signal)
        assert one.initialize().run(signal) == expected


def state_returns(fmu: Unpacked) -> None:
    """From anywhere, and with the lengths of arrays in it."""
    signal = swing(fmu.model, 60)
    with Instance(fmu) as instance:
        fresh = instance.fmu.getFMUState()
        instance.configure({"playCount": 2})
        instance.assign({"play.weight": [0.1, 0.05], "play.threshold": [1.0, 2.0]})
        instance.initialize().run(signal[:30])
        state = instance.fmu.getFMUState()
        expected = instance.run(signal[30:], first=30)
        instance.fmu.setFMUState(fresh)
        assert instance.get("playCount") == 1
        instance.fmu.setFMUState(state)
        assert instance.get("play.weight", 2) == [0.1, 0.05]
        assert instance.run(signal[30:], first=30) == expected
        for s in (fresh, state):
            instance.fmu.freeFMUState(s)


def state_survives_as_bytes(fmu: Unpacked) -> None:
    signal = swing(fmu.model, 60)
    with Instance(fmu) as one, Instance(fmu) as other:
        one.configure({"playCount": 3})
        one.initialize({"play.threshold": [1.0, 2.0, 3.0]}).run(signal[:30])
        blob = one.fmu.serializeFMUState(one.fmu.getFMUState())
        expected = one.run(signal[30:], first=30)
        other.fmu.setFMUState(other.fmu.deserializeFMUState(blob))
        assert other.run(signal[30:], first=30) == expected
        damaged = bytearray(blob)
        damaged[len(blob) // 2] ^= 1
        assert one.status_of(one.fmu.deserializeFMUState, bytes(damaged)) == ERROR


def slope_by_input(fmu: Unpacked, instance: Instance) -> float:
    """Return the derivative of the output by the input of a tick, as a difference."""
    name, calm, read = INPUT[fmu.model], CALM[fmu.model], []
    state = instance.fmu.getFMUState()
    for value in calm * np.array([1 - 1e-4, 1 + 1e-4, 1.0]):
        instance.fmu.setFMUState(state)
        instance.assign({name: float(value)})
        instance.step(0.0, TS)
        read.append(instance.get(OUTPUT[fmu.model]))
    return (read[1] - read[0]) / (2e-4 * calm)


def directional_derivatives(fmu: Unpacked) -> None:
    with Instance(fmu) as instance:
        slope = slope_by_input(fmu, instance.initialize(start_of(fmu)))
        of, by = [instance.reference(OUTPUT[fmu.model])], [instance.reference(INPUT[fmu.model])]
        (found,) = instance.fmu.getDirectionalDerivative(of, by, [2.0])
        assert found == pytest.approx(2.0 * slope, rel=1e-6)


def adjoint_derivatives(fmu: Unpacked) -> None:
    with Instance(fmu) as instance:
        slope = slope_by_input(fmu, instance.initialize(start_of(fmu)))
        of, by = [instance.reference(OUTPUT[fmu.model])], [instance.reference(INPUT[fmu.model])]
        (found,) = instance.fmu.getAdjointDerivative(of, by, [3.0])
        assert found == pytest.approx(3.0 * slope, rel=1e-6)


def no_dependencies_of_elements(fmu: Unpacked) -> None:
    with Instance(fmu) as instance:
        call, count = instance.fmu.fmi3GetNumberOfVariableDependencies, ctypes.c_size_t()
        arguments = instance.fmu.component, instance.reference(OUTPUT[fmu.model]), ctypes.byref(count)
        assert instance.status_of(call, *arguments) == ERROR


def any_step_size(fmu: Unpacked) -> None:
    read = []
    for cuts in ([3.3, 0.2, 6.5], [10.0]):
        with Instance(fmu) as instance:
            instance.initialize(start_of(fmu))
            time = 0.0
            for cut in cuts:
                _, _, time = instance.step(time, cut * TS)
            read.append(instance.get(OUTPUT[fmu.model]))
    assert read[0] == read[1]


def ticks_are_at_its_own_step(fmu: Unpacked) -> None:
    times = []
    with Instance(fmu, update=lambda instance, time: times.append(time)) as instance:
        instance.initialize().step(0.0, 10 * TS)
        step = float(fmu.description.coSimulation.fixedInternalStepSize)
        assert step == instance.get("sampleTime")
        np.testing.assert_allclose(times, step * np.arange(1, 10), rtol=1e-14)


def no_output_derivatives(fmu: Unpacked) -> None:
    with Instance(fmu) as instance:
        instance.initialize().step(0.0, TS)
        reference = [instance.reference(OUTPUT[fmu.model])]
        assert instance.status_of(instance.fmu.getOutputDerivatives, reference, [1]) == ERROR


def inputs_may_jump(fmu: Unpacked) -> None:
    """No smoothness is asked for: from tick to tick an input is what it was set to."""
    jumps = CALM[fmu.model] * (1.0 + 0.1 * (np.arange(10) % 2))

    def update(instance, time):
        instance.assign({INPUT[fmu.model]: float(jumps[round(time / TS)])})

    with Instance(fmu) as often, Instance(fmu, update=update) as once:
        expected = often.initialize(start_of(fmu)).run(jumps)[-1]
        once.initialize({**start_of(fmu), INPUT[fmu.model]: float(jumps[0])}).step(0.0, 10 * TS)
        assert once.get(OUTPUT[fmu.model]) == expected


def updates_are_provided(fmu: Unpacked) -> None:
    times = []
    with Instance(fmu, update=lambda instance, time: times.append(time)) as instance:
        instance.initialize().step(0.0, 2.5 * TS)
    np.testing.assert_allclose(times, [TS, 2 * TS], rtol=1e-14)


def steps_end_early(fmu: Unpacked) -> None:
    beyond = {"plant": 140.0, "inverse": 20e-6}[fmu.model]
    with Instance(fmu, early=True) as instance:
        instance.initialize({**start_of(fmu), INPUT[fmu.model]: beyond})
        _, early, time = instance.step(0.0, 30 * TS)
        assert early and time == pytest.approx(TS, rel=1e-14)


def steps_end_where_an_update_wants_it(fmu: Unpacked) -> None:
    with Instance(fmu, early=True, update=lambda instance, time: time) as instance:
        _, early, time = instance.initialize(start_of(fmu)).step(0.0, 30 * TS)
        assert early and time == pytest.approx(TS, rel=1e-14)


def no_event_mode(fmu: Unpacked) -> None:
    with Instance(fmu, events=True) as instance:
        assert not instance.made
    with Instance(fmu) as instance:
        call = instance.fmu.fmi3EnterEventMode
        assert instance.status_of(call, instance.initialize().fmu.component) == ERROR


def no_discrete_states(fmu: Unpacked) -> None:
    with Instance(fmu) as instance:
        call = instance.fmu.fmi3EvaluateDiscreteStates
        assert instance.status_of(call, instance.initialize().fmu.component) == ERROR


PROMISES = {
    ("needsExecutionTool", "false"): library_stands_alone,
    ("canBeInstantiatedOnlyOncePerProcess", "false"): many_instances,
    ("canGetAndSetFMUState", "true"): state_returns,
    ("canSerializeFMUState", "true"): state_survives_as_bytes,
    ("providesDirectionalDerivatives", "true"): directional_derivatives,
    ("providesAdjointDerivatives", "true"): adjoint_derivatives,
    ("providesPerElementDependencies", "false"): no_dependencies_of_elements,
    ("canHandleVariableCommunicationStepSize", "true"): any_step_size,
    ("fixedInternalStepSize", "0.0001"): ticks_are_at_its_own_step,
    ("maxOutputDerivativeOrder", "0"): no_output_derivatives,
    ("recommendedIntermediateInputSmoothness", "0"): inputs_may_jump,
    ("providesIntermediateUpdate", "true"): updates_are_provided,
    ("mightReturnEarlyFromDoStep", "true"): steps_end_early,
    ("canReturnEarlyAfterIntermediateUpdate", "true"): steps_end_where_an_update_wants_it,
    ("hasEventMode", "false"): no_event_mode,
    ("providesEvaluateDiscreteStates", "false"): no_discrete_states,
}


@pytest.mark.parametrize("which", MODELS)
def test_every_flag_is_a_promise_that_is_tried(which, packaged_fmi3):
    flags = root_of(packaged_fmi3["table_1"][1][which]).find("CoSimulation").attrib
    assert {(n, text) for n, text in flags.items() if n != "modelIdentifier"} == set(PROMISES)


@pytest.mark.parametrize("which", MODELS)
@pytest.mark.parametrize("flag", PROMISES, ids=lambda flag: flag[0])
def test_the_promise_is_kept(which, flag, packaged_fmi3):
    PROMISES[flag](packaged_fmi3["table_1"][1][which])
