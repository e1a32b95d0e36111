"""FMUs with effects: they compute what the C chain computes, however the master cuts time."""

import numpy as np
import pytest
from conftest import TS, UM, Instance, Unpacked, package_models
from effects import INVERTIBLE, gentle_reference, signals, surroundings, with_effects
from fmpy import fmi2

from it2hys.model import compiled
from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import ParameterSet

SAMPLES = 300
CASES = [(), *((e,) for e in EFFECTS), tuple(EFFECTS), INVERTIBLE]


def run(
    unpacked: Unpacked, names: tuple[str, ...], inputs: dict[str, np.ndarray], first_tick: int = 0
) -> dict[str, np.ndarray]:
    """Return outputs at every tick for inputs at every tick."""
    samples = len(next(iter(inputs.values())))
    read = {name: np.empty(samples) for name in names}
    with Instance(unpacked) as instance:
        instance.initialize(start_time=first_tick * TS)
        for k in range(samples):
            instance.assign({name: float(values[k]) for name, values in inputs.items()})
            assert instance.step((first_tick + k) * TS, TS) <= fmi2.fmi2Warning, instance.messages
            for name, values in read.items():
                values[k] = instance.get(name)
    return read


@pytest.fixture(scope="module", params=CASES, ids=lambda names: "-".join(names) or "none")
def case(request, tmp_path_factory) -> tuple[ParameterSet, dict[str, Unpacked]]:
    """Return a set with effects and its FMUs."""
    parameters = with_effects(request.param, 42)
    return parameters, package_models(parameters, tmp_path_factory.mktemp("effects"))


def test_both_fmus_are_the_c_chain_to_the_last_bit(case):
    parameters, models = case
    voltage, (force, temperature) = signals(SAMPLES, -5.0, 115.0), surroundings(SAMPLES)
    around = {"force": force, "temperature": temperature}
    for first in (0, 12345):
        plant = run(
            models["plant"], ("displacement", "measured"), {"voltage": voltage, **around}, first
        )
        displacement, measured = compiled.chain_free_run(parameters, voltage, force, temperature, first)
        assert plant["displacement"].tobytes() == displacement.tobytes()
        assert plant["measured"].tobytes() == measured.tobytes()
        reference = gentle_reference(SAMPLES)
        inverse = run(
            models["inverse"], ("voltage", "saturated"), {"reference": reference, **around}, first
        )
        expected = compiled.chain_inverse_run(parameters, reference, force, temperature, first)
        assert inverse["voltage"].tobytes() == expected[0].tobytes()
        assert np.array_equal(inverse["saturated"], expected[1])


def test_the_result_does_not_depend_on_how_time_is_cut(case):
    _, models = case
    rng = np.random.default_rng(1)
    slope = {"voltage": 300.0, "force": 50.0, "temperature": 20.0}
    start = {"voltage": 40.0, "force": -3.0, "temperature": 290.0}
    ends = []
    uneven = np.concatenate([[0.0], np.sort(rng.uniform(0.0, 100 * TS, 37)), [100 * TS]])
    for times in (np.array([0.0, 100 * TS]), np.arange(101) * TS, np.arange(401) * TS / 4, uneven):
        with Instance(models["plant"]) as instance:
            instance.initialize()
            for k in range(len(times) - 1):
                time = float(times[k])
                instance.assign({n: start[n] + slope[n] * time for n in start})
                for name, value in slope.items():
                    instance.slope(name, value)
                assert instance.step(time, float(times[k + 1]) - time) <= fmi2.fmi2Warning
            ends.append([instance.get("displacement"), instance.get("measured")])
    np.testing.assert_allclose(ends, np.broadcast_to(ends[0], (4, 2)), rtol=1e-11)


def test_a_saved_state_goes_on_bit_for_bit(case):
    _, models = case
    for model, name, value in (("plant", "voltage", 60.0), ("inverse", "reference", 7 * UM)):
        with Instance(models[model]) as instance:
            instance.initialize()
            output = "displacement" if model == "plant" else "voltage"

            def go_on(first, instance=instance, name=name, value=value, output=output):
                read = []
                for k in range(first, first + 40):
                    instance.assign({name: value * (1 + 0.1 * np.sin(k)), "force": 0.1 * k})
                    assert instance.step(k * TS, TS) <= fmi2.fmi2Warning
                    read.append(instance.get(output))
                return np.array(read).tobytes()

            go_on(0)
            state = instance.fmu.getFMUState()
            saved = instance.fmu.serializeFMUstate(state)
            first = go_on(40)
            instance.fmu.setFMUState(state)
            assert go_on(40) == first
            instance.fmu.setFMUState(instance.fmu.deSerializeFMUstate(saved))
            assert go_on(40) == first
            instance.fmu.freeFMUState(state)


def test_directional_derivatives_are_those_of_a_step(case):
    _, models = case
    steps = {"voltage": 1e-3, "force": 1e-3, "temperature": 1e-3}
    with Instance(models["plant"]) as instance:
        instance.initialize()
        for k in range(30):
            instance.assign({"voltage": 50.0 + 20 * np.sin(0.05 * k), "force": 0.1 * k})
            instance.step(k * TS, TS)
        at = {"voltage": 71.0, "force": 2.0, "temperature": 294.0}
        state = instance.fmu.getFMUState()

        def reached(**changes):
            instance.fmu.setFMUState(state)
            instance.assign({**at, **changes})
            assert instance.step(30 * TS, 5 * TS) <= fmi2.fmi2Warning
            return np.array([instance.get("displacement"), instance.get("measured")])

        outputs = instance.references(["displacement", "measured"])
        for name, h in steps.items():
            slope = (reached(**{name: at[name] + h}) - reached(**{name: at[name] - h})) / (2 * h)
            reached()
            known = instance.references([name])
            values = instance.fmu.getDirectionalDerivative(outputs, known, [1.0])
            np.testing.assert_allclose(values, slope, rtol=1e-4, atol=1e-14)


def test_the_xml_lists_what_the_set_has(case):
    parameters, models = case
    for unpacked in models.values():
        listed = {n for n, v in unpacked.variables.items() if v.causality == "parameter"}
        assert listed == set(parameters)
        for name in listed:
            assert float(unpacked.variables[name].start) == parameters[name]
