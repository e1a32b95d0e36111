"""The fast path against loops over FMPy, to the last bit, with our FMUs and with anyone's."""

from contextlib import ExitStack

import fmpy
import numpy as np
import pytest
from conftest import TS, UM, make_set
from foreign_fmu import build_foreign

from it2hys.cosimulation.simulation import simulate, track
from it2hys.cosimulation.slave import Slave
from it2hys.cosimulation.stepping import Connection, System
from it2hys.errors import InputError
from it2hys.fmu.controller import controller_fmu
from it2hys.fmu.packaging import package
from it2hys.stand.excitations import tracking_reference

CHAIN = [Connection("reference", "inverse.reference"), Connection("inverse.voltage", "plant.voltage")]
LOOP = [
    Connection("reference", "inverse.reference"),
    Connection("reference", "controller.reference"),
    Connection("inverse.voltage", "controller.feedforward"),
    Connection("plant.displacement", "controller.displacement"),
    Connection("controller.voltage", "plant.voltage", 0.9, 1.5),
    Connection("force", "plant.force"),
]


@pytest.fixture(scope="module")
def controller(tmp_path_factory):
    path = tmp_path_factory.mktemp("controller") / "PIController.fmu"
    path.write_bytes(controller_fmu())
    return path


def fmpy_loop(slaves, connections, recorded, signals, starts, steps, size):
    """Return what a loop over FMPy's setReal, doStep and getReal gives."""
    for name, slave in slaves.items():
        slave.initialize(starts[name])
    values = {c.source: 0.0 for c in connections}
    for c in connections:
        if "." in c.source:
            slave, _, variable = c.source.partition(".")
            values[c.source] = slaves[slave].get(variable)
    rows = {name: [] for name in recorded}
    for k in range(steps):
        values.update({name: float(signal[k]) for name, signal in signals.items()})
        for name, slave in slaves.items():
            for c in connections:
                target, _, variable = c.target.partition(".")
                if target == name:
                    value = c.factor * values[c.source]
                    slave.set({variable: value + c.offset if c.offset else value})
            slave.step(k * size, size, {})
            for source in list(values):
                owner, _, variable = source.partition(".")
                if owner == name and variable:
                    values[source] = slave.get(variable)
            for output in recorded:
                owner, _, variable = output.partition(".")
                if owner == name:
                    rows[output].append(slave.get(variable))
    return {name: np.array(column, dtype=float) for name, column in rows.items()}


@pytest.mark.parametrize("ticks", [1, 3, 0.4])
@pytest.mark.parametrize(("topology", "name"), [("chain", "table_1"), ("loop", "five_rules")])
def test_the_fast_path_and_fmpy_agree_to_the_last_bit(packaged, controller, topology, name, ticks):
    """Feedforward and feedback, with one tick in a step, with several and with less than one."""
    size, steps = ticks * TS, 200
    reference = tracking_reference(np.arange(steps) * size)
    start = {"initialDisplacement": reference[0]}
    paths = {model: packaged[name][1][model].path for model in ("inverse", "plant")}
    starts = dict.fromkeys(paths, start)
    signals, connections = {"reference": reference}, CHAIN
    recorded = ["inverse.voltage", "inverse.saturated", "plant.displacement", "plant.measured"]
    if topology == "loop":
        connections = LOOP
        paths = {"inverse": paths["inverse"], "controller": controller, "plant": paths["plant"]}
        starts["controller"] = {"proportionalGain": 2e6, "integralGain": 1e9}
        starts["plant"] = {**start, "load.compliance": 1e-8}
        signals["force"] = 5 * np.sin(np.arange(steps) / 9)
        recorded += ["controller.voltage", "controller.limited"]
    with ExitStack() as stack:
        slaves = {n: stack.enter_context(Slave(path)) for n, path in paths.items()}
        system = System(slaves, connections, recorded)
        system.initialize(starts, {n: s[0] for n, s in signals.items()})
        fast = system.run(signals, steps, size)
        slow = fmpy_loop(slaves, connections, recorded, signals, starts, steps, size)
    for output in recorded:
        assert fast[output].tobytes() == slow[output].tobytes(), output
    assert np.ptp(fast["plant.displacement"]) > 1 * UM


