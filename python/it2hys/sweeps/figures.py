"""Figures of a sweep, drawn from its table alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import cycle

import matplotlib
import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogFormatter

from it2hys.figures import STYLE

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
NO_VARIANT = ""

_styled = matplotlib.rc_context(STYLE)


class Columns:
    """The rows of a table that did not fail, with labels and units as people read them.

    Parameters
    ----------
    frame : polars.DataFrame
        The table.
    metadata : dict
        What the table carries with it.
    """

    def __init__(self, frame: pl.DataFrame, metadata: Mapping) -> None:
        self.frame = frame.filter(pl.col("status") == "ok")
        self.metadata = metadata
        self._units = {
            e["name"]: e["unit"] for key in ("axes", "metrics", "keep") for e in metadata[key]
        }

    def select(self, conditions: Mapping[str, float | str]) -> Columns:
        """Return the rows where columns have some values, or the ones nearest to them."""
        frame = self.frame
        for name, value in conditions.items():
            if not isinstance(value, str) and len(frame):
                value = min(frame[name].drop_nulls().unique(), key=lambda v: abs(v - value))
            frame = frame.filter(pl.col(name) == value)
        chosen = Columns(frame, self.metadata)
        chosen.frame = frame
        return chosen

    def scale(self, name: str) -> float:
        """Return the factor from SI to what is read."""
        return READ_AS.get(self._units.get(name, ""), ("", 1.0))[1]

    def label(self, name: str) -> str:
        """Return the label of an axis."""
        unit = self._units.get(name, "")
        unit = READ_AS.get(unit, (unit, 1.0))[0]
        return f"{name} in {unit}" if unit else name

    def values(self, name: str, frame: pl.DataFrame | None = None) -> np.ndarray:
        """Return a column as people read it."""
        frame = self.frame if frame is None else frame
        return frame[name].to_numpy().astype(float) * self.scale(name)

    def variants(self) -> Iterator[tuple[str, pl.DataFrame]]:
        """Yield every variant's name and rows."""
        for name in self.metadata["variants"]:
            if name == NO_VARIANT:
                yield "", self.frame
            else:
                yield name, self.frame.filter(pl.col("variant") == name)


def draw(entry: Mapping, columns: Columns) -> Figure | None:
    """Draw one figure entry of a scenario; None where no case is left to be drawn."""
    chosen = columns.select(entry["select"])
    if not len(chosen.frame):
        return None
    functions: dict[str, Callable[[Mapping, Columns], Figure]] = {
        "heat map": heat_map,
        "lines": lines,
        "loops": loops,
        "time course": time_course,
        "distribution": distribution,
    }
    return functions[entry["kind"]](entry, chosen)


def _panels(columns: Columns, height: float) -> tuple[Figure, Iterator[tuple[Axes, str, pl.DataFrame]]]:
    """Return a figure and its panels, one for each variant that has rows."""
    variants = [(name, frame) for name, frame in columns.variants() if len(frame)]
    width = 6.4 if len(variants) == 1 else min(4.2 * len(variants), 12.6)
    figure = Figure(figsize=(width, height))
    axes = figure.subplots(1, len(variants), squeeze=False, sharex=True, sharey=True)[0]
    for axis, (name, _) in zip(axes, variants, strict=True):
        axis.set_title(name, fontsize=9, loc="left")
    return figure, ((a, n, f) for a, (n, f) in zip(axes, variants, strict=True))


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
def heat_map(entry: Mapping, columns: Columns) -> Figure:
    """Draw a metric over two columns, a panel for each variant; cases sharing a cell are averaged."""
    x, y, value = entry["x"], entry["y"], entry["value"]
    figure, panels = _panels(columns, 4.0)
    all_values = columns.values(value)
    limits = {"vmin": np.nanmin(all_values), "vmax": np.nanmax(all_values)}
    drawn = []
    for axis, _, frame in panels:
        cells = frame.group_by(x, y).agg(pl.col(value).mean())
        xs, ys = (np.unique(columns.values(n, cells)) for n in (x, y))
        grid = np.full((len(ys), len(xs)), np.nan)
        rows = np.searchsorted(ys, columns.values(y, cells))
        grid[rows, np.searchsorted(xs, columns.values(x, cells))] = columns.values(value, cells)
        mesh = axis.pcolormesh(
            _edges(xs, entry["x_scale"]), _edges(ys, entry["y_scale"]), grid, cmap=MAP, **limits
        )
        axis.set(xlabel=columns.label(x), xscale=entry["x_scale"], yscale=entry["y_scale"])
        axis.grid(False)
        drawn.append((axis, mesh))
    drawn[0][0].set_ylabel(columns.label(y))
    figure.colorbar(drawn[-1][1], ax=[axis for axis, _ in drawn], label=columns.label(value))
    _head(figure, entry, f"{value} over {x} and {y}")
    return figure


def _edges(centres: np.ndarray, scale: str) -> np.ndarray:
    """Return the edges of cells around their centres."""
    if len(centres) == 1:
        return centres[0] * np.array([0.9, 1.1]) if centres[0] else np.array([-0.5, 0.5])
    log = scale == "log" and centres[0] > 0
    c = np.log(centres) if log else centres
    inner = (c[:-1] + c[1:]) / 2
    edges = np.concatenate([[2 * c[0] - inner[0]], inner, [2 * c[-1] - inner[-1]]])
    return np.exp(edges) if log else edges


