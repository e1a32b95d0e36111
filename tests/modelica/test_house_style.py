"""The house style of the Modelica Standard Library, class by class."""

import re
import tomllib

import pytest
from library import CLASSES, EXAMPLES, FILES, HEADER, LIBRARY, REFERENCE, html, kind, stored_path
from lxml import etree

from it2hys.export.modelica import LIBRARY_VERSION

each_class = pytest.mark.parametrize("name", CLASSES)
each_example = pytest.mark.parametrize("name", EXAMPLES)


@each_class
def test_the_file_holds_the_class_of_its_name_with_a_description(name):
    text = CLASSES[name].read_text(encoding="utf-8")
    header = HEADER.match(text)
    assert header, "no within clause or no description"
    assert f"{header['within'].strip()}.{header['name']}".lstrip(".") == name
    assert text.endswith(f"\nend {header['name']};\n")


@each_class
def test_info_and_revisions_are_well_formed_html(name):
    nested = len(
        re.findall(r"^  function \w+", CLASSES[name].read_text(encoding="utf-8"), re.MULTILINE)
    )
    for attribute in ("info", "revisions"):
        texts = html(CLASSES[name], attribute)
        assert len(texts) == 1 + nested, attribute
        for root in map(etree.fromstring, texts):
            assert root.tag == "html"
            assert "".join(root.itertext()).strip()


@each_class
def test_links_resolve(name):
    roots = [etree.fromstring(text) for text in html(CLASSES[name], "info")]
    for link in (link for root in roots for link in root.xpath("//a/@href | //img/@src")):
        scheme, _, target = link.partition("://")
        assert scheme in ("modelica", "https")
        if scheme == "modelica":
            path = LIBRARY.parent / target
            assert path.is_file() if "/" in target else target in CLASSES, link


@each_example
def test_a_picture_fits_into_the_pane_that_shows_the_text(name):
    roots = [etree.fromstring(text) for text in html(CLASSES[name], "info")]
    widths = [width for root in roots for width in root.xpath("//img/@width")]
    assert widths == ["640"]


@pytest.mark.parametrize("directory", [f.parent for f in FILES if f.name == "package.mo"], ids=str)
def test_package_order_agrees_with_the_files(directory):
    listed = (directory / "package.order").read_text(encoding="utf-8").split("\n")
    present = [f.stem for f in directory.glob("*.mo") if f.name != "package.mo"]
    present += [d.name for d in directory.iterdir() if d.is_dir() and d.name != "Resources"]
    assert listed.pop() == "", "the last line ends without a newline"
    assert len(listed) == len(set(listed))
    assert sorted(listed) == sorted(present)


def test_every_directory_is_a_package():
    directories = {f.parent for f in FILES}
    assert all((d / "package.mo").is_file() for d in directories)


