"""All benchmarks in one run, and at its end the limits beside what was measured.

    python benchmarks/bench.py --build build/c [--before COMMIT]

`make bench` runs it. A part that holds something against a limit prints a line that ends in "met" or
"missed"; the summary is these lines. A part that fails does not keep the others from running. The exit
code is 1 where a part failed: a limit that is missed is a finding, which a busy machine can make.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
VERDICTS = (" met", " missed")
#: As workers have it: a pool of threads spins, and that counts as processor time.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "POLARS_MAX_THREADS"), "1")


def main() -> int:
    """Run the parts and print the summary."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--build", type=Path, default=ROOT / "build/c", help="of the C sources")
    parser.add_argument("--before", metavar="COMMIT", help="an earlier commit to be compared with")
    options = parser.parse_args()
    python = [sys.executable, "-u"]
    parts = {
        "ticks, fuzzing and soak": ["cmake", "--build", options.build, "--target", "bench"],
        "identification": [*python, "benchmarks/identification.py"],
        "diagnosis": [*python, "benchmarks/diagnosis.py", "--growth"],
        "sweeps": [*python, "benchmarks/sweep.py", options.build.absolute() / "bench/bare_loop"],
        "Modelica": [*python, "tests/modelica/speed.py"],
    }
    if options.before:
        command = [*python, "benchmarks/before.py", options.before, "--build", options.build.absolute()]
        parts = {f"against {options.before}": command, **parts}
    limits, failed = [], []
    for name, command in parts.items():
        print(f"\n=== {name}", flush=True)
        begin = time.monotonic()
        code, judged = run(list(map(str, command)))
        limits += [(name, line) for line in judged]
        print(f"=== {name}: {time.monotonic() - begin:.0f} s", flush=True)
        if code:
            failed.append(f"{name}: ended with {code}")
    print("\n=== Limits, and what was measured against them")
    for name, line in limits:
        print(f"{name:24} {line}")
    print(f"{sum(line.endswith(VERDICTS[0]) for _, line in limits)} of {len(limits)} limits are met.")
    for text in failed:
        print(f"FAILED: {text}")
    return 1 if failed else 0


def run(command: list[str]) -> tuple[int, list[str]]:
    """Run a part and print what it prints; return its exit code and its lines with a verdict."""
    paths = [str(ROOT / "tests"), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, cwd=ROOT, env=environment, errors="replace"
    )
    judged = []
    for line in process.stdout:
        print(line, end="", flush=True)
        if line.rstrip().endswith(VERDICTS):
            judged.append(line.strip())
    return process.wait(), judged


if __name__ == "__main__":
    sys.exit(main())
