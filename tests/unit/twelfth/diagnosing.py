"""Diagnoses records of the twelfth effect: left out and offered, and declared."""

import numpy as np

from it2hys.diagnosis import diagnose
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet
from it2hys.model.stages import EFFECTS
from it2hys.records import Record

GAIN, NOISE, SAMPLES, TS, UM = 0.6, 5e-9, 600, 1e-4, 1e-6
#: A stage of one rule, which is quick to fit: 0.14 um/V, a lag of six ticks.
PLAIN = ParameterSet.from_rules(
    np.array([[4 * UM, 8 * UM, 7 * UM, 0.85, 0.021 * UM, 0.0]]),
    name="plain",
    initialDisplacement=2.8 * UM,
)


def record(name: str, seed: int) -> Record:
    """Return a record of the stage with the effect, from rest at 20 V."""
    rng = np.random.default_rng(seed)
    t = np.arange(SAMPLES) * TS
    steps = np.repeat(rng.uniform(-15.0, 15.0, SAMPLES // 50), 50)
    wave = 30.0 * np.cos(2.0 * np.pi * rng.uniform(20.0, 40.0) * t)
    voltage = 50.0 - wave + np.where(t > 0.005, steps, 0.0)
    displacement, _ = compiled.chain_free_run(PLAIN.replace(**{"tilt.gain": GAIN}), voltage)
    reading = displacement + NOISE * rng.standard_normal(SAMPLES)
    return Record(name, t, voltage, reading, sample_time=TS)


train, validation = [record("a", 1), record("b", 2)], [record("c", 3)]
others = tuple(name for name in EFFECTS if name != "tilt")
for declared in ((), ("tilt",)):
    found = diagnose(train, validation, model=PLAIN, declared=declared, excluded=others)
    assert (*found.effects, *found.declared) == ("tilt",), (found.effects, found.declared)
    assert abs(found.parameters["tilt.gain"] / GAIN - 1.0) < 0.05, found.parameters["tilt.gain"]
    low, high = found.intervals["tilt.gain"]
    assert low < found.parameters["tilt.gain"] < high
    assert not found.unexplained, found.left_over
    (row,) = [e for e in found.evidence if e.effect == "tilt"]
    if declared:
        assert row.why == "declared: in the model from the start"
    else:
        assert row.accepted and row.held_out_gain > 0.5 and row.why.startswith("adding it"), row
        assert row.p_value < 1e-2 and "the displacement's change" in row.signature
print("diagnosed")
