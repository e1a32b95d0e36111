"""PIController.fmu: its equations, its ticks, and every capability that its XML claims."""

import ctypes
import math
import struct
from collections.abc import Sequence

import numpy as np
import pytest
from conftest import TS, UM, Instance, Unpacked
from fmpy import fmi2
from fmpy.validation import validate_fmu
from lxml import etree

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


def test_the_controllers_ticks_do_not_depend_on_the_steps(controller):
    gains = {"integralGain": 1e9}
    inputs = {"reference": 6 * UM, "displacement": 5 * UM}
    results = []
    for size in (TS, 0.3 * TS, 7 * TS):
        with Slave(controller.path, gains) as slave:
            time, steps = 0.0, round(2.1e-2 / size)
            for k in range(steps):
                slave.step(k * size, size, inputs)
                time = (k + 1) * size
            assert math.isclose(time, 2.1e-2)
            results.append(slave.get("voltage"))
    assert results[0] == results[1] == results[2] > 0


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


def test_the_controller_refuses_a_step_beyond_the_stop_time(controller):
    with Instance(controller) as instance:
        instance.initialize(GAINS, stop_time=1.0)
        assert instance.step(0.0, 2.0) == ERROR
        assert "after stopTime, 1 s" in instance.said(ERROR)[0]
        assert instance.step(0.0, 1.0) == OK
        assert instance.step(1.0, TS) == ERROR


@pytest.mark.parametrize(("stop_time", "status"), [(0.5, ERROR), (math.nan, ERROR), (math.inf, OK)])
def test_a_stop_time_before_the_start_is_refused_and_infinity_is_none(controller, stop_time, status):
    with Instance(controller) as instance:
        assert instance.status_of(instance.fmu.setupExperiment, None, 1.0, stop_time) == status
        assert status == OK or "stopTime" in instance.said(ERROR)[0]


# --- capabilities ------------------------------------------------------------------------------


def started(controller: Unpacked, **start: float) -> Instance:
    instance = Instance(controller)
    instance.initialize({**GAINS, **start})
    instance.assign({"reference": 6 * UM, "displacement": 5 * UM})
    return instance


def after(instance: Instance, cuts: Sequence[float], first: float = 0.0) -> list[float]:
    """Return the voltage after each of these steps, with an error that changes from step to step."""
    read, time = [], first
    for size in cuts:
        instance.assign({"displacement": (5 + math.sin(1e4 * time)) * UM})
        assert instance.step(time, size) == OK, instance.messages
        time += size
        read.append(instance.get("voltage"))
    return read


def any_step_size(controller: Unpacked) -> None:
    held = []
    for cuts in ([10 * TS], [TS] * 10, [3.3 * TS, 0.2 * TS, 6.5 * TS], [0.5 * TS] * 20):
        with started(controller) as instance:
            time = 0.0
            for size in cuts:
                assert instance.step(time, size) == OK, instance.messages
                time += size
            held.append(instance.get("voltage"))
    assert len(set(held)) == 1
    assert held[0] == pytest.approx(20.0 + 1.0 + 10 * 3e9 * TS * 1e-6, rel=1e-12)


def inputs_are_held(controller: Unpacked) -> None:
    with started(controller) as instance:
        call = instance.fmu.setRealInputDerivatives
        assert instance.status_of(call, instance.references(["reference"]), [1], [1.0]) == ERROR
        assert "not supported" in instance.said(ERROR)[0]


def no_output_derivatives(controller: Unpacked) -> None:
    with started(controller) as instance:
        call = instance.fmu.getRealOutputDerivatives
        assert instance.status_of(call, instance.references(["voltage"]), [1]) == ERROR


def steps_are_never_pending(controller: Unpacked) -> None:
    with started(controller) as instance:
        assert instance.step(0.0, 100 * TS) == OK
        assert instance.fmu.getRealStatus(fmi2.fmi2LastSuccessfulTime) == 100 * TS


def many_instances_in_a_process(controller: Unpacked) -> None:
    with started(controller) as alone:
        expected = after(alone, [TS] * 20)
    with started(controller) as one, started(controller, initialVoltage=40.0) as other:
        pairs = []
        for k in range(20):
            pairs.append(after(one, [TS], k * TS) + after(other, [TS], k * TS))
    assert [a for a, _ in pairs] == pytest.approx(expected, rel=1e-9)
    assert all(b - a == pytest.approx(20.0) for a, b in pairs)


def no_memory_functions(controller: Unpacked) -> None:
    with started(controller) as instance:
        assert not instance._callbacks.allocateMemory
        assert not instance._callbacks.freeMemory


