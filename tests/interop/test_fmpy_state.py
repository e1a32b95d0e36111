"""FMU states: exact, movable between instances and processes; what is no state is refused."""

import numpy as np
import pytest
from conftest import (
    MODELS,
    UM,
    Instance,
    continue_run,
    run_python,
)
from fmpy import fmi2

OK, ERROR = fmi2.fmi2OK, fmi2.fmi2Error


@pytest.mark.parametrize("which", MODELS)
def test_rollback_repeats_the_run_bit_for_bit(models, which):
    with Instance(models[which]) as instance:
        continue_run(instance.initialize(), 0)
        state = instance.fmu.getFMUstate()
        first = continue_run(instance, 30)
        for _ in range(2):
            instance.fmu.setFMUstate(state)
            assert continue_run(instance, 30) == first
        instance.fmu.terminate()
        instance.fmu.setFMUstate(state)  # even out of termination
        assert continue_run(instance, 30) == first
        instance.fmu.freeFMUstate(state)


@pytest.mark.parametrize("which", MODELS)
def test_a_state_of_one_instance_continues_in_another(models, which):
    parameters = {"initialDisplacement": 2 * UM, "rule[1].q1": 0.88}
    with Instance(models[which]) as one, Instance(models[which]) as other:
        continue_run(one.initialize(parameters), 0)
        blob = one.fmu.serializeFMUstate(one.fmu.getFMUstate())
        assert one.fmu.serializeFMUstate(one.fmu.getFMUstate()) == blob
        expected = continue_run(one, 30)
        other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(blob))
        assert other.get("rule[1].q1") == 0.88
        assert continue_run(other, 30) == expected


CONTINUE = """
import sys
from pathlib import Path
from conftest import Instance, Unpacked, continue_run
unpacked = Unpacked(Path(sys.argv[1]), Path(sys.argv[2]))
with Instance(unpacked) as instance:
    instance.fmu.setFMUstate(instance.fmu.deSerializeFMUstate(Path(sys.argv[3]).read_bytes()))
    print(continue_run(instance, 30).hex())
"""


@pytest.mark.parametrize("which", MODELS)
def test_a_state_continues_in_another_process_bit_for_bit(models, tmp_path, which):
    with Instance(models[which]) as instance:
        continue_run(instance.initialize(), 0)
        blob = tmp_path / "state"
        blob.write_bytes(instance.fmu.serializeFMUstate(instance.fmu.getFMUstate()))
        expected = continue_run(instance, 30).hex()
    out = run_python(CONTINUE, models[which].path, tmp_path / "fmu", blob)
    assert out.strip() == expected


def test_bytes_that_are_no_state_are_refused_and_change_nothing(models):
    with Instance(models["plant"]) as instance, Instance(models["inverse"]) as other:
        instance.initialize()
        other.initialize()
        continue_run(instance, 0)
        blob = instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
        foreign = other.fmu.serializeFMUstate(other.fmu.getFMUstate())
        state = instance.fmu.getFMUstate()
        expected = continue_run(instance, 30)
        instance.fmu.setFMUstate(state)
        rng = np.random.default_rng(3)
        damaged = [
            b"",
            b"x",
            blob[:-1],
            blob + b"\0",
            bytes(len(blob)),
            rng.bytes(len(blob)),
            foreign,
        ]
        for place in rng.integers(0, len(blob), 40):
            changed = bytearray(blob)
            changed[place] ^= 1 << rng.integers(8)
            damaged.append(bytes(changed))
        for bad in damaged:
            assert instance.deserialize(bad) == ERROR
        assert len(instance.said(ERROR)) == len(damaged)
        assert instance.deserialize(blob) == OK
        assert continue_run(instance, 30) == expected


INVENTED = """
import ctypes, struct, sys
from pathlib import Path
from conftest import Instance, Unpacked

def checksum(data):
    value = 14695981039346656037
    for byte in data:
        value = (value ^ byte) * 1099511628211 % 2**64
    return struct.pack("<Q", value)

unpacked = Unpacked(Path(sys.argv[1]), Path(sys.argv[2]))
with Instance(unpacked) as instance:
    instance.initialize()
    fmu = instance.fmu
    for k in range(3):
        instance.step(k * 1e-4, 1e-4)
    good = fmu.getFMUstate()
    blob = fmu.serializeFMUstate(good)
    head, body = blob[:32], blob[40:]
    assert blob[32:40] == checksum(body)
    refused = accepted = 0
    for place in range(0, len(body), 8):
        for value in (2**63, 2**63 - 1, 2**62, 2**53, 0x7FF8 << 48, 0x7FE << 52, 2**32 - 1):
            changed = body[:place] + struct.pack("<Q", value) + body[place + 8 :]
            try:
                state = fmu.deSerializeFMUstate(head + checksum(changed) + changed)
            except Exception:
                refused += 1
                continue
            accepted += 1
            fmu.setFMUstate(state)
            for call in (
                lambda: instance.step(fmu.getRealStatus(2), 1e-3),
                lambda: fmu.getDirectionalDerivative(
                    instance.references(["displacement"]), instance.references(["voltage"]), [1.0]
                ),
                lambda: instance.get("displacement"),
            ):
                instance.status_of(lambda call=call: call() and 0)
            fmu.freeFMUstate(state)
    fmu.setFMUstate(good)
    assert instance.step(3e-4, 1e-4) == 0
    print(refused, accepted)
"""


def test_an_invented_state_with_a_right_checksum_neither_crashes_nor_hangs(models, tmp_path):
    out = run_python(INVENTED, models["plant"].path, tmp_path / "fmu", timeout=30)
    refused, accepted = map(int, out.split())
    assert refused > 100
    assert accepted > 100  # inputs and rules of other values are states like any other
