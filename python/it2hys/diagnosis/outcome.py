"""The result of a diagnosis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from it2hys.identification.judgement import Judgement
from it2hys.identification.result import Fitted
from it2hys.model.parameters import ParameterSet
from it2hys.model.stages import EFFECTS
from it2hys.model.variables import load_table

_CURVE_POINTS = 201
#: Files of models of which it is open which one is right, see `Rival.file`.
RIVAL_FILES = "rival_*.ssv"
#: Beginning of the sentences on test records.
ON_TEST_RECORDS = "On the test records"


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
        Share by which adding the effect lowers the free-run error on held-out data; NaN if not tried.
    held_out_p_value : float
    accepted : bool
    why : str
        The verdict with its reason, as a sentence.
    reason : str
        The reason alone, the same words for all effects that it holds for; empty for an effect that was
        added.
    beside : tuple of str
        Effects that the model had when this one was added to it, those of the first model left out.
    error_before, error_after : float
        Free-run error on held-out data, m; NaN if not tried.
    level : float
        Probability by chance up to which a small gain counts; NaN if not tried.
    """

    effect: str
    statistic: float
    p_value: float
    signature: str
    held_out_gain: float
    held_out_p_value: float
    accepted: bool
    why: str
    reason: str = ""
    beside: tuple[str, ...] = ()
    error_before: float = np.nan
    error_after: float = np.nan
    level: float = np.nan


@dataclass(frozen=True, eq=False)
class Stage:
    """A model on the way: the first, and after each effect that was added.

    Parameters
    ----------
    label : str
    residuals : list of ndarray
        Measured minus model on each training record, m; NaN where no error counts.
    e_rms : float
        Error on held-out data, m.
    judgements : tuple of Judgement
        Errors of the model and its inverse on all records, in their order.
    """

    label: str
    residuals: list[np.ndarray]
    e_rms: float
    judgements: tuple[Judgement, ...]


@dataclass(frozen=True, eq=False)
class Rival:
    """One of the models that the records cannot tell apart.

    Parameters
    ----------
    own : tuple of str
        Effects that the model settled on lacks; none in the rival that is this model itself.
    effects : tuple of str
        All that it has, in the order in which they came.
    parameters : ParameterSet
        As fitted to the records.
    e_rms, inverse_e_rms : float
        Errors on what decided, of the free run and of the inverse by the plant's gain, m rms.
    unexplained : bool
        Whether a significant residual is left.
    """

    own: tuple[str, ...]
    effects: tuple[str, ...]
    parameters: ParameterSet
    e_rms: float
    inverse_e_rms: float
    unexplained: bool

    @property
    def file(self) -> str:
        """Name of its file in the folder of a diagnosis."""
        return RIVAL_FILES.replace("*", "_".join(self.own)) if self.own else "parameters.ssv"


@dataclass(frozen=True, eq=False, kw_only=True)
class Diagnosis(Fitted):
    """The result of a diagnosis: the model in the end, and what was found on the way to it.

    Parameters
    ----------
    base : ParameterSet
        The model in the beginning.
    before : tuple of Judgement
        How it does on the records, in their order.
    effects : tuple of str
        Added, in the order in which they were.
    declared : tuple of str
        In the model from the start.
    unexplained : bool
        Whether a significant residual is left that none of `rivals` explains.
    left_over : tuple of str
        The residual that is left, in words.
    indistinguishable : tuple of tuple of str
        Groups of effects that explain the residual equally well on these records.
    experiments : tuple of str
        For each group, the experiment that would decide.
    evidence : tuple of Evidence
        One for each effect of the catalogue.
    stages : tuple of Stage
    has_sensor_curve : bool
        Whether the static curve is known to be the sensor's.
    rivals : tuple of Rival
        The models of `indistinguishable` as they were fitted, behind the one that was settled on; empty
        where the records can tell, or nothing was fitted that they could not.
    """

    base: ParameterSet
    before: tuple[Judgement, ...]
    effects: tuple[str, ...]
    declared: tuple[str, ...]
    unexplained: bool
    left_over: tuple[str, ...]
    indistinguishable: tuple[tuple[str, ...], ...]
    experiments: tuple[str, ...]
    evidence: tuple[Evidence, ...]
    stages: tuple[Stage, ...]
    has_sensor_curve: bool = False
    rivals: tuple[Rival, ...] = ()

    @property
    def after(self) -> tuple[Judgement, ...]:
        """How the model in the end does on the records, beside `before`."""
        return self.records

    @property
    def packaged(self) -> ParameterSet:
        """The set that the FMUs carry: without the static curve where that is the sensor's.

        Their displacement is then the stage's, which a straight sensor would read.
        """
        return self._of_the_stage(self.parameters)

    @property
    def packaged_rivals(self) -> dict[str, ParameterSet]:
        """The sets that FMUs can carry until a record decides, by their files' names."""
        return {r.file: self._of_the_stage(r.parameters) for r in self.rivals if r.own}

    def _of_the_stage(self, parameters: ParameterSet) -> ParameterSet:
        known, curves = load_table().parameters(), self.sensor_curves
        return parameters.replace(**{n: v.start for n, v in known.items() if v.effect in curves})

    @property
    def sensor_curves(self) -> tuple[str, ...]:
        """Static curves that were found and are the sensor's."""
        found = (n for n, e in EFFECTS.items() if e.is_static and e.is_on(self.parameters))
        return tuple(found) if self.has_sensor_curve else ()

    def sensor_curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Return displacements over the range of the model, and what the sensor reads there, m."""
        displacement = np.linspace(*self.parameters.displacement_range, _CURVE_POINTS)
        reading = displacement
        for name in self.sensor_curves:
            curve = EFFECTS[name]
            reading = np.array([float(curve.step(self.parameters, [], y, None)[0]) for y in reading])
        return displacement, reading
