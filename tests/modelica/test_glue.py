"""The C that a tool compiles for `Blocks.Plant` and `Blocks.Inverse`, called as the library says.

The `external` clauses are read, and turned into C functions that call what they name, with the
arguments and the types that they declare: where these differ from the C, the compiler refuses or the
numbers are wrong. The program around them is built with AddressSanitizer.
"""

import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from conftest import TS, package_models
from effects import surroundings, with_effects
from library import CLASSES, LIBRARY, values_of
from refused import BAD, parameters_of

from it2hys.cosimulation.simulation import simulate
from it2hys.export.modelica import C_SOURCES
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import ParameterSet, table_1

COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
HOST = Path(__file__).parent / "glue"
FLAGS = ["-std=c99", "-g", "-Wall", "-Wextra", "-Wno-unused-function", "-Werror", "-ffp-contract=off"]
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
C_TYPES = {"Real": "double", "Integer": "int", "Boolean": "int", "String": "const char *"}
CLAUSE = re.compile(
    r'(?:impure )?function (?P<name>\w+) "(?P<body>[^;]*;.*?)external\s*"C"\s*'
    r"(?:(?P<result>\w+) = )?(?P<c_name>\w+)\((?P<arguments>.*?)\)\s*"
    r"annotation \((?P<annotation>.*?)\);",
    re.DOTALL,
)
DECLARED = re.compile(r"^\s*(input|output) ([\w.]+) (\w+)(\[:\])?", re.MULTILINE)
INTERNAL = {n: f for n, f in CLASSES.items() if n.startswith("IT2Hysteresis.Internal.")}


def external_functions() -> Iterator[tuple[str, re.Match]]:
    """Yield a name and the clause of every external function of the library."""
    for name, file in INTERNAL.items():
        for clause in CLAUSE.finditer(file.read_text(encoding="utf-8")):
            short = name.rsplit(".", 1)[-1]
            own = clause["name"]
            yield (short if own == short else f"{short}_{own}"), clause


def c_type(way: str, modelica: str, array: str) -> str:
    """Return the C type that the standard maps an argument of an external function to."""
    base = modelica.rsplit(".", 1)[-1]
    if base.endswith("Object"):
        return "void *"
    kind = C_TYPES.get(base, "double" if modelica.startswith("Modelica.Units.SI.") else None)
    assert kind, f"{modelica} has no C type here"
    return f"const {kind} *" if array else f"{kind} *" if way == "output" else kind


def c_call(name: str, clause: re.Match) -> str:
    """Return a C function that calls an external function as its clause does.

    Its arguments are those of the Modelica function in the order of their declarations, a vector
    followed by its size. The pointer inside has exactly the types that the clause declares.
    """
    found = DECLARED.findall(clause["body"])
    declared = {n: c_type(way, t, array) for way, t, n, array in found}
    vectors = {n for _, _, n, array in found if array}
    result = clause["result"]
    parameters = [
        f"{kind} {n}" + (f", size_t {n}_size" if n in vectors else "")
        for n, kind in declared.items()
        if n != result
    ]
    arguments = re.findall(r"size\((\w+), 1\)|(\w+)", clause["arguments"])
    types = ", ".join("size_t" if size else declared[n] for size, n in arguments)
    values = ", ".join(f"{size}_size" if size else n for size, n in arguments)
    unused = "".join(f" (void){n}_size;" for n in declared if n in vectors)
    returned = declared[result] if result else "void"
    return (
        f"static {returned} {name}({', '.join(parameters)})\n{{\n"
        f"    {returned} (*const function)({types}) = {clause['c_name']};\n   {unused}\n"
        f"    {'return ' if result else ''}function({values});\n}}"
    )


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Compile the host program; returns the binary."""
    if not COMPILER:
        pytest.skip("no C compiler (cc, gcc, clang) on the path")
    directory = tmp_path_factory.mktemp("glue")
    calls = [c_call(name, clause) for name, clause in external_functions()]
    (directory / "external.h").write_text("\n\n".join([*calls, ""]))
    binary = directory / "host"
    sources = LIBRARY / C_SOURCES
    command = [COMPILER, *FLAGS, *SANITIZE, f"-I{sources}", f"-I{HOST}", f"-I{directory}"]
    done = subprocess.run(
        [*command, str(HOST / "glue_host.c"), "-o", str(binary), "-lm"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return binary


def new(number: int, kind: str, parameters: ParameterSet, **changes: float) -> str:
    """Return the line that constructs an object; changes are made behind the set's own checks."""
    numbers = values_of({**parameters, **changes})
    return f"new {number} {kind} {len(numbers)} {' '.join(map(repr, numbers))}"


