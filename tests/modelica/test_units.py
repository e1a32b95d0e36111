"""Units fit in every equation, binding, start value and event of the library.

Functions are looked at where they are called, in test_simulation, and the examples where they are
simulated, in test_components.
"""

import pytest
from combined import PARTS, source_of
from library import FMU_INVERSE, FMU_PLANT, PREAMBLE
from test_simulation import compile_model
from units import Checker, faults, parsed

EFFECTS = (
    "playThreshold={2,8}, playWeight={0.04,0.06}, creepGain={0.02,0.01}, creepTimeConstant={5e-3,0.5}, "
    "resonanceFrequency=1000, resonanceDamping=0.1, lagTimeConstant=1e-4, nonlinearityQuadratic=1e-7"
)


def test_units_fit_in_all_blocks_and_components():
    """All parts in one model, pure blocks with effects, and both blocks around the FMUs."""
    parts = tuple(p for p in PARTS if p.name != "stack")  # a second actuator
    source = source_of(parts).replace("plant;", f"plant(parameters({EFFECTS}));")
    source = source.replace(" equation ", f" {FMU_PLANT} fmu1; {FMU_INVERSE} fmu2; equation ", 1)
    source = source.replace("end M;", "fmu1.voltage = plant.voltage; fmu2.reference = 0; end M;")
    assert not faults(compile_model(source).to_dict("flat"))


@pytest.mark.parametrize(
    ("declared", "equation", "fault"),
    [
        ("", "a = b", "kg1.m2.s-3.A-1 and m1"),
        ("", "der(a) = a", "m1 and m1.s-1"),
        ("", "a = if time > 1 then 2*b else k*b", " and m1"),
        ("", "a = 1e-7*b", "kg1.m2.s-3.A-1 and m1"),
        ("", "a = 3*a*exp(b/100)", "1 and kg1"),
        ("", "a = IT2Hysteresis.Functions.Effects.lag(0.5, b, a)", "Effects.lag"),
        ('Real c(unit="V")=a;', "a = 0", "kg1.m2.s-3.A-1 and m1"),
        ("", "when sample(0, 1) then c = pre(a); end when; a = 0", "kg1.m2.s-3.A-1 and m1"),
        ("", "when sample(0, 1) then c = b; end when; a = 0", None),
        ("", "a = k*b", None),
        ("", "a = sqrt(a^2) + 3*a*exp(b/100*k/a)", None),
        ("", "a = min(max(a, 2e-6), k*b)", None),
    ],
)
def test_what_does_not_fit_is_found(declared, equation, fault):
    more = 'discrete Real c(start=0, fixed=true, unit="V"); ' if "when" in equation else declared
    source = (
        f'model M {PREAMBLE} Real a(unit="m", start=0); parameter Real b(unit="V")=1; '
        f'parameter Real k(unit="m/V")=1; {more} equation {equation}; end M;'
    )
    found = faults(compile_model(source).to_dict("flat"))
    assert bool(found) == bool(fault)
    assert not fault or any(fault in text for text in found)


def test_a_statement_of_a_function_is_looked_at():
    checker = Checker({"x": parsed("V"), "y": parsed("m")})
    value = {"VarRef": {"name": {"name": "x"}, "subscripts": []}}
    checker.unit({"Assignment": {"comp": {"parts": [{"ident": "y"}]}, "value": value}})
    assert checker.faults == ["y: kg1.m2.s-3.A-1 and m1"]
