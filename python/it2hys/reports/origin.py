"""What a parameter set was identified from, for the documentation of its FMUs."""

import os
from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np

from it2hys.fmu.documentation import Origin, OriginRecord
from it2hys.identification.judgement import Judgement
from it2hys.records import Record

_UM = 1e6
_HEADS = (
    "duration s", "voltage V", "displacement µm", "e_rms µm", "e_mr %", "noise µm", "offset µm",
)  # fmt: skip


def origin(verb: str, records: Sequence[Record], judgements: Sequence[Judgement]) -> Origin:
    """Return what a model was made from, and how it does on it.

    Parameters
    ----------
    verb : str
        The command that made it, such as "identify".
    records : sequence of Record
    judgements : sequence of Judgement
        Of the model, in the order of the records.
    """
    pairs = zip(records, judgements, strict=True)
    rows = [OriginRecord(r.name, j.role, _row(r, j)) for r, j in pairs]
    return Origin(f"it2hys {verb}", _today(), _HEADS, rows)


def _row(record: Record, judgement: Judgement) -> list[str]:
    return [
        f"{len(record.time) * record.sample_time:.4g}",
        _span(record.voltage),
        _span(record.displacement * _UM),
        f"{judgement.e_rms * _UM:.3g}",
        f"{100 * judgement.e_mr:.3g}",
        f"{judgement.noise * _UM:.3g}",
        f"{judgement.offset * _UM:.3g}",
    ]


def _span(values: np.ndarray) -> str:
    return f"{values.min():.4g} to {values.max():.4g}"


def _today() -> str:
    """Return the date; that of SOURCE_DATE_EPOCH where a build is to be repeated to the byte."""
    if "SOURCE_DATE_EPOCH" in os.environ:
        moment = datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), UTC)
    else:
        moment = datetime.now(UTC)
    return moment.date().isoformat()
