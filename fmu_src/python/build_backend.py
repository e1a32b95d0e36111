"""PEP 517 backend: scikit-build-core, with zig's compiler where the host has none."""

import os
import shutil
from pathlib import Path

from scikit_build_core.build import *  # noqa: F403
from scikit_build_core.build import build_editable as _build_editable
from scikit_build_core.build import build_wheel as _build_wheel


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Build with the host's compiler or, where there is none, with zig's."""
    _choose_compiler()
    return _build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """Do the same for an editable installation."""
    _choose_compiler()
    return _build_editable(wheel_directory, config_settings, metadata_directory)


def _choose_compiler():
    if "CC" in os.environ or any(shutil.which(name) for name in ("cc", "gcc", "clang")):
        return
    import ziglang

    # quoted, because CMake splits it at spaces; for any processor, because a wheel travels
    os.environ["CC"] = f'"{Path(ziglang.__file__).parent / "zig"}" cc -mcpu=baseline'
