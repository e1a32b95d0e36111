"""FMPy's own simulate_fmu on our FMUs, and how a run ends that cannot go on."""

import ctypes
from pathlib import Path

import fmpy
import numpy as np
import pytest
from conftest import (
    INPUT,
    MODELS,
    OUTPUT,
    TS,
    UM,
    Master,
    Unpacked,
    package_models,
    tick_values,
    ticks,
)
from fmpy import fmi2
from fmpy.fmi1 import printLogMessage
from fmpy.logging import addLoggerProxy

from it2hys.model.parameters import ParameterSet, table_1
from it2hys.stand.excitations import identification, tracking_reference

ERROR = fmi2.fmi2Error
DEFAULT_LOGGER = fmi2.fmi2CallbackLoggerTYPE(printLogMessage)


@pytest.fixture(autouse=True)
def _fmpys_default_logger():
    """Give FMPy its default logger back.

    Its default callbacks call the logger that a run was given last, even when that is gone, and crash:
    in the next test that lets an FMU warn.
    """
    yield
    callbacks = fmi2.fmi2CallbackFunctions()
    callbacks.logger = DEFAULT_LOGGER
    addLoggerProxy(ctypes.byref(callbacks))


def structured(**columns: np.ndarray) -> np.ndarray:
    """Return FMPy's input: a structured array with a time column."""
    array = np.zeros(len(next(iter(columns.values()))), dtype=[(n, float) for n in columns])
    for name, column in columns.items():
        array[name] = column
    return array


@pytest.mark.parametrize("which", MODELS)
def test_simulate_fmu_gives_every_tick_one_row_later(fmus, which):
    time = ticks(300)
    signal = {"plant": identification(time), "inverse": tracking_reference(time)}[which]
    result = fmpy.simulate_fmu(
        str(fmus[which]),
        stop_time=time[-1],
        output_interval=TS,
        step_size=TS,
        input=structured(time=time, **{INPUT[which]: signal}),
    )
    np.testing.assert_allclose(result["time"], time, rtol=0, atol=1e-9 * TS)
    expected = tick_values(which, lambda t: signal[round(t / TS)], len(time) - 1)
    np.testing.assert_allclose(
        result[OUTPUT[which]][1:], expected, rtol=1e-12, atol=1e-12 * np.max(np.abs(expected))
    )


@pytest.mark.parametrize("which", MODELS)
def test_simulate_fmu_runs_as_it_comes(fmus, which):
    result = fmpy.simulate_fmu(str(fmus[which]))
    assert result["time"][-1] == pytest.approx(0.2)
    assert np.isfinite(result[OUTPUT[which]]).all()


def test_simulate_fmu_takes_start_values_and_their_display_units(fmus):
    one = fmpy.simulate_fmu(
        str(fmus["plant"]), stop_time=TS, start_values={"initialDisplacement": 2 * UM}
    )
    other = fmpy.simulate_fmu(
        str(fmus["plant"]), stop_time=TS, start_values={"initialDisplacement": (2.0, "um")}
    )
    assert one["displacement"][0] == 2 * UM
    assert other["displacement"][0] == pytest.approx(2 * UM, rel=1e-15)


@pytest.mark.parametrize("which", MODELS)
def test_unusable_start_values_are_refused_and_the_culprit_is_named(fmus, which):
    """Every kind of them is tried in C."""
    said = []
    with pytest.raises(fmpy.fmi1.FMICallException, match="fmi2ExitInitializationMode"):
        fmpy.simulate_fmu(
            str(fmus[which]),
            stop_time=TS,
            start_values={"rule[2].sigmaLower": 12e-6},
            logger=lambda env, name, status, category, message: said.append((status, message)),
        )
    errors = [message.decode() for status, message in said if status == ERROR]
    assert len(errors) == 1
    assert "rule[2].sigmaUpper" in errors[0]


def test_the_xml_says_how_many_elements_an_fmu_can_have(packaged):
    for parameters, unpacked in packaged.values():
        for fmu in unpacked.values():
            for group, count in parameters.counts.items():
                variable = fmu.variables[f"{group}Count"]
                assert int(variable.max) == int(variable.start) == count


def test_a_lowered_count_leaves_the_last_elements_out(tmp_path):
    first = {"play[1].threshold": 2.0, "play[1].weight": 0.1}
    second = {"play[2].threshold": 9.0, "play[2].weight": 0.2}
    with_two = table_1().replace(playCount=2, **first, **second)
    with_one = table_1().replace(playCount=1, **first)
    signal = 50.0 + 40.0 * np.sin(np.arange(300) / 15)
    lowered = package_models(with_two, tmp_path / "two")["plant"]
    with Master(lowered, {"playCount": 1}) as master:
        read = master.run(signal)
    with Master(package_models(with_one, tmp_path / "one")["plant"]) as master:
        assert (master.run(signal) == read).all()
    with Master(lowered) as master:
        assert (master.run(signal) != read).any()


#: A voltage under which no plant diverges, but the displacement of a sensitive one overflows soon.
HUGE = {"voltage": -1.7e308}


def sensitive(directory: Path) -> Unpacked:
    """Return a plant that moves by 0.1 m for every volt."""
    values = {**table_1(), **{f"rule[{i}].q2": 0.1 for i in (1, 2, 3)}}
    del values["playCount"], values["creepCount"]
    return package_models(ParameterSet(values).validate(), directory)["plant"]


def test_a_run_that_overflows_ends_and_says_where(tmp_path):
    """A master must not be left repeating a step that can never be made."""
    said = []
    result = fmpy.simulate_fmu(
        str(sensitive(tmp_path).path),
        start_values=HUGE,
        stop_time=1.0,
        output_interval=TS,
        timeout=2.0,
        logger=lambda env, name, status, category, message: said.append(message.decode()),
    )
    assert result["time"][-1] < 1.0
    assert np.isfinite(result["displacement"]).all()
    refused = [message for message in said if "no longer finite" in message]
    assert len(refused) == 1  # the master did not try again and again until its timeout
