"""Where scenarios are: of experiments (`scenario`) and of sweeps (`sweeps`)."""

from importlib.resources import files
from pathlib import Path

from it2hys.errors import InputError
from it2hys.support.keys import known_names

#: Folder whose scenarios take precedence over the installed ones.
_HERE = Path("scenarios")


def find_scenario(name: str) -> Path:
    """Return the file of a scenario: a path, or a name in ./scenarios or among those installed.

    Raises
    ------
    InputError
        If there is none; lists the names that there are.
    """
    if name.endswith(".toml"):
        return Path(name)
    paths = {path.stem: path for path in scenario_paths()}
    if name not in paths:
        raise InputError(f"no scenario {name!r}; {known_names(name, list(paths))}")
    return paths[name]


def scenario_paths() -> list[Path]:
    """Return the files of all scenarios that are found by name, sorted by it."""
    installed = Path(str(files("it2hys") / "scenarios"))
    paths = {path.stem: path for folder in (installed, _HERE) for path in folder.glob("*.toml")}
    return [paths[name] for name in sorted(paths)]
