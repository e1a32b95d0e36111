"""The library in rumoca: every class is instantiated, and the numbers are those of the C core.

rumoca has no Modelica Standard Library; `stub` stands in for what the library uses of it. rumoca
loads packages whose names stand in the source, hence the import in `PREAMBLE`. Nor does it call
external C: `overlaid` puts records and Modelica functions of the same names and arguments in the
place of those of `Internal`. That checks how the blocks are wired and sampled, not the C.

It also runs an initial algorithm again at every event (SlowCreep: 14 ms a tick instead of 0.4), and
unrolls the loops that slope and contraction are sought by (a plant of 16 rules: 8.4 s instead of 0.1).
So the check of a parameter set, and what it alone needs, is left out of the overlay unless a test asks
for it: `checked`.
"""

import math
import re
import shutil
import tempfile
from collections import Counter
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from compared import PACKAGE
from conftest import make_set
from effects import with_effects
from hypothesis import given, settings
from hypothesis import strategies as st
from library import (
    CLASSES,
    EXAMPLES,
    FMU_INVERSE,
    FMU_PLANT,
    INVERSE,
    LIBRARY,
    PLANT,
    PREAMBLE,
    kind,
    model,
    values_of,
)
from units import faults

from it2hys.export.modelica import format_record
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS, Chain
from it2hys.model.parameters import ParameterSet, table_1
from it2hys.model.variables import load_table
from it2hys.stand.excitations import identification, time_grid, tracking_reference

rumoca = pytest.importorskip("rumoca", reason="rumoca, the Modelica compiler, is not installed")

STUB = LIBRARY.parents[1] / "tests" / "modelica" / "stub"
TABLE_1 = "IT2Hysteresis.Parameters.Table1"
RTOL = 1e-12

# how a block or a model is instantiated in a model M
WRAPPERS = {
    "block": "block M {pre} extends {name}; {rest} end M;",
    "model": "model M {pre} extends {name}; end M;",
}
CENTRES = "p.ruleSigmaLower, p.ruleSigmaUpper, p.ruleCentre"
RULES = f"{CENTRES}, p.ruleQ1, p.ruleQ2, p.ruleQ3"
FUNCTIONS = "IT2Hysteresis.Functions"
INTERFACES = "IT2Hysteresis.Interfaces"
# what is missing to instantiate a partial block
REST = {
    f"{INTERFACES}.PartialPlant": "equation displacement = voltage; measured = voltage; "
    "outOfRange = false;",
    f"{INTERFACES}.PartialInverse": "equation voltage = reference; saturated = false;",
}
INPUT = re.compile(r"^  input (?P<type>[\w.]+) (?P<name>\w+)(?P<size>\[[^\]]*\])?", re.MULTILINE)


def construct(name: str) -> str:
    """Return the construction of an external object, in the overlay."""
    return f"{name}({{0.0}})"


def call(name: str) -> str:
    """Return a call of a function with arguments of the declared types and some sizes."""
    arguments = []
    for declared in INPUT.finditer(CLASSES[name].read_text(encoding="utf-8")):
        if declared["type"].endswith("Object"):
            arguments.append(construct(declared["type"]))
            continue
        if declared["type"] == "String":
            arguments.append('"M"')
            continue
        value = "1" if declared["type"] == "Integer" else "0.5"
        size = declared["size"] and (re.search(r"\d+(?=\]$)", declared["size"]) or ["3"])[0]
        arguments.append(f"fill({value}, {size})" if size else value)
    return f"{name}({', '.join(arguments)})"


def use(name: str) -> str:
    """Return what makes a model call a function; one without outputs checks at the initialization."""
    if re.search(r"^  output ", CLASSES[name].read_text(encoding="utf-8"), re.MULTILINE):
        return f"Real y = sum({{{call(name)}}});"
    return f"initial algorithm {call(name)};"


