"""FMUs of FMI 3.0: the numbers of FMI 2.0, arrays, intermediate update, early return, derivatives."""

import fmpy
import numpy as np
import pytest
from conftest import CALM, INPUT, MODELS, OUTPUT, TS, UM, Master, make_set, package_models
from conftest import Instance as Instance2
from effects import with_effects
from fmi3 import DISCARD, ERROR, OK, Instance, swing

from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import table_1

FIVE = make_set(5, 5, "five rules")


@pytest.fixture(scope="module")
def of_fmi3(tmp_path_factory):
    """Return both FMUs with Table 1, by model."""
    return package_models(table_1(), tmp_path_factory.mktemp("table-1-fmi3"), 3)


@pytest.fixture(scope="module")
def five_of_fmi3(tmp_path_factory):
    """Return both FMUs with five rules, by model."""
    return package_models(FIVE, tmp_path_factory.mktemp("five-rules-fmi3"), 3)


@pytest.fixture(params=MODELS)
def fmu(request, of_fmi3):
    """Return each FMU with Table 1 in turn."""
    return of_fmi3[request.param]


def at_rest(model: str) -> dict[str, float]:
    """Return start values from which a model does not leave its range."""
    return {INPUT[model]: CALM[model], "initialDisplacement": CALM["inverse"]}


# --- the numbers of FMI 2.0 --------------------------------------------------------------------

SETS = {
    "table_1": table_1(),
    "sixteen_rules": make_set(16, 16, "sixteen rules"),
    "all_effects": with_effects(EFFECTS, seed=3),
}


@pytest.mark.parametrize("which", MODELS)
@pytest.mark.parametrize("name", SETS)
def test_a_run_gives_the_bits_of_the_fmu_of_fmi_2(name, which, tmp_path):
    """Table 1 has no play and no creep, and its arrays one element each that changes nothing."""
    two = package_models(SETS[name], tmp_path / "two")[which]
    three = package_models(SETS[name], tmp_path / "three", 3)[which]
    signal = swing(which)
    with Master(two) as master:
        expected = master.run(signal)
    with Instance(three) as instance:
        assert instance.initialize().run(signal) == expected.tolist()


@pytest.mark.parametrize("which", MODELS)
def test_fmpy_simulates_both_versions_to_equal_numbers(which, models, of_fmi3):
    time = np.arange(400) * TS
    signal = np.array(list(zip(time, swing(which, 400), strict=True)),
                      dtype=[("time", float), (INPUT[which], float)])  # fmt: skip
    arguments = {"input": signal, "stop_time": time[-1], "output_interval": 4 * TS}
    two, three = (
        fmpy.simulate_fmu(str(unpacked.path), **arguments)
        for unpacked in (models[which], of_fmi3[which])
    )
    assert two.dtype.names == three.dtype.names
    for name in two.dtype.names:
        np.testing.assert_array_equal(two[name], three[name])


def test_a_long_step_without_an_update_holds_its_input(fmu):
    with Instance(fmu) as once, Instance(fmu) as often:
        assert once.initialize({INPUT[fmu.model]: CALM[fmu.model]}).step(0.0, 20 * TS)[2] == 20 * TS
        expected = often.initialize().run([CALM[fmu.model]] * 20)[-1]
        assert once.get(OUTPUT[fmu.model]) == expected


def test_time_is_a_variable(fmu):
    with Instance(fmu) as instance:
        instance.initialize(startTime=0.5)
        assert instance.get("time") == 0.5
        instance.step(0.5, 3 * TS)
        assert instance.get("time") == 0.5 + 3 * TS
        voltage = instance.reference(INPUT[fmu.model])
        assert instance.fmu.getFloat64([instance.reference("time"), voltage]) == [0.5 + 3 * TS, 0.0]
        assert instance.status_of(instance.assign, {"time": 1.0}) == ERROR


# --- arrays ------------------------------------------------------------------------------------


def as_arrays(parameters) -> tuple[dict[str, int], dict[str, object]]:
    """Return a set's structural parameters, and its other values with groups as arrays."""
    counts, values = {}, {}
    for name, value in parameters.items():
        if name.endswith("Count"):
            counts[name] = value
        elif "[" in name:
            group, _, field = name.replace("]", "[").split("[")
            values.setdefault(f"{group}{field}", []).append(value)
        else:
            values[name] = value
    return counts, values


