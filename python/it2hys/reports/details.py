"""The details of a report, folded on its page: tables of all records, effects and parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from it2hys.diagnosis.chances import comparisons, level
from it2hys.model.variables import load_table
from it2hys.policy import SEARCH
from it2hys.records.figures_of_merit import change_in_percent
from it2hys.reports.answers import decimals_of, figure, interval, notes, small
from it2hys.reports.inputs import ROLES, inputs_section
from it2hys.reports.page import NONE, Picture, Section, Table
from it2hys.support.numerals import plain

UM = 1e6
#: Errors below it are those of rounding, per cent and µm.
_ROUNDING = 1e-6


def details(report: Mapping) -> list[Section]:
    """Return the sections of a report behind its top.

    Parameters
    ----------
    report : Mapping
        `report.json`.
    """
    return [section for section in _sections(report) if section is not None]


def _sections(report: Mapping) -> Iterator[Section | None]:
    told = notes(report)
    yield Section("Notes", told) if told else None
    yield Section("Errors on all records", [], [error_table(report), inverse_table(report)])
    left = report["left_over"][1:]
    yield Section("The residual", left) if left else None
    yield _evidence(report) if report["evidence"] else None
    yield _steps(report) if report["steps"] else None
    yield _properties(report) if report["stage_figures"] else None
    yield from (Section.of_json(stored) for stored in report["sections"])
    yield _model_tracking(report) if "model_tracking" in report else None
    yield _records(report)
    yield _parameters(report) if report["parameters"] else None
    yield _fit(report) if report["seconds"] else None
    yield _use()
    yield inputs_section(report)


def error_table(report: Mapping) -> Table:
    """Return the errors of the free run on all records, beside a straight line's and the noise."""
    before, after = report["error"]["before"], report["error"]["after"]
    is_line = report["kind"] != "diagnosis"
    rows = []
    for name, entry in after.items():
        line, first = report["straight_line"][name], before[name]
        figures = [
            f"{line['e_mr_percent']:.2f}", f"{first['e_mr_percent']:.2f}",
            f"{entry['e_mr_percent']:.2f}", f"{entry['e_mr_at_s']:.6g}",
            f"{line['e_rms_um']:.4f}", f"{first['e_rms_um']:.4f}", f"{entry['e_rms_um']:.4f}",
        ]  # fmt: skip
        if is_line:  # the model before is the line
            del figures[5], figures[1]
        rows.append([name, ROLES[entry["role"]], *figures, small(entry["noise_rms_um"])])
    head = [
        "record", "role", "line e_mr %", "before e_mr %", "now e_mr %", "at s",
        "line e_rms µm", "before e_rms µm", "now e_rms µm", "noise µm",
    ]  # fmt: skip
    if is_line:
        head = [h for h in head if not h.startswith("before")]
    return Table(
        head,
        rows,
        "Plant, free run: largest error e_mr (24), with its time in the run of the present model, and "
        "rms error e_rms (25), both after the lead-in, the first part of a record, which serves only "
        "to fit the start of its run. Line: one straight line fitted to the training records.",
    )


def inverse_table(report: Mapping) -> Table:
    """Return what the inverses ask for against the voltage that was applied, on all records."""
    before, after = report["error"]["before"], report["error"]["after"]
    rows = [
        [
            name, ROLES[entry["role"]],
            small(before[name].get("inverse_e_rms_V"), ".4g"), small(entry["inverse_e_rms_V"], ".4g"),
            small(entry["inverse_noise_rms_V"], ".2g"),
            small(before[name].get("inverse_e_rms_um"), ".4f"), small(entry["inverse_e_rms_um"], ".4f"),
            f"{1e3 * entry['inverse_delay_s']:.4g}", plain(entry["inverse_band_Hz"]),
            small(entry["inverse_clamped_percent"], ".3g"),
        ]
        for name, entry in after.items()
    ]  # fmt: skip
    return Table(
        [
            "record", "role", "before V", "now V", "by noise alone V", "before µm", "now µm",
            "delay ms", "band Hz", "clamped %",
        ],
        rows,
        "Inverse, rms errors: its voltage for the measured displacement, against the applied voltage "
        "delayed by the model's delay. The displacement is filtered to the band, which ends at the "
        "highest frequency at which it exceeds the noise.",
    )  # fmt: skip


