"""The outcome of a diagnosis: parameter set, FMUs, report and JSON in one directory."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from it2hys.cosimulation.simulation import track
from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.outcome import Diagnosis, Judgement
from it2hys.diagnosis.selection import COMPARISONS, LEVEL
from it2hys.fmu.packaging import package
from it2hys.identification.effect_coordinates import BY_RECORD, OF_READING
from it2hys.identification.explained import low_shares
from it2hys.model import compiled
from it2hys.model.variables import load_table
from it2hys.policy import SEARCH
from it2hys.records import Record
from it2hys.records.figures_of_merit import (
    Errors,
    change_in_percent,
    max_relative_error,
    noise_size,
    rms_error,
    small_figure,
)
from it2hys.reports import figures
from it2hys.reports.judged import (
    ROLES,
    UM,
    finite_or_none,
    inverse_picture,
    inverse_table,
    inversion,
    judgement_json,
    label,
    parameter_row,
    record_texts,
    records_json,
)
from it2hys.reports.origin import origin
from it2hys.reports.page import NONE, Picture, Section, Table, write_report
from it2hys.reports.verdict import judging_role, model_verdict, percent, straight_line_errors
from it2hys.stand.excitations import time_grid, tracking_reference
from it2hys.support.files import make_directory, write_atomically
from it2hys.support.progress import Progress

#: The paper's reference: so long at its sample time.
_REFERENCE_DURATION, SAMPLE_TIME = 0.15, 1e-4
#: Records whose residuals are drawn for every step of the loop.
_DRAWN = 2
#: File of the sensor's curve.
SENSOR_CURVE = "sensor_curve.csv"
#: What the model before is called where no more is known of it.
START = "starting model"
#: What to do where the model, or its inverse, is of no use.
ADVICE = (
    "Do not rely on it: see below what is left, and give `it2hys diagnose` records of other kinds too: "
    "slow and fast, with holds, with small loops."
)


def write_diagnosis(
    diagnosis: Diagnosis,
    records: Sequence[Record],
    directory: str | Path,
    title: str = "Diagnosis",
    first: Sequence[Section] | None = None,
    feedforward: Section | None = None,
    extra: Sequence[Section] = (),
    more: Mapping[str, object] | None = None,
    progress: Progress = lambda share, text: None,
) -> Path:
    """Write the parameter set, both FMUs, `report.html`, its figures and `report.json`.

    Parameters
    ----------
    diagnosis : Diagnosis
    records : sequence of Record
        In the order of `diagnosis.after`.
    directory : path
        Created if it does not exist.
    title : str
    first : sequence of Section, optional
        What the page begins with; by default, what was found and the figure of it.
    feedforward : Section, optional
        How a stage follows; by default, how the model found follows its own inverse.
    extra : sequence of Section
        Put before the parameters.
    more : mapping, optional
        Keys of `report.json` beside those of a diagnosis.
    progress : callable
        Told the share done and what is being done.

    Returns
    -------
    Path
        The report.
    """
    directory = make_directory(directory)
    found_in = origin("diagnose", records, diagnosis.after)
    package(diagnosis.packaged, directory, origin=found_in)
    if diagnosis.sensor_curves:
        _write_sensor_curve(diagnosis, directory / SENSOR_CURVE)
    train = [r for r, j in zip(records, diagnosis.after, strict=True) if j.role == "train"]
    lines = straight_line_errors(records, diagnosis.after)
    if first is None:
        first = [overview_section(diagnosis, records, conclusion(diagnosis, lines))]
    sections = [
        *first,
        Section(
            "What was found",
            [*details(diagnosis), *inversion(records)],
            [
                error_table(diagnosis, lines),
                inverse_table({"before": diagnosis.before, "after": diagnosis.after}),
                start_table(diagnosis),
            ],
        ),
        evidence_section(diagnosis),
        *_step_sections(diagnosis, train),
        *_record_sections(diagnosis, records),
        feedforward or _tracking_section(diagnosis, train, directory),
        *extra,
        _parameter_section(diagnosis),
    ]
    outcome = {
        **summary_json(diagnosis, lines),
        "records": records_json(records),
        **(more or {}),
    }
    document = json.dumps(outcome, indent=1) + "\n"
    write_atomically(directory / "report.json", document.encode())
    return write_report(directory, title, sections, progress)


def overview_section(
    diagnosis: Diagnosis,
    records: Sequence[Record],
    texts: Sequence[str],
    tracked: figures.Compared | None = None,
    start: str = START,
) -> Section:
    """Return the section that a page begins with: what to know, and one figure that shows it.

    Parameters
    ----------
    diagnosis : Diagnosis
    records : sequence of Record
        In the order of `diagnosis.after`; the first of those that count is drawn.
    texts : sequence of str
    tracked : figures.Compared, optional
        A reference that was tracked, drawn beside the record.
    start : str
        What the model before is called.
    """
    role = judging_role(diagnosis.after)
    i = next(i for i, judgement in enumerate(diagnosis.after) if judgement.role == role)
    record, before, after = records[i], diagnosis.before[i], diagnosis.after[i]
    compared = figures.Compared(
        f"Model error e_mr: {change(before.e_mr, after.e_mr)}",
        *(a[after.lead :] for a in (record.time, record.voltage, record.displacement)),
        *(j.y[after.lead :] for j in (before, after)),
    )
    caption = f"Record {record.name} ({ROLES[role]}), and the models driven by its voltage alone."
    if tracked:
        caption += " Right: reference less stage, driven by each model's inverse."
    picture = Picture(
        "overview", figures.overview(compared, tracked, labels(diagnosis, start)), caption
    )
    return Section("", list(texts), pictures=[picture])


def change(before: float, after: float) -> str:
    """Return how a share changed, for a title."""
    return f"{percent(before)} → {percent(after)}"


def labels(diagnosis: Diagnosis, start: str = START) -> tuple[str, str]:
    """Return what the models before and after are called in a figure or a table."""
    added = " ".join(f"+ {effect}" for effect in diagnosis.effects)
    return start, added or "fitted anew"


def conclusion(diagnosis: Diagnosis, lines: Sequence[Errors]) -> list[str]:
    """Return what was found, in plain words; first of all if the model is of no use."""
    return [
        *model_verdict(diagnosis.after, lines, ADVICE),
        *low_shares(diagnosis.after),
        found(diagnosis),
    ]


def details(diagnosis: Diagnosis) -> list[str]:
    """Return how well the models do, what cannot be told and what is left, in plain words."""
    before, after = (_rms_of(j, "train") for j in (diagnosis.before, diagnosis.after))
    texts = [
        f"A model is judged by its free run, from voltage alone. On the training "
        f"records its error goes from {before * UM:.4g} to {after * UM:.4g} µm rms; noise: "
        f"{noise_size(diagnosis.noise_rms)}.",
    ]
    for b, a in zip(diagnosis.before, diagnosis.after, strict=True):
        if b.role == "test":
            texts.append(
                f"On the test record {b.name}, which decided nothing, it goes from "
                f"{b.e_rms * UM:.4g} to {a.e_rms * UM:.4g} µm rms (e_mr {100 * b.e_mr:.2f} to "
                f"{100 * a.e_mr:.2f} %), noise: {noise_size(b.noise)}."
            )
    for group, experiment in zip(diagnosis.indistinguishable, diagnosis.experiments, strict=True):
        texts.append(
            f"{', '.join(group)}: these records cannot tell them apart, so none of them is named or "
            f"added. {experiment}"
        )
    if diagnosis.unexplained:
        texts.append(
            "A significant residual is left that no effect of the catalogue accounts for: it is "
            "unexplained. " + " ".join(diagnosis.left_over)
        )
    else:
        texts.append("What is left cannot be told from noise. " + " ".join(diagnosis.left_over))
    return texts + _curve_texts(diagnosis) + [f"Note: {warning}" for warning in diagnosis.warnings]


def _curve_texts(diagnosis: Diagnosis) -> list[str]:
    """Return what is said of a static curve that is the sensor's."""
    if not diagnosis.has_sensor_curve:
        return []
    if not diagnosis.sensor_curves:
        return ["The sensor was said to have a static curve, but these records show none."]
    displacement, reading = diagnosis.sensor_curve()
    bow = float(np.max(np.abs(reading - displacement)))
    return [
        f"The static curve is the sensor's, as --sensor-curve says: it reads up to {bow * UM:.3g} µm "
        f"off a straight line between the ends of its range. {SENSOR_CURVE} holds it. The errors in "
        "this report are those of readings. The FMUs are without it: their displacement and reference "
        "are the stage's own, so take a reading back through the curve before you compare."
    ]


