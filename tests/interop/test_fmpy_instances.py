"""Instances share nothing, reset to the last bit and leak no memory."""

import ctypes
import os
from pathlib import Path

import numpy as np
import pytest
from conftest import (
    CALM,
    INPUT,
    MODELS,
    OUTPUT,
    TS,
    UM,
    Instance,
    Master,
)
from fmpy import fmi2

from it2hys.model import compiled
from it2hys.model.parameters import table_1

WARNING, ERROR = fmi2.fmi2Warning, fmi2.fmi2Error


def test_many_instances_share_nothing(models):
    rules = table_1().rules
    levels = np.linspace(5.0, 100.0, 50)
    masters = [Master(models["plant"], {"initialDisplacement": v * 1e-8}) for v in levels]
    try:
        for _ in range(20):
            read = [m.advance(v) for m, v in zip(masters, levels, strict=True)]
    finally:
        for master in masters:
            master.instance.close()
    expected = [compiled.free_run(rules, np.full(20, v), v * 1e-8)[-1] for v in levels]
    np.testing.assert_allclose(read, expected, rtol=1e-12)


def test_freeing_one_instance_leaves_the_others(models):
    with Master(models["plant"]) as kept:
        with Master(models["plant"]) as freed:
            freed.advance(50.0)
        kept.advance(50.0)
        assert kept.advance(50.0) > 0


def run_of(instance: Instance, which: str, count: int = 40) -> bytes:
    """Return the bits of a run from an initialized instance."""
    values = []
    for k in range(count):
        instance.assign({INPUT[which]: CALM[which] * (1 + 0.3 * np.sin(k))})
        assert instance.step(3 * k * TS, 3 * TS) <= WARNING  # a slope left over would show
        values.append(instance.get(OUTPUT[which]))
    return np.array(values).tobytes()


@pytest.mark.parametrize("which", MODELS)
@pytest.mark.parametrize("phase", ["instantiated", "initialization", "step", "terminated", "refused"])
def test_reset_is_complete_from_every_state(models, which, phase):
    with Instance(models[which]) as fresh:
        expected = run_of(fresh.initialize(), which)
    with Instance(models[which]) as instance:
        instance.assign({"initialDisplacement": 3 * UM, "rule[1].q1": 0.88, INPUT[which]: 1e-3})
        instance.slope(INPUT[which], 100 * CALM[which])
        instance.fmu.setupExperiment(startTime=4.0, stopTime=5.0)
        if phase in ("initialization", "step", "terminated"):
            instance.fmu.enterInitializationMode()
        if phase in ("step", "terminated"):
            instance.fmu.exitInitializationMode()
            instance.step(4.0, 0.1)
        if phase == "terminated":
            instance.fmu.terminate()
        if phase == "refused":
            instance.assign({"rule[1].sigmaLower": -1.0})
            instance.fmu.enterInitializationMode()
            assert instance.status_of(instance.fmu.exitInitializationMode) == ERROR
        instance.fmu.reset()
        assert run_of(instance.initialize(), which) == expected


def test_reset_returns_to_the_packaged_set_not_to_table_1(five_rules):
    with Instance(five_rules["plant"]) as instance:
        instance.initialize({"rule[5].q1": 0.4})
        instance.fmu.reset()
        instance.initialize()
        assert instance.get("rule[5].q1") == float(five_rules["plant"].variables["rule[5].q1"].start)


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
