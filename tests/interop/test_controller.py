"""PIController.fmu: its equations and its XML; its capabilities are tried in test_capabilities."""

import math
import struct

import numpy as np
import pytest
from conftest import TS, UM, Instance, Unpacked
from fmpy import fmi2
from fmpy.validation import validate_fmu

from it2hys.cosimulation.slave import Slave
from it2hys.errors import InputError
from it2hys.fmu.codegen import fnv1a
from it2hys.fmu.controller import load_controller

OK, DISCARD, ERROR = fmi2.fmi2OK, fmi2.fmi2Discard, fmi2.fmi2Error
GAINS = {"proportionalGain": 1e6, "integralGain": 3e9, "initialVoltage": 20.0}


def test_the_controllers_xml_agrees_with_its_table_and_its_binary(controller):
    assert validate_fmu(str(controller.path)) == []
    table = load_controller().variables
    with Slave(controller.path) as slave:
        assert list(slave.variables) == [v.name for v in table]
        for variable in table:
            assert slave.variable(variable.name).valueReference == variable.value_reference
            if variable.causality != "output":
                assert slave.get(variable.name) == variable.start
        # every Real can be set and is the variable that the table says
        values = {v.name: (1.0 + v.value_reference) * 1e-3 for v in table if v.causality != "output"}
        slave.initialize(values)
        assert {name: slave.get(name) for name in values} == values


def reference_pi(error, feedforward, gains):
    """Return the voltage by the equations of PIController.c."""
    integral, voltage = gains["initialVoltage"], []
    for e, f in zip(error, feedforward, strict=True):
        grown = integral + gains["integralGain"] * TS * e
        wanted = f + gains["proportionalGain"] * e + grown
        given = min(max(wanted, gains["voltageMin"]), gains["voltageMax"])
        deeper = (wanted > given and grown > integral) or (wanted < given and grown < integral)
        integral = integral if deeper else grown
        voltage.append(given)
    return np.array(voltage)


def test_the_controller_computes_its_equations_and_does_not_wind_up(controller):
    gains = {
        "proportionalGain": 2e6, "integralGain": 3e9, "voltageMin": 0.0, "voltageMax": 60.0,
        "initialVoltage": 20.0,
    }  # fmt: skip
    # far too much for half of the time, then the other way
    error = np.where(np.arange(200) < 100, 5 * UM, -1 * UM) * (1 + 0.1 * np.sin(np.arange(200)))
    feedforward = 10 + np.cos(np.arange(200) / 7)
    read, limited = [], []
    with Slave(controller.path, gains) as slave:
        for k, (e, f) in enumerate(zip(error, feedforward, strict=True)):
            slave.tick(k, {"reference": 7 * UM + e, "displacement": 7 * UM, "feedforward": f})
            read.append(slave.get("voltage"))
            limited.append(slave.get("limited"))
    expected = reference_pi(7 * UM + error - 7 * UM, feedforward, gains)
    np.testing.assert_allclose(read, expected, rtol=1e-12)
    assert max(read) == 60.0 and any(limited) and not all(limited)
    # with wind-up it would stay at the limit for long after the error has turned
    assert read[110] < 60.0


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"sampleTime": 0.0}, "sampleTime is 0 s"),
        ({"voltageMin": 10.0, "voltageMax": 5.0}, "must be below voltageMax"),
        ({"integralGain": float("nan")}, "finite"),
    ],
)
def test_the_controller_refuses_what_it_cannot_use(controller, values, said):
    with pytest.raises(InputError, match=said), Slave(controller.path, values):
        pass


def test_every_variable_has_a_type_with_its_limits(controller):
    units = {u.name: {d.name for d in u.displayUnits} for u in controller.description.unitDefinitions}
    for variable in controller.description.modelVariables:
        declared = variable.declaredType
        assert variable.description and declared is not None, variable.name
        if variable.type != "Real":
            continue
        assert variable.unit == declared.unit in units, variable.name
        assert declared.displayUnit is None or declared.displayUnit in units[variable.unit]
        assert None not in (declared.min, declared.max, declared.nominal), variable.name
        start = float(variable.start or 0.0)
        assert float(declared.min) <= start <= float(declared.max), variable.name


def test_initial_outputs_depend_on_what_the_xml_says(controller):
    (unknown,) = [u for u in controller.description.initialUnknowns if u.variable.name == "voltage"]
    assert [u.dependencies for u in controller.description.outputs] == [[], []]
    moved = set()
    for name, variable in controller.variables.items():
        if variable.causality == "output":
            continue
        for before in ({}, {"initialVoltage": -1.0}, {"initialVoltage": 200.0}):  # within, below, above
            read = []
            for change in (0.0, 0.5e-4):
                with Instance(controller) as instance:
                    start = {"initialVoltage": 20.0, **before}
                    start[name] = start.get(name, float(variable.start)) + change
                    read.append(instance.initialize(start).get("voltage"))
            moved |= {name} if read[0] != read[1] else set()
    assert moved == {v.name for v in unknown.dependencies}


# --- what cannot be ----------------------------------------------------------------------------


def started(controller: Unpacked, **start: float) -> Instance:
    instance = Instance(controller)
    instance.initialize({**GAINS, **start})
    instance.assign({"reference": 6 * UM, "displacement": 5 * UM})
    return instance


HEADER, CHECKSUM = 40, 32
#: Words of the serialized state (struct fmu_snapshot) that hold no doubles: phase and status, findings,
#: the clock's ticks, the flags, the ticks of the last step.
STOP_TIME = 7
#: The last step may have begun before 0.
LAST_STEP = [HEADER + 8 * word for word in (19, 21)]
COUNTS = [HEADER + 8 * word for word in (0, 1, 2, 4, 5, 18, 19, 21, 22)]


@pytest.mark.parametrize("planted", [math.nan, math.inf, -math.inf, -(2**63), 2**63 - 1, 2**62, -1])
def test_a_forged_state_hands_out_no_nan_and_its_steps_return(controller, planted):
    """Each eight bytes of the state in turn, under a checksum that is right."""
    with started(controller) as instance:
        # a last step of several ticks: of one, the ticks follow from the clock and are not read
        assert instance.step(0.0, TS) == OK and instance.step(TS, 2 * TS) == OK
        blob = instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
        for place in range(HEADER, len(blob), 8):
            if isinstance(planted, float) == (place in COUNTS):
                continue
            word = struct.pack("<d" if isinstance(planted, float) else "<q", planted)
            forged = blob[:place] + word + blob[place + 8 :]
            checksum = struct.pack("<Q", fnv1a(forged[HEADER:]))
            forged = forged[:CHECKSUM] + checksum + forged[HEADER:]
            stop_time = place == HEADER + 8 * STOP_TIME and planted == math.inf
            before = place in LAST_STEP and planted == -1
            assert instance.deserialize(forged) == (OK if stop_time or before else ERROR), place


def test_an_integral_that_overflows_discards_the_step(controller):
    """Its two parts are then infinities of opposite sign, and nothing says which limit holds."""
    with started(controller, proportionalGain=-1e300, integralGain=1e300) as instance:
        before = instance.get("voltage")
        instance.assign({"reference": 1e300})
        assert instance.step(0.0, TS) == DISCARD
        assert "no longer finite" in instance.said(DISCARD)[0]
        assert instance.get("voltage") == before
        instance.assign({"reference": 5 * UM})
        assert instance.step(0.0, TS) == OK
