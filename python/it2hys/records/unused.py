"""Sentences on the columns of files that are not used, and how to use them."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

from it2hys.records.columns import listed
from it2hys.records.record import Record
from it2hys.records.units import UNITS, split_name

#: Quantities that a column may hold beside those that every record has, by how people abbreviate them.
_MEANT = {"temperature": ("temp", "t_"), "force": ("force", "load", "f_"), "reference": ("ref", "set")}
#: Consequence of leaving out a column of a quantity.
_USE = {
    "temperature": "without it, drift is tried with time alone",
    "force": "without it, load is not tried",
    "reference": "without it, the desired displacement is not known",
}
#: The unit that the advice gives where a column's name has none, or one that is not known.
_LIKELY = {"temperature": "degC", "force": "N", "reference": "um"}
#: Number of records that a sentence names.
_NAMED = 3


def unused_columns(records: Sequence[Record]) -> list[str]:
    """Return a sentence for each set of columns that were not used, with how to use them."""
    places: dict[tuple[str, ...], list[Record]] = {}
    for record in records:
        if record.unused:
            places.setdefault(record.unused, []).append(record)
    return [_sentence(names, those) for names, those in places.items()]


def _sentence(names: tuple[str, ...], records: Sequence[Record]) -> str:
    one = len(names) == 1
    head, verb = ("Column", "is") if one else ("Columns", "are")
    text = f"{head} {listed(names)} of {_those(records)} {verb} not used."
    advice = [a for a in (_advice(name, records) for name in names) if a]
    known = ", ".join(quantity for quantity in _USE if _lacks(records, quantity))
    if not advice and known:
        advice = [f"If one is {known}, name it by --column QUANTITY=NAME:UNIT."]
    return " ".join([text, *advice])


def _those(records: Sequence[Record]) -> str:
    names = [f"'{r.name}'" for r in records[:_NAMED]]
    more = f" and {len(records) - _NAMED} more" if len(records) > _NAMED else ""
    return f"record{'' if len(records) == 1 else 's'} {', '.join(names)}{more}"


def _lacks(records: Sequence[Record], quantity: str) -> bool:
    return any(getattr(r, quantity) is None for r in records)


def _advice(name: str, records: Sequence[Record]) -> str:
    """Return how to use a column that looks like a quantity that the records lack, or nothing."""
    quantity = _meant(name)
    if quantity is None or not _lacks(records, quantity):
        return ""
    unit = split_name(name)[1]
    unit = unit if unit in UNITS[quantity] else _LIKELY[quantity]
    option = shlex.quote(f"{quantity}={name}:{unit}")
    return f"If '{name}' is the {quantity}, add --column {option}: {_USE[quantity]}."


def _meant(name: str) -> str | None:
    """Return the quantity that a column looks like, by its unit or by how its name begins."""
    head, unit = split_name(name)
    for quantity, beginnings in _MEANT.items():
        own = unit in UNITS[quantity] and quantity != "reference"
        if own or head.lower().startswith(beginnings) or name.lower().startswith(beginnings):
            return quantity
    return None
