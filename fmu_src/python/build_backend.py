"""PEP 517 backend: scikit-build-core, with zig's compiler where the host has none."""

import os
import shutil
import sys

from scikit_build_core.build import *  # noqa: F403
from scikit_build_core.build import build_wheel as _build_wheel


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Build with the host's compiler or, where there is none, with zig's."""
    if "CC" not in os.environ and not any(shutil.which(name) for name in ("cc", "gcc", "clang")):
        os.environ["CC"] = f"{sys.executable} -m ziglang cc"
    return _build_wheel(wheel_directory, config_settings, metadata_directory)
