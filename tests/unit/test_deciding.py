"""Steps that only training records have decide, too."""

from dataclasses import replace

import numpy as np
from conftest import TS
from diagnosis import voltages
from scipy.signal import lfilter

from it2hys.diagnosis.deciding import steps_aside
from it2hys.identification.preparation import prepare
from it2hys.identification.traces import to_trace
from it2hys.records import Record

TIME = np.arange(2000) * TS


def trace(draw, seed, role):
    rng = np.random.default_rng(seed)
    voltage = draw(rng, TIME, 105.0)
    reading = lfilter([0.015], [1.0, -0.9], voltage) + 0.006 * rng.standard_normal(len(TIME))
    return to_trace(prepare(Record("r", TIME, voltage, 1e-6 * reading, TS)), role, False)


def test_a_third_of_the_steps_decides_and_is_not_fitted():
    stepped, smooth = trace(voltages.staircase, 1, "train"), trace(voltages.slow_sine, 2, "train")
    check = trace(voltages.slow_sine, 3, "validation")
    fitted, deciding = steps_aside([smooth, stepped], [check])
    assert fitted[0] is smooth and deciding[0] is check and len(deciding) == 2
    judged = deciding[1].judged
    assert np.any(judged) and not np.any(fitted[1].weight[judged])
    assert np.count_nonzero(fitted[1].weight) + np.count_nonzero(judged) == len(TIME)
    steps = np.flatnonzero(np.abs(np.diff(stepped.drive.voltage)) > 5.25) + 1
    # whole steps, with what follows each
    assert {*np.flatnonzero(np.diff(judged.astype(int)) > 0) + 1} <= {*steps.tolist()}


def test_where_a_record_that_decides_has_steps_all_stays_as_it_is():
    train = [trace(voltages.staircase, 1, "train")]
    deciding = [trace(voltages.staircase, 4, "validation")]
    assert steps_aside(train, deciding) == (train, deciding)


def test_a_single_step_is_fitted():
    single = trace(voltages.slow_sine, 5, "train")
    drive = replace(single.drive, voltage=np.where(TIME < 0.1, 0.0, 80.0))
    check = trace(voltages.slow_sine, 6, "validation")
    fitted, deciding = steps_aside([replace(single, drive=drive)], [check])
    assert deciding == [check] and np.all(fitted[0].weight == single.weight)
