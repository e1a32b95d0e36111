"""The five answers at the top of a report, in words.

They come from `report.json` alone, so that a page that is drawn again has the same text.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from it2hys.designs.designing import probability, told_apart
from it2hys.diagnosis.outcome import ON_TEST_RECORDS
from it2hys.identification.coverage import ONE_TONE
from it2hys.identification.explained import low_share
from it2hys.policy import REFERENCE, TELLING
from it2hys.records.figures_of_merit import Errors, noise_size, small_figure, times_the_noise
from it2hys.records.record import INVERTED
from it2hys.reports.inputs import ROLES
from it2hys.reports.page import NONE, Answer, Table
from it2hys.reports.summary import judged_records, pooled
from it2hys.reports.verdict import model_verdict
from it2hys.support.numerals import counted, plain

UM = 1e6
#: Advice where the model, or its inverse, is of no use.
DIAGNOSE = (
    "Do not rely on it: `it2hys diagnose` with the same records looks for the effects that it lacks, "
    "and adds them."
)
MORE_RECORDS = (
    "Do not rely on it: see what is not explained, and give `it2hys diagnose` records of other kinds, "
    "too: slow and fast, with holds, with small loops."
)
OTHER_SPECIMEN = (
    "These parameters belong to another specimen: `it2hys identify` with records of the stage itself "
    "gives its own, and `it2hys diagnose` the effects that they lack."
)
_ADVICE = {"identification": DIAGNOSE, "diagnosis": MORE_RECORDS, "evaluation": OTHER_SPECIMEN}
_NO_MEMORY = (
    "This model has one state, which remembers no turning points: its loop is phase lag, which grows "
    "with frequency, where a piezo's loop hardly does. One step ahead, where the model is given the "
    "measured y(k-1), its error is much smaller: that value is nearly the answer."
)


def answers(report: Mapping) -> list[Answer]:
    """Return the answers with which a page begins."""
    promised = [promised_and_found(report)] if report.get("promised") else []
    return [
        Answer("What was found", [*verdict(report), *found(report)]),
        *promised,
        Answer("How good the pair is", [_judged_on(report)], quality_table(report), _quality(report)),
        Answer("Use as feedforward", feedforward(report)),
        Answer("What is not explained", unexplained(report)),
        Answer("What to measure next", next_measurements(report)),
    ]


@dataclass(frozen=True)
class _Judged:
    """How a model does on one record, as `verdict` takes it."""

    name: str
    role: str
    e_mr: float
    e_rms: float


def verdict(report: Mapping) -> list[str]:
    """Return sentences on a model of no use, and on records that the voltage hardly explains."""
    after = report["error"]["after"]
    results = [
        _Judged(n, e["role"], e["e_mr_percent"] / 100, e["e_rms_um"] / UM) for n, e in after.items()
    ]
    lines = [
        Errors(line["e_mr_percent"] / 100, line["e_rms_um"] / UM)
        for line in (report["straight_line"][n] for n in after)
    ]
    return [
        *model_verdict(results, lines, advice(report)),
        *_worse_on_tests(report),
        *_low_shares(report),
    ]


def _worse_on_tests(report: Mapping) -> list[str]:
    """Return a sentence if the pair does worse on the test records than the one before."""
    before, after = report["error"]["before"], report["error"]["after"]
    tests = [n for n in judged_records(report) if after[n]["role"] == "test"]
    if report["kind"] != "diagnosis" or not tests:
        return []
    sizes = {
        part: [pooled(report, errors, key) for errors in (before, after)]
        for part, key in (("the plant", "e_rms_um"), ("the inverse", "inverse_e_rms_um"))
    }
    worse = [
        f"{part} is off by {micrometres(now)} rms instead of {micrometres(then)}"
        for part, (then, now) in sizes.items()
        if now > TELLING.worse * then
    ]
    if not worse:
        return []
    added = " and ".join(report["effects"]) or "the new fit"
    return [
        f"On {counted(len(tests), 'test record')}, which decided nothing, {added} makes it worse: "
        f"{' and '.join(worse)}. Do not rely on it there; the training records show too little. "
        "`it2hys identify` with the same records gives the model of before."
    ]


def advice(report: Mapping) -> str:
    """Return what to do where the model is of no use."""
    return _ADVICE[report["kind"]]


def _low_shares(report: Mapping) -> list[str]:
    """Return a sentence for each record of which the voltage explains little."""
    shares = {
        name: (entry["voltage_explains_percent"], entry["explained_percent"])
        for name, entry in report["error"]["after"].items()
    }
    known = {n: [s / 100 for s in pair] for n, pair in shares.items() if None not in pair}
    return [text for name, pair in known.items() for text in low_share(name, *pair)]


def found(report: Mapping) -> list[str]:
    """Return which model was found, and which effects it has."""
    roles = [entry["role"] for entry in report["error"]["after"].values()]
    records = counted(roles.count("train"), "training record")
    if report["kind"] == "evaluation":
        return [
            f"Nothing was fitted: {report['names']['after']} is judged on "
            f"{counted(len(roles), 'record')}."
        ]
    if report["kind"] == "identification":
        return [
            f"The interval type-2 fuzzy model with {counted(report['rules'], 'rule')} was identified "
            f"on {records}."
        ]
    start = f"the {report['names']['before']}"
    if report["declared"]:
        start += f" with {', '.join(report['declared'])} declared"
    if not report["effects"]:
        rivals = [" and ".join(r["own"]) for r in report["rivals"] if r["own"]]
        if rivals:
            return [
                f"{start.capitalize()} lacks one of these, but it is open which: {', '.join(rivals)}."
            ]
        return [f"No effect was found that {start} lacks."]
    *others, last = (f"{effect} ({report['meanings'][effect]})" for effect in report["effects"])
    named = f"{', '.join(others)} and {last}" if others else last
    return [f"Found and added to {start}: {named}."]


def _judged_on(report: Mapping) -> str:
    """Return on which records the errors at the top are taken."""
    names = judged_records(report)
    role = ROLES[report["error"]["after"][names[0]]["role"]]
    listed = ", ".join(names)
    count = f"the {role} record {listed}" if len(names) == 1 else f"the {role} records {listed}"
    which = {
        "test": "which decided nothing",
        "validation": "which decided what was added, and were not fitted",
        "training": "which were fitted: a test record (--test) would show the errors on data that was "
        "not",
    }[role]
    which = which.replace("were", "was") if len(names) == 1 else which
    return f"Errors on {count}, {which}. The plant is driven by the voltage alone (free run)."


def quality_table(report: Mapping) -> Table:
    """Return plant and inverse before and after, on the records that count, beside the noise."""
    before, after = report["error"]["before"], report["error"]["after"]
    names = judged_records(report)
    travel = max(after[n]["range_um"] for n in names)
    noise = pooled(report, after, "noise_rms_um")
    noise_volts = pooled(report, after, "inverse_noise_rms_V")

    def size(errors: Mapping) -> str:
        rms = pooled(report, errors, "e_rms_um")
        return f"{micrometres(rms)} ({_share(rms / travel)})"

    def worst(errors: Mapping) -> str:
        return _share(max(errors[n]["e_mr_percent"] for n in names) / 100)

    def volts(errors: Mapping) -> str:
        error, um = (pooled(report, errors, f"inverse_e_rms_{u}") for u in ("V", "um"))
        return f"{figure(error)} V ({micrometres(um)})" if np.isfinite(error) else NONE

    rows = [
        ["plant, rms error (of range)", size(before), size(after), f"{micrometres(noise)}"],
        ["plant, largest error e_mr", worst(before), worst(after), NONE],
        ["inverse, rms error", volts(before), volts(after),
         f"{figure(noise_volts)} V" if np.isfinite(noise_volts) else NONE],
    ]  # fmt: skip
    head = ["", f"before: {report['names']['before']}", f"now: {report['names']['after']}", "noise"]
    return Table(head, rows)


def _quality(report: Mapping) -> list[str]:
    """Return in words how far the error is above the noise, and where the largest one is."""
    after, names = report["error"]["after"], judged_records(report)
    noise = pooled(report, after, "noise_rms_um")
    error = pooled(report, after, "e_rms_um")
    worst = max(names, key=lambda n: after[n]["e_mr_percent"])
    texts = [
        f"The plant's error is {times_the_noise(error / noise)} ({noise_size(noise / UM)}). The "
        f"largest one is in record {worst} at {after[worst]['e_mr_at_s']:.6g} s."
    ]
    if report["kind"] == "identification":
        train = [e["e_rms_um"] for e in after.values() if e["role"] == "train"]
        texts += _of_training(float(np.sqrt(np.mean(np.square(train)))) / report["noise_rms_um"])
    return texts


def _of_training(ratio: float) -> list[str]:
    """Return whether the training records show that the paper's model is enough."""
    if ratio > TELLING.far_above:
        return [
            f"On the training records the error is {times_the_noise(ratio)}, far above it: the records "
            f"contain something that this model does not describe. {_NO_MEMORY}"
        ]
    return [
        f"On the training records the error is {times_the_noise(ratio)}: the model explains them "
        "nearly to their noise."
    ]


