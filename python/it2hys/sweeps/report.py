"""The report of a sweep, drawn from `results.parquet` alone."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import polars as pl

from it2hys.reports.browsable import browsable
from it2hys.reports.inputs import inputs_section
from it2hys.reports.interactive import as_json
from it2hys.reports.page import Answer, Page, Picture, Section, Table, View, write_page
from it2hys.reports.provenance import Provenance, about
from it2hys.support.files import make_directory, write_atomically
from it2hys.support.numerals import counted
from it2hys.sweeps.plots import Columns, draw
from it2hys.sweeps.store import read_metadata
from it2hys.sweeps.worker import MESSAGES_APART

if TYPE_CHECKING:
    from bokeh.models import Model

#: Failed cases and messages that a page lists, and characters of one; the table has all.
LARGEST_LIST = 20
MESSAGE = 600


@dataclass(frozen=True)
class Counts:
    """How many cases of a sweep there are, failed, were warned of, and left the range of a model.

    `longest` is the largest number of samples that one case has beyond the range.
    """

    cases: int
    failed: int
    warned: int
    out_of_range: int
    longest: int

    @classmethod
    def of_table(cls, rows: pl.LazyFrame) -> Counts:
        """Count the rows of a table."""
        beyond = pl.col("out_of_range").fill_null(0)
        counts = rows.select(
            cases=pl.len(),
            failed=(pl.col("status") != "ok").sum(),
            warned=(pl.col("warned").fill_null(False) | (beyond > 0)).sum(),
            out_of_range=(beyond > 0).sum(),
            longest=beyond.max().fill_null(0),
        )
        return cls(**counts.collect().row(0, named=True))

    @property
    def text(self) -> str:
        """The counts as a sentence without its full stop."""
        text = f"{counted(self.cases, 'case')}, {self.failed} failed"
        if self.warned:
            text += f", {self.warned} with warnings"
        if self.out_of_range:
            text += (
                f": in {self.out_of_range} a plant leaves the range of its model (outOfRange), for up "
                f"to {counted(self.longest, 'sample')}"
            )
        return text


def write_sweep_report(
    results: Path, directory: Path, provenance: Provenance | None = None
) -> tuple[Path, Counts]:
    """Write `report.html`, its figures and `report.json`.

    Parameters
    ----------
    results : path
        The table of a sweep; of an earlier `report.json` beside it, where the sweep came from.
    directory : path
        For the report; made if it does not exist.
    provenance : Provenance, optional
        Where the sweep comes from.

    Returns
    -------
    path : Path
        Of the page.
    counts : Counts
        Cases that failed or were warned of.

    Raises
    ------
    InputError
        If the file is no table of a sweep, or the directory cannot be written to.
    """
    metadata = read_metadata(results)
    rows = pl.scan_parquet(results)  # read column by column: a table may be larger than memory
    columns = Columns(rows, metadata)
    counts = Counts.of_table(rows)
    origin = _origin(results, provenance)
    table = _summary(columns)
    drawn = list(_figures(metadata, columns))
    directory = make_directory(directory)
    report = {
        "title": metadata["title"],
        **origin,
        "kind": "sweep",
        "text": metadata["text"],
        **asdict(counts),
        "axes": [axis | _ends(axis["name"], columns) for axis in metadata["axes"]],
        "variants": [name for name in metadata["variants"] if name],
        "metrics": [
            dict(zip(("metric", "variant", "cases", *_SHARES), row, strict=True)) for row in table.rows
        ],
    }
    write_atomically(directory / "report.json", (json.dumps(report, indent=1) + "\n").encode())
    pictures = [picture for picture, _ in drawn]
    details = [Section("All figures for papers", [], [], pictures[1:])] if len(pictures) > 1 else []
    if counts.failed:
        details.append(_failures(rows.filter(pl.col("status") != "ok"), metadata))
    said = _messages(columns.rows)
    if said is not None:
        details.append(said)
    details.append(inputs_section(report))
    page = Page(
        metadata["title"],
        about(report),
        _answers(report, columns, counts, table, results),
        pictures[:1],
        [View(p.caption.rstrip(".") or p.name, as_json(view)) for p, view in drawn],
        details=details,
    )
    return write_page(directory, page), counts


#: Columns that the place of an extreme is named by.
_NAMED = 3
#: Shares of the cases below the figures of a metric, and what they are called.
_SHARES = {"least": 0, "5 %": 5, "median": 50, "95 %": 95, "greatest": 100}


def _origin(results: Path, provenance: Provenance | None) -> dict:
    """Return where a sweep comes from; of one that is drawn again, what was known when it ran."""
    if provenance is not None:
        return provenance.entries()
    known = Provenance().entries()
    try:
        stored = json.loads((results.parent / "report.json").read_text(encoding="utf-8"))
        return {name: stored[name] for name in known}
    except (OSError, ValueError, KeyError, TypeError):
        return known


def _ends(name: str, columns: Columns) -> dict:
    """Return the least and the greatest value of an axis, as people read it."""
    ends = columns.rows.select(low=pl.col(name).min(), high=pl.col(name).max()).collect().row(0)
    scale = columns.scale(name)
    low, high = (None if end is None else float(end) * scale for end in ends)
    return {"low": low, "high": high, "label": columns.label(name)}


def _answers(
    report: dict, columns: Columns, counts: Counts, table: Table, results: Path
) -> list[Answer]:
    """Return the answers at the top of the page: what was run, the results, failures and warnings."""
    axes = ", ".join(_spanned(axis) for axis in report["axes"])
    run = [report["text"]] if report["text"] else []
    run.append(
        f"{counted(counts.cases, 'case')} over {axes}." if axes else f"{counted(counts.cases, 'case')}."
    )
    if report["variants"]:
        run.append(f"Variants: {', '.join(report['variants'])}.")
    sound = "No case failed, and no FMU logged a warning."
    is_sound = not (counts.failed or counts.warned)
    return [
        Answer("What was run", run),
        Answer("Results", list(_extremes(columns)), table),
        Answer("Failures and warnings", [sound if is_sound else f"{counts.text}."]),
        Answer(
            "The table",
            [f"{results.name} has a row for every case. This page is drawn from it."],
        ),
    ]


def _spanned(axis: dict) -> str:
    """Return an axis and the values that it has."""
    if axis["low"] is None:
        return axis["label"]
    return f"{axis['label']} from {axis['low']:.4g} to {axis['high']:.4g}"


def _extremes(columns: Columns) -> Iterator[str]:
    """Yield a sentence on every metric: where it is least and greatest."""
    axes = [axis["name"] for axis in columns.metadata["axes"]]
    for metric in columns.metadata["metrics"]:
        name = metric["name"]
        ordered = columns.rows.filter(pl.col(name).is_finite()).select("case", name, *axes).sort(name)
        ends = [ordered.head(1).collect(), ordered.tail(1).collect()]
        if not len(ends[0]):
            continue
        words = []
        for end in ends:
            row = end.row(0, named=True)
            at = [f"{a} = {row[a] * columns.scale(a):.4g}" for a in axes if row[a] is not None]
            # more of them are no sentence; the table has the case
            place = ", ".join([*(at if len(at) <= _NAMED else []), f"case {row['case']}"])
            words.append(f"{row[name] * columns.scale(name):.4g} ({place})")
        yield f"{columns.label(name)}: from {words[0]} to {words[1]}."


def _summary(columns: Columns) -> Table:
    rows = []
    for metric in columns.metadata["metrics"]:
        found = columns.read(metric["name"]).drop_nulls(metric["name"])
        for name, part in columns.variants(found):
            values = columns.values(metric["name"], part)
            if len(values):
                shares = np.percentile(values, list(_SHARES.values()))
                numbers = [f"{v:.4g}" for v in shares]
                rows.append([columns.label(metric["name"]), name or "–", str(len(values)), *numbers])
    head = ["metric", "variant", "cases", *_SHARES]
    return Table(head, rows, "Metrics over all cases that have them")


def _figures(metadata: dict, columns: Columns) -> Iterator[tuple[Picture, Model]]:
    """Yield every figure as a picture and as one to look into."""
    for number, entry in enumerate(metadata["figures"] or default_figures(metadata), start=1):
        drawn = draw(entry, columns)
        if drawn is not None:
            figure, text = drawn
            name = f"figure_{number}_{entry['kind'].replace(' ', '_')}"
            title = entry["title"] or figure.get_suptitle()
            caption = " ".join([f"{title.rstrip('.')}.", text]).strip()
            yield Picture(name, figure, caption), browsable(figure)


def default_figures(metadata: dict) -> Iterator[dict]:
    """Yield a figure for every metric: what suits the number of axes."""
    blank = {"title": "", "by": "", "select": {}, "x_scale": "linear", "y_scale": "linear"}
    axes = metadata["axes"] if len(metadata["axes"]) <= 2 else []
    for side, axis in zip("xy", axes, strict=False):
        blank |= {side: axis["name"], f"{side}_scale": axis.get("scale", "linear")}
    kind = ("distribution", "lines", "heat map")[len(axes)]
    for metric in metadata["metrics"]:
        yield {**blank, "value": metric["name"], "kind": kind}


def _failures(failed: pl.LazyFrame, metadata: dict) -> Section:
    axes = [axis["name"] for axis in metadata["axes"]][:6]
    rows = [
        [
            str(row["case"]),
            row["variant"] or "–",
            *(f"{row[a]:.6g}" for a in axes),
            _cut(row["message"]),
        ]
        for row in failed.select("case", "variant", *axes, "message")
        .head(LARGEST_LIST)
        .collect(engine="streaming")
        .iter_rows(named=True)
    ]
    table = Table(["case", "variant", *axes, "message"], rows, f"The first {len(rows)} failed cases")
    return Section("Cases that failed", [], [table])


def _messages(rows: pl.LazyFrame) -> Section | None:
    """Return what the FMUs said of the cases that did not fail; None if they said nothing."""
    # one message for all times and values that it was said at, and once for a case
    alike = pl.col("message").str.replace_all(r"\b\d+(\.\d+)?(e[-+]?\d+)?\b", "…")
    each = alike.str.split(MESSAGES_APART).list.unique(maintain_order=True)
    said = rows.drop_nulls("message").select("case", each).explode("message")
    counted = said.group_by("message").agg(pl.len().alias("cases"), pl.col("case").min())
    counted = counted.sort(["cases", "case"], descending=[True, False]).head(LARGEST_LIST)
    rows = [
        [_cut(row["message"]), str(row["cases"]), str(row["case"])]
        for row in counted.collect(engine="streaming").iter_rows(named=True)
    ]
    if not rows:
        return None
    table = Table(["message", "cases", "first"], rows, "Messages of the FMUs, the most frequent first")
    return Section("Messages", [], [table])


def _cut(message: str) -> str:
    """Return a message, or what fits of it in whole words."""
    return message if len(message) <= MESSAGE else message[:MESSAGE].rpartition(" ")[0] + " …"
