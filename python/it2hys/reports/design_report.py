"""A designed record as files: the voltage as CSV, what it promises as JSON, and both as a page."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from it2hys.designs.designing import Design, design, probability, takes_long
from it2hys.designs.hypotheses import NEITHER, question_of_report
from it2hys.designs.promise import Separation
from it2hys.diagnosis.outcome import Diagnosis
from it2hys.errors import InputError
from it2hys.model.variables import load_table
from it2hys.records import Record
from it2hys.records.writing import write_signals
from it2hys.reports import figures
from it2hys.reports.answers import figure
from it2hys.reports.details import read_as
from it2hys.reports.page import NONE, Answer, Page, Picture, Section, Table, write_page, write_pictures
from it2hys.reports.provenance import Provenance, about
from it2hys.reports.summary import finite_or_none
from it2hys.support.files import make_directory, read_json, write_atomically
from it2hys.support.numerals import plain
from it2hys.support.progress import Progress

UM = 1e6
#: Files that a design writes.
VOLTAGE, DESIGN_JSON, DESIGN_PAGE, PICTURE = "voltage.csv", "design.json", "design.html", "design"
#: What designs the record to measure next, in the folder of a diagnosis.
_COMMAND = "it2hys design report.json -o DIR"
#: Its figure in that diagnosis.
NEXT = "next"
NEXT_CAPTION = (
    "The record to measure next: its voltage, its spectrum and the displacement that each model in "
    "question predicts; of rivals, also the difference that remains when one is refitted to another."
)


def write_design(
    found: Design, directory: str | Path, provenance: Provenance | None = None, model: str = "P.ssv"
) -> Path:
    """Write `voltage.csv`, `design.json`, the figure and `design.html`.

    Parameters
    ----------
    found : Design
    directory : path
        Created if it does not exist.
    provenance : Provenance, optional
    model : str
        The parameter set to start the diagnosis of the new record from, as it is typed.

    Returns
    -------
    Path
        The page.
    """
    directory = make_directory(directory)
    report = design_json(found, provenance or Provenance(), model)
    write_signals(directory / VOLTAGE, found.time, {"voltage": (found.voltage, "V")})
    write_pictures(directory, [Picture(PICTURE, drawn(found), "")])
    write_atomically(directory / DESIGN_JSON, (json.dumps(report, indent=1) + "\n").encode())
    return write_page(directory, _page(report), name=DESIGN_PAGE)


def draw_design(directory: str | Path) -> Path:
    """Draw the page of a design again, from its `design.json` and its figure; return the page.

    Raises
    ------
    InputError
        If `design.json` or the figure cannot be read.
    """
    directory = Path(directory)
    return write_page(directory, _page(read_design(directory / DESIGN_JSON)), name=DESIGN_PAGE)


def drawn(found: Design) -> Figure:
    """Return the figure of a designed record."""
    return figures.designed_record(
        found.time, found.voltage, found.readings, found.left, found.question.noise
    )


def design_json(found: Design, provenance: Provenance, model: str) -> dict:
    """Return what `design.json` says; docs/design.schema.json documents the keys."""
    limits, question = found.limits, found.question
    rate = float(np.max(np.abs(np.diff(found.voltage)))) / limits.sample_time
    return {
        "title": f"The next experiment: {' or '.join(found.names)}"
        if len(found.names) > 1
        else "The next experiment: parameters",
        **provenance.entries(),
        "names": list(found.names),
        "decides": found.decides,
        "power": found.power,
        "promise": found.sentences,
        "noise_um": UM * question.noise,
        "family": found.family,
        "words": found.words,
        "limits": {
            "voltage_V": [limits.low, limits.high],
            "slew_V_per_s": limits.rate,
            "sample_time_s": limits.sample_time,
            "duration_s": limits.duration,
            "periods": limits.periods,
            "band_Hz": [limits.lowest, limits.highest],
            "said": list(limits.said),
        },
        "record": {
            "file": VOLTAGE,
            "samples": len(found.voltage),
            "voltage_V": [float(found.voltage.min()), float(found.voltage.max())],
            "fastest_V_per_s": rate,
        },
        "models": [
            {"name": h.name, "effects": list(h.effects), "said": h.said} for h in question.hypotheses
        ],
        "said": list(question.said),
        "pairs": [_pair_json(s) for s in found.separations],
        "parameters": _parameters_json(found, found.intervals),
        "others": {
            name: {
                "pairs": [_pair_json(s) for s in separations],
                "parameters": _parameters_json(found, found.other_intervals[name]),
            }
            for name, separations in found.others.items()
        },
        "simulated": [
            {"truth": s.truth, "rival": s.rival, "told": s.told, "draws": s.draws, "by": s.by}
            for s in found.simulated
        ],
        "needed": list(found.needed),
        "measure": f"it2hys diagnose NEW.csv --model {model} --design {DESIGN_JSON} -o DIR",
        "evaluated": found.evaluated,
        "seconds": found.seconds,
    }


def _pair_json(s: Separation) -> dict:
    return {
        "truth": s.truth,
        "rival": s.rival,
        "distance_noise": finite_or_none(s.distance),
        "gain_percent": finite_or_none(100 * s.gain),
        "power": finite_or_none(s.power),
        "refused": s.refused,
        "rejected": s.rejected,
    }


def _parameters_json(
    found: Design, intervals: Mapping[str, Mapping[str, tuple[float, float]]]
) -> dict[str, dict]:
    known = load_table().parameters()
    sets = {h.name: h.parameters for h in found.question.hypotheses}
    return {
        model: {
            name: {
                "value": sets[model][name],
                "ci95": [finite_or_none(low), finite_or_none(high)],
                "unit": known[name].type.unit or "1",
            }
            for name, (low, high) in own.items()
        }
        for model, own in intervals.items()
    }


# --- the page ------------------------------------------------------------------------------------


def _page(report: Mapping) -> Page:
    answers = [Answer("What to play", [*report["promise"], _rates(report)])]
    if report["pairs"]:
        answers.append(Answer("What it tells apart", [_TOLD], _pairs_table(report), _checked(report)))
    answers.append(Answer("Which parameters it determines", [_DETERMINED], _parameter_table(report)))
    answers.append(
        Answer(
            "What to do with it",
            [
                f"Play {VOLTAGE} (time_s, voltage_V) on the rig, record the displacement at the same "
                f"rate, and run `{report['measure']}`: its report compares the result "
                "with this promise."
            ],
        )
    )
    assumed = [
        f"{text[:1].upper()}{text[1:]}." for text in (*_models(report), *report["limits"]["said"])
    ]
    details = [
        Section("Limits and assumptions", [*assumed, _WHITE]),
        Section("How it was found", [_how(report)]),
    ]
    caption = (
        "The voltage, its spectrum, the models' predictions for it, and the difference that remains "
        "when one model is refitted to another's prediction."
        if report["pairs"]
        else "The voltage, its spectrum, and the displacement of the model."
    )
    picture = Picture(PICTURE, None, caption)
    return Page(report["title"], about(report), answers, [picture], details=details)


_TOLD = (
    "The probability that `it2hys diagnose` calls the true model the better one, at its own test "
    "level. Every model is refitted to the prediction of every other; the distance is the difference "
    "that remains over the whole record, in units of the noise. A model that, refitted, does no more "
    "than a delay or another sampling would is one that the diagnosis refuses. Neither: the model with "
    "none of these effects; one that is no better than that is told apart, too, for the diagnosis does "
    "not consider it. Where a model is to be told at other sizes of its effect, too, this is the mean "
    "for all of them."
)
_DETERMINED = "Expected 95 % intervals, if the model is the right one."
_WHITE = "The noise is assumed to be white, stationary and independent of the motion."


def _models(report: Mapping) -> list[str]:
    known = [m["said"] for m in report["models"] if m["said"]]
    return list(dict.fromkeys([*known, *report["said"]]))


def _rates(report: Mapping) -> str:
    record, limits = report["record"], report["limits"]
    low, high = record["voltage_V"]
    return (
        f"It goes from {figure(low)} to {figure(high)} V, changes by at most "
        f"{plain(record['fastest_V_per_s'], 4)} V/s, lasts {limits['duration_s']:.4g} s in "
        f"{record['samples']} samples every {1e3 * limits['sample_time_s']:.4g} ms, and begins and "
        "ends at rest."
    )


def _pairs_table(report: Mapping) -> Table:
    others = report["others"]
    rows = []
    for i, pair in enumerate(report["pairs"]):
        rows.append(
            [
                pair["truth"],
                pair["rival"],
                _distance(pair),
                probability(pair["power"]),
                *(probability(o["pairs"][i]["power"]) for o in others.values()),
            ]
        )
    return Table(
        ["true model", "told from", "distance / noise", "this record", *others],
        rows,
        "Probability of telling them apart",
    )


def _distance(pair: Mapping) -> str:
    if pair["refused"]:
        return "no more than a delay"
    if pair["distance_noise"] is None:
        return NONE
    beside = f", no better than {NEITHER}" if pair["rejected"] > 0.5 else ""
    return f"{pair['distance_noise']:.0f}{beside}"


def _checked(report: Mapping) -> list[str]:
    """Return what came of simulated records."""
    texts = []
    for by, what in (("refits", "Both models refitted to"), ("diagnosis", "The whole diagnosis of")):
        told = [s for s in report["simulated"] if s["by"] == by]
        if told:
            counts = ", ".join(
                f"{s['truth']} told from {s['rival']} in {s['told']} of {s['draws']}" for s in told
            )
            texts.append(f"{what} simulated records with noise: {counts}.")
    return texts


def _parameter_table(report: Mapping) -> Table:
    others = report["others"]
    rows = []
    for model, own in report["parameters"].items():
        for name, entry in own.items():
            ends = [entry["ci95"], *(o["parameters"][model][name]["ci95"] for o in others.values())]
            scale, unit = read_as(entry["unit"])
            widths = [NONE if w is None else f"± {scale * w:.2g}" for w in map(_half_width, ends)]
            rows.append([model, name, f"{scale * entry['value']:.4g}", unit, *widths])
    heads = ["model", "parameter", "value", "unit", "this record", *others]
    if len(report["parameters"]) == 1:
        heads, rows = heads[1:], [row[1:] for row in rows]
    return Table(heads, rows)


def _half_width(ends: Sequence[float | None]) -> float | None:
    low, high = ends
    return None if low is None or high is None else 0.5 * (high - low)


def _how(report: Mapping) -> str:
    return (
        f"Of {report['evaluated']} records of the allowed families, it separates the pair of models "
        "that is hardest to tell apart best. Among records that separate all pairs with certainty, the "
        "one is taken that determines the parameters best. "
        f"Seed {report['seed']}; the same seed gives the same record."
    )


# --- what a diagnosis ends with ------------------------------------------------------------------


def next_record(
    report: Mapping, result: object, progress: Progress
) -> tuple[dict | None, list[Picture]]:
    """Return the record that decides what a diagnosis could not, coarsely designed, and its figure.

    Parameters
    ----------
    report : Mapping
        What the diagnosis says, but for this.
    result : Diagnosis or another result
        Of which there is no such record.
    progress : callable
        Told the share done and what is being done.

    Notes
    -----
    It is designed between effects that cannot be told apart; where there are none, for the parameters
    of effects that were found and the records leave open. Where that takes long, there is the command
    alone.

    Returns
    -------
    entry : dict or None
        A key of `report.json`; None where everything was told apart.
    pictures : list of Picture
    """
    if not isinstance(result, Diagnosis) or not (result.indistinguishable or _open(report)):
        return None, []
    try:
        question = question_of_report(report, lambda: result.parameters)
        if takes_long(question):
            return {"promise": [], "command": _COMMAND, "power": None}, []
        found = design(question, coarse=True, progress=progress)
    except InputError as error:  # what no voltage decides: a channel is needed, or a faster sampling
        return {"promise": [f"No record was designed: {error}"], "command": None, "power": None}, []
    entry = {"promise": found.sentences, "command": _COMMAND, "power": found.power}
    return entry, [Picture(NEXT, drawn(found), "")]


def _open(report: Mapping) -> bool:
    """Return whether the records leave a parameter of an effect open that was found."""
    known = load_table().parameters()
    return any(
        not entry["determined"] and known[name].effect in report["effects"]
        for name, entry in report["parameters"].items()
    )


# --- what came out --------------------------------------------------------------------------------


def read_design(path: str | Path) -> dict:
    """Return what a `design.json` holds.

    Raises
    ------
    InputError
        If it cannot be read, or is something else.
    """
    return read_json(
        Path(path),
        ("names", "power", "promise", "noise_um", "pairs", "parameters", "record"),
        "; `it2hys design` writes it",
        "; give a design.json that `it2hys design` wrote",
    )


def designed_voltage(path: str | Path, report: Mapping) -> np.ndarray | None:
    """Return the voltage beside a `design.json`, V; None where it is not there any more."""
    file = Path(path).with_name(report["record"]["file"])
    if not file.is_file():
        return None
    return np.loadtxt(file, delimiter=",", skiprows=1)[:, 1]


def beside_promise(
    design: Mapping, voltage: np.ndarray | None, records: Sequence[Record], report: Mapping
) -> dict:
    """Return what a design promised and what came out, a key of `report.json`.

    Parameters
    ----------
    design : Mapping
        `design.json`.
    voltage : ndarray, shape (N,), or None
        That it asked for, V.
    records : sequence of Record
        The training records.
    report : Mapping
        What the diagnosis says.
    """
    named = [e for e in report["effects"] if e in design["names"]]
    return {
        "names": design["names"],
        "power": design["power"],
        "noise_um": design["noise_um"],
        "named": named,
        "told": len(named) == 1,
        "played_off_V": None if voltage is None else finite_or_none(_off(voltage, records)),
        "parameters": [
            {
                "name": name,
                "unit": entry["unit"],
                "promised": _half_width(entry["ci95"]),
                "found": _half_width(report["parameters"][name]["ci95"]),
                "value": report["parameters"][name]["value"],
            }
            for model in ([*named] if len(design["names"]) > 1 else design["names"])
            for name, entry in design["parameters"].get(model, {}).items()
            if name in report["parameters"]
        ],
    }


def _off(voltage: np.ndarray, records: Sequence[Record]) -> float:
    """Return by how much the record that is nearest to a voltage is off it, V rms."""
    found = [np.inf]
    for record in records:
        count = min(len(record), len(voltage))
        found.append(float(np.sqrt(np.mean((record.voltage[:count] - voltage[:count]) ** 2))))
    return min(found)
