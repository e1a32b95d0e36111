"""Packaging a parameter set as FMUs: `IT2Plant.fmu` and `IT2Inverse.fmu`, of FMI 2.0 or FMI 3.0.

The binaries are the same for every parameter set, and hold the functions of both versions. What
differs is modelDescription.xml, the set in `resources/` and the one compiled into `sources/`, which the
GUID ties together.
"""

import zipfile
from collections.abc import Collection, Mapping
from io import BytesIO
from pathlib import Path

from it2hys.fmu.build_description import format_build_description
from it2hys.fmu.codegen import start_header
from it2hys.fmu.documentation import Origin, documentation_files
from it2hys.fmu.model_description import IDENTIFIERS, format_model_description
from it2hys.fmu.own_binaries import make_binaries
from it2hys.fmu.platforms import platform_binaries
from it2hys.fmu.reference_run import reference_files
from it2hys.fmu.terminals import picture_files, terminal_files
from it2hys.model.compiled import native_directory
from it2hys.model.parameters import ParameterSet, format_ssv
from it2hys.model.stages import own_effects
from it2hys.model.variables import load_table
from it2hys.support.files import write_together
from it2hys.support.version import package_version

# zip entries carry a time; a fixed one makes the same input give the same file
EPOCH = (1980, 1, 1, 0, 0, 0)
PARAMETER_FILE = "parameters.ssv"
#: Endings of the files' names by version of FMI.
SUFFIX = {2: "", 3: "_fmi3"}
BUILD_DESCRIPTION = "sources/buildDescription.xml"
# beside the C library: libm for hum, lag, creep and resonance, libdl to find the FMU's resources
LIBRARIES = ("m", "dl")


def package(
    parameters: ParameterSet,
    directory: str | Path,
    *,
    fmi: Collection[int] = (2,),
    terminals: bool = True,
    origin: Origin | None = None,
) -> list[Path]:
    """Write both FMUs and the parameter set into a directory.

    Parameters
    ----------
    parameters : ParameterSet
        A validated set.
    directory : path
        Created if it does not exist. All files get there, or none of them.
    fmi : collection of {2, 3}
        Versions of FMI; each has FMUs of its own.
    terminals : bool
        Give the FMUs terminals and an icon. FMILibrary 3 up to 3.0.5, and what is built on it, refuses
        FMUs of FMI 2.0 that have them (`it2hys.fmu.terminals`).
    origin : Origin, optional
        What the set was identified from, for the FMUs' documentation.

    Returns
    -------
    list of Path
        The files written: `IT2Plant.fmu` and `IT2Inverse.fmu` of FMI 2.0, `IT2Plant_fmi3.fmu` and
        `IT2Inverse_fmi3.fmu` of FMI 3.0, and `parameters.ssv`; also the Python files of effects of the
        user's own that are in the chain.

    Raises
    ------
    InputError
        If the directory cannot be written to.
    """
    contents = {
        f"{identifier}{SUFFIX[version]}.fmu": fmu
        for version in sorted(fmi)
        for identifier, fmu in package_bytes(
            parameters, fmi=version, terminals=terminals, origin=origin
        ).items()
    }
    contents[PARAMETER_FILE] = format_ssv(parameters).encode()
    # without which nobody can read the set again
    contents |= {f"{effect.name}.py": effect.text for effect in own_effects().values()}
    return write_together(directory, contents)


def package_bytes(
    parameters: ParameterSet, *, fmi: int = 2, terminals: bool = True, origin: Origin | None = None
) -> dict[str, bytes]:
    """Return both FMUs with a parameter set, of one version of FMI, by model identifier."""
    native = native_directory()
    if own_effects():
        make_binaries(native)
    if fmi == 3:
        parameters = with_every_array(parameters)
    return {
        identifier: _fmu(model, identifier, parameters, native, fmi, terminals, origin)
        for model, identifier in IDENTIFIERS.items()
    }


def with_every_array(parameters: ParameterSet) -> ParameterSet:
    """Return a set that has an element of every group: where there was none, one without effect.

    FMI 3.0 wants arrays that are not empty at first (Array variables and structural parameters), for
    tools that do not care about their length.
    """
    missing: dict[str, float | int] = {}
    for group, entry in load_table().counts.items():
        if parameters.counts[group] == 0:
            missing[entry["variable"]] = 1
            missing.update({f"{group}[1].{name}": v for name, v in entry["without_effect"].items()})
    return parameters.replace(**missing) if missing else parameters


def _fmu(
    model: str,
    identifier: str,
    parameters: ParameterSet,
    native: Path,
    fmi: int,
    terminals: bool,
    origin: Origin | None,
) -> bytes:
    """Return the FMU as a zip archive."""
    sources = fmu_sources(identifier, native / "sources", fmi)
    c_files = sorted(name for name in sources if name.endswith(".c"))
    sources["fmu_start.h"] = start_header(parameters, format_ssv(parameters)).encode()
    description = format_model_description(model, parameters, c_files, package_version(), fmi)
    entries = {
        "modelDescription.xml": description,
        f"resources/{PARAMETER_FILE}": format_ssv(parameters).encode(),
        **{f"resources/{effect.name}.py": effect.text for effect in own_effects().values()},
        **{f"sources/{name}": content for name, content in sources.items()},
        BUILD_DESCRIPTION: format_build_description(identifier, c_files, LIBRARIES),
        **platform_binaries(identifier, native, fmi),
        **documentation_files(model, parameters, (native / "LICENSE").read_bytes(), origin, fmi),
        # FMI 3.0's is with the terminals
        **(picture_files(model) if fmi == 2 else {}),
        **(terminal_files(model, parameters) if terminals else {}),
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


def fmu_sources(identifier: str, folder: Path, fmi: int) -> dict[str, bytes]:
    """Return the C files of one FMU, with the functions of one version of FMI."""
    names = (f"{identifier}{SUFFIX[fmi]}.c", "it2hys.c", "it2hys.h")
    return {name: (folder / name).read_bytes() for name in names}
