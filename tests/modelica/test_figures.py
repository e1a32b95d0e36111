"""The pictures in the examples' texts show what their classes declare as figures."""

import re

import pytest
from figures import FIGURES
from library import CLASSES, EXAMPLES, LIBRARY

CURVE = re.compile(r"Curve\((?:x=(?P<x>[\w.\[\]]+), )?y=(?P<y>[\w.\[\]]+), legend=\"[^\"]+\"\)")


def declared(name: str) -> set[tuple[str, str]]:
    """Return the curves of an example's figures as (x, y); every one has a legend."""
    text = CLASSES[name].read_text(encoding="utf-8")
    found = {(curve["x"] or "time", curve["y"]) for curve in CURVE.finditer(text)}
    assert len(re.findall(r"Curve\(", text)) == len(CURVE.findall(text))
    return found


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_picture_shows_the_curves_of_the_class(name):
    """All of the figure that tools show first, and nothing that the class does not name."""
    panels = FIGURES[name.rsplit(".", 1)[-1]]
    drawn = {(panel.x, y) for panel in panels for y in panel.curves}
    assert drawn <= declared(name)
    text = CLASSES[name].read_text(encoding="utf-8")
    preferred = text[text.index("preferred=true") :].split("Figure(")[0]
    assert {(c["x"] or "time", c["y"]) for c in CURVE.finditer(preferred)} <= drawn


def test_every_example_has_a_picture_that_a_command_draws():
    shorts = {name.rsplit(".", 1)[-1] for name in EXAMPLES}
    assert set(FIGURES) == shorts
    assert {p.stem for p in (LIBRARY / "Resources/Images/Examples").iterdir()} == shorts
