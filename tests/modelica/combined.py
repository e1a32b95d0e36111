"""Models of the library's parts with their defaults only, as drag and drop makes them.

Every connected combination of two or three parts is built, with two actuators, too: an input takes the
first output of its unit, or 0; pins go to pins, a flange to the next one, sensors lie between the frame
and what moves.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain, combinations, pairwise

import numpy as np
import pytest
from library import INVERSE, PLANT, model

COMPONENTS = "IT2Hysteresis.Components"
FRAME = "Modelica.Mechanics.Translational.Components.Fixed frame;"
GROUND = "Modelica.Electrical.Analog.Basic.Ground ground;"


@dataclass(frozen=True)
class Part:
    """What a class connects by: signals by unit, whether it has pins, and how its flanges are used."""

    name: str
    model: str
    inputs: tuple[tuple[str, str], ...] = ()
    outputs: tuple[tuple[str, str], ...] = ()
    pins: str = ""
    flanges: str = ""


PARTS = (
    Part(
        "controller", f"{COMPONENTS}.SampledPI", (("reference", "m"), ("measured", "m")), (("y", "V"),)
    ),
    Part("inverse", INVERSE, (("reference", "m"),), (("voltage", "V"),)),
    Part("plant", PLANT, (("voltage", "V"),), (("measured", "m"),)),
    Part("amplifier", f"{COMPONENTS}.VoltageAmplifier", (("u", "V"),), pins="source"),
    Part("charger", f"{COMPONENTS}.ChargeAmplifier", (("u", "V"),), pins="source"),
    Part("actuator", f"{COMPONENTS}.PiezoActuator", pins="load", flanges="through"),
    Part("stack", f"{COMPONENTS}.PiezoActuator", pins="load", flanges="through"),
    Part("guide", f"{COMPONENTS}.FlexureGuide", flanges="through"),
    Part("gauge", f"{COMPONENTS}.StrainGauge", outputs=(("y", "m"),), flanges="across"),
    Part("sensor", f"{COMPONENTS}.PositionSensor", outputs=(("y", "m"),), flanges="across"),
)


def wires(parts: tuple[Part, ...]) -> tuple[list[str], list[tuple[str, str]], list[str]]:
    """Return connections, which parts they join, and the inputs that nothing drives."""
    connections, joined, free = [], [], []
    for part in parts:
        for port, unit in part.inputs:
            drivers = [(p, o) for p in parts for o, u in p.outputs if u == unit and p is not part]
            if port == "reference" or not drivers:
                free.append(f"{part.name}.{port}")
            else:
                driver, output = drivers[0]
                connections.append(f"connect({driver.name}.{output}, {part.name}.{port});")
                joined.append((driver.name, part.name))
    for load in (p for p in parts if p.pins == "load"):
        for source in (p for p in parts if p.pins == "source"):
            connections += [f"connect({source.name}.{pin}, {load.name}.{pin});" for pin in "pn"]
            joined.append((source.name, load.name))
    electrical = [p for p in parts if p.pins]
    if electrical:
        connections.append(f"connect({electrical[0].name}.n, ground.p);")
    for one, other in pairwise(p for p in electrical if all(q.pins == "load" for q in electrical)):
        connections += [f"connect({one.name}.{pin}, {other.name}.{pin});" for pin in "pn"]
    through = [p for p in parts if p.flanges == "through"]
    if through and through[0].name == "actuator":
        connections.append("connect(frame.flange, actuator.flange_a);")
    for one, other in pairwise(through):
        connections.append(f"connect({one.name}.flange_b, {other.name}.flange_a);")
        joined.append((one.name, other.name))
    for across in (p for p in parts if p.flanges == "across" and through):
        connections += [
            f"connect(frame.flange, {across.name}.flange_a);",
            f"connect({through[0].name}.flange_b, {across.name}.flange_b);",
        ]
        joined.append((through[0].name, across.name))
    return connections, joined, free


def fits(parts: tuple[Part, ...]) -> bool:
    """Tell whether the parts are one connected model that is physically complete."""
    names = {p.name for p in parts}
    sources = sum(p.pins == "source" for p in parts)
    if sources > 1 or (sources and "actuator" not in names):
        return False  # two amplifiers on one stack, or one on nothing
    if any(p.flanges for p in parts) and "actuator" not in names:
        return False  # nothing moves them, or says where they are; a stack is the second actuator
    reached, joined = {parts[0].name}, wires(parts)[1]
    for _ in parts:
        reached |= set(chain.from_iterable(pair for pair in joined if reached & set(pair)))
    return reached == names


COMBINATIONS = [c for n in (2, 3) for c in combinations(PARTS, n) if fits(c)]


def source_of(parts: tuple[Part, ...]) -> str:
    """Return the model of a combination, with inputs at 0."""
    connections, _, free = wires(parts)
    names = {p.name for p in parts}
    frame = FRAME if "actuator" in names else ""
    ground = GROUND if any(p.pins for p in parts) else ""
    declarations = " ".join(f"{p.model} {p.name};" for p in parts)
    return model(
        f"{declarations} {frame} {ground}", " ".join([*connections, *(f"{name} = 0;" for name in free)])
    )


def assert_physical(parts: tuple[Part, ...], at: Callable[[str], np.ndarray]) -> None:
    """With all inputs at 0 V or 0 um: nothing jumps, no force, no voltage beyond what may be given."""
    names = {p.name for p in parts}
    if "actuator" in names:
        s = at("actuator.s_rel")
        assert 0 < s[0] < 1e-6
        assert np.abs(s - s[0]).max() < (1e-9 if "controller" not in names else 1e-7)
        assert np.abs(at("actuator.f")).max() < 1.0
        assert np.abs(at("actuator.v")).max() < 1.0
    if "stack" in names:
        assert np.ptp(at("stack.s_rel")) < 1e-9
        assert np.abs(at("stack.f")).max() < 1.0
    if "guide" in names:
        assert at("guide.stackForce") == pytest.approx(200.0, abs=1.0)
    if "plant" in names:
        # the paper's actuator rests 0.58 um above 0 at 0 V; it begins at 0, as the FMU does
        assert at("plant.displacement").min() > -1e-7
        assert at("plant.displacement").max() < 6e-7
    for sensor in names & {"gauge", "sensor"}:
        if "actuator" in names:
            assert at(f"{sensor}.y")[-1] == pytest.approx(at("actuator.s_rel")[-1], abs=3e-8)
