"""The FMUs run by FMPy: ticks do not depend on how a master cuts time."""

import numpy as np
import pytest
from conftest import (
    INPUT,
    MODELS,
    OUTPUT,
    TS,
    UM,
    Instance,
    Master,
    tick_values,
)
from fmpy import fmi2
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from it2hys.model import compiled
from it2hys.model.parameters import table_1


def polygon(knots: np.ndarray, values: np.ndarray):
    """Return a piecewise linear signal and its slope to the right."""

    def slope(t: float) -> float:
        i = min(max(np.searchsorted(knots, t, side="right") - 1, 0), len(knots) - 2)
        return (values[i + 1] - values[i]) / (knots[i + 1] - knots[i])

    return lambda t: float(np.interp(t, knots, values)), slope


def held_at(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the value of the last tick before each time: its left limit."""
    return values[np.ceil(times / TS - 1e-6).astype(int) - 1]


@pytest.fixture(scope="module")
def zigzag():
    """Return a signal with corners at times that are no ticks."""
    rng = np.random.default_rng(7)
    knots = np.concatenate([[0.0], np.cumsum(rng.uniform(20.3, 180.7, 12))]) * TS
    return knots, rng.uniform(0.1, 0.9, len(knots))


@pytest.mark.parametrize("which", MODELS)
@pytest.mark.parametrize("size", [1 / 3, 1.0, 7.3, 100.0])
def test_ticks_do_not_depend_on_the_communication_step(models, zigzag, which, size):
    knots, values = zigzag
    signal, slope = polygon(knots, values * {"plant": 100.0, "inverse": 15 * UM}[which])
    regular = np.arange(int(knots[-1] / TS / size)) * size * TS
    times = np.unique(np.concatenate([regular, knots[knots < regular[-1]]]))
    with Master(models[which]) as master:
        read = master.run_steps(signal, slope, times)
    expected = held_at(times[1:], tick_values(which, signal, int(times[-1] / TS) + 2))
    np.testing.assert_allclose(read, expected, rtol=1e-12, atol=1e-12 * np.max(np.abs(expected)))


@given(
    cuts=st.lists(
        st.one_of(
            st.floats(0.0, 3.0),
            st.sampled_from([0.0, 1e-9, 1 / 3, 0.1, 0.5, 1.0, 2.0, 7.3]),
        ),
        min_size=1,
        max_size=40,
    ),
    which=st.sampled_from(MODELS),
)
@settings(max_examples=80)
def test_ticks_do_not_depend_on_how_time_is_cut(models, cuts, which):
    """One ramp, any cuts: steps without a tick, steps of no length, steps of many ticks."""
    end = 60.0
    times = np.concatenate([[0.0], np.cumsum(cuts), [max(end, sum(cuts) + 1)]]) * TS
    behind = times / TS % 1  # a communication point barely behind a tick may be taken to lie at it
    assume(not np.any((behind > 1e-8) & (behind < 2e-3)))
    top = {"plant": 100.0, "inverse": 15 * UM}[which]
    signal, slope = polygon(np.array([0.0, times[-1]]), np.array([0.1, 0.9]) * top)
    with Master(models[which]) as master:
        initial = master.instance.get(master.output)
        read = master.run_steps(signal, slope, times)
    values = tick_values(which, signal, int(times[-1] / TS) + 2)
    last = np.ceil(times[1:] / TS - 1e-6).astype(int) - 1
    expected = np.where(last < 0, initial, values[np.maximum(last, 0)])
    np.testing.assert_allclose(read, expected, rtol=1e-12, atol=1e-12 * np.max(np.abs(values)))


def test_what_is_read_is_the_value_of_the_last_tick_before_the_communication_point(plant):
    plant.initialize()
    rules = table_1().rules
    y = compiled.free_run(rules, np.full(3, 50.0), 0.0)
    plant.assign({"voltage": 50.0})
    assert plant.get("displacement") == 0.0  # an input does not reach the output before a tick
    read = []
    for i in range(8):
        plant.step(i * TS / 4, TS / 4)
        read.append(plant.get("displacement"))
    np.testing.assert_allclose(read, [y[0]] * 4 + [y[1]] * 4, rtol=1e-12)


FINE = 1e-5  # sample time


def communication_points(
    master: str, start: float, step: float, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return times and lengths of the steps of a master."""
    added = np.cumsum(np.concatenate([[start], np.full(count, step)]))
    multiplied = start + np.arange(count + 1) * step
    times = {"adds": added, "multiplies": multiplied}.get(master, multiplied)
    lengths = np.diff(multiplied) if master == "subtracts" else np.full(count, step)
    if master == "changes":  # saves a state and goes on from it with the other's times
        times = np.where(np.arange(count + 1) % 500 < 250, added, multiplied)
    return times[:-1], lengths


# steps of p/q sample times, and a start at which every addition of one makes the time too large
@pytest.mark.parametrize(
    ("p", "q", "start"), [(1, 1, 1.1e6), (1, 10, 1.1e6), (10, 1, 1.1e6), (5, 2, 5e6)]
)
@pytest.mark.parametrize("master", ["adds", "multiplies", "subtracts", "changes"])
def test_all_fmus_stay_together_tick_for_tick(models, controller, master, p, q, start):
    """Whatever a master makes of time, plant, inverse and controller run the ticks that are due.

    The controller counts: its integral grows by 1 V at every tick. Plant and inverse get the number of
    the step as their input, so that the ticks of a step are seen in the output.
    """
    count = 4000
    times, lengths = communication_points(master, start, p * FINE / q, count)
    if master == "adds":  # or there would be nothing to test
        assert times[-1] - start - (count - 1) * p / q * FINE > 2.5e-3 * FINE
    due = -(-np.arange(1, count + 1) * p // q)  # ticks up to the end of each step
    of_tick = np.arange(due[-1]) * q // p  # the step that each lies in
    swing = {"plant": 50 + 40 * np.sin(np.arange(count) / 50), "inverse": 5 * UM * np.ones(count)}
    swing["inverse"] += 3 * UM * np.sin(np.arange(count) / 50)
    for which in MODELS:
        expected = tick_values(which, lambda t, w=which: swing[w][of_tick[round(t / TS)]], due[-1])
        with Instance(models[which]) as instance:
            instance.initialize({"sampleTime": FINE}, start_time=start)
            read = follow(instance, times, lengths, {INPUT[which]: swing[which]}, OUTPUT[which])
        np.testing.assert_allclose(read, expected[due - 1], rtol=1e-9)
    counts = {"integralGain": 1 / FINE, "voltageMax": 1e6, "reference": 1.0, "sampleTime": FINE}
    with Instance(controller) as instance:
        instance.initialize(counts, start_time=start)
        np.testing.assert_allclose(follow(instance, times, lengths, {}, "voltage"), due, rtol=1e-9)


def follow(
    instance: Instance,
    times: np.ndarray,
    lengths: np.ndarray,
    inputs: dict[str, np.ndarray],
    output: str,
) -> list[float]:
    """Return the output after each step; every so often the instance goes on from its saved state."""
    read = []
    for n, (time, length) in enumerate(zip(times, lengths, strict=True)):
        if n % 250 == 0:
            saved = instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
            instance.fmu.reset()
            instance.fmu.setFMUstate(instance.fmu.deSerializeFMUstate(saved))
        instance.assign({name: float(values[n]) for name, values in inputs.items()})
        assert instance.step(time, length) <= fmi2.fmi2Warning, instance.messages
        read.append(instance.get(output))
    return read


@pytest.mark.parametrize("which", [*MODELS, "controller"])
def test_a_step_that_would_run_for_days_is_refused_with_the_number_of_its_ticks(
    models, controller, which
):
    with Instance({**models, "controller": controller}[which]) as instance:
        instance.initialize({"sampleTime": TS})
        assert instance.step(0.0, 1e9) == fmi2.fmi2Error
        assert "1e+13 ticks of 0.0001 s; at most 1e+09" in instance.said(fmi2.fmi2Error)[0]
        assert instance.step(0.0, TS) <= fmi2.fmi2Warning


def test_a_derivative_acts_from_the_communication_point_on_and_stays(plant):
    plant.initialize()
    plant.assign({"voltage": 20.0})
    plant.slope("voltage", 1e5)
    plant.step(0.0, 3 * TS)
    plant.step(3 * TS, 2 * TS)  # starts again from 20 V
    x = [20.0, 30.0, 40.0, 20.0, 30.0]
    expected = compiled.free_run(table_1().rules, np.array(x), 0.0)[-1]
    assert plant.get("displacement") == pytest.approx(expected, rel=1e-12)
