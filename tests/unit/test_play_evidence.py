"""More play operators, where the density that was found asks for them."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from it2hys.diagnosis.evidence.play import EVIDENCE
from it2hys.model.effects.play import COUNT, INITIAL, thresholds
from it2hys.model.variables import load_table
from it2hys.records.clues import Clues, Extent

EXTENT = Extent(1e-4, 1.0, (0.0, 100.0), (0.0, 16e-6))


def operators(values: dict) -> tuple[np.ndarray, np.ndarray]:
    places = range(1, int(values["playCount"]) + 1)
    return (
        np.array([values[f"play[{j}].threshold"] for j in places]),
        np.array([values[f"play[{j}].weight"] for j in places]),
    )


def extended(values: dict) -> dict:
    """Return the values with more operators."""
    [more] = EVIDENCE.extended(values, EXTENT)
    return more


def coarse(weights: list[float]) -> dict:
    own = {f"play[{j}].weight": w for j, w in enumerate(weights, start=1)}
    return {"playCount": COUNT, **thresholds(EXTENT), **own}


@given(st.lists(st.floats(0.0, 1.0), min_size=COUNT, max_size=COUNT).filter(lambda w: sum(w) > 1e-6))
def test_more_operators_have_the_same_memory_over_rising_thresholds(weights):
    before = coarse(weights)
    r, w = operators(extended(before))
    _, w_before = operators(before)
    assert len(r) == 16
    assert np.all(np.diff(r) > 0.0)
    assert r[0] > 0.0
    assert np.all(w >= 0.0)
    np.testing.assert_allclose(w.sum(), w_before.sum(), rtol=1e-12)
    assert r[-1] < 0.5 * EXTENT.voltage_span


def test_operators_are_close_where_the_density_is_great():
    weights = [0.4, 0.3, 0.1, *([0.0] * (COUNT - 3))]
    r, _ = operators(extended(coarse(weights)))
    r_before, _ = operators(coarse(weights))
    dense = r_before[2]
    assert np.count_nonzero(r <= dense) >= 2 * np.count_nonzero(r_before <= dense)


def test_there_is_no_more_of_no_memory_nor_beyond_the_most_operators():
    assert EVIDENCE.extended(coarse([0.0] * COUNT), EXTENT) == []
    assert EVIDENCE.extended(most(coarse([0.1] * COUNT)), EXTENT) == []


@given(st.integers(1, COUNT), st.floats(0.1, 2.0))
def test_a_scaled_memory_has_all_thresholds_at_a_multiple_and_its_weights(count, factor):
    values = {**coarse([0.1] * COUNT), "playCount": count}
    r, w = operators(values)
    change = EVIDENCE.scaled(values, EXTENT, factor)
    scaled = {**values, **change}
    if not change:  # no loop would engage the last one
        assert factor > 1.0 and factor * r[-1] > 0.5 * EXTENT.voltage_span
        return
    assert np.allclose(operators(scaled)[0], factor * r, rtol=1e-15)
    assert np.array_equal(operators(scaled)[1], w)


def test_a_single_operator_becomes_two():
    one = {"playCount": 1, "play[1].threshold": 10.0, "play[1].weight": 0.2}
    assert extended(one)["playCount"] == 2


def most(values: dict) -> dict:
    """Return the values with as many operators as there may be."""
    counts = [values["playCount"]]
    while counts[-1] < load_table().counts["play"]["maximum"]:
        values = values | extended(values)
        counts.append(values["playCount"])
    assert counts == [10, 16, 25, 32]
    return values


def test_operators_go_as_far_as_an_initial_curve_and_a_fit_of_them_has_that_reach():
    """From 0 V a stage is driven over twice the way that a loop engages operators on."""
    far = {"playCount": COUNT + INITIAL, **thresholds(EXTENT, initial=True)}
    far |= {f"play[{j}].weight": 0.1 for j in range(1, COUNT + INITIAL + 1)}
    r, _ = operators(far)
    assert np.all(np.diff(r) > 0.0)
    assert r[COUNT - 1] < 50.0 <= r[COUNT] and r[-1] < 100.0
    more, w = operators(extended(far))
    assert len(more) == 20 and 50.0 < more[-1] < 100.0
    np.testing.assert_allclose(w.sum(), 0.1 * (COUNT + INITIAL), rtol=1e-12)


def test_around_0_v_an_initial_curve_engages_what_loops_do():
    around_zero = Clues(replace(EXTENT, voltage=(-100.0, 100.0)), [])
    assert not EVIDENCE.further_guesses(around_zero)
    counts = {g["playCount"] for g in EVIDENCE.further_guesses(Clues(EXTENT, []))}
    assert counts == {COUNT + INITIAL}


def test_operators_that_only_an_initial_curve_engages_are_added_to_those_that_are_there():
    before = coarse([0.1] * COUNT)
    wider = before | EVIDENCE.reaching(before, EXTENT)
    r, w = operators(wider)
    np.testing.assert_array_equal(r, list(thresholds(EXTENT, initial=True).values()))
    np.testing.assert_array_equal(w[:COUNT], 0.1)
    assert np.all((w[COUNT:] > 0.0) & (w[COUNT:] < 0.01))
    assert EVIDENCE.reaching(wider, EXTENT) is None  # it reaches that far
    between = replace(EXTENT, voltage=(-50.0, 50.0))  # from 0 V no farther than in loops
    assert EVIDENCE.reaching(coarse([0.1] * COUNT), between) is None
    assert EVIDENCE.reaching(most(before), EXTENT) is None  # there may be no more of them