def test_the_library_names_its_version_and_what_it_uses():
    text = (LIBRARY / "package.mo").read_text(encoding="utf-8")
    project = tomllib.loads((LIBRARY.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
    assert f'version="{LIBRARY_VERSION}"' in text
    assert project["project"]["version"] == LIBRARY_VERSION
    assert 'uses(Modelica(version="4.0.0"))' in text
    assert (
        f"<h4>Version {LIBRARY_VERSION}</h4>"
        in html(CLASSES["IT2Hysteresis.UsersGuide.ReleaseNotes"], "info")[0]
    )


def test_the_release_notes_say_what_the_changelog_says():
    """Every component, example and command of the changelog's section that is a class is there."""
    changelog = (LIBRARY.parents[1] / "CHANGELOG.md").read_text(encoding="utf-8")
    section = changelog.split("### The Modelica library\n")[1].split("\n### ")[0]
    known = {name.rsplit(".", 1)[-1]: name for name in CLASSES}
    named = {n for n in re.findall(r"`(\w+)`", section) if n in known}
    assert {"ChargeAmplifier", "FlexureGuide", "PositionSensor"} <= named
    links = etree.fromstring(html(CLASSES["IT2Hysteresis.UsersGuide.ReleaseNotes"], "info")[0])
    linked = {href.rsplit(".", 1)[-1] for href in links.xpath("//a/@href")}
    assert named - {"Stage"} <= linked


def test_the_library_says_when_it_was_made_and_opens_with_its_text():
    text = without_texts((LIBRARY / "package.mo").read_text(encoding="utf-8"))
    top = inside(text, "annotation (")
    assert all(f'{name}=""' in top for name in ("preferredView", "versionDate", "dateModified"))


@each_class
def test_no_vendor_extension_and_no_absolute_path(name):
    text = CLASSES[name].read_text(encoding="utf-8")
    assert not re.search(r"__\w+", text)
    assert not re.search(r'"(/\w|[A-Za-z]:[\\/]|file:)', text)


@each_class
def test_what_a_class_says_begins_with_the_name_of_the_block(name):
    """Three blocks of a kind in one model would say the same. A function is told the name."""
    text = CLASSES[name].read_text(encoding="utf-8")
    said = re.findall(r"\bassert\((.*?)\);\n", text, re.DOTALL)
    own = r"\bname\s*\+" if kind(name) == "function" else r"getInstanceName\(\)\s*\+"
    assert all(re.match(rf"[^\"]*?,\s*{own}", call) for call in said)


@each_example
def test_an_example_says_how_to_run_and_plot_it(name):
    text = CLASSES[name].read_text(encoding="utf-8")
    assert kind(name) == "model"
    assert "extends Modelica.Icons.Example;" in text
    assert re.search(r"experiment\(StopTime=[\d.]+, Interval=[\d.e-]+, Tolerance=1e-6\)", text)
    assert "preferred=true" in text
    assert "/Resources/Images/Examples/" in text


def without_texts(text: str) -> str:
    """Return Modelica text with empty strings and no comments."""
    return re.sub(r"//[^\n]*", "", re.sub(r'"(?:[^"\\]|\\.)*"', '""', text))


def inside(text: str, opening: str) -> str:
    """Return what stands between an opening, which ends with a parenthesis, and its closing."""
    start = text.index(opening) + len(opening)
    depth = 1
    for end in range(start, len(text)):
        depth += {"(": 1, ")": -1}.get(text[end], 0)
        if depth == 0:
            return text[start:end]
    raise AssertionError(f"{opening} is not closed")


@each_example
def test_figures_are_a_part_of_the_documentation(name):
    """Elsewhere no tool finds them (section 18.3 of the language's specification)."""
    text = without_texts(CLASSES[name].read_text(encoding="utf-8"))
    assert text.count("figures=") == 1
    assert "figures={" in inside(text, "Documentation(")


DECLARATION = re.compile(
    r"^  parameter (?P<type>Real|Integer|Modelica\.Units\.\S+) \w+(?:\[[\w:]+\])?\s*"
    r"(?P<attributes>\(.*?\))?=",
    re.MULTILINE | re.DOTALL,
)


@each_class
def test_numeric_parameters_have_bounds_and_units(name):
    text = CLASSES[name].read_text(encoding="utf-8")
    if name in EXAMPLES:
        return  # their parameters are records
    found = list(DECLARATION.finditer(text))
    assert found or ".Components." not in name
    for declared in found:
        attributes = declared["attributes"] or ""
        assert "min=" in attributes and "max=" in attributes, declared[0]
        assert declared["type"] != "Real" or "unit=" in attributes, declared[0]


@pytest.mark.parametrize(
    "name", ["IT2Hysteresis", *(f"IT2Hysteresis.{p}" for p in ("Blocks", "Components"))]
)
def test_a_package_that_is_dragged_from_has_an_icon_of_its_own(name):
    text = without_texts(CLASSES[name].read_text(encoding="utf-8"))
    assert re.search(r"Line\(|Rectangle\(", inside(text, "Icon("))


@pytest.mark.parametrize("block", ["Plant", "Inverse"])
def test_icons_tell_fmu_from_pure_blocks(block):
    drawn = [
        CLASSES[f"IT2Hysteresis.{place}.{block}"].read_text(encoding="utf-8")
        for place in ("Blocks", "Blocks.PureModelica")
    ]
    labels = [re.findall(r'textString="([^"%]+)"', text) for text in drawn]
    assert labels == [["FMU"], ["pure"]]


def test_every_resource_is_used():
    texts = "".join(f.read_text(encoding="utf-8") for f in FILES)
    images = (LIBRARY / "Resources" / "Images").rglob("*.*")
    assert all(f"modelica://IT2Hysteresis/{i.relative_to(LIBRARY).as_posix()}" in texts for i in images)
    signals = REFERENCE.rglob("*.txt")
    assert sorted(".".join(s.parent.relative_to(REFERENCE).parts) for s in signals) == sorted(EXAMPLES)
    assert sorted(REFERENCE.rglob("*.csv")) == sorted(map(stored_path, EXAMPLES))


EXTENT = r"\{\{(-?\d+),(-?\d+)\},\{(-?\d+),(-?\d+)\}\}"
COMPONENTS = [n for n in CLASSES if ".Components." in n and kind(n) != "package"]


def corners(found: tuple[str, ...]) -> tuple[int, int, int, int]:
    """Return the least and greatest x and y of an extent."""
    x1, y1, x2, y2 = map(int, found)
    return min(x1, x2), max(x1, x2), min(y1, y2), max(y1, y2)


@pytest.mark.parametrize("name", COMPONENTS)
def test_a_components_icon_shows_its_name_and_a_value(name):
    """A parameter of it, by name: of several in a diagram one sees which is which."""
    text = CLASSES[name].read_text(encoding="utf-8")
    shown = re.findall(r"%(\w+)", " ".join(re.findall(r'textString="([^"]*)"', text)))
    assert "name" in shown
    values = set(shown) - {"name"}
    assert values
    assert all(re.search(rf"\bparameter [\w.]+ {value}\b", text) for value in values)


@pytest.mark.parametrize("name", COMPONENTS)
def test_no_text_of_an_icon_lies_on_a_connector_or_between_two_of_a_side(name):
    text = CLASSES[name].read_text(encoding="utf-8")
    placed = [
        corners(m.groups())
        for m in re.finditer(rf"Placement\(transformation\(\s*extent={EXTENT}\)\)", text)
    ]
    texts = [corners(m.groups()) for m in re.finditer(rf"Text\(\s*extent={EXTENT}", text)]
    assert texts and (placed or "PartialElementary" in text)
    for left, right, bottom, top in texts:
        for x1, x2, y1, y2 in placed:
            assert x2 <= left or x1 >= right or y2 <= bottom or y1 >= top
        # the pins of the top edge: a name between them would be crossed by their wires
        pins = [x1 for x1, _, y1, y2 in placed if y1 < 100 <= y2]
        assert len(pins) < 2 or top < 90 or right < min(pins) or left > max(pins)
