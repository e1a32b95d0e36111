"""The version of the package."""

from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed_version


def package_version() -> str:
    """Return the version of the installed package; of the source tree where it runs from there."""
    try:
        return installed_version("it2hys")
    except PackageNotFoundError:
        return "0.1.0"
