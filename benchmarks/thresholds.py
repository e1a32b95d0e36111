"""What becomes of a diagnosis's decisions at half and at double of its thresholds.

Run as ``python benchmarks/thresholds.py [--seeds FIRST] [--draws N] [--page]``. Short records of
simulated stages are diagnosed, on seeds that nothing was chosen on. At every decision of the search,
and of whether a residual is noise, the same question is put again with one threshold of
``it2hys.policy`` halved and then doubled; nothing is fitted anew. The counts go to
``benchmarks/thresholds.json``, and with all thresholds to ``docs/policy.md``; ``--page`` writes that
page again from the last counts.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
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

from diagnosis.cases import CHOSEN_ON, RANGE, Case, short
from tqdm import tqdm

from it2hys.diagnosis.selection import Search
from it2hys.policy import NOISE, SEARCH, thresholds

ROOT = Path(__file__).resolve().parents[1]
COUNTS, PAGE = ROOT / "benchmarks" / "thresholds.json", ROOT / "docs" / "policy.md"
FACTORS = {"half": 0.5, "double": 2.0}
#: Thresholds of the search, and of whether a residual is noise, that decisions are put again with.
ASKED = (
    "least_gain", "clear_gain", "least_share", "least_excess", "spoils", "noisy", "equal",
    "inverse_gain", "commensurate", "likely",
)  # fmt: skip
ASKED_OF_NOISE = ("little", "little_alone", "level")
PROCESSES = 2


def main() -> int:
    """Count and write the page, or the page alone; return the exit code."""
    options = _parser().parse_args()
    if not options.page:
        cases = list(drawn(options.seeds, options.draws))
        with ProcessPoolExecutor(PROCESSES) as pool:
            counts = sum(tqdm(pool.map(counted, cases), total=len(cases)), Counter())
        about = {"seeds": options.seeds, "cases": len(cases)}
        text = json.dumps({**about, "counts": counts}, indent=1, sort_keys=True) + "\n"
        COUNTS.write_text(text, encoding="utf-8")
    counted_last = json.loads(COUNTS.read_text(encoding="utf-8"))
    PAGE.write_text(page(counted_last), encoding="utf-8")
    print(f"{PAGE.relative_to(ROOT)}: {len(thresholds())} thresholds")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=60_000, metavar="FIRST")
    parser.add_argument("--draws", type=int, default=2, metavar="N", help="stages of each kind")
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

    def accepts_again(self, node, child, addition, gains, fitted):
        decided = accepts(self, node, child, addition, gains, fitted)
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


@contextmanager
def scaled(section: object, name: str, factor: float) -> Iterator[None]:
    """Multiply one threshold for a while."""
    value = getattr(section, name)
    object.__setattr__(section, name, factor * value)
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
        "threshold changed; nothing was fitted anew. “–”: not counted, because the threshold acts "
        "on what is fitted or on what is said, not on one decision.",
        "",
        "| threshold | value | unit | meaning | source | at half | at double |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, value, *texts in thresholds():
        changes = [_change(counts, name, label) for label in FACTORS]
        lines.append("| " + " | ".join([f"`{name}`", f"{value:g}", *texts, *changes]) + " |")
    return "\n".join(lines) + "\n"


def _change(counts: Counter, name: str, label: str) -> str:
    section, short_name = name.split(".")
    if short_name not in {"search": ASKED, "noise": ASKED_OF_NOISE}.get(section, ()):
        return "–"
    found = [
        f"{counts[f'{name} {label} {what}']} {what}"
        for what in ("right lost", "right accepted", "wrong lost", "wrong accepted", "lost", "raised")
        if counts[f"{name} {label} {what}"]
    ]
    return ", ".join(found) or "no change"


if __name__ == "__main__":
    sys.exit(main())
