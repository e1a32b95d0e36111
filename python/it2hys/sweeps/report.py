"""The report of a sweep, drawn from `results.parquet` alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl

from it2hys.reports.page import Picture, Section, Table, write_report
from it2hys.support.files import make_directory
from it2hys.sweeps.plots import Columns, draw
from it2hys.sweeps.store import read_metadata
from it2hys.sweeps.worker import MESSAGES_APART

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
        text = f"{self.cases} cases, {self.failed} failed"
        if self.warned:
            text += f", {self.warned} with warnings"
        if self.out_of_range:
            text += (
                f": {self.out_of_range} go beyond what their model holds for (outOfRange), for up to "
                f"{self.longest} samples"
            )
        return text


def write_sweep_report(results: Path, directory: Path) -> tuple[Path, Counts]:
    """Write `report.html` and its figures.

    Parameters
    ----------
    results : path
        The table of a sweep; nothing else is read.
    directory : path
        For the report; made if it does not exist.

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
    failed = rows.filter(pl.col("status") != "ok")
    counts = Counts.of_table(rows)
    text = [metadata["text"]] if metadata["text"] else []
    text.append(
        f"{counts.text}. Everything here is drawn from {results.name}, whose rows are the cases."
    )
    sections = [Section("Results", text, [_summary(columns)], _pictures(metadata, columns))]
    if counts.failed:
        sections.append(_failures(failed, metadata))
    said = _messages(columns.rows)
    if said is not None:
        sections.append(said)
    return write_report(make_directory(directory), metadata["title"], sections), counts


def _summary(columns: Columns) -> Table:
    rows = []
    for metric in columns.metadata["metrics"]:
        found = columns.read(metric["name"]).drop_nulls(metric["name"])
        for name, part in columns.variants(found):
            values = columns.values(metric["name"], part)
            if len(values):
                shares = np.percentile(values, [0, 5, 50, 95, 100])
                numbers = [f"{v:.4g}" for v in shares]
                rows.append([columns.label(metric["name"]), name or "–", str(len(values)), *numbers])
    head = ["metric", "variant", "cases", "least", "5 %", "median", "95 %", "greatest"]
    return Table(head, rows, "Metrics over all cases that have them")


def _pictures(metadata: dict, columns: Columns) -> list[Picture]:
    pictures = []
    for number, entry in enumerate(metadata["figures"] or default_figures(metadata), start=1):
        drawn = draw(entry, columns)
        if drawn is not None:
            figure, text = drawn
            name = f"figure_{number}_{entry['kind'].replace(' ', '_')}"
            pictures.append(Picture(name, figure, f"{entry['title']} {text}".strip()))
    return pictures


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
    table = Table(["message", "cases", "first"], rows, "What the FMUs had to say, most frequent first")
    return Section("Messages", [], [table])


def _cut(message: str) -> str:
    """Return a message, or what fits of it in whole words."""
    return message if len(message) <= MESSAGE else message[:MESSAGE].rpartition(" ")[0] + " …"