def evidence_tables(report: Mapping) -> list[Table]:
    """Return the effects that were added, and those that were not: a table for each common reason."""
    added = [e for e in report["evidence"] if e["accepted"]]
    others = [e for e in report["evidence"] if not e["accepted"]]
    groups: dict[str, list] = {}
    for entry in others:
        groups.setdefault(entry["reason"], []).append(entry)
    common = {reason: g for reason, g in groups.items() if len(g) > 1}
    alone = [entry for reason, g in groups.items() if reason not in common for entry in g]
    start = report["names"]["before"]
    tables = [_evidence_table(added, start, "Added")] if added else []
    tables += [_evidence_table(g, start, f"Not added: {reason}") for reason, g in common.items()]
    if alone:
        tables.append(_evidence_table(alone, start, "Not added, for different reasons", True))
    return tables


def _evidence_table(
    entries: Sequence[Mapping], start: str, caption: str, with_reason: bool = False
) -> Table:
    """Return a table of effects; what is the same for all of them stands in its caption."""
    bases = {tuple(e["beside"]) for e in entries if e["held_out_gain_percent"] is not None}
    if len(bases) == 1:
        base = " + ".join([f"the {start}", *next(iter(bases))])
        caption += f"; tried on top of {base}" if not entries[0]["accepted"] else ""
    columns: dict[str, list[str]] = {"effect": [e["effect"] for e in entries]}
    if len(bases) > 1:
        columns["beside"] = [" + ".join(e["beside"]) or NONE for e in entries]
    if bases:
        columns |= {
            "error before µm": [small(e["error_before_um"], ".4g") for e in entries],
            "with it µm": [small(e["error_after_um"], ".4g") for e in entries],
            "change %": [change_of(e["held_out_gain_percent"]) for e in entries],
            "p": [small(e["held_out_p_value"], ".2g") for e in entries],
        }
    columns["signature p"] = [small(e["p_value"], ".2g") for e in entries]
    if with_reason:
        columns["reason"] = [e["reason"] for e in entries]
    columns["signature"] = [e["signature"] or NONE for e in entries]
    rows = [list(row) for row in zip(*columns.values(), strict=True)]
    return Table(list(columns), rows, f"{caption}.")


def change_of(gain_percent: float | None) -> str:
    """Return by how much an error changes, per cent with its sign, from what it falls by."""
    return NONE if gain_percent is None else change_in_percent(-gain_percent / 100)


def _evidence(report: Mapping) -> Section:
    rows = report["evidence"]
    effects = len(rows)
    planned = [e for e in rows if e["level"] and e["level"] > level(effects)]
    return Section(
        "Evidence on every effect",
        [
            "Signature: a property of the first model's residual that this effect alone predicts, with "
            "its p-value. Error: of the free run on held-out data, without and with the effect, all "
            "parameters refitted; p is the probability of that change by chance (compared in blocks of "
            "samples). An effect is added only if the change is large enough to matter and p is "
            f"below {level(effects, len(planned)):.1g}, so that a whole search of up to "
            f"{comparisons(effects)} comparisons names an effect by chance with a probability of at "
            f"most {100 * SEARCH.budget:.0f} %.",
            f"Of a gain that halves the error, p up to {SEARCH.confirming:g} is enough: chance does "
            "that no oftener. A delay, which a slow core imitates in the free run, is added where the "
            "free run stays as good and the inverse becomes far better.",
            *([_designed_for(planned)] if planned else []),
        ],
        evidence_tables(report),
    )


def _designed_for(planned: Sequence[Mapping]) -> str:
    """Return what counts for the effects that the record was designed to show."""
    names = ", ".join(e["effect"] for e in planned)
    return (
        f"The record was designed for {names}: where one of them alone is added to the first model, "
        f"p up to {planned[0]['level']:.1g} is enough, as these comparisons were fixed before it was "
        "measured."
    )


