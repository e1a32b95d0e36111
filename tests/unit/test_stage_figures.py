"""Figures of a stage that records determine, whatever they leave open of the rules."""

from __future__ import annotations

import numpy as np
import pytest

from it2hys.identification import identify
from it2hys.model import compiled
from it2hys.records import Record

TS, UM = 1e-4, 1e-6
NOISE, SAMPLES = 0.01 * UM, 1200
RULES = np.array([[5e-6, 15e-6, 8e-6, 0.9, 1.5e-8, 1e-7]])


def drive(seed: int) -> np.ndarray:
    time = np.arange(SAMPLES) * TS
    return 50.0 - (50.0 - 5.0 * seed) * np.cos(2 * np.pi * (40.0 + 15.0 * seed) * time)


def run_of(voltage: np.ndarray) -> np.ndarray:
    return compiled.free_run(RULES, voltage, UM)


@pytest.fixture(scope="module", params=range(3))
def found(request):
    """Identify a stage of one rule, whose memberships nothing shows, from two noisy records."""
    records = []
    for i, name in enumerate("ab"):
        noise = NOISE * np.random.default_rng(10 * request.param + i).standard_normal(SAMPLES)
        voltage = drive(i)
        records.append(Record(name, np.arange(SAMPLES) * TS, voltage, run_of(voltage) + noise, TS))
    return identify(records, rules=1)


def figure(found, name, record=""):
    (one,) = [f for f in found.stage_figures if (f.name, f.record) == (name, record)]
    return one


def assert_holds(figure, truth, share):
    assert figure.low < figure.value < figure.high
    # 95 % intervals: half as wide again, so that another seed passes
    assert abs(figure.value - truth) < 0.75 * (figure.high - figure.low)
    assert figure.high - figure.low < share * abs(truth)


def test_the_rules_leave_their_memberships_open(found):
    assert {"rule[1].sigmaLower", "rule[1].centre"} <= {*found.undetermined}


def test_the_gain_is_the_slope_of_the_run(found):
    runs = [(drive(i), run_of(drive(i))) for i in range(2)]
    away = [x - x.mean() for x, _ in runs]
    truth = sum(a @ y for a, (_, y) in zip(away, runs, strict=True)) / sum(a @ a for a in away)
    assert_holds(figure(found, "gain"), truth, 0.01)
    assert figure(found, "gain").unit == "m/V"


@pytest.mark.parametrize("name", ["a", "b"])
def test_the_width_of_a_loop_is_what_one_measures(found, name):
    voltage = drive("ab".index(name))
    y, rate = run_of(voltage), np.gradient(voltage)
    middle = 0.5 * (voltage.min() + voltage.max())
    # where each branch crosses the middle of the voltages, behind the first period
    crossing = np.flatnonzero(np.diff(np.sign(voltage - middle)) != 0)[2:]
    ways = [slice(k, k + 2) if rate[k] > 0.0 else slice(k + 1, k - 1, -1) for k in crossing]
    at = [np.interp(middle, voltage[way], y[way]) for way in ways]
    falling = rate[crossing] < 0.0
    truth = np.mean(np.array(at)[falling]) - np.mean(np.array(at)[~falling])
    one = figure(found, "loop width", name)
    assert one.value == pytest.approx(truth, rel=0.01)
    assert one.high - one.low < 0.02 * truth


def test_the_time_constant_is_that_of_the_pole(found):
    assert_holds(figure(found, "time constant"), -TS / np.log(0.9), 0.05)
