"""Identification of the paper's model from measured records."""

from it2hys.identification.identify import identify
from it2hys.identification.preparation import check_rule_count
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
    "check_rule_count",
    "identify",
]