def _steps(report: Mapping) -> Section:
    """Return the residuals before and after every step of the search."""
    rows, pictures, names = [], [], list(report["error"]["after"])
    for number, step in enumerate(report["steps"], start=1):
        added = " + ".join(step["added"])
        plant = [small(step["error"][n]["e_rms_um"], ".4f") for n in names]
        inverse = [small(step["error"][n]["inverse_e_rms_V"], ".4g") for n in names]
        rows.append([f"{number}: + {added}", figure(step["deciding_e_rms_um"]), *plant, *inverse])
        pictures += [
            Picture(name, None, f"Step {number}, + {added}: residual over time, voltage and frequency.")
            for name in step["pictures"]
        ]
    head = ["step", "held-out µm", *(f"{n} µm" for n in names), *(f"{n}, inverse V" for n in names)]
    caption = "Rms errors after every step: on held-out data, and of plant and inverse on all records."
    return Section("The search, step by step", [], [Table(head, rows, caption)], pictures)


def _properties(report: Mapping) -> Section:
    """Return what the records determine of the stage, and the parameters of its effects."""
    rows = [
        [f["meaning"], *_with_unit(f["value"], f["ci95"], f["unit"])] for f in report["stage_figures"]
    ]
    tables = [Table(["property", "value", "95 % interval", "unit"], rows)]
    known = load_table().parameters()
    of_effects = {n: p for n, p in report["parameters"].items() if n in known and known[n].effect}
    if of_effects:
        rows = [
            [n, known[n].description, *_with_unit(p["value"], p["ci95"], p["unit"])]
            for n, p in of_effects.items()
        ]
        head = ["parameter", "meaning", "value", "95 % interval", "unit"]
        tables.append(Table(head, rows, "Parameters of effects."))
    return Section(
        "Properties of the stage",
        [
            "Quantities that the training records determine, with 95 % intervals that allow for "
            "residuals correlated in time."
        ],
        tables,
    )


def _with_unit(value: float, ends: list, unit: str) -> list[str]:
    """Return value, interval and unit as people read them: lengths in µm, short times in ms."""
    scale, shown = read_as(unit)
    if unit == "s" and abs(value) < 1.0:
        scale, shown = 1e3, "ms"
    low, high = ends
    if low is None or high is None:
        return [figure(scale * value), "not determined", shown]
    decimals = decimals_of(scale * (high - low))
    return [f"{scale * value:.{decimals}f}", interval(low, high, scale), shown]


def read_as(unit: str) -> tuple[float, str]:
    """Return factor and name of the unit that people read for one of a parameter."""
    if unit == "1":
        return 1.0, ""
    return (UM, unit.replace("m", "µm", 1)) if unit.startswith("m") else (1.0, unit)


def _model_tracking(report: Mapping) -> Section:
    rows = [
        [
            {"before": f"before: {report['names']['before']}", "after": "now"}[name],
            _or_nothing(entry["e_mr_percent"]), _or_nothing(entry["e_rms_um"]),
            f"{entry['limited_percent']:.3g}",
        ]
        for name, entry in sorted(report["model_tracking"].items(), reverse=True)
    ]  # fmt: skip
    return Section(
        "The FMUs together: the inverse drives the plant",
        [
            "The paper's reference, a sine, scaled to the range and pace of the records. The plant is "
            "the model found here, as FMU; the inverse is exact, so this shows that the two FMUs "
            "agree. How well the real stage follows is limited by the errors at the top."
        ],
        [
            Table(
                ["inverse", "e_mr %", "e_rms µm", "clamped %"],
                rows,
                "Tracking errors in co-simulation. Clamped: share of samples in which the range or the "
                "amplifier clamps the reference (records with ringing may exceed the static "
                "range).",
            )
        ],
        [Picture("tracking", None, "Reference, displacement, error and voltage (paper's Figure 7).")],
    )


def _or_nothing(error: float) -> str:
    """Return an error; one of rounding as such."""
    return f"{error:.2g}" if error >= _ROUNDING else f"< {_ROUNDING:g}"