DECLARED = re.compile(r"^ *(input|output) ([\w.]+ \w+)((?:\[:\])?)", re.MULTILINE)
EXTERNAL = re.compile(r'external"C".*?;\n', re.DOTALL)
#: What the overlaid tick functions compute: every argument has a digit of its own.
TICKS = {
    "plantTick": "displacement := 1e-7*voltage + 1e-3*t; measured := 1e-9*force + 1e-12*temperature; "
    "outOfRange := t > 5e-4;",
    "inverseTick": "voltage := 1e7*reference + t + 1e-3*force + 1e-6*temperature; "
    "saturated := t > 5e-4;",
}


def overlay_of(file: Path) -> str:
    """Return what stands for a class with external C, with the same inputs and outputs."""
    text, name = file.read_text(encoding="utf-8"), file.stem
    if name in TICKS:
        text = text.replace("impure function", "function")
        return EXTERNAL.sub(f"algorithm {TICKS[name]}\n", text)
    constructor = text[text.index("function constructor") : text.index("end constructor")]
    fields = [
        f"parameter {what}{size};"
        for way, what, size in DECLARED.findall(constructor)
        if way == "input" and what != "String name"
    ]
    return f'within IT2Hysteresis.Internal;\nrecord {name} "overlay" {" ".join(fields)} end {name};\n'


#: The check of a parameter set, in the blocks in pure Modelica, and what it alone needs.
CHECK = re.compile(
    r"initial algorithm\n  IT2Hysteresis.Internal.checkBounds.*?(?=^equation$)"
    r"|  final parameter Real (?:leastSlope|contraction)\[2\]=.*?;\n"
    r"|  IT2Hysteresis.Internal.Values all\(.*?;\n",
    re.M | re.S,
)


@cache
def overlaid(checked: bool) -> tempfile.TemporaryDirectory:
    """Return a directory with the library and its overlay; it lasts as long as the tests."""
    directory = tempfile.TemporaryDirectory()
    root = Path(directory.name)
    shutil.copytree(LIBRARY, root / LIBRARY.name, ignore=shutil.ignore_patterns("Resources"))
    shutil.copytree(PACKAGE.parent, root / PACKAGE.parent.name)
    for file in (root / LIBRARY.name / "Internal").glob("*.mo"):
        if 'external"C"' in file.read_text(encoding="utf-8"):
            file.write_text(overlay_of(file), encoding="utf-8")
    for file in (root / LIBRARY.name / "Blocks").glob("*.mo"):
        # rumoca knows a block's name in its equations only, not where it declares something
        text = file.read_text(encoding="utf-8")
        file.write_text(text.replace("all.vector, getInstanceName()", "all.vector"), encoding="utf-8")
    for file in (root / LIBRARY.name / "Examples").glob("*.mo"):
        # and where an example has an FMU, the same in pure Modelica
        text = file.read_text(encoding="utf-8")
        text = re.sub(r"\b(IT2Hysteresis\.Blocks)\.(Plant|Inverse)\b", r"\1.PureModelica.\2", text)
        text = TABLE_ON_FILE.sub(f"{INTERNAL_TABLE} measurement", text)
        file.write_text(text, encoding="utf-8")
    if checked:
        # every fourth point of the grids, which rumoca unrolls; whole they are compared with the C core
        for name in (f"{FUNCTIONS}.contraction", f"{FUNCTIONS}.leastSlope"):
            file = root.joinpath(*name.split(".")).with_suffix(".mo")
            text = file.read_text(encoding="utf-8")
            assert "grid=256" in text
            file.write_text(text.replace("grid=256", "grid=64"), encoding="utf-8")
    else:
        for name in (PLANT, INVERSE):
            file = root.joinpath(*name.split(".")).with_suffix(".mo")
            text, found = CHECK.subn("", file.read_text(encoding="utf-8"))
            assert found == 4
            file.write_text(text, encoding="utf-8")
    write_table(root / LIBRARY.name / "Internal")
    return directory


#: A table on a file is external C; what stands for it holds the record's values at the ticks.
TABLE_ON_FILE = re.compile(
    r"Modelica\.Blocks\.Sources\.CombiTimeTable measurement\((?:.|\n)*?LinearSegments\)"
)
INTERNAL_TABLE = "IT2Hysteresis.Internal.RecordedTable"