def feedforward(report: Mapping) -> list[str]:
    """Return whether the inverse can be used as feedforward, how well, over which range and band."""
    before, after = report["error"]["before"], report["error"]["after"]
    names = judged_records(report)
    error = pooled(report, after, "inverse_e_rms_um")
    line = pooled(report, report["straight_line"], "e_rms_um")
    first = pooled(report, before, "inverse_e_rms_um")
    if not np.isfinite(error):
        return ["Not known: the inverse could not be judged on these records."]
    if len(_low_shares(report)) == len(after):
        return [
            "No: most of what was measured is not the voltage's doing. The inverse can ask for the "
            "other part alone, and the stage goes where the rest takes it."
        ]
    (low, high), (bottom, top) = report["range"]["displacement_um"], report["range"]["voltage_V"]
    band = min(after[n]["inverse_band_Hz"] for n in names)
    travel = max(after[n]["range_um"] for n in names)
    size = f"{micrometres(error)} rms, {_share(error / travel)} of the range"
    if error >= line:
        return [
            f"No: fed with the measured displacement, the inverse is off by {size}; a straight line "
            f"would be by {micrometres(line)}. {advice(report)}"
        ]
    cautions = [*_halved(error, line), *_enlarged(report, error / travel), *_of_one_loop(report)]
    if report["kind"] == "diagnosis" and error > TELLING.worse * first:
        cautions.insert(
            0,
            f"The inverse of the {report['names']['before']} is the better one by this measure, with "
            f"{micrometres(first)}.",
        )
    driven = _driven_up_to(report)
    reach = (
        f"{plain(driven)} Hz, as fast as the records are driven"
        if driven < band
        else f"{plain(band)} Hz"
    )
    texts = [
        f"{'With care' if cautions else 'Yes'}, for references from {_ends(low, high)} µm "
        f"({bottom:.4g} to {top:.4g} V) and up to {reach}: expect a tracking error of {size}. "
        f"A straight line as feedforward would have {micrometres(line)}.",
        *cautions,
    ]
    latency = max(after[n]["inverse_delay_s"] for n in names)
    if 2.0 * np.pi * band * latency > TELLING.late:
        texts.append(
            f"The stage follows {1e3 * latency:.3g} ms after the voltage; no inverse makes up for that "
            "dead time, and the figures leave it out."
        )
    clamped = max(after[n]["inverse_clamped_percent"] or 0.0 for n in names)
    if clamped > 0.0:
        texts.append(
            f"At up to {clamped:.3g} % of a record's samples the inverse was clamped, or not yet back "
            f"where the reference is: its voltage keeps to {bottom:.4g} to {top:.4g} V, the range of "
            "the training records, and to the limits of the effects in the model. The tracking error "
            "above includes these samples."
        )
    texts.append(
        "This was measured without the rig: the inverse is fed with the displacement that was "
        "measured, and its voltage compared with the one that was applied."
    )
    return texts


