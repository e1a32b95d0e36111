"""What designed records decide: the loop closed on seeded stages of the independent simulator.

Run as ``python benchmarks/designs.py [--seeds FIRST] [--count N] [--pairs PATTERN] [--length N]
[--noise TIMES]``, as ``make design`` does. For every pair of ``tests/diagnosis/designed.py`` and every
seed a stage has one of the two effects; on its first record they look alike, or neither shows. The next
record is designed between the two and played on the stage, beside the paper's signal and a chirp of the
same length. Right is what names the effect that is there, and nothing else. Beside the share that was
right stands the probability that was promised.

Each loop is a line of ``build/designs/loops.jsonl`` once it is done; what is there is not done again.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import as_completed
from fnmatch import fnmatch
from pathlib import Path

# one thread a process: two processes share two processors; read when NumPy is loaded
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# in place of this folder, where files have names of the package of cases
if Path(sys.path[0]).resolve() == Path(__file__).resolve().parent:
    sys.path.pop(0)
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np
from diagnosis.designed import PAIRS, Loop, run_loop
from scipy.stats import binomtest
from tqdm import tqdm

from it2hys.support.processes import make_pool

DONE = Path(__file__).resolve().parents[1] / "build" / "designs" / "loops.jsonl"
#: The share of designed records on which the effect has to be named alone.
WANTED = 0.9


def main() -> int:
    """Run what is not done, print the table; return 1 where less than wanted is right."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=90_000, help="the first (default: 90000)")
    parser.add_argument("--count", type=int, default=10, help="of each pair (default: 10)")
    parser.add_argument("--pairs", default="*", help="such as 'delay/*' (default: all)")
    parser.add_argument("--length", type=int, default=1200, help="samples of a record (default: 1200)")
    parser.add_argument(
        "--noise", type=float, default=1.0, help="of the records, by that of the suite's (default: 1)"
    )
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--table", action="store_true", help="print what is done, and do no more")
    options = parser.parse_args()
    pairs = [pair for pair in PAIRS if fnmatch("/".join(pair), options.pairs)]
    # one seed of all pairs, then the next: what is cut short has seen all pairs
    wanted = [(p, options.seeds + i) for i in range(options.count) for p in pairs]
    kind = (options.length, options.noise)
    done = {(loop.pair, loop.seed): loop for loop in read() if (loop.length, loop.noise) == kind}
    if not options.table:
        missing = [(*case, *kind) for case in wanted if case not in done]
        for loop in run(missing, options.workers):
            done[loop.pair, loop.seed] = loop
    loops = [done[case] for case in wanted if case in done]
    print(table(pairs, loops))
    right = [loop.is_right(loop.designed) for loop in loops]
    return 0 if right and np.mean(right) >= WANTED else 1


def read() -> Iterator[Loop]:
    """Yield what is done."""
    if DONE.is_file():
        yield from (Loop.read(line) for line in DONE.read_text(encoding="utf-8").splitlines())


def run(cases: Sequence[tuple], workers: int) -> Iterator[Loop]:
    """Yield loops of pair, seed, length and noise as they are closed, each written before."""
    DONE.parent.mkdir(parents=True, exist_ok=True)
    with make_pool(workers) as pool:
        waiting = [pool.submit(run_loop, *case) for case in cases]
        for future in tqdm(as_completed(waiting), total=len(waiting), desc="loops"):
            loop = future.result()
            with DONE.open("a", encoding="utf-8") as file:
                file.write(loop.line)
            yield loop


def table(pairs: Sequence[tuple[str, ...]], loops: Sequence[Loop]) -> str:
    """Return how often what is there was named alone, by pair, and how often that was promised."""
    kinds = ("designed", "paper", "chirp")
    head = f"{'right (promised)':20} seeds  first open"
    lines = [head + "".join(f"{kind:>13}" for kind in kinds) + "  failed  CPU s: design  loop"]
    for pair in [*pairs, None]:
        own = [loop for loop in loops if pair in (None, loop.pair)]
        if not own:
            continue
        shares = [(share_right(own, kind), promised(own, kind)) for kind in kinds]
        lines.append(
            f"{'/'.join(pair) if pair else 'all':20} {len(own):5}  "
            f"{sum(loop.was_open for loop in own):10}"
            + "".join(f"  {right:4.2f} ({told:4.2f})" for right, told in shares)
            + f"  {sum(bool(loop.failure) for loop in own):6}  "
            f"{np.mean([loop.design_seconds for loop in own]):13.0f}  "
            f"{np.mean([loop.seconds for loop in own]):4.0f}"
        )
    lines += [sentence(loops, kind) for kind in kinds if loops]
    wrong = [loop for loop in loops if not loop.is_right(loop.designed)]
    lines += [
        f"  {'/'.join(loop.pair)} seed {loop.seed}: {loop.truth} was there, "
        f"{loop.failure or ' + '.join(loop.designed) or 'nothing'} was named (promised "
        f"{loop.promised:.2f}, {loop.family})"
        for loop in wrong
    ]
    return "\n".join(lines)


def share_right(loops: Sequence[Loop], kind: str) -> float:
    """Return how often the truth was named alone on the records of a kind."""
    return float(np.mean([loop.is_right(getattr(loop, kind)) for loop in loops]))


def promised(loops: Sequence[Loop], kind: str) -> float:
    """Return how often that was expected."""
    return float(np.nanmean([loop.promise(kind) for loop in loops]))


def sentence(loops: Sequence[Loop], kind: str) -> str:
    """Return whether a promise is within the statistical error of what came out."""
    right, told, count = share_right(loops, kind), promised(loops, kind), len(loops)
    low, high = binomtest(round(right * count), count).proportion_ci(method="wilson")
    verdict = "within" if low <= told <= high else "not within"
    return (
        f"{kind}: {told:.3f} promised, {right:.3f} came out; that is {verdict} the 95 % interval of "
        f"{count} loops, {low:.3f} to {high:.3f}"
    )


if __name__ == "__main__":
    sys.exit(main())