def _records(report: Mapping) -> Section:
    after, before = report["error"]["after"], report["error"]["before"]
    rows = [
        [
            name, ROLES[e["role"]], str(report["records"][name]["samples"]),
            f"{1 / report['records'][name]['sample_time_s']:.6g}", f"{e['lead_in_s']:.3g}",
            f"{e['offset_um']:.3f}",
            small(before[name].get("cold_start_e_rms_um"), ".4f"),
            small(e["cold_start_e_rms_um"], ".4f"),
            small(e["explained_percent"], ".4g"), small(e["voltage_explains_percent"], ".4g"),
        ]
        for name, e in after.items()
    ]  # fmt: skip
    head = [
        "record", "role", "samples", "Hz", "lead-in s", "offset removed µm", "cold start before µm",
        "cold start now µm", "explained %", "by voltage %",
    ]  # fmt: skip
    table = Table(
        head,
        rows,
        "Cold start: e_rms of the plant FMU as packaged, given only the first displacement. "
        "Explained: share of the displacement's variance that the free run explains. By voltage: the "
        "share that a general predictor, without physics, explains on data it was not fitted to.",
    )
    texts = []
    for name, entry in after.items():
        own = report["records"][name]
        start = ", ".join(f"{n} = {v:.6g}" for n, v in entry["start"].items())
        texts.append(
            f"{name}: the plant FMU gives this run with {start} (SI units). Noise by "
            f"{own['noise_method'] or 'the residual'}. Figures for papers: "
            + ", ".join(f"{name}_{kind}.png" for kind in ("time", "loop", "inverse"))
            + "."
        )
        texts += [f"{name}: {own['out_of_range']}"] if own["out_of_range"] else []
        texts += [f"{name}: {note}" for note in own["notes"]]
    return Section("Records, and the start of their runs", texts, [table])


def _parameters(report: Mapping) -> Section:
    """Return the fitted parameters of the rules; the effects' stand among the properties."""
    known = load_table().parameters()
    rules = {n: p for n, p in report["parameters"].items() if not (n in known and known[n].effect)}
    rows = []
    for name, p in rules.items():
        scale, unit = read_as(p["unit"])
        low, high = p["ci95"] if p["determined"] else (None, None)
        rows.append([name, f"{scale * p['value']:.6g}", interval(low, high, scale), unit])
    texts = []
    if any(not p["determined"] for p in rules.values()):
        texts.append(
            "Not determined: other values would fit as well. Within the range above the model's output "
            "does not depend on them; the properties of the stage are determined by the records."
        )
    if report.get("condition"):
        texts.append(f"The condition number of the scaled problem is {report['condition']:.2g}.")
    table = Table(["parameter", "value", "95 % interval", "unit"], rows)
    return Section("Parameters of the rules", texts, [table])


def _fit(report: Mapping) -> Section:
    seconds = ", ".join(f"{k} {v:.1f} s" for k, v in report["seconds"].items())
    fit = report.get("fit")
    if fit is None:
        return Section("How it was found", [f"Duration: {seconds}."])
    texts = [
        f"The fit ended: {fit['message'].rstrip('.')}. The largest contraction |∂y(k)/∂y(k−1)| over "
        f"the displacement range is {report['contraction']:.4f} (below 1: the effect of a wrong start "
        "decays; beyond the range the model continues with the contraction of its ends, so that no "
        "voltage makes a free run diverge).",
        f"Duration: {seconds}.",
        *fit["searched"],
    ]
    rows = [
        [str(i), small(s["one_step_rms_um"], ".4f"), small(s["free_run_rms_um"], ".4f")]
        for i, s in enumerate(fit["starts"], start=1)
    ]
    caption = "The best initial guesses and the rms errors on the training records that they led to."
    tables = [Table(["start", "one-step µm", "free run µm"], rows, caption)]
    if fit["orders"]:
        rows = [[str(o["rules"]), f"{o['e_rms_um']:.4f}"] for o in fit["orders"]]
        head = ["rules", "held-out free-run error µm"]
        tables.append(Table(head, rows, "Numbers of rules that were tried."))
    rows = [
        [name, ROLES[e["role"]], f"{e['one_step_ahead']['e_mr_percent']:.2f}",
         f"{e['one_step_ahead']['e_rms_um']:.4f}"]
        for name, e in report["error"]["after"].items()
        if "one_step_ahead" in e
    ]  # fmt: skip
    if rows:
        head = ["record", "role", "one-step e_mr %", "one-step e_rms µm"]
        caption = (
            "One step ahead, where the model is given the measured y(k-1): this says nothing about a "
            "free run."
        )
        tables.append(Table(head, rows, caption))
    return Section("How it was identified", texts, tables)


def _use() -> Section:
    return Section(
        "Using the FMUs",
        [
            "IT2Plant.fmu and IT2Inverse.fmu lie beside this report, with the parameter set in "
            "parameters.ssv. Any FMI 2.0 co-simulation master runs them; quantities are in SI units. "
            "To repeat a free run, set the start values that are given with the record, step at "
            "sampleTime, and add the offset."
        ],
    )