def write_table(directory: Path) -> None:
    """Write the block that stands for the table of MeasuredRecord into the overlay."""
    rows = np.loadtxt(LIBRARY / "Resources/Data/sine_20Hz.txt", skiprows=3)
    columns = ["{" + ", ".join(f"{v:.9g}" for v in column) + "}" for column in rows.T[1:]]
    (directory / "recordedValue.mo").write_text(
        "within IT2Hysteresis.Internal;\nfunction recordedValue input Integer k; input Integer column; "
        "output Real value; protected constant Real "
        f"voltage[{len(rows)}]={columns[0]}; constant Real displacement[{len(rows)}]={columns[1]}; "
        "algorithm value := if column == 1 then voltage[k] else displacement[k]; end recordedValue;\n",
        encoding="utf-8",
    )
    (directory / "RecordedTable.mo").write_text(
        "within IT2Hysteresis.Internal;\nblock RecordedTable "
        "Modelica.Blocks.Interfaces.RealOutput y[2]; "
        "protected discrete Integer k(start=0, fixed=true); "
        "discrete Real voltage(start=0, fixed=true); discrete Real displacement(start=0, fixed=true); "
        "equation when sample(0, 1e-4) then k = pre(k) + 1; "
        f"voltage = IT2Hysteresis.Internal.recordedValue(min(pre(k) + 1, {len(rows)}), 1); "
        f"displacement = IT2Hysteresis.Internal.recordedValue(min(pre(k) + 1, {len(rows)}), 2); "
        "end when; y[1] = voltage; y[2] = displacement; end RecordedTable;\n",
        encoding="utf-8",
    )
    order = directory / "package.order"
    order.write_text(order.read_text() + "recordedValue\nRecordedTable\n")


def compile_model(source: str, checked: bool = False) -> "rumoca.Model":
    """Compile the model M of a source text; `checked`: it refuses what is no usable parameter set."""
    session = rumoca.Session(roots=[overlaid(checked).name, str(STUB)])
    return session.loads(source, model="M", filename="M.mo")


def run(
    source: str, ticks: int, sample_time: float = 1e-4, checked: bool = False
) -> Callable[[str], np.ndarray]:
    """Simulate the model M; returns a function from a variable to its values at the ticks."""
    result = compile_model(source, checked).simulate(
        t=(0.0, (ticks - 1) * sample_time),
        dt=sample_time,
        config=rumoca.SimConfig(solver="rk-like"),
    )
    # a tick has several rows; the last one is what holds after the event
    rows = np.searchsorted(result.time, (np.arange(ticks) + 0.1) * sample_time) - 1
    return lambda name: np.asarray(result[name])[rows]


def run_from(directory: Path, source: str, name: str) -> np.ndarray:
    """Simulate the model M for three ticks with the library in a directory, as it is: no overlay."""
    session = rumoca.Session(roots=[str(directory), str(STUB)])
    result = session.loads(source, model="M", filename="M.mo").simulate(t=(0.0, 2e-4), dt=1e-4)
    return np.asarray(result[name])


def relative(actual: np.ndarray, expected: np.ndarray) -> float:
    """Return the largest deviation, relative to the largest expected value."""
    return np.max(np.abs(actual - expected)) / np.max(np.abs(expected))


# --- every class -------------------------------------------------------------------------------


CALLED = [name for name in CLASSES if kind(name) == "function"]
PASSIVE = [name for name in CLASSES if kind(name) in ("package", "class", "record")]


@pytest.mark.parametrize("name", [n for n in CLASSES if n not in {*EXAMPLES, *CALLED, *PASSIVE}])
def test_every_block_and_model_is_instantiated_and_balanced(name):
    """The examples are simulated, in test_components."""
    source = WRAPPERS[kind(name)].format(pre=PREAMBLE, name=name, rest=REST.get(name, ""))
    assert compile_model(source, checked=True).structure().is_balanced


