"""Masters that we did not write, on our FMUs.

libcosim and ecos are Jacobi masters: in one step every FMU runs with what was handed on after the
step before. The plant therefore gets the voltage of tick k at tick k + 1, and the one that the
inverse gives before its first tick at tick 0. Each master runs in a process of its own.
"""

import importlib.util
import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import TS, UM, Master, Unpacked, make_set, run_python

from it2hys.model import compiled
from it2hys.model.parameters import SSV_NAMESPACE, write_ssv
from it2hys.stand.excitations import tracking_reference

# Each program reads a job and writes a file: voltage and displacement of each pair after each step.
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
    execution = CosimExecution.from_ssp_file(job["ssp"], job["nanoseconds"])
    index = {name: execution.slave_index_from_instance_name(name) for name in vr}
else:
    execution = CosimExecution.from_step_size(job["nanoseconds"])
    slaves = {name: CosimLocalSlave(path, name) for name, path in job["fmus"].items()}
    index = {name: execution.add_local_slave(slave) for name, slave in slaves.items()}
    for name in index:
        for variable, value in job["start"][name].items():
            assert execution.real_initial_value(index[name], vr[name][variable], value)
    for a, b in job["pairs"]:
        assert execution.connect_real_variables(
            index[a], vr[a]["voltage"], index[b], vr[b]["voltage"]
        ) == 0
observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
assert execution.add_observer(observer) and execution.add_manipulator(manipulator)
rows = []
for reference in job["reference"]:
    for a, _ in job["pairs"]:
        assert manipulator.slave_real_values(index[a], [vr[a]["reference"]], [reference])
    assert execution.step()
    for a, b in job["pairs"]:
        (voltage,) = observer.last_real_values(index[a], [vr[a]["voltage"]])
        (reached,) = observer.last_real_values(index[b], [vr[b]["displacement"]])
        rows.append((voltage, reached))
json.dump(rows, open(job["rows"], "w"))
"""

ECOS = """
import json, sys
from contextlib import ExitStack
from ecospy import EcosSimulation, EcosSimulationStructure

job = json.load(open(sys.argv[1], encoding="utf-8"))
with ExitStack() as stack:
    if "ssp" in job:
        simulation = EcosSimulation(job["nanoseconds"] * 1e-9, ssp_path=job["ssp"])
        chosen = job["set"]
    else:
        structure = stack.enter_context(EcosSimulationStructure())
        for name, path in job["fmus"].items():
            structure.add_model(name, path)
        for a, b in job["pairs"]:
            structure.make_real_connection(f"{a}::voltage", f"{b}::voltage")
        start = {f"{n}::{v}": x for n, values in job["start"].items() for v, x in values.items()}
        structure.add_parameter_set("start", start)
        simulation = EcosSimulation(job["nanoseconds"] * 1e-9, structure=structure)
        chosen = "start"
    stack.enter_context(simulation)
    assert simulation.init(parameter_set=chosen)
    rows = []
    for reference in job["reference"]:
        for a, _ in job["pairs"]:
            simulation.set_real(f"{a}::reference", reference)
        simulation.step()
        rows += [
            (simulation.get_real(f"{a}::voltage"), simulation.get_real(f"{b}::displacement"))
            for a, b in job["pairs"]
        ]
