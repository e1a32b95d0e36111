"""`sources/buildDescription.xml`: how a tool builds an FMU from its sources.

FMI 2.0.4 took the file over from FMI 3.0, and what it says goes before the list of files in
modelDescription.xml, which knows neither libraries nor options.
"""

from collections.abc import Sequence

from lxml import etree

# fused multiplications would give other bits than the binaries in the FMU
OPTIONS = "-ffp-contract=off"
WINDOWS = ("x86_64-windows", "x86-windows")


def format_build_description(
    identifier: str, source_files: Sequence[str], libraries: Sequence[str] = ()
) -> bytes:
    """Return buildDescription.xml.

    Parameters
    ----------
    identifier : str
        The FMU's model identifier.
    source_files : sequence of str
        C files in `sources/` to compile; FMI's headers are the importer's.
    libraries : sequence of str
        Libraries to link to, except on Windows, whose C library has all.
    """
    root = etree.Element("fmiBuildDescription", fmiVersion="3.0")
    anywhere = etree.SubElement(
        root,
        "BuildConfiguration",
        modelIdentifier=identifier,
        description="Any platform but Windows, with gcc or a compiler that takes its options",
    )
    _add_sources(anywhere, source_files, compiler="gcc", compilerOptions=OPTIONS)
    for name in libraries:
        etree.SubElement(anywhere, "Library", name=name, external="true")
    for platform in WINDOWS:
        windows = etree.SubElement(
            root, "BuildConfiguration", modelIdentifier=identifier, platform=platform
        )
        _add_sources(windows, source_files)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def _add_sources(configuration: etree._Element, source_files: Sequence[str], **attributes: str) -> None:
    files = etree.SubElement(configuration, "SourceFileSet", language="C99", **attributes)
    for name in source_files:
        etree.SubElement(files, "SourceFile", name=name)