@pytest.mark.parametrize("which", MODELS)
def test_resized_the_fmu_of_table_1_is_that_of_another_set(which, of_fmi3, tmp_path):
    """From three rules to five, from one play operator and creep term to as many as the set has."""
    other = with_effects(EFFECTS, seed=5)
    counts, values = as_arrays(other)
    assert counts != {"ruleCount": 3, "playCount": 1, "creepCount": 1}
    signal = swing(which)
    with Master(package_models(other, tmp_path)[which]) as master:
        expected = master.run(signal)
    with Instance(of_fmi3[which]) as instance:
        instance.configure(counts)
        assert instance.initialize(values).run(signal) == expected.tolist()


@pytest.mark.parametrize("which", MODELS)
def test_arrays_grow_shrink_and_vanish(which, of_fmi3, five_of_fmi3):
    signal = swing(which, 60)
    with Instance(five_of_fmi3[which]) as instance:
        expected = instance.initialize().run(signal)
    with Instance(of_fmi3[which]) as instance:
        instance.configure({"ruleCount": 16, "playCount": 16})
        instance.configure({"ruleCount": 5, "playCount": 0, "creepCount": 0})
        assert [instance.get(n) for n in ("ruleCount", "playCount", "creepCount")] == [5, 0, 0]
        assert instance.get("play.weight", 0) == []
        values = as_arrays(FIVE)[1]
        assert instance.initialize(values).run(signal) == expected
        assert instance.get("rule.centre", 5) == values["rule.centre"]
        instance.fmu.reset()  # to the set it was packaged with
        assert instance.get("ruleCount") == 3


def test_lengths_are_set_in_configuration_mode_alone(fmu):
    with Instance(fmu) as instance:
        for change in ({"ruleCount": 2}, {"playCount": 0}):
            assert instance.status_of(instance.assign, change) == ERROR
        assert "structural parameter" in instance.messages[-1][2]
        instance.fmu.enterConfigurationMode()
        assert instance.status_of(instance.assign, {"initialDisplacement": 1e-6}) == ERROR
        for count in (0, 17, 2**31, 2**63):
            assert instance.status_of(instance.assign, {"ruleCount": count}) == ERROR, count
        assert "it must be 1 to 16" in instance.messages[-1][2]
        assert instance.status_of(instance.fmu.enterInitializationMode) == ERROR
        instance.fmu.exitConfigurationMode()
        instance.initialize()
        assert instance.status_of(instance.fmu.enterConfigurationMode) == ERROR


def test_an_array_is_set_and_got_with_as_many_values_as_it_has(fmu):
    with Instance(fmu) as instance:
        before = instance.get("rule.q1", 3)
        for wrong in ([1.0], [1.0] * 4, []):
            assert instance.status_of(instance.assign, {"rule.q1": wrong}) == ERROR
            assert instance.status_of(instance.get, "rule.q1", len(wrong)) == ERROR
        assert "that have 3" in instance.messages[-1][2]
        assert instance.status_of(instance.assign, {"rule.q1": [0.5, np.nan, 0.5]}) == DISCARD
        assert instance.get("rule.q1", 3) == before
        hidden = instance.reference("rule.q1") + 6  # of the second element, which only the array shows
        assert instance.status_of(instance.fmu.getFloat64, [hidden]) == ERROR
        assert instance.status_of(instance.fmu.setFloat64, [hidden], [1.0]) == ERROR


def test_rules_that_were_not_set_after_resizing_are_named(fmu):
    with Instance(fmu) as instance:
        instance.configure({"ruleCount": 4})
        instance.fmu.enterInitializationMode()
        assert instance.status_of(instance.fmu.exitInitializationMode) == ERROR
        assert "rule[4].sigmaLower is 0" in instance.messages[-1][2]


# --- intermediate update -----------------------------------------------------------------------


def test_a_long_step_gets_its_input_at_every_tick(fmu):
    """As the same master does with a step a tick; and the outputs of the tick before can be read."""
    signal, seen, read = swing(fmu.model, 50), [], []

    def update(instance, time):
        seen.append(time)
        read.append((instance.get(OUTPUT[fmu.model]), instance.get("time")))
        instance.assign({INPUT[fmu.model]: float(signal[round(time / TS)])})

    with Instance(fmu) as often:
        expected = often.initialize().run(signal)
    with Instance(fmu, update=update) as once:
        once.initialize({INPUT[fmu.model]: float(signal[0])})
        assert once.step(0.0, 50 * TS) == (False, False, pytest.approx(50 * TS, rel=1e-15))
        assert once.get(OUTPUT[fmu.model]) == expected[-1]
    # at the beginning of a step the input was set before it
    np.testing.assert_allclose(seen, np.arange(1, 50) * TS, rtol=1e-14)
    assert [value for value, _ in read] == expected[:-1]
    assert [time for _, time in read] == seen