def _write_sensor_curve(diagnosis: Diagnosis, path: Path) -> None:
    displacement, reading = diagnosis.sensor_curve()
    rows = [
        f"{y * UM!r},{r * UM!r}" for y, r in zip(displacement.tolist(), reading.tolist(), strict=True)
    ]
    write_atomically(path, ("\n".join(["displacement_um,reading_um", *rows]) + "\n").encode())


def found(diagnosis: Diagnosis, start: str = START) -> str:
    """Return a sentence that names the effects that were found, and what they are."""
    start = f"the {start}"
    if diagnosis.declared:
        start += f" with {', '.join(diagnosis.declared)} declared"
    if not diagnosis.effects:
        return f"No effect was found that {start} lacks."
    *others, last = (f"{effect} ({EVIDENCE[effect].meaning})" for effect in diagnosis.effects)
    named = f"{', '.join(others)} and {last}" if others else last
    return f"Found and added to {start}: {named}."


def _rms_of(judgements: Sequence[Judgement], role: str) -> float:
    chosen = [j for j in judgements if j.role == role]
    weights = [len(j.y) - j.lead for j in chosen]
    return float(np.sqrt(np.average([j.e_rms**2 for j in chosen], weights=weights)))


def error_table(diagnosis: Diagnosis, lines: Sequence[Errors]) -> Table:
    """Return the errors of all records before and after, beside a straight line's and the noise."""
    rows = [
        [
            b.name, ROLES[b.role],
            f"{100 * line.e_mr:.2f}", f"{100 * b.e_mr:.2f}", f"{100 * a.e_mr:.2f}",
            f"{line.e_rms * UM:.4f}", f"{b.e_rms * UM:.4f}", f"{a.e_rms * UM:.4f}",
            small_figure(a.noise * UM),
        ]
        for b, a, line in zip(diagnosis.before, diagnosis.after, lines, strict=True)
    ]  # fmt: skip
    return Table(
        [
            "record", "role",
            "line e_mr %", "e_mr % before", "e_mr % after",
            "line e_rms µm", "e_rms µm before", "e_rms µm after",
            "noise µm",
        ],
        rows,
        "Errors (24) and (25) of the free run before and after, behind the lead-in: the first part of "
        "a record, on which the start of its run is fitted and nothing else. Line: one straight line "
        "fitted to the training records.",
    )  # fmt: skip