json.dump(rows, open(job["rows"], "w"))
"""

MASTERS = {"libcosimpy": LIBCOSIM, "ecospy": ECOS}


@pytest.fixture(params=MASTERS)
def run_master(request, tmp_path):
    """Return a function from a job to the voltage and the displacement after each step."""
    if importlib.util.find_spec(request.param) is None:
        pytest.skip(f"{request.param} is not installed")

    def run(job: dict) -> tuple[np.ndarray, np.ndarray]:
        path = tmp_path / "job.json"
        rows = tmp_path / "rows.json"  # what a master itself prints may come last
        defaults = {"nanoseconds": 100_000, "pairs": [("inverse", "plant")], "rows": str(rows)}
        job = {**defaults, **job}
        path.write_text(json.dumps(job), encoding="utf-8")
        libraries = str(Path(sys.prefix) / "lib")  # where PyPI's tbb is, which ecos needs
        run_python(MASTERS[request.param], path, LD_LIBRARY_PATH=libraries)
        return tuple(np.array(json.loads(rows.read_text())).T)

    return run


def paths(unpacked: dict[str, Unpacked]) -> dict[str, str]:
    return {name: str(unpacked[name].path) for name in ("inverse", "plant")}


def same_start(**values: float) -> dict[str, dict[str, float]]:
    return {name: values for name in ("inverse", "plant")}


def jacobi(unpacked: dict[str, Unpacked], start: dict, reference: np.ndarray) -> tuple:
    """Return what a Jacobi master reads after each step, run through FMPy."""
    with Master(unpacked["inverse"], start) as inverse, Master(unpacked["plant"], start) as plant:
        handed_on = inverse.instance.get("voltage")
        voltage, reached = [], []
        for desired in reference:
            reached.append(plant.advance(handed_on))
            handed_on = inverse.advance(desired)
            voltage.append(handed_on)
    return np.array(voltage), np.array(reached)


@pytest.mark.parametrize("name", ["table_1", "five_rules"])
def test_a_jacobi_master_runs_inverse_and_plant_as_fmpy_does(packaged, run_master, name):
    parameters, unpacked = packaged[name]
    reference = tracking_reference(np.arange(500) * TS)
    start = {"initialDisplacement": reference[0]}
    job = {"fmus": paths(unpacked), "start": same_start(**start), "reference": reference.tolist()}
    voltage, reached = run_master(job)
    expected = jacobi(unpacked, start, reference)
    np.testing.assert_allclose(voltage, expected[0], rtol=1e-12)
    np.testing.assert_allclose(reached, expected[1], rtol=1e-12)
    # the C core, with the set's own rules and the voltage one tick late
    rules = parameters.rules
    late = np.concatenate([compiled.solve(rules, reference[:1], reference[:1]), voltage[:-1]])
    np.testing.assert_allclose(reached, compiled.free_run(rules, late, reference[0]), rtol=1e-12)
    # so the plant follows the reference, one step late
    np.testing.assert_allclose(reached[1:], reference[:-1], rtol=1e-9)


def test_many_instances_from_a_path_with_spaces_and_umlauts(five_rules, run_master, tmp_path):
    """Three pairs that start elsewhere and share binaries, in one simulation."""
    place = tmp_path / "Prüfstand für Aktor ä"
    place.mkdir()
    copies = {n: shutil.copy(five_rules[n].path, place) for n in ("inverse", "plant")}
    pairs = [(f"inverse{k}", f"plant{k}") for k in range(3)]
    start = [{"initialDisplacement": (3.0 + 2 * k) * UM} for k in range(3)]
    reference = tracking_reference(np.arange(50) * TS)
    job = {
        "fmus": {n: copies[n[:-1]] for pair in pairs for n in pair},
        "start": {n: start[k] for k, pair in enumerate(pairs) for n in pair},
        "pairs": pairs,
        "reference": reference.tolist(),
    }
    voltage, reached = run_master(job)
    for k in range(3):
        expected = jacobi(five_rules, start[k], reference)
        np.testing.assert_allclose(voltage[k::3], expected[0], rtol=1e-12)
        np.testing.assert_allclose(reached[k::3], expected[1], rtol=1e-12)
    assert np.ptp(reached[:3]) > 1 * UM


def test_the_parameters_of_another_set_make_another_voltage(packaged, run_master):
    """A guard for the test above: a master that ran Table 1 instead would be seen."""
    reference = np.full(3, 5 * UM)
    job = {"start": same_start(initialDisplacement=5 * UM), "reference": reference.tolist()}
    voltage = [
        run_master({"fmus": paths(packaged[name][1]), **job})[0][-1]
        for name in ("table_1", "five_rules")
    ]
    expected = [
        compiled.solve(packaged[name][0].rules, reference[:1], reference[:1])[0]
        for name in ("table_1", "five_rules")
    ]
    np.testing.assert_allclose(voltage, expected, rtol=1e-12)
    assert abs(voltage[0] - voltage[1]) > 1


# --- our parameter file in their hands ---------------------------------------------------------

SSD = f"""<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription name="rig" version="1.0"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssv="{SSV_NAMESPACE}">
  <ssd:System name="rig">
    <ssd:Elements>
      <ssd:Component name="inverse" type="application/x-fmu-sharedlibrary"
          source="resources/IT2Inverse.fmu">
        <ssd:Connectors>
          <ssd:Connector name="voltage" kind="output"><ssc:Real/></ssd:Connector>
        </ssd:Connectors>
        <ssd:ParameterBindings>
          <ssd:ParameterBinding source="resources/parameters.ssv"/>
        </ssd:ParameterBindings>
      </ssd:Component>
      <ssd:Component name="plant" type="application/x-fmu-sharedlibrary"
          source="resources/IT2Plant.fmu">
        <ssd:Connectors>
          <ssd:Connector name="voltage" kind="input"><ssc:Real/></ssd:Connector>
        </ssd:Connectors>
        <ssd:ParameterBindings>
          <ssd:ParameterBinding source="resources/parameters.ssv"/>
        </ssd:ParameterBindings>
      </ssd:Component>
    </ssd:Elements>
    <ssd:Connections>
      <ssd:Connection startElement="inverse" startConnector="voltage"
          endElement="plant" endConnector="voltage"/>
    </ssd:Connections>
  </ssd:System>
</ssd:SystemStructureDescription>
"""


def test_a_parameter_file_in_an_ssp_reaches_the_fmus(tmp_path, models, run_master):
    """FMUs with Table 1, and a parameter set of other rules written by us beside them."""
    parameters = make_set(33, 3, initialDisplacement=5 * UM)
    resources = tmp_path / "ssp" / "resources"
    resources.mkdir(parents=True)
    for unpacked in models.values():
        shutil.copy(unpacked.path, resources)
    write_ssv(parameters, resources / "parameters.ssv")
    (tmp_path / "ssp" / "SystemStructure.ssd").write_text(SSD, encoding="utf-8")
    packed = Path(shutil.make_archive(str(tmp_path / "rig"), "zip", tmp_path / "ssp"))
    packed = packed.rename(packed.with_suffix(".ssp"))
    reference = (5 + np.sin(np.arange(100) / 20)) * UM
    voltage, reached = run_master(
        {
            "fmus": paths(models),
            "ssp": str(packed),
            "set": parameters.name,  # ecos takes no set but the one that it is told by name
            "reference": reference.tolist(),
        }
    )
    expected = compiled.solve(parameters.rules, np.concatenate([[5 * UM], reference[:-1]]), reference)
    np.testing.assert_allclose(voltage, expected, rtol=1e-12)
    np.testing.assert_allclose(reached[1:], reference[:-1], rtol=1e-9)