def test_every_package_class_and_record_is_instantiated():
    """All in one model: they have no equations."""
    inside = [
        f"package P{k} extends {name}; end P{k};"
        if kind(name) == "package"
        else f"{name} item{k}{f'={construct(name)}' if name.endswith('Object') else ''};"
        for k, name in enumerate(PASSIVE)
    ]
    assert compile_model(model(" ".join(inside)), checked=True).structure().is_balanced
    assert {"package", "class", "record"} == {kind(name) for name in PASSIVE}


def test_every_function_is_called():
    """All in one model, with units; those without outputs check something at the initialization."""
    uses = [use(name).replace("Real y ", f"Real y{k} ") for k, name in enumerate(CALLED)]
    declared = " ".join(text for text in uses if text.startswith("Real"))
    sections = " ".join(text for text in uses if not text.startswith("Real"))
    compiled_model = compile_model(f"model M {PREAMBLE} {declared} {sections} end M;", checked=True)
    assert compiled_model.structure().is_balanced
    flat = compiled_model.to_dict("flat")
    assert set(CALLED) <= set(flat["functions"])
    assert not faults(flat), "units do not fit"


@pytest.mark.parametrize(
    ("which", "block"),
    [("plant", PLANT), ("inverse", INVERSE), ("plant", FMU_PLANT), ("inverse", FMU_INVERSE)],
)
def test_connectors_are_the_variables_of_the_table(which, block):
    source = f"block M {PREAMBLE} extends {block}(useForce=true, useTemperature=true); end M;"
    found = {
        name: (next(iter(entry["causality"])).lower(), entry)
        for name, entry in compile_model(source).to_dict("flat")["variables"].items()
        if entry["causality"] != "Empty" and not name.endswith("Internal")
    }
    expected = {
        v.name: v for v in load_table().variables if v.causality != "parameter" and which in v.models
    }
    assert set(found) == set(expected)
    for name, variable in expected.items():
        causality, entry = found[name]
        assert causality == variable.causality
        assert entry["description"] == variable.description
        if variable.type.base == "Real":
            kind = variable.type
            assert entry["quantity"] == kind.quantity
            assert entry["unit"] == kind.unit
            assert entry["display_unit"] == kind.displayUnit
            assert float(entry["nominal"]["Literal"]["value"].popitem()[1]) == kind.nominal


def test_inputs_that_are_off_have_the_start_values_of_the_table():
    source = (
        f"block M {PREAMBLE} extends {INTERFACES}.PartialChain; "
        "output Real f = forceInternal; output Real T = temperatureInternal; end M;"
    )
    at = run(source, 2)
    start = {v.name: v.start for v in load_table().variables}
    assert at("f")[-1] == start["force"]
    assert at("T")[-1] == start["temperature"]


# --- against the C core --------------------------------------------------------------------------


def test_hysteresis_loop_is_the_free_run_under_22():
    at = run(model("extends IT2Hysteresis.Examples.HysteresisLoop;"), 1200)
    expected = compiled.free_run(table_1().rules, at("plant.voltage"), 0.0)
    assert relative(at("plant.displacement"), expected) < RTOL
    assert np.array_equal(at("plant.measured"), at("plant.displacement"))
    assert relative(at("plant.voltage"), identification(time_grid(0.12, 1e-4))) < RTOL


def test_feedforward_cancels_the_plant():
    at = run(model("extends IT2Hysteresis.Examples.FeedforwardTracking;"), 1000)
    reference = at("inverse.reference")
    previous = np.concatenate([[0.7e-6], reference[:-1]])
    assert relative(at("plant.displacement"), reference) < RTOL
    assert relative(at("inverse.voltage"), compiled.solve(table_1().rules, previous, reference)) < RTOL
    assert relative(reference, tracking_reference(time_grid(0.1, 1e-4))) < RTOL
    assert not at("inverse.saturated").any()


