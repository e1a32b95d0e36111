"""Fixtures of the tests of the installation: fresh environments, an sdist, a wheel of it."""

import os
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
NOT_TRACKED = (
    ".git", ".venv", "build", "dist", "out", "__pycache__", ".*_cache", ".hypothesis", "native",
)  # fmt: skip


class Environment:
    """A virtual environment with the newest pip."""

    def __init__(self, folder):
        venv.create(folder, with_pip=True)
        self.folder = folder
        (folder / "tmp").mkdir()
        self.install("--upgrade", "pip")

    def run(self, *command, cwd=None, path=None):
        """Run a program of the environment; return what it prints."""
        variables = {
            n: v for n, v in os.environ.items() if n not in ("CC", "PYTHONPATH", "VIRTUAL_ENV")
        }
        variables["TMPDIR"] = str(self.folder / "tmp")  # where pip makes its isolated environments
        variables["PATH"] = os.environ["PATH"] if path is None else str(path)
        program, *arguments = map(str, command)
        done = subprocess.run(
            [self.folder / "bin" / program, *arguments],
            cwd=cwd or self.folder,
            env=variables,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def pip(self, *arguments, **options):
        return self.run("python", "-m", "pip", *arguments, **options)

    def install(self, *arguments, **options):
        """Install packages, of which what is used is compiled once it is: most is not."""
        self.pip("install", "--no-compile", *arguments, **options)


def place():
    """Return where to work: in memory, if there is room for the tens of thousands of small files."""
    memory = Path("/dev/shm")
    roomy = memory.is_dir() and shutil.disk_usage(memory).free > 4 * 2**30
    return memory if roomy else Path(tempfile.gettempdir())


@pytest.fixture(scope="session")
def folder():
    """Return a folder with a space and an umlaut in its path, which does not stay: it is large."""
    with tempfile.TemporaryDirectory(prefix="Prüf Stand ", dir=place()) as path:
        yield Path(path)


@pytest.fixture(scope="session")
def empty_path(folder):
    """Return a search path on which there is no program at all."""
    (folder / "nothing").mkdir()
    return folder / "nothing"


@pytest.fixture(scope="session")
def checkout(folder):
    """Return a copy of this repository as a clone has it."""
    ignored = shutil.ignore_patterns(*NOT_TRACKED)
    return Path(shutil.copytree(ROOT, folder / "it2hys", ignore=ignored))


@pytest.fixture(scope="session")
def fresh(folder):
    """Return the environment that builds."""
    return Environment(folder / "fresh")


@pytest.fixture(scope="session")
def user(fresh, wheel, empty_path):
    """Return the environment once the wheel is in it, with what it needs; nobody has the checkout.

    To install hundreds of megabytes takes long: that is done once. The tests of other ways to install
    come later, and take the package out of it again.
    """
    fresh.install("--constraint", ROOT / "requirements.lock", wheel, path=empty_path)
    fresh.pip("check")
    place = fresh.run("python", "-c", "import it2hys; print(it2hys.__file__)").strip()
    assert Path(place).is_relative_to(fresh.folder)
    return fresh


@pytest.fixture(scope="session")
def sdist(checkout, folder):
    """Return the sdist of the checkout."""
    command = [sys.executable, "-m", "build", "--sdist", "--no-isolation", "--outdir", folder / "dist"]
    subprocess.run(command, cwd=checkout, check=True, capture_output=True)
    [path] = (folder / "dist").glob("*.tar.gz")
    return path


@pytest.fixture(scope="session")
def wheel(sdist, folder, empty_path):
    """Return the wheel of the sdist, built where there is no compiler.

    By the tools of the tests: pip fetches its own for the checkout, which takes as long again.
    """
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation"]
    variables = {n: v for n, v in os.environ.items() if n != "CC"} | {"PATH": str(empty_path)}
    command += ["--wheel-dir", folder / "dist", sdist]
    subprocess.run(command, env=variables, check=True, capture_output=True)
    [path] = (folder / "dist").glob("*.whl")
    return path
