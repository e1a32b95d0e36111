"""Stored results of the Modelica library's examples, from their simulations in rumoca.

    PYTHONPATH=tests python tests/modelica/reference.py [EXAMPLE...]

Run it when an example changes, then `compared.py`, and look at the figures, too. The signals are those
of comparisonSignals.txt, at 201 times; where an example has an FMU, rumoca has the same in pure
Modelica, which equals it.
"""

import csv
import sys

import numpy as np
from library import EXAMPLES, comparison_signals, experiment, stored_path
from test_components import simulate

POINTS = 201


def write(name: str) -> None:
    """Simulate an example and store what it is compared by."""
    package, short = name.rsplit(".", 1)
    result = simulate(short, package)
    time, signals = np.asarray(result.time), comparison_signals(name)
    times = np.linspace(0.0, experiment(name)[0], POINTS)
    columns = [np.interp(times, time, np.asarray(result[s])) for s in signals]
    with stored_path(name).open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["time", *signals])
        table.writerows([f"{v:.7g}" for v in row] for row in zip(times, *columns, strict=True))
    print(name)


if __name__ == "__main__":
    for chosen in EXAMPLES:
        if chosen.rsplit(".", 1)[-1] in sys.argv[1:] or not sys.argv[1:]:
            write(chosen)