def test_one_fmu_agrees_with_simulate_fmu(fmus):
    """FMPy records before a step what is recorded here after the step before."""
    time = np.arange(300) * TS
    voltage = 50 - 50 * np.cos(2 * np.pi * 40 * time)
    outputs, _ = simulate(fmus["plant"], {"voltage": voltage}, {"initialDisplacement": 1 * UM})
    rows = list(zip(time, voltage, strict=True))
    result = fmpy.simulate_fmu(
        str(fmus["plant"]),
        input=np.array(rows, dtype=[("time", float), ("voltage", float)]),
        start_values={"initialDisplacement": 1 * UM},
        output=["displacement"],
        stop_time=299 * TS,
        step_size=TS,
        output_interval=TS,
    )
    assert result["displacement"][1:].tobytes() == outputs["displacement"][: len(result) - 1].tobytes()
    assert len(result) == 300


def test_a_second_run_is_the_first_whatever_came_between(packaged):
    """Reset leaves nothing: not after another set, nor after a run that was refused."""
    _, unpacked = packaged["five_rules"]
    reference = tracking_reference(np.arange(300) * TS)
    start = {"initialDisplacement": reference[0]}
    with Slave(unpacked["inverse"].path) as inverse, Slave(unpacked["plant"].path) as plant:
        system = System({"inverse": inverse, "plant": plant}, CHAIN, ["plant.displacement"])

        def run(values):
            system.initialize({"inverse": start, "plant": values}, {"reference": reference[0]})
            return system.run({"reference": reference}, 300, TS)["plant.displacement"]

        first = run(start)
        other = run({**start, "rule[1].q2": 3e-8})
        with pytest.raises(InputError, match="rule\\[2\\]"):
            run({**start, "rule[2].sigmaLower": -1.0})
        with pytest.raises(InputError, match=r"ruleCount is 2\.5; it must be a whole number"):
            run({**start, "ruleCount": 2.5})
        assert run(start).tobytes() == first.tobytes()
        assert other.tobytes() != first.tobytes()
    fresh = track(unpacked["inverse"].path, unpacked["plant"].path, reference, start)
    assert fresh["displacement"].tobytes() == first.tobytes()


def test_a_run_in_pieces_is_the_run(fmus):
    voltage = 50 + 40 * np.sin(np.arange(1000) / 30)
    with Slave(fmus["plant"]) as plant:
        system = System({"plant": plant}, [Connection("u", "plant.voltage")], ["plant.displacement"])
        system.initialize()
        whole = system.run({"u": voltage}, 1000, TS)["plant.displacement"]
        system.initialize()
        pieces = [system.run({"u": voltage[a:b]}, b - a, TS)["plant.displacement"]
                  for a, b in ((0, 1), (1, 400), (400, 1000))]  # fmt: skip
    assert np.concatenate(pieces).tobytes() == whole.tobytes()


def test_a_discarded_step_ends_the_run_in_the_fmus_words(fmus):
    """No voltage that there is makes the plant diverge; the largest that a double holds overflows."""
    sensitive = {f"rule[{i}].q2": 0.1 for i in (1, 2, 3)}
    with Slave(fmus["plant"]) as plant:
        system = System({"plant": plant}, [Connection("u", "plant.voltage")], ["plant.displacement"])
        system.initialize({"plant": sensitive})
        with pytest.raises(InputError, match=r"no longer finite.*fmi2Discard") as caught:
            system.run({"u": np.full(1000, -1.7e308)}, 1000, TS)
        assert str(fmus["plant"]) in str(caught.value)
        system.initialize()
        assert np.isfinite(system.run({"u": np.full(5, 50.0)}, 5, TS)["plant.displacement"]).all()


