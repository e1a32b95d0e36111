"""`report.json`: everything that a report says, in numbers; the page is drawn from it.

The keys are documented in docs/report.schema.json. One function serves an identification, a parameter
set that is judged on records, and a diagnosis: the first two are reports without effects, whose model
before is a straight line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from it2hys.diagnosis.evidence import EVIDENCE
from it2hys.diagnosis.outcome import Diagnosis
from it2hys.identification.coverage import driven_up_to
from it2hys.identification.excerpts import searched_text
from it2hys.identification.findings import sensor_step
from it2hys.identification.judgement import Judgement
from it2hys.identification.result import Identification
from it2hys.identification.stage_figures import StageFigure
from it2hys.model.parameters import ParameterSet
from it2hys.model.variables import load_table
from it2hys.policy import TELLING
from it2hys.records import Record
from it2hys.records.figures_of_merit import Errors
from it2hys.reports.validity import out_of_range_sentence
from it2hys.reports.verdict import COUNTING, straight_line, straight_line_errors

UM = 1e6
#: Name of the model before a diagnosis: a given one, or the paper's, identified on the same records.
START = "starting model"
PAPER = "paper's model"
LINE = "straight line"

Result = Identification | Diagnosis


def summary(result: Result, records: Sequence[Record], start: str = START) -> dict:
    """Return what a result says, with the keys of `report.json`.

    Parameters
    ----------
    result : Identification or Diagnosis
    records : sequence of Record
        In the order of the result's judgements.
    start : str
        What the model before a diagnosis is called.
    """
    after = result.records
    lines = straight_line_errors(records, after)
    slope, _ = straight_line(records, after)
    if isinstance(result, Diagnosis):
        own = _diagnosed(result, start)
        before = _judgements_json(result.before, records)
    else:
        own = _identified(result)
        before = {j.name: _line_json(j, line, slope) for j, line in zip(after, lines, strict=True)}
    return {
        **own,
        "error": {"before": before, "after": _judgements_json(after, records)},
        "noise_rms_um": result.noise_rms * UM,
        "rules": result.parameters.counts["rule"],
        "straight_line": {
            j.name: {"e_mr_percent": 100 * line.e_mr, "e_rms_um": line.e_rms * UM}
            for j, line in zip(after, lines, strict=True)
        },
        "range": _range(result, records),
        "parameters": _parameters_json(result),
        "stage_figures": [_figure_json(f) for f in result.stage_figures],
        "warnings": list(result.warnings),
        "seconds": result.seconds,
        "records": {
            j.name: record_json(r, j, result.parameters) for r, j in zip(records, after, strict=True)
        },
    }


def model_names(found: Diagnosis, start: str = START) -> dict[str, str]:
    """Return what the models before and after are called in a figure or a table."""
    added = " ".join(f"+ {effect}" for effect in found.effects)
    return {"before": start, "after": added or "fitted anew"}


def _identified(found: Identification) -> dict:
    """Return what only an identification has, and what it has not, empty."""
    samples = sum(len(j.y) for j in found.by_role("train"))
    is_given = not found.intervals
    return {
        "kind": "evaluation" if is_given else "identification",
        "names": {"before": LINE, "after": found.parameters.name if is_given else "model"},
        "effects": [],
        "declared": [],
        "meanings": {},
        "unexplained": bool(found.error_over_noise > TELLING.far_above),
        "left_over": [],
        "indistinguishable": [],
        "experiments": [],
        "rivals": [],
        "evidence": [],
        "steps": [],
        "condition": finite_or_none(found.condition),
        "contraction": finite_or_none(found.contraction),
        "fit": None
        if is_given
        else {
            "message": found.message,
            "searched": list(filter(None, [searched_text(samples)])),
            "starts": [
                {
                    "one_step_rms_um": finite_or_none(s.one_step_rms * UM),
                    "free_run_rms_um": finite_or_none(s.free_run_rms * UM),
                }
                for s in found.starts[:10]
            ],
            "orders": [{"rules": o.rules, "e_rms_um": o.e_rms * UM} for o in found.orders],
        },
    }


def _diagnosed(found: Diagnosis, start: str) -> dict:
    """Return what only a diagnosis has; its models' errors are `summary`'s."""
    return {
        "kind": "diagnosis",
        "names": model_names(found, start),
        "effects": list(found.effects),
        "declared": list(found.declared),
        "meanings": {effect: EVIDENCE[effect].meaning for effect in found.effects},
        "unexplained": found.unexplained,
        "left_over": list(found.left_over),
        "indistinguishable": [list(group) for group in found.indistinguishable],
        "experiments": list(found.experiments),
        "rivals": [
            {
                "own": list(r.own),
                "effects": list(r.effects),
                "file": r.file,
                "e_rms_um": r.e_rms * UM,
                "inverse_e_rms_um": r.inverse_e_rms * UM,
                "unexplained": r.unexplained,
                "parameters": dict(r.parameters),
            }
            for r in found.rivals
        ],
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
                "reason": e.reason,
                "beside": list(e.beside),
                "level": finite_or_none(e.level),
                "error_before_um": finite_or_none(e.error_before * UM),
                "error_after_um": finite_or_none(e.error_after * UM),
            }
            for e in found.evidence
        ],
        "steps": _steps(found),
        "sensor_curve": _sensor_curve(found),
    }


def _steps(found: Diagnosis) -> list[dict]:
    """Return the models on the way, the last one included, each with what was added in its step."""
    steps, known = [], set()
    for stage in found.stages[1:]:
        names = stage.label.split(" + ")
        steps.append(
            {
                "added": [name for name in names if name not in known],
                "deciding_e_rms_um": stage.e_rms * UM,
                "error": {
                    j.name: {
                        "e_rms_um": finite_or_none(j.e_rms * UM),
                        "inverse_e_rms_V": finite_or_none(j.inverse.e_rms),
                        "inverse_e_rms_um": finite_or_none(j.inverse.e_displacement * UM),
                    }
                    for j in stage.judgements
                },
            }
        )
        known = {*names}
    return steps


def _sensor_curve(found: Diagnosis) -> dict | None:
    """Return what is known of a static curve that is the sensor's; None where none was asked for."""
    if not found.has_sensor_curve:
        return None
    if not found.sensor_curves:
        return {"found": False, "bow_um": 0.0}
    displacement, reading = found.sensor_curve()
    return {"found": True, "bow_um": float(np.max(np.abs(reading - displacement))) * UM}


