"""Every capability that modelDescription.xml claims is held: each flag has a promise, tried here.

A flag without a promise below fails, and so does a promise that the binary does not keep.
"""

import ctypes

import numpy as np
import pytest
from conftest import CALM, INPUT, OUTPUT, TS, UM, Instance, Unpacked, continue_run
from fmpy import fmi2

#: What an FMU needs beside its defaults to answer its input, and the start of another run.
START = {
    "controller": {
        "proportionalGain": 1e6, "integralGain": 3e9, "initialVoltage": 20.0, "reference": 6 * UM,
    },
}  # fmt: skip
OTHER = {"controller": {"initialVoltage": 40.0}}


def started(fmu: Unpacked, **start: float) -> Instance:
    return Instance(fmu).initialize({**START.get(fmu.model, {}), **start})


def read_after(fmu: Unpacked, cuts: list[float], rate: float = 0.0) -> float:
    """Return the output at the end of a ramp from `CALM` on, with time cut into these steps."""
    with started(fmu) as instance:
        name, time = INPUT[fmu.model], 0.0
        for size in cuts:
            instance.assign({name: CALM[fmu.model] + rate * time})
            if rate:
                instance.slope(name, rate)
            assert instance.step(time, size) <= fmi2.fmi2Warning, instance.messages
            time += size
        return instance.get(OUTPUT[fmu.model])


def any_step_size(fmu: Unpacked) -> None:
    cuts = ([10 * TS], [TS] * 10, [3.3 * TS, 0.2 * TS, 6.5 * TS], [0.5 * TS] * 20)
    assert len({read_after(fmu, sizes) for sizes in cuts}) == 1


def inputs_are_interpolated(fmu: Unpacked) -> None:
    rate = CALM[fmu.model] / (20 * TS)
    one_step = read_after(fmu, [10 * TS], rate)
    for cuts in ([TS] * 10, [3.3 * TS, 0.2 * TS, 6.5 * TS]):
        assert one_step == pytest.approx(read_after(fmu, cuts, rate), rel=1e-12)
    assert read_after(fmu, [10 * TS]) != pytest.approx(one_step, rel=1e-3)


def inputs_are_held(fmu: Unpacked) -> None:
    with started(fmu) as instance:
        call = instance.fmu.setRealInputDerivatives
        references = instance.references([INPUT[fmu.model]])
        assert instance.status_of(call, references, [1], [1.0]) == fmi2.fmi2Error
        assert "not supported" in instance.said(fmi2.fmi2Error)[0]


def no_output_derivatives(fmu: Unpacked) -> None:
    with started(fmu) as instance:
        instance.step(0.0, TS)
        reference = (ctypes.c_uint * 1)(*instance.references([OUTPUT[fmu.model]]))
        order, value = (ctypes.c_int * 1)(1), (ctypes.c_double * 1)()
        call = instance.fmu.fmi2GetRealOutputDerivatives
        status = instance.status_of(call, instance.fmu.component, reference, 1, order, value)
        assert status == fmi2.fmi2Error


def steps_are_never_pending(fmu: Unpacked) -> None:
    with started(fmu) as instance:
        assert instance.step(0.0, 100 * TS) in (fmi2.fmi2OK, fmi2.fmi2Warning)
        assert instance.fmu.getRealStatus(fmi2.fmi2LastSuccessfulTime) == 100 * TS


def many_instances_in_a_process(fmu: Unpacked) -> None:
    with started(fmu) as alone:
        expected = continue_run(alone, 0)
    other_start = OTHER.get(fmu.model, {"initialDisplacement": 3 * UM})
    with started(fmu) as one, started(fmu, **other_start) as other:
        pairs = [(continue_run(other, k, 1), continue_run(one, k, 1)) for k in range(30)]
    assert b"".join(own for _, own in pairs) == expected
    assert any(others != own for others, own in pairs)


def no_memory_functions(fmu: Unpacked) -> None:
    """Run with null pointers as allocateMemory and freeMemory, as all our tests do."""
    with started(fmu) as instance:
        assert not instance._callbacks.allocateMemory
        assert not instance._callbacks.freeMemory
        continue_run(instance, 0)


def state_returns(fmu: Unpacked) -> None:
    """Even out of termination."""
    with started(fmu) as instance:
        continue_run(instance, 0)
        state = instance.fmu.getFMUstate()
        expected = continue_run(instance, 30)
        for _ in range(2):
            instance.fmu.setFMUstate(state)
            assert continue_run(instance, 30) == expected
            instance.fmu.terminate()
        instance.fmu.freeFMUstate(state)


def state_survives_as_bytes(fmu: Unpacked) -> None:
    with started(fmu) as one, Instance(fmu) as other:
        continue_run(one, 0)
        blob = one.fmu.serializeFMUstate(one.fmu.getFMUstate())
        expected = continue_run(one, 30)
        other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(blob))
        assert other.fmu.serializeFMUstate(other.fmu.getFMUstate()) == blob
        assert continue_run(other, 30) == expected


def directional_derivatives(fmu: Unpacked) -> None:
    """Of the output by the input that the last step ran with."""
    name, calm = INPUT[fmu.model], CALM[fmu.model]
    with started(fmu, initialDisplacement=5e-6) as instance:
        state, read = instance.fmu.getFMUstate(), []
        for value in calm * np.array([1 - 1e-4, 1 + 1e-4, 1.0]):
            instance.fmu.setFMUstate(state)
            instance.assign({name: float(value)})
            instance.step(0.0, TS)
            read.append(instance.get(OUTPUT[fmu.model]))
        unknowns, knowns = instance.references([OUTPUT[fmu.model]]), instance.references([name])
        (derivative,) = instance.fmu.getDirectionalDerivative(unknowns, knowns, [1.0])
        assert derivative == pytest.approx((read[1] - read[0]) / (2e-4 * calm), rel=1e-6)


def no_directional_derivatives(fmu: Unpacked) -> None:
    with started(fmu) as instance:
        references = (instance.references([n[fmu.model]]) for n in (OUTPUT, INPUT))
        call = instance.fmu.getDirectionalDerivative
        assert instance.status_of(call, *references, [1.0]) == fmi2.fmi2Error


PROMISES = {
    ("canHandleVariableCommunicationStepSize", "true"): any_step_size,
    ("canInterpolateInputs", "true"): inputs_are_interpolated,
    ("canInterpolateInputs", "false"): inputs_are_held,
    ("maxOutputDerivativeOrder", "0"): no_output_derivatives,
    ("canRunAsynchronuously", "false"): steps_are_never_pending,
    ("canBeInstantiatedOnlyOncePerProcess", "false"): many_instances_in_a_process,
    ("canNotUseMemoryManagementFunctions", "true"): no_memory_functions,
    ("canGetAndSetFMUstate", "true"): state_returns,
    ("canSerializeFMUstate", "true"): state_survives_as_bytes,
    ("providesDirectionalDerivative", "true"): directional_derivatives,
    ("providesDirectionalDerivative", "false"): no_directional_derivatives,
}
FLAGS = sorted({flag for flag, _ in PROMISES})


def test_every_flag_is_a_promise_that_is_tried(fmu):
    assert {flag for flag, _ in fmu.flags} == set(FLAGS)


@pytest.mark.parametrize("flag", FLAGS)
def test_the_promise_is_kept(fmu, flag):
    PROMISES[flag, dict(fmu.flags)[flag]](fmu)
