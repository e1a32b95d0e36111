"""Figures as a control engineer would put them in a paper.

Every function returns a matplotlib figure; lengths are drawn in µm, the error always on an axis of
its own. Long records are thinned to what the picture can show, extremes kept.
"""

import textwrap
from io import BytesIO
from typing import Any, NamedTuple

import matplotlib

matplotlib.use("Agg")

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from it2hys.reports.courses import amplitude_density

# broad and pale: what lies on it does not hide it
MEASURED: dict[str, Any] = {"color": "0.72", "linewidth": 2.6, "solid_capstyle": "round"}
MODEL: dict[str, Any] = {"color": "#1f77b4", "linewidth": 1.1}
SECOND: dict[str, Any] = {"color": "#d95f02", "linewidth": 1.1, "linestyle": "--"}
NOISE: dict[str, Any] = {"color": "0.6", "linewidth": 0.8, "linestyle": ":"}
STYLE: Any = {
    "font.size": 9,
    "axes.grid": True,
    "grid.color": "0.92",
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
    "figure.dpi": 160,
}
_BEFORE: dict[str, Any] = {"color": "#d95f02", "linewidth": 0.9}
_AFTER: dict[str, Any] = {"color": "#1f77b4", "linewidth": 0.9}
_RISING: dict[str, Any] = {"color": "#b2182b", "linestyle": "none", "marker": ".", "markersize": 1.2}
_FALLING: dict[str, Any] = {"color": "#2166ac", "linestyle": "none", "marker": ".", "markersize": 1.2}
_HELD: dict[str, Any] = {"color": "0.55", "linestyle": "none", "marker": ".", "markersize": 1.2}
_FLOOR: dict[str, Any] = {"color": "0.2", "linewidth": 1.0, "linestyle": ":", "zorder": 3}
LARGEST_COUNT = 20_000
#: Characters on a line of a legend within small axes.
_LEGEND_WIDTH = 18
UM = 1e6

_styled = matplotlib.rc_context(STYLE)


def png(figure: Figure) -> bytes:
    """Return a figure as PNG."""
    buffer = BytesIO()
    with matplotlib.rc_context(STYLE):
        # `savefig` would draw it twice
        FigureCanvasAgg(figure).print_png(buffer)  # type: ignore[no-untyped-call]
    return buffer.getvalue()


def _figure(
    rows: list[float], width: float = 6.4, height: float = 4.4, **options: Any
) -> tuple[Figure, np.ndarray]:
    """Return a figure with stacked axes of the given relative heights."""
    figure = Figure(figsize=(width, height))
    axes = figure.subplots(len(rows), 1, height_ratios=rows, squeeze=False, **options)[:, 0]
    return figure, axes


def _title(figure: Figure, title: str) -> None:
    """Put the title on a line of its own, flush left."""
    figure.suptitle(title, x=0.01, horizontalalignment="left", fontsize=11)


def _legend(axis: Axes) -> None:
    """Put the legend above the axes, where it hides no data."""
    axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1)


