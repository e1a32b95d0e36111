"""Figures as a control engineer would put them in a paper.

Every function returns a matplotlib figure; lengths are drawn in um, the error always on an axis of
its own. Long records are thinned to what the picture can show, extremes kept.
"""

from io import BytesIO

import matplotlib

matplotlib.use("Agg")

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

MEASURED = {"color": "0.25", "linewidth": 1.4}
MODEL = {"color": "#1f77b4", "linewidth": 1.1}
SECOND = {"color": "#d95f02", "linewidth": 1.1, "linestyle": "--"}
ERROR = {"color": "#b2182b", "linewidth": 0.8}
NOISE = {"color": "0.6", "linewidth": 0.8, "linestyle": ":"}
STYLE = {
    "font.size": 9,
    "axes.grid": True,
    "grid.color": "0.92",
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
    "figure.dpi": 110,
    "savefig.dpi": 160,
}
LARGEST_COUNT = 20_000
UM = 1e6

_styled = matplotlib.rc_context(STYLE)


def png(figure: Figure) -> bytes:
    """Return a figure as PNG."""
    buffer = BytesIO()
    with matplotlib.rc_context(STYLE):
        figure.savefig(buffer, format="png")
    return buffer.getvalue()


def _figure(rows: list[float], width: float = 6.4, height: float = 4.4, **options: object):
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
def hysteresis_loop(
    voltage: np.ndarray, measured: np.ndarray, model: np.ndarray, title: str, name: str = "model"
) -> Figure:
    """Draw displacement and error over voltage, both branches (the paper's Figure 3).

    Parameters
    ----------
    voltage : ndarray, shape (N,)
        In V.
    measured, model : ndarray, shape (N,)
        In m.
    title, name : str
        Title, and the model's name in the legend.
    """
    figure, (top, bottom) = _figure([2, 1], height=5.0, sharex=True)
    top.plot(voltage, measured * UM, label="measured", **MEASURED)
    top.plot(voltage, model * UM, label=name, **MODEL)
    error = (measured - model) * UM
    rising = np.gradient(voltage) >= 0
    for branch, label, style in (
        (rising, "rising voltage", MODEL),
        (~rising, "falling voltage", SECOND),
    ):
        bottom.plot(voltage, np.where(branch, error, np.nan), label=label, **style)
    _title(figure, title)
    top.set(ylabel="displacement in µm")
    bottom.set(xlabel="voltage in V", ylabel="error in µm")
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
