"""The library in OpenModelica, where there is one: see omc_acceptance."""

import re
import sys

import omc_acceptance
import pytest
from library import CLASSES
from omc_acceptance import OMC, PARTS_OF_ACCEPTANCE, VERSIONS, MissingError, Session, check_classes


@pytest.mark.slow
@pytest.mark.skipif(not OMC, reason="no omc, OpenModelica's compiler, on the path")
@pytest.mark.parametrize("msl", VERSIONS)
@pytest.mark.parametrize("part", PARTS_OF_ACCEPTANCE)
def test_openmodelica_finds_nothing(msl, part, tmp_path):
    try:
        found = list(PARTS_OF_ACCEPTANCE[part](Session(msl, tmp_path)))
    except MissingError as missing:
        pytest.skip(str(missing))
    assert not found, "\n".join(found)


#: As much of omc as shows what the script makes of its answers.
OMC_OF_PAPER = r"""
import re, sys
text = open(sys.argv[1], encoding="utf-8").read()
for line in text.splitlines():
    if match := re.match(r'print\\("(.*)\\\\n"\\);', line):
        print(match[1])
    elif match := re.match(r"checkModel\\((.*)\\);", line):
        print(f'"Check of {match[1]} completed successfully."')
        if match[1].endswith("Blocks.Plant"):
            print('"[f.mo:1:1-2:2:writable] Warning: units do not match"')
    elif line.startswith("getVersion"):
        print('"VERSION"')
    elif line.startswith("getErrorString"):
        print('""')
"""


def omc_of_paper(tmp_path, monkeypatch, version):
    """Put the above in the place of omc."""
    script = tmp_path / "omc"
    body = OMC_OF_PAPER.replace("VERSION", version).replace("\\\\", "\\")
    script.write_text(f"#!{sys.executable}\n{body}", encoding="utf-8")
    script.chmod(0o755)
    monkeypatch.setattr(omc_acceptance, "OMC", str(script))


def test_a_warning_of_the_unit_check_is_a_finding(tmp_path, monkeypatch):
    omc_of_paper(tmp_path, monkeypatch, "4.0.0")
    found = list(check_classes(Session("4.0.0", tmp_path / "work")))
    named = [re.match(r"checkModel\((.*?)\)", finding)[1] for finding in found]
    assert named == [name for name in CLASSES if name.endswith("Blocks.Plant")]
    assert "units do not match" in found[0]


def test_a_standard_library_that_is_not_there_is_said(tmp_path, monkeypatch):
    omc_of_paper(tmp_path, monkeypatch, "")
    with pytest.raises(MissingError, match=re.escape("Standard Library 4.1.0 is not installed")):
        list(check_classes(Session("4.1.0", tmp_path / "work")))
