"""Which column of a file holds which quantity, and in which unit."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from it2hys.errors import InputError
from it2hys.records.text import HEADER, Source
from it2hys.records.units import DEFAULT_UNITS, UNITS, known_unit, split_name, unknown_unit

#: NAME, "NAME:UNIT" or (NAME, UNIT).
ColumnChoice = str | tuple[str, str | None]


@dataclass(frozen=True)
class Column:
    """Where a quantity stands in the file."""

    index: int
    name: str
    unit: str
    note: str = ""


def parse_column_option(option: str) -> tuple[str, str, str | None]:
    """Split the command line's ``--column QUANTITY=NAME[:UNIT]``.

    Parameters
    ----------
    option : str
        For example ``voltage=Vin`` or ``displacement=y:um``.

    Returns
    -------
    tuple of (str, str, str or None)
        Quantity, column name, and unit where one is given.

    Raises
    ------
    InputError
        Where the form is another, or the quantity or the unit is unknown.
    """
    quantity, equals, name = (part.strip() for part in option.partition("="))
    if not equals or not name:
        raise InputError(
            f"--column {option}: the form is QUANTITY=NAME or QUANTITY=NAME:UNIT, as in voltage=Vin:mV"
        )
    _check_quantity(quantity, UNITS)
    name, unit = _split_choice(quantity, name)
    return quantity, name, unit


def choose_columns(
    source: Source, quantities: Collection[str], choices: Mapping[str, ColumnChoice]
) -> dict[str, Column]:
    """Return the column of each of the quantities that the file has."""
    for quantity in choices:
        _check_quantity(quantity, quantities)
    chosen = {q: _mapped_column(source, q, choices[q]) for q in quantities if q in choices}
    # a damper's 'force_kN' that is to be the displacement is no load beside it
    taken = {column.name for column in chosen.values()}
    for quantity in quantities:
        if quantity not in choices:
            column = _named_column(source, quantity, taken)
            if column is not None:
                chosen[quantity] = column
    return {q: chosen[q] for q in quantities if q in chosen}


def no_columns(source: Source, missing: Collection[str], taken: Collection[str]) -> InputError:
    """Return the error that quantities have no column; it proposes those whose unit tells them.

    Parameters
    ----------
    source : Source
    missing : collection of str
        The quantities.
    taken : collection of str
        Names of columns that hold others.
    """
    them = "it" if len(missing) == 1 else "them"
    wanted = ", ".join(f"{quantity}_{_first_unit(quantity)}" for quantity in missing)
    options = " ".join(
        f"--column {shlex.quote(_proposed(source, quantity, taken))}" for quantity in missing
    )
    return source.fault(
        f"no column for {', '.join(missing)}; the header has {listed(source.names)}. Name {them} "
        f"{wanted}, or map {them} by {options}",
        HEADER,
    )


def _proposed(source: Source, quantity: str, taken: Collection[str]) -> str:
    """Return a mapping to the one column that has such a unit, or how one is written."""
    free = [name for name in source.names if name not in taken]
    fitting = [name for name in free if _written_unit(source, name) in UNITS[quantity]]
    if len(fitting) == 1:
        return f"{quantity}={fitting[0]}"
    return f"{quantity}=NAME:{_first_unit(quantity)}"


def _first_unit(quantity: str) -> str:
    return next(iter(UNITS[quantity]))


def listed(names: Collection[str]) -> str:
    """Return names in quotation marks, for messages."""
    return ", ".join(f"'{name}'" for name in names)


def _mapped_column(source: Source, quantity: str, choice: ColumnChoice) -> Column:
    if not isinstance(choice, str):
        name, unit = choice
    elif choice in source.names:  # a column's name may hold a colon itself
        name, unit = choice, None
    else:
        name, unit = _split_choice(quantity, choice)
    if name not in source.names:
        raise source.fault(
            f"no column '{name}' for {quantity}; the header has {listed(source.names)}", HEADER
        )
    if unit is not None:
        return _column(source, quantity, name, known_unit(quantity, unit))
    unit = _written_unit(source, name)
    return _column(source, quantity, name, unit if unit in UNITS[quantity] else "")


def _named_column(source: Source, quantity: str, taken: Collection[str]) -> Column | None:
    """Find the quantity in the header, with or without a unit, in a column that is not taken."""
    units = {}
    for name in source.names:
        if split_name(name)[0].lower() == quantity and name not in taken:
            units[name] = _written_unit(source, name)
    usable = [name for name, unit in units.items() if unit in UNITS[quantity] or not unit]
    if len(usable) > 1:
        raise source.fault(
            f"more than one column for {quantity}: {listed(usable)}. Name the right one by "
            f"--column {quantity}={usable[0]}",
            HEADER,
        )
    if usable:
        return _column(source, quantity, usable[0], units[usable[0]])
    for name, unit in units.items():
        raise source.fault(f"column '{name}': {unknown_unit(quantity, unit)}", HEADER)
    return None


def _written_unit(source: Source, name: str) -> str:
    """Return the unit in a column's name, or else that of the row below the header."""
    return split_name(name)[1] or source.units.get(name, "")


def _column(source: Source, quantity: str, name: str, unit: str) -> Column:
    index = source.names.index(name)
    if unit:
        return Column(index, name, unit)
    default = DEFAULT_UNITS.get(quantity)
    if default is None:
        known = ", ".join(UNITS[quantity])
        raise source.fault(
            f"column '{name}' has no unit. Add it to the name, or give it by "
            f"--column {quantity}={name}:UNIT with one of {known}",
            HEADER,
        )
    return Column(index, name, default, f"Column '{name}' has no unit; taken as {default}.")


def _split_choice(quantity: str, choice: str) -> tuple[str, str | None]:
    """Split NAME or NAME:UNIT."""
    name, colon, unit = (part.strip() for part in choice.rpartition(":"))
    return (name, known_unit(quantity, unit)) if colon else (choice, None)


def _check_quantity(quantity: str, known: Collection[str]) -> None:
    if quantity not in known:
        raise InputError(f"--column: unknown quantity '{quantity}'; known are {', '.join(known)}")
