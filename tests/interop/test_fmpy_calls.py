"""What the packaged FMUs say, and which variables they know.

Every call of the standard, in and out of order, with arguments that cannot be, is tried in C
(fmu_src/tests/test_fmi2_*.c).
"""

import ctypes

import fmpy
from conftest import MODELS, TS, Instance, Master, make_set, ticks
from fmpy import fmi2
from lxml import etree

from it2hys.stand.excitations import tracking_reference

OK, ERROR = fmi2.fmi2OK, fmi2.fmi2Error


def test_within_the_range_nothing_is_said(models):
    reference = tracking_reference(ticks(400))
    start = {"initialDisplacement": reference[0]}
    with Master(models["inverse"], start) as inverse, Master(models["plant"], start) as plant:
        plant.run(inverse.run(reference))
        assert [m for m in plant.instance.messages + inverse.instance.messages if m[0] != OK] == []


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


def test_categories_are_those_of_the_xml_and_honoured(fmu):
    root = etree.parse(fmu.directory / "modelDescription.xml").getroot()
    names = [c.get("name") for c in root.iterfind("LogCategories/Category")]
    assert names
    with Instance(fmu) as instance:
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
