"""What records cannot show may be all that was named of them."""

from types import SimpleNamespace

import numpy as np
import pytest

from it2hys.diagnosis import selection
from it2hys.diagnosis.rows import indistinguishable
from it2hys.diagnosis.selection import Node, Search

UNTRIED = ("delay", "lag", "play")


def node(rms: float, *added: str) -> Node:
    fit = SimpleNamespace(model=SimpleNamespace(effects=()))
    return Node(frozenset(added), fit, SimpleNamespace(free=[np.full(4, rms)]))


@pytest.mark.parametrize(
    ("by_play", "groups"),
    [
        (1.2, [("delay", "lag", "play", "nonlinearity")]),  # play takes nearly all of it as well
        (3.0, [UNTRIED]),  # play takes hardly any of it
    ],
)
def test_an_effect_that_an_untried_one_does_without_is_not_told_from_it(monkeypatch, by_play, groups):
    found = {"delay": None, "lag": node(3.9, "lag"), "play": node(by_play, "play")}
    monkeypatch.setattr(selection, "_with_one", lambda bench, root, effect: found[effect])
    search = Search(bench=None)
    search.root, chosen = node(4.0), node(1.0, "nonlinearity")
    search.nodes[search.root.added] = search.root
    search.compare_with(chosen, UNTRIED)
    settled = search.settled(chosen)
    assert settled.effects == (frozenset() if len(groups[0]) > 3 else {"nonlinearity"})
    assert [*indistinguishable(chosen, search.rivals, UNTRIED)] == groups


def test_where_nothing_was_named_nothing_is_compared(monkeypatch):
    search = Search(bench=None)
    search.root = node(4.0)
    search.compare_with(search.root, UNTRIED)
    assert search.rivals == []
    assert [*indistinguishable(search.root, [], UNTRIED)] == [UNTRIED]
    assert indistinguishable(search.root, [], ()) == ()
