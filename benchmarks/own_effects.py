"""Effects of the user's own on records of an independent simulator: what the worked examples do.

Run as ``python benchmarks/own_effects.py [--seeds N] [--kind KIND]``, as ``make own-effects`` does.
With the physics of each example of ``examples/own_effects`` the records are diagnosed without its file
(they have to stay unexplained) and with it (it has to be named); with all files, records without that
physics are diagnosed (none may be named). A diagnosis takes about a minute.

Each is written to ``build/own_effects`` once it is done; what is there for the same sources is not done
again. The exit code is 1 where a case did not come out as it has to.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import sys
from collections.abc import Sequence
from concurrent.futures import as_completed
from pathlib import Path

# one thread a process: two processes share two processors; read when NumPy is loaded
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# in place of this folder, where a file has the name of the package of cases
if Path(sys.path[0]).resolve() == Path(__file__).resolve().parent:
    sys.path.pop(0)
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np
from diagnosis.own_cases import KINDS, PHYSICS, OwnOutcome, run, suite
from tqdm import tqdm

from it2hys.support.processes import make_pool

PROCESSES = 2
ROOT = Path(__file__).resolve().parents[1]
DONE = ROOT / "build" / "own_effects"
#: What decides on the outcome of a case: other files may change and its outcome stays.
SOURCES = (
    *(f"python/it2hys/{room}/**/*.py" for room in ("diagnosis", "identification", "model", "records")),
    "python/it2hys/policy.py", "fmu_src/**/*.[ch]", "examples/own_effects/*.py",
    *(f"tests/diagnosis/{name}.py" for name in ("cases", "simulator", "voltages")),
    "tests/diagnosis/own_*.py",
)  # fmt: skip


def main() -> int:
    """Run what is missing and print the table; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20, help="of each kind of case (20)")
    parser.add_argument("--kind", choices=KINDS, help="only these")
    options = parser.parse_args()
    cases = [c for c in suite(options.seeds) if c.kind == (options.kind or c.kind)]
    path = DONE / f"{_digest()}.jsonl"
    path.parent.mkdir(parents=True, exist_ok=True)
    done = _finished(path)
    pool = make_pool(PROCESSES)
    try:
        waiting = [pool.submit(run, case) for case in cases if case.name not in done]
        for future in tqdm(as_completed(waiting), total=len(waiting), unit="diagnosis"):
            outcome = done[future.result().name] = future.result()
            with path.open("a") as file:
                file.write(outcome.line)
            tqdm.write(_in_brief(outcome), file=sys.stderr)
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
    outcomes = [done[case.name] for case in cases]
    print(table(outcomes))
    wrong = [o for o in outcomes if not o.is_right]
    print("\n".join(["\nnot as it has to be:", *map(_in_brief, wrong)] if wrong else ["\nall holds"]))
    return int(bool(wrong))


def _digest() -> str:
    """Return what tells these sources from others."""
    whole = hashlib.sha256()
    for path in sorted(path for pattern in SOURCES for path in ROOT.glob(pattern)):
        whole.update(str(path.relative_to(ROOT)).encode() + b"\0" + path.read_bytes() + b"\0")
    return whole.hexdigest()[:12]


def _finished(path: Path) -> dict[str, OwnOutcome]:
    """Return what was done before; a last line that was cut off is taken away."""
    if not path.exists():
        return {}
    text = path.read_text()
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        path.write_text(whole)
    return {o.name: o for o in map(OwnOutcome.read, whole.splitlines())}


def _in_brief(o: OwnOutcome) -> str:
    named = ", ".join(o.named) or "nothing"
    more = " and unexplained" if o.unexplained else ""
    return (
        f"{o.name}: {'right' if o.is_right else 'WRONG'}, {o.failure or named + more}; "
        f"{o.before / o.noise:.2f} -> {o.after / o.noise:.2f} x noise, {o.cpu:.0f} s"
    )


def table(outcomes: Sequence[OwnOutcome]) -> str:
    """Return a table, in Markdown, of what the examples do; medians, and the worst in brackets."""
    examples = [e for e in PHYSICS if any(o.example == e for o in outcomes)]
    lines = [
        "| example | without: unexplained | given: named | error over noise | inverse, V | its noise |",
        "|---|---|---|---|---|---|",
    ]
    for example in examples:
        absent, given = (
            [o for o in outcomes if o.example == example and o.kind == kind]
            for kind in ("absent", "given")
        )
        known = [o for o in given if not o.failure]
        lines.append(
            f"| {example} | {_count(absent)} | {_count(given)} "
            f"| {_fall([(o.before / o.noise, o.after / o.noise) for o in known])} "
            f"| {_fall([(o.inverse_before, o.inverse_after) for o in known])} "
            f"| {_median([o.inverse_noise for o in known])} |"
        )
    others = [o for o in outcomes if o.kind == "not there"]
    false = {e: sum(e in (*o.named, *o.indistinguishable) for o in others) for e in PHYSICS}
    named = ", ".join(f"{e} {n}" for e, n in false.items())
    return "\n".join([*lines, "", f"Named in {len(others)} records without it: {named}."])


def _count(outcomes: Sequence[OwnOutcome]) -> str:
    return f"{sum(o.is_right for o in outcomes)} of {len(outcomes)}"


def _median(values: Sequence[float]) -> str:
    return f"{np.median(values):.2g}" if values else "-"


def _fall(pairs: Sequence[tuple[float, float]]) -> str:
    if not pairs:
        return "-"
    before, after = np.array(pairs).T
    return f"{np.median(before):.3g} -> {np.median(after):.3g} ({np.max(after):.3g})"


if __name__ == "__main__":
    sys.exit(main())
