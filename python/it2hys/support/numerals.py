"""Numbers as files have them, and as people read them."""

import re

_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|[+-]?(inf|infinity|nan)", re.I)


def parse_number(text: str) -> float:
    """Return the number that a text is, infinities and NaN included.

    `float` also takes underscores and the digits of all scripts, which no file format means.

    Raises
    ------
    ValueError
        If the text is not a number.
    """
    text = text.strip(" \t\r\n")
    if not _NUMBER.fullmatch(text):
        raise ValueError(f"{text!r} is not a number")
    return float(text)


def counted(count: int, noun: str) -> str:
    """Return a count with its noun, in the plural unless it is one."""
    return f"{count} {noun}{'' if count == 1 else 'es' if noun.endswith('ch') else 's'}"


def plain(value: float, digits: int = 3) -> str:
    """Return a number to so many significant digits, as a power of ten only where it is far from 1."""
    short = f"{value:.{digits}g}"
    return f"{float(short):.0f}" if "e+" in short and abs(value) < 1e7 else short
