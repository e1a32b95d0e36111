"""The fit engine, for the paper's model and for the whole chain; `identify` is the former."""

from it2hys.identification.identify import identify
from it2hys.identification.judgement import Judgement
from it2hys.identification.preparation import check_rule_count
from it2hys.identification.result import (
    SOLVERS,
    Fitted,
    Identification,
    IdentificationError,
    Options,
    OrderTrial,
    Start,
)

__all__ = [
    "SOLVERS",
    "Fitted",
    "Identification",
    "IdentificationError",
    "Judgement",
    "Options",
    "OrderTrial",
    "Start",
    "check_rule_count",
    "identify",
]
