"""Reports of sweeps: figures that suit how the cases were chosen, from tables of any size."""

import json
import re

import numpy as np
import polars as pl
import pytest
from browser import Browser, needs_browser
from conftest import run_python
from matplotlib.collections import PathCollection, QuadMesh

from it2hys.sweeps import parse_sweep
from it2hys.sweeps.cases import make_plan
from it2hys.sweeps.plots import Columns, draw
from it2hys.sweeps.report import default_figures, write_sweep_report
from it2hys.sweeps.store import KEY, metadata

BASE = {
    "duration": 0.01,
    "fmu": {"plant": {"source": "IT2Plant"}},
    "signal": {"voltage": {"signal": "sine", "frequency": 50.0}},
    "connections": [{"from": "voltage", "to": "plant.voltage"}],
    "metric": [{"name": "top", "kind": "max", "of": "plant.displacement"}],
}
HIGH = {"name": "high", "of": "voltage.high", "range": [20.0, 100.0]}
FREQUENCY = {"name": "f", "of": "voltage.frequency", "range": [1.0, 400.0], "scale": "log"}
DRAWN = [{**HIGH, "method": "random"}, {**FREQUENCY, "method": "latin hypercube"}]


def grid(columns, rows):
    return [{**HIGH, "count": columns}, {**FREQUENCY, "count": rows}]


