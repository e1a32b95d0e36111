"""What is known of a fitted model, and of an identified one beside that."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from it2hys.errors import InputError
from it2hys.model.parameters import ParameterSet

if TYPE_CHECKING:
    from it2hys.identification.judgement import Judgement
    from it2hys.identification.stage_figures import StageFigure


#: Names of the solvers that minimise (23), see `solvers`; the first is the default.
SOLVERS = (
    "levenberg-marquardt",
    "trust-region",
    "quasi-newton",
    "gradient-descent",
    "ipopt",
    "evolution",
)


class IdentificationError(InputError):
    """No usable model could be fitted; the message says why."""


@dataclass(frozen=True)
class Options:
    """Options of an identification; the defaults suit most records.

    Parameters
    ----------
    seed : int
        Seed of the random starts: the same data and seed give the same model.
    starts : int
        Largest number of starts; fewer where several of them soon agree on the best optimum.
    max_iterations : int
        Limit of the fits on the whole records; one that reaches it has not converged.
    solver : str
        One of `SOLVERS`, for the fits on the whole records. The starts of these are sought on excerpts
        by the default one.

    Raises
    ------
    InputError
        If the seed is not a whole number from 0 up, a limit not one from 1 up, or the solver not known.
    """

    seed: int = 0
    starts: int = 36
    max_iterations: int = 600
    solver: str = SOLVERS[0]

    def __post_init__(self) -> None:
        """Refuse what no fit takes."""
        least = {"seed": 0, "starts": 1, "max_iterations": 1}
        for name, low in least.items():
            value = getattr(self, name)
            if not isinstance(value, int | np.integer) or value < low:
                option = name.replace("_", "-")
                raise InputError(f"--{option} {value}: must be a whole number from {low} up")
        if self.solver not in SOLVERS:
            raise InputError(f"unknown solver '{self.solver}'; known are {', '.join(SOLVERS)}")


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


@dataclass(frozen=True, eq=False, kw_only=True)
class Fitted:
    """A model and what is known about it: all that one report says of any model.

    Parameters
    ----------
    parameters : ParameterSet
        The model, in SI units.
    records : tuple of Judgement
        How it does on training, validation and test records, in this order.
    noise_rms : float
        Noise of the training records, m.
    intervals : dict of str to (float, float)
        95 % intervals by FMU parameter name, SI units; NaN for a parameter held at a bound; empty for a
        model that was given.
    undetermined : tuple of str
        Parameters that the data do not determine; `warnings` say which of them only together.
    stage_figures : tuple of StageFigure
        What the data do determine: gain, widths of loops, time constants.
    warnings : tuple of str
        What a user of the model should know, as sentences.
    seconds : dict of str to float
        Duration of each phase, s.
    """

    parameters: ParameterSet
    records: tuple[Judgement, ...]
    noise_rms: float
    intervals: dict[str, tuple[float, float]] = field(default_factory=dict)
    undetermined: tuple[str, ...] = ()
    stage_figures: tuple[StageFigure, ...] = ()
    warnings: tuple[str, ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def packaged(self) -> ParameterSet:
        """The set that the FMUs carry."""
        return self.parameters

    def by_role(self, role: str) -> list[Judgement]:
        """Return the results of the training, validation or test records."""
        return [result for result in self.records if result.role == role]


@dataclass(frozen=True, eq=False, kw_only=True)
class Identification(Fitted):
    """An identified model of the paper, or a given one where nothing was fitted.

    Parameters
    ----------
    condition : float
        Condition number of the Jacobian by coordinates in units of a plausible interval.
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
    """

    condition: float = np.nan
    converged: bool = True
    message: str = ""
    contraction: float = np.nan
    starts: tuple[Start, ...] = ()
    orders: tuple[OrderTrial, ...] = ()

    @property
    def error_over_noise(self) -> float:
        """Free-run error of the training records over their noise: 1 where nothing is missing.

        Of all records where none was fitted.
        """
        results = self.by_role("train") or self.records
        return float(np.sqrt(np.mean([r.e_rms**2 for r in results]))) / self.noise_rms