@pytest.mark.parametrize("cut", [[50], [0.3, 20.4, 29.3], [0.5] * 100, [7.25] * 8])
def test_ticks_are_met_however_a_master_cuts_time(fmu, cut):
    signal, seen = swing(fmu.model, 60), []

    def update(instance, time):
        seen.append(time / TS)
        instance.assign({INPUT[fmu.model]: float(signal[round(time / TS)])})

    with Instance(fmu) as often:
        expected = often.initialize().run(signal)
    with Instance(fmu, update=update) as instance:
        instance.initialize({INPUT[fmu.model]: float(signal[0])})
        time = 0.0
        for ticks in cut:
            instance.assign({INPUT[fmu.model]: float(signal[round(time / TS)])})
            _, _, time = instance.step(time, ticks * TS)
        ticks_run = int(np.ceil(sum(cut) - 1e-6))
        assert instance.get(OUTPUT[fmu.model]) == expected[ticks_run - 1]
    np.testing.assert_allclose(seen, np.round(seen), atol=1e-9)


def test_within_an_update_only_values_are_got_and_set(fmu):
    statuses = []

    def update(instance, time):
        fmu3, c = instance.fmu, instance.fmu.component
        for call in (fmu3.fmi3Terminate, fmu3.fmi3Reset, fmu3.fmi3EnterConfigurationMode):
            statuses.append(instance.status_of(call, c))
        statuses.append(instance.status_of(instance.step, time, TS))
        statuses.append(instance.status_of(fmu3.getFMUState))
        statuses.append(instance.status_of(instance.assign, {"initialDisplacement": 0.0}))
        fmu3.fmi3FreeInstance(c)

    with Instance(fmu, update=update) as instance:
        instance.initialize().step(0.0, 2 * TS)
        assert statuses == [ERROR] * 6
        assert any("intermediateUpdateMode" in text for _, _, text in instance.messages)
        instance.step(2 * TS, TS)


ENDINGS = [(7.5, 7.5), (5.0, 5.0), (0.0, 5.0), (np.nan, 5.0), (99, 20)]


@pytest.mark.parametrize(("wanted", "reached"), ENDINGS)
def test_an_update_may_end_the_step(fmu, wanted, reached):
    def update(instance, time):
        return wanted * TS if round(time / TS) == 5 else None

    for early in (True, False):
        with Instance(fmu, early=early, update=update) as instance:
            instance.initialize(at_rest(fmu.model))
            terminate, ended, time = instance.step(0.0, 20 * TS)
            expected = reached if early else 20
            assert (terminate, ended) == (False, expected < 20)
            assert time == pytest.approx(expected * TS, rel=1e-14)
            instance.step(time, (30 - expected) * TS)
            with Instance(fmu) as straight:
                straight.initialize(at_rest(fmu.model)).step(0.0, 30 * TS)
                assert instance.get(OUTPUT[fmu.model]) == straight.get(OUTPUT[fmu.model])


# --- early return ------------------------------------------------------------------------------

BEYOND = {"plant": 140.0, "inverse": 20 * UM}
FLAG = {"plant": "outOfRange", "inverse": "saturated"}


def test_a_step_ends_early_where_the_run_leaves_its_range(fmu):
    """At the tick that left, seen at the next one; and not again while it is outside."""
    leaving = 12

    def update(instance, time):
        outside = round(time / TS) >= leaving
        instance.assign({INPUT[fmu.model]: BEYOND[fmu.model] if outside else CALM[fmu.model]})

    start = at_rest(fmu.model)
    with Instance(fmu, early=True, update=update) as instance:
        instance.initialize(start)
        terminate, ended, time = instance.step(0.0, 40 * TS)
        assert (terminate, ended) == (False, True)
        assert time == pytest.approx((leaving + 1) * TS, rel=1e-14)
        assert instance.get(FLAG[fmu.model]) is True
        assert instance.step(time, 40 * TS)[1] is False
    with Instance(fmu, update=update) as instance:
        instance.initialize(start)
        assert instance.step(0.0, 40 * TS)[:2] == (False, False)