@pytest.mark.parametrize("count", [1, 2, 5, 16])
def test_an_exported_record_runs(count):
    wide = {"voltageMin": -2000.0, "voltageMax": 2000.0}  # the reference is quick
    parameters = make_set(count, count, sampleTime=2e-4, initialDisplacement=1e-6, **wide)
    source = format_record(parameters, "Stage") + model(
        f"parameter Stage p; {INVERSE} inverse(parameters=p); {PLANT} plant(parameters=p);",
        "inverse.reference = 8e-6 + 7.9e-6*sin(300*time)*cos(777*time); "
        "connect(inverse.voltage, plant.voltage);",
    )
    at = run(source, 200, sample_time=2e-4)
    reference = at("inverse.reference")
    voltage = compiled.solve(parameters.rules, np.r_[1e-6, reference[:-1]], reference)
    assert relative(at("inverse.voltage"), voltage) < RTOL
    assert relative(at("plant.displacement"), reference) < RTOL


def test_beyond_reach_the_inverse_aims_at_the_nearest_displacement():
    wide = f"{TABLE_1}(voltageMin=-2000, voltageMax=2000)"
    source = model(
        f"{INVERSE} inverse(parameters={wide});", "inverse.reference = 8e-6 + 14e-6*sin(300*time);"
    )
    at = run(source, 500)
    reference = at("inverse.reference")
    aim = np.clip(reference, 0.0, 16e-6)
    expected = compiled.solve(table_1().rules, np.r_[0.0, aim[:-1]], aim)
    assert relative(at("inverse.voltage"), expected) < RTOL
    assert np.array_equal(at("inverse.saturated").astype(bool), aim != reference)
    assert set(np.sign(reference - aim)) == {-1.0, 0.0, 1.0}


@pytest.mark.parametrize("count", [1, 3])
def test_the_inverse_of_the_fuzzy_system_alone_keeps_to_its_voltages_and_goes_on_from_there(count):
    limits = {"voltageMin": 15.0, "voltageMax": 70.0}
    parameters = make_set(count, count, initialDisplacement=5e-6, **limits)
    signal = "if time < 0.01 then 12e-6*sin(700*time) elseif time < 0.015 then 6e-6 else 5e-6"
    source = format_record(parameters, "Stage") + model(
        f"parameter Stage p; {INVERSE} inverse(parameters=p); {PLANT} plant(parameters=p);",
        f"inverse.reference = {signal}; connect(inverse.voltage, plant.voltage);",
    )
    at = run(source, 300)
    reference, saturated = at("inverse.reference"), at("inverse.saturated").astype(bool)
    voltage, expected = compiled.chain_inverse_run(parameters, reference)
    assert relative(at("inverse.voltage"), voltage) < RTOL
    assert np.array_equal(saturated, expected)
    assert saturated[:100].any() and not saturated[130:150].any() and not saturated[-50:].any()
    assert relative(at("plant.displacement")[~saturated], reference[~saturated]) < RTOL


def test_before_the_first_tick_the_inverse_holds_the_plant():
    source = model(
        f"{INVERSE} inverse(parameters={TABLE_1}(initialDisplacement=3e-6)); Real v;",
        "inverse.reference = 3e-6; v = inverse.voltage;",
    )
    expected = compiled.solve(table_1().rules, 3e-6, 3e-6)
    assert run(source, 3)("v") == pytest.approx(float(expected), rel=RTOL)
    beyond = run(source.replace("=3e-6)", "=3e-6, voltageMax=10)"), 3)("v")
    assert np.array_equal(beyond, [10.0, 10.0, 10.0])


@pytest.mark.parametrize("parameters", [table_1(), make_set(3, 5)], ids=["table_1", "five"])
def test_functions_near_and_far_from_all_centres(parameters):
    distance = [0.0, 5e-6, 16e-6, 1e-4, 1e-3, 1.0, 1e6, 1e130, 1e200]
    previous = np.array([*distance, *(-d for d in distance[1:])])
    n = len(previous)
    points = ", ".join(map(repr, previous.tolist()))
    step = f"{FUNCTIONS}.step({RULES}, yPrevious[i], 50)"
    back = f"{FUNCTIONS}.inverse({RULES}, yPrevious[i], 5e-6)"
    source = format_record(parameters, "Stage") + model(
        f"parameter Stage p; parameter Real yPrevious[{n}] = {{{points}}}; "
        f"Real y[{n}] = {{{step} for i in 1:{n}}}; Real x[{n}] = {{{back} for i in 1:{n}}};"
    )
    at = run(source, 2)
    y = np.array([at(f"y[{i}]")[0] for i in range(1, n + 1)])
    x = np.array([at(f"x[{i}]")[0] for i in range(1, n + 1)])
    assert np.isfinite(y).all() and np.isfinite(x).all()
    assert y == pytest.approx(compiled.one_step(parameters.rules, previous, 50.0), rel=RTOL)
    assert x == pytest.approx(compiled.solve(parameters.rules, previous, 5e-6), rel=RTOL)


