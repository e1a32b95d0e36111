"""Reports: one self-contained HTML page, with its figures as PNG beside it."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from jinja2 import Environment, PackageLoader
from markupsafe import Markup, escape
from matplotlib.figure import Figure

from it2hys.errors import InputError
from it2hys.reports.figures import png
from it2hys.reports.interactive import script
from it2hys.support.files import write_atomically
from it2hys.support.progress import Progress

#: File name of a page.
PAGE = "report.html"
#: Cell of a table without a value.
NONE = "–"
#: A cell that is a figure, or a figure with its unit.
_FIGURE = re.compile(r"(± |[+−-])?\d[\d.,e+-]*|–")
#: The space between a figure and its unit, where no line is broken.
_BEFORE_UNIT = re.compile(r"(?<=\d) (?=(?:[µn]m|m?V|m?s|k?Hz|N|K|°C|MB|%)(?![A-Za-z]))|(?<=±) ")


@dataclass(frozen=True)
class Table:
    """A table of a report: column heads and rows of text."""

    columns: list[str]
    rows: list[list[str]]
    caption: str = ""

    @property
    def figures(self) -> list[bool]:
        """Of each column whether it holds figures alone; text is aligned at its beginning."""
        return [all(_FIGURE.fullmatch(c) for c in cells) for cells in zip(*self.rows, strict=True)]

    def text(self) -> str:
        """Return the table as aligned text for the terminal."""
        lines = [self.columns, *self.rows]
        widths = [max(len(line[i]) for line in lines) for i in range(len(self.columns))]
        return "\n".join(
            "  ".join(
                cell.rjust(width) if is_figure else cell.ljust(width)
                for cell, width, is_figure in zip(line, widths, self.figures, strict=True)
            ).rstrip()
            for line in lines
        )


@dataclass(frozen=True)
class Answer:
    """A question that the reader has, and the answer: sentences, and figures that are compared."""

    question: str
    texts: list[str]
    table: Table | None = None
    after: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Picture:
    """A figure of a report: its file name without ending, and what it shows.

    Without a `figure` it is the PNG of that name that lies in the directory of the report already.
    """

    name: str
    figure: Figure | None
    caption: str


@dataclass(frozen=True)
class View:
    """A figure to look into: what it shows, and itself as `interactive.as_json` gives it."""

    title: str
    content: str


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

    def as_json(self) -> dict:
        """Return the section as `report.json` holds it; its pictures are files."""
        return {
            "title": self.title,
            "text": self.text,
            "tables": [vars(table) for table in self.tables],
            "pictures": [{"name": p.name, "caption": p.caption} for p in self.pictures],
            "commands": self.commands,
        }

    @classmethod
    def of_json(cls, stored: dict) -> Section:
        """Return a section from `report.json`."""
        return cls(
            stored["title"],
            stored["text"],
            [Table(**table) for table in stored["tables"]],
            [Picture(p["name"], None, p["caption"]) for p in stored["pictures"]],
            stored["commands"],
        )


@dataclass(frozen=True)
class Page:
    """A report: answers beside pictures at the top, figures to look into, and folded details.

    Parameters
    ----------
    title : str
    about : str
        Where it comes from: version, date, command.
    answers : list of Answer
    pictures : list of Picture
        Beside the answers.
    views : list of View
    hint : str
        How they are looked into.
    details : list of Section
        Folded.
    """

    title: str
    about: str = ""
    answers: list[Answer] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)
    views: list[View] = field(default_factory=list)
    hint: str = "Drag a box to zoom in; the circular arrow takes it back. Values show at the pointer."
    details: list[Section] = field(default_factory=list)

    @property
    def all_pictures(self) -> list[Picture]:
        """All pictures, in their order."""
        return [*self.pictures, *(p for section in self.details for p in section.pictures)]


def _with_commands(text: str) -> Markup:
    """Return a text with its `commands` set as such, and figures and their units on one line."""
    return Markup(re.sub("`([^`]+)`", r"<code>\1</code>", str(escape(_with_units(text)))))


def _with_units(text: str) -> str:
    """Return a text in which figures and their units are not parted by the end of a line."""
    return _BEFORE_UNIT.sub("\N{NO-BREAK SPACE}", text)


def write_pictures(
    directory: Path,
    pictures: Iterable[Picture],
    progress: Progress = lambda share, text: None,
) -> None:
    """Write those pictures that have a figure as PNG into an existing directory."""
    drawn = {picture.name: picture.figure for picture in pictures if picture.figure}
    for i, (name, figure) in enumerate(drawn.items()):
        progress(i / len(drawn), f"report: {name}")
        write_atomically(directory / f"{name}.png", png(figure))


def write_page(directory: Path, page: Page, name: str = PAGE) -> Path:
    """Write `report.html`, or a page of another name, and its PNG files into an existing directory.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    InputError
        If a picture that was written before is not there, or the directory cannot be written to.
    """
    write_pictures(directory, page.all_pictures)
    environment = Environment(
        loader=PackageLoader("it2hys.reports"), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["commands"] = _with_commands
    environment.filters["units"] = _with_units
    text = environment.get_template("report.html").render(
        page=page,
        images={p.name: _image(directory / f"{p.name}.png") for p in page.all_pictures},
        script=Markup(script()) if page.views else "",
        views=[Markup(view.content) for view in page.views],
    )
    path = directory / name
    write_atomically(path, text.encode())
    return path


def _image(path: Path) -> Image:
    """Return a picture as the page carries it."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: a figure of the report cannot be read: {error.strerror}") from None
    # of a PNG the width stands in bytes 16 to 19; 160 pixels are an inch, 6.67 inches the text's width
    width = int.from_bytes(content[16:20], "big") / 160.0
    return Image(base64.b64encode(content).decode(), round(width * 6.67, 1))


class Image(NamedTuple):
    """A PNG as base64, and its width on the page in rem."""

    content: str
    width: float
