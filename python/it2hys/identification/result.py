"""What an identification returns."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from it2hys.errors import InputError
from it2hys.model.parameters import ParameterSet


class IdentificationError(InputError):
    """No usable model could be fitted; the message says why."""


@dataclass(frozen=True)
class Options:
    """Choices of an identification; the defaults need no thought.

    Parameters
    ----------
    offsets : bool or None
        Let every record after the first differ by a constant of its own. None: where it lowers the
        error of the training records by far.
    skip : int or None
        Leading samples of every record left out of fit and errors. None: those of a start-up
        transient that the model cannot explain.
    starts : int
        Largest number of starts; fewer where several of them soon agree on the best optimum.
    max_rules : int
        Largest number of rules tried when it is to be chosen.
    max_iterations : int
        Limit of the final free-run fit; a fit that reaches it has not converged.
    seed : int
        Seed of the random starts: the same data give the same model.

    Raises
    ------
    InputError
        If the seed is not a whole number from 0 up.
    """

    offsets: bool | None = None
    skip: int | None = None
    starts: int = 36
    max_rules: int = 6
    max_iterations: int = 600
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse a seed that no generator takes."""
        if not isinstance(self.seed, int | np.integer) or self.seed < 0:
            raise InputError(f"the seed must be a whole number from 0 up, not {self.seed}")


@dataclass(frozen=True, eq=False)
class RecordResult:
    """How the model does on one record.

    Parameters
    ----------
    name : str
        Name of the record.
    role : str
        "train", "validation" or "test".
    e_mr, e_rms : float
        (24) as a fraction and (25) in m, of the free run.
    e_mr_one_step, e_rms_one_step : float
        The same one step ahead.
    offset : float
        Constant between record and model, fitted and removed, m; 0 where none was allowed.
    initial_displacement : float
        Displacement before the first sample from which the free run starts, m; fitted. The plant
        FMU with this `initialDisplacement` gives `y_free` less `offset`.
    skip : int
        Leading samples that errors leave out.
    used : ndarray of bool, shape (N,)
        Samples on which the errors of the free run are taken.
    noise_rms : float
        Noise of the record, m.
    noise_method : str
        How it was estimated.
    y_free, y_one_step : ndarray, shape (N,)
        Model outputs on all samples, `offset` included, m.
    out_of_range : ndarray of bool, shape (N,)
        Where the free run is beyond what the model holds for (`outOfRange` of the plant FMU).
    start : dict of str to float
        Parameters with which the plant FMU begins this record, SI units; of a model without effects
        `initialDisplacement` alone.
    """

    name: str
    role: str
    e_mr: float
    e_rms: float
    e_mr_one_step: float
    e_rms_one_step: float
    offset: float
    initial_displacement: float
    skip: int
    used: np.ndarray = field(repr=False)
    noise_rms: float
    noise_method: str
    y_free: np.ndarray = field(repr=False)
    y_one_step: np.ndarray = field(repr=False)
    out_of_range: np.ndarray = field(repr=False)
    start: dict[str, float]


@dataclass(frozen=True)
class Start:
    """One of the starts and where it led.

    Parameters
    ----------
    one_step_rms : float
        Error one step ahead with which it began, m; NaN for a start taken from a smaller model.
    free_run_rms : float
        Error in free run to which it led, on what the search sees of the training records, m.
    """

    one_step_rms: float
    free_run_rms: float


@dataclass(frozen=True)
class OrderTrial:
    """A number of rules that was tried.

    Parameters
    ----------
    rules : int
        Number of rules L.
    e_rms : float
        Free-run error on the records, or parts of records, that decide, m.
    """

    rules: int
    e_rms: float


@dataclass(frozen=True, eq=False)
class Identification:
    """An identified model and what is known about it.

    Parameters
    ----------
    parameters : ParameterSet
        The model, in SI units.
    records : tuple of RecordResult
        Training, validation and test records, in this order.
    noise_rms : float
        Noise of the training records, m.
    intervals : dict of str to (float, float)
        95 % intervals by FMU parameter name, SI units; NaN for a parameter held at a bound.
    condition : float
        Condition number of the Jacobian by coordinates in units of a plausible interval.
    undetermined : tuple of str
        Parameters that the data do not determine; `warnings` say which of them only together.
    warnings : tuple of str
        What a user of the model should know, as sentences.
    converged : bool
        Whether the final fit met its stopping test. If not, the parameters are not to be written.
    message : str
        How the final fit ended.
    contraction : float
        Largest |dy(k)/dy(k-1)| over the band of the training records, verified on a fine grid: at
        every displacement of their range and 10 % beyond, from the least to the greatest voltage
        that they have near it and 10 % beyond, and on the equilibrium curve. Below 1 two free runs
        in the band under the same voltage approach each other; 1 or more is also warned of.
    starts : tuple of Start
        All starts, best first.
    orders : tuple of OrderTrial
        Numbers of rules tried; empty if it was given.
    seconds : dict of str to float
        Duration of each phase, s.
    """

    parameters: ParameterSet
    records: tuple[RecordResult, ...]
    noise_rms: float
    intervals: dict[str, tuple[float, float]]
    condition: float
    undetermined: tuple[str, ...]
    warnings: tuple[str, ...]
    converged: bool
    message: str
    contraction: float
    starts: tuple[Start, ...]
    orders: tuple[OrderTrial, ...]
    seconds: dict[str, float]

    def by_role(self, role: str) -> list[RecordResult]:
        """Return the results of the training, validation or test records."""
        return [result for result in self.records if result.role == role]

    @property
    def error_over_noise(self) -> float:
        """Free-run error of the training records over their noise: 1 where nothing is missing."""
        results = self.by_role("train")
        return float(np.sqrt(np.mean([r.e_rms**2 for r in results]))) / self.noise_rms
