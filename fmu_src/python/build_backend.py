"""PEP 517 backend: scikit-build-core, and ziglang from PyPI where there is no C compiler."""

import os
import shutil
import sys

from scikit_build_core.build import *  # noqa: F403
from scikit_build_core.build import build_wheel as _build_wheel
from scikit_build_core.build import get_requires_for_build_wheel as _get_requires

ZIGLANG = "ziglang==0.17.0"


def _has_compiler() -> bool:
    return "CC" in os.environ or any(shutil.which(name) for name in ("cc", "gcc", "clang"))


def get_requires_for_build_wheel(config_settings=None):
    """Ask for ziglang too, where there is no other compiler."""
    return [*_get_requires(config_settings), *([] if _has_compiler() else [ZIGLANG])]


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Build with the host's compiler or, where there is none, with zig's."""
    if not _has_compiler():
        os.environ["CC"] = f"{sys.executable} -m ziglang cc"
    return _build_wheel(wheel_directory, config_settings, metadata_directory)
