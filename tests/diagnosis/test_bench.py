"""How models are fitted to one short record."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import TS, UM
from effects import signals, surroundings

from it2hys.diagnosis import fitting
from it2hys.diagnosis.fitting import Bench
from it2hys.identification import inverse
from it2hys.identification.criterion import Model, Trace
from it2hys.identification.inverse import References
from it2hys.identification.result import IdentificationError
from it2hys.identification.scaling import Scaling
from it2hys.identification.traces import within
from it2hys.model import compiled
from it2hys.model.effects.nonlinearity import COEFFICIENTS
from it2hys.model.parameters import table_1
from it2hys.records.clues import Extent

SAMPLES, NOISE = 2000, 0.002 * UM
EXTENT = Extent(TS, SAMPLES * TS, (0.0, 100.0), (0.0, 13 * UM))
#: Waves as of a Chebyshev polynomial of degree 4; continued by a tenth of the range they would fall.
WAVES = dict(zip(COEFFICIENTS, (0.0, 0.0, -2.6 * UM, 0.0, 0.0), strict=True))


@pytest.fixture
def plain():
    """Return the paper's model of one record."""
    own = {"initialDisplacement": np.array([5 * UM])}
    return Model(table_1(), (), np.zeros(1), own)


@pytest.fixture
def empty():
    """Return a record of a voltage, without readings."""
    voltage, used = signals(SAMPLES, 2.0, 98.0), np.ones(SAMPLES, dtype=bool)
    drive = compiled.Drive.of(voltage, *surroundings(SAMPLES))
    references = References(voltage, used, NOISE, TS)
    return Trace("record", "train", drive, np.zeros(SAMPLES), 1.0 * used, used, 40, NOISE, references)


def bench_of(empty: Trace, truth: Model) -> Bench:
    """Return the record with readings of a stage and noise, to fit models to."""
    noise = NOISE * np.random.default_rng(3).standard_normal(SAMPLES)
    y = truth.predict(empty, 0) + noise
    trace = replace(empty, y=y, references=References(y, empty.judged, NOISE, TS))
    return Bench([trace], Scaling(7 * UM, 7 * UM, 50.0, 50.0), EXTENT, [trace])


def test_waves_that_would_fall_beyond_the_readings_are_found(plain, empty):
    """Nothing is asked of a curve where nothing was read."""
    straight = plain.predict(empty, 0)
    waves = {f"nonlinearity.{name}": value for name, value in WAVES.items()}
    ends = {
        "nonlinearity.minimum": float(straight.min()), "nonlinearity.maximum": float(straight.max())
    }  # fmt: skip
    values = {**plain.values, **waves, **ends}
    bench = bench_of(empty, replace(plain, values=values, effects=("nonlinearity",)))
    found = bench.finish(bench.add(plain, "nonlinearity").model, 100).model
    trace = bench.traces[0]
    assert np.std(found.predict(trace, 0) - trace.y) < 1.05 * NOISE


