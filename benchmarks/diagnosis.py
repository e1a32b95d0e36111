"""The gate of the diagnosis: what it names and how good its FMUs are, on seeds nothing was chosen on.

Run as ``python benchmarks/diagnosis.py [--seeds FIRST] [--cases N|PATTERN]``, as ``make diagnosis``
does. Every case of ``tests/diagnosis/cases.py`` is diagnosed, and fitted again with all that is in it
declared and nothing else allowed: a model told the truth, the best that the catalogue can do there.

Each case is written to ``build/diagnosis`` once it is done; what is there for the same sources and
seeds is not done again. The figures are appended to ``benchmarks/diagnosis_history.jsonl``, and the
exit code is 1 where they are below `LIMITS`. Seeds are a range of ``cases.RANGE`` by its first: by
default the next that the history has not, because whoever saw figures may have chosen on them.

``--growth`` prints instead how the time of one diagnosis grows, as ``make bench`` does. Times of the
cases are processor times of two processes beside each other.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, as_completed
from dataclasses import dataclass, replace
from fnmatch import fnmatch
from pathlib import Path

# one thread a process: two processes share two processors; read when NumPy is loaded
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# in place of this folder, where this file has the name of the package of cases
if Path(sys.path[0]).resolve() == Path(__file__).resolve().parent:
    sys.path.pop(0)
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np
from diagnosis.cases import CHOSEN_ON, RANGE, Case, suite
from diagnosis.outcomes import Outcome, run_case
from tqdm import tqdm

from it2hys.diagnosis import diagnose
from it2hys.model.chain import EFFECTS
from it2hys.records import Record
from it2hys.support.processes import make_pool

PROCESSES = 2
ROOT = Path(__file__).resolve().parents[1]
HISTORY = ROOT / "benchmarks" / "diagnosis_history.jsonl"
DONE = ROOT / "build" / "diagnosis"
#: What decides on the outcome of a case: other files may change and its outcome stays.
SOURCES = (
    "python/it2hys/**/*.py", "python/it2hys/**/*.toml", "fmu_src/**/*.[ch]",
    *(f"tests/diagnosis/{name}.py" for name in ("cases", "simulator", "voltages", "outcomes")),
)  # fmt: skip
NOTHING = "nothing"
#: The effects in the cases of the table of growth, and the samples of each of their records, of which
#: as many validate as in the suite. The growth in samples and in records is that of the case with one
#: effect: what is named of two, and how long that is sought, changes with what fewer samples show.
GROWING, RESIZED = ((), ("creep",), ("play", "creep")), ("creep",)
SAMPLES, RECORDS = (1250, 2500, 5000), (4, 6, 8)
#: Samples of a record from which all training records, cut to lengths of their own, have the most.
DRAWN = 6000
#: What a diagnosis of 40,000 samples in eight records may take on two free processors, s.
LONGEST = 45.0
#: Seed of the case that grows.
SEED = 7000


@dataclass(frozen=True)
class Limits:
    """Where the gate closes; shares are of the cases, errors are rms over a case's test records.

    Parameters
    ----------
    exactly_right : float
        Least share in which exactly what is there is named.
    false_names : int
        Most cases in which something is named that is not there.
    error_over_noise, largest_error_over_noise : float
        Most that the packaged FMU's error may be, in units of the true noise: in `share` of the cases
        whose effects the catalogue has, and in any of them.
    inverse_over_truth : float
        Most that the inverse's error on the measured displacement may be, in units of that of a model
        told the truth, in `share` of the same cases.
    share : float
    unexplained : float
        Most that may be called unexplained of the cases whose effects the catalogue has. Of those with
        an effect that it has not, all must be.
    """

    exactly_right: float = 0.98
    false_names: int = 0
    error_over_noise: float = 1.3
    largest_error_over_noise: float = 3.0
    inverse_over_truth: float = 1.2
    share: float = 0.95
    unexplained: float = 0.05


LIMITS = Limits()


def main() -> int:
    """Run the suite, or print how the time grows; return the exit code."""
    options = _parser().parse_args()
    if options.growth:
        measure_growth()
        return 0
    sources, made_of = digest(), commit()  # now: both may change while the cases run
    first = fresh_seeds(HISTORY, sources) if options.seeds is None else options.seeds
    cases = list(chosen(first, options.cases))
    if not cases:
        print(f"--cases {options.cases}: no case has such a name", file=sys.stderr)
        return 2
    print(f"{len(cases)} cases, seeds {first} to {first + RANGE - 1}, sources {sources}", flush=True)
    outcomes = run_all(cases, first, DONE / f"{sources}.jsonl")
    print_tables(outcomes)
    figures = summarise(outcomes)
    failed = shortfalls(figures)
    print_figures(figures)
    about = {"commit": made_of, "sources": sources, "seeds": first, "wanted": options.cases}
    print("\n" + remember(HISTORY, about, {**figures, "passed": not failed}))
    print("\n".join(["\nbelow what must hold:", *failed] if failed else ["\nall holds"]))
    return int(bool(failed))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--seeds", type=_first_of_range, metavar="FIRST",
        help=f"first seed of a range of {RANGE}; by default the next that was not reported on",
    )  # fmt: skip
    parser.add_argument(
        "--cases", default="*", metavar="N|PATTERN",
        help="so many of them, evenly spread, or those of such a name, as in 'play*'",
    )  # fmt: skip
    parser.add_argument("--growth", action="store_true", help="print how the time grows instead")
    return parser


def _first_of_range(text: str) -> int:
    first = int(text)
    if first < 0 or first % RANGE:
        raise argparse.ArgumentTypeError(f"{text}: a range of seeds begins at a multiple of {RANGE}")
    return first


def chosen(first: int, wanted: str) -> Iterator[Case]:
    """Yield so many cases of a range of seeds, evenly spread, or those of such a name."""
    cases = list(suite(first))
    if wanted.isdigit():
        picked = np.unique(np.linspace(0, len(cases) - 1, min(int(wanted), len(cases))).astype(int))
        return (cases[i] for i in picked)
    return (case for case in cases if fnmatch(case.name, wanted))


# --- what was done before ------------------------------------------------------------------------


def digest() -> str:
    """Return what tells these sources from others."""
    names = sorted(path for pattern in SOURCES for path in ROOT.glob(pattern))
    whole = hashlib.sha256()
    for path in names:
        whole.update(str(path.relative_to(ROOT)).encode() + b"\0" + path.read_bytes() + b"\0")
    return whole.hexdigest()[:12]


def commit() -> str:
    """Return the commit's short name, with a plus where the sources differ; "unknown" outside git."""

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(ROOT), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    try:
        differs = git("status", "--porcelain", "--", *(f":(glob){pattern}" for pattern in SOURCES))
        return git("rev-parse", "--short=7", "HEAD") + ("+" if differs else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def history_of(path: Path) -> list[dict]:
    """Return the lines of a history."""
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def fresh_seeds(path: Path, sources: str) -> int:
    """Return the first seed of a range that nothing was chosen on.

    Sources that have been reported on keep their range, so that a rerun finds its cases.
    """
    lines = history_of(path)
    own = [line["seeds"] for line in lines if line["sources"] == sources and is_unseen(lines, line)]
    return max(own) if own else max([*CHOSEN_ON, *(line["seeds"] for line in lines)]) + RANGE


def is_unseen(lines: Sequence[dict], about: dict) -> bool:
    """Tell whether nothing was chosen, or reported of other sources, on the seeds of a run."""
    seen = {line["seeds"] for line in lines if line["sources"] != about["sources"]}
    return about["seeds"] not in {*CHOSEN_ON, *seen}


def remember(path: Path, about: dict, figures: dict) -> str:
    """Append a line to a history unless it is no measure or stands there; return what was done."""
    lines = history_of(path)
    if not is_unseen(lines, about):
        return f"Seeds from {about['seeds']} were seen before: no line is added to {path.name}."
    if any(about.items() <= line.items() for line in lines):
        return f"{path.name} has this line."
    about = {"date": time.strftime("%Y-%m-%d"), **about}
    with path.open("a") as file:
        file.write(json.dumps(_for_json({**about, **figures})) + "\n")
    return f"One line was added to {path.name}."


def finished(path: Path, first: int) -> dict[str, Outcome]:
    """Return the outcomes of a range of seeds by the names of their cases.

    A last line that was cut off when the run before was ended is taken away.
    """
    if not path.exists():
        return {}
    text = path.read_text()
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        path.write_text(whole)
    outcomes = map(Outcome.read, whole.splitlines())
    return {outcome.name: outcome for outcome in outcomes if outcome.seeds == first}


# --- the cases -----------------------------------------------------------------------------------


def run_all(cases: Sequence[Case], first: int, path: Path) -> list[Outcome]:
    """Return the outcomes of the cases, in their order; what was not done before is done now."""
    path.parent.mkdir(parents=True, exist_ok=True)
    done = finished(path, first)
    missing = [case for case in cases if case.name not in done]
    pool = make_pool(PROCESSES)
    try:
        waiting: list[Future] = [pool.submit(run_case, case, first) for case in missing]
        for future in tqdm(as_completed(waiting), total=len(waiting), unit="case", mininterval=1.0):
            outcome = done[future.result().name] = future.result()
            with path.open("a") as file:
                file.write(outcome.line)
            tqdm.write(_in_brief(outcome), file=sys.stderr)
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
    return [done[case.name] for case in cases]


def _in_brief(o: Outcome) -> str:
    verdict = "right" if o.is_right else f"named {_text(o.named)} {o.failure}"
    return f"{o.name}: {verdict}; {o.over_noise:.2f} x noise, {o.cpu:.0f} s"


# --- figures -------------------------------------------------------------------------------------


def summarise(outcomes: Sequence[Outcome]) -> dict:
    """Return the figures of the suite: what a line of the history holds."""
    explained = [o for o in outcomes if o.kind != "outside"]
    outside = [o for o in outcomes if o.kind == "outside"]
    over_noise = [o.over_noise for o in explained]
    inverse = [o.inverse_over_truth for o in explained]
    return {
        "cases": len(outcomes),
        "failed": sum(bool(o.failure) for o in outcomes),
        "exactly_right": sum(o.is_right for o in outcomes) / len(outcomes),
        "false_names": sum(bool(o.false) for o in outcomes),
        "effects": {name: _counts(outcomes, name) for name in EFFECTS},
        "error_over_noise": _spread(over_noise, LIMITS.error_over_noise),
        "from_cold_start": _spread([o.over_noise for o in explained if all(o.cold)]),
        "error_over_truth": _spread([o.over_truth for o in explained]),
        "truth_over_noise": _spread([o.truth_over_noise for o in explained]),
        "inverse_over_truth": _spread(inverse, LIMITS.inverse_over_truth),
        "without_truth": sum(bool(o.failure_of_truth) for o in outcomes),
        "explained": len(explained),
        "explained_called_unexplained": sum(o.unexplained for o in explained),
        "outside": len(outside),
        "outside_called_unexplained": sum(o.unexplained for o in outside),
        "inverses_held_back": sum(o.held_back > 0.0 for o in outcomes),
        "cpu_s": _spread([o.cpu for o in outcomes]),
    }


def _counts(outcomes: Sequence[Outcome], name: str) -> dict[str, int]:
    return {
        "right": sum(name in o.there and name in o.named for o in outcomes),
        "missed": sum(name in o.there and name not in o.named for o in outcomes),
        "false": sum(name in o.false for o in outcomes),
    }


def _spread(values: Sequence[float], limit: float | None = None) -> dict[str, float]:
    """Return number, median, 95 % and maximum of what is known, and the share within a limit."""
    known = np.array([v for v in values if not np.isnan(v)])
    if not known.size:
        return {"of": 0}
    middle, most = np.quantile(known, [0.5, 0.95], method="higher")
    spread = {"of": known.size, "median": middle, "p95": most, "max": known.max()}
    if limit is not None:
        spread["share_within"] = np.mean(known <= limit)
    return {name: float(value) if name != "of" else value for name, value in spread.items()}


def shortfalls(figures: dict) -> list[str]:
    """Return a sentence for each limit that the figures do not keep to."""
    error, inverse = figures["error_over_noise"], figures["inverse_over_truth"]
    right, within = figures["exactly_right"], error.get("share_within", 1.0)
    false, worst = figures["false_names"], error.get("max", 0.0)
    followed = inverse.get("share_within", 1.0)
    called, explained = figures["explained_called_unexplained"], figures["explained"]
    seen, outside = figures["outside_called_unexplained"], figures["outside"]
    limits = LIMITS
    checks = {
        f"{right:.1%} exactly right; at least {limits.exactly_right:.0%} must be": (
            right < limits.exactly_right
        ),
        f"{false} cases with a false name; at most {limits.false_names} may have one": (
            false > limits.false_names
        ),
        f"packaged FMU within {limits.error_over_noise} times the noise in {within:.1%} of the cases; "
        f"in {limits.share:.0%} it must be": within < limits.share,
        f"packaged FMU at {worst:.3g} times the noise in the worst case; it may never be above "
        f"{limits.largest_error_over_noise:g}": worst > limits.largest_error_over_noise,
        f"inverse within {limits.inverse_over_truth} times that of a model told the truth in "
        f"{followed:.1%} of the cases; in {limits.share:.0%} it must be": followed < limits.share,
        f"{called} of {explained} cases that the catalogue explains are called unexplained; at most "
        f"{limits.unexplained:.0%} may be": called > limits.unexplained * explained,
        f"{seen} of {outside} cases with an effect outside the catalogue are called unexplained; all "
        "must be": seen < outside,
        f"{figures['without_truth']} models told the truth ended with a message; none may": (
            figures["without_truth"] > 0
        ),
    }
    return [f"- {sentence}" for sentence, is_short in checks.items() if is_short]


def _for_json(value: object) -> object:
    """Return the value with four digits, and null for numbers that JSON has not."""
    if isinstance(value, dict):
        return {k: _for_json(v) for k, v in value.items()}
    if isinstance(value, float):
        return float(f"{value:.4g}") if np.isfinite(value) else None
    return value


# --- tables --------------------------------------------------------------------------------------


def print_tables(outcomes: Sequence[Outcome]) -> None:
    """Print what was named, the cases that are not right, and where the time goes."""
    print_confusion(outcomes)
    print_wrong(outcomes)
    print_seconds(outcomes)


def print_figures(figures: dict) -> None:
    """Print the figures, one a line."""
    rows = [
        (name.replace("_", " "), _figure(value)) for name, value in figures.items() if name != "effects"
    ]
    rows += [(name, _figure(counts)) for name, counts in figures["effects"].items()]
    table("In figures", ("figure", "value"), rows)


def _figure(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{name.replace('_', ' ')} {number:.3g}" for name, number in value.items())
    return f"{value:.4g}"


def print_confusion(outcomes: Sequence[Outcome]) -> None:
    """Print how often each effect was named, by what was there; a case may count in several places."""
    rows = []
    names = [*EFFECTS, NOTHING]
    for there in [*EFFECTS, "none", "outside"]:
        own = [o for o in outcomes if there in o.there or there == o.kind]
        if not own:
            continue
        counts = [sum(_is_named(o, name) for o in own) for name in names]
        rows.append([there, str(len(own)), *(str(c) if c else "." for c in counts)])
    table("Effects named (columns) against effects there (rows)", ["", "cases", *names], rows)


def _is_named(outcome: Outcome, name: str) -> bool:
    return not outcome.named if name == NOTHING else name in outcome.named


def print_wrong(outcomes: Sequence[Outcome]) -> None:
    """Print the cases that are another set, above a limit, wrongly (un)explained, or held back."""
    rows = [
        [
            o.name, _text(o.there), _text(o.named), _text(o.indistinguishable),
            "yes" if o.unexplained else "no", f"{o.over_noise:.2f}", f"{o.over_truth:.2f}",
            f"{o.inverse_over_truth:.2f}", f"{100 * o.held_back:.0f} %",
            (o.failure or o.failure_of_truth)[:60],
        ]
        for o in outcomes
        if _is_worth_a_look(o)
    ]  # fmt: skip
    if rows:
        header = (
            "case", "there", "named", "not told apart", "unexplained", "/ noise", "/ truth",
            "inverse / truth", "held back", "",
        )  # fmt: skip
        table("Cases that are not right, above a limit, or held back", header, rows)


def _is_worth_a_look(o: Outcome) -> bool:
    is_outside = o.kind == "outside"
    is_above = not is_outside and (
        o.over_noise > LIMITS.error_over_noise or o.inverse_over_truth > LIMITS.inverse_over_truth
    )
    wrong = not o.is_right or o.unexplained != is_outside or bool(o.failure_of_truth)
    return wrong or is_above or o.held_back > 0.0


def print_seconds(outcomes: Sequence[Outcome]) -> None:
    """Print where the time goes."""
    times = [o.seconds for o in outcomes if o.seconds]
    if not times:
        return
    phases = {name: [t[name] for t in times] for name in times[0]}
    whole = [sum(t.values()) for t in times]
    rows = [
        (name, f"{np.median(t):.1f}", f"{np.max(t):.1f}", f"{100 * np.sum(t) / np.sum(whole):.0f}")
        for name, t in (*phases.items(), ("all", whole))
    ]
    table("Where the time goes, s a case", ("phase", "median", "longest", "% of all"), rows)


def table(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table with aligned columns."""
    widths = [max(len(line[i]) for line in [header, *rows]) for i in range(len(header))]
    print(f"\n{title}")
    for line in [header, *rows]:
        print("  " + "  ".join(text.rjust(w) for text, w in zip(line, widths, strict=True)), flush=True)


def _text(effects: Sequence[str]) -> str:
    return ", ".join(effects) or "-"


# --- growth --------------------------------------------------------------------------------------


def measure_growth() -> list[dict]:
    """Print how the time of one diagnosis grows with samples, effects and records."""
    results = []
    for effects in GROWING:
        sizes = [(SAMPLES[-1], RECORDS[-1])]
        if effects == RESIZED:
            sizes = [(n, RECORDS[-1]) for n in SAMPLES] + [(SAMPLES[-1], n) for n in RECORDS[:-1]]
        results += [_measured(Case(SEED, "growing", effects, length=DRAWN), *size) for size in sizes]
    rows = [
        (
            _text(r["there"]), _text(r["named"]), f"{r['records']}", f"{r['samples']}",
            f"{r['seconds']:.0f}", f"{r['search_seconds']:.0f}", f"{r['cpu_seconds']:.0f}",
            f"{1e6 * r['cpu_seconds'] / r['samples']:.0f}",
        )
        for r in results
    ]  # fmt: skip
    header = (
        "there", "named", "records", "samples", "seconds", "of them search", "CPU s", "CPU us a sample",
    )  # fmt: skip
    table(f"How the time of one diagnosis grows, {PROCESSES} processes", header, rows)
    print_growth(results)
    return results


def _measured(case: Case, samples: int, records: int) -> dict:
    """Diagnose so many records of a case, each of so many samples, and return what it took."""
    validation = [_first(record, samples) for record in case.validation]
    train = [_first(record, samples) for record in [*case.train, *case.test]]
    train = train[: records - len(validation)]
    start, busy = time.perf_counter(), _processor_time()
    found = diagnose(train, validation, workers=PROCESSES)
    return {
        "there": list(case.truth),
        "named": list(found.effects),
        "records": records,
        "samples": sum(len(r) for r in [*train, *validation]),
        "seconds": time.perf_counter() - start,
        "cpu_seconds": _processor_time() - busy,
        "search_seconds": found.seconds["search"],
    }


def print_growth(results: Sequence[dict]) -> None:
    """Print the exponents of the growth of the processor time, and what holds for the whole cases."""
    whole = [r for r in results if r["samples"] == SAMPLES[-1] * RECORDS[-1]]
    resized = [r for r in results if r["there"] == list(RESIZED)]
    most = max(resized, key=_samples)
    in_samples = min((r for r in resized if r["records"] == most["records"]), key=_samples)
    in_records = min((r for r in resized if r["records"] < most["records"]), key=_samples)
    for name, few in (("samples of a record", in_samples), ("records", in_records)):
        times, larger = most["cpu_seconds"] / few["cpu_seconds"], _samples(most) / _samples(few)
        power = np.log(times) / np.log(larger)
        print(f"grows with the {name} to the power of {power:.2f}")
    base = whole[0]["cpu_seconds"]
    texts = [f"{_text(r['there'])} {r['cpu_seconds'] / base:.1f}" for r in whole]
    print(f"with the effects, by the time without any: {'; '.join(texts)}")
    longest = max(whole, key=lambda r: r["seconds"])
    verdict = "met" if longest["seconds"] <= LONGEST else "missed"
    print(
        f"longest of {_samples(most)} samples in {most['records']} records: "
        f"{_text(longest['there'])}, {longest['cpu_seconds']:.0f} CPU s, {longest['seconds']:.0f} s   "
        f"<= {LONGEST:g} s {verdict}"
    )


def _samples(result: dict) -> int:
    return result["samples"]


def _processor_time() -> float:
    """Return the processor time of this process and of those that it has ended, s."""
    return sum(os.times()[:4])


def _first(record: Record, samples: int) -> Record:
    arrays = {
        name: value[:samples] for name, value in vars(record).items() if isinstance(value, np.ndarray)
    }
    return replace(record, **arrays)


if __name__ == "__main__":
    sys.exit(main())
