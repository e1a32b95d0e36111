"""What a diagnosis returns."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from it2hys.model.parameters import ParameterSet


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
        from the voltage alone does (`diagnosis.explained`).
    y : ndarray, shape (N,)
        The model's reading on all samples, offset included, m.
    out_of_range : ndarray of bool, shape (N,)
        Where the run is beyond what the model holds for (`outOfRange` of the plant FMU).
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


@dataclass(frozen=True)
class Evidence:
    """One effect that was tried, or could not be.

    Parameters
    ----------
    effect : str
    statistic, p_value : float
        Of the residual's signature; NaN where there is none.
    signature : str
        The signature in words.
    held_out_gain : float
        Share by which adding the effect lowers the error on the records that decide; NaN if not tried.
    held_out_p_value : float
    accepted : bool
    why : str
    """

    effect: str
    statistic: float
    p_value: float
    signature: str
    held_out_gain: float
    held_out_p_value: float
    accepted: bool
    why: str


@dataclass(frozen=True, eq=False)
class Stage:
    """A model on the way: the first, and after each effect that was added.

    Parameters
    ----------
    label : str
    residuals : list of ndarray
        Measured minus model on each training record, m; NaN where no error counts.
    e_rms : float
        Error on the records that decide, m.
    """

    label: str
    residuals: list[np.ndarray]
    e_rms: float


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What was found in the records.

    Parameters
    ----------
    parameters, base : ParameterSet
        The model in the end and the one in the beginning.
    effects : tuple of str
        Added, in the order in which they were.
    declared : tuple of str
        In the model from the start.
    unexplained : bool
        Whether a significant residual is left.
    left_over : tuple of str
        The residual that is left, in words.
    indistinguishable : tuple of tuple of str
        Groups of effects that explain the residual equally well on these records.
    experiments : tuple of str
        For each group, what would decide.
    noise_rms : float
        Of the records, m.
    before, after : tuple of Judgement
        Of the first and the last model, in the order of the records.
    evidence : tuple of Evidence
        One for each effect of the catalogue.
    stages : tuple of Stage
    intervals : dict of str to (float, float)
        95 % intervals by FMU parameter name, SI units; NaN for a parameter held at a bound.
    warnings : tuple of str
    seconds : dict of str to float
        Duration of each phase, s.
    """

    parameters: ParameterSet
    base: ParameterSet
    effects: tuple[str, ...]
    declared: tuple[str, ...]
    unexplained: bool
    left_over: tuple[str, ...]
    indistinguishable: tuple[tuple[str, ...], ...]
    experiments: tuple[str, ...]
    noise_rms: float
    before: tuple[Judgement, ...]
    after: tuple[Judgement, ...]
    evidence: tuple[Evidence, ...]
    stages: tuple[Stage, ...]
    intervals: dict[str, tuple[float, float]]
    warnings: tuple[str, ...]
    seconds: dict[str, float]