def tick(number: int, k: int, signal: float, force: float = 0.0, temperature: float = 293.15) -> str:
    """Return the line that makes tick k."""
    return f"tick {number} {k * TS!r} {float(signal)!r} {float(force)!r} {float(temperature)!r}"


def talk(host: Path, *lines: str) -> list[str]:
    """Return the host's answers; leaks and errors in memory fail here."""
    done = subprocess.run([host], input="\n".join(lines), capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def outputs(answers: list[str]) -> np.ndarray:
    """Return the numbers of the answers to ticks, three columns: the last is the flag."""
    return np.array([[float(v) for v in a.split()] for a in answers if a != "ok"])


# --- the clauses -----------------------------------------------------------------------------------


def test_every_external_function_includes_the_one_header():
    found = dict(external_functions())
    assert sorted(found) == sorted(
        f"{kind}{function}"
        for kind, functions in (
            ("Plant", ("Object_constructor", "Object_destructor")),
            ("Inverse", ("Object_constructor", "Object_destructor")),
            ("plant", ("Tick",)),
            ("inverse", ("Tick",)),
        )
        for function in functions
    )
    for clause in found.values():
        assert '#include \\"IT2Hysteresis.h\\"' in clause["annotation"]
        assert f'IncludeDirectory="modelica://IT2Hysteresis/{C_SOURCES}"' in clause["annotation"]
    elsewhere = [n for n, f in CLASSES.items() if "external" in f.read_text() and n not in INTERNAL]
    assert not [n for n in elsewhere if re.search(r'external\s*"C"', CLASSES[n].read_text())]


@pytest.mark.parametrize("block", ["Plant", "Inverse"])
def test_blocks_hand_over_the_parameters_by_the_generated_record(block):
    text = CLASSES[f"IT2Hysteresis.Blocks.{block}"].read_text(encoding="utf-8")
    constructor = CLASSES[f"IT2Hysteresis.Internal.{block}Object"].read_text(encoding="utf-8")
    call = re.search(rf"{block}Object\((.*)\)\s*\"The FMU\"", text)[1]
    assert call.strip() == "all.vector, getInstanceName()"
    handed = "(parameters=parameters, initialDisplacement=initialDisplacement)"
    assert f"IT2Hysteresis.Internal.Values all{handed}" in text
    assert re.findall(r"input ([\w.]+) (\w+)\[:\]", constructor) == [("Real", "values")]


# --- what they compute -------------------------------------------------------------------------------


@pytest.mark.parametrize("effects", [(), *((e,) for e in EFFECTS), tuple(EFFECTS)], ids="-".join)
def test_the_plant_is_the_c_core_bit_for_bit(host, effects):
    parameters = with_effects(effects, seed=5)
    n = 120
    voltage = 52.5 + 42.0 * np.sin(250.0 * TS * np.arange(n))
    force, temperature = surroundings(n)
    ticks = [tick(0, k, voltage[k], force[k], temperature[k]) for k in range(n)]
    answers = talk(host, new(0, "plant", parameters), *ticks, "free 0")
    expected = compiled.chain_free_run(parameters, voltage, force, temperature)
    got = outputs([a for a in answers if not a.startswith("warning")])
    assert got[:, :2] == pytest.approx(np.column_stack(expected), rel=1e-12, abs=1e-18)
    outside = compiled.chain_out_of_range(parameters, voltage, force, temperature)
    assert np.array_equal(got[:, 2] != 0.0, outside)


def test_beyond_its_range_the_plant_is_the_c_core_and_says_so(host):
    voltage = np.array(
        [*np.linspace(50.0, 400.0, 60), *np.linspace(400.0, -300.0, 60), *np.full(60, 50.0)]
    )
    ticks = [tick(0, k, v) for k, v in enumerate(voltage)]
    answers = talk(host, new(0, "plant", table_1(), initialDisplacement=-20e-6), *ticks, "free 0")
    got = outputs([a for a in answers if not a.startswith("warning")])
    begun = table_1().replace(initialDisplacement=-20e-6)
    assert got[:, 0] == pytest.approx(compiled.chain_free_run(begun, voltage)[0], rel=1e-12)
    outside = compiled.chain_out_of_range(begun, voltage)
    assert np.array_equal(got[:, 2] != 0.0, outside)
    assert outside.any() and not outside.all()


@pytest.mark.parametrize("effects", [(), tuple(EFFECTS)], ids="-".join)
def test_the_inverse_is_the_c_core(host, effects):
    parameters = with_effects(effects, seed=5)
    n = 120
    reference = 5e-6 + 2e-6 * np.sin(250.0 * TS * np.arange(n))
    ticks = [tick(1, k, reference[k]) for k in range(n)]
    answers = talk(host, new(1, "inverse", parameters), *ticks, "free 1")
    voltage, saturated = compiled.chain_inverse_run(parameters, reference)
    got = outputs([a for a in answers if not a.startswith("warning")])
    assert got[:, 0] == pytest.approx(voltage, rel=1e-12)
    assert np.array_equal(got[:, 2] != 0.0, saturated)


@pytest.mark.parametrize("kind", ["plant", "inverse"])
def test_what_modelica_gets_is_what_the_packaged_fmu_gives(host, tmp_path, kind):
    parameters = with_effects(tuple(EFFECTS), seed=8)
    fmu = package_models(parameters, tmp_path)[kind].path
    n = 120
    wave = np.sin(250.0 * TS * np.arange(n))
    name, signal = ("voltage", 50 + 40 * wave) if kind == "plant" else ("reference", 5e-6 + 2e-6 * wave)
    force, temperature = surroundings(n)
    ticks = [tick(0, k, signal[k], force[k], temperature[k]) for k in range(n)]
    answers = talk(host, new(0, kind, parameters), *ticks, "free 0")
    outside, messages = simulate(fmu, {name: signal, "force": force, "temperature": temperature})
    got = outputs([a for a in answers if not a.startswith("warning")])
    plant = kind == "plant"
    columns = ("displacement", "measured", "outOfRange") if plant else ("voltage", "saturated")
    expected = np.column_stack([outside[c] for c in columns])
    got = got if plant else got[:, [0, 2]]
    assert got == pytest.approx(expected, rel=1e-9, abs=1e-15)
    warnings = [a for a in answers if a.startswith("warning")]
    assert len(warnings) == len(messages)


def test_instances_live_beside_each_other(host):
    stage, other = with_effects(("play", "creep"), seed=1), table_1()
    voltage = np.linspace(10.0, 80.0, 30)
    lines = [new(0, "plant", stage), new(1, "plant", other), new(2, "inverse", other)]
    for k, v in enumerate(voltage):
        lines += [tick(0, k, v), tick(2, k, 1e-7 * v), tick(1, k, v)]
    answers = talk(host, *lines, "free 1", "free 0", "free 2")
    got = outputs(answers).reshape(len(voltage), 3, 3)
    assert got[:, 0, 0] == pytest.approx(compiled.chain_free_run(stage, voltage)[0], rel=1e-12)
    assert got[:, 2, 0] == pytest.approx(compiled.chain_free_run(other, voltage)[0], rel=1e-12)
    assert got[:, 1, 0] == pytest.approx(
        compiled.chain_inverse_run(other, 1e-7 * voltage)[0], rel=1e-12
    )


def test_a_tick_that_is_evaluated_again_counts_once_and_last(host):
    parameters = with_effects(tuple(EFFECTS), seed=5)
    voltage = 40.0 + np.arange(20.0)
    lines = [new(0, "plant", parameters)]
    for k, v in enumerate(voltage):
        lines += [tick(0, k, v + 7.0), tick(0, k, v), tick(0, k, v)]
    got = outputs([a for a in talk(host, *lines, "free 0") if not a.startswith("warning")])
    got = got.reshape(len(voltage), 3, 3)
    assert np.array_equal(got[:, 1], got[:, 2])
    expected = np.column_stack(compiled.chain_free_run(parameters, voltage))
    assert got[:, 2, :2] == pytest.approx(expected, rel=1e-12, abs=1e-18)


@pytest.mark.parametrize("first", [-3, 17, 100000])
def test_a_simulation_may_start_at_any_time(host, first):
    parameters = with_effects(tuple(EFFECTS), seed=5)
    voltage = 40.0 + np.arange(20.0)
    ticks = [tick(0, first + k, v) for k, v in enumerate(voltage)]
    got = outputs(
        [a for a in talk(host, new(0, "plant", parameters), *ticks, "free 0") if "w" not in a]
    )
    expected = np.column_stack(compiled.chain_free_run(parameters, voltage, first_tick=first))
    assert got[:, :2] == pytest.approx(expected, rel=1e-12, abs=1e-18)


# --- what goes wrong -----------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["plant", "inverse"])
@pytest.mark.parametrize("name", BAD)
def test_parameters_that_are_refused_stop_the_constructor_with_the_message(host, kind, name):
    changes, message = BAD[name]
    # a tool calls the destructor all the same, without an object
    answer, freed = talk(host, new(0, kind, parameters_of(changes), **changes), "free 0")
    assert freed == "ok"
    assert answer == f"error: M.stage (IT2{kind.capitalize()}): {message}."


def test_too_many_rules_are_refused(host):
    # the last of the three rules once more, until there are 17 of them
    values = {**table_1(), "ruleCount": 17}
    for i in range(4, 18):
        values |= {n.replace("[3]", f"[{i}]"): v for n, v in table_1().items() if "rule[3]" in n}
    (answer,) = talk(host, new(0, "plant", values))
    assert "ruleCount is 17; it must be 1 to 16" in answer


def test_a_library_of_another_version_is_refused(host):
    line = new(0, "plant", table_1()).split()
    for missing in (1, -1):
        count = int(line[3]) - missing
        other = [*line[:3], str(count), *[*line[4:], "0.0"][:count]]
        (answer,) = talk(host, " ".join(other))
        assert "the C sources have" in answer and "different versions" in answer


def test_a_step_that_fails_stops_with_the_message_and_leaves_the_state(host):
    parameters = table_1().replace(**{"playCount": 1, "play[1].threshold": 0.0, "play[1].weight": 1.0})
    lines = [tick(0, 0, 50.0), tick(0, 1, 1e308), tick(0, 1, float("nan")), tick(0, 1, 60.0)]
    first, *errors, last = talk(host, new(0, "plant", parameters), *lines, "free 0")[1:-1]
    errors = [e for e in errors if not e.startswith("warning")]
    assert len(errors) == 2
    assert errors[0].startswith(
        "error: M.stage (IT2Plant): at 0.0001 s: the displacement is no longer finite"
    )
    assert "voltage must be a finite number" in errors[1]
    expected = compiled.chain_free_run(parameters, np.array([50.0, 60.0]))[0]
    assert outputs([first, last])[:, 0] == pytest.approx(expected, rel=1e-12)


def test_an_input_out_of_range_warns_once(host):
    voltages = [10.0, 151.0, 152.0, 10.0, 153.0]
    lines = [tick(0, k, v) for k, v in enumerate(voltages) for _ in range(2)]  # each event twice
    answers = talk(host, new(0, "plant", table_1()), *lines, "free 0")
    (warning,) = [a for a in answers if a.startswith("warning")]
    assert "M.stage (IT2Plant): the voltage left voltageMin..voltageMax, 0 to 110 V" in warning


def test_the_inverse_warns_of_a_reference_out_of_reach(host):
    answers = talk(host, new(0, "inverse", table_1()), *(tick(0, k, 17e-6) for k in range(5)), "free 0")
    reach = [a for a in answers if "is outside displacementMin..displacementMax" in a]
    assert len(reach) == 1
    assert outputs([a for a in answers if not a.startswith("warning")])[:, 2].all()