def test_a_step_that_would_diverge_ends_where_it_was_finite_or_not_at_all(of_fmi3):
    """An offset in front of the sensor takes the reading beyond what a double can hold."""

    def update(instance, time):
        if round(time / TS) >= 6:
            instance.assign({"voltage": 1.7e308})

    start = {"play.weight": [9.0], "play.threshold": [0.0], "voltage": 5.0}
    plant, names = of_fmi3["plant"], ["displacement", "time", "voltage"]
    with Instance(plant) as straight:
        straight.initialize(start).step(0.0, 6 * TS)
        with Instance(plant, early=True, update=update) as instance:
            instance.initialize(start)
            terminate, ended, time = instance.step(0.0, 20 * TS)
            assert (terminate, ended) == (True, True)
            assert time == pytest.approx(6 * TS, rel=1e-14)
            assert instance.get("displacement") == straight.get("displacement")
    with Instance(plant, update=update) as instance:
        instance.initialize(start)
        before = [instance.get(name) for name in names]
        assert instance.status_of(instance.step, 0.0, 20 * TS) == DISCARD
        assert [instance.get(name) for name in names] == before
        instance.step(0.0, 5 * TS)


# --- derivatives -------------------------------------------------------------------------------


@pytest.mark.parametrize("early", [False, True])
def test_derivatives_are_those_of_fmi_2(fmu, models, early):
    """Of the whole step, in pieces or not."""
    name = INPUT[fmu.model]
    with Instance2(models[fmu.model]) as two, Instance(fmu, early=early) as three:
        two.initialize(at_rest(fmu.model))
        three.initialize(at_rest(fmu.model))
        two.step(0.0, 7 * TS)
        three.step(0.0, 7 * TS)
        of, by = two.references([OUTPUT[fmu.model]]), two.references([name, "force", "temperature"])
        seeds = [1.5, 2.0, 3.0]
        forward = two.fmu.getDirectionalDerivative(of, by, seeds)
        assert three.fmu.getDirectionalDerivative(of, by, seeds) == forward
        assert forward[0] != 0.0
        gradient = three.fmu.getAdjointDerivative(of, by, [2.0], 3)
        assert np.dot(gradient, seeds) == pytest.approx(2.0 * forward[0], rel=1e-14)


def test_derivatives_by_arrays_before_the_first_tick(of_fmi3):
    """Of the voltage at rest by the rules, against differences."""
    with Instance(of_fmi3["inverse"]) as instance:
        instance.assign({"initialDisplacement": 5 * UM})
        q3 = np.array(instance.get("rule.q3", 3))
        instance.fmu.enterInitializationMode()
        of, by = [instance.reference("voltage")], [instance.reference("rule.q3")]
        gradient = np.array(instance.fmu.getAdjointDerivative(of, by, [1.0], 3))
        seeds = np.array([1.0, -2.0, 0.5])
        (forward,) = instance.fmu.getDirectionalDerivative(of, by, seeds.tolist())
        assert forward == pytest.approx(gradient @ seeds, rel=1e-13)
        step, read = 1e-11, []
        for sign in (1, -1):
            instance.assign({"rule.q3": q3 + sign * step * seeds})
            read.append(instance.get("voltage"))
        assert forward == pytest.approx((read[0] - read[1]) / (2 * step), rel=1e-6)
        # of the one operator and the one term that change nothing yet
        instance.assign({"rule.q3": q3})
        for name in ("play.weight", "creep.gain"):
            (slope,) = instance.fmu.getDirectionalDerivative(of, [instance.reference(name)], [1.0])
            read = []
            for value in (1e-6, -1e-6, 0.0):
                instance.assign({name: value})
                read.append(instance.get("voltage"))
            assert slope == pytest.approx((read[0] - read[1]) / 2e-6, rel=1e-6)
            assert slope != 0.0
        for count in (2, 4):
            assert instance.status_of(instance.fmu.getAdjointDerivative, of, by, [1.0], count) == ERROR


# --- calls in their order ----------------------------------------------------------------------

PHASES = ("instantiated", "configuration", "initialization", "step", "terminated")


def in_phase(instance: Instance, phase: str) -> Instance:
    """Take a new instance to a phase."""
    if phase == "configuration":
        instance.fmu.enterConfigurationMode()
    elif phase != "instantiated":
        instance.assign(at_rest(instance.unpacked.model))
        instance.fmu.enterInitializationMode()
    if phase in ("step", "terminated"):
        instance.fmu.exitInitializationMode()
    if phase == "terminated":
        instance.fmu.terminate()
    return instance


