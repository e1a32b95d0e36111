"""What a report was made of: its records by their roles, and other files."""

from __future__ import annotations

from collections.abc import Mapping

from it2hys.reports.page import NONE, Section, Table

#: What a page calls the roles of records.
ROLES = {"train": "training", "validation": "validation", "test": "test"}


def inputs_section(report: Mapping) -> Section:
    """Return what a report was made of, and how it is drawn again."""
    rows = [
        [i["name"], ROLES.get(i["role"], i["role"]), i["file"] or NONE, i["sha256"] or NONE]
        for i in report["inputs"]
    ]
    seed = "" if report["seed"] is None else f" Seed of the random starts: {report['seed']}."
    text = (
        f"Written by it2hys {report['version']}.{seed} `it2hys report DIR`, with the directory of this "
        "page, draws it again."
    )
    table = [Table(["name", "role", "file", "SHA-256"], rows)] if rows else []
    return Section("Inputs", [text], table)
