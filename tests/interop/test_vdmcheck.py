"""VDMCheck2, a checker that we did not write, on our FMUs: its static and its rule model."""

import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

JARS = {
    "vdmj": "4.5.0",
    "annotations": "4.5.0",
    "xsd2vdm": "1.1.3",
    "fmuReader": "1.1.3",
    "vdmcheck2": "1.1.3",
    "static-model": "1.1.3",
    "rule-model": "1.1.3",
}


@pytest.fixture(scope="session")
def vdmcheck(tmp_path_factory):
    """Return a function that runs one of VDMCheck2's models and returns exit code and output."""
    root = Path(__file__).parents[2]
    jars = Path(os.environ.get("VDMCHECK_JARS", root / "build" / "vdmcheck"))
    java = shutil.which("java")
    if java is None:
        pytest.skip("VDMCheck2 needs java")
    missing = [f"{n}-{v}.jar" for n, v in JARS.items() if not (jars / f"{n}-{v}.jar").is_file()]
    if missing:
        pytest.skip(
            f"VDMCheck2 is not in {jars}: {', '.join(missing)} missing; `make build/vdmcheck/.fetched`"
        )
    home = tmp_path_factory.mktemp("vdmcheck")  # it wants its parts beside it, unpacked, so named
    for name, version in JARS.items():
        jar = jars / f"{name}-{version}.jar"
        shutil.copy(jar, home / f"{name}.jar")
        with zipfile.ZipFile(jar) as archive:
            archive.extractall(home, [n for n in archive.namelist() if n.startswith("fmi2")])

    def run(check: str, path: Path) -> tuple[int, str]:
        done = subprocess.run(
            [java, "-cp", "vdmcheck2.jar", check, str(path)],
            cwd=home,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=120,
            check=False,
        )
        return done.returncode, done.stdout

    return run


VDM_MODELS = {"static": "VDMCheck", "rule": "VDMCheckPlus"}


@pytest.mark.parametrize("which", ["plant", "inverse", "controller"])
@pytest.mark.parametrize("check", VDM_MODELS)
def test_vdmcheck_finds_nothing(vdmcheck, models, controller, check, which):
    code, out = vdmcheck(VDM_MODELS[check], {**models, "controller": controller}[which].path)
    assert "No errors found." in out
    assert code == 0, out


@pytest.mark.parametrize("check", VDM_MODELS)
def test_vdmcheck_does_find_a_fault(vdmcheck, models, tmp_path, check):
    """A guard for the test above: a parameter that varies continuously."""
    text = (models["plant"].directory / "modelDescription.xml").read_text(encoding="utf-8")
    path = tmp_path / "modelDescription.xml"
    path.write_text(text.replace('variability="fixed"', 'variability="continuous"'), "utf-8")
    assert path.read_text(encoding="utf-8") != text
    code, out = vdmcheck(VDM_MODELS[check], path)
    assert code != 0
    assert "No errors found." not in out
