"""Figures of a sweep, drawn from its table alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from copy import copy
from itertools import cycle

import matplotlib
import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogFormatter

from it2hys.reports.figures import STYLE
from it2hys.sweeps.schema import DRAWN

#: Units as people read them: label and factor from SI.
READ_AS = {
    "m": ("µm", 1e6),
    "share": ("%", 100.0),
    "m/V": ("µm/V", 1e6),
    "m/N": ("µm/N", 1e6),
    "1": ("", 1.0),
}
COLOURS = ("#1f77b4", "#d95f02", "#1b9e77", "#7570b3", "#e7298a", "#666666", "#a6761d", "#000000")
MAP = "viridis"
#: Curves of a family that can be told apart, and points of one that a picture can show.
LARGEST_FAMILY, LARGEST_COUNT = 40, 4000
#: Cases that a figure is drawn of: of a larger table some, taken at random.
LARGEST_ROWS = 1_000_000
#: Points that can be told apart; cells along a side of a map, of a grid and of what is drawn.
LARGEST_SCATTER, LARGEST_SIDE, LARGEST_BINS = 4000, 200, 100
#: Points of a line, points of one that are marked, and lines that a legend can name.
LARGEST_LINE, LARGEST_MARKED, LARGEST_LEGEND = 1000, 200, 8
NO_VARIANT = ""

_styled = matplotlib.rc_context(STYLE)


class Columns:
    """The rows of a table that did not fail, with labels and units as people read them.

    A table may be larger than memory: columns are read when they are asked for.

    Parameters
    ----------
    rows : polars.LazyFrame
        The table.
    metadata : dict
        What the table carries with it.
    """

    def __init__(self, rows: pl.LazyFrame, metadata: Mapping) -> None:
        self._table, self.rows = rows, rows.filter(pl.col("status") == "ok")
        self.metadata = metadata
        self.names = rows.collect_schema().names()
        self._axes = {axis["name"]: axis for axis in metadata["axes"]}
        self._units = {
            e["name"]: e["unit"] for key in ("axes", "metrics", "keep") for e in metadata[key]
        }

    def select(self, conditions: Mapping[str, float | str]) -> Columns:
        """Return the rows where columns have some values, or the ones nearest to them."""
        chosen = copy(self)
        for name, value in conditions.items():
            if not isinstance(value, str):
                known = chosen.rows.select(pl.col(name).drop_nulls().unique()).collect()[name]
                value = min(known, key=lambda v: abs(v - value), default=value)
            chosen.rows = chosen.rows.filter(pl.col(name) == value)
        return chosen

    @property
    def one_in(self) -> int:
        """Of how many cases one is enough for a figure."""
        return -(-self.metadata["cases"] // LARGEST_ROWS)

    def read(self, *names: str, one_in: int = 1) -> pl.DataFrame:
        """Return columns, and the variant if there are any, of all cases or some taken at random."""
        rows = self.rows
        if one_in > 1:
            rows = rows.filter(pl.col("case").hash(seed=0) % one_in == 0)
        if self.metadata["variants"] != [NO_VARIANT]:
            names = ("variant", *names)
        return rows.select(*dict.fromkeys(names)).collect(engine="streaming")

    def traces(self, case: int, *names: str) -> dict[str, np.ndarray]:
        """Return traces of a case as people read them; row k of the table is case k."""
        row = self._table.slice(case, 1).select(*names).collect(engine="streaming")
        return {name: row[name][0].to_numpy() * self.scale(name) for name in names}

    def is_drawn(self, name: str) -> bool:
        """Tell whether a column's values are random draws."""
        return self._axes.get(name, {}).get("method") in DRAWN

    def scale(self, name: str) -> float:
        """Return the factor from SI to what is read."""
        return READ_AS.get(self._units.get(name, ""), ("", 1.0))[1]

    def label(self, name: str) -> str:
        """Return the label of an axis."""
        unit = self._units.get(name, "")
        unit = READ_AS.get(unit, (unit, 1.0))[0]
        return f"{name} in {unit}" if unit else name

    def values(self, name: str, frame: pl.DataFrame) -> np.ndarray:
        """Return a column of rows as people read it."""
        return np.multiply(frame[name].to_numpy(), self.scale(name), dtype=float)

    def variants(self, frame: pl.DataFrame) -> Iterator[tuple[str, pl.DataFrame]]:
        """Yield every variant's name and its part of some rows."""
        for name in self.metadata["variants"]:
            if name == NO_VARIANT:
                yield "", frame
            else:
                yield name, frame.filter(pl.col("variant") == name)