def _trained(result: Result, records: Sequence[Record]) -> list[tuple[Record, Judgement]]:
    """Return the training records and their judgements; all of them where none was fitted."""
    pairs = list(zip(records, result.records, strict=True))
    return [(r, j) for r, j in pairs if j.role == "train"] or pairs


def settled_training(result: Result, records: Sequence[Record]) -> list[Record]:
    """Return the training records behind their lead-ins; all records where none was fitted.

    A stage may begin where none of the records' voltages brings it again. Where more than the voltage
    moved it, displacements end a little beyond the model's: no voltage reaches the others.
    """
    settled = []
    for record, judgement in _trained(result, records):
        behind, y = record.slice(judgement.lead), judgement.y[judgement.lead :]
        ends = y.min() - TELLING.off_model * np.ptp(y), y.max() + TELLING.off_model * np.ptp(y)
        settled.append(replace(behind, displacement=np.clip(behind.displacement, *ends)))
    return settled


def _range(result: Result, records: Sequence[Record]) -> dict:
    """Return the training records' voltages, and the displacements that the sensor reads at them."""
    voltages = [r.voltage for r, _ in _trained(result, records)]
    trusted = [r.displacement[~r.outliers] for r in settled_training(result, records)]
    return {
        "voltage_V": [min(float(v.min()) for v in voltages), max(float(v.max()) for v in voltages)],
        "displacement_um": [UM * min(float(y.min()) for y in trusted),
                            UM * max(float(y.max()) for y in trusted)],
    }  # fmt: skip


def _parameters_json(result: Result) -> dict:
    known = load_table().parameters()
    return {
        name: {
            "value": result.parameters[name],
            "ci95": [finite_or_none(low), finite_or_none(high)],
            "unit": known[name].type.unit or "1",
            "determined": name not in result.undetermined and bool(np.isfinite(high - low)),
        }
        for name, (low, high) in result.intervals.items()
    }


def _figure_json(figure: StageFigure) -> dict:
    return {
        "name": figure.name,
        "meaning": figure.meaning,
        "record": figure.record,
        "value": figure.value,
        "ci95": [finite_or_none(figure.low), finite_or_none(figure.high)],
        "unit": figure.unit,
    }


