"""Compilers for the tests: the host's, or zig's from PyPI where there is none."""

import importlib.util
import os
import re
import shutil
import sys
from pathlib import Path

import fmpy
import pytest

HEADERS = Path(fmpy.__file__).parent / "c-code"


def compiler(language: str = "c") -> list[str]:
    """Return the command of a compiler for C (``c``) or C++ (``c++``); skips where there is none."""
    names = ("cc", "gcc", "clang") if language == "c" else ("c++", "g++", "clang++")
    for name in names:
        if found := shutil.which(name):
            return [found]
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("no compiler: neither the host's nor PyPI's ziglang")
    # for any processor: with fused multiplications the last bits would be others
    return [sys.executable, "-m", "ziglang", "cc" if language == "c" else "c++", "-mcpu=baseline"]


def environment_for_cmake() -> dict[str, str]:
    """Return an environment in which CMake finds itself, ninja and compilers."""
    return {
        **os.environ,
        "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]),
        "CC": " ".join(compiler()),
        "CXX": " ".join(compiler("c++")),
        "CMAKE_GENERATOR": "Ninja",
    }


def declared_functions_of_fmi3() -> set[str]:
    """Return the functions of FMI 3.0, all of which a library has, whatever its interface."""
    header = (HEADERS / "fmi3Functions.h").read_text(encoding="utf-8")
    found = set(re.findall(r"FMI3_Export fmi3\w+TYPE\s+(fmi3\w+);", header))
    assert len(found) > 70
    return found


def declared_functions() -> set[str]:
    """Return the functions of FMI 2.0 for co-simulation, from the standard's own header."""
    header = (HEADERS / "fmi2Functions.h").read_text(encoding="utf-8")
    rest, co_simulation = header.rsplit("Functions for FMI2 for Co-Simulation", 1)
    common, _ = rest.rsplit("Functions for FMI2 for Model Exchange", 1)
    return set(re.findall(r"FMI2_Export fmi2\w+TYPE\s+(fmi2\w+);", common + co_simulation))
