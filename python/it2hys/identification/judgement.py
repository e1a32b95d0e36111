"""The errors of a model on one record: of its free run, its cold start, and its inverse."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from it2hys.identification.criterion import Model, Trace
from it2hys.identification.effect_coordinates import of_reading
from it2hys.identification.explained import explained_by_model, explained_by_voltage
from it2hys.identification.inverse import applied_voltage, ask_inverse, noise_of_inverse
from it2hys.identification.noise import NoiseEstimate, estimate_noise, noise_floor
from it2hys.identification.starts import Starts
from it2hys.model import compiled
from it2hys.model.chain import EFFECTS, active_effects
from it2hys.model.parameters import ParameterSet
from it2hys.policy import NOISE
from it2hys.records.figures_of_merit import max_relative_error, rms_error


@dataclass(frozen=True, eq=False)
class InverseJudgement:
    """What voltage the inverse asks for when it is fed with the displacement that was measured.

    Parameters
    ----------
    e_rms : float
        Its difference to the voltage that was applied, behind the lead-in, V rms.
    e_displacement : float
        The same by the records' gain, m rms.
    noise : float
        What the noise of the reference alone makes of it, V rms.
    band : float
        Highest frequency of the reference, Hz.
    latency : float
        By which the stage is later than the inverse's voltage, s; compensated.
    saturated : float
        Share of the samples at which the inverse could not follow.
    asked, applied : ndarray, shape (N,)
        V; the applied voltage later by the latency. NaN in `asked` where nothing is judged.
    """

    e_rms: float
    e_displacement: float
    noise: float
    band: float
    latency: float
    saturated: float
    asked: np.ndarray = field(repr=False)
    applied: np.ndarray = field(repr=False)


@dataclass(frozen=True, eq=False)
class OneStep:
    """How the paper's model predicts the next reading from the measured one.

    Parameters
    ----------
    e_mr, e_rms : float
        (24) as a fraction and (25) in m.
    y : ndarray, shape (N,)
        Predictions, the record's constant included, m.
    """

    e_mr: float
    e_rms: float
    y: np.ndarray = field(repr=False)


@dataclass(frozen=True, eq=False)
class Judgement:
    """How a model does on one record, in free run.

    Parameters
    ----------
    name, role : str
        Role is "train", "validation" or "test".
    e_mr, e_rms : float
        (24) as a fraction and (25) in m.
    start : dict of str to float
        Parameters with which the plant FMU begins this record, SI units.
    offset : float
        Constant between record and model, fitted and removed, m; 0 where none is allowed.
    lead : int
        Samples of the lead-in, on which the start is fitted and which the errors leave out.
    lead_in : float
        Its duration, s.
    used : ndarray of bool, shape (N,)
        Samples on which the errors are taken.
    noise : float
        Of the record, m rms.
    cold_start : float
        (25) in m of the FMU as packaged, told nothing but the first displacement.
    inverse : InverseJudgement
        How the inverse does on the measured displacement.
    explained, voltage_share : float
        Share of the displacement's variance that the free run explains, and that a generous predictor
        from the voltage alone does (`identification.explained`).
    y : ndarray, shape (N,)
        The model's reading on all samples, offset included, m.
    out_of_range : ndarray of bool, shape (N,)
        Where the run is beyond what the model holds for (`outOfRange` of the plant FMU).
    noise_method : str
        How the noise was estimated.
    one_step : OneStep or None
        None for a model with effects: a reading alone does not give the states that they have.
    """

    name: str
    role: str
    e_mr: float
    e_rms: float
    start: dict[str, float]
    offset: float
    lead: int
    lead_in: float
    used: np.ndarray = field(repr=False)
    noise: float
    cold_start: float
    inverse: InverseJudgement
    explained: float
    voltage_share: float
    y: np.ndarray = field(repr=False)
    out_of_range: np.ndarray = field(repr=False)
    noise_method: str
    one_step: OneStep | None


def judge_records(
    starts: Starts,
    model: Model,
    parameters: ParameterSet,
    traces: Sequence[Trace],
    each: Callable = map,
) -> tuple[Judgement, ...]:
    """Return the errors of a model on records, each begun as its lead-in tells.

    Parameters
    ----------
    starts : Starts
    model : Model
    parameters : ParameterSet
        The model as packaged.
    traces : sequence of Trace
    each : callable
        A `map`; one over processes shares the records among them.
    """
    return tuple(each(partial(_judge_begun, starts, model, parameters), traces))


def _judge_begun(starts: Starts, model: Model, parameters: ParameterSet, trace: Trace) -> Judgement:
    fitted = starts.fit_own(model, [trace])
    return judge(trace, parameters, fitted.start(0), float(fitted.offsets[0]))


def judge(trace: Trace, parameters: ParameterSet, start: dict, offset: float) -> Judgement:
    """Return the errors of both FMUs on a record, begun with a start."""
    begun = parameters.replace(**start)
    e_mr, e_rms, y = _errors(trace, begun, offset)
    if e_rms * NOISE.nearly < trace.noise:
        trace = with_noise(trace, _noise_left(trace, y))
    # the phase of what is picked up is nothing that a stage or its model could be told
    told = parameters.replace(
        **{n: v for n, v in start.items() if n in of_reading()},
        initialDisplacement=float(trace.y[0]) - offset,
    )
    return Judgement(
        name=trace.name,
        role=trace.role,
        e_mr=e_mr,
        e_rms=e_rms,
        start=start,
        offset=offset,
        lead=trace.lead,
        lead_in=trace.lead * float(parameters["sampleTime"]),
        noise=trace.noise,
        cold_start=_errors(trace, told, offset)[1],
        inverse=_judge_inverse(trace, begun, offset),
        explained=explained_by_model(trace.y, y, judged_samples(trace)),
        voltage_share=explained_by_voltage(trace.drive.voltage, trace.y, judged_samples(trace)),
        y=y,
        used=judged_samples(trace),
        out_of_range=compiled.chain_out_of_range(
            begun, trace.drive.voltage, trace.drive.force, trace.drive.temperature
        ),
        noise_method=trace.noise_method,
        one_step=None if active_effects(parameters) else _one_step(trace, begun, offset),
    )


def _noise_left(trace: Trace, y: np.ndarray) -> NoiseEstimate:
    """Return the noise of a record of which a model leaves less than what was estimated.

    That was motion, then: a model that follows it leaves the noise.
    """
    used = judged_samples(trace)
    left = estimate_noise(trace.drive.voltage, trace.y - y, used)
    rms = max(left.rms, noise_floor(trace.y[used]))
    return NoiseEstimate(min(rms, trace.noise), f"{left.method}, of what the model leaves")


def with_noise(trace: Trace, noise: NoiseEstimate) -> Trace:
    """Return a record with another estimate of its noise."""
    return replace(
        trace,
        noise=noise.rms,
        noise_method=noise.method,
        references=replace(trace.references, noise=noise.rms),
    )


def judged_samples(trace: Trace) -> np.ndarray:
    """Return the samples behind the lead-in whose errors count, a mask of shape (N,)."""
    return trace.judged & (np.arange(len(trace.y)) >= trace.lead)


def _one_step(trace: Trace, parameters: ParameterSet, offset: float) -> OneStep:
    measured = trace.y - offset
    previous = np.concatenate([[parameters["initialDisplacement"]], measured[:-1]])
    limits = parameters.displacement_range
    y = compiled.one_step(parameters.rules, previous, trace.drive.voltage, limits) + offset
    # a reading that is not to be trusted spoils the prediction of the next sample as well
    used = judged_samples(trace)
    paired = used & np.concatenate([[False], used[:-1]])
    pairs = trace.y[paired], y[paired]
    return OneStep(max_relative_error(*pairs), rms_error(*pairs), y)


def _judge_inverse(trace: Trace, parameters: ParameterSet, offset: float) -> InverseJudgement:
    """Return how the inverse does on the measured displacement, up to the band of the record."""
    reference, drive = trace.references.local, trace.drive
    judged = trace.judged & reference.inside
    asked, saturated = ask_inverse(parameters, drive, trace.references, offset=offset)
    applied = applied_voltage(parameters, drive)
    noise = noise_of_inverse(parameters, drive, trace.references)
    (low, high), (lowest, highest) = parameters.voltage_range, parameters.displacement_range
    e_rms = rms_error(applied[judged], asked[judged])
    return InverseJudgement(
        e_rms=e_rms,
        e_displacement=e_rms * (highest - lowest) / (high - low),
        noise=float(np.sqrt(np.mean(noise[judged] ** 2))),
        band=reference.band,
        latency=float(sum(EFFECTS[e].latency(parameters) for e in active_effects(parameters))),
        saturated=float(np.mean(saturated[judged])),
        asked=np.where(judged, asked, np.nan),
        applied=applied,
    )


def _errors(trace: Trace, parameters: ParameterSet, offset: float) -> tuple[float, float, np.ndarray]:
    """Return (24), (25) behind the lead-in, and the reading."""
    drive = trace.drive
    _, reading = compiled.chain_free_run(parameters, drive.voltage, drive.force, drive.temperature)
    y, used = reading + offset, judged_samples(trace)
    if not np.all(np.isfinite(y)):
        return np.inf, np.inf, y
    return max_relative_error(trace.y[used], y[used]), rms_error(trace.y[used], y[used]), y
