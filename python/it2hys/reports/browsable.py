"""A matplotlib figure as an interactive one: the same lines, points and cells, with zoom and hover."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection, PathCollection, PolyCollection, QuadMesh
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

if TYPE_CHECKING:
    from bokeh.models import Model, Plot

#: Largest number of points of a line on a page.
_MOST = 1000
_HEIGHT = 380
_DASHES = {"-": "solid", "--": "dashed", ":": "dotted", "-.": "dashdot"}
#: matplotlib's names of the axes of a colour bar, and of a line without a name.
_BAR, _NAMELESS = "<colorbar>", "_"


def browsable(figure: Figure) -> Model:
    """Return a figure's panels, side by side and with common axes where they share them.

    Lines, bands, bars, points and cells of a colour map are taken over, with titles, labels, scales and
    legends.
    """
    from bokeh.layouts import row

    bars = [axis for axis in figure.axes if axis.get_label() == _BAR]
    value = bars[0].get_ylabel() if bars else ""
    panels = [axis for axis in figure.axes if axis.get_label() != _BAR]
    plots: list[Any] = []
    for axis in panels:
        plot = _Panel(axis, value).draw()
        if bars and not axis.collections:  # of curves that have a colour each
            _add_colours(plot, value, *bars[0].get_ylim())
        if plots and axis.get_shared_x_axes().joined(axis, panels[0]):
            plot.x_range, plot.y_range = plots[0].x_range, plots[0].y_range
        plots.append(plot)
    return row(*plots, sizing_mode="stretch_width")


def _add_colours(plot: Plot, title: str, low: float, high: float) -> Any:
    """Add a colour bar, and return what gives a value its colour."""
    from bokeh.models import ColorBar, LinearColorMapper
    from bokeh.palettes import Viridis256

    colours = LinearColorMapper(Viridis256, low=low, high=high if high > low else low + 1.0)
    bar = ColorBar(color_mapper=colours, title=title, title_text_font_style="normal")
    plot.add_layout(bar, "right")
    return colours


class _Panel:
    """One of the axes of a figure."""

    def __init__(self, axis: Axes, value: str) -> None:
        self._axis, self._value = axis, value
        # a second panel of common axes has no label of its own
        self._labels = [axis.get_xlabel(), axis.get_ylabel()]

    def draw(self) -> Plot:
        """Return it as Bokeh draws it."""
        from bokeh.plotting import figure

        axis = self._axis
        plot = figure(
            height=_HEIGHT,
            sizing_mode="stretch_width",
            title=axis.get_title(loc="left") or None,
            x_axis_label=self._labels[0],
            y_axis_label=self._labels[1],
            x_axis_type=axis.get_xscale(),
            y_axis_type=axis.get_yscale(),
            x_range=axis.get_xlim(),
            y_range=axis.get_ylim(),
            tools="pan,box_zoom,wheel_zoom,reset,save",
            active_drag="box_zoom",
            active_scroll=None,
        )
        plot.toolbar.logo = None
        plot.grid.grid_line_color = "#ececec"
        plot.outline_line_color = None
        for side in plot.axis:
            side.axis_label_text_font_style = "normal"
        for collection in axis.collections:
            self._collection(plot, collection)
        for bar in self._bars():
            self._hover(plot, plot.quad(**bar), [("from", "left"), ("to", "right"), ("cases", "top")])
        for line in axis.lines:
            self._line(plot, line)
        if plot.legend:
            plot.legend.click_policy = "hide"
            plot.legend.background_fill_alpha = 0.7
            plot.add_layout(plot.legend[0], "above")
            plot.legend.orientation = "horizontal"
        return plot

    def _line(self, plot: Plot, line: Line2D) -> None:
        from bokeh.models import Span

        x, y = (np.asarray(v, dtype=float) for v in (line.get_xdata(), line.get_ydata()))
        colour = to_hex(line.get_color())
        if line.get_transform() != self._axis.transData:  # as of axvline
            dash = _DASHES[str(line.get_linestyle())]
            plot.add_layout(
                Span(location=float(x[0]), dimension="height", line_color=colour, line_dash=dash)
            )
            return
        kept = _telling(y)
        data = {"x": x[kept], "y": y[kept]}
        label = str(line.get_label())
        named = {} if label.startswith(_NAMELESS) else {"legend_label": label}
        rows = [("x", "x"), ("y", "y")]
        if line.get_linewidth() > 0:
            glyph = plot.line(**data, color=colour, line_width=line.get_linewidth(), **named)
            self._hover(plot, glyph, rows)
        if line.get_markersize() > 0 and line.get_marker() not in ("None", "", None):
            size = line.get_markersize() * 1.5
            self._hover(plot, plot.scatter(**data, color=colour, size=size, **named), rows)

    def _collection(self, plot: Plot, collection: Collection) -> None:
        if isinstance(collection, QuadMesh):
            corners = np.asarray(collection.get_coordinates())
            masked: np.ma.MaskedArray = np.ma.masked_invalid(np.ma.asarray(collection.get_array()))
            kept = ~np.ma.getmaskarray(masked)
            self._coloured(
                plot,
                plot.quad,
                {
                    "left": corners[:-1, :-1, 0][kept],
                    "right": corners[:-1, 1:, 0][kept],
                    "bottom": corners[:-1, :-1, 1][kept],
                    "top": corners[1:, :-1, 1][kept],
                },
                np.asarray(masked[kept]),
                ("left", "bottom"),
            )
        elif isinstance(collection, PathCollection):
            at = np.asarray(collection.get_offsets())
            values = np.asarray(collection.get_array())
            data = {"x": at[:, 0], "y": at[:, 1]}
            self._coloured(plot, plot.scatter, data, values, ("x", "y"), size=6)
        elif isinstance(collection, PolyCollection):
            colour = to_hex(np.asarray(collection.get_facecolor())[0])
            for path in collection.get_paths():
                edge = np.asarray(path.vertices)
                band = edge[_telling(edge[:, 1], 4 * _MOST)]
                plot.patch(band[:, 0], band[:, 1], color=colour, alpha=0.15, line_width=0)

    def _coloured(
        self,
        plot: Plot,
        draw: Any,
        data: dict[str, np.ndarray],
        values: np.ndarray,
        at: tuple[str, str],
        **style: Any,
    ) -> None:
        """Draw what has a value each, with a colour bar."""
        from bokeh.models import ColumnDataSource

        colours = _add_colours(plot, self._value, float(values.min()), float(values.max()))
        source = ColumnDataSource({**data, "value": values})
        shade = {"field": "value", "transform": colours}
        fields = {name: name for name in data}
        glyph = draw(**fields, source=source, fill_color=shade, line_color=None, **style)
        self._hover(plot, glyph, [("x", at[0]), ("y", at[1]), (self._value or "value", "value")])

    def _bars(self) -> Iterator[dict]:
        """Yield the bars of histograms, those of one colour together."""
        bars: dict[str, list[Rectangle]] = {}
        for patch in self._axis.patches:
            if isinstance(patch, Rectangle):
                bars.setdefault(to_hex(patch.get_facecolor()), []).append(patch)
        for colour, group in bars.items():
            left = np.array([bar.get_x() for bar in group])
            yield {
                "left": left,
                "right": left + [bar.get_width() for bar in group],
                "bottom": np.zeros(len(group)),
                "top": np.array([bar.get_height() for bar in group]),
                "fill_color": colour,
                "fill_alpha": 0.45,
                "line_color": None,
            }

    def _hover(self, plot: Plot, glyph: Any, rows: list[tuple[str, str]]) -> None:
        """Show values, those of the axes by their labels, which have the units."""
        from bokeh.models import HoverTool

        names = dict(zip(("x", "y"), self._labels, strict=True))
        tips = [(names.get(name) or name, f"@{column}{{%.6g}}") for name, column in rows]
        formats = {f"@{column}": "printf" for _, column in rows}
        plot.add_tools(
            HoverTool(
                renderers=[glyph], tooltips=tips, formatters=formats,
                point_policy="snap_to_data", line_policy="nearest",
            )
        )  # fmt: skip


def _telling(values: np.ndarray, most: int = _MOST) -> np.ndarray:
    """Return the places of so many values at most, the least and the greatest of every stretch."""
    if len(values) <= most:
        return np.arange(len(values))
    stretches = np.array_split(np.arange(len(values)), most // 2)
    known = np.where(np.isfinite(values), values, 0.0)
    ends = [[s[np.argmin(known[s])], s[np.argmax(known[s])]] for s in stretches]
    return np.unique([0, *np.ravel(ends), len(values) - 1])