def _of_one_loop(report: Mapping) -> list[str]:
    """Return a caution where the inverse was fitted and judged on one loop alone."""
    judged = {report["error"]["after"][name]["role"] for name in judged_records(report)}
    if judged != {"train"} or not any(text.startswith(ONE_TONE) for text in report["warnings"]):
        return []
    return ["The records hold one loop: how well the inverse follows smaller ones is not known."]


def _driven_up_to(report: Mapping) -> float:
    """Return up to which frequency in Hz the records are driven, infinite where one steps."""
    driven = [entry.get("driven_up_to_Hz") for entry in report["records"].values()]
    return np.inf if None in driven else max(driven)


def _halved(error: float, line: float) -> list[str]:
    """Return a caution where the inverse does little better than a straight line."""
    if error <= REFERENCE.worth * line:
        return []
    return ["That is more than half of a straight line's error: the inverse is worth little here."]


def _enlarged(report: Mapping, share: float) -> list[str]:
    """Return a caution where the inverse enlarges noise so much that its error cannot be judged."""
    after = report["error"]["after"]
    noise, um, volts, all_volts = (
        pooled(report, after, name)
        for name in ("noise_rms_um", "inverse_e_rms_um", "inverse_noise_rms_V", "inverse_e_rms_V")
    )
    if not share > REFERENCE.seen:
        return []
    passed_on = volts * um / all_volts
    if not passed_on > REFERENCE.enlarged * noise:
        return []
    return [
        f"The noise of the measured displacement alone makes {figure(volts)} V of these "
        f"{figure(all_volts)} V: the inverse enlarges it {passed_on / noise:.1f} times, as it does "
        "whatever is fast in a reference. How well it tracks one without noise, these records do not "
        "show."
    ]


