"""The outcome of an identification: parameter set, FMUs, report and JSON in one directory."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from it2hys.cosimulation.simulation import track
from it2hys.errors import InputError
from it2hys.fmu.packaging import package
from it2hys.identification.excerpts import searched_text
from it2hys.identification.explained import low_shares
from it2hys.identification.judgement import Judgement
from it2hys.identification.result import Identification
from it2hys.model.parameters import ParameterSet
from it2hys.model.variables import load_table
from it2hys.records import Record
from it2hys.records.figures_of_merit import (
    Errors,
    max_relative_error,
    noise_size,
    small_figure,
    times_the_noise,
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
from it2hys.reports.page import Picture, Section, Table, write_report
from it2hys.reports.verdict import model_verdict, straight_line_errors
from it2hys.support.files import make_directory, write_atomically
from it2hys.support.progress import Progress

# a free-run error above this many times the noise says that the model lacks something
FAR_ABOVE_NOISE = 2.0
#: What to do where the model, or its inverse, is of no use.
ADVICE = (
    "Do not rely on it: `it2hys diagnose` with the same records looks for the effects that it lacks, "
    "and adds them."
)
NO_MEMORY = (
    "The one-step-ahead error is much the smaller one because the prediction leans on the measured "
    "y(k-1), which is nearly the answer. In free run the model has only the voltage and its own past: "
    "its one state remembers no turning points, and its loop is phase lag, which grows with "
    "frequency, where a piezo's loop hardly does."
)


def write_identification(
    identification: Identification,
    records: Sequence[Record],
    directory: str | Path,
    title: str = "Identification",
    extra: Sequence[Section] = (),
    first: Sequence[str] = (),
    progress: Progress = lambda share, text: None,
) -> Path:
    """Write the parameter set, both FMUs, `report.html`, its figures and `report.json`.

    Parameters
    ----------
    identification : Identification
        The result.
    records : sequence of Record
        In the order of `identification.records`.
    directory : path
        Created if it does not exist.
    title : str
        Of the report.
    extra : sequence of Section
        Put after the records.
    first : sequence of str
        Sentences with which the report begins, but for one that says that the model is of no use.
    progress : callable
        Told the share done and what is being done.

    Returns
    -------
    Path
        The report.

    Raises
    ------
    InputError
        If the fit has not converged: nothing is written then.
    """
    if not identification.converged:
        raise InputError(
            f"the fit did not converge ({identification.message}); no parameter set is written. "
            "Try more iterations (--max-iterations), fewer rules, or records that cover the range"
            " better"
        )
    directory = make_directory(directory)
    found_in = origin("identify", records, identification.records)
    package(identification.parameters, directory, origin=found_in)
    results = identification.records
    lines = straight_line_errors(records, results)
    texts = summary(identification, lines, first)
    sections = [
        Section(
            "Summary",
            [*texts, *inversion(records)],
            [error_table(identification, lines), inverse_table({"": results})],
        ),
        *(
            record_section(record, result, identification.parameters)
            for record, result in zip(records, results, strict=True)
        ),
        *extra,
        _tracking_section(directory, identification, records[0]),
        _parameter_section(identification),
        _method_section(identification),
        _use_section(),
    ]
    outcome = summary_json(identification, lines) | {"records": records_json(records)}
    document = json.dumps(outcome, indent=1) + "\n"
    write_atomically(directory / "report.json", document.encode())
    return write_report(directory, title, sections, progress)


def summary(
    identification: Identification, lines: Sequence[Errors], first: Sequence[str] = ()
) -> list[str]:
    """Return what was found, in plain words; first of all if it is of no use."""
    count = identification.parameters.counts["rule"]
    ratio = identification.error_over_noise
    texts = [
        *model_verdict(identification.records, lines, ADVICE),
        *low_shares(identification.records),
        *first,
        f"The interval type-2 fuzzy model with {_count(count, 'rule')} was identified on "
        f"{_count(len(identification.by_role('train')), 'training record')}. The noise: "
        f"{noise_size(identification.noise_rms)}. A model is judged by its free run, from voltage "
        "alone.",
    ]
    if ratio > FAR_ABOVE_NOISE:
        texts.append(
            f"On the training records the free-run error is {times_the_noise(ratio)}: far above it. "
            "The records contain something that this model does not describe; `it2hys diagnose` with "
            "the same records looks for it. " + NO_MEMORY
        )
    else:
        texts.append(
            f"On the training records the free-run error is {times_the_noise(ratio)}: the model "
            "explains what can be explained."
        )
    for result in identification.by_role("test"):
        texts.append(
            f"On the test record {result.name}, which decided nothing, it is "
            f"{result.e_rms * UM:.3g} µm rms, {times_the_noise(result.e_rms / result.noise)} of "
            f"that record ({noise_size(result.noise)})."
        )
    return texts + [f"Note: {warning}" for warning in identification.warnings]


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"


def error_table(identification: Identification, lines: Sequence[Errors]) -> Table:
    """Return the errors of all records: straight line, one step ahead, free run, noise."""
    rows = [
        [
            r.name, ROLES[r.role],
            f"{100 * line.e_mr:.2f}", f"{line.e_rms * UM:.4f}",
            f"{100 * r.one_step.e_mr:.2f}", f"{r.one_step.e_rms * UM:.4f}",
            f"{100 * r.e_mr:.2f}", f"{r.e_rms * UM:.4f}", f"{r.cold_start * UM:.4f}",
            small_figure(r.noise * UM), f"{r.offset * UM:.3f}", f"{r.lead_in:.3g}",
        ]
        for r, line in zip(identification.records, lines, strict=True)
    ]  # fmt: skip
    return Table(
        [
            "record", "role",
            "line e_mr %", "line e_rms µm",
            "one-step e_mr %", "one-step e_rms µm",
            "free-run e_mr %", "free-run e_rms µm", "cold start µm",
            "noise µm", "offset removed µm", "lead-in s",
        ],
        rows,
        "Errors (24) and (25) behind the lead-in: the first part of a record, on which the start of "
        "its run is fitted and nothing else. Line: one straight line fitted to the training records. "
        "One-step: the model is given the measured y(k-1). Free run: it gets the voltage alone. "
        "Cold start: e_rms of the plant FMU as packaged, told nothing but the first displacement.",
    )  # fmt: skip


def record_section(record: Record, result: Judgement, ends: ParameterSet) -> Section:
    """Return how a model does on one record: over time, over voltage, and its inverse."""
    kept = slice(result.lead, None)
    time, voltage = record.time[kept], record.voltage[kept]
    measured, runs = record.displacement[kept], {"free run": result.y[kept]}
    ahead = {"one step ahead": result.one_step.y[kept]} if result.one_step else {}
    return Section(
        f"Record {label(result)}",
        [
            f"{len(record)} samples at {1 / record.sample_time:.6g} Hz. "
            f"Noise by {result.noise_method}.",
            *record_texts(record, result, ends),
        ],
        pictures=[
            Picture(
                f"{result.name}_time",
                figures.time_course(time, measured, {**runs, **ahead}, label(result), result.noise),
                "Displacement and error over time (compare the paper's Figures 2, 4 and 5).",
            ),
            Picture(
                f"{result.name}_loop",
                figures.hysteresis_loop(voltage, measured, runs, label(result)),
                "Hysteresis loop and error over voltage (compare the paper's Figure 3).",
            ),
            inverse_picture(record, {"": result}),
        ],
    )


def _tracking_section(directory: Path, identification: Identification, record: Record) -> Section:
    """Run the FMUs just written on a reference that suits the record: 90 % of its range, its pace."""
    low, high = record.displacement.min(), record.displacement.max()
    periods, samples = 2.0, min(4000, len(record))
    phase = 2 * np.pi * periods * np.arange(samples) / samples
    reference = (low + high) / 2 - 0.45 * (high - low) * np.cos(phase)
    run = track(
        directory / "IT2Inverse.fmu",
        directory / "IT2Plant.fmu",
        reference,
        {"initialDisplacement": float(reference[0])},
    )
    error = max_relative_error(reference, run["displacement"])
    return Section(
        "Feedforward: inverse FMU drives plant FMU",
        [
            "A sine over 90 % of the record's range through IT2Inverse.fmu and its voltage through "
            f"IT2Plant.fmu, in co-simulation: e_mr is {100 * error:.2g} %. The inverse is exact, so "
            "this says that the two FMUs fit together; how well the real stage tracks is limited by "
            "the free-run errors above."
        ],
        pictures=[
            Picture(
                "tracking_model",
                figures.tracking(
                    np.arange(samples) * record.sample_time,
                    reference,
                    {"plant FMU": run["displacement"]},
                    run["voltage"],
                    "inverse → plant",
                ),
                "Reference, displacement, error and voltage (compare the paper's Figure 7).",
            )
        ],
    )


def _parameter_section(identification: Identification) -> Section:
    rows = [
        [
            *parameter_row(name, identification.parameters[name], low, high),
            "no" if name in identification.undetermined else "yes",
        ]
        for name, (low, high) in identification.intervals.items()
    ]
    text = [f"The condition number of the scaled problem is {identification.condition:.2g}."]
    if identification.undetermined:
        text.append(
            "The data do not determine " + ", ".join(identification.undetermined) + ": other values "
            "would fit as well. The model's output is not affected, the values mean little."
        )
    return Section(
        "Parameters",
        text,
        [Table(["parameter", "value", "95 % from", "to", "unit", "determined"], rows)],
    )


def _method_section(identification: Identification) -> Section:
    text = [
        f"The fit ended: {identification.message.rstrip('.')}. The largest contraction "
        "|∂y(k)/∂y(k−1)| over the displacement range is "
        f"{identification.contraction:.4f} (below 1: a wrong start is forgotten; "
        "beyond the range the model goes on as the contraction that it is at its ends, so that no "
        "voltage makes a free run diverge).",
        "Duration: " + ", ".join(f"{k} {v:.1f} s" for k, v in identification.seconds.items()) + ".",
    ]
    samples = sum(len(r.y) for r in identification.by_role("train"))
    text += filter(None, [searched_text(samples)])
    tables = [
        Table(
            ["start", "one-step µm", "free run µm"],
            [
                [str(i), f"{s.one_step_rms * UM:.4f}", f"{s.free_run_rms * UM:.4f}"]
                for i, s in enumerate(identification.starts[:10], start=1)
            ],
            "The best starts and where they led: rms errors on the training records.",
        )
    ]
    if identification.orders:
        tables.append(
            Table(
                ["rules", "deciding free-run error µm"],
                [[str(o.rules), f"{o.e_rms * UM:.4f}"] for o in identification.orders],
                "Numbers of rules that were tried.",
            )
        )
    return Section("How it was identified", text, tables)


def _use_section() -> Section:
    return Section(
        "Using the FMUs",
        [
            "IT2Plant.fmu and IT2Inverse.fmu lie beside this report, with the parameter set in "
            "parameters.ssv. Any FMI 2.0 co-simulation master runs them; quantities are in SI units. "
            "To repeat a free run above, set initialDisplacement to the value given with the record, "
            "step at sampleTime, and add the offset in the table."
        ],
    )


def summary_json(identification: Identification, lines: Sequence[Errors]) -> dict:
    """Return `report.json` as a dictionary, with the keys of DESIGN.md."""
    known = load_table().parameters()
    results = identification.records
    return {
        "effects": [],
        "unexplained": bool(identification.error_over_noise > FAR_ABOVE_NOISE),
        "noise_rms_um": identification.noise_rms * UM,
        "error": {
            "before": {
                r.name: {
                    "e_mr_percent": 100 * line.e_mr,
                    "e_rms_um": line.e_rms * UM,
                    "role": r.role,
                    "model": "line",
                }
                for r, line in zip(results, lines, strict=True)
            },
            "after": {r.name: judgement_json(r) for r in results},
        },
        "evidence": [],
        "parameters": {
            name: {
                "value": identification.parameters[name],
                "ci95": [finite_or_none(low), finite_or_none(high)],
                "unit": known[name].type.unit or "1",
                "determined": name not in identification.undetermined,
            }
            for name, (low, high) in identification.intervals.items()
        },
        "warnings": list(identification.warnings),
        "condition": finite_or_none(identification.condition),
        "contraction": identification.contraction,
        "seconds": identification.seconds,
    }
