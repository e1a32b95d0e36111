"""The C sources of `fmu_src` as two files, `it2hys.h` and `it2hys.c`.

They are what others compile: an FMU's `sources/`, the C header package and the Modelica library. Each
has the parts that it needs; the text of a part is the same everywhere. Files that make an FMU of a
model (`fmu_src/models/IT2Plant.c`) go beside them, with FMI's functions in them.

Only the standard library is used, because the C build runs this in an environment without packages:
``python -m it2hys.fmu.amalgamation FMU_SRC GENERATED`` writes the folders `sources`, `controller` and
`embedded` beside the headers that `it2hys.fmu.codegen` has generated.
"""

import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

HEADER, SOURCE = "it2hys.h", "it2hys.c"
FOLDERS = ("core", "fmi", "models")
#: What finds another parameter set than the one compiled in; the Modelica library has none.
RESOURCES = ("fmu_parameters.c", "fmu_location.c")
LAYER = (
    "fmu_lifecycle.c",
    "fmu_variables.c",
    "fmu_step.c",
    "fmu_update.c",
    "fmu_derivative.c",
    "fmu_adjoint.c",
    "fmu_arrays.c",
    "fmu_state.c",
    "fmu_log.c",
)
#: Identification only.
LEFT_OUT = ("it2_free_run.c",)
#: A parameter set, which every packaged FMU has its own of.
SEPARATE = ("fmu_start.h",)

_INCLUDE = re.compile(r'^#include "([^"]+)"$')
_SYSTEM = re.compile(r"^#include <[^>]+>$")
_GNU = re.compile(r"^#if !defined _WIN32 && !defined _GNU_SOURCE\n.*\n#endif\n", re.MULTILINE)
_TITLE = "/* {}: generated from fmu_src by python -m it2hys.fmu.amalgamation. */\n"


@dataclass
class Amalgamation:
    """Files of a source tree, each taken in once, where it is first included.

    Parameters
    ----------
    places : dict of str to Path
        Where the files are, by their names, which differ.
    taken : set of str
        Files that are in already.
    system : set of str
        Lines that include headers of the system, for the beginning.
    """

    places: dict[str, Path]
    taken: set[str] = field(default_factory=set)
    system: set[str] = field(default_factory=set)

    def take(self, name: str) -> str:
        """Return a file's text with the files that it includes; empty if it is in already."""
        if name in self.taken:
            return ""
        self.taken.add(name)
        text = _GNU.sub("", self.places[name].read_text(encoding="utf-8"))
        lines, depth = [], 0
        for line in (_without_guard(text) if name.endswith(".h") else text).splitlines(keepends=True):
            depth += line.startswith("#if") - line.startswith("#endif")
            included = _INCLUDE.match(line.rstrip())
            if depth == 0 and _SYSTEM.match(line.rstrip()):
                self.system.add(line)
            elif included and included[1] in self.places and included[1] not in SEPARATE:
                lines.append(self.take(included[1]))
            else:
                lines.append(line)
        body = re.sub(r"\n{3,}", "\n\n", "".join(lines)).strip("\n")
        return f"\n/* --- {name} --- */\n\n{body}\n"

    def beginning(self) -> str:
        """Return the lines that include the system's headers."""
        return "".join(sorted(self.system)) + "\n"


def _without_guard(text: str) -> str:
    """Return a header without the lines that keep it from being included twice."""
    return re.sub(
        r"^#ifndef (IT2HYS_\w+)\n#define \1\n(.*)^#endif\n$",
        r"\2",
        text,
        flags=re.MULTILINE | re.DOTALL,
    )


def source_places(source: Path, generated: Path) -> dict[str, Path]:
    """Return the files of `fmu_src` and the generated headers by their names."""
    folders = [*(source / name for name in FOLDERS), generated]
    return {path.name: path for folder in folders for path in sorted(folder.glob("*.[ch]"))}


def amalgamate(places: dict[str, Path], header: str, sources: Iterable[str]) -> dict[str, str]:
    """Return `it2hys.h`, with what `header` includes, and `it2hys.c` by their names."""
    files = Amalgamation(places)
    declarations = files.take(header)
    first = files.beginning()
    files.system = set()
    parts = []
    for name in sources:
        part = files.take(name)
        if name in RESOURCES:
            part = f"\n#if !defined IT2HYS_NO_RESOURCES\n{part}\n#endif\n"
        parts.append(part)
    gnu = "#if !defined _WIN32 && !defined _GNU_SOURCE\n#define _GNU_SOURCE /* dladdr */\n#endif\n"
    guard = "#ifndef IT2HYS_H\n#define IT2HYS_H\n\n"
    return {
        HEADER: f"{_TITLE.format(HEADER)}{guard}{first}{declarations}\n#endif\n",
        SOURCE: "".join(
            [
                _TITLE.format(SOURCE),
                gnu if "fmu_location.c" in files.taken else "",
                f'#include "{HEADER}"\n\n',
                files.beginning(),
                *parts,
            ]
        ),
    }


def face(places: dict[str, Path], name: str, header: str) -> str:
    """Return a file that makes an FMU of a model, for beside `it2hys.h`, which holds `header`."""
    files = Amalgamation(places)
    files.take(header)
    files.system = set()
    text = files.take(name)
    return f'{_TITLE.format(name)}#include "{HEADER}"\n\n{files.beginning()}{text}'


def faces(*identifiers: str) -> list[str]:
    """Return the files that make FMUs of models: for FMI 2.0 and for FMI 3.0."""
    return [f"{identifier}{version}.c" for identifier in identifiers for version in ("", "_fmi3")]


def folders(source: Path, generated: Path) -> dict[str, dict[str, str]]:
    """Return the files of each folder by their names."""
    places = source_places(source, generated)
    core = [path.name for path in sorted((source / "core").glob("*.c")) if path.name not in LEFT_OUT]
    chain = [*core, *LAYER, *RESOURCES, "actuator.c", "plant.c", "inverse.c"]
    return {
        "sources": {
            **amalgamate(places, "actuator.h", chain),
            **{name: face(places, name, "actuator.h") for name in faces("IT2Plant", "IT2Inverse")},
        },
        "controller": {
            **amalgamate(places, "controller.h", [*LAYER, "controller.c"]),
            **{name: face(places, name, "controller.h") for name in faces("PIController")},
        },
        "embedded": amalgamate(places, "chain.h", core),
    }


def write_folders(source: Path, generated: Path) -> None:
    """Write the folders into the one of the generated headers."""
    for folder, files in folders(source, generated).items():
        (generated / folder).mkdir(parents=True, exist_ok=True)
        for old in (generated / folder).iterdir():  # a build folder outlives the names in it
            if old.name not in files:
                old.unlink()
        for name, text in files.items():
            (generated / folder / name).write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    write_folders(Path(sys.argv[1]), Path(sys.argv[2]))
