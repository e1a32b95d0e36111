"""The five steps of the user's guide's tutorial are models that simulate and show what it says."""

import numpy as np
import pytest
from library import CLASSES, INVERSE, PLANT, html, model
from lxml import etree
from test_simulation import relative, run

from it2hys.export.modelica import format_record
from it2hys.model.parameters import table_1

TUTORIAL = "IT2Hysteresis.UsersGuide.Tutorial"
COMPONENTS = "IT2Hysteresis.Components"
STAGE = "parameter MyStage stage(initialDisplacement=1e-6);"
RECORD = format_record(table_1(), "MyStage")
REFERENCE = "6e-6 - 5e-6*cos(125.66*time)"
MACHINE = (
    f"{STAGE} {INVERSE} inverse(parameters=stage); {COMPONENTS}.PiezoActuator actuator(stage=stage); "
    f"{COMPONENTS}.VoltageAmplifier amplifier(k=1, vStart=actuator.vStart); {COMPONENTS}.FlexureGuide "
    "guide; Modelica.Mechanics.Translational.Components.Fixed base; "
    "Modelica.Electrical.Analog.Basic.Ground ground;"
)
WIRES = (
    "connect(amplifier.p, actuator.p); connect(amplifier.n, actuator.n); "
    "connect(amplifier.n, ground.p); "
    f"connect(base.flange, actuator.flange_a); connect(actuator.flange_b, guide.flange_a); "
    f"inverse.reference = {REFERENCE};"
)


def steps() -> list[set[str]]:
    """Return what each step of the tutorial writes as code, without blanks."""
    root = etree.fromstring(html(CLASSES[TUTORIAL], "info")[0])
    codes: list[set[str]] = []
    for element in root:
        if element.tag == "h4":
            codes.append(set())
        for code in element.iter("code", "pre", "a"):
            if codes:
                codes[-1] |= {"".join(line.split()) for line in "".join(code.itertext()).split("\n")}
    return codes


def test_the_tutorial_has_five_steps_that_say_what_is_tried_here():
    said = steps()
    assert len(said) == 5
    assert {"amplitude=45", "offset=50", "f=20"} <= said[0]
    assert "parameterMyStagestage(initialDisplacement=1e-6);" in said[1]
    assert "plant(redeclarerecordStage=MyStage,parameters(lagTimeConstant=1e-3))" in said[1]
    assert {"voltage", "reference", "saturated"} <= said[2]
    assert {
        "PiezoActuator",
        "VoltageAmplifier",
        "k=1",
        "FlexureGuide",
        "vStart=actuator.vStart",
    } <= said[3]
    assert {"StrainGauge", "offset=actuator.length", "SampledPI", "Modelica.Blocks.Math.Add"} <= said[4]


def test_a_plant_draws_a_loop():
    source = f"{PLANT} plant; Modelica.Blocks.Sources.Sine sine(amplitude=45, offset=50, f=20);"
    at = run(model(source, "connect(sine.y, plant.voltage);"), 1000)
    voltage, displacement = at("plant.voltage")[500:], at("plant.displacement")[500:]
    rising = np.gradient(voltage) > 0
    middle = np.abs(voltage - 50.0) < 2.0
    assert displacement[middle & ~rising].mean() - displacement[middle & rising].mean() > 1e-6


def test_a_set_of_ones_own_is_handed_over_or_chosen_and_modified():
    chosen = "redeclare record Stage = MyStage, parameters(lagTimeConstant=1e-3)"
    source = f"{STAGE} {PLANT} plant(parameters=stage); {PLANT} slow({chosen});"
    at = run(RECORD + model(source, "plant.voltage = 50; slow.voltage = 50;"), 10)
    assert at("plant.displacement")[0] > 1e-6 > at("slow.displacement")[0]


def test_the_displacement_is_the_reference():
    source = f"{STAGE} {INVERSE} inverse(parameters=stage); {PLANT} plant(parameters=stage);"
    at = run(
        RECORD
        + model(source, f"inverse.reference = {REFERENCE}; connect(inverse.voltage, plant.voltage);"),
        500,
    )
    assert relative(at("plant.displacement"), at("inverse.reference")) < 1e-12
    assert not at("inverse.saturated").any()


def test_a_machine_begins_at_rest_and_a_closed_loop_follows_better():
    open_loop = run(RECORD + model(MACHINE, f"{WIRES} connect(inverse.voltage, amplifier.u);"), 400)
    assert open_loop("actuator.s_rel")[0] == pytest.approx(1e-6, rel=1e-3)
    assert open_loop("actuator.v")[0] == pytest.approx(open_loop("inverse.voltage")[0], abs=0.1)
    assert open_loop("actuator.f")[0] == pytest.approx(0.0, abs=1e-6)
    assert open_loop("guide.stackForce").min() > 0
    parts = (
        f"{COMPONENTS}.StrainGauge gauge(parameters=stage, offset=actuator.length); "
        f"{COMPONENTS}.SampledPI controller(parameters=stage); Modelica.Blocks.Math.Add total;"
    )
    loop = (
        "connect(inverse.voltage, total.u1); connect(controller.y, total.u2); "
        "connect(total.y, amplifier.u); connect(base.flange, gauge.flange_a); "
        "connect(actuator.flange_b, gauge.flange_b); connect(gauge.y, controller.measured); "
        f"controller.reference = {REFERENCE};"
    )
    closed = run(RECORD + model(f"{MACHINE} {parts}", f"{WIRES} {loop}"), 400)
    errors = [
        np.sqrt(np.mean((at("actuator.s_rel") - at("inverse.reference"))[100:] ** 2))
        for at in (open_loop, closed)
    ]
    assert errors[1] < 0.5 * errors[0]
