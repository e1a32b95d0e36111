"""The interface of an effect of the chain: its physics as CasADi expressions, and how it is fitted.

One module of `model/effects` per effect, whose operations are those of its C file (`fmu_src/core`). How
an effect shows in records is not known here: that is in `diagnosis/evidence`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from enum import Enum
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from it2hys.records.clues import Clues, Extent
from it2hys.support.lazy import Lazy

if TYPE_CHECKING:
    import casadi as ca

    Scalar = ca.SX | float
else:
    ca = Lazy("casadi")
    #: A number or an expression.
    Scalar = object
#: Numbers or expressions by FMU variable name; counts and switches are always numbers.
Values = Mapping[str, Scalar]


class Surroundings(NamedTuple):
    """At one tick: force (N), temperature (K), time (s), and the voltage at the actuator (V).

    The voltage is that which drives the core, behind which alone it is known.
    """

    force: Scalar
    temperature: Scalar
    time: Scalar
    voltage: Scalar = 0.0


#: Share of its upper bound up to which a parameter that is fitted is 0.
_NOTHING = 1e-9
#: Lowest and highest values by record, of shape (R,).
Bounds = tuple[np.ndarray, np.ndarray]


class Start(NamedTuple):
    """Where a fit of one parameter begins, and its bounds, in SI units.

    `of_sampling` says that it tells how signals were sampled: its bounds are not the stage's. `seen` is
    the largest value that the records show; what is beyond has to improve the fit, see
    `PHYSICS.unseen`.
    """

    value: float
    low: float
    high: float
    of_sampling: bool = False
    seen: float = math.inf


class History(NamedTuple):
    """A possible history before a record.

    `values` are of parameters that belong to a record; `has_to_show` is whether it has to earn its
    place against one that needs less.
    """

    values: dict[str, float]
    has_to_show: bool


class Memory(Enum):
    """How long an effect remembers, in the words of `fmu_src/core/stages.h`."""

    NONE = "no state"
    AIMED = "a tick or two; the inverse keeps what it aimed at, and beside it what the plant reached"
    SHORT = "a tick; the inverse keeps what the plant reached"
    LONG = "many numbers, of which the same is true"
    LONGEST = "even more of them"


class Effect(ABC):
    """A scalar causal map with a state of its own: one stage of the chain.

    Attributes
    ----------
    memory : Memory
    states : int
        Number of states, where it is the same in all parameter sets.
    is_static : bool
        Whether it is a curve of the reading alone, which may be the sensor's.
    limits : bool
        Whether it loses what is beyond, so that its inverse gives the nearest.
    words : str or None
        Its name for readers, where that is not the one in the list of stages.
    per_record : tuple of str
        Parameters whose value differs from record to record: how it begins, and what nothing in the
        voltage tells.
    sampled : bool
        Whether its sampled form may differ from the truth by a part of a sample: how the voltage is
        held and when the reading is taken is not in the records. A part of a sample goes with it.
    sampling_delay : str or None
        Parameter of a sampled effect that is that part; where there is none, a part of `shift` is.
    shift : str or None
        Parameter that shifts the voltage, up to a sample of which belongs to a sampled effect. The
        effect that has one waits, as a slow core does.
    """

    memory: ClassVar[Memory] = Memory.NONE
    states: ClassVar[int] = 0
    is_static: ClassVar[bool] = False
    limits: ClassVar[bool] = False
    words: ClassVar[str | None] = None
    per_record: ClassVar[tuple[str, ...]] = ()
    sampled: ClassVar[bool] = False
    sampling_delay: ClassVar[str | None] = None
    shift: ClassVar[str | None] = None

    @abstractmethod
    def is_on(self, parameters: Values) -> bool:
        """Return whether a parameter set has the effect."""

    def size(self, parameters: Values) -> int:
        """Return the number of states."""
        return self.states

    def rest(self, values: Values, y: Scalar) -> tuple[Scalar, list[Scalar]]:
        """Return input and states at rest at the output y, of which the first `size` are used.

        By default all of them are the output.
        """
        return y, [y] * self.states

    @abstractmethod
    def step(
        self, values: Values, state: list[Scalar], x: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the output and the next states."""

    def inverse(
        self, values: Values, state: list[Scalar], y: Scalar, around: Surroundings
    ) -> tuple[Scalar, list[Scalar]]:
        """Return the input that makes the output y, and the next states where the memory is short.

        By default the effect has no part in the inverse, as a delay, which none can make up for.
        """
        return y, state

    @property
    def has_inverse(self) -> bool:
        """Whether the effect has a part in the inverse."""
        return type(self).inverse is not Effect.inverse

    def latency(self, values: Values) -> Scalar:
        """Return how much later the output comes, in s, where the inverse does not make up for it."""
        return 0.0

    def ordered(self, values: Mapping) -> dict:
        """Return the values with the effect's elements in the order that its inverse wants."""
        return dict(values)

    def over_range(self, low: float, high: float) -> dict[str, float]:
        """Return what of the effect follows from the range of displacement of a set, in m."""
        return {}

    # --- how it is fitted -------------------------------------------------------------------------

    @abstractmethod
    def starts(self, extent: Extent) -> dict[str, Start]:
        """Return start values and bounds for a fit, from the extent of the records."""

    def starts_of(self, values: Mapping, extent: Extent) -> dict[str, Start]:
        """Return start values and bounds for as many elements as a parameter set has."""
        return self.starts(extent)

    def is_nil(self, values: Mapping, extent: Extent) -> bool:
        """Return whether a fit has left nothing of the effect: all that may be 0 and not less is 0."""
        sizes = {
            name: start.high
            for name, start in self.starts_of(values, extent).items()
            if start.low == 0.0 and not start.of_sampling and name not in self.per_record
        }
        return bool(sizes) and all(values[n] <= _NOTHING * high for n, high in sizes.items())

    def roughness(self, values: Mapping, units: Mapping[str, float]) -> np.ndarray:
        """Return the rows, (K, C), of what costs as it is not smooth; none by default.

        Parameters
        ----------
        values : Mapping
            Parameters of the chain.
        units : Mapping
            The C parameters that are fitted, and what of them a coordinate of 1 is.
        """
        return np.zeros((0, len(units)))

    @property
    def is_smoothed(self) -> bool:
        """Whether what is not smooth of the effect costs."""
        return type(self).roughness is not Effect.roughness

    def steepness(self, values: Mapping, units: Mapping[str, float]) -> np.ndarray:
        """Return the rows, (K, C), of what the coordinates add to the slope of a static curve."""
        return np.zeros((0, len(units)))

    def nowhere(self, extent: Extent) -> dict[str, float]:
        """Return the values of parameters at which they do nothing on the records.

        Of those that may act beyond them, too, which a fit to the records hardly shows. By default
        there are none.
        """
        return {}

    def bounds_of_record(
        self, name: str, bounds: Bounds, begins: np.ndarray, travel: tuple[float, float]
    ) -> Bounds:
        """Return the bounds of a `per_record` parameter by record; by default the same in all.

        Parameters
        ----------
        name : str
        bounds : tuple of two ndarray, shape (R,)
            Lowest and highest value of any record.
        begins : ndarray, shape (R,)
            First displacements, m.
        travel : tuple of float
            Lowest and highest displacement that a record may be taken to begin at, m.
        """
        return bounds

    def told_after(self, values: Values) -> float:
        """Return how much of a record, in s, tells its `per_record` parameters from slow motion."""
        return 0.0

    def histories(self, voltage: np.ndarray) -> list[History]:
        """Return what may have been before a record of this voltage, (N,); nothing by default."""
        return []

    def found_in_records(
        self, values: Mapping, clues: Callable[[Mapping], Clues]
    ) -> dict[str, np.ndarray]:
        """Return guesses of `per_record` parameters, (R,) each, for records not seen before.

        Parameters
        ----------
        values : Mapping
            Parameters of the chain.
        clues : callable
            Takes other ones, and returns what the chain leaves over with these.
        """
        return {}