def unexplained(report: Mapping) -> list[str]:
    """Return what is left that the model does not account for."""
    if report["kind"] != "diagnosis":
        if report["unexplained"]:
            return ["The residual is more than noise: `it2hys diagnose` finds out what it contains."]
        return ["Nothing: the residual is about as large as the noise."]
    texts = [
        f"{', '.join(group)}: these records cannot tell them apart, so none of them is named or added."
        for group in report["indistinguishable"]
    ]
    texts += _meanwhile(report["rivals"])
    if report["unexplained"]:
        head = "A significant residual remains that no effect of the catalogue explains."
    elif any(r["unexplained"] for r in report["rivals"]):
        head = "Without them a significant residual remains, which one of them explains."
    else:
        head = "Beside the noise, little or nothing is left of what was fitted or decided."
    # the first sentence is the verdict, the details describe it
    texts.append(" ".join([head, *report["left_over"][:1]]))
    if _tests_show_more(report):
        texts.append("On the test records the residual is more than noise; the details describe it.")
    return [*texts, *_curve(report)]


def _meanwhile(rivals: Sequence[Mapping]) -> list[str]:
    """Return what to do until a record decides between models that these cannot tell apart."""
    if not rivals:
        return []
    errors = [
        f"{' and '.join(r['own']) or 'none of them'} {micrometres(r['e_rms_um'])}"
        f" ({micrometres(r['inverse_e_rms_um'])} for the inverse)"
        for r in rivals
    ]
    files = " or ".join(f"`it2hys package {r['file']} -o DIR`" for r in rivals if r["own"])
    return [
        f"The error on what decided is, with {', with '.join(errors)}. Until a record decides, "
        f"{files} writes FMUs that are as good on signals like those of these records."
    ]


def _tests_show_more(report: Mapping) -> bool:
    """Return whether more than noise is left of the test records."""
    return any(text.startswith(ON_TEST_RECORDS) for text in report["left_over"])


def _curve(report: Mapping) -> list[str]:
    """Return what is said of a static curve that is the sensor's."""
    curve = report.get("sensor_curve")
    if curve is None:
        return []
    if not curve["found"]:
        return ["--sensor-curve was given, but these records show no static curve."]
    return [
        f"The static curve is the sensor's, as --sensor-curve says: it reads up to "
        f"{curve['bow_um']:.3g} µm off a straight line between the ends of its range. "
        "The curve is in sensor_curve.csv. The errors in this report are those of readings. The FMUs "
        "leave it out: their displacement and reference are the stage's own, so invert the curve on a "
        "reading before you compare."
    ]


def next_measurements(report: Mapping) -> list[str]:
    """Return which records would tell more."""
    roles = {entry["role"] for entry in report["error"]["after"].values()}
    texts = _designed(report)
    if report["unexplained"]:
        texts.append(
            "Records of other kinds would narrow down the residual: slow and fast, with holds, with "
            "minor loops. `it2hys design report.json --between EFFECT,EFFECT -o DIR` designs one that "
            "decides between effects that you suspect."
            if report["kind"] == "diagnosis"
            else "Nothing yet: run `it2hys diagnose` with the same records first."
        )
    elif _tests_show_more(report):
        texts.append(
            "More records like the test records, for training or validation (--validate): they contain "
            "something that the present ones do not."
        )
    if "test" not in roles:
        texts.append(
            "A test record (--test), which is neither fitted nor decides, would show how good the pair "
            "is on a signal that it has not seen."
        )
    if report["warnings"]:
        texts.append("The notes in the details name what else the records lack.")
    return texts or ["Nothing is needed for the range and band above."]


