"""Every capability that modelDescription.xml claims is held: each flag has a promise, tried here.

A flag without a promise below fails, and so does a promise that the binary does not keep.
"""

import ctypes

import numpy as np
import pytest
from conftest import CALM, INPUT, OUTPUT, TS, Instance, Unpacked, continue_run
from fmpy import fmi2


def read_after(unpacked: Unpacked, cuts: list[float]) -> float:
    """Return the output at the end of a ramp, with time cut into these steps."""
    with Instance(unpacked) as instance:
        instance.initialize()
        rate, time = CALM[unpacked.model] / (20 * TS), 0.0
        for size in cuts:
            instance.assign({INPUT[unpacked.model]: rate * time})
            instance.slope(INPUT[unpacked.model], rate)
            assert instance.step(time, size) <= fmi2.fmi2Warning, instance.messages
            time += size
        return instance.get(OUTPUT[unpacked.model])


def any_step_size(unpacked: Unpacked) -> None:
    cut = read_after(unpacked, [3.3 * TS, 0.2 * TS, 6.5 * TS])
    assert cut == pytest.approx(read_after(unpacked, [10 * TS]), rel=1e-12)


def inputs_are_interpolated(unpacked: Unpacked) -> None:
    one_step = read_after(unpacked, [10 * TS])
    assert one_step == pytest.approx(read_after(unpacked, [TS] * 10), rel=1e-12)
    with Instance(unpacked) as held:
        held.initialize()
        held.step(0.0, 10 * TS)
        assert held.get(OUTPUT[unpacked.model]) != pytest.approx(one_step, rel=1e-3)


def no_output_derivatives(unpacked: Unpacked) -> None:
    with Instance(unpacked) as instance:
        instance.initialize()
        instance.step(0.0, TS)
        reference = (ctypes.c_uint * 1)(*instance.references([OUTPUT[unpacked.model]]))
        order, value = (ctypes.c_int * 1)(1), (ctypes.c_double * 1)()
        call = instance.fmu.fmi2GetRealOutputDerivatives
        status = instance.status_of(call, instance.fmu.component, reference, 1, order, value)
        assert status == fmi2.fmi2Error


def steps_are_never_pending(unpacked: Unpacked) -> None:
    with Instance(unpacked) as instance:
        instance.initialize()
        assert instance.step(0.0, 100 * TS) in (fmi2.fmi2OK, fmi2.fmi2Warning)


def many_instances_in_a_process(unpacked: Unpacked) -> None:
    with Instance(unpacked) as alone:
        expected = continue_run(alone.initialize(), 0)
    with Instance(unpacked) as one, Instance(unpacked) as other:
        other.initialize({"initialDisplacement": 3e-6})
        continue_run(other, 0)
        assert continue_run(one.initialize(), 0) == expected


def no_memory_functions(unpacked: Unpacked) -> None:
    """Run with null pointers as allocateMemory and freeMemory, as all our tests do."""
    with Instance(unpacked) as instance:
        assert not instance._callbacks.allocateMemory
        assert not instance._callbacks.freeMemory
        continue_run(instance.initialize(), 0)


def state_returns(unpacked: Unpacked) -> None:
    with Instance(unpacked) as instance:
        continue_run(instance.initialize(), 0)
        state = instance.fmu.getFMUstate()
        expected = continue_run(instance, 30)
        instance.fmu.setFMUstate(state)
        assert continue_run(instance, 30) == expected
        instance.fmu.freeFMUstate(state)


def state_survives_as_bytes(unpacked: Unpacked) -> None:
    with Instance(unpacked) as one, Instance(unpacked) as other:
        continue_run(one.initialize(), 0)
        blob = one.fmu.serializeFMUstate(one.fmu.getFMUstate())
        expected = continue_run(one, 30)
        other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(blob))
        assert continue_run(other, 30) == expected


def directional_derivatives(unpacked: Unpacked) -> None:
    """Of the output by the input that the last step ran with."""
    name, calm = INPUT[unpacked.model], CALM[unpacked.model]
    with Instance(unpacked) as instance:
        instance.initialize({"initialDisplacement": 5e-6})
        state, read = instance.fmu.getFMUstate(), []
        for value in calm * np.array([1 - 1e-4, 1 + 1e-4, 1.0]):
            instance.fmu.setFMUstate(state)
            instance.assign({name: float(value)})
            instance.step(0.0, TS)
            read.append(instance.get(OUTPUT[unpacked.model]))
        unknowns, knowns = instance.references([OUTPUT[unpacked.model]]), instance.references([name])
        (derivative,) = instance.fmu.getDirectionalDerivative(unknowns, knowns, [1.0])
        assert derivative == pytest.approx((read[1] - read[0]) / (2e-4 * calm), rel=1e-6)


PROMISES = {
    ("canHandleVariableCommunicationStepSize", "true"): any_step_size,
    ("canInterpolateInputs", "true"): inputs_are_interpolated,
    ("maxOutputDerivativeOrder", "0"): no_output_derivatives,
    ("canRunAsynchronuously", "false"): steps_are_never_pending,
    ("canBeInstantiatedOnlyOncePerProcess", "false"): many_instances_in_a_process,
    ("canNotUseMemoryManagementFunctions", "true"): no_memory_functions,
    ("canGetAndSetFMUstate", "true"): state_returns,
    ("canSerializeFMUstate", "true"): state_survives_as_bytes,
    ("providesDirectionalDerivative", "true"): directional_derivatives,
}


def test_every_flag_is_a_promise_that_is_tried(model):
    assert model.flags == set(PROMISES)


@pytest.mark.parametrize("flag", PROMISES, ids=lambda flag: flag[0])
def test_the_promise_is_kept(model, flag):
    PROMISES[flag](model)
