"""The diagnosis on all seeded cases: what it names, how well it does, and where the time goes.

Run as ``python benchmarks/diagnosis.py [--cases N | --cases PATTERN] [--json FILE]``; ``make bench``
does. Every case of ``tests/diagnosis/cases.py`` is diagnosed, and diagnosed again with all that is in
it declared: a model told the truth, the best that the catalogue can do on the same records. The table
of growth repeats one case's records, longer and shorter, and with more effects.

Times of the cases are those of two processes beside each other.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from fnmatch import fnmatch
from pathlib import Path

# one thread a process: two processes share two processors; read when NumPy is loaded
os.environ.setdefault("OMP_NUM_THREADS", "1")
# in place of this folder, where this file has the name of the package of cases
sys.path.pop(0)
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np
from diagnosis.cases import Case, suite
from tqdm import tqdm

from it2hys import core
from it2hys.chain import EFFECTS, active_effects
from it2hys.diagnosis import Diagnosis, diagnose
from it2hys.diagnosis.result import Judgement
from it2hys.diagnosis_report import at_rest, scaled_reference
from it2hys.errors import InputError
from it2hys.files import write_atomically
from it2hys.records import Record

PROCESSES = 2
NOTHING = "nothing"
#: Shares of the records of some 40,000 samples in all, and the effects in them, of the table of growth.
SHARES = (0.25, 0.5, 1.0)
GROWING = ((), ("creep",), ("play", "creep"))
#: Seed of the case that grows.
SEED = 7000


@dataclass(frozen=True)
class Outcome:
    """What came of one case.

    Parameters
    ----------
    name, kind : str
        Kind is what was undeclared, joined by "+"; "none", or "outside".
    there, named, indistinguishable : tuple of str
        Effects to be named, and those that were, and those that were said not to be told apart.
    unexplained : bool
    noise : float
        True noise, m rms.
    error, best : float
        Error on the test records after the diagnosis and of a model told the truth, m rms; NaN where
        a run failed.
    held_back : float
        Share of the tracking reference at which the inverse found cannot follow it; NaN where a limit
        of the amplifier is in the model.
    seconds : dict of str to float
        Of each phase.
    failure : str
        The message of a run that ended with one.
    """

    name: str
    kind: str
    there: tuple[str, ...]
    named: tuple[str, ...] = ()
    indistinguishable: tuple[str, ...] = ()
    unexplained: bool = False
    noise: float = np.nan
    error: float = np.nan
    best: float = np.nan
    held_back: float = np.nan
    seconds: dict[str, float] | None = None
    failure: str = ""

    @property
    def is_right(self) -> bool:
        """Whether exactly what is there was named."""
        return not self.failure and set(self.named) == set(self.there)


def main() -> None:
    """Print all tables; write them as JSON if asked to."""
    options = _parser().parse_args()
    start = time.perf_counter()
    outcomes = run_all(list(_chosen(options.cases)), options.truth)
    report = summarise(outcomes)
    if options.growth:
        report["growth"] = measure_growth()
    report["total_seconds"] = time.perf_counter() - start
    print(f"\n{report['total_seconds']:.0f} s in total")
    if options.json:
        report["cases"] = [asdict(o) for o in outcomes]
        write_atomically(options.json, (json.dumps(_finite(report), indent=1) + "\n").encode())


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--cases", default="*", metavar="N|PATTERN",
        help="every so many of them, evenly spread, or those of such a name, as in 'play*'",
    )  # fmt: skip
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there, too")
    parser.add_argument(
        "--no-truth", dest="truth", action="store_false", help="leave out the models told the truth"
    )
    parser.add_argument("--no-growth", dest="growth", action="store_false", help="leave out the growth")
    return parser


def _chosen(wanted: str) -> Iterator[Case]:
    cases = list(suite())
    if wanted.isdigit():
        picked = np.unique(np.linspace(0, len(cases) - 1, min(int(wanted), len(cases))).astype(int))
        return (cases[i] for i in picked)
    return (case for case in cases if fnmatch(case.name, wanted))


# --- the cases -----------------------------------------------------------------------------------


def run_all(cases: Sequence[Case], truth: bool) -> list[Outcome]:
    """Diagnose the cases in two processes; they come back in the order of the suite."""
    with ProcessPoolExecutor(PROCESSES) as pool:
        waiting = {pool.submit(run_case, case, truth): i for i, case in enumerate(cases)}
        done: dict[int, Outcome] = {}
        for future in tqdm(as_completed(waiting), total=len(cases), unit="case", mininterval=1.0):
            outcome = done[waiting[future]] = future.result()
            if not outcome.is_right:
                tqdm.write(f"{outcome.name}: {_text(outcome.named)}{outcome.failure}", file=sys.stderr)
    return [done[i] for i in range(len(cases))]


def run_case(case: Case, truth: bool) -> Outcome:
    """Diagnose one case, and again with the truth declared."""
    kind = "outside" if case.outside else "+".join(case.undeclared) or "none"
    outcome = Outcome(case.name, kind, case.undeclared, noise=case.noise_rms)
    try:
        found = _diagnose(case, case.declared)
        best = _error_of_the_truth(case, found) if truth else np.nan
    except InputError as error:
        return replace(outcome, failure=str(error))
    return replace(
        outcome,
        named=found.effects,
        indistinguishable=tuple(e for group in found.indistinguishable for e in group),
        unexplained=found.unexplained,
        error=_test_error(found.after),
        best=best,
        held_back=_held_back(case, found),
        seconds=found.seconds,
    )


def _diagnose(case: Case, declared: Sequence[str]) -> Diagnosis:
    return diagnose(case.train, case.validation, case.test, declared=declared)


def _error_of_the_truth(case: Case, found: Diagnosis) -> float:
    """Return the test error of a model that has what is there; NaN where none is known."""
    if case.outside:
        return np.nan
    if not case.truth:
        return _test_error(found.before)
    told = _diagnose(case, case.truth)
    # a model that was given more than the truth is no measure
    return np.nan if told.effects else _test_error(told.after)


def _held_back(case: Case, found: Diagnosis) -> float:
    if {"slew", "saturation"} & {*active_effects(found.parameters)}:
        return np.nan
    reference = scaled_reference(case.train)
    start = found.parameters.replace(**at_rest(reference[0]))
    return float(np.mean(core.chain_inverse_run(start, reference)[1]))


def _test_error(judgements: Sequence[Judgement]) -> float:
    return float(np.sqrt(np.mean([j.e_rms**2 for j in judgements if j.role == "test"])))


# --- tables --------------------------------------------------------------------------------------


def summarise(outcomes: Sequence[Outcome]) -> dict:
    """Print what was named and how well it does; return the figures."""
    print_confusion(outcomes)
    clean = [o for o in outcomes if o.kind == "none"]
    outside = [o for o in outcomes if o.kind == "outside"]
    ratios = [o.error / o.best for o in outcomes if np.isfinite(o.error / o.best)]
    noisy = [o.error / o.noise for o in outcomes if o.kind != "outside" and np.isfinite(o.error)]
    figures = {
        "cases": len(outcomes),
        "exactly_right": sum(o.is_right for o in outcomes),
        "clean_cases": len(clean),
        "clean_cases_with_a_name": sum(bool(o.named) for o in clean),
        "clean_cases_unexplained": sum(o.unexplained for o in clean),
        "outside_cases": len(outside),
        "outside_cases_with_a_false_name": sum(not {*o.named} <= {*o.there} for o in outside),
        "outside_cases_unexplained": sum(o.unexplained for o in outside),
        "explained_cases_called_unexplained": sum(
            o.unexplained for o in outcomes if o.kind not in ("none", "outside")
        ),
        "inverses_that_do_not_follow": sum(o.held_back > 0.0 for o in outcomes),
        "of_inverses": int(np.count_nonzero(np.isfinite([o.held_back for o in outcomes]))),
        "failed": sum(bool(o.failure) for o in outcomes),
        "cases_with_a_ratio_to_the_truth": len(ratios),
        "of_them_below_0.8": sum(r < 0.8 for r in ratios),
        "median_ratio_to_the_truth": float(np.median(ratios)) if ratios else np.nan,
        "largest_ratio_to_the_truth": float(np.max(ratios)) if ratios else np.nan,
        "median_ratio_to_the_noise": float(np.median(noisy)) if noisy else np.nan,
    }
    right = 100.0 * figures["exactly_right"] / max(len(outcomes), 1)
    table(
        "In figures",
        ("figure", "value"),
        [
            ("cases whose set of effects is exactly right", f"{right:.1f} % of {len(outcomes)}"),
            *((name.replace("_", " "), f"{value:.4g}") for name, value in figures.items()),
        ],
    )
    print_wrong(outcomes)
    figures["seconds"] = print_seconds(outcomes)
    return figures


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
    """Print the cases with another set, those far above the truth, and inverses that do not follow."""
    rows = [
        [
            o.name, _text(o.there), _text(o.named), _text(o.indistinguishable),
            "yes" if o.unexplained else "no", f"{o.error / o.noise:.2f}", f"{o.error / o.best:.2f}",
            f"{100 * o.held_back:.0f} %", o.failure[:60],
        ]
        for o in outcomes
        if not o.is_right or o.error > 1.5 * o.best or o.held_back > 0.0
    ]  # fmt: skip
    if rows:
        header = (
            "case", "there", "named", "not told apart", "unexplained", "/ noise", "/ truth",
            "held back", "",
        )  # fmt: skip
        table("Cases that are not right, 1.5 times above the truth, or held back", header, rows)


def print_seconds(outcomes: Sequence[Outcome]) -> dict[str, float]:
    """Print where the time goes; return the median of each phase."""
    times = [o.seconds for o in outcomes if o.seconds]
    if not times:
        return {}
    phases = {name: [t[name] for t in times] for name in times[0]}
    whole = [sum(t.values()) for t in times]
    rows = [
        (name, f"{np.median(t):.1f}", f"{np.max(t):.1f}", f"{100 * np.sum(t) / np.sum(whole):.0f}")
        for name, t in (*phases.items(), ("all", whole))
    ]
    table("Where the time goes, s a case", ("phase", "median", "longest", "% of all"), rows)
    return {name: float(np.median(t)) for name, t in (*phases.items(), ("all", whole))}


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
    """Print how the time of one diagnosis grows with samples and with effects; one process."""
    results = []
    for effects in GROWING:
        case = Case(SEED, "growing", effects)
        for share in SHARES:
            train = [_cut(record, share) for record in (*case.train, *case.test)]
            validation = [_cut(record, share) for record in case.validation]
            start = time.perf_counter()
            found = diagnose(train, validation)
            results.append(
                {
                    "there": list(effects),
                    "named": list(found.effects),
                    "samples": sum(len(r) for r in [*train, *validation]),
                    "seconds": time.perf_counter() - start,
                    "search_seconds": found.seconds["search"],
                }
            )
    rows = [
        (
            _text(r["there"]), _text(r["named"]), f"{r['samples']}", f"{r['seconds']:.0f}",
            f"{r['search_seconds']:.0f}", f"{1e6 * r['seconds'] / r['samples']:.0f}",
        )
        for r in results
    ]  # fmt: skip
    header = ("there", "named", "samples", "seconds", "of them search", "us a sample")
    table("How the time of one diagnosis grows, one process", header, rows)
    return results


def _cut(record: Record, share: float) -> Record:
    kept = slice(0, int(share * len(record)))
    arrays = {
        name: value[kept] for name, value in vars(record).items() if isinstance(value, np.ndarray)
    }
    return replace(record, **arrays)


def _finite(value: object) -> object:
    """Return the value with null for numbers that JSON has not."""
    if isinstance(value, dict):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v) for v in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


if __name__ == "__main__":
    main()
