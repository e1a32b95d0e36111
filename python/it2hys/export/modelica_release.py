"""The Modelica library as it is handed on: a folder to load, or an archive that loads by itself.

`it2hys modelica PATH` writes it, `make modelica` makes the archive of a release. Nothing in it is built
for a platform: a Modelica tool compiles the C sources with the model.
"""

import shutil
import tempfile
import zipfile
from importlib.resources import files
from pathlib import Path

from it2hys.errors import InputError
from it2hys.export.modelica import LIBRARY_VERSION, format_record, generated_files
from it2hys.model.compiled import native_directory
from it2hys.model.parameters import table_1
from it2hys.support.files import write_atomically

NAME = "IT2Hysteresis"
TEMPLATE = "MyStage"
README = f"""IT2Hysteresis {LIBRARY_VERSION}: hysteresis of piezoelectric actuators, and its inverse.

Open {NAME}/package.mo in your Modelica tool, or put the folder {NAME} where it looks for
libraries. It needs the Modelica Standard Library 4.0.0 or 4.1.0; the blocks that hold FMUs also a C
compiler, which most tools bring. UsersGuide.Tutorial leads from drag and drop to a closed loop.

{TEMPLATE}.mo is a parameter set of your own to begin with: `it2hys package PARAMETERS.ssv --modelica
-o DIR` writes one like it for an identified actuator.
"""
#: One time for all files of an archive: the same library gives the same bytes.
EPOCH = (1980, 1, 1, 0, 0, 0)


def library_directory() -> Path:
    """Return where the library is: in the checkout, or installed with the package.

    Raises
    ------
    InputError
        If it is in neither.
    """
    checkout = Path(__file__).parents[3] / "modelica" / NAME
    for directory in (checkout, Path(str(files("it2hys"))) / "modelica" / NAME):
        if (directory / "package.mo").is_file():
            return directory
    raise InputError("the Modelica library is not installed with it2hys; install it2hys again")


def release_files() -> dict[str, bytes]:
    """Return all files of a release by path: library, record template, licence, README."""
    library = library_directory()
    found = {
        f"{NAME}/{path.relative_to(library).as_posix()}": path.read_bytes()
        for path in sorted(library.rglob("*"))
        if path.is_file()
    }
    # installed, the library lacks the two C files that the FMUs' sources are; with effects of the
    # user's own, what is generated is other than what is there
    generated = {f"{NAME}/{place}": content for place, content in generated_files().items()}
    return dict(sorted((found | generated).items())) | {
        f"{TEMPLATE}.mo": format_record(table_1(), TEMPLATE).encode(),
        "LICENSE": (native_directory() / "LICENSE").read_bytes(),
        "README.txt": README.encode(),
    }


def write_release(path: Path) -> Path:
    """Write the release into a directory, or as an archive where the path ends in .zip.

    Parameters
    ----------
    path : Path
        Directory, which is made if it is not there; it gets the folder `IT2Hysteresis` and three files.
        Or the archive.

    Returns
    -------
    Path
        What a Modelica tool opens.

    Raises
    ------
    InputError
        If the folder is there already, or the path cannot be written. Nothing is left half written.
    """
    content = release_files()
    try:
        return _write_archive(path, content) if path.suffix == ".zip" else _write_folder(path, content)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from error


def _write_archive(path: Path, content: dict[str, bytes]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile() as file:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in content.items():
                archive.writestr(zipfile.ZipInfo(name, EPOCH), data, zipfile.ZIP_DEFLATED)
        file.seek(0)
        write_atomically(path, file.read())
    return path


def _write_folder(path: Path, content: dict[str, bytes]) -> Path:
    if path.exists() and not path.is_dir():
        raise InputError(f"{path} is a file; name a directory for the library, or an archive.zip")
    if (path / NAME).exists():
        raise InputError(f"{path / NAME} is there already; remove it, or name another directory")
    path.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path) as beside:
        for name, data in content.items():
            target = Path(beside) / name
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
        shutil.move(Path(beside) / NAME, path / NAME)
        for name in content:
            if "/" not in name:
                (Path(beside) / name).replace(path / name)
    return path / NAME / "package.mo"
