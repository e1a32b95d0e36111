"""The C core (`fmu_src/core`), called on whole records.

What the FMUs compute at a tick is computed here by the same C functions, without FMI around it: fast
free runs with forward sensitivities for the identification, and the one check of a parameter set.
Units are the caller's: m and V, or a scaled pair of the identification.
"""

import ctypes
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from it2hys.errors import InputError
from it2hys.support.processes import LONG, has_threads, thread_map

MAX_RULES = 16
REST_TEMPERATURE = 293.15
_INTEGERS = np.ctypeslib.ndpointer(np.int32, flags="C_CONTIGUOUS")
_DOUBLES = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")


class _Record(ctypes.Structure):
    """The `struct chain_record` of fmu_src/identification/chain_sensitivity.h."""

    _fields_ = [
        ("voltage", ctypes.c_void_p),
        ("force", ctypes.c_void_p),
        ("temperature", ctypes.c_void_p),
        ("first_tick", ctypes.c_int64),
        ("samples", ctypes.c_size_t),
    ]


_RULES = _DOUBLES, ctypes.c_int
_RANGE = ctypes.c_double, ctypes.c_double
_MESSAGE = ctypes.c_char_p, ctypes.c_size_t
_RUN = *[_DOUBLES] * 4, ctypes.c_int64, ctypes.c_size_t, _DOUBLES
#: Result and arguments of the functions of fmu_src/python/it2core.c.
_FUNCTIONS = {
    "free_run": (ctypes.c_size_t, *_RULES, *[_DOUBLES] * 2, ctypes.c_size_t, ctypes.c_double, _DOUBLES),
    "solve": (None, *_RULES, *[_DOUBLES] * 3, ctypes.c_size_t, _DOUBLES),
    "one_step": (None, *_RULES, *[_DOUBLES] * 3, ctypes.c_size_t, _DOUBLES),
    "gradient": (ctypes.c_double, *_RULES, _DOUBLES, *_RANGE, *[_DOUBLES] * 2),
    "contraction": (ctypes.c_double, *_RULES, *_RANGE),
    "usability": (None, *_RULES, *[ctypes.c_void_p] * 3, ctypes.c_size_t, ctypes.c_void_p),
    "check": (ctypes.c_bool, *_RULES, *_RANGE, *_MESSAGE),
    "chain_size": (ctypes.c_size_t,),
    "chain_parameter": (
        ctypes.c_size_t,
        ctypes.c_int,
        ctypes.POINTER(ctypes.c_char_p),
        ctypes.POINTER(ctypes.c_int),
    ),
    "chain_check": (ctypes.c_bool, _DOUBLES, *_MESSAGE),
    "chain_run": (ctypes.c_size_t, *_RUN, _DOUBLES, _INTEGERS),
    "chain_inverse": (ctypes.c_size_t, *_RUN, _INTEGERS),
    "chain_equilibrium": (ctypes.c_double, _DOUBLES),
    "chain_predict": (ctypes.c_size_t, _DOUBLES, ctypes.POINTER(_Record), *[ctypes.c_void_p] * 3),
    "chain_predict_each": (
        ctypes.c_bool,
        ctypes.c_void_p,
        ctypes.c_size_t,
        ctypes.POINTER(_Record),
        ctypes.c_size_t,
        ctypes.c_void_p,
    ),
    "chain_sensitivity": (
        ctypes.c_size_t,
        ctypes.c_void_p,
        ctypes.POINTER(_Record),
        ctypes.c_bool,
        ctypes.POINTER(ctypes.c_size_t),
        ctypes.c_int,
        *[ctypes.c_void_p] * 2,
    ),
}


def packaged_native() -> Path:
    """Return where the built binaries and the FMUs' C sources are that come with the package.

    `IT2HYS_NATIVE` names those of another build.
    """
    return Path(os.environ.get("IT2HYS_NATIVE") or str(files("it2hys") / "native"))


#: The binaries that were built with effects of the user's own.
_own_native: Path | None = None


def use_native(directory: Path | None) -> None:
    """Use the binaries and C sources of another folder from now on; None: those of the package."""
    global _own_native
    _own_native = directory
    _library.cache_clear()


def native_directory() -> Path:
    """Return where the binaries and the FMUs' C sources are that are in use."""
    return _own_native or packaged_native()