def _designed(report: Mapping) -> list[str]:
    """Return what to play where effects or their parameters are open; or else what would show them."""
    found = report.get("next") or {"promise": [], "command": None, "power": None}
    if found["power"] is None:
        later = (
            f"`{found['command']}` in this folder designs the record to measure next. With records as "
            "long as these, that takes many minutes."
        )
        return [*report["experiments"], *found["promise"], *([later] if found["command"] else [])]
    return [
        *found["promise"],
        f"This is a quick design within the limits of these records. `{found['command']}` in this "
        "folder takes a minute, keeps to the limits of your rig (--slew, --bandwidth, --current ...) "
        "and writes the voltage to play.",
    ]


def promised_and_found(report: Mapping) -> Answer:
    """Return the design's promise beside what came out, for the page."""
    entry = report["promised"]
    texts = []
    if len(entry["names"]) > 1:
        came = (
            f"{entry['named'][0]} was named"
            if entry["told"]
            else "none of them was named alone"
            if not entry["named"]
            else f"{' and '.join(entry['named'])} were named together"
        )
        texts.append(
            f"Promised: this record tells {told_apart(entry['names'])} with probability "
            f"{probability(entry['power'])} at a noise of {entry['noise_um']:.2g} µm. Result: "
            f"{came}, at a noise of {report['noise_rms_um']:.2g} µm."
        )
    else:
        texts.append(
            f"Promised at a noise of {entry['noise_um']:.2g} µm, found at one of "
            f"{report['noise_rms_um']:.2g} µm:"
        )
    off, span = entry["played_off_V"], np.ptp(report["range"]["voltage_V"])
    if off is not None and off > TELLING.other_voltage * span:
        texts.append(
            f"The recorded voltage is not the designed one: they differ by {figure(off)} V rms, so the "
            "promise does not hold."
        )
    rows = [
        [
            p["name"],
            f"{p['value']:.4g}",
            p["unit"],
            *(NONE if p[key] is None else f"± {p[key]:.2g}" for key in ("promised", "found")),
        ]
        for p in entry["parameters"]
    ]
    table = Table(["parameter", "value", "unit", "promised", "found"], rows) if rows else None
    return Answer("What the design promised", texts, table)


def notes(report: Mapping) -> list[str]:
    """Return warnings, and what was done to records."""
    inverted = any(entry["displacement_inverted"] for entry in report["records"].values())
    return [*report["warnings"], *([INVERTED] if inverted else [])]


def figure(value: float) -> str:
    """Return a figure with three significant digits, never as a power of ten where that can be read."""
    if value == 0.0 or not np.isfinite(value):
        return "0" if value == 0.0 else NONE
    digits = 2 - int(np.floor(np.log10(abs(value))))
    if digits > 6:
        return f"{value:.2g}"
    return f"{value:.{max(digits, 0)}f}"


def _ends(low: float, high: float) -> str:
    """Return both ends of a range to three digits of its width."""
    decimals = max(2 - int(np.floor(np.log10(high - low))), 0)
    ends = (round(end, decimals) + 0.0 for end in (low, high))  # no minus before a zero
    return " to ".join(f"{end:.{decimals}f}" for end in ends)


def micrometres(value: float) -> str:
    """Return a length, µm."""
    return f"{figure(value)} µm"


def _share(share: float) -> str:
    return f"{100 * share:.{2 if share < 0.01 else 1}f} %"


def small(value: float | None, pattern: str = "") -> str:
    """Return a number of `report.json` for a table; a dash where there is none."""
    if value is None:
        return NONE
    return format(value, pattern) if pattern else small_figure(value)


def interval(low: float | None, high: float | None, scale: float = 1.0) -> str:
    """Return a 95 % interval for a table."""
    if low is None or high is None:
        return "not determined"
    digits = decimals_of(scale * (high - low))
    return f"{scale * low:.{digits}f} to {scale * high:.{digits}f}"


def decimals_of(width: float) -> int:
    """Return the decimals that show two digits of an interval's width."""
    return int(np.clip(1 - np.floor(np.log10(width)), 0, 12)) if width > 0.0 else 6
