"""A named effect whose fit rests on a bound is said so; one that does not, is not."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import TS, UM
from effects import signals, surroundings

from it2hys.diagnosis.bounds import bound_sentences
from it2hys.diagnosis.chances import Gains
from it2hys.diagnosis.fitting import Errors
from it2hys.diagnosis.imitation import overdriven_by, refusal
from it2hys.diagnosis.refinement import Node
from it2hys.diagnosis.selection import Search
from it2hys.identification.criterion import ChainCriterion, ChainFit, Model, Trace, minimise
from it2hys.identification.effect_coordinates import Coordinate
from it2hys.identification.inverse import References
from it2hys.identification.scaling import Scaling
from it2hys.model import compiled
from it2hys.model.own_loading import load_effect
from it2hys.model.parameters import table_1
from it2hys.model.stages import EFFECTS
from it2hys.policy import PHYSICS
from it2hys.records.clues import Extent

SAMPLES, NOISE = 3000, 0.005 * UM
EXTENT = Extent(TS, SAMPLES * TS, (0.0, 100.0), (0.0, 16 * UM))


def fitted_creep(
    gain: float,
    time_constant: float,
    of_sampling: bool = False,
    rested: bool = False,
    **others: float,
) -> ChainFit:
    """Return the fit of one term of creep to a stage that creeps by one, its rules and others known."""
    known = {**table_1(), "creepCount": 1, **others}
    truth = {**known, "creep[1].gain": gain, "creep[1].timeConstant": time_constant}
    voltage = signals(SAMPLES, 5.0, 95.0)
    drive = compiled.Drive.of(voltage, *surroundings(SAMPLES))
    rng = np.random.default_rng(1)
    own = {
        "initialDisplacement": np.array([5 * UM]),
        "initialCreep": np.zeros(1),
        "initialCreepAge": np.zeros(1),
    }
    model = Model(truth, ("creep",), np.zeros(1), own, rested=rested)
    used = np.ones(SAMPLES, dtype=bool)
    empty = Trace(
        "record", "train", drive, np.zeros(SAMPLES), 1.0 * used, used, 40, NOISE,
        References(voltage, used, NOISE, TS),
    )  # fmt: skip
    trace = replace(empty, y=model.predict(empty, 0) + NOISE * rng.standard_normal(SAMPLES))
    starts = EFFECTS["creep"].starts(EXTENT, 1)
    guess = {name: s.value for name, s in starts.items() if not name.startswith("initial")}
    fitted = [
        Coordinate.of(name, start._replace(of_sampling=of_sampling)) for name, start in starts.items()
    ]
    fitted.append(Coordinate("initialDisplacement", (0.0, 16 * UM), logarithmic=False))
    start = replace(model, values={**known, **guess})
    criterion = ChainCriterion([trace], start, fitted, Scaling(8 * UM, 8 * UM, 50.0, 50.0))
    return minimise(criterion.holding(["rules"]), 100)


def test_more_creep_than_there_is_in_stacks_is_said():
    (sentence,) = bound_sentences(fitted_creep(0.2, 0.03), ("creep",))
    assert f"creep[1].gain ({PHYSICS.slow_gain:g})" in sentence
    assert "Do not read its parameters as the stage's" in sentence


@pytest.mark.parametrize("gain", [0.0, 0.5 * PHYSICS.slow_gain])
def test_a_fit_within_its_bounds_and_a_term_of_nothing_are_not_said(gain):
    assert bound_sentences(fitted_creep(gain, 0.03), ("creep",)) == []


def test_what_is_held_rests_on_no_bound():
    """Creep that goes on behind the records was held, and an effect was taken back for that."""
    held = fitted_creep(0.2, 0.03).criterion.holding(["creep[1].gain", "creep[1].timeConstant"])
    assert bound_sentences(minimise(held, 20), ("creep",)) == []


def test_an_effect_that_was_not_named_is_not_said():
    assert bound_sentences(fitted_creep(0.2, 0.03), ("play",)) == []


def test_an_addition_that_presses_another_effect_against_its_bound_is_seen():
    within, beyond = (Node(frozenset(), fitted_creep(gain, 0.03), None) for gain in (0.02, 0.2))
    assert overdriven_by(within, beyond, 0.2) == ("creep",)
    assert overdriven_by(beyond, beyond, 0.2) == overdriven_by(beyond, within, 0.2) == ()


def test_an_addition_that_explains_most_of_the_error_may_press_others():
    within, beyond = (Node(frozenset(), fitted_creep(gain, 0.03), None) for gain in (0.02, 0.2))
    assert overdriven_by(within, beyond, 0.94) == ()


def test_how_signals_were_sampled_may_rest_on_a_bound():
    """It is no size of a stage: neither said, nor a reason to refuse an addition."""
    within, beyond = (Node(frozenset(), fitted_creep(gain, 0.03, True), None) for gain in (0.02, 0.2))
    assert bound_sentences(beyond.fit, ("creep",)) == []
    assert overdriven_by(within, beyond, 0.2) == ()


def test_what_tells_of_sampling_says_so():
    starts = {n: s for e in EFFECTS.values() for n, s in e.starts(EXTENT).items()}
    of_sampling = [n for n, s in starts.items() if s.of_sampling]
    assert of_sampling == ["resonance.samplingZero", "resonance.samplingDelay"]
    example = load_effect(Path(__file__).parents[2] / "examples/own_effects/second_resonance.py")
    of_example = [n for n, s in example.starts(EXTENT).items() if s.of_sampling]
    assert of_example == ["second_resonance.straight"]


def test_an_effect_is_nil_where_all_that_may_be_nothing_is():
    delay, creep, lag = EFFECTS["delay"], EFFECTS["creep"], EFFECTS["lag"]
    assert delay.is_nil({"delay.time": 0.0}, EXTENT)
    assert not delay.is_nil({"delay.time": 0.1 * TS}, EXTENT)
    terms = {f"creep[{i}].{name}": 0.1 for i in (1, 2) for name in ("gain", "timeConstant")}
    none = {name: 0.0 if name.endswith("gain") else value for name, value in terms.items()}
    assert creep.is_nil({"creepCount": 2, **none}, EXTENT)
    assert not creep.is_nil({"creepCount": 2, **none, "creep[2].gain": 0.01}, EXTENT)
    # a lag cannot be nothing within its bounds
    assert not lag.is_nil({"lag.timeConstant": 5e-6}, EXTENT)


def test_an_effect_of_which_the_last_fit_leaves_nothing_is_taken_back():
    """A report named a delay of 0 s."""
    within = fitted_creep(0.02, 0.03)
    search = Search(SimpleNamespace(extent=EXTENT))
    node = Node(frozenset({"creep"}), within, None)
    assert search.withdrawn_by(node, within) == {}
    at_zero = replace(within.minimum, coordinates=np.zeros_like(within.minimum.coordinates))
    withdrawn = search.withdrawn_by(node, ChainFit(within.criterion, at_zero))
    assert withdrawn == {"creep": "the fit to the whole records leaves nothing of it"}
    assert search.anew_without(withdrawn).withdrawn == withdrawn


def drift_beside_creep(share: float, rested: bool = False, **drift: float) -> str:
    """Return why a drift beside creep is refused, which leaves a share of the error."""
    fit = fitted_creep(0.02, 0.03, rested=rested, **drift)
    noise = NOISE * np.random.default_rng(2).standard_normal(SAMPLES)
    without, found = (
        Node(frozenset(effects), fit, Errors(*([size * noise] for _ in range(3))))
        for effects, size in (({"creep"}, 1.0), ({"creep", "drift"}, share))
    )
    assert not refusal(found, found, Gains.of(found.errors, found.errors))
    return refusal(without, found, Gains.of(without.errors, found.errors))


def test_a_drift_with_time_is_refused_where_creep_is_still_under_way():
    """Records of a stage that was driven before named a drift that was creep of minutes."""
    assert "begin them after a longer rest" in drift_beside_creep(0.7, **{"drift.rate": 2e-9})


@pytest.mark.parametrize(
    "found",
    [
        {"share": 0.3, "drift.rate": 2e-9},
        {"share": 0.7, "drift.rate": 2e-9, "rested": True},
        {"share": 0.7, "drift.rate": 2e-9, "drift.temperatureCoefficient": 1e-8},
    ],
    ids=["most of the error", "begun at rest", "by temperature"],
)
def test_a_drift_that_creep_does_not_do_is_accepted(found):
    assert not drift_beside_creep(**found)
