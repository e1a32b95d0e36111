"""The text of SSP parameter sets (SSV).

Only the standard library is used, because the C build hashes Table 1's text.
"""

from collections.abc import Mapping
from xml.sax.saxutils import escape, quoteattr

from it2hys.model.variables import DeclaredType, load_table

SSV_NAMESPACE = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"


def format_set(parameters: Mapping[str, float | int | bool], name: str) -> str:
    """Return values of parameters, in SI units, as SSV text under a name."""
    types = {entry: variable.type for entry, variable in load_table().parameters().items()}
    return format_entries(parameters, types, name)


def format_entries(
    values: Mapping[str, float | int | bool], types: Mapping[str, DeclaredType], name: str
) -> str:
    """Return values of declared types as SSV text under a name.

    The profile that common masters read: the literal prefix `ssv:`, version 1.0 and only Real,
    Integer and Boolean entries; numbers are written with the fewest digits that read back to the
    same bits.
    """
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<ssv:ParameterSet xmlns:ssv="{SSV_NAMESPACE}" version="1.0" name={quoteattr(name)}>',
        "  <ssv:Parameters>",
    ]
    for entry, value in values.items():
        kind = types[entry]
        text = str(value).lower() if kind.base == "Boolean" else repr(value)
        unit = f" unit={quoteattr(kind.unit)}" if kind.unit else ""
        lines += [
            f"    <ssv:Parameter name={quoteattr(entry)}>",
            f'      <ssv:{kind.base} value="{escape(text)}"{unit}/>',
            "    </ssv:Parameter>",
        ]
    return "\n".join([*lines, "  </ssv:Parameters>", "</ssv:ParameterSet>", ""])
