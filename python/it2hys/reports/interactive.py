"""Interactive figures: zoom, pan, hover, selection; drawn by Bokeh in the browser, without a network.

Bokeh ships its script in its wheel, and the page carries it along. It is imported when a page is
drawn, as it takes a while.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy as np

from it2hys.reports.courses import Course

if TYPE_CHECKING:
    from bokeh.models import Model, Plot

UM = 1e6
#: The colours of the PNGs.
MEASURED, BEFORE, AFTER, NOISE = "#8a8a8a", "#d95f02", "#1f77b4", "#444444"
#: Samples of each signal that are drawn at first; a zoom draws more.
_FIRST = 3000
_TOOLS = "xpan,pan,box_zoom,xbox_zoom,wheel_zoom,box_select,reset,save"


@cache
def script() -> str:
    """Return Bokeh's script, for a page that works without a network."""
    from bokeh.resources import Resources

    return "\n".join(Resources(mode="inline", components=["bokeh", "bokeh-widgets"]).js_raw)


def as_json(model: Model) -> str:
    """Return a figure for `Bokeh.embed.embed_item`, safe within a script element."""
    from bokeh.embed import json_item

    return json.dumps(json_item(model)).replace("</", "<\\/")


def _code(name: str) -> str:
    return resources.files("it2hys.reports").joinpath("templates", name).read_text(encoding="utf-8")


def record_view(course: Course, names: Mapping[str, str], noise: float) -> Model:
    """Return the view of a record: three courses of time, the inverse, the loop and the spectrum.

    Parameters
    ----------
    course : Course
    names : Mapping of str to str
        What the models "before" and "after" are called.
    noise : float
        m rms.
    """
    return _View(course, names, noise).layout()