def record_json(record: Record, judgement: Judgement, ends: ParameterSet) -> dict:
    """Return what `report.json` says of a record itself."""
    step = sensor_step(record)
    return {
        "displacement_inverted": record.inverted,
        "unused_columns": list(record.unused),
        "sensor_step_um": None if step is None else UM * step,
        "notes": list(record.notes),
        "samples": len(record),
        "sample_time_s": record.sample_time,
        "fastest_V_per_s": float(np.max(np.abs(np.diff(record.voltage)))) / record.sample_time,
        "driven_up_to_Hz": driven_up_to(record),
        "noise_method": judgement.noise_method,
        "out_of_range": out_of_range_sentence(
            ends, judgement.out_of_range, record.voltage, judgement.y - judgement.offset
        ),
    }


def _judgements_json(judgements: Sequence[Judgement], records: Sequence[Record]) -> dict:
    return {j.name: judgement_json(j, r) for j, r in zip(judgements, records, strict=True)}


def judgement_json(judgement: Judgement, record: Record) -> dict:
    """Return what `report.json` says of a model on a record, with the keys of DESIGN.md."""
    measured = record.displacement[judgement.used]
    error = np.where(judgement.used, np.abs(record.displacement - judgement.y), -np.inf)
    found = {
        "e_mr_percent": 100 * judgement.e_mr,
        "e_mr_at_s": float(record.time[int(np.argmax(error))]),
        "e_rms_um": judgement.e_rms * UM,
        "range_um": float(np.ptp(measured)) * UM,
        "samples": int(np.count_nonzero(judgement.used)),
        "role": judgement.role,
        "model": "free run",
        "noise_rms_um": judgement.noise * UM,
        "explained_percent": finite_or_none(100 * judgement.explained),
        "voltage_explains_percent": finite_or_none(100 * judgement.voltage_share),
        "offset_um": judgement.offset * UM,
        "start": judgement.start,
        "lead_in_s": judgement.lead_in,
        "skipped_samples": judgement.lead,
        "cold_start_e_rms_um": finite_or_none(judgement.cold_start * UM),
        "inverse_e_rms_V": finite_or_none(judgement.inverse.e_rms),
        "inverse_e_rms_um": finite_or_none(judgement.inverse.e_displacement * UM),
        "inverse_noise_rms_V": finite_or_none(judgement.inverse.noise),
        "inverse_delay_s": judgement.inverse.latency,
        "inverse_band_Hz": judgement.inverse.band,
        "inverse_clamped_percent": finite_or_none(100 * judgement.inverse.saturated),
        "samples_out_of_range": int(np.count_nonzero(judgement.out_of_range)),
    }
    if judgement.one_step is None:
        return found
    return found | {
        "initial_displacement_um": judgement.start["initialDisplacement"] * UM,
        "one_step_ahead": {
            "e_mr_percent": 100 * judgement.one_step.e_mr,
            "e_rms_um": judgement.one_step.e_rms * UM,
        },
    }


def _line_json(judgement: Judgement, line: Errors, slope: float) -> dict:
    """Return the errors of a straight line, which is the model before an identification."""
    e_rms = line.e_rms * UM
    return {
        "e_mr_percent": 100 * line.e_mr,
        "e_rms_um": e_rms,
        "role": judgement.role,
        "model": "line",
        "inverse_e_rms_V": line.e_rms / abs(slope),
        "inverse_e_rms_um": e_rms,
    }


def finite_or_none(value: float) -> float | None:
    """Return the value, or None (JSON's null) where it is not a finite number."""
    return float(value) if np.isfinite(value) else None


def judged_records(report: Mapping) -> list[str]:
    """Return the names of the records that count most: of test, validation or training."""
    after = report["error"]["after"]
    role = next(r for r in COUNTING if any(e["role"] == r for e in after.values()))
    return [name for name, entry in after.items() if entry["role"] == role]


def pooled(report: Mapping, errors: Mapping, key: str) -> float:
    """Return the rms over the records that count of an error that is an rms on each; NaN if one lacks.

    Parameters
    ----------
    report : Mapping
        `report.json`.
    errors : Mapping
        By record, such as `report["error"]["after"]`.
    key : str
        Such as "e_rms_um".
    """
    names = judged_records(report)
    values = [errors[n].get(key) for n in names]
    weights = [report["error"]["after"][n]["samples"] for n in names]
    squares = [np.nan if v is None else v**2 for v in values]
    return float(np.sqrt(np.average(squares, weights=weights)))
