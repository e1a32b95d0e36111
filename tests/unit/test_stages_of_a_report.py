"""The models between the first and the last, of which a report shows the errors."""

from types import SimpleNamespace

import pytest

from it2hys.diagnosis.diagnose import _Session


def search_of(*chains):
    """Return a search's nodes, one for each set of effects."""
    nodes = {c: SimpleNamespace(effects=frozenset(c), rms=1.0, fit=fit_of(c)) for c in chains}
    return SimpleNamespace(nodes=nodes, root=nodes[()])


def fit_of(effects):
    return SimpleNamespace(model=SimpleNamespace(effects=effects))


class Session(_Session):
    """One whose fits and runs stand for themselves."""

    def __init__(self, usable):
        self._usable = usable
        self._windows = self._whole = self._all_fitted = ()
        self._is_whole = True

    def _searched(self):
        return []

    def _with_range(self, model):
        return ("usable", *model.effects) if model.effects in self._usable else None

    def _judgements(self, model, bench, traces):
        return model

    def _stage(self, label, node, parts, judgements):
        return label, judgements


@pytest.mark.parametrize("usable", [{("play",)}, set()])
def test_a_model_on_the_way_that_is_not_usable_is_left_out(usable):
    search = search_of((), ("play",), ("play", "creep"))
    node = SimpleNamespace(
        effects=frozenset({"play", "creep"}),
        added=frozenset({"play", "creep"}),
        fit=fit_of(("play", "creep")),
    )
    bench = SimpleNamespace(deciding=None, errors=lambda *_: SimpleNamespace(free=[]))
    stages = Session(usable)._stages(search, node, node.fit, bench, "first", "last", ())
    between = [("play", ("usable", "play"))] if usable else []
    assert stages == (("before", "first"), *between, ("play + creep", "last"))
