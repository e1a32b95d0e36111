"""PEP 517 backend: scikit-build-core; zig compiles wheels that travel, and where nothing else does."""

import os
import platform
import shutil
import sys
from pathlib import Path

from scikit_build_core.build import *  # noqa: F403
from scikit_build_core.build import build_editable as _build_editable
from scikit_build_core.build import build_wheel as _build_wheel
from scikit_build_core.build import prepare_metadata_for_build_wheel as _prepare_wheel

#: Oldest C library of GNU that a wheel for Linux runs with: that of RHEL 7, as "manylinux2014".
GLIBC = "2.17"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Build with zig's compiler against an old C library, so that the wheel runs on all newer ones.

    With a compiler of the user's own choice, in `CC`, the wheel is for systems like this one alone.
    """
    settings = _wheel_settings(config_settings)
    if _travels():
        _choose_zig("-target", f"{platform.machine()}-linux-gnu.{GLIBC}")
    else:
        _choose_compiler()
    return _build_wheel(wheel_directory, settings, metadata_directory)


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Return the metadata of the same wheel."""
    return _prepare_wheel(metadata_directory, _wheel_settings(config_settings))


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """Build with the host's compiler or, where there is none, with zig's."""
    _choose_compiler()
    return _build_editable(wheel_directory, config_settings, metadata_directory)


def _travels():
    """Tell whether a wheel is for more systems than this one: not with a compiler of the user's own."""
    return sys.platform == "linux" and platform.libc_ver()[0] == "glibc" and "CC" not in os.environ


def _wheel_settings(given):
    """Return the settings of a build, with the tag of a wheel that travels."""
    name = f"manylinux_{GLIBC.replace('.', '_')}_{platform.machine()}"
    own = {"wheel.tags": [f"py3-none-{name}"]} if _travels() else {}
    return own | dict(given or {})


def _choose_compiler():
    if "CC" not in os.environ and not any(shutil.which(name) for name in ("cc", "gcc", "clang")):
        _choose_zig()


def _choose_zig(*flags):
    import ziglang

    # quoted, because CMake splits it at spaces; for any processor, because a wheel travels
    zig = Path(ziglang.__file__).parent / "zig"
    os.environ["CC"] = " ".join([f'"{zig}"', "cc", "-mcpu=baseline", *flags])
