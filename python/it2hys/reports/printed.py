"""A report as text for the terminal: tables of all records and effects, then the answers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from it2hys.reports.answers import answers, notes, small
from it2hys.reports.details import change_of, error_table
from it2hys.reports.page import Table


def printed(report: Mapping) -> str:
    """Return what is printed of a report.

    Parameters
    ----------
    report : Mapping
        `report.json`.
    """
    return "\n\n".join(_blocks(report))


def _blocks(report: Mapping) -> Iterator[str]:
    yield error_table(report).text()
    if report["evidence"]:
        yield _effects(report).text()
    for answer in answers(report):
        lines = [answer.question.upper(), *answer.texts]
        if answer.table:
            lines.append(answer.table.text())
        yield "\n".join([*lines, *answer.after])
    told = notes(report)
    if told:
        yield "\n".join(["NOTES", *told])


def _effects(report: Mapping) -> Table:
    """Return the verdict on every effect, and its figures."""
    rows = [
        [
            e["effect"],
            _verdict(e, report),
            change_of(e["held_out_gain_percent"]),
            small(e["held_out_p_value"], ".2g"),
            small(e["p_value"], ".2g"),
        ]
        for e in report["evidence"]
    ]
    return Table(["effect", "verdict", "error change %", "p", "signature p"], rows)


def _verdict(entry: Mapping, report: Mapping) -> str:
    if entry["accepted"]:
        return "added"
    if any(entry["effect"] in group for group in report["indistinguishable"]):
        return "indistinguishable"
    if entry["effect"] in report["declared"]:
        return "declared"
    return "not tried" if entry["held_out_gain_percent"] is None else "not added"