def library_name() -> str:
    """Return the file name of the C core on this system."""
    return "it2core" + {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


@cache
def _library() -> ctypes.CDLL:
    # every call of the compiled chain asks for it: a fit does so thousands of times
    return _loaded(native_directory() / library_name())


@cache
def _loaded(path: Path) -> ctypes.CDLL:
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise ImportError(
            f"the C core is not built ({error}); run `make install` or `pip install .`"
        ) from None
    for name, (result, *arguments) in _FUNCTIONS.items():
        function = getattr(library, f"it2core_{name}")
        function.restype, function.argtypes = result, arguments
    return library


def library_function(name: str) -> Any:
    """Return a function of the library, whose arguments the caller declares."""
    return getattr(_library(), name)


def address(array: np.ndarray) -> int:
    """Return where an array is, in a quarter of the time that `array.ctypes` takes."""
    try:
        return ctypes.addressof(ctypes.c_char.from_buffer(array.data))
    except (TypeError, ValueError):  # it is read-only, or empty
        return array.ctypes.data


def _rules(rules: np.ndarray) -> tuple[np.ndarray, int]:
    rules = np.ascontiguousarray(rules, dtype=np.float64)
    if rules.ndim != 2 or rules.shape[1] != 6 or not 1 <= len(rules) <= MAX_RULES:
        raise InputError(f"rules must be an (L, 6) array with L = 1..{MAX_RULES}, not {rules.shape}")
    return rules, len(rules)


def _limits(limits: tuple[float, float] | None) -> np.ndarray:
    return np.array((-np.inf, np.inf) if limits is None else limits, dtype=np.float64)


def free_run(
    rules: np.ndarray, x: np.ndarray, y_initial: float, limits: tuple[float, float] | None = None
) -> np.ndarray:
    """Simulate the core from voltage alone.

    Parameters
    ----------
    rules : ndarray, shape (L, 6)
        Columns s1, s2, c, q1, q2, q3.
    x : ndarray, shape (N,)
        Voltage at every tick.
    y_initial : float
        Displacement before the first tick.
    limits : (float, float), optional
        Range of displacement that the rules hold for (`ParameterSet.displacement_range`). Beyond
        its ends the core goes on as its linearisation there, as in the FMUs. Without, it is (10)
        everywhere, which diverges beyond.

    Returns
    -------
    ndarray, shape (N,)
        ``y[k] = F(y[k-1], x[k])``; NaN from the sample on at which the run is no longer finite.
    """
    rules, count = _rules(rules)
    x = np.ascontiguousarray(x, dtype=np.float64)
    y = np.empty(len(x))
    done = _library().it2core_free_run(rules, count, _limits(limits), x, len(x), y_initial, y)
    y[done:] = np.nan
    return y


def _pairwise(
    function: str,
    rules: np.ndarray,
    y_previous: np.ndarray,
    other: np.ndarray,
    limits: tuple[float, float] | None,
) -> np.ndarray:
    rules, count = _rules(rules)
    first, second = np.broadcast_arrays(
        np.asarray(y_previous, dtype=np.float64), np.asarray(other, dtype=np.float64)
    )
    result = np.empty(first.size)
    getattr(_library(), function)(
        rules, count, _limits(limits), np.ascontiguousarray(first).ravel(),
        np.ascontiguousarray(second).ravel(), first.size, result,
    )  # fmt: skip
    return result.reshape(first.shape)


def one_step(
    rules: np.ndarray,
    y_previous: np.ndarray,
    x: np.ndarray,
    limits: tuple[float, float] | None = None,
) -> np.ndarray:
    """Evaluate the core at given pairs ``(y[k-1], x[k])``: the one-step-ahead prediction.

    `limits` are as for `free_run`, here and in the functions below.
    """
    return _pairwise("it2core_one_step", rules, y_previous, x, limits)


def solve(
    rules: np.ndarray,
    y_previous: np.ndarray,
    y: np.ndarray,
    limits: tuple[float, float] | None = None,
) -> np.ndarray:
    """Evaluate the inverse (30) at given pairs ``(y[k-1], y[k])``: the voltage x[k]."""
    return _pairwise("it2core_solve", rules, y_previous, y, limits)


def gradient(
    rules: np.ndarray, y_previous: float, x: float, limits: tuple[float, float] | None = None
) -> tuple[float, np.ndarray, np.ndarray]:
    """Evaluate the core and its derivatives, (13) to (18) within the range, at one point.

    Returns
    -------
    y : float
        Value of (10), or of what goes on from it.
    by_rules : ndarray, shape (L, 6)
        Derivatives with respect to the rules' parameters.
    by_arguments : ndarray, shape (3,)
        Derivatives with respect to ``x[k]``, ``y[k-1]`` and the end of the range that ``y[k-1]`` lies
        beyond; the last is 0 within.
    """
    rules, count = _rules(rules)
    by_rules, by_arguments = np.empty((count, 6)), np.empty(3)
    y = _library().it2core_gradient(
        rules, count, _limits(limits), y_previous, x, by_rules, by_arguments
    )
    return y, by_rules, by_arguments


def contraction(rules: np.ndarray, minimum: float, maximum: float) -> float:
    """Return the largest |dy[k]/dy[k-1]| on the equilibrium curve over a displacement range."""
    rules, count = _rules(rules)
    return _library().it2core_contraction(rules, count, minimum, maximum)


def usability(rules: np.ndarray, y: np.ndarray, x_low: np.ndarray, x_high: np.ndarray) -> np.ndarray:
    """Return the numbers of `it2.usability_function` at G displacements.

    Parameters
    ----------
    rules : array_like, shape (L, 6)
    y, x_low, x_high : ndarray, shape (G,)
        Displacements, and two voltages at each.

    Returns
    -------
    ndarray, shape (4, G)
        dy[k]/dy[k-1] of (10) at the equilibrium and at the two voltages, and dy[k]/dx[k].
    """
    rules, count = _rules(rules)
    values = np.empty((4, len(y)))
    band = [np.ascontiguousarray(v, dtype=np.float64) for v in (y, x_low, x_high)]
    _library().it2core_usability(rules, count, *map(address, band), len(y), address(values))
    return values


def check(rules: np.ndarray, minimum: float, maximum: float) -> str | None:
    """Return why rules are not admissible over a displacement range, or None if they are."""
    rules, count = _rules(rules)
    message = ctypes.create_string_buffer(512)
    if _library().it2core_check(rules, count, minimum, maximum, message, len(message)):
        return None
    return message.value.decode()


# --- the whole chain ---------------------------------------------------------------------------


def _places() -> dict[str, tuple[int, bool]]:
    """Return offset in bytes and whether it is an integer, of every parameter of the chain."""
    return _places_in(_library())


@cache
def _places_in(library: ctypes.CDLL) -> dict[str, tuple[int, bool]]:
    places: dict[str, tuple[int, bool]] = {}
    name, integer = ctypes.c_char_p(), ctypes.c_int()
    while True:
        offset = library.it2core_chain_parameter(len(places), ctypes.byref(name), ctypes.byref(integer))
        if not name.value:
            return places
        places[name.value.decode()] = (offset, bool(integer.value))


def chain_places(names: Sequence[str]) -> np.ndarray:
    """Return where Real parameters are in what `pack_chain` returns, shape (P,)."""
    places = _places()
    return np.array([places[name][0] // 8 for name in names], dtype=int)


@cache
def _offsets_in(library: ctypes.CDLL, names: tuple[str, ...]) -> ctypes.Array:
    """Return the offsets of parameters in bytes, as C takes them."""
    places = _places_in(library)
    return (ctypes.c_size_t * len(names))(*(places[name][0] for name in names))


def pack_chain(
    parameters: Mapping[str, float | int | bool], others: np.ndarray | None = None
) -> np.ndarray:
    """Return `struct chain_parameters` as an array; what is not given is 0, which is off.

    Parameters
    ----------
    parameters : Mapping
        Values by FMU variable name, such as a `ParameterSet`; nothing is checked here.
    others : ndarray, optional
        Packed values that the given ones are put into a copy of, instead.
    """
    packed = np.zeros(_library().it2core_chain_size() // 8) if others is None else others.copy()
    integers, places = packed.view(np.int32), _places()
    for name, value in parameters.items():
        offset, integer = places[name]
        if integer:
            integers[offset // 4] = value
        else:
            packed[offset // 8] = value
    return packed


def chain_check(parameters: Mapping[str, float | int | bool]) -> str | None:
    """Return why a parameter set is not admissible, or None if it is."""
    message = ctypes.create_string_buffer(512)
    if _library().it2core_chain_check(pack_chain(parameters), message, len(message)):
        return None
    return message.value.decode()


def _channels(*channels: np.ndarray | float) -> list[np.ndarray]:
    """Return channels as arrays of the first one's length."""
    first = np.ascontiguousarray(channels[0], dtype=np.float64)
    others = (np.broadcast_to(np.asarray(c, dtype=np.float64), first.shape) for c in channels[1:])
    return [first, *map(np.ascontiguousarray, others)]


def chain_free_run(
    parameters: Mapping[str, float | int | bool],
    voltage: np.ndarray,
    force: np.ndarray | float = 0.0,
    temperature: np.ndarray | float = REST_TEMPERATURE,
    first_tick: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Simulate the chain from rest at `initialDisplacement`: what the plant FMU computes.

    Parameters
    ----------
    parameters : Mapping
        A `ParameterSet`, or values by FMU variable name; packed (`pack_chain`) ones are taken too.
    voltage : ndarray, shape (N,)
        Voltage in V at every tick.
    force, temperature : ndarray, shape (N,), or float
        In N, compressive positive, and K.
    first_tick : int
        The first sample is at ``first_tick * sampleTime``.

    Returns
    -------
    displacement, measured : ndarray, shape (N,)
        NaN from the sample on at which the run is no longer finite.
    """
    return _chain_run(parameters, voltage, force, temperature, first_tick)[:2]


def chain_out_of_range(
    parameters: Mapping[str, float | int | bool],
    voltage: np.ndarray,
    force: np.ndarray | float = 0.0,
    temperature: np.ndarray | float = REST_TEMPERATURE,
    first_tick: int = 0,
) -> np.ndarray:
    """Return where the run of `chain_free_run` is beyond what the parameters hold for.

    Returns
    -------
    ndarray of bool, shape (N,)
        `outOfRange` of the plant FMU: the voltage is outside voltageMin..voltageMax or the core's
        displacement outside displacementMin..displacementMax.
    """
    return _chain_run(parameters, voltage, force, temperature, first_tick)[2] != 0


def _chain_run(
    parameters: Mapping[str, float | int | bool],
    voltage: np.ndarray,
    force: np.ndarray | float,
    temperature: np.ndarray | float,
    first_tick: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    packed = parameters if isinstance(parameters, np.ndarray) else pack_chain(parameters)
    voltage, force, temperature = _channels(voltage, force, temperature)
    displacement, measured = np.full(len(voltage), np.nan), np.full(len(voltage), np.nan)
    outside = np.zeros(len(voltage), dtype=np.int32)
    done = _library().it2core_chain_run(
        packed, voltage, force, temperature, first_tick, len(voltage), displacement, measured, outside
    )
    displacement[done:] = measured[done:] = np.nan
    return displacement, measured, outside


def chain_inverse_run(
    parameters: Mapping[str, float | int | bool],
    reference: np.ndarray,
    force: np.ndarray | float = 0.0,
    temperature: np.ndarray | float = REST_TEMPERATURE,
    first_tick: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Run the chain's inverse over a reference in m: what the inverse FMU computes.

    Parameters as for `chain_free_run`.

    Returns
    -------
    voltage : ndarray, shape (N,)
        In V.
    saturated : ndarray of bool, shape (N,)
        Where the plant does not follow: reference or voltage are kept to their limits, or the plant is
        not yet back from where they left it.
    """
    packed = parameters if isinstance(parameters, np.ndarray) else pack_chain(parameters)
    reference, force, temperature = _channels(reference, force, temperature)
    voltage, limits = np.full(len(reference), np.nan), np.zeros(len(reference), dtype=np.int32)
    done = _library().it2core_chain_inverse(
        packed, reference, force, temperature, first_tick, len(reference), voltage, limits
    )
    voltage[done:] = np.nan
    return voltage, limits != 0


def chain_equilibrium(parameters: Mapping[str, float | int | bool]) -> float:
    """Return the voltage in V that holds the chain at `initialDisplacement`.

    It is what the inverse FMU puts out before its first tick.
    """
    return _library().it2core_chain_equilibrium(pack_chain(parameters))


# --- the whole chain, as an identification needs it ----------------------------------------------


@dataclass(frozen=True, eq=False)
class Drive:
    """The inputs of the chain over a record.

    Parameters
    ----------
    voltage, force, temperature : ndarray, shape (N,)
        In V, N and K.
    """

    voltage: np.ndarray
    force: np.ndarray
    temperature: np.ndarray

    @classmethod
    def of(
        cls,
        voltage: np.ndarray,
        force: np.ndarray | float | None = None,
        temperature: np.ndarray | float | None = None,
    ) -> "Drive":
        """Return a drive; without force and at the reference temperature where not given."""
        force = 0.0 if force is None else force
        temperature = REST_TEMPERATURE if temperature is None else temperature
        return cls(*_channels(voltage, force, temperature))

    def __reduce__(self) -> tuple:
        """Leave the addresses behind when another process gets the channels."""
        return Drive, (self.voltage, self.force, self.temperature)

    @cached_property
    def _struct(self) -> _Record:
        channels = (self.voltage, self.force, self.temperature)
        return _Record(*(c.ctypes.data for c in channels), 0, len(self.voltage))


class Drives:
    """The inputs of the chain over several records, as one call takes them.

    Parameters
    ----------
    drives : sequence of Drive
        R of them, of N samples together.
    """

    def __init__(self, drives: Sequence[Drive]) -> None:
        self._drives = tuple(drives)
        self.lengths = np.array([len(d.voltage) for d in self._drives])
        self.firsts = np.cumsum(self.lengths) - self.lengths

    @property
    def mapped(self) -> Callable:
        """What maps over the records: their runs are shared among threads where that is worth it."""
        return thread_map if self._are_shared else map

    @property
    def _are_shared(self) -> bool:
        return has_threads() and len(self._drives) > 1 and self.lengths.sum() >= LONG

    def __reduce__(self) -> tuple:
        """Leave the addresses behind when another process gets the channels."""
        return Drives, (self._drives,)

    @cached_property
    def _structs(self) -> ctypes.Array:
        return (_Record * len(self._drives))(*(d._struct for d in self._drives))


def chain_predict_each(packed: np.ndarray, drives: Drives) -> np.ndarray | None:
    """Simulate records as `chain_predict` does, in one call.

    Parameters
    ----------
    packed : ndarray, shape (R, ...)
        Parameters of each record, from `pack_chain`.
    drives : Drives

    Returns
    -------
    ndarray, shape (N,), or None
        The readings in m, record after record; None if one is not finite.
    """
    measured = np.empty(int(drives.lengths.sum()))
    count, stride = packed.shape
    run, structs, output = _library().it2core_chain_predict_each, drives._structs, address(measured)
    values = address(packed)
    if not drives._are_shared:
        return measured if run(values, stride, structs, count, output) else None

    def run_one(i: int) -> bool:
        first = output + measured.itemsize * int(drives.firsts[i])
        return run(values + packed.strides[0] * i, stride, structs[i], 1, first)

    return measured if all(thread_map(run_one, range(count))) else None


def chain_predict(packed: np.ndarray, drive: Drive) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Simulate the chain from rest at the first voltage of a record, its core being (10) everywhere.

    A fit does not know yet which range its core holds for: what the FMU computes, and reports say, is
    `chain_free_run`.

    Parameters
    ----------
    packed : ndarray
        Parameters, from `pack_chain`. `initialDisplacement` is where the search for the displacement at
        rest begins; the history before it is that of `initialDemagnetisation`, `initialExcursion`,
        `initialCreep` and `initialCreepAge`.
    drive : Drive

    Returns
    -------
    measured : ndarray, shape (N,)
        The reading in m; NaN from the sample on at which the run is no longer finite.
    core_input, core_output : ndarray, shape (N,)
        In V and m.
    """
    outputs = np.empty((3, len(drive.voltage)))
    # by address: a fit of short records would else spend its time on checks of its own arrays
    first, step = outputs.ctypes.data, outputs.strides[0]
    addresses = (first, first + step, first + 2 * step)
    done = _library().it2core_chain_predict(packed, drive._struct, *addresses)
    outputs[:, done:] = np.nan
    measured, core_input, core_output = outputs
    return measured, core_input, core_output


def chain_sensitivity(
    packed: np.ndarray, drive: Drive, names: Sequence[str], by_rules: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Simulate as `chain_predict` with derivatives.

    Parameters
    ----------
    packed, drive
        As in `chain_predict`.
    names : sequence of str
        Parameters of effects, by their FMU variable names: at most 96.
    by_rules : bool
        Whether the derivatives by the rules' parameters are wanted, too.

    Returns
    -------
    measured : ndarray, shape (N,)
    sensitivity : ndarray, shape (N, 6 L + len(names))
        Derivatives by the rules' parameters, row by row, and these. NaN from the sample on at which
        the run is no longer finite. Without rules it has no columns of theirs.
    """
    rows = int(packed.view(np.int32)[_places()["ruleCount"][0] // 4]) if by_rules else 0
    columns = 6 * rows + len(names)
    offsets = _offsets_in(_library(), tuple(names))
    measured, sensitivity = np.empty(len(drive.voltage)), np.empty((len(drive.voltage), columns))
    done = _library().it2core_chain_sensitivity(
        address(packed),
        drive._struct,
        by_rules,
        offsets,
        len(names),
        address(measured),
        address(sensitivity),
    )
    measured[done:] = sensitivity[done:] = np.nan
    return measured, sensitivity
