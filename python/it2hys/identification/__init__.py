"""Identification of the paper's model from measured records."""

from it2hys.identification.identify import identify
from it2hys.identification.result import (
    Identification,
    IdentificationError,
    Options,
    OrderTrial,
    RecordResult,
    Start,
)

__all__ = [
    "Identification",
    "IdentificationError",
    "Options",
    "OrderTrial",
    "RecordResult",
    "Start",
    "identify",
]
