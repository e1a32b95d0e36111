"""How a given model does on records: with all its effects, begun as each record begins."""

import numpy as np
import pytest
from conftest import TS
from effects import with_effects

from it2hys.identification.evaluation import as_identification, evaluate
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS
from it2hys.model.parameters import ParameterSet, table_1
from it2hys.records import Record
from it2hys.reports.details import details
from it2hys.reports.summary import record_json, summary

#: Of what a record can show by itself: the rest needs other channels, or begins at time 0.
SHOWN = [e for e in EFFECTS if e not in ("drift", "load")]
SAMPLES = 2000
#: What a report has beside what it says of a result.
PLAIN = {"sections": [], "inputs": [], "seed": None, "version": "0"}


def record_of(parameters: ParameterSet, high: float = 90.0) -> Record:
    """Return what the set itself makes of a sine after long rest at its lowest voltage."""
    time = np.arange(SAMPLES) * TS
    voltage = 10.0 + (high - 10.0) / 2 * (1.0 - np.cos(2 * np.pi * 100 * time))
    held = compiled.chain_free_run(parameters, np.full(20_000, voltage[0]))[0][-1]
    rested = parameters.replace(initialDisplacement=held)
    return Record("own", time, voltage, compiled.chain_free_run(rested, voltage)[1], TS)


@pytest.mark.parametrize("effects", [(), *((e,) for e in SHOWN), ("lag", "play", "creep", "resonance")])
def test_a_set_explains_what_it_made_itself(effects):
    changes = dict.fromkeys(("initialDemagnetisation", "initialExcursion", "initialCreep"), 0.0)
    parameters = with_effects(effects, 5, **changes)
    record = record_of(parameters)
    (result,) = evaluate(parameters, [record])
    travel = np.ptp(record.displacement)
    assert result.e_rms < 1e-3 * travel
    # the FMU begun so makes this run
    again = compiled.chain_free_run(parameters.replace(**result.start), record.voltage)[1]
    assert again.tobytes() == result.y.tobytes()
    assert (result.one_step is None) == bool(effects)
    if effects:
        (alone,) = evaluate(table_1(), [record])
        assert alone.e_rms > 3.0 * result.e_rms


def test_samples_beyond_the_range_are_counted():
    parameters = table_1()
    inside, outside = (evaluate(parameters, [record_of(parameters, v)])[0] for v in (100.0, 140.0))
    assert not inside.out_of_range.any()
    assert 100 < np.count_nonzero(outside.out_of_range) < SAMPLES
    assert np.abs(outside.y).max() < 20e-6


def test_the_report_says_how_many_samples_of_a_record_are_beyond_the_model():
    parameters, record = table_1(), record_of(table_1(), 140.0)
    results = evaluate(parameters, [record])
    count = np.count_nonzero(results[0].out_of_range)
    report = summary(as_identification(parameters, results), [record]) | PLAIN
    text = " ".join(t for section in details(report) for t in section.text)
    assert f"{count} of {SAMPLES} samples are outside the range of the model, 0 to 110 V" in text
    assert "to 140 V" in text
    within = record_of(table_1(), 100.0)
    (result,) = evaluate(parameters, [within])
    assert record_json(within, result, parameters)["out_of_range"] is None


def test_what_a_model_follows_of_a_fast_record_is_no_noise():
    """A designed record of steps to every second sample: its differences are those of the stage."""
    rng, noise = np.random.default_rng(7), 5e-9
    voltage = np.concatenate([np.zeros(50), np.repeat(rng.uniform(5.0, 95.0, SAMPLES // 2), 2)])
    parameters = with_effects(("delay",), 5)
    reading = compiled.chain_free_run(parameters, voltage)[1]
    reading = reading + noise * rng.standard_normal(len(voltage))
    record = Record("fast", np.arange(len(voltage)) * TS, voltage, reading, TS)
    (result,) = evaluate(parameters, [record])
    assert result.noise == pytest.approx(noise, rel=0.2)
    assert result.noise_method.endswith("of what the model leaves")
    assert result.e_rms == pytest.approx(noise, rel=0.2)
