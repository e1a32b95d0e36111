"""Where scenarios are: of experiments (`scenario`) and of sweeps (`sweeps`)."""

from importlib.resources import files
from pathlib import Path

from it2hys.errors import InputError


def find_scenario(name: str) -> Path:
    """Return the file of a scenario: a path, or a name in ./scenarios or among those installed.

    Raises
    ------
    InputError
        If there is none; lists the names that there are.
    """
    if name.endswith(".toml"):
        return Path(name)
    folders = [Path("scenarios"), Path(str(files("it2hys") / "scenarios"))]
    for folder in folders:
        if (folder / f"{name}.toml").is_file():
            return folder / f"{name}.toml"
    known = sorted({path.stem for folder in folders for path in folder.glob("*.toml")})
    raise InputError(f"no scenario {name!r}; there are: {', '.join(known) or 'none'}")
