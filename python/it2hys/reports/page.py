"""Reports: one self-contained HTML page, with its figures as PNG beside it."""

import base64
import re
from dataclasses import dataclass, field
from pathlib import Path

from jinja2 import Environment, PackageLoader
from markupsafe import Markup, escape
from matplotlib.figure import Figure

from it2hys.reports.figures import png
from it2hys.support.files import write_atomically
from it2hys.support.progress import Progress

#: Stands in a table where there is no figure.
NONE = "–"


@dataclass(frozen=True)
class Table:
    """A table of a report: column heads and rows of text."""

    columns: list[str]
    rows: list[list[str]]
    caption: str = ""

    def text(self) -> str:
        """Return the table as aligned text for the terminal."""
        lines = [self.columns, *self.rows]
        widths = [max(len(line[i]) for line in lines) for i in range(len(self.columns))]
        return "\n".join(
            "  ".join(
                cell.ljust(width) if i == 0 else cell.rjust(width)
                for i, (cell, width) in enumerate(zip(line, widths, strict=True))
            ).rstrip()
            for line in lines
        )


@dataclass(frozen=True)
class Picture:
    """A figure of a report: its file name without ending, and what it shows."""

    name: str
    figure: Figure
    caption: str


@dataclass(frozen=True)
class Section:
    """A section of a report: paragraphs, commands, then tables, then pictures.

    Without a title it goes on from the section before.
    """

    title: str
    text: list[str] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)
    commands: list[str] = field(default_factory=list)


def _with_commands(text: str) -> Markup:
    """Return a text with its `commands` set as such."""
    return Markup(re.sub("`([^`]+)`", r"<code>\1</code>", str(escape(text))))


def write_report(
    directory: Path,
    title: str,
    sections: list[Section],
    progress: Progress = lambda share, text: None,
) -> Path:
    """Write `report.html` and the PNG files of its pictures into an existing directory.

    Returns
    -------
    Path
        The page.
    """
    pictures = [picture for section in sections for picture in section.pictures]
    images = {}
    for i, picture in enumerate(pictures):
        progress(i / len(pictures), f"report: {picture.name}")
        images[picture.name] = png(picture.figure)
    for name, content in images.items():
        write_atomically(directory / f"{name}.png", content)
    environment = Environment(
        loader=PackageLoader("it2hys.reports"), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["commands"] = _with_commands
    page = environment.get_template("report.html").render(
        title=title,
        sections=sections,
        images={name: base64.b64encode(content).decode() for name, content in images.items()},
    )
    path = directory / "report.html"
    write_atomically(path, page.encode())
    return path