END = "Functions.linearisation"


@pytest.mark.parametrize("parameters", [table_1(), make_set(3, 5)], ids=["table_1", "five"])
def test_functions_beyond_both_ends_of_the_range(parameters):
    """Forward, inverse and the derivatives, which are those of the end."""
    low, high = limits = parameters.displacement_range
    previous = np.array([-64e-6, -5e-6, -1e-12, low, 7e-6, high, high + 1e-12, 20e-6, 80e-6])
    n, reach = len(previous), (-2000.0, 2000.0)
    points = ", ".join(map(repr, previous.tolist()))
    calls = {
        f"y{k}": f"{FUNCTIONS}.core({RULES}, yPrevious[i], {x}, lower, upper)"
        for k, x in enumerate(reach)
    }
    calls["x"] = f"{FUNCTIONS}.coreInverse({RULES}, yPrevious[i], 5e-6, lower, upper)"
    source = format_record(parameters, "Stage") + model(
        f"parameter Stage p; parameter Real yPrevious[{n}] = {{{points}}}; "
        f"parameter Real lower[4] = IT2Hysteresis.{END}({RULES}, {low!r}); "
        f"parameter Real upper[4] = IT2Hysteresis.{END}({RULES}, {high!r}); "
        + " ".join(f"Real {name}[{n}] = {{{text} for i in 1:{n}}};" for name, text in calls.items())
        + " Real ends[8] = cat(1, lower, upper);"
    )
    at = run(source, 2)
    got = {name: np.array([at(f"{name}[{i}]")[0] for i in range(1, n + 1)]) for name in calls}
    for k, x in enumerate(reach):
        expected = compiled.one_step(parameters.rules, previous, x, limits)
        assert got[f"y{k}"] == pytest.approx(expected, rel=RTOL, abs=1e-17)
    assert got["x"] == pytest.approx(compiled.solve(parameters.rules, previous, 5e-6, limits), rel=RTOL)
    for first, end, beyond in ((1, low, low - 1e-6), (5, high, high + 1e-6)):
        rest = float(compiled.solve(parameters.rules, end, end))
        _, _, (by_x, by_y, _) = compiled.gradient(parameters.rules, beyond, 50.0, limits)
        found = [at(f"ends[{first + i}]")[0] for i in range(4)]
        assert found == pytest.approx([end, rest, by_x, by_y], rel=RTOL)


@settings(max_examples=4, deadline=None)
@given(
    start=st.floats(-64e-6, 80e-6),
    voltage=st.floats(-2000.0, 2000.0),
    frequency=st.floats(0.0, 3000.0),
)
def test_no_voltage_makes_the_plant_run_away(start, voltage, frequency):
    """As tests/unit/test_range.py asks of the C core, which it is."""
    parameters = table_1().replace(initialDisplacement=start)
    source = format_record(parameters, "Stage") + model(
        f"parameter Stage p; {PLANT} plant(parameters=p);",
        f"plant.voltage = {voltage!r}*cos({frequency!r}*time);",
    )
    at = run(source, 1500)
    expected, _ = compiled.chain_free_run(parameters, at("plant.voltage"))
    assert relative(at("plant.displacement"), expected) < RTOL
    assert np.abs(at("plant.displacement")).max() < 26 * 16e-6
    outside = compiled.chain_out_of_range(parameters, at("plant.voltage"))
    assert np.array_equal(at("plant.outOfRange").astype(bool), outside)


