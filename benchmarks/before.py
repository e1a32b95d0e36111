"""FMUs of the working tree against those of an earlier commit: ticks, and ticks with a derivative.

    python benchmarks/before.py BEFORE [--build build/c]

Both builds are by the same compiler, and both FMUs are in one process, run in turn for a millisecond
each; what is printed is the median of the ratios of neighbours (fmu_src/bench/bench_before.c). A ratio
above 1 is slower than before. `make bench BEFORE=<commit>` runs it.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from statistics import median

from it2hys.fmu.codegen import parameters_hash
from it2hys.model.parameters import table_1
from it2hys.model.ssv import format_set

ROOT = Path(__file__).parents[1]
PORTS = {"Plant": ("voltage", "displacement"), "Inverse": ("reference", "voltage")}
#: Well within both ranges, with all effects on.
INPUT = {"Plant": (30.0, 70.0), "Inverse": (5e-6, 9e-6)}
EFFECTS = {
    "none": {},
    "lag": {"lag.timeConstant": 3e-4},
    "play": {
        "playCount": 2, "play[1].threshold": 2.0, "play[1].weight": 0.1,
        "play[2].threshold": 6.0, "play[2].weight": -0.05,
    },
    "creep": {
        "creepCount": 2, "creep[1].gain": 0.02, "creep[1].timeConstant": 0.1,
        "creep[2].gain": 0.02, "creep[2].timeConstant": 10.0,
    },
    "resonance": {"resonance.frequency": 900.0, "resonance.damping": 0.05},
    "slew": {"slew.rate": 1e6},
    "saturation": {"saturation.minimum": -50.0, "saturation.maximum": 200.0},
    "delay": {"delay.time": 5e-4},
    "load": {"load.compliance": 2e-8},
    "drift": {"drift.temperatureCoefficient": 1e-8, "drift.rate": 1e-12},
    "nonlinearity": {
        "nonlinearity.quadratic": 2e-7, "nonlinearity.cubic": 1e-7, "nonlinearity.maximum": 1.6e-5,
    },
    "hum": {"hum.amplitude": 2e-8, "hum.frequency": 50.0},
}  # fmt: skip
EFFECTS["all"] = {name: value for settings in EFFECTS.values() for name, value in settings.items()}
EFFECTS["play, creep"] = EFFECTS["play"] | EFFECTS["creep"]
START = {"initialDisplacement": 7e-6}
#: Of the program, each with its own addresses of memory, which alone may make a tick twice as long.
RUNS = 5


class Build:
    """A build's FMUs, the hashes in their GUIDs, and the value references of its variables."""

    def __init__(self, folder: Path) -> None:
        generated = folder / "generated"
        self.binaries = folder / "native/binaries/linux64"
        table = (generated / "fmu_table.h").read_text(encoding="utf-8")
        self.references = {
            name: reference
            for reference, name in enumerate(re.findall(r'^    \{ "([^"]+)"', table, re.M))
        }
        self._hashes = (generated / "fmu_table_hash.h").read_text(encoding="utf-8")

    def fmu(self, model: str, values: Mapping[str, float], folder: Path) -> list[str]:
        """Return a model's binary, its GUID and the URI of its resources, with a parameter set."""
        resources = folder / self.binaries.parents[2].parent.name
        resources.mkdir()
        known = {name: value for name, value in values.items() if name in self.references}
        text = format_set(known, "bench")
        (resources / "parameters.ssv").write_text(text, encoding="utf-8", newline="\n")
        table = re.search(rf"FMU_TABLE_HASH_{model.upper()} 0x(\w+)u", self._hashes)[1]
        guid = f"{{{table}{parameters_hash(text):016x}}}"
        return [str(self.binaries / f"IT2{model}.so"), guid, resources.as_uri()]


def build_of(commit: str, work: Path) -> Build:
    """Build the FMUs of a commit, once."""
    name = subprocess.run(
        ["git", "rev-parse", "--short", f"{commit}^{{commit}}"],
        cwd=ROOT, check=True, capture_output=True, text=True,
    ).stdout.strip()  # fmt: skip
    folder = work / name
    if not (folder / "build/native/binaries").is_dir():
        tree = ["git", "archive", "--format=zip", name, "fmu_src", "python", "LICENSE"]
        content = subprocess.run(tree, cwd=ROOT, check=True, capture_output=True).stdout
        # no tar: its filters came within Python 3.11
        with zipfile.ZipFile(BytesIO(content)) as archive:
            archive.extractall(folder)
        cmake = ["cmake", "-S", folder / "fmu_src", "-B", folder / "build", "-G", "Ninja"]
        subprocess.run([*cmake, f"-DPython_EXECUTABLE={sys.executable}"], check=True, stdout=sys.stderr)
        targets = ["--target", "IT2Plant", "IT2Inverse"]
        subprocess.run(["cmake", "--build", folder / "build", *targets], check=True, stdout=sys.stderr)
    return Build(folder / "build")


def compare(
    program: Path, after: Build, before: Build, model: str, effects: str
) -> list[tuple[str, float, float, float]]:
    """Return what is timed with nanoseconds after and before, and their ratio."""
    values = table_1().replace(**START, **EFFECTS[effects])
    ports = [f"{after.references[port]}:{before.references[port]}" for port in PORTS[model]]
    runs = []
    with tempfile.TemporaryDirectory() as folder:
        fmus = [*after.fmu(model, values, Path(folder)), *before.fmu(model, values, Path(folder))]
        command = [program, *fmus, *ports, *map(repr, INPUT[model])]
        for _ in range(RUNS):
            done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
            runs.append([line.split() for line in done.stdout.splitlines()])
    return [
        (rows[0][0], *(median(float(row[column]) for row in rows) for column in (1, 2, 3)))
        for rows in zip(*runs, strict=True)
    ]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("before", help="the earlier commit")
    parser.add_argument("--build", type=Path, default=ROOT / "build/c", help="of the working tree")
    parser.add_argument("--effects", nargs="*", choices=EFFECTS, default=list(EFFECTS))
    options = parser.parse_args()
    after, before = Build(options.build), build_of(options.before, ROOT / "build/before")
    print(f"{'model':8} {'effects':12} {'timed':11} {'ns':>7} {'before':>7} {'ratio':>6}")
    for model in PORTS:
        for effects in options.effects:
            for what, now, then, ratio in compare(
                options.build / "bench/bench_before", after, before, model, effects
            ):
                print(
                    f"{model:8} {effects:12} {what:11} {now:7.1f} {then:7.1f} {ratio:6.3f}", flush=True
                )


if __name__ == "__main__":
    main()
