"""The last fit of a diagnosis: a core that cannot be made usable."""

from types import SimpleNamespace

import numpy as np
import pytest

from it2hys.diagnosis import last_fit as module
from it2hys.diagnosis.last_fit import last_fit
from it2hys.errors import InputError
from it2hys.identification.criterion import Model, with_rules

POOR, USABLE = np.full((1, 6), 2.0), np.full((1, 6), 1.0)


def model(rules):
    return with_rules(Model({}, (), np.zeros(0), {}), rules)


@pytest.fixture
def bench(monkeypatch):
    """Return a bench whose fits stay where they begin; of its cores one is usable."""
    monkeypatch.setattr(
        module, "usable_over", lambda m, _: m if np.array_equal(m.rules, USABLE) else None
    )

    def criterion(model):
        held = SimpleNamespace(model=model, held=())
        return SimpleNamespace(holding=lambda _: held, **vars(held))

    def stay(model, *_):
        return SimpleNamespace(model=model, minimum=None, criterion=criterion(model))

    ways = {"finish": stay, "fit": stay, "rested": lambda fit, *_: fit, "criterion": criterion}
    return SimpleNamespace(traces=[], begins_alike=False, **ways)


def test_a_core_past_mending_is_begun_again_from_the_one_before(bench):
    """A square wave's ended in a message after all the work, where `identify` had a model."""
    _, fit = last_fit(bench, model(POOR), model(USABLE))
    assert np.array_equal(fit.criterion.model.rules, USABLE)


def test_without_any_usable_core_it_is_refused(bench):
    with pytest.raises(InputError, match="has an inverse"):
        last_fit(bench, model(POOR), model(POOR))