def draw(entry: Mapping, columns: Columns) -> tuple[Figure, str] | None:
    """Draw one figure entry of a scenario.

    Returns
    -------
    figure : Figure
    text : str
        What a mark of it is; None instead of both where no case is left to be drawn.
    """
    functions: dict[str, Callable[[Mapping, Columns], tuple[Figure, str] | None]] = {
        "heat map": heat_map,
        "lines": lines,
        "loops": loops,
        "time course": time_course,
        "distribution": distribution,
    }
    drawn = functions[entry["kind"]](entry, columns.select(entry["select"]))
    if drawn is None or columns.one_in == 1:
        return drawn
    return drawn[0], f"{drawn[1]} One in {columns.one_in} cases is drawn, taken at random."


def _panels(
    columns: Columns, rows: pl.DataFrame, height: float
) -> tuple[Figure, list[tuple[Axes, pl.DataFrame]]]:
    """Return a figure and its panels with their rows, one for each variant that has any."""
    variants = [(name, part) for name, part in columns.variants(rows) if len(part)]
    width = 6.4 if len(variants) == 1 else min(4.2 * len(variants), 12.6)
    figure = Figure(figsize=(width, height))
    axes = figure.subplots(1, len(variants), squeeze=False, sharex=True, sharey=True)[0]
    for axis, (name, _) in zip(axes, variants, strict=True):
        axis.set_title(name, fontsize=9, loc="left")
    return figure, [(axis, part) for axis, (_, part) in zip(axes, variants, strict=True)]


def _head(figure: Figure, entry: Mapping, fallback: str) -> None:
    for axis in figure.axes:
        _plain_numbers(axis)
    figure.suptitle(
        entry["title"].rstrip(".") or fallback, x=0.01, horizontalalignment="left", fontsize=11
    )


def _plain_numbers(axis: Axes) -> None:
    """Write 20 and not 2 x 10^1 on a logarithmic axis."""
    for side in (axis.xaxis, axis.yaxis):
        if side.get_scale() == "log":
            side.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            side.set_minor_formatter(_PlainMinor(minor_thresholds=(1.5, 0.4)))