def make_table(path, vary, top=lambda high, _: 1e-7 * high, message=None, kept=0, **changes):
    """Write the table that a sweep would leave whose metric is a function of its axes."""
    table = {**BASE, "vary": vary, **changes}
    if kept:
        table |= {"keep": ["plant.displacement"], "duration": kept * 1e-4}
    plan = make_plan(parse_sweep(table))
    axes = {axis.name: plan.matrix[:, i] for i, axis in enumerate(plan.axes)}
    traces = {}
    if kept:
        shapes = np.outer(next(iter(axes.values())), np.linspace(0.0, 1e-7, kept))
        traces["plant.displacement"] = pl.Series(shapes).cast(pl.List(pl.Float64))
    frame = pl.DataFrame(
        {
            "case": np.arange(plan.cases),
            "variant": pl.Series([None] * plan.cases, dtype=pl.String),
            **axes,
            "top": top(*axes.values()),
            **traces,
            "status": ["ok"] * plan.cases,
            "warned": [False] * plan.cases,
            "out_of_range": [0] * plan.cases,
            "message": pl.Series([message] * plan.cases, dtype=pl.String),
        }
    )
    size = int(np.clip(16e6 // (8 * (kept + 4)), 1, 100_000))
    frame.write_parquet(path, row_group_size=size, metadata={KEY: json.dumps(metadata(plan))})
    return frame, Columns(pl.scan_parquet(path), metadata(plan))


def default_figure(columns):
    """Return the figure of the only metric, and what a mark of it is."""
    (entry,) = default_figures(columns.metadata)
    return draw(entry, columns)


def marks(figure, kind):
    return [c for c in figure.axes[0].collections if isinstance(c, kind)]


# --- figures -----------------------------------------------------------------------------------


def test_two_drawn_axes_are_points(tmp_path):
    """A heat map of a cell for each draw of either axis would be empty but for a diagonal."""
    frame, columns = make_table(tmp_path / "r.parquet", DRAWN, samples=2000)
    figure, text = default_figure(columns)
    (points,) = marks(figure, PathCollection)
    assert not marks(figure, QuadMesh)
    np.testing.assert_allclose(points.get_offsets(), frame.select("high", "f").to_numpy())
    np.testing.assert_allclose(points.get_array(), frame["top"] * 1e6)
    assert text == "A point is a case."
    axis, bar = figure.axes
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("high in V", "f in Hz")
    assert (axis.get_xscale(), axis.get_yscale()) == ("linear", "log")
    assert bar.get_ylabel() == "top in µm"


def test_more_draws_than_can_be_told_apart_are_means_over_cells(tmp_path):
    def top(high, f):
        return 1e-7 * high + 1e-6 * np.log10(f)

    frame, columns = make_table(tmp_path / "r.parquet", DRAWN, top, samples=40_000)
    figure, text = default_figure(columns)
    (mesh,) = marks(figure, QuadMesh)
    rows, cells = mesh.get_array().shape
    assert 20 <= rows <= 100 and 20 <= cells <= 100
    assert mesh.get_array().count() > 0.99 * rows * cells
    corners = np.asarray(mesh.get_coordinates())
    assert corners[0, 0] == pytest.approx([frame["high"].min(), frame["f"].min()])
    assert corners[-1, -1] == pytest.approx([frame["high"].max(), frame["f"].max()])
    middle = corners[rows // 2 : rows // 2 + 2, cells // 2 : cells // 2 + 2].reshape(4, 2)
    (low, bottom), (high, upper) = middle.min(axis=0), middle.max(axis=0)
    inside = frame.filter(pl.col("high").is_between(low, high) & pl.col("f").is_between(bottom, upper))
    expected = inside["top"].mean() * 1e6
    assert mesh.get_array()[rows // 2, cells // 2] == pytest.approx(expected)
    assert figure.axes[1].get_ylabel() == "mean top in µm" and "mean" in text


def test_a_grid_is_its_cells(tmp_path):
    _, columns = make_table(tmp_path / "r.parquet", grid(7, 5), lambda high, f: 1e-9 * high * f)
    figure, _ = default_figure(columns)
    (mesh,) = marks(figure, QuadMesh)
    high, f = np.linspace(20, 100, 7), np.geomspace(1, 400, 5)
    np.testing.assert_allclose(mesh.get_array(), 1e-3 * np.outer(f, high))
    assert figure.axes[0].get_yscale() == "log"
    assert figure.axes[1].get_ylabel() == "top in µm"


def test_a_grid_with_more_lines_than_pixels_has_cells_of_several(tmp_path):
    _, columns = make_table(tmp_path / "r.parquet", grid(401, 3))
    figure, _ = default_figure(columns)
    (mesh,) = marks(figure, QuadMesh)
    assert mesh.get_array().shape == (3, 134) and not np.ma.is_masked(mesh.get_array())
    np.testing.assert_allclose(mesh.get_array()[0, :2], [2.02, 2.08], rtol=1e-9)


def test_a_grid_crossed_with_draws_is_its_cells(tmp_path):
    vary = [{**HIGH, "count": 4}, {**FREQUENCY, "method": "random"}]
    _, columns = make_table(tmp_path / "r.parquet", vary, samples=30)
    figure, _ = default_figure(columns)
    (mesh,) = marks(figure, QuadMesh)
    assert mesh.get_array().shape == (30, 4) and not np.ma.is_masked(mesh.get_array())


def test_a_figure_of_one_axis_follows_its_scale(tmp_path):
    _, columns = make_table(tmp_path / "r.parquet", [{**FREQUENCY, "count": 9}], lambda f: 1e-7 * f)
    figure, _ = default_figure(columns)
    assert figure.axes[0].get_xscale() == "log" and figure.axes[0].get_xlabel() == "f in Hz"
    (line,) = figure.axes[0].lines
    np.testing.assert_allclose(line.get_xdata(), np.geomspace(1, 400, 9))


def test_a_scale_that_the_values_cannot_have_is_linear(tmp_path):
    vary = [{"name": "f", "of": "plant.force", "values": [0.0, 1.0, 10.0], "scale": "log"}]
    _, columns = make_table(tmp_path / "r.parquet", vary, lambda f: 1e-7 * f)
    figure, _ = default_figure(columns)
    assert figure.axes[0].get_xscale() == "linear"


LINES = {"kind": "lines", "title": "", "x": "f", "value": "top", "by": "", "select": {},
         "x_scale": "log", "y_scale": "linear"}  # fmt: skip


def test_a_line_has_no_more_points_than_a_picture(tmp_path):
    """Neighbours share one; the band shows how they differ, which is by the other column."""
    _, columns = make_table(tmp_path / "r.parquet", DRAWN, samples=20_000)
    figure, _ = draw(LINES, columns)
    (line,) = figure.axes[0].lines
    assert len(line.get_xdata()) == 1000
    assert np.median(line.get_ydata()) == pytest.approx(6.0, rel=0.02)
    band = figure.axes[0].collections[0].get_paths()[0].get_extents()
    assert band.ymin < 4.0 and band.ymax > 8.0


def test_draws_among_others_are_points_of_a_line_and_not_joined(tmp_path):
    _, columns = make_table(tmp_path / "r.parquet", DRAWN, samples=500)
    figure, _ = draw(LINES, columns)
    (line,) = figure.axes[0].lines
    assert len(line.get_xdata()) == 500
    assert line.get_linewidth() == 0 and line.get_markersize() > 0


def test_a_legend_names_lines_that_can_be_told_apart(tmp_path):
    _, columns = make_table(tmp_path / "r.parquet", grid(50, 3))
    figure, text = draw({**LINES, "by": "high"}, columns)
    labels = figure.axes[0].get_legend_handles_labels()[1]
    assert len(labels) == 8 and labels[0] == "high 20" and labels[-1] == "high 100"
    assert "8 of the 50 values of high are drawn" in text


def test_a_family_says_how_many_of_its_cases_are_drawn(tmp_path):
    frame, columns = make_table(tmp_path / "r.parquet", DRAWN, samples=300, kept=20)
    entry = {
        **LINES,
        "kind": "time course",
        "value": "plant.displacement",
        "by": "f",
        "x_scale": "linear",
    }
    figure, text = draw(entry, columns)
    assert "40 of 300 are drawn" in text
    traces = frame.sort("f")["plant.displacement"]
    first, last = (figure.axes[0].lines[i].get_ydata() for i in (0, -1))
    np.testing.assert_allclose(first, traces[0].to_numpy() * 1e6)
    np.testing.assert_allclose(last, traces[-1].to_numpy() * 1e6)


# --- the page ----------------------------------------------------------------------------------


def test_messages_are_whole_and_counted_one_by_one(tmp_path):
    """Two of a case are two rows; one that is longer than a page takes ends with a word."""
    long = "inverse (Model): " + "stretch " * 200
    said = (
        f"plant (IT2Plant): fmi2DoStep to 0.0012 s: beyond 2.5e-05 m | {long} | plant (IT2Plant): again"
    )
    make_table(tmp_path / "r.parquet", [{**FREQUENCY, "count": 9}], lambda f: f, said)
    report, counts = write_sweep_report(tmp_path / "r.parquet", tmp_path)
    page = report.read_text(encoding="utf-8")
    cells = re.findall(r"<tr><td[^>]*>(.*?)</td><td[^>]*>(\d+)</td><td[^>]*>(\d+)</td></tr>", page)
    assert counts.failed == 0
    assert {text for text, *_ in cells if len(text) < 100} == {
        "plant (IT2Plant): fmi2DoStep to … s: beyond … m",
        "plant (IT2Plant): again",
    }
    assert {tuple(numbers) for _, *numbers in cells} == {("9", "0")}
    (cut,) = [text for text, *_ in cells if len(text) > 100]
    assert 550 < len(cut) < 610 and cut.endswith("stretch …") and cut.startswith("inverse (Model): ")


@needs_browser
def test_every_kind_of_figure_can_be_looked_into(tmp_path):
    """Points, cells, lines with bands, bars and curves are drawn from what matplotlib was given."""
    (tmp_path / "drawn").mkdir()
    (tmp_path / "grid").mkdir()
    trace = {"kind": "time course", "value": "plant.displacement", "by": "f"}
    line = {k: v for k, v in LINES.items() if k != "by"}
    bars = {"kind": "distribution", "value": "top"}
    points = {"kind": "heat map", "x": "high", "y": "f", "value": "top", "y_scale": "log"}
    frame, _ = make_table(
        tmp_path / "drawn/r.parquet", DRAWN, samples=500, kept=20, figure=[points, line, bars, trace]
    )
    make_table(tmp_path / "grid/r.parquet", grid(4, 3), figure=[points, line])
    counts = """Bokeh.documents.map((d) => Array.from(d._all_models.values())
      .filter((m) => m.type === "GlyphRenderer")
      .map((m) => m.glyph.type + " " + m.data_source.get_length()))"""
    with Browser() as browser:
        for name, expected in (
            ("drawn", [{"Scatter 500"}, {"Scatter 500"}, {"Quad"}, {"Line 20"}]),
            ("grid", [{"Quad 12"}, {"Line 3", "Patch"}]),
        ):
            write_sweep_report(tmp_path / name / "r.parquet", tmp_path / name)
            browser.open(tmp_path / name / "report.html")
            browser.run("document.querySelectorAll('details').forEach((d) => { d.open = true; }); 0")
            browser.until(f"window.Bokeh && Bokeh.documents.length === {len(expected)}")
            browser.until("Bokeh.documents.every((d) => d.is_idle)")
            for found, kinds in zip(browser.run(counts), expected, strict=True):
                assert all(any(f.startswith(kind) for f in found) for kind in kinds), (found, kinds)
            assert browser.errors == []
    report = json.loads((tmp_path / "drawn/report.json").read_text(encoding="utf-8"))
    assert report["axes"][0]["high"] == pytest.approx(frame["high"].max())


MEASURE = """
import resource, sys
# the cells of a heat map of all draws would need 13 GB
resource.setrlimit(resource.RLIMIT_AS, (8 * 10**9, 8 * 10**9))
from it2hys.cli import main
assert main(["sweep", sys.argv[1], "-o", sys.argv[2], "--quiet"]) == 0
# not ru_maxrss, which begins with that of the process that made this one
print(int(open("/proc/self/status").read().split("VmHWM:")[1].split()[0]) / 1024)
"""


@pytest.mark.parametrize(("cases", "kept"), [(40_000, 200), (1_000_000, 0)])
def test_the_memory_of_a_report_is_bounded(cases, kept, tmp_path):
    """Drawn again by the command; both took or would have taken more than a machine has."""
    path = tmp_path / "results.parquet"
    message = "plant (IT2Plant): fmi2DoStep to 0.0001 s: the voltage left its range" if kept else None
    figures = {}
    if kept:
        trace = {"kind": "time course", "value": "plant.displacement", "by": "f"}
        map_ = {"kind": "heat map", "x": "high", "y": "f", "value": "top", "y_scale": "log"}
        figures = {"figure": [trace, map_, {k: v for k, v in LINES.items() if k != "by"}]}
    make_table(path, DRAWN, message=message, kept=kept, samples=cases, **figures)
    peak = float(run_python(MEASURE, path, tmp_path / "again"))
    print(f"{cases} cases, {path.stat().st_size / 1e6:.0f} MB: {peak:.0f} MB at most")
    assert peak < 700
    assert len(list((tmp_path / "again").glob("figure_*.png"))) == (3 if kept else 1)
