"""What pure Modelica refuses, and that it says it as the FMUs do."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from conftest import make_set
from effects import with_effects
from library import CLASSES, FMU_PLANT, INVERSE, PLANT, model
from refused import BAD, parameters_of
from test_simulation import CHECK, rumoca, run

from it2hys.export.modelica import field, format_record
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import table_1

ROOT = Path(__file__).parents[2]
FUNCTIONS = "IT2Hysteresis.Functions"
EXPONENT = re.compile(r"e([+-])0?(\d)\b")


def plain(message: str) -> str:
    """Return a message with numbers written in one way: rumoca writes 1e-5, others 1e-05."""
    return EXPONENT.sub(r"e\1\2", message).replace("e+", "e").replace("1000000", "1e6")


def test_plant_and_inverse_are_checked_alike():
    """So that what the plant refuses, the inverse does."""
    checks = [CHECK.findall(CLASSES[block].read_text(encoding="utf-8")) for block in (PLANT, INVERSE)]
    assert checks[0] == checks[1]
    assert "Functions.check(" in "".join(checks[0])


@pytest.mark.parametrize(
    ("block", "name"),
    [
        *((PLANT, name) for name in BAD),
        *((INVERSE, name) for name in ("a weight too few", "far start")),
    ],
)
def test_a_set_that_is_refused_stops_the_initialization_with_the_fmus_message(block, name):
    changes, message = BAD[name]
    if any(math.isnan(value) for value in changes.values()):
        pytest.skip("a Modelica text has no literal for nan")
    if name == "no sample time":
        pytest.skip("rumoca refuses sample(0, 0) before")
    kind = block.rsplit(".", 1)[-1].lower()
    signal = "voltage" if kind == "plant" else "reference"
    source = format_record(parameters_of(changes), "Mine") + model(
        f"parameter Mine p; {block} {kind}(parameters=p);", f"{kind}.{signal} = 0;"
    )
    with pytest.raises(rumoca.SimulationError) as caught:
        run(source, 2, checked=True)
    assert plain(f"M.{kind}: {message}.") in plain(str(caught.value))


@pytest.mark.parametrize("rules", [1, 5])
def test_a_usable_set_with_every_effect_is_not_refused(rules):
    effects = with_effects(tuple(EFFECTS), seed=rules)
    changes = {name: value for name, value in effects.items() if not name.startswith("rule")}
    parameters = make_set(rules, rules).replace(**changes)
    source = format_record(parameters, "Mine") + model(
        f"parameter Mine p; {INVERSE} inverse(parameters=p); {PLANT} plant(parameters=p);",
        "inverse.reference = p.initialDisplacement; connect(inverse.voltage, plant.voltage);",
    )
    assert np.isfinite(run(source, 2, checked=True)("plant.displacement")).all()


@pytest.mark.parametrize("block", [PLANT, INVERSE])
def test_an_input_that_is_no_number_is_said_before_anything_else(block):
    kind = block.rsplit(".", 1)[-1].lower()
    signal = "voltage" if kind == "plant" else "reference"
    source = model(
        f"{block} {kind};", f"{kind}.{signal} = if time > 2.5e-4 then 1.7976931348623157e308 else 1e-6;"
    )
    with pytest.raises(rumoca.SimulationError, match=f"{kind}: {signal} must be a finite number, not"):
        run(source, 8)


@pytest.mark.parametrize("parameters", [table_1(), make_set(5, 5)], ids=["table_1", "five"])
def test_contraction_and_slope_are_those_of_the_c_core(parameters):
    rules = "p.ruleSigmaLower, p.ruleSigmaUpper, p.ruleCentre"
    ends = "p.displacementMin, p.displacementMax"
    source = format_record(parameters, "Mine") + model(
        f"parameter Mine p; Real largest[2] = {FUNCTIONS}.contraction({rules}, p.ruleQ1, p.ruleQ2, "
        f"p.ruleQ3, {ends}); Real slope = {FUNCTIONS}.slope({rules}, p.ruleQ2, 7e-6);"
    )
    at = run(source, 2)
    expected = compiled.contraction(parameters.rules, *parameters.displacement_range)
    assert at("largest[1]")[0] == pytest.approx(expected, rel=1e-9)
    by_x = compiled.gradient(parameters.rules, 7e-6, 50.0)[2][0]
    assert at("slope")[0] == pytest.approx(float(by_x), rel=1e-12)


def test_every_message_of_the_c_check_is_one_of_the_pure_check():
    """A check that C gets and Modelica does not would show here."""
    sources = sorted((ROOT / "fmu_src/core").glob("*.c"))
    assert sources
    pure = "".join(
        CLASSES[f"IT2Hysteresis.{name}"].read_text(encoding="utf-8")
        for name in ("Functions.check", "Internal.checkBounds")
    )
    pure = re.sub(r"String\([^\"]*?(?:, significantDigits=\d)?\)", "%", pure)
    pure = re.sub(r'"\s*\+\s*(%)\s*\+\s*"', r"\1", pure)
    pure = re.sub(r'"\s*\+\s*"', "", pure)
    missing = []
    for source in sources:
        text = source.read_text(encoding="utf-8")
        for call in re.findall(r"(?:refuse|fail)\(message, size,\s*((?:\"[^\"]*\"\s*)+)", text):
            message = "".join(re.findall(r'"([^"]*)"', call))
            if not any(words in pure for words in candidates(message)):
                missing.append(f"{source.name}: {message}")
    assert not missing


#: What the bounds of the table, which are checked before, leave no room for.
BEFORE = (
    "Count is",
    "finite number",
    "must be positive, or 0",
    "must not be negative",
    "standard deviation",
)


def candidates(message: str) -> list[str]:
    """Return how a message of the C core may stand in Modelica."""
    if any(words in message for words in BEFORE) or message.startswith("sampleTime is"):
        return [""]
    text = re.sub(r"%\.?\d*[gds]", "%", message)
    text = re.sub(r"\b(\w+)(\[%?\])?\.(\w+)", lambda m: field(f"{m[1]}.{m[3]}") + index(m[2]), text)
    # a number at the start or the end stands outside the literal
    return [text, text.strip("% ")]


def index(text: str | None) -> str:
    """Return the index of an element behind its name, if it has any."""
    return text if text and text != "[]" else ""


@pytest.mark.parametrize("block", [PLANT, FMU_PLANT])
def test_an_element_that_is_modified_in_place_acts(block):
    """OpenModelica ignored it, where the record had a binding."""
    source = model(
        f"{block} plant(parameters(lagTimeConstant=1e-3, initialDisplacement=2e-6)); "
        "Real tau = plant.parameters.lagTimeConstant; Real start = plant.initialDisplacement;",
        "plant.voltage = 50;",
    )
    at = run(source, 4)
    assert at("tau")[-1] == 1e-3
    assert at("start")[-1] == 2e-6
    declared = CLASSES["IT2Hysteresis.Interfaces.PartialChain"].read_text(encoding="utf-8")
    assert re.search(r'parameter Stage parameters "', declared), (
        "a binding wins over such a modification"
    )


@pytest.mark.parametrize("block", [PLANT, INVERSE])
def test_vectors_that_are_given_in_place_or_by_a_constructor_need_no_count(block):
    """And none that is given counts: three ways to hand over two play operators and a creep term."""
    kind = block.rsplit(".", 1)[-1].lower()
    signal, y = ("voltage", "displacement") if kind == "plant" else ("reference", "voltage")
    vectors = "playThreshold={2,8}, playWeight={0.04,0.06}, creepGain={0.03}, creepTimeConstant={0.005}"
    table = "IT2Hysteresis.Parameters.Table1"
    source = model(
        f"parameter {table} stage({vectors}); {block} named(parameters=stage); "
        f"{block} placed(parameters({vectors})); {block} made(parameters={table}({vectors})); "
        "Integer counts[3] = {stage.ruleCount, stage.playCount, stage.creepCount};",
        f"named.{signal} = {'50*sin(300*time)^2' if kind == 'plant' else '6e-6*sin(300*time)^2'}; "
        f"placed.{signal} = named.{signal}; made.{signal} = named.{signal};",
    )
    at = run(source, 60)
    assert [at(f"counts[{i}]")[0] for i in (1, 2, 3)] == [3, 2, 1]
    elements = {"play[1]": (2.0, 0.04), "play[2]": (8.0, 0.06)}
    values = {f"{n}.threshold": t for n, (t, _) in elements.items()}
    values |= {f"{n}.weight": w for n, (_, w) in elements.items()}
    parameters = table_1().replace(
        playCount=2, creepCount=1, **values, **{"creep[1].gain": 0.03, "creep[1].timeConstant": 0.005}
    )
    chain = compiled.chain_free_run if kind == "plant" else compiled.chain_inverse_run
    expected = chain(parameters, at(f"named.{signal}"))[0]
    for name in ("named", "placed", "made"):
        assert at(f"{name}.{y}") == pytest.approx(expected, rel=1e-12, abs=1e-18), name


def test_a_set_without_rules_is_refused():
    source = model(
        f"{PLANT} plant(redeclare record Stage = IT2Hysteresis.Parameters.Base);", "plant.voltage = 0;"
    )
    with pytest.raises(rumoca.SimulationError, match=r"M\.plant: ruleCount is 0; it must be 1 to 16"):
        run(source, 2, checked=True)


def test_a_lag_that_is_modified_in_place_slows_the_plant():
    source = model(
        f"{PLANT} quick; {PLANT} slow(parameters(lagTimeConstant=1e-3));",
        "quick.voltage = 50; slow.voltage = 50;",
    )
    at = run(source, 20)
    assert (at("slow.displacement")[1:] < at("quick.displacement")[1:]).all()
