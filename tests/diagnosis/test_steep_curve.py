"""A static curve that is steep at its ends is found: nothing is asked of it where nothing was read."""

from dataclasses import replace

import numpy as np
from conftest import TS, UM
from effects import signals, surroundings

from it2hys.diagnosis.fitting import Bench
from it2hys.identification.criterion import Model, Trace
from it2hys.identification.inverse import References
from it2hys.identification.scaling import Scaling
from it2hys.model import compiled
from it2hys.model.effects.nonlinearity import COEFFICIENTS
from it2hys.model.parameters import table_1
from it2hys.records.clues import Extent

SAMPLES, NOISE = 2000, 0.002 * UM
EXTENT = Extent(TS, SAMPLES * TS, (0.0, 100.0), (0.0, 13 * UM))
#: Waves as of a Chebyshev polynomial of degree 4; continued by a tenth of the range they would fall.
WAVES = dict(zip(COEFFICIENTS, (0.0, 0.0, -2.6 * UM, 0.0, 0.0), strict=True))


def test_waves_that_would_fall_beyond_the_readings_are_found():
    voltage, rng = signals(SAMPLES, 2.0, 98.0), np.random.default_rng(3)
    drive = compiled.Drive.of(voltage, *surroundings(SAMPLES))
    used = np.ones(SAMPLES, dtype=bool)
    own = {"initialDisplacement": np.array([5 * UM])}
    plain = Model(table_1(), (), np.zeros(1), own)
    empty = Trace(
        "record", "train", drive, np.zeros(SAMPLES), 1.0 * used, used, 40, NOISE,
        References(voltage, used, NOISE, TS),
    )  # fmt: skip
    straight = plain.predict(empty, 0)
    waves = {f"nonlinearity.{name}": value for name, value in WAVES.items()}
    ends = {
        "nonlinearity.minimum": float(straight.min()), "nonlinearity.maximum": float(straight.max())
    }  # fmt: skip
    values = {**plain.values, **waves, **ends}
    truth = replace(plain, values=values, effects=("nonlinearity",))
    y = truth.predict(empty, 0) + NOISE * rng.standard_normal(SAMPLES)
    trace = replace(empty, y=y, references=References(y, used, NOISE, TS))
    bench = Bench([trace], Scaling(7 * UM, 7 * UM, 50.0, 50.0), EXTENT, [trace])
    found = bench.finish(bench.add(plain, "nonlinearity").model, 100).model
    assert np.std(found.predict(trace, 0) - y) < 1.05 * NOISE
