"""The measured record of the Modelica library's examples, and the two sets that explain it.

    PYTHONPATH=tests python tests/modelica/recorded.py

What `it2hys run demo` measures and finds, without its report: a test record as a table of
`Modelica.Blocks.Sources.CombiTimeTable`, and the paper's model and the diagnosed one, from the training
record. The same each time. Run it when the stand, the fit or the diagnosis changes what is found, then
`reference.py MeasuredRecord` and `figures.py MeasuredRecord`; the example's text states the errors.
"""

from functools import cache

import numpy as np
from library import LIBRARY

from it2hys.diagnosis import diagnose
from it2hys.experiments.scenario import read_scenario
from it2hys.experiments.scenario_files import find_scenario
from it2hys.export.modelica import PACKAGE, format_record
from it2hys.identification import Options
from it2hys.model.parameters import ParameterSet
from it2hys.records import Record
from it2hys.support.files import write_atomically

RECORD, TRAINING = "sine_20Hz", "identification"
TABLE = LIBRARY / f"Resources/Data/{RECORD}.txt"
SAMPLES = 1001  # two periods of 20 Hz
NAMES = {"StageIdentified": "identified", "StageDiagnosed": "diagnosed"}


@cache
def records() -> dict[str, Record]:
    """Return the demo's records by name, as its stand measures them."""
    scenario = read_scenario(find_scenario("demo"))
    return {
        entry.name: scenario.stand.record(entry.values(), entry.name, seed=scenario.seed + i)
        for i, entry in enumerate(scenario.records)
    }


def table() -> str:
    """Return the test record as a text file of the standard library's tables."""
    record = records()[RECORD]
    head = (
        f"#1\n# record {RECORD} of `it2hys run demo`, a simulated stage: time in s, voltage in V, "
        f"displacement in m\ndouble record({SAMPLES},3)\n"
    )
    columns = (record.time, record.voltage, record.displacement)
    rows = np.column_stack([column[:SAMPLES] for column in columns])
    return head + "".join(" ".join(f"{v:.9g}" for v in row) + "\n" for row in rows)


def found() -> dict[str, ParameterSet]:
    """Return the paper's model and the diagnosed one, by the name of their records."""
    scenario = read_scenario(find_scenario("demo"))
    diagnosis = diagnose(
        [records()[TRAINING]], rules=scenario.rules, options=Options(seed=scenario.seed), workers=1
    )
    sets = dict(zip(NAMES, (diagnosis.base, diagnosis.parameters), strict=True))
    return {
        name: ParameterSet(dict(values), f"{NAMES[name]} from the demo's record")
        for name, values in sets.items()
    }


if __name__ == "__main__":
    write_atomically(TABLE, table().encode())
    for name, parameters in found().items():
        path = LIBRARY / f"Parameters/{name}.mo"
        write_atomically(path, format_record(parameters, name, PACKAGE).encode())
        print(path.relative_to(LIBRARY.parent))
