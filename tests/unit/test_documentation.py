"""The site's pages: commands exist, code is run when the site is built, links lead somewhere."""

import importlib.util
import re
import shlex
from pathlib import Path

import pytest

from it2hys.cli import make_parser
from it2hys.model.variables import load_table

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(p for p in DOCS.rglob("*.md") if "_generated" not in p.parts)
TEXTS = [*PAGES, ROOT / "README.md", ROOT / "scenarios" / "README.md"]
#: Of the house, not of the site's own: their code is shown, not run.
HOUSE = {"architecture.md", "policy.md"}


def name(path):
    return path.relative_to(ROOT).as_posix()


@pytest.fixture(scope="module")
def generated():
    place = importlib.util.spec_from_file_location("generated", DOCS / "_ext" / "generated.py")
    module = importlib.util.module_from_spec(place)
    place.loader.exec_module(module)
    return module


def fences(path, language):
    text = path.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_code_of_a_page_is_run_when_the_site_is_built(page):
    if page.name in HOUSE:
        return
    for language in ("sh", "bash", "python", "pycon"):
        assert fences(page, language) == [], "use ```{run}"


@pytest.mark.parametrize("page", TEXTS, ids=name)
def test_commands_are_ones_that_there_are(page):
    """Those in blocks: of the parser's words, none is misspelled."""
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"^```.*?\n(.*?)^```|((?:^    .*\n)+)", text, re.DOTALL | re.MULTILINE)
    code = "\n".join(fenced or indented for fenced, indented in blocks)
    for line in re.findall(r"^ *(?:\.venv/bin/)?it2hys ([a-z].*)$", code, re.MULTILINE):
        typed = re.split(r"  +| #|&&", line)[0]
        if "[" in typed or "..." in typed:  # a synopsis
            parser = make_parser()._subparsers._group_actions[0].choices[typed.split()[0]]
            assert set(re.findall(r"--[a-z-]+", typed)) <= set(parser._option_string_actions), line
            continue
        typed = re.split(r"[|>]", typed)[0]
        try:
            make_parser().parse_args(shlex.split(typed))
        except SystemExit as end:
            assert end.code == 0, line


@pytest.mark.parametrize("page", TEXTS, ids=name)
def test_links_to_files_lead_somewhere(page):
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", text):
        if "://" not in target:
            assert (page.parent / target).exists(), target
    for target in re.findall(r"```{include} (\S+)", text):
        if "_generated" not in target:
            assert (page.parent / target).exists(), target


def test_every_page_is_in_the_table_of_contents():
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```{toctree}\n(.*?)```", index, re.DOTALL)
    listed = {line for block in blocks for line in block.split()}
    for page in PAGES:
        place = page.relative_to(DOCS).with_suffix("").as_posix()
        assert place == "index" or place in listed, place


def test_the_reference_has_every_command_option_and_name(generated):
    text = generated.commands()
    commands = make_parser()._subparsers._group_actions[0].choices
    for command, parser in commands.items():
        part = text[text.index(f"## it2hys {command}\n") :]
        for action in parser._actions[1:]:
            for option in action.option_strings:
                assert option in part
    names = generated.names()
    for word in ("loop_map", "creep", "multisine"):
        assert f"| {word} |" in names


def test_the_reference_has_every_variable(generated):
    text = generated.variables()
    for variable in load_table().variables:
        if variable.index in (None, 1):
            assert f"`{variable.name}`" in text
    assert "`rule[2]" not in text


def test_capabilities_and_platforms_are_read_from_the_fmus(generated):
    text = generated.fmus()
    assert "| `canGetAndSetFMUstate` | yes | yes |" in text
    assert "binaries/linux64" in text


def test_what_weighs_is_measured(generated):
    rows = dict(re.findall(r"\| `?([\w-]+)`? \| (\d+) \|", generated.weights()))
    assert int(rows["casadi"]) > 50
    assert int(rows["all"]) >= sum(int(size) for package, size in rows.items() if package != "all")


def test_the_readme_works_where_only_itself_is_shown():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert not re.findall(r"!\[.*?\]\((?!https://)", text)