class _PlainMinor(LogFormatter):
    """Labels the minor ticks that a logarithmic axis labels, in plain numbers."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        return f"{x:g}" if super().__call__(x, pos) else ""


@_styled
def heat_map(entry: Mapping, columns: Columns) -> tuple[Figure, str] | None:
    """Draw a metric over two columns, a panel for each variant.

    A grid is drawn as its cells. Columns whose values hardly ever meet again, such as random draws,
    are drawn as points, or as means over cells where there are too many of them.
    """
    x, y, value = entry["x"], entry["y"], entry["value"]
    rows = columns.read(x, y, value, one_in=columns.one_in).drop_nulls([x, y, value])
    if not len(rows):
        return None
    scales = (entry["x_scale"], entry["y_scale"])
    sides, places = zip(
        *(np.unique(columns.values(name, rows), return_inverse=True) for name in (x, y)), strict=True
    )
    meeting = _do_meet(len(sides[0]), len(sides[1]), *places)
    if meeting or len(rows) > LARGEST_SCATTER:
        edges = [_edges(*side, len(rows), meeting) for side in zip(sides, scales, strict=True)]
        text = "A cell is a case, or the mean of those in it."
    else:
        edges, text = None, "A point is a case."
    figure, panels = _panels(columns, rows, 4.0)
    drawn = []
    for axis, part in panels:
        numbers = [columns.values(name, part) for name in (x, y, value)]
        drawn.append(_points(axis, *numbers) if edges is None else _cells(axis, *numbers, *edges))
        axis.set(xlabel=columns.label(x), xscale=scales[0], yscale=scales[1])
    shades = np.ma.concatenate([np.ma.ravel(collection.get_array()) for collection in drawn])
    for collection in drawn:
        collection.set_clim(shades.min(), shades.max())
    panels[0][0].set_ylabel(columns.label(y))
    mean = "mean " if shades.count() < len(rows) else ""
    figure.colorbar(drawn[-1], ax=figure.axes, label=mean + columns.label(value))
    _head(figure, entry, f"{value} over {x} and {y}")
    return figure, text


def _do_meet(columns: int, rows: int, column: np.ndarray, row: np.ndarray) -> bool:
    """Tell whether cases fill most of a grid, given the places of each."""
    if 2 * len(row) <= columns * rows:
        return False
    return 2 * np.count_nonzero(np.bincount(row * columns + column)) > columns * rows


def _points(axis: Axes, x: np.ndarray, y: np.ndarray, value: np.ndarray) -> Collection:
    size = np.clip(8000.0 / len(x), 4.0, 30.0)
    return axis.scatter(x, y, c=value, s=size, cmap=MAP, linewidths=0)


def _cells(
    axis: Axes, x: np.ndarray, y: np.ndarray, value: np.ndarray, xs: np.ndarray, ys: np.ndarray
) -> Collection:
    """Draw means over cells between edges; a cell without a case stays empty."""
    column, row = (
        np.clip(np.searchsorted(edges, at, side="right") - 1, 0, len(edges) - 2)
        for edges, at in ((xs, x), (ys, y))
    )
    shape = (len(ys) - 1, len(xs) - 1)
    place = row * shape[1] + column
    count = np.bincount(place, minlength=shape[0] * shape[1])
    total = np.bincount(place, value, minlength=shape[0] * shape[1])
    means = np.divide(total, count, out=np.full(len(count), np.nan), where=count > 0)
    axis.grid(False)
    return axis.pcolormesh(xs, ys, means.reshape(shape), cmap=MAP)


def _edges(values: np.ndarray, scale: str, count: int, meeting: bool) -> np.ndarray:
    """Return the edges of cells along one side of a map.

    Around each of the values, or around runs of neighbours where they are many. Where values do not
    meet, at even distances with some ten of the `count` cases in a cell.
    """
    if len(values) == 1:
        return np.sort(values[0] * np.array([0.9, 1.1])) if values[0] else np.array([-0.5, 0.5])
    log = scale == "log" and values[0] > 0
    v = np.log(values) if log else values
    if len(v) > LARGEST_SIDE and not meeting:
        edges = np.linspace(v[0], v[-1], 1 + int(np.clip(np.sqrt(count / 10), 10, LARGEST_BINS)))
    else:
        run = -(-len(v) // LARGEST_SIDE)
        middles = (v[:-1] + v[1:]) / 2
        edges = np.concatenate([[2 * v[0] - middles[0]], middles[run - 1 :: run]])
        edges = np.append(edges, 2 * v[-1] - middles[-1])
    return np.exp(edges) if log else edges


@_styled
def lines(entry: Mapping, columns: Columns) -> tuple[Figure, str] | None:
    """Draw a metric over a column: a line for each variant, and each value of `by` if there is one.

    Where several cases share a point, their median is drawn, and the range of 90 % as a band.
    """
    x, value, by = entry["x"], entry["value"], entry["by"]
    by = "" if by == "variant" else by
    named = filter(None, (x, value, by))
    rows = columns.read(*named, one_in=columns.one_in).drop_nulls([x, value])
    if not len(rows):
        return None
    text = "A point is a case, or the median of those that share it, with a band of 5 to 95 %."
    groups = [None]
    if by:
        groups = rows[by].drop_nulls().unique().sort()
        if len(groups) > LARGEST_LEGEND:
            text += f" {LARGEST_LEGEND} of the {len(groups)} values of {by} are drawn."
            groups = groups.gather(_spread(len(groups), LARGEST_LEGEND))
    figure = Figure(figsize=(6.4, 4.0))
    axis = figure.subplots()
    colours = cycle(COLOURS)
    for name, frame in columns.variants(rows):
        for group in groups:
            part = frame if group is None else frame.filter(pl.col(by) == group)
            if not len(part):
                continue
            label = name if group is None else f"{name} {by} {group * columns.scale(by):g}".strip()
            _line(axis, columns, part, x, value, label, next(colours))
    axis.set(
        xlabel=columns.label(x), ylabel=columns.label(value),
        xscale=entry["x_scale"], yscale=entry["y_scale"],
    )  # fmt: skip
    if axis.get_legend_handles_labels()[1]:
        axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.1)
    _head(figure, entry, f"{value} over {x}")
    return figure, text


def _spread(count: int, most: int) -> np.ndarray:
    """Return at most so many indices below a count, evenly spread."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(int))


