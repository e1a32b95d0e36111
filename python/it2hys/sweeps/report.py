"""The report of a sweep, drawn from `results.parquet` alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl

from it2hys.packaging import make_directory
from it2hys.report import Picture, Section, Table, write_report
from it2hys.sweeps.figures import Columns, draw
from it2hys.sweeps.store import read_metadata

CAPTIONS = {
    "heat map": "A cell is a case, or the mean of those that share it.",
    "lines": "A point is a case, or the median of those that share it, with a band of 5 to 95 %.",
    "loops": "A curve is a case.",
    "time course": "A curve is a case.",
    "distribution": "Median (solid) and 5 and 95 % (dotted) of the cases.",
}
#: Failed cases and messages that a page lists; the table has all.
LARGEST_LIST = 20
MESSAGE = 240


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
    def of_table(cls, frame: pl.DataFrame) -> Counts:
        """Count the rows of a table."""
        beyond = frame["out_of_range"].fill_null(0)
        return cls(
            len(frame),
            int((frame["status"] != "ok").sum()),
            int((frame["warned"].fill_null(False) | (beyond > 0)).sum()),
            int((beyond > 0).sum()),
            int(beyond.max() or 0),
        )

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
    frame = pl.read_parquet(results, columns=_columns_drawn(metadata))
    columns = Columns(frame, metadata)
    failed = frame.filter(pl.col("status") != "ok")
    counts = Counts.of_table(frame)
    text = [metadata["text"]] if metadata["text"] else []
    text.append(
        f"{counts.text}. Everything here is drawn from {results.name}, whose rows are the cases."
    )
    sections = [Section("Results", text, [_summary(columns)], _pictures(metadata, columns))]
    if len(failed):
        sections.append(_failures(failed, metadata))
    warned = columns.frame.drop_nulls("message")
    if len(warned):
        sections.append(_messages(warned))
    return write_report(make_directory(directory), metadata["title"], sections), counts


def _columns_drawn(metadata: dict) -> list[str]:
    """Return the columns that a report needs; of the traces, which may be large, those it draws."""
    scalars = [entry["name"] for key in ("axes", "metrics") for entry in metadata[key]]
    drawn = {figure[key] for figure in metadata["figures"] for key in ("x", "y", "value")}
    traces = [entry["name"] for entry in metadata["keep"] if entry["name"] in drawn]
    return ["case", "variant", *scalars, *traces, "status", "warned", "out_of_range", "message"]


def _summary(columns: Columns) -> Table:
    rows = []
    for name, frame in columns.variants():
        for metric in columns.metadata["metrics"]:
            values = columns.values(metric["name"], frame.drop_nulls(metric["name"]))
            if len(values):
                shares = np.percentile(values, [0, 5, 50, 95, 100])
                numbers = [f"{v:.4g}" for v in shares]
                rows.append([columns.label(metric["name"]), name or "–", str(len(values)), *numbers])
    head = ["metric", "variant", "cases", "least", "5 %", "median", "95 %", "greatest"]
    return Table(head, rows, "Metrics over all cases that have them")


def _pictures(metadata: dict, columns: Columns) -> list[Picture]:
    pictures = []
    for number, entry in enumerate(metadata["figures"] or _default_figures(metadata), start=1):
        figure = draw(entry, columns)
        if figure is not None:
            name = f"figure_{number}_{entry['kind'].replace(' ', '_')}"
            pictures.append(
                Picture(name, figure, f"{entry['title']} {CAPTIONS[entry['kind']]}".strip())
            )
    return pictures


def _default_figures(metadata: dict) -> Iterator[dict]:
    """Yield a figure for every metric: what suits the number of axes."""
    blank = {"title": "", "x": "", "y": "", "by": "", "select": {}}
    axes = [axis["name"] for axis in metadata["axes"]]
    for metric in metadata["metrics"]:
        entry = {**blank, "value": metric["name"], "x_scale": "linear", "y_scale": "linear"}
        if len(axes) == 1:
            yield {**entry, "kind": "lines", "x": axes[0]}
        elif len(axes) == 2:
            yield {**entry, "kind": "heat map", "x": axes[0], "y": axes[1]}
        else:
            yield {**entry, "kind": "distribution"}


def _failures(failed: pl.DataFrame, metadata: dict) -> Section:
    axes = [axis["name"] for axis in metadata["axes"]][:6]
    rows = [
        [
            str(row["case"]),
            row["variant"] or "–",
            *(f"{row[a]:.6g}" for a in axes),
            _cut(row["message"]),
        ]
        for row in failed.head(LARGEST_LIST).iter_rows(named=True)
    ]
    table = Table(["case", "variant", *axes, "message"], rows, f"The first {len(rows)} failed cases")
    return Section("Cases that failed", [], [table])


def _messages(warned: pl.DataFrame) -> Section:
    # one message for all times and values that it was said at
    alike = pl.col("message").str.replace_all(r"\b\d+(\.\d+)?(e[-+]?\d+)?\b", "…").alias("message")
    counted = warned.group_by(alike).agg(pl.len().alias("cases"), pl.col("case").min())
    counted = counted.sort(["cases", "case"], descending=[True, False])
    rows = [
        [_cut(row["message"]), str(row["cases"]), str(row["case"])]
        for row in counted.head(LARGEST_LIST).iter_rows(named=True)
    ]
    table = Table(["message", "cases", "first"], rows, "What the FMUs had to say, most frequent first")
    return Section("Messages", [], [table])


def _cut(message: str) -> str:
    return message if len(message) <= MESSAGE else message[:MESSAGE] + " …"
