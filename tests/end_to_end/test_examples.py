"""The scripts of examples/ do what they say."""

import importlib.util
import re
from pathlib import Path

import numpy as np

from it2hys.model import compiled

EXAMPLES = Path(__file__).parents[2] / "examples"


def load(name):
    place = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(place)
    place.loader.exec_module(module)
    return module


def test_a_voltage_under_the_amplifiers_limits_beats_the_clamping_inverse(capsys):
    example = load("amplifier_limits")
    voltages, wanted = example.main(), example.reference()
    errors = {name: example.rms_error(voltage, wanted) for name, voltage in voltages.items()}
    shown = capsys.readouterr().out
    clamped = int(re.search(r"clamps at (\d+) of", shown)[1])
    assert clamped > 100
    for name, error in errors.items():
        assert f"{name:22} {1e6 * error:.4f} µm rms" in shown
    ours, theirs = errors["IPOPT over the chain"], errors["closed-form inverse"]
    assert ours < 0.5 * theirs

    voltage, limited = voltages["IPOPT over the chain"], example.STAGE.replace(**example.LIMITS)
    # the amplifier passes it as it is: it is within both limits, and touches both
    low, high = example.LIMITS["saturation.minimum"], example.LIMITS["saturation.maximum"]
    most = example.LIMITS["slew.rate"] * example.STAGE["sampleTime"]
    change = np.abs(np.diff(voltage, prepend=example.voltage_at_rest()))
    assert low - 1e-6 <= voltage.min() and voltage.max() <= high + 1e-6
    assert most * (1.0 - 1e-6) <= change.max() <= most * (1.0 + 1e-6)
    unlimited = compiled.chain_free_run(example.STAGE, voltage)[0]
    passed = compiled.chain_free_run(limited, voltage)[0]
    np.testing.assert_allclose(passed, unlimited, rtol=0, atol=1e-12)
    # no small change of it within the limits does better: it is an optimum
    rng = np.random.default_rng(0)
    for _ in range(20):
        other = 0.99 * voltage + 0.01 * (low + (high - low) * rng.random(len(voltage)))
        assert example.rms_error(other, wanted) > ours