def derivative(instance: Instance) -> list[float]:
    model = instance.unpacked.model
    of, by = instance.reference(OUTPUT[model]), instance.reference(INPUT[model])
    return instance.fmu.getDirectionalDerivative([of], [by], [1.0])


EVERYWHERE, BEFORE = set(PHASES), {"instantiated", "initialization"}
# What the standard's state machine for co-simulation allows, and where.
CALLS = {
    "enter configuration": (lambda i: i.fmu.enterConfigurationMode(), {"instantiated"}),
    "exit configuration": (lambda i: i.fmu.exitConfigurationMode(), {"configuration"}),
    "enter initialization": (lambda i: i.fmu.enterInitializationMode(), {"instantiated"}),
    "exit initialization": (lambda i: i.fmu.exitInitializationMode(), {"initialization"}),
    "step": (lambda i: i.step(0.0, TS), {"step"}),
    "terminate": (lambda i: i.fmu.terminate(), {"step"}),
    "reset": (lambda i: i.fmu.reset(), EVERYWHERE),
    "get a parameter": (lambda i: i.get("sampleTime"), EVERYWHERE),
    "get an array": (lambda i: i.get("rule.centre", 3), EVERYWHERE),
    "get a length": (lambda i: i.get("ruleCount"), EVERYWHERE),
    "get the time": (lambda i: i.get("time"), EVERYWHERE),
    "get an output": (lambda i: i.get(OUTPUT[i.unpacked.model]), EVERYWHERE),
    "set an input": (lambda i: i.assign({INPUT[i.unpacked.model]: 0.0}), BEFORE | {"step"}),
    "set a parameter": (lambda i: i.assign({"initialDisplacement": 0.0}), BEFORE),
    "set an array": (lambda i: i.assign({"rule.q1": [0.5] * 3}), BEFORE),
    "set a length": (lambda i: i.assign({"ruleCount": 3}), {"configuration"}),
    "get a state": (lambda i: i.fmu.freeFMUState(i.fmu.getFMUState()), EVERYWHERE),
    "get a derivative": (derivative, {"initialization", "step", "terminated"}),
    "set logging": (lambda i: i.fmu.setDebugLogging(True, ["logAll"]), EVERYWHERE),
}


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("call", CALLS)
def test_a_call_is_accepted_where_the_standard_allows_it_and_nowhere_else(fmu, call, phase):
    function, allowed = CALLS[call]
    with Instance(fmu) as instance:
        in_phase(instance, phase).messages.clear()
        try:
            function(instance)
            accepted = True
        except fmpy.fmi1.FMICallException as error:
            accepted = False
            assert error.status == ERROR
            assert instance.messages[-1][0] == ERROR
        assert accepted == (phase in allowed), instance.messages


# --- what is not there -------------------------------------------------------------------------


def test_other_interfaces_and_events_are_refused(fmu):
    with Instance(fmu, events=True) as instance:
        assert not instance.made
        assert "event mode" in instance.messages[-1][2]
    with Instance(fmu) as instance:
        arguments = (b"x", fmu.description.instantiationToken.encode(), None, False, True, None)
        log = instance.fmu.logMessage
        assert not instance.fmu.fmi3InstantiateModelExchange(*arguments, log)
        assert instance.messages[-1][2].startswith("fmi3InstantiateModelExchange: ")


def test_types_without_variables_and_other_modes_are_refused(fmu):
    with Instance(fmu) as instance:
        instance.initialize()
        reference = [instance.reference(INPUT[fmu.model])]
        for kind in ("Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64"):
            assert instance.status_of(getattr(instance.fmu, f"get{kind}"), reference) == ERROR
            assert instance.status_of(getattr(instance.fmu, f"set{kind}"), reference, [0]) == ERROR
        assert instance.status_of(instance.fmu.getUInt64, reference) == ERROR
        assert instance.status_of(instance.fmu.setBoolean, reference, [True]) == ERROR
        for mode in ("EventMode", "StepMode"):
            call = getattr(instance.fmu, f"fmi3Enter{mode}")
            assert instance.status_of(call, instance.fmu.component) == ERROR
            assert instance.messages[-1][2].startswith(f"fmi3Enter{mode}: ")
        instance.step(0.0, TS)  # as if nothing had been


def test_messages_are_text_not_formats(fmu):
    with Instance(fmu) as instance:
        status = instance.status_of(instance.fmu.setDebugLogging, True, ["%n%s"])
        assert status == ERROR
        assert "'%n%s'" in instance.messages[-1][2]
        assert instance.status_of(instance.fmu.setDebugLogging, False, ["logAll"]) == OK
