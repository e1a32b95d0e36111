"""Draw the FMUs' pictures, `model.png`: a hysteresis loop with the way that it is run through.

    .venv/bin/python tools/icons.py

The loop is that of a stage with play, as the simulated stage has one, not the paper's narrow one: a
picture of 120 points must show that it is a loop.
"""

from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

TEMPLATES = Path(__file__).parents[1] / "python" / "it2hys" / "fmu" / "templates"
THRESHOLDS = np.linspace(0.0, 0.4, 9)


def loop(turns: list[float], points: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Return input and output of a sum of play operators that is driven from turn to turn."""
    legs = [np.linspace(a, b, points) for a, b in pairwise(turns)]
    x = np.concatenate(legs)
    states, y = np.full(len(THRESHOLDS), turns[0]), []
    for value in x:
        states = np.maximum(value - THRESHOLDS, np.minimum(value + THRESHOLDS, states))
        y.append(states.mean())
    return x, np.array(y)


def draw(path: Path, inverse: bool) -> None:
    """Draw one picture; that of the inverse has its axes exchanged, and another colour."""
    colour = "#d95f02" if inverse else "#1f77b4"
    figure = Figure(figsize=(2, 2), dpi=100)
    axes = figure.add_axes((0.08, 0.08, 0.84, 0.84))
    for turns, width in (([0.0, 1.0, 0.0, 1.0], 5.0), ([0.0, 1.0, 0.0, 0.6, 0.15, 0.6], 2.0)):
        x, y = loop(turns)
        cut = 60 if width > 3 else 180
        x, y = (y[cut:], x[cut:]) if inverse else (x[cut:], y[cut:])
        axes.plot(x, y, color=colour, linewidth=width, solid_capstyle="round")
    for start in (90, 150):  # on the way back, and on the way there
        x, y = loop([0.0, 1.0, 0.0, 1.0])
        x, y = (y, x) if inverse else (x, y)
        axes.annotate(
            "", (x[start + 3], y[start + 3]), (x[start], y[start]),
            arrowprops={"arrowstyle": "-|>", "color": colour, "mutation_scale": 30},
        )  # fmt: skip
    axes.set(xticks=[], yticks=[])
    axes.margins(0.1)
    for spine in axes.spines.values():
        spine.set(linewidth=2, color="#444444")
    figure.savefig(path, metadata={"Software": None})


if __name__ == "__main__":
    draw(TEMPLATES / "plant.png", inverse=False)
    draw(TEMPLATES / "inverse.png", inverse=True)
