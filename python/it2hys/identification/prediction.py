"""Free run and one-step prediction of a fitted model on a record, and the errors of both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from it2hys.identification.criteria import FreeRun, Series
from it2hys.identification.lead_in import Misfit, lead_in_length
from it2hys.identification.levenberg_marquardt import levenberg_marquardt
from it2hys.identification.preparation import Prepared, to_series
from it2hys.identification.result import RecordResult
from it2hys.identification.scaling import Scaling
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet
from it2hys.records.figures_of_merit import max_relative_error, rms_error

#: A lead counts as explained if its errors, mean and largest, are not above the rest's by more.
_EXPLAINED = 1.5
#: Errors below this, in scaled units, count as none.
_RESOLUTION = 1e-6


def fit_state(
    series: Series,
    rules: np.ndarray,
    has_offset: bool,
    limits: tuple[float, float] | None = None,
) -> tuple[float, float, float]:
    """Fit the initial state, and an offset where allowed, of one record to a given model.

    Parameters
    ----------
    series : Series
    rules : ndarray, shape (L, 6)
        Scaled rules, held.
    has_offset : bool
        Whether the record may differ by a constant.
    limits : (float, float), optional
        Scaled range of displacement that the rules hold for, where it is known.

    Returns
    -------
    state, offset, rms : float
        Scaled; `rms` is infinite where the free run diverges.
    """
    run = compiled.free_run(rules, series.x, series.state, limits)
    offset = 0.0
    if has_offset and np.all(np.isfinite(run)):
        offset = float(np.average(series.y - run, weights=series.weight))
    series = replace(series, has_offset=has_offset, offset=offset)
    criterion = FreeRun([series], len(rules), limits).with_fixed_rules(rules)
    minimum = levenberg_marquardt(
        criterion.residual,
        criterion.linearise,
        criterion.pack(rules),
        criterion.lower,
        criterion.upper,
        tolerance=1e-9,
        max_iterations=30,
    )
    point = minimum.coordinates
    rms = np.sqrt(2.0 * minimum.cost / max(np.sum(series.weight**2), 1e-300))
    return float(criterion.states(point)[0]), float(criterion.offsets(point)[0]), float(rms)


def explains_lead(prepared: Prepared, rules: np.ndarray, scaling: Scaling, offset: float = 0.0) -> bool:
    """Return whether a model explains the discarded lead of a record as well as the rest.

    Parameters
    ----------
    prepared : Prepared
    rules : ndarray, shape (L, 6)
        Scaled rules.
    scaling : Scaling
    offset : float
        Offset of the record, scaled.
    """
    if prepared.skip == 0:
        return False
    whole = to_series(replace(prepared, skip=0), scaling)
    whole = replace(whole, y=whole.y - offset, state=float(whole.y[0] - offset))
    state, *_ = fit_state(whole, rules, has_offset=False)
    error = np.abs(compiled.free_run(rules, whole.x, state) - whole.y)
    in_lead = np.arange(len(error)) < prepared.skip
    lead, rest = error[in_lead & (whole.weight > 0)], error[~in_lead & (whole.weight > 0)]
    floor = _RESOLUTION
    return bool(
        np.sqrt(np.mean(lead**2)) <= _EXPLAINED * np.sqrt(np.mean(rest**2)) + floor
        and np.max(lead, initial=0.0) <= _EXPLAINED * np.max(rest) + floor
    )


def judge(
    prepared: Prepared,
    role: str,
    parameters: ParameterSet,
    scaling: Scaling,
    state: float,
    offset: float,
) -> RecordResult:
    """Return how the paper's model does on a record from a given initial state and offset, both scaled.

    The runs are made with the parameters in SI units: with the numbers that the FMU uses, within its
    range and beyond.
    """
    record = prepared.record
    rules, limits = parameters.rules, parameters.displacement_range
    shift = offset * scaling.y_unit
    initial = float(scaling.displacement(state))
    free = compiled.free_run(rules, record.voltage, initial, limits) + shift
    previous = np.concatenate([[initial], record.displacement[:-1] - shift])
    one_step = compiled.one_step(rules, previous, record.voltage, limits) + shift
    started = parameters.replace(initialDisplacement=initial)
    # A reading that is not to be trusted spoils the prediction of the next sample as well.
    used = prepared.used
    paired = used & np.concatenate([[False], used[:-1]])
    y = record.displacement
    return RecordResult(
        name=record.name,
        role=role,
        e_mr=max_relative_error(y[used], free[used]),
        e_rms=rms_error(y[used], free[used]),
        e_mr_one_step=max_relative_error(y[paired], one_step[paired]),
        e_rms_one_step=rms_error(y[paired], one_step[paired]),
        offset=shift,
        initial_displacement=initial,
        skip=prepared.skip,
        used=used,
        noise_rms=prepared.noise.rms,
        noise_method=prepared.noise.method,
        y_free=free,
        y_one_step=one_step,
        out_of_range=compiled.chain_out_of_range(started, record.voltage),
        start={"initialDisplacement": initial},
    )


def judge_new(
    prepared: Prepared,
    role: str,
    parameters: ParameterSet,
    scaling: Scaling,
    has_offset: bool,
    misfit: Misfit,
) -> RecordResult:
    """Return how the paper's model does on a record not fitted, behind its lead-in.

    Only the initial state, and an offset where allowed, are fitted, on the lead-in alone.
    """
    low, high = parameters.displacement_range
    limits = (scaling.y(low), scaling.y(high))
    rules = scaling.rules(parameters.rules)
    series = replace(to_series(prepared, scaling), has_offset=has_offset)
    scaled = Misfit(misfit.power / scaling.y_unit**2, misfit.correlated)
    noise = prepared.noise.rms / scaling.y_unit
    lead = lead_in_length(_by_start(series, rules, limits), prepared.used, noise, scaled)
    first = replace(series, weight=np.where(np.arange(len(series.x)) < lead, series.weight, 0.0))
    state, offset, _ = fit_state(first, rules, has_offset, limits)
    return judge(replace(prepared, skip=lead), role, parameters, scaling, state, offset)


def _by_start(series: Series, rules: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    """Return the sensitivity of the displacement by initial state and offset, (M, 1 or 2)."""
    criterion = FreeRun([series], len(rules), limits)
    jacobian, _ = criterion.jacobian(criterion.pack(rules))
    return jacobian[: np.count_nonzero(series.weight), criterion.rule_size :]