def start_table(diagnosis: Diagnosis) -> Table:
    """Return how the runs of the last model begin, and how much of each record they explain."""
    rows = [
        [
            a.name, ROLES[a.role],
            f"{a.lead_in:.3g}", f"{a.offset * UM:.3f}",
            f"{b.cold_start * UM:.4f}", f"{a.cold_start * UM:.4f}",
            _format(100 * a.explained, "{:.4g}"), _format(100 * a.voltage_share, "{:.4g}"),
        ]
        for b, a in zip(diagnosis.before, diagnosis.after, strict=True)
    ]  # fmt: skip
    return Table(
        [
            "record", "role",
            "lead-in s", "offset removed µm",
            "cold start µm before", "cold start µm after",
            "explained %", "by voltage %",
        ],
        rows,
        "Cold start: e_rms of the plant FMU as packaged, told nothing but the first displacement. "
        "Explained: share of the displacement's variance that the free run accounts for; by voltage: "
        "that a predictor without physics makes of the voltage's past, on parts that it was not "
        "fitted to.",
    )  # fmt: skip


def evidence_overview(diagnosis: Diagnosis) -> Table:
    """Return the figures of every effect tried, and the verdict."""
    rows = [
        [
            e.effect,
            _verdict(e.effect, e.accepted, diagnosis),
            _format(e.p_value, "{:.2g}"),
            change_in_percent(e.held_out_gain) if np.isfinite(e.held_out_gain) else "–",
            _format(e.held_out_p_value, "{:.2g}"),
        ]
        for e in diagnosis.evidence
    ]
    return Table(["effect", "verdict", "signature p", "gain %", "gain p"], rows)


