"""What an FMU says and refuses, as FMPy hears it; every call in every phase is tried in C."""

import ctypes

import fmpy
import numpy as np
import pytest
from conftest import INPUT, MODELS, OUTPUT, TS, Instance, Master, make_set, ticks
from fmpy import fmi2
from lxml import etree

from it2hys.stand.excitations import tracking_reference

OK, WARNING, DISCARD, ERROR = fmi2.fmi2OK, fmi2.fmi2Warning, fmi2.fmi2Discard, fmi2.fmi2Error


# --- inputs that cannot be ---------------------------------------------------------------------


@pytest.mark.parametrize("value", [1e300, -1e300, 1.7e308])
@pytest.mark.parametrize("which", MODELS)
def test_a_huge_input_is_survived(models, which, value):
    with Instance(models[which]) as instance:
        instance.initialize()
        instance.assign({INPUT[which]: value})
        assert instance.step(0.0, 3 * TS) in (WARNING, DISCARD)
        assert np.isfinite(instance.get(OUTPUT[which]))


def test_within_the_range_nothing_is_said(models):
    reference = tracking_reference(ticks(400))
    start = {"initialDisplacement": reference[0]}
    with Master(models["inverse"], start) as inverse, Master(models["plant"], start) as plant:
        plant.run(inverse.run(reference))
        assert [m for m in plant.instance.messages + inverse.instance.messages if m[0] != OK] == []


# --- the log -----------------------------------------------------------------------------------


def test_what_comes_with_a_status_is_told_even_where_logging_is_off(models):
    """`loggingOn` is for debugging; fmi2Warning says that the logger was called."""
    with Instance(models["plant"], logging=False) as instance:
        instance.initialize()
        instance.assign({"voltage": -1.0})
        assert instance.step(0.0, TS) == WARNING
        (message,) = instance.said(WARNING)
        assert "voltageMin..voltageMax, 0 to 110 V" in message
        assert "it is -1 V at 0 s" in message
        assert instance.get("outOfRange") == 1
        assert [instance.step(k * TS, TS) for k in range(1, 50)] == 49 * [OK]
        assert instance.step(5.0, TS) == ERROR
        assert len(instance.messages) == 2


def test_a_user_of_fmpys_defaults_is_told_once(models, capfd):
    fmpy.simulate_fmu(str(models["plant"].path), start_values={"voltage": 130.0}, stop_time=0.1)
    said = capfd.readouterr().out
    assert said.count("voltageMin..voltageMax, 0 to 110 V") == 1
    assert said.count("displacementMin..displacementMax, 0 to 16 µm") == 1


def categories(instance: Instance, on: bool, *names: str) -> int:
    return instance.status_of(
        instance.fmu.fmi2SetDebugLogging,
        instance.fmu.component,
        on,
        len(names),
        (ctypes.c_char_p * len(names))(*[n.encode() for n in names]),
    )


def test_categories_are_those_of_the_xml_and_honoured(model):
    root = etree.parse(model.directory / "modelDescription.xml").getroot()
    names = [c.get("name") for c in root.iterfind("LogCategories/Category")]
    assert names
    with Instance(model) as instance:
        for name in names:
            assert categories(instance, True, name) == OK
        assert categories(instance, False) == OK
        instance.messages.clear()
        assert instance.step(0.0, TS) == ERROR  # not initialized
        assert instance.messages == []
        assert categories(instance, True, "logStatusError") == OK
        instance.step(0.0, TS)
        assert [category for _, category, _ in instance.messages] == ["logStatusError"]


def test_variables_of_the_other_fmu_do_not_exist(models):
    """Value references are those of one table; each FMU knows only its own."""
    for which, other in (MODELS, MODELS[::-1]):
        own = {v.valueReference for v in models[which].description.modelVariables}
        with Instance(models[which]) as instance:
            instance.initialize()
            for variable in models[other].description.modelVariables:
                if variable.valueReference not in own:
                    getter = getattr(instance.fmu, f"get{variable.type}")
                    assert instance.status_of(getter, [variable.valueReference]) == ERROR


def test_sets_are_random_but_repeatable():
    assert dict(make_set(5, 5)) == dict(make_set(5, 5))
    assert dict(make_set(5, 5)) != dict(make_set(6, 5))