def _thin(*signals: np.ndarray) -> list[np.ndarray]:
    """Keep the least and the greatest of every run of samples of the first signal."""
    count = len(signals[0])
    if count <= LARGEST_COUNT:
        return list(signals)
    blocks = np.array_split(np.arange(count), LARGEST_COUNT // 2)
    kept = [b[i] for b in blocks for i in sorted((signals[0][b].argmin(), signals[0][b].argmax()))]
    return [s[kept] for s in signals]


@_styled
def time_course(
    time: np.ndarray,
    measured: np.ndarray,
    models: dict[str, np.ndarray],
    title: str,
    noise: float | None = None,
) -> Figure:
    """Draw displacement and error over time (the paper's Figures 2, 4 and 5).

    Parameters
    ----------
    time : ndarray, shape (N,)
        In s.
    measured : ndarray, shape (N,)
        In m.
    models : dict of str to ndarray, shape (N,)
        Predictions in m by their name in the legend, at most two.
    title : str
        Says which record and signal this is.
    noise : float, optional
        Noise floor in m rms, drawn as a band of two standard deviations.
    """
    figure, (top, bottom) = _figure([2, 1], sharex=True)
    measured_t, measured_y = _thin(measured, time)[::-1]
    top.plot(measured_t, measured_y * UM, label="measured", **MEASURED)
    # the second lies behind the first
    for (name, y), style in list(zip(models.items(), (MODEL, SECOND), strict=False))[::-1]:
        y_thin, t_thin = _thin(y, time)
        top.plot(t_thin, y_thin * UM, label=name, **style)
        e_thin, t_thin = _thin(measured - y, time)
        bottom.plot(t_thin, e_thin * UM, **{**style, "linewidth": 0.8})
    if noise:
        for bound in (-2 * noise * UM, 2 * noise * UM):
            bottom.axhline(bound, **NOISE)
        bottom.plot([], [], label="noise, ±2 std", **NOISE)
    _title(figure, title)
    top.set(ylabel="displacement in µm")
    bottom.set(xlabel="time in s", ylabel="error in µm")
    _legend(top)
    if noise:
        _legend(bottom)
    return figure


@_styled
def inverse_course(
    time: np.ndarray,
    applied: np.ndarray,
    asked: dict[str, np.ndarray],
    gain: float,
    title: str,
) -> Figure:
    """Draw the voltage that was applied, what inverses ask for, and the difference as displacement.

    Parameters
    ----------
    time : ndarray, shape (N,)
        In s.
    applied : ndarray, shape (N,)
        In V.
    asked : dict of str to ndarray, shape (N,)
        In V by its name in the legend, at most two; NaN where nothing is judged.
    gain : float
        Displacement by voltage, m/V.
    title : str
        Says which record this is.
    """
    figure, (top, bottom) = _figure([2, 1], sharex=True)
    applied_t, applied_v = _thin(applied, time)[::-1]
    top.plot(applied_t, applied_v, label="applied", **MEASURED)
    for (name, voltage), style in list(zip(asked.items(), (MODEL, SECOND), strict=False))[::-1]:
        known = np.isfinite(voltage)
        v_thin, t_thin = _thin(voltage[known], time[known])
        top.plot(t_thin, v_thin, label=f"inverse {name}".rstrip(), **style)
        e_thin, t_thin = _thin(gain * (voltage - applied)[known], time[known])
        bottom.plot(t_thin, e_thin * UM, **{**style, "linewidth": 0.8})
    _title(figure, title)
    top.set(ylabel="voltage in V")
    bottom.set(xlabel="time in s", ylabel="difference in µm")
    _legend(top)
    return figure


@_styled
def hysteresis_loop(
    voltage: np.ndarray, measured: np.ndarray, models: dict[str, np.ndarray], title: str
) -> Figure:
    """Draw displacement and error over voltage, both branches (the paper's Figure 3).

    Parameters
    ----------
    voltage : ndarray, shape (N,)
        In V.
    measured : ndarray, shape (N,)
        In m.
    models : dict of str to ndarray, shape (N,)
        Predictions in m by their name in the legend, at most two; the error drawn is the first's.
    title : str
        Says which record and signal this is.
    """
    figure, (top, bottom) = _figure([2, 1], height=5.0, sharex=True)
    top.plot(voltage, measured * UM, label="measured", **MEASURED)
    for (name, y), style in list(zip(models.items(), (MODEL, SECOND), strict=False))[::-1]:
        top.plot(voltage, y * UM, label=name, **style)
    first = next(iter(models))
    error = (measured - models[first]) * UM
    rising = np.gradient(voltage) >= 0
    for branch, label, style in (
        (rising, "rising voltage", {"color": _RISING["color"], "linewidth": 0.8}),
        (~rising, "falling voltage", {"color": _FALLING["color"], "linewidth": 0.8}),
    ):
        bottom.plot(voltage, np.where(branch, error, np.nan), label=label, **style)
    _title(figure, title)
    top.set(ylabel="displacement in µm")
    bottom.set(xlabel="voltage in V", ylabel=f"error {first} in µm")
    _legend(top)
    _legend(bottom)
    return figure


@_styled
def tracking(
    time: np.ndarray,
    reference: np.ndarray,
    courses: dict[str, np.ndarray],
    voltage: np.ndarray,
    title: str,
) -> Figure:
    """Draw reference, displacement, error and voltage of a tracking run (the paper's Figure 7).

    Parameters
    ----------
    time : ndarray, shape (N,)
        In s.
    reference : ndarray, shape (N,)
        In m.
    courses : dict of str to ndarray, shape (N,)
        Displacements in m by the name of what drove them, at most two.
    voltage : ndarray, shape (N,)
        Of the first course, in V.
    title : str
        Says what is tracked.
    """
    figure, (top, middle, bottom) = _figure([2, 1, 1], height=5.6, sharex=True)
    top.plot(time, reference * UM, label="reference", **MEASURED)
    for (name, y), style in zip(courses.items(), (MODEL, SECOND), strict=False):
        top.plot(time, y * UM, label=name, **style)
        middle.plot(time, (reference - y) * UM, label=name, **style)
    bottom.plot(time, voltage, **MODEL)
    _title(figure, title)
    top.set(ylabel="displacement in µm")
    middle.set(ylabel="error in µm")
    bottom.set(xlabel="time in s", ylabel="voltage in V")
    _legend(top)
    return figure


class Compared(NamedTuple):
    """What is measured or wanted, and what two models make of it; s, V and m, all of shape (N,).

    `title` says what the errors are of.
    """

    title: str
    time: np.ndarray
    voltage: np.ndarray
    target: np.ndarray
    before: np.ndarray
    after: np.ndarray


@_styled
def overview(record: Compared, tracked: Compared | None, names: tuple[str, str]) -> Figure:
    """Draw in one figure what a diagnosis brought: the loop, the model's error, the tracking error.

    Parameters
    ----------
    record : Compared
        Its loop and its errors are drawn.
    tracked : Compared or None
        A reference and what followed it: its errors are drawn, on the scale of the record's.
    names : (str, str)
        Of the models before and after, in the legend.
    """
    shown = [record, tracked] if tracked else [record]
    figure = Figure(figsize=(6.4, 2.2 * len(shown) + 0.8))
    grid = figure.add_gridspec(len(shown), 2)
    loop = figure.add_subplot(grid[:, 0])
    errors = [figure.add_subplot(grid[row, 1]) for row in range(len(shown))]
    loop.plot(*_thin(record.target * UM, record.voltage)[::-1], label="measured", **MEASURED)
    for when, name, style in zip(("before", "after"), names, (_BEFORE, _AFTER), strict=True):
        label = textwrap.fill(name, _LEGEND_WIDTH)
        loop.plot(*_thin(getattr(record, when) * UM, record.voltage)[::-1], label=label, **style)
        for axis, compared in zip(errors, shown, strict=True):
            error = (compared.target - getattr(compared, when)) * UM
            axis.plot(*_thin(error, compared.time)[::-1], **style)
    loop.set(xlabel="voltage in V", ylabel="displacement in µm")
    loop.set_title("Hysteresis loop", loc="left", fontsize=10)
    loop.legend(loc="upper left", borderaxespad=0.1, handlelength=1.2, fontsize=8)
    for axis, compared in zip(errors, shown, strict=True):
        axis.set(xlabel="time in s", ylabel="error in µm")
        axis.set_title(compared.title, loc="left", fontsize=10)
        axis.locator_params(axis="x", nbins=5)
        axis.sharey(errors[0])
    return figure


@_styled
def designed_record(
    time: np.ndarray,
    voltage: np.ndarray,
    readings: dict[str, np.ndarray],
    left: dict[str, np.ndarray],
    noise: float,
) -> Figure:
    """Draw a record to play: voltage, its spectrum, what models read on it and what is left of that.

    Parameters
    ----------
    time, voltage : ndarray, shape (N,)
        In s and V.
    readings : dict of str to ndarray, shape (N,)
        Displacements of the models in m, by their names.
    left : dict of str to ndarray, shape (N,)
        What a model leaves of another's readings once it is refitted to them, m, by what it is.
    noise : float
        In m rms: a band of two standard deviations.
    """
    figure = Figure(figsize=(6.4, 7.6 if left else 5.8))
    axes = figure.subplots(4 if left else 3, 1)
    axes[0].plot(time, voltage, **MODEL)
    axes[0].set(xlabel="time in s", ylabel="voltage in V")
    axes[0].set_title("Voltage to play", loc="left", fontsize=10)
    frequency, density = amplitude_density(voltage, float(time[1] - time[0]))
    axes[1].loglog(frequency, density, **MODEL)
    axes[1].set(xlabel="frequency in Hz", ylabel="V/√Hz")
    axes[1].set_title("Its spectrum", loc="left", fontsize=10)
    for name, y in readings.items():
        axes[2].plot(time, y * UM, linewidth=0.9, label=name)
    axes[2].set(xlabel="time in s", ylabel="displacement in µm")
    axes[2].set_title("What the models predict", loc="left", fontsize=10)
    axes[2].sharex(axes[0])
    _legend(axes[2])
    if left:
        for name, y in left.items():
            axes[3].plot(time, y * UM, linewidth=0.7, label=name)
        axes[3].axhspan(-2e6 * noise, 2e6 * noise, color="0.85", zorder=0, label="noise, ±2σ")
        axes[3].set(xlabel="time in s", ylabel="difference in µm")
        axes[3].set_title("Difference after the refit", loc="left", fontsize=10)
        axes[3].sharex(axes[0])
        columns = 2 if len(left) < 4 else 3
        axes[3].legend(loc="upper center", bbox_to_anchor=(0.5, -0.35), ncols=columns, fontsize=7)
    return figure


@_styled
def residual_views(
    time: np.ndarray,
    voltage: np.ndarray,
    before: np.ndarray,
    after: np.ndarray,
    noise: float,
    sample_time: float,
    title: str,
) -> Figure:
    """Draw what is left over before and after a step of the diagnosis: by time, voltage, frequency.

    Parameters
    ----------
    time, voltage : ndarray, shape (N,)
        In s and V.
    before, after : ndarray, shape (N,)
        Residuals in m; NaN where the reading cannot be trusted.
    noise : float
        Noise floor in m rms: a band of two standard deviations, and the density of white noise.
    sample_time : float
        In s.
    title : str
        Says which record and which step this is.
    """
    figure = Figure(figsize=(7.2, 6.8))
    grid = figure.add_gridspec(3, 2, height_ratios=[1.0, 1.1, 1.1])
    course, spectrum = figure.add_subplot(grid[0, :]), figure.add_subplot(grid[2, :])
    loops = [figure.add_subplot(grid[1, 0])]
    loops.append(figure.add_subplot(grid[1, 1], sharex=loops[0], sharey=loops[0]))
    rate = np.gradient(voltage)
    held = np.abs(rate) <= 1e-6 * np.ptp(voltage)
    branches = (
        (held, "held", _HELD),
        (~held & (rate > 0.0), "rising", _RISING),
        (~held & (rate < 0.0), "falling", _FALLING),
    )
    # what is larger lies behind
    for name, residual, style, loop in (
        ("before", before, _BEFORE, loops[0]),
        ("after", after, _AFTER, loops[1]),
    ):
        residual_thin, time_thin = _thin(residual * UM, time)
        course.plot(time_thin, residual_thin, label=name, **style)
        frequency, density = amplitude_density(residual, sample_time)
        spectrum.loglog(frequency, density * UM, label=name, **style)
        for branch, label, points in branches:
            if np.any(branch):
                loop.plot(voltage[branch], residual[branch] * UM, label=label, **points)
        loop.set_xlabel("voltage in V")
        loop.set_title(name, loc="left", fontsize=9)
    for axis in (course, *loops):
        for bound in (-2.0 * noise * UM, 2.0 * noise * UM):
            axis.axhline(bound, **_FLOOR)
    course.plot([], [], label="noise, ±2 std", **_FLOOR)
    spectrum.axhline(noise * UM * np.sqrt(2.0 * sample_time), label="white noise of that rms", **_FLOOR)
    _title(figure, title)
    course.set(xlabel="time in s", ylabel="error in µm")
    loops[0].set(ylabel="error in µm")
    loops[1].tick_params(labelleft=False)
    spectrum.set(xlabel="frequency in Hz", ylabel="error in µm/√Hz")
    _legend(course)
    _legend(spectrum)
    loops[1].legend(
        loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.1, markerscale=4.0
    )
    return figure


class Fall(NamedTuple):
    """An error that falls from model to model, down to the noise.

    `label` says what it is of, with its unit; `steps` are the names of the models and their errors, the
    first model's first, in that unit; `noise` is the floor, NaN where it is not known.
    """

    label: str
    steps: list[tuple[str, float]]
    noise: float


@_styled
def waterfall(falls: list[Fall]) -> Figure:
    """Draw how the error falls from the first model through every effect down to the noise.

    Parameters
    ----------
    falls : list of Fall
        One panel each: of the plant and of its inverse.
    """
    figure = Figure(figsize=(6.4, 3.0))
    for axis, fall in zip(figure.subplots(1, len(falls), squeeze=False)[0], falls, strict=True):
        (first, height), *steps = fall.steps
        bars = [(first, 0.0, height, _BEFORE["color"])]
        for name, error in steps:
            # an effect that makes this error larger is drawn so
            colour = "#6baed6" if error <= height else "#b2182b"
            bars.append((name, min(error, height), max(error, height), colour))
            height = error
        bars.append(("now", 0.0, height, _AFTER["color"]))
        if np.isfinite(fall.noise):
            bars.append(("noise", 0.0, fall.noise, "0.55"))
        for place, (_, low, high, colour) in enumerate(bars):
            axis.bar(place, high - low, bottom=low, color=colour, width=0.7)
            shown = high - low if 0 < place <= len(steps) else high
            sign = "" if not 0 < place <= len(steps) else ("−" if colour == "#6baed6" else "+")
            axis.text(place, high, f"{sign}{shown:.2g}", ha="center", va="bottom", fontsize=7)
        for place, error in enumerate(e for _, e in fall.steps):
            axis.plot([place + 0.35, place + 0.65], [error, error], color="0.5", linewidth=0.7)
        names = [textwrap.fill(name, 12) for name, *_ in bars]
        axis.set_xticks(range(len(bars)), names, rotation=90 if len(bars) > 5 else 0, fontsize=7)
        axis.grid(axis="x", visible=False)
        axis.margins(y=0.12)
        axis.set_title(fall.label, loc="left", fontsize=9)
    return figure