def evidence_table(diagnosis: Diagnosis) -> Table:
    """Return every effect tried with evidence, verdict and reason."""
    overview = evidence_overview(diagnosis)
    texts = [[e.why, e.signature] for e in diagnosis.evidence]
    rows = [row + text for row, text in zip(overview.rows, texts, strict=True)]
    return Table([*overview.columns, "reason", "signature"], rows)


def evidence_section(diagnosis: Diagnosis) -> Section:
    """Return the section of every effect tried."""
    return Section(
        "Evidence",
        [
            "Signature: a property of the first model's residual that this effect alone predicts, with "
            "its significance. Gain: by how much adding the effect, everything fitted anew, lowers the "
            "free-run error on the records that decide, and the probability of that by chance (block "
            "bootstrap). An effect stays only if the gain is large enough to matter, and so unlikely "
            f"by chance (p below {LEVEL:.1g}) that a whole search, of up to {COMPARISONS} comparisons, "
            f"names anything by chance in {100 * SEARCH.budget:.0f} % of the cases at most."
        ],
        [evidence_table(diagnosis)],
    )


def _verdict(effect: str, accepted: bool, diagnosis: Diagnosis) -> str:
    if accepted:
        return "added"
    if any(effect in group for group in diagnosis.indistinguishable):
        return "cannot be told"
    return "declared" if effect in diagnosis.declared else "no"


def _format(value: float, pattern: str) -> str:
    return pattern.format(value) if np.isfinite(value) else NONE


def _step_sections(diagnosis: Diagnosis, train: Sequence[Record]) -> list[Section]:
    """Return the residuals before and after every step of the loop."""
    sections = []
    for number, (first, second) in enumerate(
        zip(diagnosis.stages, diagnosis.stages[1:], strict=False), start=1
    ):
        text = [
            f"With {second.label} the error on what decides goes from {first.e_rms * UM:.4g} to "
            f"{second.e_rms * UM:.4g} µm rms."
        ]
        pictures = [
            Picture(
                f"step{number}_{record.name}",
                figures.residual_views(
                    record.time,
                    record.voltage,
                    first.residuals[i],
                    second.residuals[i],
                    diagnosis.noise_rms,
                    record.sample_time,
                    f"{record.name}: {first.label} → {second.label}",
                ),
                "Residual over time, over voltage and its spectrum, before and after this step.",
            )
            for i, record in enumerate(train[:_DRAWN])
        ]
        sections.append(Section(f"Step {number}: {second.label}", text, pictures=pictures))
    return sections


def _record_sections(diagnosis: Diagnosis, records: Sequence[Record]) -> list[Section]:
    sections = []
    for record, before, after in zip(records, diagnosis.before, diagnosis.after, strict=True):
        kept = slice(after.lead, None)
        texts = record_texts(record, after, diagnosis.parameters)
        pictures = [
            Picture(
                f"{record.name}_time",
                figures.time_course(
                    record.time[kept],
                    record.displacement[kept],
                    {"after": after.y[kept], "before": before.y[kept]},
                    label(after),
                    after.noise,
                ),
                "Displacement and error over time, before and after.",
            ),
            Picture(
                f"{record.name}_loop",
                figures.hysteresis_loop(
                    record.voltage[kept],
                    record.displacement[kept],
                    {"after": after.y[kept], "before": before.y[kept]},
                    label(after),
                ),
                "Hysteresis loop before and after, and error over voltage after.",
            ),
            inverse_picture(record, {"after": after, "before": before}),
        ]
        sections.append(Section(f"Record {label(after)}", texts, pictures=pictures))
    return sections


