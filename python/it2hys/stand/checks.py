"""Checks shared by the parameter classes of the rig."""

import math

import numpy as np

from it2hys.errors import InputError


def require(part, condition, message):
    """Refuse a parameter of a part.

    Parameters
    ----------
    part : object
        The part, named in the message by its class.
    condition : bool
        What must hold.
    message : str
        What must hold, in words.

    Raises
    ------
    InputError
        If `condition` is false.
    """
    if not condition:
        raise InputError(f"rig: {type(part).__name__}: {message}")


def require_positive(part, *names):
    """Refuse parameters that are not numbers above zero; infinity is allowed ("ideal").

    Raises
    ------
    InputError
        If one of the named fields is zero, negative or NaN.
    """
    for name in names:
        value = getattr(part, name)
        require(part, value > 0.0, f"{name} must be positive, not {value!r}")


def require_finite(part, *names, minimum=-math.inf):
    """Refuse parameters that are not finite or lie below `minimum`.

    Raises
    ------
    InputError
        If one of the named fields is infinite, NaN or below `minimum`.
    """
    for name in names:
        value = getattr(part, name)
        message = f"{name} must be finite and at least {minimum}, not {value!r}"
        require(part, math.isfinite(value) and value >= minimum, message)


def finite_signal(values, name, length=None):
    """Give a signal as a float array, refusing what the rig cannot be driven with.

    Parameters
    ----------
    values : array_like, shape (n,)
        The samples.
    name : str
        What the signal is, for the message.
    length : int, optional
        The number of samples that it must have.

    Returns
    -------
    numpy.ndarray, shape (n,)

    Raises
    ------
    InputError
        If the signal is empty, not one-dimensional, not of the given length, or not finite.
    """
    try:
        signal = np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"rig: {name} is not a sequence of numbers") from error
    if signal.ndim != 1 or signal.size == 0:
        raise InputError(f"rig: {name} must be a non-empty row of samples, not {signal.shape}")
    if length is not None and signal.size != length:
        raise InputError(f"rig: {name} has {signal.size} samples where voltage has {length}")
    bad = np.flatnonzero(~np.isfinite(signal))
    if bad.size:
        raise InputError(f"rig: {name} is {signal[bad[0]]} at sample {bad[0]}")
    return signal