@_styled
def lines(entry: Mapping, columns: Columns) -> Figure:
    """Draw a metric over a column: a line for each variant, and each value of `by` if there is one.

    Where several cases share a point, their median is drawn, and the range of 90 % as a band.
    """
    x, value, by = entry["x"], entry["value"], entry["by"]
    figure = Figure(figsize=(6.4, 4.0))
    axis = figure.subplots()
    colours = cycle(COLOURS)
    for name, frame in columns.variants():
        groups = frame[by].unique().sort() if by and by != "variant" else [None]
        for group in groups:
            part = frame if group is None else frame.filter(pl.col(by) == group)
            part = part.drop_nulls(value)
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
    return figure


def _line(
    axis: Axes, columns: Columns, part: pl.DataFrame, x: str, value: str, label: str, colour: str
) -> None:
    points = (
        part.group_by(x)
        .agg(
            pl.col(value).median(),
            pl.col(value).quantile(0.05).alias("low"),
            pl.col(value).quantile(0.95).alias("high"),
            pl.len().alias("count"),
        )
        .sort(x)
    )
    at = columns.values(x, points)
    axis.plot(
        at,
        columns.values(value, points),
        color=colour,
        label=label,
        marker="o",
        markersize=3,
        linewidth=1.2,
    )
    if points["count"].max() > 1:
        scale = columns.scale(value)
        low, high = (points[name].to_numpy() * scale for name in ("low", "high"))
        axis.fill_between(at, low, high, color=colour, alpha=0.15, linewidth=0)


@_styled
def loops(entry: Mapping, columns: Columns) -> Figure:
    """Draw one trace over another for every case, coloured by a column: a family of loops."""
    x, y = entry["x"], entry["y"]
    figure, panels = _panels(columns, 4.4)
    first, last = None, None
    for axis, _, frame in panels:
        _family(axis, columns, frame, entry["by"], (x, y))
        axis.set_xlabel(columns.label(x))
        first, last = first or axis, axis
    first.set_ylabel(columns.label(y))
    _colour_bar(figure, last, columns, entry["by"])
    _head(figure, entry, f"{y} over {x}")
    return figure


@_styled
def time_course(entry: Mapping, columns: Columns) -> Figure:
    """Draw a trace over time for every case, coloured by a column."""
    value = entry["value"]
    figure, panels = _panels(columns, 4.0)
    first, last = None, None
    for axis, _, frame in panels:
        _family(axis, columns, frame, entry["by"], (None, value))
        axis.set(xlabel="time in s", xscale=entry["x_scale"])
        first, last = first or axis, axis
    first.set_ylabel(columns.label(value))
    _colour_bar(figure, last, columns, entry["by"])
    _head(figure, entry, f"{value} over time")
    return figure


def _family(
    axis: Axes, columns: Columns, frame: pl.DataFrame, by: str, names: tuple[str | None, str]
) -> None:
    frame = frame.sort(by) if by else frame
    picked = np.unique(np.linspace(0, len(frame) - 1, min(len(frame), LARGEST_FAMILY)).astype(int))
    colour = _colours(columns, by)
    for row in frame[picked].iter_rows(named=True):
        y = np.asarray(row[names[1]]) * columns.scale(names[1])
        stride = max(len(y) // LARGEST_COUNT, 1)
        if names[0] is None:
            step = row.get("step") or columns.metadata["step"]
            x = np.arange(len(y)) * step * columns.metadata["keep_every"]
        else:
            x = np.asarray(row[names[0]]) * columns.scale(names[0])
        shade = colour(row[by] * columns.scale(by)) if by and by != "variant" else COLOURS[0]
        axis.plot(x[::stride], y[::stride], linewidth=0.9, color=shade)


def _colours(columns: Columns, by: str) -> matplotlib.cm.ScalarMappable | Callable:
    if not by or by == "variant":
        return lambda _value: COLOURS[0]
    values = columns.values(by)
    norm = matplotlib.colors.Normalize(np.nanmin(values), np.nanmax(values) or 1.0)
    return matplotlib.cm.ScalarMappable(norm, MAP).to_rgba


def _colour_bar(figure: Figure, axis: Axes, columns: Columns, by: str) -> None:
    if by and by != "variant":
        figure.colorbar(_colours(columns, by).__self__, ax=figure.axes, label=columns.label(by))


@_styled
def distribution(entry: Mapping, columns: Columns) -> Figure:
    """Draw the histogram of a metric, for each variant, with its median and range of 90 %."""
    value = entry["value"]
    figure = Figure(figsize=(6.4, 3.8))
    axis = figure.subplots()
    every = columns.values(value, columns.frame.drop_nulls(value))
    # a few cases that ran away would leave nothing to be seen of the others
    low, high = np.percentile(every, [0.0, 99.0])
    outside = np.count_nonzero(every > high)
    space = np.geomspace if entry["x_scale"] == "log" and low > 0 else np.linspace
    bins = space(low, high if high > low else low + 1.0, min(60, max(10, int(np.sqrt(len(every))) * 2)))
    for (name, frame), colour in zip(columns.variants(), cycle(COLOURS), strict=False):
        values = columns.values(value, frame.drop_nulls(value))
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
    return figure
