"""Figures of the worked examples of own effects: errors on a test record before and after.

Run as ``python benchmarks/own_effects_figures.py``; it writes ``docs/own_effects.png``, one row for
each example of ``examples/own_effects``, and ``docs/own_effects_neural.png``, where rules and network
are fitted together. Records are of the independent simulator of the tests. So that it takes minutes, no
other effect is tried; ``benchmarks/own_effects.py`` has all of them tried.
"""

from __future__ import annotations

import sys
from pathlib import Path

# in place of this folder, where a file has the name of the package of cases
if Path(sys.path[0]).resolve() == Path(__file__).resolve().parent:
    sys.path.pop(0)
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from diagnosis.own_cases import FILES, LOOKED_AT, PHYSICS, TRAINING, with_physics

from it2hys.diagnosis import Diagnosis, diagnose
from it2hys.fmu.own_library import use_effects
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet
from it2hys.model.stages import EFFECTS
from it2hys.records import Record

DOCS = Path(__file__).resolve().parents[1] / "docs"
SEED = LOOKED_AT + 1000
BEFORE, AFTER, PLAIN = "tab:orange", "tab:blue", "0.4"
WORDS = {
    "second_resonance": "a second resonance",
    "friction": "friction in the guide",
    "thermal_path": "heat of its own",
    "neural": "an unknown (drag)",
}


def errors(parameters: ParameterSet, record: Record, offset: float) -> np.ndarray:
    """Return the error of a free run that is told no more than the first displacement, (N,), m."""
    first = float(record.displacement[0] - offset)
    low, high = parameters.displacement_range
    told = parameters.replace(initialDisplacement=float(np.clip(first, low, high)))
    _, reading = compiled.chain_free_run(told, record.voltage, record.force, record.temperature)
    return record.displacement - offset - reading


def found(example: str) -> tuple[Diagnosis, list[Record]]:
    """Return the diagnosis with the example alone, and the test records."""
    case = with_physics(example, SEED)
    use_effects([FILES / f"{example}.py"])
    others = [e for e in EFFECTS if e != example]
    diagnosis = diagnose(case.train[:TRAINING], case.validation, case.test, excluded=others)
    return diagnosis, case.test


def lines(axes: plt.Axes, diagnosis: Diagnosis, tests: list[Record], number: int) -> None:
    """Draw the errors of a test record before and after."""
    record = tests[number]
    for judged, model, colour, name in (
        (diagnosis.before, diagnosis.base, BEFORE, "before"),
        (diagnosis.after, diagnosis.parameters, AFTER, "after"),
    ):
        judgement = [j for j in judged if j.role == "test"][number]
        error = 1e9 * errors(model, record, judgement.offset)
        label = f"{name}: {1e9 * judgement.e_rms:.3g} nm rms"
        axes.plot(1e3 * record.time, error, colour, lw=0.8, label=label)
    axes.set_ylabel("error in nm")
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 0.98),
        ncols=2,
        fontsize=8,
        frameon=False,
        handlelength=1.2,
    )
    axes.grid(alpha=0.3)


def main() -> None:
    """Diagnose, and draw."""
    figure, rows = plt.subplots(len(PHYSICS), 1, figsize=(8.0, 8.0), layout="constrained")
    for axes, example in zip(rows, PHYSICS, strict=True):
        diagnosis, tests = found(example)
        worst = np.argmax([j.e_rms for j in diagnosis.before if j.role == "test"])
        lines(axes, diagnosis, tests, int(worst))
        axes.set_title(f"{WORDS[example]}: {example}.py", fontsize=10, loc="left")
        if example == "neural":
            draw_network(diagnosis, tests)
        for judged in (diagnosis.before, diagnosis.after):
            rms = [(j.name, j.e_rms, j.inverse.e_rms, j.noise) for j in judged if j.role == "test"]
            print(example, diagnosis.effects, "unexplained" if diagnosis.unexplained else "", rms)
        use_effects([])
    rows[-1].set_xlabel("time in ms")
    figure.savefig(DOCS / "own_effects.png", dpi=80)


def draw_network(diagnosis: Diagnosis, tests: list[Record]) -> None:
    """Draw both test records with what is left of them without and with the network."""
    figure, rows = plt.subplots(2, len(tests), figsize=(9.0, 5.0), layout="constrained", sharex="col")
    for i, record in enumerate(tests):
        rows[0, i].plot(1e3 * record.time, 1e6 * record.displacement, PLAIN, lw=0.9)
        rows[0, i].set_ylabel("measured in µm")
        rows[0, i].grid(alpha=0.3)
        lines(rows[1, i], diagnosis, tests, i)
        rows[1, i].set_xlabel("time in ms")
    figure.savefig(DOCS / "own_effects_neural.png", dpi=80)
    plt.close(figure)


if __name__ == "__main__":
    main()
