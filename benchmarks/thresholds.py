"""What becomes of a diagnosis at half and at double of its thresholds.

Run as ``python benchmarks/thresholds.py [--seeds FIRST] [--draws N] [--each N] [--page]``. Short
records of simulated stages are diagnosed, on seeds that nothing was chosen on. At every decision of the
search, and of whether a residual is noise, the same question is put again with one threshold of
``it2hys.policy`` halved and then doubled; nothing is fitted anew. A threshold that was chosen by hand
and acts on what is fitted is halved and doubled for whole diagnoses, of a few of the stages whose
diagnosis asks for it. The counts go to ``benchmarks/thresholds.json``, and with all thresholds to
``docs/policy.md``; ``--page`` writes that page again from the last counts. It takes an hour.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from unittest.mock import patch

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# in place of this folder, where a file has the name of the package of cases
if Path(sys.path[0]).resolve() == Path(__file__).resolve().parent:
    sys.path.pop(0)
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np
from diagnosis.cases import CHOSEN_ON, RANGE, Case, short
from diagnosis.outcomes import Outcome, diagnosed
from tqdm import tqdm

from it2hys.diagnosis.selection import Search
from it2hys.policy import DESIGN, NOISE, SEARCH, SECTIONS, thresholds

ROOT = Path(__file__).resolve().parents[1]
COUNTS, PAGE = ROOT / "benchmarks" / "thresholds.json", ROOT / "docs" / "policy.md"
FACTORS = {"half": 0.5, "double": 2.0}
#: Thresholds of the search, and of whether a residual is noise, that decisions are put again with.
ASKED = (
    "least_gain", "clear_gain", "least_share", "least_excess", "spoils", "noisy", "equal",
    "inverse_gain", "commensurate", "likely",
)  # fmt: skip
ASKED_OF_NOISE = ("little", "little_alone", "level")
#: Where a threshold follows from something else, its source begins so.
FOLLOWS = ("statistic", "convention", "makers", "textbook", "rounding", "physics", "from ")
#: Change of an error that is told.
TOLD = 0.05
PROCESSES = 2


def main() -> int:
    """Count and write the page, or the page alone; return the exit code."""
    options = _parser().parse_args()
    if not options.page:
        cases = list(drawn(options.seeds, options.draws))
        with ProcessPoolExecutor(PROCESSES) as pool:
            counts = sum(_shown(pool.map(counted, cases), cases, "decisions"), Counter())
            usual = list(_shown(pool.map(asked, cases), cases, "as they are"))
            jobs = list(chosen(usual, options.each))
            again = _shown(pool.map(changed, jobs), jobs, "half and double")
            whole = summarised([(*job, other) for job, other in zip(jobs, again, strict=True)])
        about = {"seeds": options.seeds, "cases": len(cases), "each": options.each}
        text = json.dumps({**about, "counts": counts, "whole": whole}, indent=1, sort_keys=True)
        COUNTS.write_text(text + "\n", encoding="utf-8")
    counted_last = json.loads(COUNTS.read_text(encoding="utf-8"))
    PAGE.write_text(page(counted_last), encoding="utf-8")
    print(f"{PAGE.relative_to(ROOT)}: {len(thresholds())} thresholds")
    return 0


def _shown(results: Iterator, jobs: Sequence, what: str) -> Iterator:
    return iter(tqdm(results, what, total=len(jobs), mininterval=1.0))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=440_000, metavar="FIRST")
    parser.add_argument("--draws", type=int, default=2, metavar="N", help="stages of each kind")
    parser.add_argument("--each", type=int, default=4, metavar="N", help="diagnoses of a threshold")
    parser.add_argument("--page", action="store_true", help="write the page of the last counts")
    return parser


def drawn(first: int, draws: int) -> Iterator[Case]:
    """Yield short cases of every effect and of none."""
    if first - first % RANGE in CHOSEN_ON:
        raise ValueError(f"seeds {first}: thresholds were chosen on them")
    nothing = Case(9500, "none, short", (), sample_time=1e-4, length=1200)
    for draw in range(draws):
        for case in (*short(), nothing):
            yield replace(case, seed=first + case.seed + 20 * draw)


def counted(case: Case) -> Counter:
    """Diagnose a case and return how often which threshold would have changed which decision."""
    counts, module = Counter(), import_module("it2hys.diagnosis.diagnose")
    accepts, left_over = Search._accepts, module.left_over

    def accepts_again(self, node, child, addition, gains, fitted, likely=False):
        decided = accepts(self, node, child, addition, gains, fitted, likely)
        if likely:  # what is tried further for the time being is no decision
            return decided
        kind = "right" if addition in case.undeclared else "wrong"
        counts[f"{kind} {'accepted' if decided else 'refused'}"] += 1
        for name in ASKED:
            for label, factor in FACTORS.items():
                with scaled(SEARCH, name, factor):
                    other = accepts(self, node, child, addition, gains, fitted)
                if other != decided:
                    counts[f"search.{name} {label} {kind} {'lost' if decided else 'accepted'}"] += 1
        return decided

    def left_over_again(clues, noise):
        left = left_over(clues, noise)
        counts["residual " + ("not noise" if left.significant else "noise")] += 1
        for name in ASKED_OF_NOISE:
            for label, factor in FACTORS.items():
                with scaled(NOISE, name, factor):
                    other = left_over(clues, noise)
                if other.significant != left.significant:
                    counts[f"noise.{name} {label} {'lost' if left.significant else 'raised'}"] += 1
        return left

    with (
        patch.object(Search, "_accepts", accepts_again),
        patch.object(module, "left_over", left_over_again),
    ):
        module.diagnose(case.train, case.validation, case.test, declared=case.declared)
    return counts


# --- whole diagnoses -------------------------------------------------------------------------------


def asked(case: Case) -> tuple[Case, Outcome, set[str]]:
    """Diagnose a case; return it, what came out, and the thresholds that were asked for."""
    names: set[str] = set()

    def recording(section: type) -> object:
        def read(self: object, name: str) -> object:
            names.add(f"{section.__name__.lower()}.{name}")
            return object.__getattribute__(self, name)

        return patch.object(section, "__getattribute__", read, create=True)

    with ExitStack() as all_sections:
        for section in SECTIONS:
            all_sections.enter_context(recording(type(section)))
        return case, diagnosed(case, 0), names


def chosen(
    usual: Sequence[tuple[Case, Outcome, set[str]]], each: int
) -> Iterator[tuple[str, str, Case, Outcome]]:
    """Yield thresholds, half or double, and a few of the cases that ask for them, in turns."""
    for number, name in enumerate(n for n, *_, source in thresholds() if _acts_on_fits(n, source)):
        cases = [(case, outcome) for case, outcome, names in usual if name in names]
        count = min(each, len(cases))
        picked = [cases[(number + i * len(cases) // count) % len(cases)] for i in range(count)]
        for label in FACTORS:
            yield from ((name, label, *pair) for pair in picked)


def changed(job: tuple[str, str, Case, Outcome]) -> Outcome:
    """Diagnose a case with one threshold halved or doubled; return what came out."""
    name, label, case, _ = job
    section, short_name = _found(name)
    with scaled(section, short_name, FACTORS[label]):
        return diagnosed(case, 0)


def summarised(runs: Sequence[tuple[str, str, Case, Outcome, Outcome]]) -> dict[str, dict]:
    """Return what each threshold changed at half and at double."""
    whole: dict[str, dict] = {}
    for name, label, _, usual, other in runs:
        counts = whole.setdefault(name, {}).setdefault(label, Counter())
        counts["runs"] += 1
        counts["failed"] += bool(other.failure)
        counts["lost"] += bool({*usual.named} - {*other.named})
        counts["named"] += bool({*other.named} - {*usual.named})
        counts["unexplained"] += other.unexplained and not usual.unexplained
        if other.failure:
            continue
        ratio = other.over_noise / usual.over_noise
        counts["least"] = min(counts.get("least", np.inf), ratio)
        counts["most"] = max(counts.get("most", 0.0), ratio)
    return whole


def _acts_on_fits(name: str, source: str) -> bool:
    section, short_name = _found(name)
    again = short_name in {SEARCH: ASKED, NOISE: ASKED_OF_NOISE}.get(section, ())
    return not (again or section is DESIGN or source.startswith(FOLLOWS))


def _found(name: str) -> tuple[object, str]:
    wanted, short_name = name.split(".")
    return next(s for s in SECTIONS if type(s).__name__.lower() == wanted), short_name


@contextmanager
def scaled(section: object, name: str, factor: float) -> Iterator[None]:
    """Multiply one threshold for a while; what is counted stays a whole number."""
    value = getattr(section, name)
    other = max(round(factor * value), 1) if isinstance(value, int) else factor * value
    object.__setattr__(section, name, other)
    try:
        yield
    finally:
        object.__setattr__(section, name, value)


# --- the page --------------------------------------------------------------------------------------


def page(counted: dict) -> str:
    """Return all thresholds and what was counted as a page in Markdown."""
    counts = Counter(counted["counts"])
    lines = [
        "# Thresholds of identification and diagnosis",
        "",
        "Written by `python benchmarks/thresholds.py` from `it2hys.policy`; do not edit.",
        "",
        f"What changes at half and at double was counted on {counted['cases']} short diagnoses of "
        f"simulated stages with seeds from {counted['seeds']}, which nothing was chosen on: the "
        "searches accepted, on their way, "
        f"{counts['right accepted']} additions that are in the stage and {counts['wrong accepted']} "
        "that are not (what the last model does without is not named), refused "
        f"{counts['wrong refused']} that are not and {counts['right refused']} that are "
        "(some of them beside another model, where they came too early), and of "
        f"{counts['residual noise'] + counts['residual not noise']} residuals called "
        f"{counts['residual not noise']} more than noise. Every decision was made again with one "
        "threshold changed; nothing was fitted anew. Thresholds that were chosen by hand and act on "
        f"what is fitted were halved and doubled for up to {counted['each']} whole diagnoses each, of "
        "stages whose diagnosis asks for them: in how many something was no longer named, something "
        "else was, or what is left was called unexplained, and the packaged FMU's error on the test "
        f"records over that of before, where it changed by {TOLD:.0%} or more. “not asked for”: no "
        "diagnosis of these stages does. “–”: not counted, because the threshold follows from what "
        "its source says, or decides on words alone.",
        "",
        "| threshold | value | unit | meaning | source | at half | at double |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, value, *texts in thresholds():
        changes = [_change(counted, name, label, texts[-1]) for label in FACTORS]
        lines.append("| " + " | ".join([f"`{name}`", f"{value:g}", *texts, *changes]) + " |")
    return "\n".join(lines) + "\n"


def _change(counted: dict, name: str, label: str, source: str) -> str:
    if _acts_on_fits(name, source):
        return _change_of_whole(counted["whole"].get(name, {}).get(label))
    section, short_name = _found(name)
    if short_name not in {SEARCH: ASKED, NOISE: ASKED_OF_NOISE}.get(section, ()):
        return "–"
    counts = Counter(counted["counts"])
    found = [
        f"{counts[f'{name} {label} {what}']} {what}"
        for what in ("right lost", "right accepted", "wrong lost", "wrong accepted", "lost", "raised")
        if counts[f"{name} {label} {what}"]
    ]
    return ", ".join(found) or "no change"


def _change_of_whole(counts: dict | None) -> str:
    if counts is None:
        return "not asked for"
    found = [
        f"{counts[key]} of {counts['runs']} {what}"
        for key, what in (
            ("failed", "failed"),
            ("lost", "lost a name"),
            ("named", "named something else"),
            ("unexplained", "unexplained"),
        )
        if counts[key]
    ]
    if "most" in counts and max(counts["most"], 1.0 / counts["least"]) > 1.0 + TOLD:
        found.append(f"error {counts['least']:.2f} to {counts['most']:.2f}")
    return ", ".join(found) or "no change"


if __name__ == "__main__":
    sys.exit(main())