@pytest.mark.parametrize(
    ("connections", "recorded", "said"),
    [
        ([Connection("u", "plant.volts")], [], "no variable 'volts'"),
        ([Connection("u", "stage.voltage")], [], "no FMU 'stage'"),
        ([Connection("u", "plant.displacement")], [], "is no input"),
        ([Connection("u", "plant.voltage"), Connection("v", "plant.voltage")], [], "connected twice"),
        ([Connection("u", "plant.voltage")], ["plant.speed"], "no variable 'speed'"),
    ],
)
def test_a_system_names_what_is_wrong_with_it(fmus, connections, recorded, said):
    with Slave(fmus["plant"]) as plant, pytest.raises(InputError, match=said):
        System({"plant": plant}, connections, recorded)


def test_a_signal_that_is_missing_or_short_is_named(fmus):
    with Slave(fmus["plant"]) as plant:
        system = System({"plant": plant}, [Connection("u", "plant.voltage")], [])
        system.initialize()
        with pytest.raises(InputError, match="no signal 'u'"):
            system.run({}, 3, TS)
        with pytest.raises(InputError, match=r"shape \(2,\)"):
            system.run({"u": np.zeros(2)}, 3, TS)


# --- an FMU that is nothing like ours ----------------------------------------------------------


@pytest.fixture(scope="module")
def foreign(tmp_path_factory):
    return build_foreign(tmp_path_factory.mktemp("foreign"))


def test_integers_booleans_and_printf_messages_of_a_foreign_fmu(foreign):
    pairs = ["x a.x", "n a.n", "on a.on", "a.count b.x", "a.odd b.on", "a.y b.n"]
    connections = [Connection(*pair.split()) for pair in pairs]
    recorded = ["a.y", "a.count", "a.odd", "b.x", "b.y", "b.count"]
    steps = 50
    signals = {
        "x": np.linspace(0, 3, steps),
        "n": np.arange(steps) % 3,
        "on": (np.arange(steps) % 4 > 0).astype(float),
    }
    with Slave(foreign) as a, Slave(foreign) as b:
        system = System({"a": a, "b": b}, connections, recorded)
        system.initialize()
        fast = system.run(signals, steps, 0.1)
        time = np.arange(steps) * 0.1
        y = np.where(signals["on"] > 0, signals["x"] + time, 0.0)
        count = np.cumsum(signals["n"])
        odd = count % 2
        assert fast["a.y"].tobytes() == y.tobytes()
        np.testing.assert_array_equal(fast["a.count"], count)
        np.testing.assert_array_equal(fast["a.odd"], odd)
        np.testing.assert_array_equal(fast["b.x"], count)
        np.testing.assert_array_equal(fast["b.y"], np.where(odd > 0, count + time, 0.0))
        np.testing.assert_array_equal(fast["b.count"], np.cumsum(np.floor(y + 0.5)))
        system.initialize()
        signals["x"] = np.where(np.arange(steps) < 20, 1.0, -1.5)
        with pytest.raises(InputError, match=r"x is -1.5, which is fatal \(fmi2Fatal at 2 s\)"):
            system.run(signals, steps, 0.1)
        # a fatal status forbids to use the instance again: there is another
        system.initialize()
        signals["x"] = np.ones(steps)
        assert len(system.run(signals, steps, 0.1)["a.y"]) == steps


def test_rows_do_not_depend_on_the_set_that_ran_before(tmp_path):
    """Two FMUs of one kind and unlike sets, alternately, as the cases of a sweep do."""
    package(make_set(3, 2), tmp_path)
    voltage = {"voltage": 40 + 30 * np.sin(np.arange(200) / 20)}
    alone, _ = simulate(tmp_path / "IT2Plant.fmu", voltage)
    with Slave(tmp_path / "IT2Plant.fmu") as slave:
        system = System({"p": slave}, [Connection("voltage", "p.voltage")], ["p.displacement"])
        for q2 in (3e-9, 4e-9):
            system.initialize({"p": {"rule[1].q2": q2}})
            system.run(voltage, 200, TS)
        system.initialize({}, {"voltage": 40.0})
        again = system.run(voltage, 200, TS)["p.displacement"]
    assert again.tobytes() == alone["displacement"].tobytes()