def test_a_part_of_a_sample_is_sought_from_the_end_that_a_fit_did_not_find(plain, empty):
    """While something is missing, the wrong end may be the better one, and stays once it is there."""
    values = {**plain.values, "slew.rate": 4000.0, "delay.time": 0.02 * TS}
    slewed = replace(plain, values=values, effects=("slew",))
    steps = np.repeat(np.random.default_rng(4).uniform(5.0, 95.0, SAMPLES // 20), 20)
    driven = replace(empty, drive=replace(empty.drive, voltage=steps))
    bench = bench_of(driven, slewed)
    wrong = replace(slewed, values={**values, "delay.time": 0.99 * TS, "slew.rate": 3900.0})
    fit = bench.fit(wrong, 60)
    better = bench.resampled(fit)
    assert fit.model.values["delay.time"] > 0.9 * TS
    assert better.model.values["delay.time"] < 0.1 * TS
    assert better.minimum.cost < fit.minimum.cost
    assert bench.resampled(better).model.values["delay.time"] < 0.1 * TS


@pytest.mark.parametrize(
    ("limits", "left"), [((12.0, 101.0), (12.0, 110.0)), ((-1.0, 90.0), (-10.0, 90.0))]
)
def test_a_limit_that_no_record_reaches_is_none(plain, empty, limits, left):
    """It ended 0.4 V above the records, and cut off one that was not fitted, which went further."""
    names = ("saturation.minimum", "saturation.maximum")
    values = {**plain.values, **dict(zip(names, limits, strict=True))}
    limited = replace(plain, values=values, effects=("saturation",))
    bench = bench_of(empty, limited)
    fit = bench.fit(limited, 5)
    freed = bench.without_unseen(fit)
    assert [freed.model.values[n] for n in names] == pytest.approx(left, rel=0.01)
    assert freed.model.values["rule[1].q1"] == fit.model.values["rule[1].q1"]
    given = replace(bench, known=dict(zip(names, limits, strict=True)))
    assert given.without_unseen(fit) is fit  # other records may have shown it


def test_a_limit_that_takes_up_noise_at_the_end_of_the_records_is_none(plain, empty):
    """It ended 0.09 V below the highest voltage; one 6 V higher was at 11 times the noise by it."""
    end = float(empty.drive.voltage.max())
    limits = {"saturation.minimum": 12.0, "saturation.maximum": end - 0.02}
    limited = replace(plain, values={**plain.values, **limits}, effects=("saturation",))
    bench = bench_of(empty, limited)
    fit = bench.fit(limited, 5)
    assert fit.model.values["saturation.maximum"] < end
    freed = bench.without_unseen(fit).model.values
    assert freed["saturation.maximum"] == pytest.approx(110.0)
    assert freed["saturation.minimum"] == fit.model.values["saturation.minimum"]


@pytest.mark.parametrize("late", [0.0, 2.0], ids=["at once", "late"])
def test_behind_the_turns_of_the_voltage_a_displacement_that_waits_shows(plain, empty, late):
    """However much both models miss that is slow."""
    levels = np.random.default_rng(4).uniform(5.0, 95.0, 11)
    voltage = np.interp(np.arange(SAMPLES), np.linspace(0, SAMPLES, len(levels)), levels)
    driven = replace(empty, drive=replace(empty.drive, voltage=voltage))
    at_once, waiting = (
        replace(plain, values={**plain.values, "delay.time": d * TS}, effects=("delay",))
        for d in (0.0, 2.0)
    )
    bench = bench_of(driven, waiting if late else at_once)
    (trace,) = bench.traces
    slow = replace(trace, y=trace.y + 50 * NOISE * np.sin(np.arange(SAMPLES) / 100.0))
    for bench_or_slow in (bench, replace(bench, traces=[slow])):
        ratio = bench_or_slow.likelihood_ratio_behind_turns(at_once, waiting)
        assert ratio > 20.0 if late else ratio < -20.0


def test_where_no_rules_are_found_those_of_the_model_stay(plain, empty, monkeypatch):
    """One effect too many that is tried must not end a diagnosis."""

    def diverging(*_):
        raise IdentificationError("no free run stays finite")

    monkeypatch.setattr(fitting, "search_rules", diverging)
    bench = bench_of(empty, plain)
    trace = bench.traces[0]
    found = bench.reshaped(plain).model
    assert np.std(found.predict(trace, 0) - trace.y) < 1.05 * NOISE


def test_an_inverse_that_is_judged_keeps_to_the_voltages_of_the_records(plain, empty):
    """As when it is packaged, it does not follow a ring that the model lacks to any voltage."""
    time = np.arange(SAMPLES) * TS
    ring = 3.0 * UM * np.exp(-time / 0.003) * np.sin(2.0 * np.pi * 700.0 * time)
    trace = replace(empty, drive=compiled.Drive.of(50.0 * (1.0 - np.cos(2.0 * np.pi * 10.0 * time))))
    stage = replace(plain, own={"initialDisplacement": np.array([0.0])})
    rung = stage.predict(trace, 0) - ring
    trace = replace(trace, y=rung, references=References(rung, trace.judged, NOISE, TS))
    bench = Bench([trace], Scaling(7 * UM, 7 * UM, 50.0, 50.0), EXTENT, [trace], parts=True)
    error = bench.errors(stage).wide[0] * EXTENT.voltage_span / EXTENT.displacement_span
    asked = error + trace.drive.voltage[trace.references.wide.inside]
    assert -5.1 <= asked.min() < -4.9 and asked.max() < 105.1


@pytest.mark.parametrize(
    ("begins", "counts"),
    [((2.0, 2.0, 60.0), False), ((2.0, 2.0, 2.0), True), ((2.0, 40.0, 60.0), True)],
)
def test_a_constant_that_no_fitted_record_could_show_decides_nothing(plain, empty, begins, counts):
    """One began after rest at 63 V, all others at 0 V: slow creep decided which effects are there."""
    slow, traces = 50.0 * NOISE, []
    for begin in begins:
        voltage = begin + np.linspace(0.0, 1.0, SAMPLES) * (signals(SAMPLES, 2.0, 98.0) - begin)
        driven = replace(empty, drive=replace(empty.drive, voltage=voltage))
        traces += bench_of(driven, plain).traces
    *fitted, deciding = traces
    crept = replace(deciding, y=deciding.y + slow)
    crept = replace(crept, references=References(crept.y, crept.judged, NOISE, TS))
    bench = replace(bench_of(empty, plain), traces=fitted, deciding=[crept])
    errors = bench.errors(plain)
    assert (abs(np.mean(errors.free[0])) > 0.9 * slow) == counts
    assert (abs(np.mean(errors.band[0])) > 0.5 * slow) == counts
    assert np.std(errors.free[0][500:]) < 1.2 * NOISE


def test_behind_voltages_that_were_not_fitted_no_inverse_is_judged(plain, empty):
    """Its play remembers what it asked for there: finer operators, nearer to the truth, went."""
    play = {"playCount": 1, "play[1].threshold": 10.0, "play[1].weight": 0.5}
    own = {**plain.own, **dict.fromkeys(("initialDemagnetisation", "initialExcursion"), np.zeros(1))}
    stage = replace(plain, values={**plain.values, **play}, effects=("play",), own=own)

    def left(begin: int) -> Trace:
        voltage = 0.8 * empty.drive.voltage
        rise = np.sin(np.linspace(0.0, np.pi, 300)) ** 2
        voltage[begin : begin + 300] += rise * (125.0 - voltage[begin : begin + 300])
        y = stage.predict(replace(empty, drive=replace(empty.drive, voltage=voltage)), 0)
        y += 0.05 * UM * np.maximum(voltage - 110.0, 0.0)  # the stage goes on otherwise than the model
        driven = replace(empty, y=y, drive=replace(empty.drive, voltage=voltage))
        driven = replace(driven, references=References(y, empty.judged, NOISE, TS))
        return within(driven, EXTENT.voltage)

    early, late = left(50), left(1200)
    bench = replace(bench_of(empty, stage), deciding=[early, late])
    (before,) = bench.errors(stage).band
    assert 1000 < len(before) < 1350 and np.std(before) < 3.0 * NOISE
    assert min(len(e) for e in bench.errors(stage).free) > SAMPLES - 300
    assert bench.least_inverse_error(stage) < 5.0 * NOISE
    # where no record has more, all of it counts
    (whole,) = replace(bench, deciding=[early]).errors(stage).band
    assert len(whole) > 1500 and np.std(whole) > 10.0 * NOISE


def test_only_judged_samples_say_which_of_two_fits_is_calmer(plain, empty):
    """All of them did: what nothing judges hid the delay of a measured stage."""
    bench = bench_of(empty, plain)
    (trace,) = bench.traces
    early = np.arange(SAMPLES) < SAMPLES // 2

    def unrest(y: np.ndarray) -> float:
        judged = replace(trace, y=y, judged=early, references=References(y, trace.judged, NOISE, TS))
        return replace(bench, traces=[judged])._unrest(SimpleNamespace(model=plain))

    moved = np.where(np.arange(SAMPLES) < SAMPLES // 2 + 50, trace.y, trace.y + 40.0 * NOISE)
    assert unrest(moved) == pytest.approx(unrest(trace.y), rel=0.05)


@pytest.mark.parametrize("name", ["band", "wide"])
def test_an_inverse_misses_what_its_reference_leaves_out(plain, empty, name):
    """Reversals from sample to sample: play, the truth, gave way to a delay that missed a bit less."""
    quick = 0.9 * np.sin(2.0 * np.pi * 0.31 * np.arange(SAMPLES))
    voltage = signals(SAMPLES, 20.0, 80.0) + quick
    bench = bench_of(replace(empty, drive=replace(empty.drive, voltage=voltage)), plain)
    errors, least = bench.errors(plain), bench.least_inverse_error(plain, name)
    assert np.std(getattr(errors, name)[0]) == pytest.approx(least, rel=0.1)
    (trace,) = bench.traces
    noise = inverse.noise_of_inverse(
        {**plain.values, **plain.start(0)}, trace.drive, trace.references, name
    )
    assert least > 1.5 * np.std(noise) * EXTENT.displacement_span / EXTENT.voltage_span