class _View:
    """The figures of one record, which share their samples, their time axis and what is selected."""

    def __init__(self, course: Course, names: Mapping[str, str], noise: float) -> None:
        from bokeh.models import ColumnDataSource, Range1d

        self._course, self._names, self._noise = course, names, noise * UM
        columns = {
            "t": course.time.astype(float),
            "u": course.voltage,
            "y": course.measured * UM,
            "b": course.before * UM,
            "a": course.after * UM,
            "eb": course.error_before * UM,
            "ea": course.error_after * UM,
            "ib": course.inverse_before,
            "ia": course.inverse_after,
        }
        columns = {n: v if n == "t" else v.astype(np.float32) for n, v in columns.items()}
        self._full = ColumnDataSource(columns, tags=[[]])
        places = np.unique(np.linspace(0, len(course.time) - 1, _FIRST).astype(int))
        self._shown = ColumnDataSource(
            {n: v[places] for n, v in columns.items()} | {"place": places.astype(np.int32)}
        )
        low, high = float(course.time[0]), float(course.time[-1])
        self._time = Range1d(low, high, bounds=(low, high))
        self._lines: dict[str, list] = {"measured": [], "before": [], "after": []}

    def layout(self) -> Model:
        """Return the view."""
        from bokeh.layouts import column, gridplot, row
        from bokeh.models import CustomJS

        inverse = bool(np.any(np.isfinite(self._course.inverse_after)))
        over_time = [self._voltage(), self._displacement(), self._errors("error in µm", "eb", "ea")]
        if inverse:
            over_time.append(self._errors("inverse less applied, V", "ib", "ia", is_last=True))
        self._label_last(over_time)
        loop = self._loop()
        view = CustomJS(
            args={"full": self._full, "shown": self._shown, "range": self._time, "plot": over_time[0]},
            code=_code("view.js"),
        )
        for end in ("start", "end"):
            self._time.js_on_change(end, view)
        over_time[0].js_on_change("inner_width", view)
        keep = CustomJS(args={"full": self._full, "shown": self._shown}, code=_code("select.js"))
        self._shown.selected.js_on_change("indices", keep)
        shared = {"sizing_mode": "stretch_width", "toolbar_location": "above"}
        left = gridplot([[p] for p in over_time], merge_tools=True, **shared)
        right = column(loop, self._spectrum(), sizing_mode="stretch_width")
        left.styles, right.styles = {"flex": "3 1 30rem"}, {"flex": "2 1 22rem"}
        both = row(left, right, sizing_mode="stretch_width", styles={"flex-wrap": "wrap"})
        return column(self._toggle(), both, sizing_mode="stretch_width")

    def _toggle(self) -> Model:
        """Return what shows and hides the measurement, and the models before and after."""
        from bokeh.models import CheckboxButtonGroup, CustomJS

        kinds = list(self._lines)
        labels = ["measured", f"before: {self._names['before']}", f"now: {self._names['after']}"]
        buttons = CheckboxButtonGroup(labels=labels, active=[0, 1, 2], name="toggle")
        code = (
            "lines.forEach((group, i) => "
            "group.forEach((line) => { line.visible = buttons.active.includes(i); }));"
        )
        arguments = {"lines": [self._lines[k] for k in kinds], "buttons": buttons}
        buttons.js_on_change("active", CustomJS(args=arguments, code=code))
        return buttons

    def _figure(self, name: str, label: str, height: int, **options: Any) -> Plot:
        from bokeh.plotting import figure

        plot = figure(
            name=name,
            height=height,
            sizing_mode="stretch_width",
            tools=_TOOLS,
            active_drag="box_zoom",
            active_scroll=None,
            y_axis_label=label,
            min_border_left=64,
            **options,
        )
        plot.toolbar.logo = None
        plot.grid.grid_line_color = "#ececec"
        plot.outline_line_color = None
        for axis in plot.axis:
            axis.axis_label_text_font_style = "normal"
        return plot

    def _over_time(self, name: str, label: str, height: int) -> Plot:
        plot = self._figure(name, label, height, x_range=self._time)
        plot.xaxis.visible = False
        return plot

    @staticmethod
    def _label_last(plots: Sequence[Plot]) -> None:
        plots[-1].xaxis.visible = True
        plots[-1].xaxis.axis_label = "time in s"
        plots[-1].height += 40

    def _line(self, plot: Plot, kind: str, column: str, **style: Any) -> Any:
        """Draw a signal over time, and the samples of it that are selected."""
        colour = {"measured": MEASURED, "before": BEFORE, "after": AFTER}[kind]
        width = 2.4 if kind == "measured" else 1.2
        line = plot.line("t", column, source=self._shown, color=colour, line_width=width, **style)
        self._lines[kind] += [line, self._marks(plot, "t", column, colour)]
        return line

    def _marks(
        self, plot: Plot, x: str, y: str, colour: str, alpha: float = 0.0, size: float = 2.5
    ) -> Any:
        """Draw samples, faint or not at all, but for those that are selected."""
        return plot.scatter(
            x, y, source=self._shown, size=size, color=colour, alpha=alpha,
            selection_alpha=1.0, selection_color=colour, nonselection_alpha=0.25 * alpha,
        )  # fmt: skip

    def _voltage(self) -> Plot:
        plot = self._over_time("voltage", "voltage in V", 130)
        line = plot.line("t", "u", source=self._shown, color="#555555", line_width=1.2)
        self._marks(plot, "t", "u", "#555555")
        self._hover(plot, line, [("time", "t", "s"), ("voltage", "u", "V")])
        return plot

    def _displacement(self) -> Plot:
        plot = self._over_time("displacement", "displacement in µm", 210)
        line = self._line(plot, "measured", "y")
        for kind, column in (("before", "b"), ("after", "a")):
            self._line(plot, kind, column)
        self._hover(plot, line, self._all_figures())
        return plot

    def _all_figures(self) -> list[tuple[str, str, str]]:
        return [
            ("time", "t", "s"),
            ("voltage", "u", "V"),
            ("measured", "y", "µm"),
            (f"before: {self._names['before']}", "b", "µm"),
            (f"now: {self._names['after']}", "a", "µm"),
            ("error before", "eb", "µm"),
            ("error now", "ea", "µm"),
        ]

    def _errors(self, label: str, before: str, after: str, is_last: bool = False) -> Plot:
        from bokeh.models import BoxAnnotation

        plot = self._over_time("inverse" if is_last else "error", label, 150)
        if not is_last and self._noise > 0.0:
            band = 2.0 * self._noise
            plot.add_layout(BoxAnnotation(bottom=-band, top=band, fill_color=NOISE, fill_alpha=0.08))
        self._line(plot, "before", before)
        line = self._line(plot, "after", after)
        unit = "V" if is_last else "µm"
        rows = [("time", "t", "s"), ("before", before, unit), ("now", after, unit)]
        self._hover(plot, line, rows)
        return plot

    def _loop(self) -> Plot:
        plot = self._figure("loop", "displacement in µm", 340, x_axis_label="voltage in V")
        for kind, column, colour in (
            ("measured", "y", MEASURED), ("before", "b", BEFORE), ("after", "a", AFTER),
        ):  # fmt: skip
            # the measurement lies behind, and is broad enough to be seen
            size = 5.0 if kind == "measured" else 2.5
            marks = self._marks(plot, "u", column, colour, 0.7, size)
            self._lines[kind].append(marks)
            if kind == "measured":
                self._hover(plot, marks, self._all_figures(), "mouse")
        return plot

    def _spectrum(self) -> Plot:
        from bokeh.models import ColumnDataSource, Span

        course = self._course
        source = ColumnDataSource(
            {
                "f": course.frequency,
                "b": course.spectrum_before * UM,
                "a": course.spectrum_after * UM,
            }
        )
        plot = self._figure(
            "spectrum",
            "error in µm/√Hz",
            250,
            x_axis_type="log",
            y_axis_type="log",
            x_axis_label="frequency in Hz",
        )
        for kind, column, colour in (("before", "b", BEFORE), ("after", "a", AFTER)):
            line = plot.line("f", column, source=source, color=colour, line_width=1.2)
            self._lines[kind].append(line)
        if self._noise > 0.0:
            # of white noise of that size, up to the Nyquist frequency
            density = self._noise / float(np.sqrt(course.frequency[-1]))
            plot.add_layout(
                Span(dimension="width", location=density, line_color=NOISE, line_dash="dotted")
            )
        rows = [("frequency", "f", "Hz"), ("before", "b", "µm/√Hz"), ("now", "a", "µm/√Hz")]
        self._hover(plot, line, rows)
        return plot

    @staticmethod
    def _hover(
        plot: Plot, renderer: Any, rows: Sequence[tuple[str, str, str]], mode: str = "vline"
    ) -> None:
        """Show values with units at the pointer."""
        from bokeh.models import HoverTool

        tips = [(name, f"@{column}{{%.6g}} {unit}") for name, column, unit in rows]
        formats = {f"@{column}": "printf" for _, column, _ in rows}
        plot.add_tools(
            HoverTool(
                renderers=[renderer], tooltips=tips, formatters=formats, mode=mode,
                point_policy="snap_to_data", line_policy="nearest", attachment="horizontal",
            )
        )  # fmt: skip