def state_returns(controller: Unpacked) -> None:
    with started(controller) as instance:
        after(instance, [TS] * 7)
        state = instance.fmu.getFMUstate()
        expected = after(instance, [TS] * 30, 7 * TS)
        for _ in range(2):
            instance.fmu.setFMUstate(state)
            assert after(instance, [TS] * 30, 7 * TS) == expected
        instance.fmu.terminate()
        instance.fmu.setFMUstate(state)  # even out of termination
        assert after(instance, [TS] * 30, 7 * TS) == expected
        instance.fmu.freeFMUstate(state)


def state_survives_as_bytes(controller: Unpacked) -> None:
    with started(controller) as one, Instance(controller) as other:
        after(one, [TS] * 7)
        blob = one.fmu.serializeFMUstate(one.fmu.getFMUstate())
        expected = after(one, [TS] * 30, 7 * TS)
        other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(blob))
        assert other.fmu.serializeFMUstate(other.fmu.getFMUstate()) == blob
        assert after(other, [TS] * 30, 7 * TS) == expected


def no_directional_derivatives(controller: Unpacked) -> None:
    with started(controller) as instance:
        references = (instance.references([n]) for n in ("voltage", "reference"))
        call = instance.fmu.getDirectionalDerivative
        assert instance.status_of(call, *references, [1.0]) == ERROR


PROMISES = {
    ("canHandleVariableCommunicationStepSize", "true"): any_step_size,
    ("canInterpolateInputs", "false"): inputs_are_held,
    ("maxOutputDerivativeOrder", "0"): no_output_derivatives,
    ("canRunAsynchronuously", "false"): steps_are_never_pending,
    ("canBeInstantiatedOnlyOncePerProcess", "false"): many_instances_in_a_process,
    ("canNotUseMemoryManagementFunctions", "true"): no_memory_functions,
    ("canGetAndSetFMUstate", "true"): state_returns,
    ("canSerializeFMUstate", "true"): state_survives_as_bytes,
    ("providesDirectionalDerivative", "false"): no_directional_derivatives,
}


def test_every_flag_is_a_promise_that_is_tried(controller):
    assert controller.flags == set(PROMISES)


@pytest.mark.parametrize("flag", PROMISES, ids=lambda flag: flag[0])
def test_the_promise_is_kept(controller, flag):
    PROMISES[flag](controller)


# --- what cannot be ----------------------------------------------------------------------------


def test_bytes_that_are_no_state_are_refused(controller):
    with started(controller) as instance:
        blob = instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
        damaged = [b"", blob[:-1], blob + b"\0", bytes(len(blob))]
        for place in range(len(blob)):
            damaged.append(blob[:place] + bytes([blob[place] ^ 0x10]) + blob[place + 1 :])
        assert {instance.deserialize(bad) for bad in damaged} == {ERROR}
        assert instance.deserialize(blob) == OK


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
        after(instance, [TS] * 5 + [2 * TS])
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


def test_null_pointers_and_unknown_categories_are_refused(controller):
    with started(controller) as instance:
        fmu, c = instance.fmu, instance.fmu.component
        names = (ctypes.c_char_p * 1)(b"logNonsense%s")
        for call in (
            lambda: fmu.fmi2GetReal(c, None, 1, None),
            lambda: fmu.fmi2GetBoolean(c, None, 1, None),
            lambda: fmu.fmi2SetReal(c, None, 1, None),
            lambda: fmu.fmi2GetFMUstate(c, None),
            lambda: fmu.fmi2SetFMUstate(c, None),
            lambda: fmu.fmi2DeSerializeFMUstate(c, None, 10, None),
            lambda: fmu.fmi2GetRealStatus(c, 2, None),
            lambda: fmu.fmi2DoStep(None, 0.0, TS, True),
            lambda: fmu.fmi2SetDebugLogging(c, True, 1, names),
        ):
            assert instance.status_of(call) == ERROR
        assert "logNonsense%s" in instance.said(ERROR)[-1]
        assert instance.step(0.0, TS) == OK


def test_log_categories_are_honoured(controller):
    with started(controller) as instance:
        root = etree.parse(controller.directory / "modelDescription.xml").getroot()
        listed = [c.get("name") for c in root.iterfind("LogCategories/Category")]
        said = {}
        for name in listed:
            for on in (False, True):
                names = (ctypes.c_char_p * 1)(name.encode())
                instance.fmu.fmi2SetDebugLogging(instance.fmu.component, on, 1, names)
                instance.messages.clear()
                assert instance.step(5.0, TS) == ERROR
                said[name, on] = len(instance.messages)
        assert said == {
            ("logEvents", False): 1,
            ("logEvents", True): 1,
            ("logStatusError", False): 0,
            ("logStatusError", True): 1,
            ("logStatusWarning", False): 1,
            ("logStatusWarning", True): 1,
            ("logStatusDiscard", False): 1,
            ("logStatusDiscard", True): 1,
            ("logAll", False): 0,
            ("logAll", True): 1,
        }
