"""Packaging a parameter set as FMUs: `IT2Plant.fmu` and `IT2Inverse.fmu`.

The binaries are the same for every parameter set. What differs is modelDescription.xml, the set in
`resources/` and the one compiled into `sources/`, which the GUID ties together.
"""

import zipfile
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path

from it2hys.fmu.build_description import format_build_description
from it2hys.fmu.codegen import start_header
from it2hys.fmu.documentation import Origin, documentation_files
from it2hys.fmu.model_description import IDENTIFIERS, format_model_description
from it2hys.fmu.reference_run import reference_files
from it2hys.fmu.terminals import picture_files
from it2hys.model.compiled import native_directory
from it2hys.model.parameters import ParameterSet, format_ssv
from it2hys.support.files import write_together
from it2hys.support.version import package_version

# zip entries carry a time; a fixed one makes the same input give the same file
EPOCH = (1980, 1, 1, 0, 0, 0)
PARAMETER_FILE = "parameters.ssv"
BUILD_DESCRIPTION = "sources/buildDescription.xml"
# beside the C library: libm for hum, lag, creep and resonance, libdl to find the FMU's resources
LIBRARIES = ("m", "dl")


def package(
    parameters: ParameterSet, directory: str | Path, origin: Origin | None = None
) -> list[Path]:
    """Write both FMUs and the parameter set into a directory.

    Parameters
    ----------
    parameters : ParameterSet
        A validated set.
    directory : path
        Created if it does not exist. All files get there, or none of them.
    origin : Origin, optional
        What the set was identified from, for the FMUs' documentation.

    Returns
    -------
    list of Path
        The files written: `IT2Plant.fmu`, `IT2Inverse.fmu` and `parameters.ssv`.

    Raises
    ------
    InputError
        If the directory cannot be written to.
    """
    fmus = package_bytes(parameters, origin)
    contents = {f"{identifier}.fmu": fmu for identifier, fmu in fmus.items()}
    contents[PARAMETER_FILE] = format_ssv(parameters).encode()
    return write_together(directory, contents)


def package_bytes(parameters: ParameterSet, origin: Origin | None = None) -> dict[str, bytes]:
    """Return both FMUs with a parameter set, by model identifier."""
    native = native_directory()
    return {
        identifier: _fmu(model, identifier, parameters, native, origin)
        for model, identifier in IDENTIFIERS.items()
    }


def _fmu(
    model: str, identifier: str, parameters: ParameterSet, native: Path, origin: Origin | None
) -> bytes:
    """Return the FMU as a zip archive."""
    sources = _sources(identifier, parameters, native)
    c_files = sorted(name for name in sources if name.endswith(".c"))
    description = format_model_description(model, parameters, c_files, package_version())
    entries = {
        "modelDescription.xml": description,
        f"resources/{PARAMETER_FILE}": format_ssv(parameters).encode(),
        **{f"sources/{name}": content for name, content in sources.items()},
        BUILD_DESCRIPTION: format_build_description(identifier, c_files, LIBRARIES),
        **platform_binaries(identifier, native),
        **documentation_files(model, parameters, (native / "LICENSE").read_bytes(), origin),
        **picture_files(model, parameters),
        **reference_files(model, parameters),
    }
    return fmu_archive(entries)


def fmu_archive(entries: Mapping[str, bytes]) -> bytes:
    """Return files by path as a zip archive; the same files give the same bytes."""
    archive = BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in entries.items():
            info = zipfile.ZipInfo(name, EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            file.writestr(info, content)
    return archive.getvalue()


def _sources(identifier: str, parameters: ParameterSet, native: Path) -> dict[str, bytes]:
    """Return the C files of one FMU: those of the other are left out, its set is compiled in."""
    others = {f"{name}.c" for name in IDENTIFIERS.values() if name != identifier}
    found = sorted((native / "sources").glob("*.[ch]"))
    sources = {path.name: path.read_bytes() for path in found if path.name not in others}
    start = start_header(parameters, format_ssv(parameters))
    return {**sources, "fmu_start.h": start.encode()}


def platform_binaries(identifier: str, native: Path) -> dict[str, bytes]:
    """Return the built binaries of an FMU by their path in it."""
    found = sorted((native / "binaries").glob(f"*/{identifier}.*"))
    return {f"binaries/{p.parent.name}/{p.name}": p.read_bytes() for p in found}