def _line(
    axis: Axes, columns: Columns, part: pl.DataFrame, x: str, value: str, label: str, colour: str
) -> None:
    distinct = part[x].n_unique()
    run = -(-distinct // LARGEST_LINE)  # neighbours that share a point
    points = (
        part.group_by(((pl.col(x).rank("dense") - 1) // run).alias("place"))
        .agg(
            pl.col(x).mean().alias("x"),
            pl.col(value).median().alias("median"),
            pl.col(value).quantile(0.05).alias("low"),
            pl.col(value).quantile(0.95).alias("high"),
            pl.len().alias("count"),
        )
        .sort("x")
    )
    at = points["x"].to_numpy() * columns.scale(x)
    median, low, high = (
        points[name].to_numpy() * columns.scale(value) for name in ("median", "low", "high")
    )
    # a line from draw to draw would show how the other columns were drawn
    alone = points["count"].max() == 1 and columns.is_drawn(x) and len(columns.metadata["axes"]) > 1
    axis.plot(
        at,
        median,
        color=colour,
        label=label,
        marker="o",
        markersize=3 if alone or len(at) <= LARGEST_MARKED else 0,
        linewidth=0 if alone else 1.2,
    )
    if points["count"].max() > 1:
        axis.fill_between(at, low, high, color=colour, alpha=0.15, linewidth=0)


@_styled
def loops(entry: Mapping, columns: Columns) -> tuple[Figure, str] | None:
    """Draw one trace over another for every case, coloured by a column: a family of loops."""
    x, y = entry["x"], entry["y"]
    return _families(entry, columns, (x, y), columns.label(x), f"{y} over {x}", 4.4)


@_styled
def time_course(entry: Mapping, columns: Columns) -> tuple[Figure, str] | None:
    """Draw a trace over time for every case, coloured by a column."""
    value = entry["value"]
    return _families(entry, columns, (None, value), "time in s", f"{value} over time", 4.0)


def _families(
    entry: Mapping,
    columns: Columns,
    names: tuple[str | None, str],
    label: str,
    title: str,
    height: float,
) -> tuple[Figure, str] | None:
    """Draw a family of traces for each variant; of many cases some, evenly spread."""
    by = "" if entry["by"] == "variant" else entry["by"]
    known = ["case", *filter(None, (by, "step" if "step" in columns.names else None))]
    cases = columns.read(*known, one_in=columns.one_in)
    if not len(cases):
        return None
    figure, panels = _panels(columns, cases, height)
    colour, count = _colours(columns, cases, by), 0
    for axis, part in panels:
        part = part.sort(by) if by else part
        picked = part[_spread(len(part), LARGEST_FAMILY)]
        count += len(picked)
        _family(axis, columns, picked, names, colour, by)
        axis.set(xlabel=label, xscale=entry["x_scale"])
    panels[0][0].set_ylabel(columns.label(names[1]))
    if by:
        figure.colorbar(colour, ax=figure.axes, label=columns.label(by))
    _head(figure, entry, title)
    some = f" {count} of {len(cases)} are drawn." if count < len(cases) else ""
    return figure, f"A curve is a case.{some}"


def _family(
    axis: Axes,
    columns: Columns,
    picked: pl.DataFrame,
    names: tuple[str | None, str],
    colour: matplotlib.cm.ScalarMappable,
    by: str,
) -> None:
    for row in picked.iter_rows(named=True):
        traces = columns.traces(row["case"], *filter(None, names))
        y = traces[names[1]]
        stride = max(len(y) // LARGEST_COUNT, 1)
        if names[0] is None:
            step = row.get("step") or columns.metadata["step"]
            x = np.arange(len(y)) * step * columns.metadata["keep_every"]
        else:
            x = traces[names[0]]
        shade = colour.to_rgba(row[by] * columns.scale(by)) if by else COLOURS[0]
        axis.plot(x[::stride], y[::stride], linewidth=0.9, color=shade)


def _colours(columns: Columns, cases: pl.DataFrame, by: str) -> matplotlib.cm.ScalarMappable:
    values = columns.values(by, cases) if by else np.zeros(1)
    norm = matplotlib.colors.Normalize(np.nanmin(values), np.nanmax(values) or 1.0)
    return matplotlib.cm.ScalarMappable(norm, MAP)


@_styled
def distribution(entry: Mapping, columns: Columns) -> tuple[Figure, str] | None:
    """Draw the histogram of a metric, for each variant, with its median and range of 90 %."""
    value = entry["value"]
    rows = columns.read(value, one_in=columns.one_in).drop_nulls(value)
    if not len(rows):
        return None
    figure = Figure(figsize=(6.4, 3.8))
    axis = figure.subplots()
    every = columns.values(value, rows)
    # a few cases that ran away would leave nothing to be seen of the others
    low, high = np.percentile(every, [0.0, 99.0])
    outside = np.count_nonzero(every > high)
    space = np.geomspace if entry["x_scale"] == "log" and low > 0 else np.linspace
    bins = space(low, high if high > low else low + 1.0, min(60, max(10, int(np.sqrt(len(every))) * 2)))
    for (name, frame), colour in zip(columns.variants(rows), cycle(COLOURS), strict=False):
        values = columns.values(value, frame)
        if not len(values):
            continue
        axis.hist(values, bins, color=colour, alpha=0.45, label=name or None)
        for share, style in ((5, ":"), (50, "-"), (95, ":")):
            axis.axvline(np.percentile(values, share), color=colour, linestyle=style, linewidth=1.0)
    beyond = f" ({outside} greater ones are not shown)" if outside else ""
    axis.set(xlabel=columns.label(value) + beyond, ylabel="cases", xscale=entry["x_scale"])
    if axis.get_legend_handles_labels()[1]:
        axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1)
    _head(figure, entry, f"Distribution of {value}")
    return figure, "Median (solid) and 5 and 95 % (dotted) of the cases."
