"""The outcome of an identification or a diagnosis: parameter set, FMUs, report, in one directory.

What is found is written as `report.json` and courses of the records; the page is drawn from these and
from the figures beside them, at once or later.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from it2hys.cosimulation.simulation import track
from it2hys.diagnosis.outcome import Diagnosis
from it2hys.errors import InputError
from it2hys.fmu.own_library import only_used
from it2hys.fmu.packaging import package
from it2hys.identification.effect_coordinates import by_record, of_reading
from it2hys.identification.judgement import Judgement
from it2hys.identification.result import Identification
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet, write_ssv
from it2hys.records import Record
from it2hys.records.figures_of_merit import max_relative_error, rms_error
from it2hys.reports import figures
from it2hys.reports.answers import answers, verdict
from it2hys.reports.courses import Course, make_course, read_courses, write_courses
from it2hys.reports.design_report import (
    NEXT,
    NEXT_CAPTION,
    beside_promise,
    next_record,
)
from it2hys.reports.details import details
from it2hys.reports.inputs import ROLES
from it2hys.reports.interactive import as_json, record_view
from it2hys.reports.origin import origin
from it2hys.reports.page import Answer, Page, Picture, Section, Table, View, write_page, write_pictures
from it2hys.reports.provenance import Provenance, about
from it2hys.reports.summary import START, Result, judged_records, pooled, settled_training, summary
from it2hys.reports.verdict import has_offsets, straight_line
from it2hys.stand.excitations import time_grid, tracking_reference
from it2hys.support.files import make_directory, read_json, write_atomically
from it2hys.support.progress import Progress, part

UM = 1e6
#: The file that the page is drawn from.
REPORT = "report.json"
#: The paper's reference: so long at its sample time.
_REFERENCE_DURATION, SAMPLE_TIME = 0.15, 1e-4
#: Records whose residuals are drawn for every step of the loop, and that a page has figures of.
_DRAWN, _LOOKED_INTO = 2, 20
_HINT = (
    "Drag a box to zoom in; the time axes go together, and the loop shows what they hold. The tool "
    "with the dotted box selects samples: they are marked in the loop and over time. The circular "
    "arrow takes it all back."
)
#: File of the sensor's curve.
SENSOR_CURVE = "sensor_curve.csv"


def write_report(
    result: Result,
    records: Sequence[Record],
    directory: str | Path,
    title: str = "",
    provenance: Provenance | None = None,
    lead: Answer | None = None,
    tracked: figures.Compared | None = None,
    extra: Sequence[Section] = (),
    more: Mapping[str, object] | None = None,
    start: str = START,
    progress: Progress = lambda share, text: None,
    promised: tuple[Mapping, np.ndarray | None] | None = None,
) -> Path:
    """Write the parameter set, both FMUs, `report.json`, its figures and `report.html`.

    Parameters
    ----------
    result : Identification or Diagnosis
    records : sequence of Record
        In the order of the result's judgements.
    directory : path
        Created if it does not exist.
    title : str
        By default what was done.
    provenance : Provenance, optional
        What it was made by.
    lead : Answer, optional
        What the page answers first of all.
    tracked : figures.Compared, optional
        A reference that was tracked on a stage, drawn at the top; by default it is the plant found that
        is driven by its inverse, among the details.
    extra : sequence of Section
        Put among the details.
    more : mapping, optional
        Keys of `report.json` beside those of the result.
    start : str
        What the model before a diagnosis is called.
    progress : callable
        Told the share done and what is being done.
    promised : tuple of mapping and ndarray, optional
        The design that a training record was made by, and its voltage: what came out stands beside it.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    InputError
        If the fit of an identification has not converged: nothing is written then.
    """
    _check_converged(result)
    directory = make_directory(directory)
    verb = "diagnose" if isinstance(result, Diagnosis) else "identify"
    with only_used(result.packaged) as alone:
        package(alone, directory, origin=origin(verb, records, result.records))
    roles = [j.role for j in result.records]
    if isinstance(result, Diagnosis):
        for name, parameters in result.packaged_rivals.items():
            with only_used(parameters) as alone:
                write_ssv(alone, directory / name)
    report = {
        "title": title or ("Diagnosis" if isinstance(result, Diagnosis) else "Identification"),
        **(provenance or Provenance()).entries(records, roles, directory),
        **summary(result, records, start),
        **(more or {}),
    }
    pictures = _record_pictures(result, records)
    report["promised"] = None
    if promised is not None:
        trained = [r for r, role in zip(records, roles, strict=True) if role == "train"]
        report["promised"] = beside_promise(*promised, trained, report)
    report["next"], drawn_next = next_record(report, result, part(progress, 0.0, 0.7))
    pictures += drawn_next
    if isinstance(result, Diagnosis):
        if result.sensor_curves:
            _write_sensor_curve(result, directory / SENSOR_CURVE)
        steps = _step_pictures(result, records)
        for entry, drawn in zip(report["steps"], steps, strict=True):
            entry["pictures"] = [p.name for p in drawn]
        pictures += [p for drawn in steps for p in drawn]
    if tracked is None:
        report["model_tracking"], picture = _track_model(result, records, directory)
        pictures.append(picture)
    pictures.append(_overview(result, records, tracked, report["names"]))
    pictures += [p for section in extra for p in section.pictures]
    write_pictures(directory, pictures, part(progress, 0.7, 1.0))
    report["lead"] = None if lead is None else _answer_json(lead)
    report["sections"] = [section.as_json() for section in extra]
    write_courses(directory, _courses(result, records))
    write_atomically(directory / REPORT, (json.dumps(report, indent=1) + "\n").encode())
    return draw_report(directory)


def _check_converged(result: Result) -> None:
    if isinstance(result, Identification) and not result.converged:
        raise InputError(
            f"the fit did not converge ({result.message}); no parameter set is written. "
            "Try more iterations (--max-iterations), fewer rules, or records that cover the range"
            " better"
        )


def draw_report(directory: str | Path) -> Path:
    """Draw the page from `report.json`, the courses and the figures that lie in a directory.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    InputError
        If what it is drawn from is not there or not whole, or the page cannot be written.
    """
    directory = Path(directory)
    report = read_report(directory / REPORT)
    after = report["error"]["after"]
    courses = read_courses(directory, list(after))
    answered = answers(report)
    if report["lead"]:
        # that a model is of no use comes before anything else
        answered.insert(1 if verdict(report) else 0, _answer_of(report["lead"]))
    views = [
        View(
            f"Record {name} ({ROLES[after[name]['role']]})",
            as_json(record_view(course, report["names"], after[name]["noise_rms_um"] / UM)),
        )
        for name, course in _most_telling_first(courses, report)[:_LOOKED_INTO]
    ]
    hint = _HINT
    if len(courses) > len(views):
        hint += f" {len(views)} of {len(courses)} records are shown; the others are in the PNG files."
    pictures = [Picture("overview", None, _overview_caption(report)), *_waterfall(report)]
    if (report.get("next") or {}).get("power") is not None:  # otherwise no record was designed
        pictures.append(Picture(NEXT, None, NEXT_CAPTION))
    page = Page(report["title"], about(report), answered, pictures, views, hint, details(report))
    return write_page(directory, page)


def read_report(path: Path) -> dict:
    """Return what a `report.json` holds.

    Raises
    ------
    InputError
        If there is none, or it is not one that this version can draw.
    """
    return read_json(
        path,
        ("title", "kind", "error", "names", "sections"),
        "; give the directory that was named by -o",
        "; this is a report of an earlier version, or another file: make the report again from its "
        "records",
    )


def _answer_json(answer: Answer) -> dict:
    table = None if answer.table is None else vars(answer.table)
    return {"question": answer.question, "texts": answer.texts, "table": table, "after": answer.after}


def _answer_of(stored: dict) -> Answer:
    table = None if stored["table"] is None else Table(**stored["table"])
    return Answer(stored["question"], stored["texts"], table, stored["after"])


def _most_telling_first(courses: Mapping[str, Course], report: Mapping) -> list[tuple[str, Course]]:
    """Return the courses, those of the records that count first."""
    first = judged_records(report)
    return [(n, courses[n]) for n in (*first, *(n for n in courses if n not in first))]


# --- figures of the top ----------------------------------------------------------------------------


def _overview(
    result: Result, records: Sequence[Record], tracked: figures.Compared | None, names: Mapping
) -> Picture:
    """Return the loop and the errors before and after, of the first record that counts."""
    after, before = result.records, _readings_before(result, records)
    roles = [j.role for j in after]
    i = roles.index(next(role for role in ("test", "validation", "train") if role in roles))
    record, kept = records[i], slice(after[i].lead, None)
    compared = figures.Compared(
        f"Error of the model, {record.name}",
        record.time[kept],
        record.voltage[kept],
        record.displacement[kept],
        before[i][kept],
        after[i].y[kept],
    )
    labels = (names["before"], names["after"])
    return Picture("overview", figures.overview(compared, tracked, labels), "")


def _overview_caption(report: Mapping) -> str:
    name = judged_records(report)[0]
    role = ROLES[report["error"]["after"][name]["role"]]
    text = f"Loop and error of the {role} record {name}; the models are driven by its voltage alone."
    if "tracking" in report:
        text += " Below: reference less stage, driven by each model's inverse."
    return text


def _waterfall(report: Mapping) -> list[Picture]:
    """Return how the errors of plant and inverse fall from model to model, on the same records."""
    after = report["error"]["after"]
    models = [(report["names"]["before"], report["error"]["before"])]
    models += [(f"+ {' + '.join(s['added'])}", s["error"]) for s in report["steps"]]
    if not report["steps"]:
        models.append((report["names"]["after"], after))
    falls = [
        figures.Fall(
            label, [(n, pooled(report, e, key)) for n, e in models], pooled(report, after, floor)
        )
        for label, key, floor in (
            ("Plant: rms error in µm", "e_rms_um", "noise_rms_um"),
            ("Inverse: rms error in V", "inverse_e_rms_V", "inverse_noise_rms_V"),
        )
    ]  # fmt: skip
    falls = [fall for fall in falls if all(np.isfinite(error) for _, error in fall.steps)]
    if not falls:
        return []
    names = ", ".join(judged_records(report))
    caption = (
        "How the error falls, from the first model through each addition to the error that noise alone "
        f"makes. All on the same records: {names}."
    )
    return [Picture("waterfall", figures.waterfall(falls), caption)]


# --- what is kept of the records --------------------------------------------------------------------


def _readings_before(result: Result, records: Sequence[Record]) -> list[np.ndarray]:
    """Return what the models before make of the records, m: of an identification, a straight line."""
    if isinstance(result, Diagnosis):
        return [j.y for j in result.before]
    slope, offset = straight_line(records, result.records)
    own = has_offsets(result.records)
    readings = []
    for record, judgement in zip(records, result.records, strict=True):
        line, used = slope * record.voltage, judgement.used
        apart = float(np.mean(record.displacement[used] - line[used])) if own else offset
        readings.append(line + apart)
    return readings


def _courses(result: Result, records: Sequence[Record]) -> dict[str, Course]:
    before = _readings_before(result, records)
    inverse_before = _inverse_errors_before(result, records, before)
    courses = {}
    for record, j, y, volts in zip(records, result.records, before, inverse_before, strict=True):
        kept = slice(j.lead, None)
        signals = {
            "voltage": record.voltage,
            "measured": np.where(record.outliers, np.nan, record.displacement),
            "before": y,
            "after": j.y,
            "inverse_before": volts,
            "inverse_after": _inverse_error(j),
        }
        cut = {name: values[kept] for name, values in signals.items()}
        courses[record.name] = make_course(record.sample_time, record.time[kept], **cut)
    return courses


def _inverse_error(judgement: Judgement) -> np.ndarray:
    return judgement.inverse.asked - judgement.inverse.applied


def _inverse_errors_before(
    result: Result, records: Sequence[Record], before: Sequence[np.ndarray]
) -> list[np.ndarray]:
    """Return by how much the inverse of the model before is off, V."""
    if isinstance(result, Diagnosis):
        return [_inverse_error(j) for j in result.before]
    slope, _ = straight_line(records, result.records)
    return [(r.displacement - y) / slope for r, y in zip(records, before, strict=True)]


# --- figures for papers -----------------------------------------------------------------------------


def _record_pictures(result: Result, records: Sequence[Record]) -> list[Picture]:
    """Return the figures of every record: over time, over voltage, and of the inverse."""
    pictures = []
    for i, (record, after) in enumerate(zip(records, result.records, strict=True)):
        kept = slice(after.lead, None)
        time, voltage, measured = (a[kept] for a in (record.time, record.voltage, record.displacement))
        title = f"{after.name} ({ROLES[after.role]})"
        if isinstance(result, Diagnosis):
            others, inverses = {"before": result.before[i].y[kept]}, {"before": result.before[i]}
            runs = {"after": after.y[kept]}
        else:
            runs, inverses = {"free run": after.y[kept]}, {}
            others = {"one step ahead": after.one_step.y[kept]} if after.one_step else {}
        loops = {**runs, **(others if isinstance(result, Diagnosis) else {})}
        asked = {"after" if inverses else "": after, **inverses}
        gain = after.inverse.e_displacement / max(after.inverse.e_rms, np.finfo(float).tiny)
        volts = {name: j.inverse.asked[kept] for name, j in asked.items()}
        pictures += [
            Picture(
                f"{record.name}_time",
                figures.time_course(time, measured, {**runs, **others}, title, after.noise),
                "Displacement and error over time",
            ),
            Picture(
                f"{record.name}_loop",
                figures.hysteresis_loop(voltage, measured, loops, title),
                "Hysteresis loop, and error over voltage",
            ),
            Picture(
                f"{record.name}_inverse",
                figures.inverse_course(time, after.inverse.applied[kept], volts, gain, title),
                "The applied voltage, and that of the inverse for the measured displacement",
            ),
        ]
    return pictures


def _step_pictures(found: Diagnosis, records: Sequence[Record]) -> list[list[Picture]]:
    """Return, for every step of the search, the residuals of some training records before and after."""
    train = [r for r, j in zip(records, found.after, strict=True) if j.role == "train"]
    return [
        [
            Picture(
                f"step{number}_{record.name}",
                figures.residual_views(
                    record.time,
                    record.voltage,
                    first.residuals[i],
                    second.residuals[i],
                    found.noise_rms,
                    record.sample_time,
                    f"{record.name}: {first.label} → {second.label}",
                ),
                "",
            )
            for i, record in enumerate(train[:_DRAWN])
        ]
        for number, (first, second) in enumerate(
            zip(found.stages, found.stages[1:], strict=False), start=1
        )
    ]


def _write_sensor_curve(found: Diagnosis, path: Path) -> None:
    displacement, reading = found.sensor_curve()
    rows = [
        f"{y * UM!r},{r * UM!r}" for y, r in zip(displacement.tolist(), reading.tolist(), strict=True)
    ]
    write_atomically(path, ("\n".join(["displacement_um,reading_um", *rows]) + "\n").encode())


# --- the FMUs together ------------------------------------------------------------------------------


def _track_model(
    result: Result, records: Sequence[Record], directory: Path
) -> tuple[dict[str, dict], Picture]:
    """Drive the plant FMU through the inverse FMU, and that of the model before a diagnosis."""
    reference = scaled_reference(settled_training(result, records))
    time = np.arange(len(reference)) * result.parameters["sampleTime"]
    start = at_rest(reference[0])
    new = track(directory / "IT2Inverse.fmu", directory / "IT2Plant.fmu", reference, start)
    runs = {"after": (new["displacement"], new["saturated"])}
    if isinstance(result, Diagnosis):
        plant = result.packaged.replace(**start)
        runs["before"] = _driven_by(result.base.replace(**start), plant, reference)
    table = {
        name: {
            "e_mr_percent": 100 * max_relative_error(reference, y),
            "e_rms_um": rms_error(reference, y) * UM,
            "limited_percent": 100 * float(np.mean(limited)),
        }
        for name, (y, limited) in runs.items()
    }
    courses = {name: y for name, (y, _) in runs.items()}
    drawn = figures.tracking(time, reference, courses, new["voltage"], "inverse → plant")
    return table, Picture("tracking", drawn, "")


def _driven_by(
    inverse: ParameterSet, plant: ParameterSet, reference: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the displacement of a plant that another model's inverse drives, and where that clamps."""
    voltage, limited = compiled.chain_inverse_run(inverse, reference)
    return compiled.chain_free_run(plant, voltage)[0], limited


def at_rest(displacement: float) -> dict[str, float]:
    """Return the parameters of a run that begins at rest at a displacement, m."""
    rest = {name: 0.0 for name in by_record() if name not in of_reading()}
    return {**rest, "initialDisplacement": float(displacement)}


def scaled_reference(records: Sequence[Record]) -> np.ndarray:
    """Return the paper's reference over 90 % of the records' range, m, in its number of samples."""
    paper = tracking_reference(time_grid(_REFERENCE_DURATION, SAMPLE_TIME))
    low = min(r.displacement[~r.outliers].min() for r in records)
    high = max(r.displacement[~r.outliers].max() for r in records)
    share = (paper - paper.min()) / np.ptp(paper)
    return low + (0.05 + 0.9 * share) * (high - low)
