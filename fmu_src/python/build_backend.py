"""PEP 517 backend: scikit-build-core; zig compiles wheels that travel, and where nothing else does."""

import os
import platform
import shutil
import sys
from pathlib import Path

from scikit_build_core.build import *  # noqa: F403
from scikit_build_core.build import build_editable as _build_editable
from scikit_build_core.build import build_wheel as _build_wheel

#: Oldest C library of GNU that a wheel for Linux runs with: that of RHEL 7, as "manylinux2014".
GLIBC = "2.17"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Build with zig's compiler against an old C library, so that the wheel runs on all newer ones.

    With a compiler of the user's own choice, in `CC`, the wheel is for systems like this one alone.
    """
    settings = dict(config_settings or {})
    if _is_gnu_linux() and "CC" not in os.environ:
        _choose_zig("-target", f"{platform.machine()}-linux-gnu.{GLIBC}")
        name = f"manylinux_{GLIBC.replace('.', '_')}_{platform.machine()}"
        settings.setdefault("wheel.tags", [f"py3-none-{name}"])
    else:
        _choose_compiler()
    return _build_wheel(wheel_directory, settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """Build with the host's compiler or, where there is none, with zig's."""
    _choose_compiler()
    return _build_editable(wheel_directory, config_settings, metadata_directory)


def _is_gnu_linux():
    return sys.platform == "linux" and platform.libc_ver()[0] == "glibc"


def _choose_compiler():
    if "CC" not in os.environ and not any(shutil.which(name) for name in ("cc", "gcc", "clang")):
        _choose_zig()


def _choose_zig(*flags):
    import ziglang

    # quoted, because CMake splits it at spaces; for any processor, because a wheel travels
    zig = Path(ziglang.__file__).parent / "zig"
    os.environ["CC"] = " ".join([f'"{zig}"', "cc", "-mcpu=baseline", *flags])