# --- what the external objects get ---------------------------------------------------------------


@pytest.mark.parametrize("effects", [(), ("creep",), tuple(EFFECTS)], ids="-".join)
def test_all_parameters_reach_the_c_sources_in_the_tables_order(effects):
    parameters = with_effects(effects, seed=2)
    expected = values_of(parameters)
    source = format_record(parameters, "Stage") + model(
        f"Stage stage; IT2Hysteresis.Internal.Values all(parameters=stage); Real y[{len(expected)}];",
        "y = all.vector;",
    )
    found = compile_model(source).simulate(t=(0.0, 1e-4), dt=1e-4)
    got = [found[f"y[{i}]"][-1] for i in range(1, len(expected) + 1)]
    assert got == expected


# --- effects -------------------------------------------------------------------------------------

SOME = ("slew", "saturation", "play", "creep")
EFFECT_SETS = [*((effect,) for effect in EFFECTS), tuple(EFFECTS), SOME]
SURROUNDINGS = "f = 10*sin(190*time); T = 293 + 5*cos(80*time);"


def run_block(block: str, parameters: ParameterSet, signal: str, ticks: int = 400):
    """Simulate a block under an input, force and temperature; returns it and the surroundings."""
    first = "voltage" if block.endswith("Plant") else "reference"
    source = format_record(parameters, "Stage") + model(
        f"parameter Stage p; Real f; Real T; "
        f"{block} block1(parameters=p, useForce=true, useTemperature=true);",
        f"{SURROUNDINGS} block1.{first} = {signal}; block1.force = f; block1.temperature = T;",
    )
    at = run(source, ticks)
    return (lambda name: at(f"block1.{name}")), (at("f"), at("T"))


@pytest.mark.parametrize("effects", EFFECT_SETS, ids="-".join)
def test_plant_and_inverse_with_effects_are_the_c_core(effects):
    """Each under a signal of its own, in one model."""
    parameters = with_effects(effects, seed=11)
    source = format_record(parameters, "Stage") + model(
        "parameter Stage p; Real f; Real T; "
        + " ".join(
            f"{block} {name}(parameters=p, useForce=true, useTemperature=true);"
            for name, block in (("plant", PLANT), ("inverse", INVERSE))
        ),
        f"{SURROUNDINGS} plant.force = f; plant.temperature = T; inverse.force = f; "
        "inverse.temperature = T; plant.voltage = 52.5 + 42*sin(250*time) + 10*sin(1700*time); "
        "inverse.reference = "
        "5e-6 + (1 - exp(-1e6*time^2))*(2e-6*sin(250*time) + 0.5e-6*sin(1700*time));",
    )
    at = run(source, 400)
    around = (at("f"), at("T"))
    displacement, measured = compiled.chain_free_run(parameters, at("plant.voltage"), *around)
    assert relative(at("plant.displacement"), displacement) < RTOL
    assert relative(at("plant.measured"), measured) < RTOL
    outside = compiled.chain_out_of_range(parameters, at("plant.voltage"), *around)
    assert np.array_equal(at("plant.outOfRange").astype(bool), outside)
    voltage, saturated = compiled.chain_inverse_run(parameters, at("inverse.reference"), *around)
    assert relative(at("inverse.voltage"), voltage) < RTOL
    assert np.array_equal(at("inverse.saturated").astype(bool), saturated)


@pytest.mark.parametrize("effects", EFFECT_SETS, ids="-".join)
def test_the_inverse_beyond_its_limits_and_back_is_the_c_core(effects):
    calm = {"resonance.damping": 0.5, "voltageMin": 5.0, "voltageMax": 95.0}
    parameters = with_effects(effects, seed=3, **calm)
    signal = "7e-6 + (if time < 0.02 then 13e-6*sin(600*time) else 0.5e-6*sin(5*time))"
    at, around = run_block(INVERSE, parameters, signal, ticks=800)
    voltage, saturated = compiled.chain_inverse_run(parameters, at("reference"), *around)
    assert saturated[:200].any() and not saturated[-20:].any()
    assert relative(at("voltage"), voltage) < RTOL
    # where the plant is back may be a tick of rounding apart
    apart = np.count_nonzero(at("saturated").astype(bool) != saturated)
    assert apart <= 1


