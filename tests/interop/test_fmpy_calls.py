"""Calls and values that cannot be: refused with a reason, and nothing changes."""

import ctypes

import fmpy
import numpy as np
import pytest
from conftest import (
    CALM,
    INPUT,
    MODELS,
    OUTPUT,
    TS,
    Instance,
    Master,
    make_set,
    ticks,
)
from fmpy import fmi2
from lxml import etree

from it2hys.stand.excitations import tracking_reference

OK, WARNING, DISCARD, ERROR = fmi2.fmi2OK, fmi2.fmi2Warning, fmi2.fmi2Discard, fmi2.fmi2Error


# --- inputs that cannot be ---------------------------------------------------------------------


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("which", MODELS)
def test_an_input_that_is_not_finite_is_refused_and_the_last_value_stays(models, which, bad):
    with Instance(models[which]) as instance, Instance(models[which]) as unharmed:
        for each in (instance, unharmed):
            each.initialize().assign({INPUT[which]: CALM[which]})
            each.step(0.0, TS)
        references = instance.references([INPUT[which], "force"])
        status = instance.status_of(instance.fmu.setReal, references[::-1], [1.0, bad])
        assert status == DISCARD
        (message,) = instance.said(DISCARD)
        assert INPUT[which] in message
        assert "finite" in message
        assert instance.get(INPUT[which]) == CALM[which]
        assert instance.get("force") == 0.0  # all are checked before any is set
        assert instance.status_of(
            instance.fmu.setRealInputDerivatives, references[:1], [1], [bad]
        ) == DISCARD  # fmt: skip
        for each in (instance, unharmed):
            each.step(TS, 5 * TS)
        assert instance.get(OUTPUT[which]) == unharmed.get(OUTPUT[which])


@pytest.mark.parametrize("value", [1e300, -1e300, 1.7e308])
@pytest.mark.parametrize("which", MODELS)
def test_a_huge_input_is_survived(models, which, value):
    with Instance(models[which]) as instance:
        instance.initialize()
        instance.assign({INPUT[which]: value})
        assert instance.step(0.0, 3 * TS) in (WARNING, DISCARD)
        assert np.isfinite(instance.get(OUTPUT[which]))


def test_leaving_the_range_is_said_once(plant):
    plant.initialize()
    plant.assign({"voltage": -10.0})
    statuses = [plant.step(k * TS, TS) for k in range(20)]
    assert statuses == [WARNING] + 19 * [OK]
    warnings = plant.said(WARNING)
    assert len(warnings) == 2
    assert "voltageMin..voltageMax" in warnings[0]
    assert "displacementMin..displacementMax" in warnings[1]
    plant.fmu.reset()
    plant.initialize()
    plant.assign({"voltage": -10.0})
    plant.step(0.0, TS)
    assert len(plant.said(WARNING)) > 2  # but a new run says it again


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


def test_an_unknown_category_is_refused_by_name(plant):
    assert categories(plant, True, "logEvents", "logNonsense%s") == ERROR
    assert "logNonsense%s" in plant.said(ERROR)[-1]


# --- calls out of order ------------------------------------------------------------------------


def in_state(instance: Instance, state: str) -> Instance:
    instance.fmu.setupExperiment()
    if state != "instantiated":
        instance.fmu.enterInitializationMode()
    if state in ("stepComplete", "terminated"):
        instance.fmu.exitInitializationMode()
        instance.assign({"voltage": 50.0})
        instance.step(0.0, TS)
    if state == "terminated":
        instance.fmu.terminate()
    return instance


CALLS = {
    "fmi2SetupExperiment": lambda i: i.fmu.setupExperiment(),
    "fmi2EnterInitializationMode": lambda i: i.fmu.enterInitializationMode(),
    "fmi2ExitInitializationMode": lambda i: i.fmu.exitInitializationMode(),
    "fmi2DoStep": lambda i: i.fmu.doStep(TS, TS),
    "fmi2Terminate": lambda i: i.fmu.terminate(),
    "fmi2GetReal": lambda i: i.get("displacement"),
    "fmi2GetInteger": lambda i: i.get("ruleCount"),
    "fmi2SetReal": lambda i: i.assign({"voltage": 50.0}),
    "fmi2SetInteger": lambda i: i.assign({"ruleCount": 3}),
    "fmi2SetRealInputDerivatives": lambda i: i.slope("voltage", 1.0),
    "fmi2GetDirectionalDerivative": lambda i: i.fmu.getDirectionalDerivative(
        i.references(["displacement"]), i.references(["voltage"]), [1.0]
    ),
    "fmi2GetRealStatus": lambda i: i.fmu.getRealStatus(fmi2.fmi2LastSuccessfulTime),
}
ALLOWED = {
    "instantiated": {
        "fmi2SetupExperiment", "fmi2EnterInitializationMode", "fmi2SetReal", "fmi2SetInteger",
        "fmi2SetRealInputDerivatives",
    },
    "initializationMode": {
        "fmi2ExitInitializationMode", "fmi2GetReal", "fmi2GetInteger", "fmi2SetReal",
        "fmi2SetInteger", "fmi2SetRealInputDerivatives", "fmi2GetDirectionalDerivative",
    },
    "stepComplete": {
        "fmi2DoStep", "fmi2Terminate", "fmi2GetReal", "fmi2GetInteger", "fmi2SetReal",
        "fmi2SetRealInputDerivatives", "fmi2GetDirectionalDerivative", "fmi2GetRealStatus",
    },
    "terminated": {
        "fmi2GetReal", "fmi2GetInteger", "fmi2GetDirectionalDerivative", "fmi2GetRealStatus"
    },
}  # fmt: skip


