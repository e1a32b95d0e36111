"""Tables of TOML files as pydantic models, with messages that name the key and the mend."""

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from it2hys.errors import InputError
from it2hys.support.keys import known_names

T = TypeVar("T", bound=BaseModel)

#: The expected value in words, by pydantic's type of an error and its context.
_MUST = {
    "float_type": "a number", "int_type": "a whole number", "string_type": "a text",
    "bool_type": "true or false", "tuple_type": "a list", "dict_type": "a table",
    "literal_error": "one of {expected}", "finite_number": "finite",
    "greater_than": "positive", "greater_than_equal": "at least {ge:g}",  # the former: than 0
}  # fmt: skip


class Table(BaseModel):
    """A table of a TOML file. A field with ``init=False`` is no key: it is set by `model_copy`.

    What a key means stands below it, for the documentation.

    Raises
    ------
    ValueError
        If a key is unknown. With ``extra="allow"``, unknown keys are in `model_extra`.
    """

    model_config = ConfigDict(frozen=True, use_attribute_docstrings=True)

    @model_validator(mode="before")
    @classmethod
    def _know_every_key(cls, table: object) -> object:
        if isinstance(table, Mapping):
            known = [f.alias or name for name, f in cls.model_fields.items() if f.init is not False]
            free = cls.model_config.get("extra") == "allow"
            for key in table:
                if key not in known and (not free or key in cls.model_fields):
                    raise ValueError(f"unknown key {key!r}; {known_names(key, known)}")
        return table


def read_table(kind: type[T], table: object) -> T:
    """Return a table as a model of some kind.

    Raises
    ------
    InputError
        With the first mistake: the path of the key, its value, and what it must be.
    """
    try:
        return kind.model_validate(table)
    except ValidationError as error:
        raise InputError(_told(error.errors(include_url=False)[0])) from None


def _told(error: Any) -> str:
    """Return an error of pydantic in plain words."""
    kind, value, context = error["type"], error["input"], error.get("ctx", {})
    *above, last = error["loc"] or ("",)
    if kind == "missing":
        given = ", ".join(value) or "none"
        return f"{_place(above)}key {last!r} is missing; other keys given: {given}"
    if kind == "value_error" and isinstance(value, Mapping):  # said of a whole table
        return f"{_place(error['loc'])}{context['error']}"
    if kind == "model_type":
        return f"{_place(error['loc']).removesuffix(': ')} is {value!r}; it must be a table".lstrip()
    subject, where = "it", f"{_place(above)}{last} is"
    if isinstance(last, int):
        subject, where = "each", f"{_place(above).removesuffix(': ')} has"
    if kind == "value_error":
        return f"{where} {value!r}; {context['error']}"
    expected = context.get("expected", "").replace("'", "").replace(" or ", ", ")
    must = _MUST[kind].format(**{**context, "expected": expected})
    return f"{where} {value!r}; {subject} must be {must}"


def _place(path: Any) -> str:
    """Return the path of a table as messages begin: ``"fmu.plant: "``, ``"record 1: paper: "``."""
    place = ""
    for key in path:
        if isinstance(key, int):
            place = f"{place.removesuffix(': ')} {key + 1}: "
        else:
            place += f".{key}" if place and not place.endswith(": ") else key
    return place and place.removesuffix(": ") + ": "
