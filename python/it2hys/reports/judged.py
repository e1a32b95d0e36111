"""How models do on records, as reports show it: rows, sentences, figures, and `report.json`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from it2hys.identification.findings import sensor_step
from it2hys.identification.judgement import Judgement
from it2hys.model.variables import load_table
from it2hys.records import Record
from it2hys.records.record import INVERTED
from it2hys.reports import figures
from it2hys.reports.page import Picture, Table
from it2hys.reports.validity import out_of_range_sentence

UM = 1e6
ROLES = {"train": "training", "validation": "validation", "test": "test"}


def label(judgement: Judgement) -> str:
    """Return name and role of a record."""
    return f"{judgement.name} ({ROLES[judgement.role]})"


def inversion(records: Sequence[Record]) -> list[str]:
    """Return the sentence on records whose sign was flipped, if there are any."""
    return [f"Note: {INVERTED}"] if any(r.inverted for r in records) else []


def records_json(records: Sequence[Record]) -> dict:
    """Return what `report.json` says of the records themselves, by name."""
    return {
        r.name: {
            "displacement_inverted": r.inverted,
            "unused_columns": list(r.unused),
            "sensor_step_um": None if (step := sensor_step(r)) is None else UM * step,
            "notes": list(r.notes),
        }
        for r in records
    }


def judgement_json(judgement: Judgement) -> dict:
    """Return what `report.json` says of a model on a record, with the keys of DESIGN.md."""
    found = {
        "e_mr_percent": 100 * judgement.e_mr,
        "e_rms_um": judgement.e_rms * UM,
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


def finite_or_none(value: float) -> float | None:
    """Return the value, or None (JSON's null) where it is not a finite number."""
    return float(value) if np.isfinite(value) else None


def inverse_table(models: Mapping[str, Sequence[Judgement]]) -> Table:
    """Return what inverses ask for against the voltage that was applied.

    Parameters
    ----------
    models : mapping of str to sequence of Judgement
        How each model does on the records, by what it is called in the heads of the columns; the last
        one is described in full.
    """
    *_, last = models.values()
    rows = [
        [
            a.name, ROLES[a.role],
            *(f"{results[i].inverse.e_rms:.4g}" for results in models.values()),
            f"{a.inverse.noise:.2g}",
            *(f"{results[i].inverse.e_displacement * UM:.4f}" for results in models.values()),
            f"{a.inverse.latency * 1e3:.4g}", f"{a.inverse.band:.3g}",
            f"{100 * a.inverse.saturated:.2g}",
        ]
        for i, a in enumerate(last)
    ]  # fmt: skip
    return Table(
        [
            "record", "role",
            *(f"V rms {name}".rstrip() for name in models), "of that noise V",
            *(f"µm rms {name}".rstrip() for name in models),
            "delay ms", "band Hz", "clamped %",
        ],
        rows,
        "The inverse, fed with the displacement that was measured (up to the band, the highest "
        "frequency at which it stands out of the noise), against the voltage that was applied, later "
        "by the model's delay. It says on measured data how well feedforward will track.",
    )  # fmt: skip


def record_texts(record: Record, judgement: Judgement, ends: Mapping[str, float]) -> list[str]:
    """Return how a run on a record began, and what is to be noted of it.

    Parameters
    ----------
    record : Record
    judgement : Judgement
    ends : mapping of str to float
        For what the model holds, see `out_of_range_sentence`.
    """
    start = ", ".join(f"{n} = {v:.6g}" for n, v in judgement.start.items())
    beyond = out_of_range_sentence(
        ends, judgement.out_of_range, record.voltage, judgement.y - judgement.offset
    )
    return [
        f"The plant FMU gives this run with {start} (SI units).",
        f"The start is fitted on the lead-in, the first {judgement.lead_in:.3g} s, and the errors are "
        "those behind it.",
        *([beyond] if beyond else []),
        *(f"Note: {note}" for note in record.notes),
    ]


def inverse_picture(record: Record, models: Mapping[str, Judgement]) -> Picture:
    """Return the figure of what inverses ask for; of the first model's the error is drawn."""
    first = next(iter(models.values()))
    kept = slice(first.lead, None)
    return Picture(
        f"{record.name}_inverse",
        figures.inverse_course(
            record.time[kept],
            first.inverse.applied[kept],
            {name: j.inverse.asked[kept] for name, j in models.items()},
            first.inverse.e_displacement / max(first.inverse.e_rms, 1e-300),
            label(first),
        ),
        "The voltage that was applied, and what the inverse asks for when it is fed with the "
        "measured displacement.",
    )


def parameter_row(name: str, value: float, low: float, high: float) -> list[str]:
    """Return name, value, ends of the interval and unit of a parameter as a table shows them."""
    unit = load_table().parameters()[name].type.unit or ""
    scale = UM if unit.startswith("m") else 1.0
    shown = unit.replace("m", "µm", 1) if scale != 1.0 else unit
    return [name, *(f"{v * scale:.6g}" if np.isfinite(v) else "–" for v in (value, low, high)), shown]
