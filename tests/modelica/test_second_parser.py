"""Every file of the library in pymoca's parser: another grammar of Modelica than rumoca's.

Of it the grammar alone serves: its flattening knows no `size` of a function's input. A third front end
of the registries, `modelica` 0.0.205, needs Python 3.12; tried once, it parsed every file, flattened
three components, and knew no open vectors.
"""

import pytest
from compared import PACKAGE
from library import CLASSES, EXAMPLES

parser = pytest.importorskip(
    "pymoca.parser", reason="pymoca, a second Modelica parser, is not installed"
)


@pytest.mark.parametrize("name", CLASSES)
def test_a_class_is_modelica_to_another_parser_too(name):
    found = parser.parse(CLASSES[name].read_text(encoding="utf-8"))
    for part in name.split("."):
        found = found.classes[part]
    assert found.name == name.rsplit(".", 1)[-1]


def test_the_test_package_is_modelica_to_another_parser_too():
    found = parser.parse(PACKAGE.read_text(encoding="utf-8")).classes["IT2HysteresisTest"]
    assert {name.rsplit(".", 1)[-1] for name in EXAMPLES} <= set(found.classes)


def test_the_parser_refuses_what_is_no_modelica():
    with pytest.raises(parser.ModelicaSyntaxError):
        parser.parse("model M Real x; equation x = ; end M;")
