"""The library in rumoca: every class is instantiated, and the numbers are those of the C core.

rumoca has no Modelica Standard Library; `stub` stands in for what the library uses of it. rumoca
loads packages whose names stand in the source, hence the import in `PREAMBLE`.
"""

from collections.abc import Callable

import numpy as np
import pytest
from conftest import make_set
from library import CLASSES, LIBRARY, kind

from it2hys import core
from it2hys.excitations import identification, time_grid, tracking_reference
from it2hys.modelica import format_record
from it2hys.parameters import table_1
from it2hys.variables import load_table

rumoca = pytest.importorskip("rumoca", reason="rumoca, the Modelica compiler, is not installed")

STUB = LIBRARY.parents[1] / "tests" / "modelica" / "stub"
PREAMBLE = "import Modelica.Units.SI;"
PLANT = "IT2Hysteresis.Blocks.PureModelica.Plant"
INVERSE = "IT2Hysteresis.Blocks.PureModelica.Inverse"
TABLE_1 = "IT2Hysteresis.Parameters.Table1"
RTOL = 1e-12

# how a class of each kind is instantiated in a model M
WRAPPERS = {
    "package": "package P {pre} extends {name}; end P; model M end M;",
    "class": "model M {pre} {name} item; end M;",
    "record": "model M {pre} {name} item; end M;",
    "block": "block M {pre} extends {name}; {rest} end M;",
    "model": "model M {pre} extends {name}; end M;",
    "function": "model M {pre} parameter {table_1} p; Real y = {rest}; end M;",
}
CENTRES = "p.ruleSigmaLower, p.ruleSigmaUpper, p.ruleCentre"
RULES = f"{CENTRES}, p.ruleQ1, p.ruleQ2, p.ruleQ3"
FUNCTIONS = "IT2Hysteresis.Functions"
INTERFACES = "IT2Hysteresis.Interfaces"
# what is missing to instantiate a partial block or a function
REST = {
    f"{INTERFACES}.PartialPlant": "equation displacement = voltage; measured = voltage;",
    f"{INTERFACES}.PartialInverse": "equation voltage = reference; saturated = false;",
    f"{FUNCTIONS}.memberships": f"sum({FUNCTIONS}.memberships({CENTRES}, 1e-6))",
    f"{FUNCTIONS}.step": f"{FUNCTIONS}.step({RULES}, 1e-6, 50)",
    f"{FUNCTIONS}.inverse": f"{FUNCTIONS}.inverse({RULES}, 1e-6, 2e-6)",
}


def compile_model(source: str) -> "rumoca.Model":
    """Compile the model M of a source text."""
    session = rumoca.Session(roots=[str(LIBRARY.parent), str(STUB)])
    return session.loads(source, model="M", filename="M.mo")


def model(declarations: str, equations: str = "") -> str:
    """Return the source of a model M."""
    return f"model M {PREAMBLE} {declarations} equation {equations} end M;"


def run(source: str, ticks: int, sample_time: float = 1e-4) -> Callable[[str], np.ndarray]:
    """Simulate the model M; returns a function from a variable to its values at the ticks."""
    result = compile_model(source).simulate(
        t=(0.0, (ticks - 1) * sample_time),
        dt=sample_time,
        config=rumoca.SimConfig(solver="rk-like"),
    )
    # a tick has several rows; the last one is what holds after the event
    rows = np.searchsorted(result.time, (np.arange(ticks) + 0.1) * sample_time) - 1
    return lambda name: np.asarray(result[name])[rows]


def relative(actual: np.ndarray, expected: np.ndarray) -> float:
    """Return the largest deviation, relative to the largest expected value."""
    return np.max(np.abs(actual - expected)) / np.max(np.abs(expected))


# --- every class -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CLASSES)
def test_every_class_is_instantiated_and_balanced(name):
    source = WRAPPERS[kind(name)].format(
        pre=PREAMBLE, name=name, rest=REST.get(name, ""), table_1=TABLE_1
    )
    assert compile_model(source).structure().is_balanced


@pytest.mark.parametrize(("which", "block"), [("plant", PLANT), ("inverse", INVERSE)])
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
    expected = core.free_run(table_1().rules, at("plant.voltage"), 0.0)
    assert relative(at("plant.displacement"), expected) < RTOL
    assert np.array_equal(at("plant.measured"), at("plant.displacement"))
    assert relative(at("plant.voltage"), identification(time_grid(0.12, 1e-4))) < RTOL


def test_feedforward_cancels_the_plant():
    at = run(model("extends IT2Hysteresis.Examples.FeedforwardTracking;"), 1000)
    reference = at("inverse.reference")
    previous = np.concatenate([[0.7e-6], reference[:-1]])
    assert relative(at("plant.displacement"), reference) < RTOL
    assert relative(at("inverse.voltage"), core.solve(table_1().rules, previous, reference)) < RTOL
    assert relative(reference, tracking_reference(time_grid(0.1, 1e-4))) < RTOL
    assert not at("inverse.saturated").any()


@pytest.mark.parametrize("count", [1, 2, 5, 16])
def test_an_exported_record_runs(count):
    parameters = make_set(count, count, sampleTime=2e-4, initialDisplacement=1e-6)
    source = format_record(parameters, "Stage") + model(
        f"parameter Stage p; {INVERSE} inverse(parameters=p); {PLANT} plant(parameters=p);",
        "inverse.reference = 8e-6 + 7.9e-6*sin(300*time)*cos(777*time); "
        "connect(inverse.voltage, plant.voltage);",
    )
    at = run(source, 200, sample_time=2e-4)
    reference = at("inverse.reference")
    voltage = core.solve(parameters.rules, np.r_[1e-6, reference[:-1]], reference)
    assert relative(at("inverse.voltage"), voltage) < RTOL
    assert relative(at("plant.displacement"), reference) < RTOL


def test_beyond_reach_the_inverse_aims_at_the_nearest_displacement():
    at = run(model(f"{INVERSE} inverse;", "inverse.reference = 8e-6 + 14e-6*sin(300*time);"), 500)
    reference = at("inverse.reference")
    aim = np.clip(reference, 0.0, 16e-6)
    expected = core.solve(table_1().rules, np.r_[0.0, aim[:-1]], aim)
    assert relative(at("inverse.voltage"), expected) < RTOL
    assert np.array_equal(at("inverse.saturated").astype(bool), aim != reference)
    assert set(np.sign(reference - aim)) == {-1.0, 0.0, 1.0}


def test_before_the_first_tick_the_inverse_holds_the_plant():
    source = model(
        f"{INVERSE} inverse(parameters={TABLE_1}(initialDisplacement=3e-6)); Real v;",
        "inverse.reference = 3e-6; v = inverse.voltage;",
    )
    expected = core.solve(table_1().rules, 3e-6, 3e-6)
    assert run(source, 3)("v") == pytest.approx(float(expected), rel=RTOL)


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
    assert y == pytest.approx(core.one_step(parameters.rules, previous, 50.0), rel=RTOL)
    assert x == pytest.approx(core.solve(parameters.rules, previous, 5e-6), rel=RTOL)