@pytest.mark.parametrize("ticks", [1.0, 0.5, 3.25, 64.0])
def test_delays_of_whole_and_broken_ticks(ticks):
    parameters = table_1().replace(**{"delay.time": ticks * 1e-4})
    at, _ = run_block(PLANT, parameters, "52.5 + 42*sin(250*time)", ticks=150)
    expected, _ = compiled.chain_free_run(parameters, at("voltage"))
    assert relative(at("displacement"), expected) < RTOL


def test_an_event_computes_no_more_than_what_the_set_has():
    """It shifted 65 voltages, whatever the delay: 82 numbers, and three times the time."""
    delay, creep = "delayTime=3e-4", "creepGain={0.03,0.05}, creepTimeConstant={4e-3,6e-2}"
    blocks = {"paper": "", "delayed": delay, "crept": creep}
    declared = " ".join(
        f"{PLANT} {name}Plant(parameters({changes})); {INVERSE} {name}Inverse(parameters({changes}));"
        for name, changes in blocks.items()
    )
    equations = " ".join(f"{n}Plant.voltage = 1; {n}Inverse.reference = 1e-6;" for n in blocks)
    computed = Counter()
    for name, entry in compile_model(model(declared, equations)).to_dict("flat")["variables"].items():
        if isinstance(entry["variability"], dict) and "Discrete" in entry["variability"]:
            computed[name.split(".")[0]] += math.prod(entry["dims"])
    assert computed["paperPlant"] <= 15
    assert computed["delayedPlant"] == computed["paperPlant"] + 3
    assert computed["delayedInverse"] == computed["paperInverse"]
    assert computed["creptPlant"] == computed["paperPlant"] + 2


# --- blocks around the FMUs: wiring and sampling ---------------------------------------------------


def test_the_fmus_tick_at_the_sample_times_with_all_inputs():
    at, (force, temperature) = run_block(FMU_PLANT, table_1(), "50 + 3e4*time", ticks=10)
    t = np.arange(10) * 1e-4
    assert at("displacement") == pytest.approx(1e-7 * at("voltage") + 1e-3 * t, rel=1e-12)
    assert at("measured") == pytest.approx(1e-9 * force + 1e-12 * temperature, rel=1e-12)
    assert np.array_equal(at("outOfRange").astype(bool), t > 5e-4)
    at, (force, temperature) = run_block(FMU_INVERSE, table_1(), "5e-6 + 1e-3*time", ticks=10)
    expected = 1e7 * at("reference") + t + 1e-3 * force + 1e-6 * temperature
    assert at("voltage") == pytest.approx(expected, rel=1e-12)
    assert np.array_equal(at("saturated").astype(bool), t > 5e-4)


@pytest.mark.parametrize("effects", [("play",), ("creep",), ("lag", "play", "creep", "resonance")])
def test_at_rest_the_chain_has_the_states_that_hold_it(effects):
    # a delay's first state is the voltage at rest; it comes behind the core's
    parameters = with_effects(("delay", *effects), seed=2, initialDisplacement=6e-6)
    source = format_record(parameters, "Mine") + (
        f"block M {PREAMBLE} extends {INTERFACES}.PartialChain(parameters=p); parameter Mine p; "
        "output Real v = chain.voltageRest; output Real y = chain.coreRest; "
        "output Real p1 = chain.playRest[1]; output Real s1 = chain.creepRest[1]; end M;"
    )
    chain = Chain(parameters)
    core_rest, voltage, *states = chain.rest(chain.vector()).full().ravel()
    at = run(source, 2)
    assert at("y")[0] == pytest.approx(core_rest, rel=1e-10)
    assert at("v")[0] == pytest.approx(voltage, rel=1e-10)
    for effect, state in (("play", "p1"), ("creep", "s1")):
        assert effect not in effects or np.isclose(at(state)[0], states, rtol=1e-10, atol=0).any()
