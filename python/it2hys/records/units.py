"""The quantities of a record, the units they come in, and how a unit is spelt in a header."""

import re

import numpy as np

from it2hys.errors import InputError

_LENGTH = {"um": (1e6, 0.0), "nm": (1e9, 0.0), "mm": (1e3, 0.0), "m": (1.0, 0.0)}

#: Units by quantity, as (divisor, offset): SI value = (value + offset) / divisor. Dividing by an
#: exact power of ten rounds once, so that 5 ms becomes the float that "0.005" would be.
UNITS: dict[str, dict[str, tuple[float, float]]] = {
    "time": {"s": (1.0, 0.0), "ms": (1e3, 0.0), "us": (1e6, 0.0)},
    "voltage": {"V": (1.0, 0.0), "mV": (1e3, 0.0), "uV": (1e6, 0.0), "kV": (1e-3, 0.0)},
    "displacement": _LENGTH,
    "force": {"N": (1.0, 0.0), "mN": (1e3, 0.0), "kN": (1e-3, 0.0)},
    "temperature": {"K": (1.0, 0.0), "degC": (1.0, 273.15)},
    "reference": _LENGTH,
}

#: Taken where a column carries no unit. Lengths and temperatures have none: um and m, or degC and
#: K, are equally common, and the wrong one would look plausible.
DEFAULT_UNITS = {"time": "s", "voltage": "V", "force": "N"}

#: The unit of numbers without one, which a column's name does not tell.
DIMENSIONLESS = "1"

_SCALES = {unit: scale for units in UNITS.values() for unit, scale in units.items()}
_SCALES[DIMENSIONLESS] = (1.0, 0.0)

_BRACKETED = re.compile(r"(?P<head>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))")


def is_unit(text: str) -> bool:
    """Tell whether a text is one of the units, or of the dimensionless ``-``."""
    return plain_unit(text) in {*_SCALES, "-"}


def to_si(values: np.ndarray, unit: str) -> np.ndarray:
    """Convert numbers in a unit to SI."""
    divisor, offset = _SCALES[unit]
    return (values + offset) / divisor


def from_si(values: np.ndarray, unit: str) -> np.ndarray:
    """Convert SI numbers to a unit."""
    divisor, offset = _SCALES[unit]
    return values * divisor - offset


def plain_unit(unit: str) -> str:
    """Spell the micro sign (U+00B5, or the Greek letter U+03BC) and the degree sign in ASCII."""
    return unit.strip().replace("\u00b5", "u").replace("\u03bc", "u").replace("\u00b0", "deg")


def known_unit(quantity: str, unit: str) -> str:
    """Return the plain spelling of a unit given on the command line, or refuse it."""
    plain = plain_unit(unit)
    if plain not in UNITS[quantity]:
        raise InputError(f"--column {quantity}: {unknown_unit(quantity, unit)}")
    return plain


def unknown_unit(quantity: str, unit: str) -> str:
    """Return the complaint about a unit."""
    return f"unknown unit '{unit}' for {quantity}; known are {', '.join(UNITS[quantity])}"


def split_name(name: str) -> tuple[str, str]:
    """Split a column's name into what it calls and its unit, as spelt in ASCII.

    ``voltage_V``, ``voltage [V]`` and ``voltage (V)`` are understood; the unit is empty where
    there is none.
    """
    match = _BRACKETED.fullmatch(name)
    if match:
        return match["head"], plain_unit(match["square"] or match["round"] or "")
    head, underscore, unit = name.rpartition("_")
    return (head, plain_unit(unit)) if underscore else (name, "")