def _tracking_section(diagnosis: Diagnosis, records: Sequence[Record], directory: Path) -> Section:
    """Drive the plant FMU through the inverse before and after, on the paper's reference."""
    reference = scaled_reference(records)
    time = np.arange(len(reference)) * diagnosis.parameters["sampleTime"]
    start = at_rest(reference[0])
    plant = directory / "IT2Plant.fmu"
    new = track(directory / "IT2Inverse.fmu", plant, reference, start)
    voltage, limited = compiled.chain_inverse_run(diagnosis.base.replace(**start), reference)
    old, _ = compiled.chain_free_run(diagnosis.packaged.replace(**start), voltage)
    rows = [
        [
            name,
            f"{100 * max_relative_error(reference, y):.2g}",
            f"{rms_error(reference, y) * UM:.2g}",
            f"{100 * np.mean(out_of_reach):.2g}",
        ]
        for name, y, out_of_reach in (
            ("before", old, limited),
            ("after", new["displacement"], new["saturated"]),
        )
    ]
    return Section(
        "Feedforward: the inverse drives the plant",
        [
            "The paper's reference, a sine, scaled to the range and pace of the records. The plant is "
            "the model found here, as FMU; it is driven by the inverse of the model before and by its "
            "own inverse FMU. How well the real stage follows is limited by the free-run errors above."
        ],
        [
            Table(
                ["inverse", "e_mr %", "e_rms µm", "limited %"],
                rows,
                "Tracking errors in co-simulation. Limited: share of samples in which the range or the "
                "amplifier keeps the inverse from what is asked for (records that ring span more than "
                "the stage reaches at rest).",
            )
        ],
        [
            Picture(
                "tracking",
                figures.tracking(
                    time, reference, {"after": new["displacement"], "before": old}, new["voltage"],
                    "inverse → plant",
                ),
                "Reference, displacement, error and voltage (compare the paper's Figure 7).",
            )
        ],
    )  # fmt: skip


def at_rest(displacement: float) -> dict[str, float]:
    """Return the parameters of a run that begins at rest at a displacement, m."""
    rest = {name: 0.0 for name in BY_RECORD if name not in OF_READING}
    return {**rest, "initialDisplacement": float(displacement)}


def scaled_reference(records: Sequence[Record]) -> np.ndarray:
    """Return the paper's reference over 90 % of the records' range, m, in its number of samples."""
    paper = tracking_reference(time_grid(_REFERENCE_DURATION, SAMPLE_TIME))
    low = min(r.displacement[~r.outliers].min() for r in records)
    high = max(r.displacement[~r.outliers].max() for r in records)
    share = (paper - paper.min()) / np.ptp(paper)
    return low + (0.05 + 0.9 * share) * (high - low)


def summary_json(diagnosis: Diagnosis, lines: Sequence[Errors]) -> dict:
    """Return `report.json` as a dictionary, with the keys of DESIGN.md."""
    known = load_table().parameters()
    return {
        "effects": list(diagnosis.effects),
        "declared": list(diagnosis.declared),
        "unexplained": diagnosis.unexplained,
        "left_over": list(diagnosis.left_over),
        "indistinguishable": [list(group) for group in diagnosis.indistinguishable],
        "experiments": list(diagnosis.experiments),
        "noise_rms_um": diagnosis.noise_rms * UM,
        "error": {
            "before": {j.name: judgement_json(j) for j in diagnosis.before},
            "after": {j.name: judgement_json(j) for j in diagnosis.after},
        },
        "straight_line": {
            j.name: {"e_mr_percent": 100 * line.e_mr, "e_rms_um": line.e_rms * UM}
            for j, line in zip(diagnosis.after, lines, strict=True)
        },
        "evidence": [
            {
                "effect": e.effect,
                "statistic": finite_or_none(e.statistic),
                "p_value": finite_or_none(e.p_value),
                "signature": e.signature,
                "held_out_gain_percent": finite_or_none(100 * e.held_out_gain),
                "held_out_p_value": finite_or_none(e.held_out_p_value),
                "accepted": e.accepted,
                "why": e.why,
            }
            for e in diagnosis.evidence
        ],
        "parameters": {
            name: {
                "value": diagnosis.parameters[name],
                "ci95": [finite_or_none(low), finite_or_none(high)],
                "unit": known[name].type.unit or "1",
            }
            for name, (low, high) in diagnosis.intervals.items()
        },
        "warnings": list(diagnosis.warnings),
        "seconds": diagnosis.seconds,
    }


def _parameter_section(diagnosis: Diagnosis) -> Section:
    rows = [
        parameter_row(name, diagnosis.parameters[name], low, high)
        for name, (low, high) in diagnosis.intervals.items()
    ]
    seconds = ", ".join(f"{k} {v:.1f} s" for k, v in diagnosis.seconds.items())
    return Section(
        "Parameters",
        [
            "Intervals hold for residuals correlated in time; none is given for a parameter at its "
            f"bound or that the records do not determine. Duration: {seconds}."
        ],
        [Table(["parameter", "value", "95 % from", "to", "unit"], rows)],
    )
