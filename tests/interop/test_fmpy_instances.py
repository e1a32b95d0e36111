"""Instances share nothing and leak no memory; their states go on in other processes."""

import ctypes
import os
from pathlib import Path

import pytest
from conftest import MODELS, TS, Instance, Master, continue_run, run_python


def test_freeing_one_instance_leaves_the_others(models):
    with Master(models["plant"]) as kept:
        with Master(models["plant"]) as freed:
            freed.advance(50.0)
        kept.advance(50.0)
        assert kept.advance(50.0) > 0


def test_reset_returns_to_the_packaged_set_not_to_table_1(five_rules):
    with Instance(five_rules["plant"]) as instance:
        instance.initialize({"rule[5].q1": 0.4})
        instance.fmu.reset()
        instance.initialize()
        assert instance.get("rule[5].q1") == float(five_rules["plant"].variables["rule[5].q1"].start)


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


def resident_kilobytes() -> int:
    """Return the memory that this process has now."""
    pages = Path("/proc/self/statm")
    if not pages.is_file():
        pytest.skip("needs /proc/self/statm")
    return int(pages.read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


def test_thousands_of_runs_in_one_process_do_not_grow(models):
    """A sweep makes and frees instances by the thousand."""
    with Instance(models["plant"], logging=False) as instance:
        fmu, first = instance.fmu, instance.fmu.component
        guid, callbacks = fmu.guid.encode(), ctypes.byref(instance._callbacks)
        name = 1000 * b"n"  # long, so that a leaked name is seen too

        def runs(count: int) -> int:
            for _ in range(count):
                fmu.component = fmu.fmi2Instantiate(name, 1, guid, None, callbacks, False, False)
                instance.initialize()
                state = fmu.getFMUstate()
                instance.step(0.0, 10 * TS)
                copy = fmu.deSerializeFMUstate(fmu.serializeFMUstate(state))
                fmu.setFMUstate(copy)
                fmu.reset()
                fmu.freeFMUstate(state)
                fmu.freeFMUstate(copy)
                fmu.fmi2FreeInstance(fmu.component)
            return resident_kilobytes()

        before = runs(500)
        after = runs(5000)
        fmu.component = first
    assert after - before < 2000  # a leaked instance or state would be ten thousand and more
