"""Properties of a stage that records determine even where they leave the rules open: gain, loops, lag.

Several sets of rules may give the same output. A figure of that output has a narrow interval even
where the rules have none: it follows from the gradient of the figure by the coordinates of the fit, and
the covariance of these.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from it2hys.identification import rule_coordinates
from it2hys.identification.criterion import ChainCriterion, ChainFit
from it2hys.identification.uncertainty import NORMAL_95, Uncertainty
from it2hys.model.it2 import usability_function, usability_jacobian

#: Half of the band about the middle of the voltage's range in which branches are read, as a share of
#: the range, and the fewest samples of each branch in it.
_BAND, _FEWEST = 0.05, 10


@dataclass(frozen=True)
class StageFigure:
    """A property of the stage, by the fitted model on the training records.

    Parameters
    ----------
    name : str
        "gain", "loop width" or "time constant".
    meaning : str
        What it is and where it was taken, for a reader.
    value, low, high : float
        The figure and its 95 % interval, SI units; the ends are NaN where it is not determined.
    unit : str
    record : str
        The record that it was taken on; empty for all training records.
    """

    name: str
    meaning: str
    value: float
    low: float
    high: float
    unit: str
    record: str = ""


def stage_figures(fit: ChainFit, uncertainty: Uncertainty) -> tuple[StageFigure, ...]:
    """Return gain, widths of loops and the core's time constant, with intervals.

    Parameters
    ----------
    fit : ChainFit
    uncertainty : Uncertainty
        Of this fit.
    """
    runs = _runs(fit)
    slope, by_slope = _gain(runs)
    figures = [
        _figure(
            "gain",
            "gain over the range of the voltage, a straight line through all training records",
            slope,
            uncertainty.deviation(by_slope),
            "m/V",
        )
    ]
    figures += [f for r in runs if (f := _loop_width(r, slope, by_slope, uncertainty))]
    constant = _time_constant(fit, uncertainty)
    return (*figures, constant) if constant else tuple(figures)


@dataclass(frozen=True)
class _Run:
    """The model on the fitted samples of a record: V, m, and m by the coordinates of the fit."""

    name: str
    voltage: np.ndarray
    rate: np.ndarray
    y: np.ndarray
    by_point: np.ndarray


def _runs(fit: ChainFit) -> list[_Run]:
    criterion, point = fit.criterion, fit.minimum.coordinates
    jacobian, _ = criterion.jacobian(point)
    model, runs, first = criterion.unpack(point), [], 0
    for i, trace in enumerate(criterion.traces):
        rows = trace.fitted
        weight, voltage = trace.weight[rows], trace.drive.voltage
        by_point = jacobian[first : first + len(weight)] / weight[:, None]
        first += len(weight)
        if len(weight):
            y = model.predict(trace, i)[rows]
            runs.append(
                _Run(
                    trace.name,
                    voltage[rows],
                    np.gradient(voltage)[rows],
                    y,
                    criterion.scaling.y_unit * by_point,
                )
            )
    return runs


def _figure(name: str, meaning: str, value: float, deviation: float, unit: str, record: str = ""):
    half = NORMAL_95 * deviation
    return StageFigure(name, meaning, value, value - half, value + half, unit, record)


def _gain(runs: list[_Run]) -> tuple[float, np.ndarray]:
    """Return the slope over voltage, m/V, every record about its own mean, and its gradient."""
    away = [r.voltage - r.voltage.mean() for r in runs]
    power = sum(float(x @ x) for x in away)
    slope = sum(float(x @ r.y) for x, r in zip(away, runs, strict=True)) / power
    return slope, sum(x @ r.by_point for x, r in zip(away, runs, strict=True)) / power


def _loop_width(
    run: _Run, slope: float, by_slope: np.ndarray, uncertainty: Uncertainty
) -> StageFigure | None:
    """Return by how much a run is higher on the way down, at the middle of the record's voltages."""
    low, high = float(run.voltage.min()), float(run.voltage.max())
    middle = 0.5 * (low + high)
    near = np.abs(run.voltage - middle) < _BAND * (high - low)
    falling, rising = near & (run.rate < 0.0), near & (run.rate > 0.0)
    if min(np.count_nonzero(falling), np.count_nonzero(rising)) < _FEWEST:
        return None
    # the branches are read at slightly different voltages on the average
    shift = run.voltage[falling].mean() - run.voltage[rising].mean()
    width = run.y[falling].mean() - run.y[rising].mean() - slope * shift
    by_point = run.by_point[falling].mean(axis=0) - run.by_point[rising].mean(axis=0)
    return _figure(
        "loop width",
        f"width of the loop at {middle:.4g} V, the middle of record {run.name}: falling less rising",
        float(width),
        uncertainty.deviation(by_point - shift * by_slope),
        "m",
        run.name,
    )


def _time_constant(fit: ChainFit, uncertainty: Uncertainty) -> StageFigure | None:
    """Return the time in which the core forgets, in the middle of its travel; None if it rings."""
    criterion, point = fit.criterion, fit.minimum.coordinates
    rules = criterion.rules(point)
    pole, by_rules = _pole(rules, _middle(criterion, point))
    if not 0.0 < pole < 1.0:
        return None
    gradient = np.zeros(len(point))
    gradient[: criterion.rule_size] = rule_coordinates.chain_rule(by_rules, rules)
    half = NORMAL_95 * uncertainty.deviation(gradient)
    sample_time = criterion.traces[0].references.sample_time

    def seconds(pole: float) -> float:
        if pole >= 1.0 or not np.isfinite(pole):
            return float("nan")
        return 0.0 if pole <= 0.0 else float(-sample_time / np.log(pole))

    return StageFigure(
        "time constant",
        "time constant of the core's own lag, in the middle of its travel",
        seconds(pole),
        seconds(pole - half),
        seconds(pole + half),
        "s",
    )


def _middle(criterion: ChainCriterion, point: np.ndarray) -> float:
    """Return the middle of the core's outputs on the training records, scaled."""
    model = criterion.unpack(point)
    outputs = [criterion.scaling.y(model.run(t, i)[2]) for i, t in enumerate(criterion.traces)]
    return 0.5 * float(min(y.min() for y in outputs) + max(y.max() for y in outputs))


def _pole(rules: np.ndarray, y: float) -> tuple[float, np.ndarray]:
    """Return dy(k)/dy(k-1) at rest at y, and its derivatives by the scaled rules, (1, 6 L)."""
    count = len(rules)
    value = float(usability_function(count, 1)(rules, y, 0.0, 0.0)[0])
    by_rules = usability_jacobian(count, 1)(rules, y, 0.0, 0.0).full()[0]
    # CasADi lays the rules out column by column, the coordinates are row by row
    return value, by_rules.reshape(rule_coordinates.RULE_SIZE, count).T.reshape(1, -1).copy()
