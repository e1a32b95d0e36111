"""The verdict of a report: whether the model beats a straight line, and feedforward beats none."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from it2hys.records import Record
from it2hys.records.figures_of_merit import Errors, errors

UM = 1e6
#: Roles in the order in which they count: records that were not fitted come first.
COUNTING = ("test", "validation", "train")
#: Number of records that a sentence names.
_NAMED = 3


class Compared(Protocol):
    """The errors of a model on one record."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def role(self) -> str: ...  # noqa: D102
    @property
    def e_mr(self) -> float: ...  # noqa: D102
    @property
    def e_rms(self) -> float: ...  # noqa: D102


class Judged(Compared, Protocol):
    """How a model does on one record: what both kinds of results have."""

    @property
    def offset(self) -> float: ...  # noqa: D102
    @property
    def used(self) -> np.ndarray: ...  # noqa: D102


def straight_line(records: Sequence[Record], results: Sequence[Judged]) -> tuple[float, float]:
    """Return slope (m/V) and offset (m) of one straight line from voltage to displacement.

    It is what one has without a model of hysteresis. It gets what the model got: it is fitted to the
    training records, or to all of them where a model was trained elsewhere, on the same samples, and
    differs from record to record by a constant if the model does; the offset is the mean one then.

    Parameters
    ----------
    records : sequence of Record
    results : sequence of Judged
        How the model does on them, in the same order.

    Returns
    -------
    slope, offset : float
    """
    pairs = _judged_samples(records, results)
    train = [pair for pair, s in zip(pairs, results, strict=True) if s.role == "train"] or pairs
    centred = train
    if has_offsets(results):
        centred = [(x - x.mean(), y - y.mean()) for x, y in train]
    slope = np.polyfit(*_joined(centred), 1)[0]
    x, y = _joined(train)
    return float(slope), float(np.mean(y - slope * x))


def straight_line_errors(records: Sequence[Record], results: Sequence[Judged]) -> list[Errors]:
    """Return the errors of `straight_line` on the samples on which the model is judged, by record."""
    slope, offset = straight_line(records, results)
    own = has_offsets(results)
    return [
        errors(y, slope * x + (np.mean(y - slope * x) if own else offset))
        for x, y in _judged_samples(records, results)
    ]


def has_offsets(results: Sequence[Judged]) -> bool:
    """Return whether a constant between records and model was fitted."""
    return any(result.offset != 0.0 for result in results)


def _judged_samples(
    records: Sequence[Record], results: Sequence[Judged]
) -> list[tuple[np.ndarray, np.ndarray]]:
    return [(r.voltage[s.used], r.displacement[s.used]) for r, s in zip(records, results, strict=True)]


def _joined(pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    x, y = zip(*pairs, strict=True)
    return np.concatenate(x), np.concatenate(y)


def judging_role(results: Sequence[Compared]) -> str:
    """Return the role of the records that count: test; where there is none, validation or training."""
    roles = {result.role for result in results}
    return next(role for role in COUNTING if role in roles)


def no_better_than_a_line(
    results: Sequence[Compared], lines: Sequence[Errors]
) -> list[tuple[Compared, Errors]]:
    """Return those of the records that count on which an error of the model is not below the line's."""
    role = judging_role(results)
    return [
        (result, line)
        for result, line in zip(results, lines, strict=True)
        if result.role == role and not (result.e_mr < line.e_mr and result.e_rms < line.e_rms)
    ]


def model_verdict(results: Sequence[Compared], lines: Sequence[Errors], advice: str) -> list[str]:
    """Return a sentence that says so if the model does no better than a straight line.

    Parameters
    ----------
    results : sequence of Compared
    lines : sequence of Errors
        Of `straight_line_errors`.
    advice : str
        What to do then, as a sentence.

    Returns
    -------
    list of str
        The sentence and the advice, or nothing.
    """
    worse = no_better_than_a_line(results, lines)
    if not worse:
        return []
    named = [
        f"{r.name} ({_beside(Errors(r.e_mr, r.e_rms), line, 'line')})" for r, line in worse[:_NAMED]
    ]
    more = f" and {len(worse) - _NAMED} more" if len(worse) > _NAMED else ""
    by = _by_which([(Errors(r.e_mr, r.e_rms), line) for r, line in worse])
    text = f"{by}this model does no better than a straight line on {', '.join(named)}{more}"
    return [f"{_as_sentence(text)} {advice}"]


def feedforward_verdict(inverse: Errors, none: Errors, advice: str) -> list[str]:
    """Return a sentence that says so if the inverse tracks worse than no feedforward does."""
    if inverse.e_mr <= none.e_mr and inverse.e_rms <= none.e_rms:
        return []
    by = _by_which([(inverse, none)])
    text = f"{by}the inverse as feedforward is worse than none: {_beside(inverse, none, 'none')}"
    return [f"{_as_sentence(text)} {advice}".rstrip()]


def _by_which(pairs: Sequence[tuple[Errors, Errors]]) -> str:
    """Return the error by which something is not the better one, unless it is both."""
    largest = any(not ours.e_mr < theirs.e_mr for ours, theirs in pairs)
    rms = any(not ours.e_rms < theirs.e_rms for ours, theirs in pairs)
    if largest and rms:
        return ""
    return "by its largest error " if largest else "by its rms error "


def _as_sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."


def percent(share: float) -> str:
    """Return a share in per cent, with two decimals below 1 % and one above."""
    return f"{100 * share:.{2 if share < 0.01 else 1}f} %"


def _beside(ours: Errors, theirs: Errors, name: str) -> str:
    return (
        f"e_mr {100 * ours.e_mr:.3g} %, {name} {100 * theirs.e_mr:.3g} %; "
        f"e_rms {ours.e_rms * UM:.3g} µm, {name} {theirs.e_rms * UM:.3g} µm"
    )
