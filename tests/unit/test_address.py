"""The project's public address: none is invented, and one that is known stands the same everywhere."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
PLACES = (
    "README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "docs/**/*.md",
    "docs/conf.py",
    "modelica/**/*.mo",
)


def known_address():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return project.get("urls", {}).get("Repository")


def test_the_citation_has_the_address_of_the_package():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    found = re.findall(r"^(?:repository-code|url): *\"?([^\"\n]+)", citation, re.MULTILINE)
    assert set(found) <= {known_address()} and bool(found) == bool(known_address())


def test_no_page_has_another_address_of_the_project():
    for path in (p for place in PLACES for p in ROOT.glob(place)):
        found = re.findall(
            r"https?://[^\s)>\"`]*it2hys[^\s)>\"`]*", path.read_text(encoding="utf-8"), re.I
        )
        assert all(known_address() and a.startswith(known_address()) for a in found), path
