"""Masters that we did not write: libcosim and ecos, each run in a process of its own."""

import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import run_python

# Each program reads a job, steps a package, or FMUs that it connects, and writes the outputs after each
# step to a file: what a master itself prints may come last.
LIBCOSIM = """
import json, sys
import fmpy
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

job = json.load(open(sys.argv[1], encoding="utf-8"))
log_output_level(CosimLogLevel.WARNING)
vr = {
    name: {v.name: v.valueReference for v in fmpy.read_model_description(path).modelVariables}
    for name, path in job["fmus"].items()
}
if "ssp" in job:
    execution = CosimExecution.from_ssp_file(job["ssp"], 100_000)
    index = {name: execution.slave_index_from_instance_name(name) for name in vr}
else:
    execution = CosimExecution.from_step_size(100_000)
    slaves = {name: CosimLocalSlave(path, name) for name, path in job["fmus"].items()}
    index = {name: execution.add_local_slave(slave) for name, slave in slaves.items()}
    for name in index:
        for variable, value in job["start"][name].items():
            assert execution.real_initial_value(index[name], vr[name][variable], value)
    for (a, output), (b, input) in job["connections"]:
        assert execution.connect_real_variables(
            index[a], vr[a][output], index[b], vr[b][input]
        ) == 0
observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
assert execution.add_observer(observer) and execution.add_manipulator(manipulator)
rows = []
for reference in job["reference"]:
    for name, variable in job["driven"]:
        assert manipulator.slave_real_values(index[name], [vr[name][variable]], [reference])
    assert execution.step()
    rows.append(
        [observer.last_real_values(index[n], [vr[n][v]])[0] for n, v in job["outputs"]]
    )
json.dump(rows, open(job["rows"], "w"))
"""

# What is freed is freed by then: while a process ends, oneTBB now and then takes libtcm away from a
# thread that is in it, and the process crashes (5 of 1500 runs).
ECOS = """
import json, os, sys
from contextlib import ExitStack
from ecospy import EcosSimulation, EcosSimulationStructure

job = json.load(open(sys.argv[1], encoding="utf-8"))
with ExitStack() as stack:
    if "ssp" in job:
        simulation, chosen = EcosSimulation(1e-4, ssp_path=job["ssp"]), job["set"]
    else:
        structure = stack.enter_context(EcosSimulationStructure())
        for name, path in job["fmus"].items():
            structure.add_model(name, path)
        for (a, output), (b, input) in job["connections"]:
            structure.make_real_connection(f"{a}::{output}", f"{b}::{input}")
        start = {f"{n}::{v}": x for n, values in job["start"].items() for v, x in values.items()}
        structure.add_parameter_set("start", start)
        simulation, chosen = EcosSimulation(1e-4, structure=structure), "start"
    stack.enter_context(simulation)
    assert simulation.init(parameter_set=chosen) if chosen else simulation.init()
    rows = []
    for reference in job["reference"]:
        for name, variable in job["driven"]:
            simulation.set_real(f"{name}::{variable}", reference)
        simulation.step()
        rows.append([simulation.get_real(f"{n}::{v}") for n, v in job["outputs"]])
json.dump(rows, open(job["rows"], "w"))
os._exit(0)
"""

MASTERS = {"libcosimpy": LIBCOSIM, "ecospy": ECOS}


def run_in(master: str, job: dict, directory: Path) -> np.ndarray:
    """Return the outputs after each step of a master, shape (steps, outputs).

    Parameters
    ----------
    master : str
        A module's name; the test is skipped where it is not installed.
    job : dict
        `fmus` by name, `driven` and `outputs` as lists of name and variable, and the `reference` that
        the former get; a package as `ssp` and the name of its `set`, or `connections` and `start`.
    directory : Path
        To work in.
    """
    if importlib.util.find_spec(master) is None:
        pytest.skip(f"{master} is not installed")
    file, rows = directory / "job.json", directory / "rows.json"
    file.write_text(json.dumps({**job, "rows": str(rows)}), encoding="utf-8")
    libraries = str(Path(sys.prefix) / "lib")  # where PyPI's tbb is, which ecos needs
    # what a package is unpacked to goes with the test
    run_python(MASTERS[master], file, LD_LIBRARY_PATH=libraries, TMPDIR=str(directory))
    return np.array(json.loads(rows.read_text()))