@pytest.mark.parametrize("state", ALLOWED)
@pytest.mark.parametrize("call", CALLS)
def test_calls_are_allowed_where_the_standard_says_and_refused_elsewhere(models, state, call):
    with Instance(models["plant"]) as instance:
        in_state(instance, state)
        status = instance.status_of(lambda: CALLS[call](instance) and OK)
        if call in ALLOWED[state]:
            assert status == OK, instance.messages
            return
        assert status == ERROR
        (message,) = instance.said(ERROR)
        assert call in message
        fixed = call == "fmi2SetInteger" and state == "stepComplete"  # a parameter, not the state
        assert ("fixed parameter" if fixed else state) in message
        if state == "stepComplete":  # as if nothing had happened
            assert instance.step(TS, TS) == OK


@pytest.mark.parametrize(
    ("time", "size", "phrase"),
    [
        (5 * TS, TS, "the step begins at"),
        (0.0, TS, "set an earlier FMU state"),
        (TS, -TS, "not negative"),
        (TS, np.nan, "finite"),
        (np.inf, TS, "finite"),
        (TS, 1e300, "counted"),
    ],
)
def test_a_step_that_cannot_be_made_is_refused_and_the_next_one_works(plant, time, size, phrase):
    plant.initialize().assign({"voltage": 50.0})
    plant.step(0.0, TS)
    before = plant.get("displacement")
    assert plant.step(time, size) == ERROR
    assert phrase in plant.said(ERROR)[-1]
    assert plant.get("displacement") == before
    assert plant.step(TS, TS) == OK


def test_a_step_beyond_the_stop_time_is_refused(plant):
    plant.initialize(stop_time=3 * TS)
    assert plant.step(0.0, 3 * TS) == OK
    assert plant.step(3 * TS, TS) == ERROR
    assert "stopTime" in plant.said(ERROR)[-1]


def test_unknown_references_wrong_types_and_outputs_are_refused_by_name(plant):
    plant.initialize()
    fmu = plant.fmu
    for call, phrase in [
        (lambda: fmu.getReal([99_999]), "99999"),
        (lambda: fmu.getReal(plant.references(["ruleCount"])), "ruleCount is of type Integer"),
        (lambda: fmu.getInteger(plant.references(["voltage"])), "voltage is of type Real"),
        (lambda: fmu.getString(plant.references(["voltage"])), "voltage is of type Real"),
        (lambda: fmu.getBoolean(plant.references(["voltage"])), "voltage is of type Real"),
        (lambda: plant.assign({"displacement": 1.0}), "displacement is an output"),
        (lambda: plant.assign({"rule[1].q1": 0.9}), "rule[1].q1 is a fixed parameter"),
        (lambda: plant.slope("displacement", 1.0), "displacement is not an input"),
        (lambda: fmu.setRealInputDerivatives(plant.references(["voltage"]), [2], [1.0]), "order 2"),
        (lambda: fmu.getRealOutputDerivatives(plant.references(["displacement"]), [1]), "held"),
        (fmu.cancelStep, "no step is in progress"),
    ]:
        assert plant.status_of(lambda call=call: call() and OK) == ERROR
        assert phrase in plant.said(ERROR)[-1]


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


def test_null_pointers_are_refused(plant):
    plant.initialize()
    fmu, c = plant.fmu, plant.fmu.component
    for call in (
        lambda: fmu.fmi2GetReal(c, None, 1, None),
        lambda: fmu.fmi2SetReal(c, None, 1, None),
        lambda: fmu.fmi2SetRealInputDerivatives(c, None, 1, None, None),
        lambda: fmu.fmi2GetFMUstate(c, None),
        lambda: fmu.fmi2SetFMUstate(c, None),
        lambda: fmu.fmi2DeSerializeFMUstate(c, None, 10, None),
        lambda: fmu.fmi2GetDirectionalDerivative(c, None, 1, None, 1, None, None),
        lambda: fmu.fmi2SetDebugLogging(c, True, 1, None),
        lambda: fmu.fmi2GetRealStatus(c, 2, None),
        lambda: fmu.fmi2DoStep(None, 0.0, TS, True),
        lambda: fmu.fmi2Reset(None),
    ):
        assert plant.status_of(call) == ERROR
    assert fmu.fmi2GetReal(c, None, 0, None) == OK
    fmu.fmi2FreeInstance(None)
    assert plant.step(0.0, TS) == OK


def test_an_instance_can_be_made_without_a_logger(models):
    unpacked = models["plant"]
    fmu = fmi2.FMU2Slave(
        guid=unpacked.description.guid,
        unzipDirectory=str(unpacked.directory),
        modelIdentifier=unpacked.identifier,
    )
    guid = fmu.guid.encode()
    component = fmu.fmi2Instantiate(b"quiet", fmi2.fmi2CoSimulation, guid, None, None, False, True)
    assert component
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmu.fmi2DoStep(component, 0.0, TS, True)
    fmu.fmi2FreeInstance(component)


def test_model_exchange_and_nameless_instances_are_refused(models):
    unpacked = models["plant"]
    with Instance(unpacked) as instance:
        fmu, guid = instance.fmu, unpacked.description.guid.encode()
        callbacks = ctypes.byref(instance._callbacks)
        for name, kind, phrase in [(b"x", 0, "co-simulation"), (b"", 1, "name"), (None, 1, "name")]:
            assert not fmu.fmi2Instantiate(name, kind, guid, None, callbacks, False, True)
            assert phrase in instance.said(ERROR)[-1]


def test_an_instance_name_with_percent_signs_does_no_harm(models):
    with Instance(models["plant"], name="100%s %n ä") as instance:
        assert instance.step(0.0, TS) == ERROR


def test_sets_are_random_but_repeatable():
    assert dict(make_set(5, 5)) == dict(make_set(5, 5))
    assert dict(make_set(5, 5)) != dict(make_set(6, 5))
