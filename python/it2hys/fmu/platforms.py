"""The platforms that an FMU has binaries for, and what each version of FMI calls them.

FMI 2.0.5 names x86 processors only: its `linux64` and `darwin64` are x86-64, and tools for ARM look for
FMI 3.0's tuples, such as `aarch64-linux`, in an FMU of FMI 2.0 too. Its one name for macOS stands for a
library that holds both processors' code, because tools on either look there.
"""

from pathlib import Path

#: Folder of the build (`fmu_src/platforms`): the platform's name in FMI 2.0 and in FMI 3.0, if any.
PLATFORMS = {
    "linux64": ("linux64", "x86_64-linux"),
    "aarch64-linux": ("aarch64-linux", "aarch64-linux"),
    "win64": ("win64", "x86_64-windows"),
    "win32": ("win32", "x86-windows"),
    "aarch64-windows": ("aarch64-windows", "aarch64-windows"),
    "darwin64": ("darwin64", None),
    "x86_64-darwin": (None, "x86_64-darwin"),
    "aarch64-darwin": ("aarch64-darwin", "aarch64-darwin"),
}


def platform_binaries(identifier: str, native: Path, fmi: int) -> dict[str, bytes]:
    """Return the built binaries of an FMU by their path in it.

    Parameters
    ----------
    identifier : str
        Model identifier.
    native : path
        Folder of what was built; it has binaries for all platforms or for the host's alone.
    fmi : {2, 3}
        Version of FMI.
    """
    found = {}
    for folder, names in PLATFORMS.items():
        name = names[fmi - 2]
        for path in sorted((native / "binaries" / folder).glob(f"{identifier}.*")) if name else ():
            found[f"binaries/{name}/{path.name}"] = path.read_bytes()
    return found
