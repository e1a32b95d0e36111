"""Masters and a checker that we did not write, on our FMUs.

libcosim and ecos are Jacobi masters: in one step every FMU runs with what was handed on after the
step before. The plant therefore gets the voltage of tick k at tick k + 1, and the one that the
inverse gives before its first tick at tick 0. Each master runs in a process of its own.
"""

import csv
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from conftest import TS, UM, Instance, Master, Unpacked, make_set, run_python

from it2hys import core
from it2hys.excitations import tracking_reference
from it2hys.parameters import SSV_NAMESPACE, write_ssv

# Each program reads a job and prints the voltage and the displacement after each step.
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
        for variable, value in job["start"].items():
            assert execution.real_initial_value(index[name], vr[name][variable], value)
    a, b = index["inverse"], index["plant"]
    assert execution.connect_real_variables(
        a, vr["inverse"]["voltage"], b, vr["plant"]["voltage"]
    ) == 0
observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
assert execution.add_observer(observer) and execution.add_manipulator(manipulator)
rows = []
for reference in job["reference"]:
    assert manipulator.slave_real_values(
        index["inverse"], [vr["inverse"]["reference"]], [reference]
    )
    assert execution.step()
    (voltage,) = observer.last_real_values(index["inverse"], [vr["inverse"]["voltage"]])
    (reached,) = observer.last_real_values(index["plant"], [vr["plant"]["displacement"]])
    rows.append((voltage, reached))
print(json.dumps(rows))
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
        structure.make_real_connection("inverse::voltage", "plant::voltage")
        start = {f"{n}::{v}": x for n in job["fmus"] for v, x in job["start"].items()}
        structure.add_parameter_set("start", start)
        simulation = EcosSimulation(job["nanoseconds"] * 1e-9, structure=structure)
        chosen = "start"
    stack.enter_context(simulation)
    assert simulation.init(parameter_set=chosen)
    rows = []
    for reference in job["reference"]:
        simulation.set_real("inverse::reference", reference)
        simulation.step()
        rows.append(
            (simulation.get_real("inverse::voltage"), simulation.get_real("plant::displacement"))
        )
print(json.dumps(rows))
"""

MASTERS = {"libcosimpy": LIBCOSIM, "ecospy": ECOS}


@pytest.fixture(params=MASTERS)
def run_master(request, tmp_path):
    """Return a function from a job to the voltage and the displacement after each step."""
    if importlib.util.find_spec(request.param) is None:
        pytest.skip(f"{request.param} is not installed")

    def run(job: dict) -> tuple[np.ndarray, np.ndarray]:
        path = tmp_path / "job.json"
        path.write_text(json.dumps({"nanoseconds": 100_000, **job}), encoding="utf-8")
        libraries = str(Path(sys.prefix) / "lib")  # where PyPI's tbb is, which ecos needs
        out = run_python(MASTERS[request.param], path, LD_LIBRARY_PATH=libraries)
        return tuple(np.array(json.loads(out.splitlines()[-1])).T)

    return run


def paths(unpacked: dict[str, Unpacked]) -> dict[str, str]:
    return {name: str(unpacked[name].path) for name in ("inverse", "plant")}


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
    voltage, reached = run_master({"fmus": paths(unpacked), "start": start,
                                   "reference": reference.tolist()})  # fmt: skip
    expected = jacobi(unpacked, start, reference)
    np.testing.assert_allclose(voltage, expected[0], rtol=1e-12)
    np.testing.assert_allclose(reached, expected[1], rtol=1e-12)
    # the C core, with the set's own rules and the voltage one tick late
    rules = parameters.rules
    late = np.concatenate([core.solve(rules, reference[:1], reference[:1]), voltage[:-1]])
    np.testing.assert_allclose(reached, core.free_run(rules, late, reference[0]), rtol=1e-12)
    # so the plant follows the reference, one step late
    np.testing.assert_allclose(reached[1:], reference[:-1], rtol=1e-9)


def test_the_parameters_of_another_set_make_another_voltage(packaged, run_master):
    """A guard for the test above: a master that ran Table 1 instead would be seen."""
    reference = np.full(3, 5 * UM)
    job = {"start": {"initialDisplacement": 5 * UM}, "reference": reference.tolist()}
    voltage = [
        run_master({"fmus": paths(packaged[name][1]), **job})[0][-1]
        for name in ("table_1", "five_rules")
    ]
    expected = [
        core.solve(packaged[name][0].rules, reference[:1], reference[:1])[0]
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
    expected = core.solve(parameters.rules, np.concatenate([[5 * UM], reference[:-1]]), reference)
    np.testing.assert_allclose(voltage, expected, rtol=1e-12)
    np.testing.assert_allclose(reached[1:], reference[:-1], rtol=1e-9)


# --- Maestro, a master on the JVM --------------------------------------------------------------

MAESTRO = "maestro-2.3.0-jar-with-dependencies.jar"


@pytest.fixture(scope="session")
def maestro():
    """Return a function that runs Maestro in a directory and returns the rows of its outputs.csv."""
    jar = Path(__file__).parents[2] / "build" / "maestro" / MAESTRO
    java = shutil.which("java")
    if java is None:
        pytest.skip("Maestro needs java")
    if not jar.is_file():
        pytest.skip(f"{MAESTRO} is not in build/maestro; `make build/maestro/.fetched`")

    def run(directory: Path, system: dict, steps: dict) -> list[dict[str, str]]:
        (directory / "system.json").write_text(json.dumps(system), encoding="utf-8")
        (directory / "steps.json").write_text(json.dumps(steps), encoding="utf-8")
        command = [java, "-Dfile.encoding=UTF-8", "-jar", str(jar), "import", "Sg1", "-i"]
        done = subprocess.run(
            [*command, "-output", "out", "system.json", "steps.json"],
            cwd=directory,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=120,
            check=False,
        )
        assert done.returncode == 0, done.stdout
        with (directory / "out" / "outputs.csv").open(encoding="utf-8") as file:
            return list(csv.DictReader(file))

    return run


def closed_loop(unpacked: dict[str, Unpacked], start: dict, steps: int, size: float) -> np.ndarray:
    """Return voltage and displacement of a Jacobi master that feeds each FMU the other's output."""
    with Instance(unpacked["inverse"]) as inverse, Instance(unpacked["plant"]) as plant:
        inverse.initialize(start["inverse"])
        plant.initialize(start["plant"])
        rows = [(inverse.get("voltage"), plant.get("displacement"))]
        for k in range(steps):
            inverse.assign({"reference": rows[-1][1]})
            plant.assign({"voltage": rows[-1][0]})
            assert max(inverse.step(k * size, size), plant.step(k * size, size)) <= 1
            rows.append((inverse.get("voltage"), plant.get("displacement")))
    return np.array(rows)


@pytest.mark.parametrize("ticks", [1, 7])
def test_maestro_runs_a_loop_of_both_fmus_as_fmpy_does(packaged, maestro, tmp_path, ticks):
    """With one and with seven ticks in a communication step, from a path with a space."""
    _, unpacked = packaged["five_rules"]
    start = {
        "inverse": {"initialDisplacement": 5.2 * UM},
        "plant": {"initialDisplacement": 5.0 * UM},
    }
    place = tmp_path / "two FMUs"
    place.mkdir()
    copies = {n: shutil.copy(unpacked[n].path, place) for n in start}
    system = {
        "fmus": {f"{{{n}}}": Path(path).as_uri() for n, path in copies.items()},
        "connections": {
            "{inverse}.i.voltage": ["{plant}.p.voltage"],
            "{plant}.p.displacement": ["{inverse}.i.reference"],
        },
        "parameters": {
            f"{{{n}}}.{n[0]}.{v}": x for n, values in start.items() for v, x in values.items()
        },
    }
    size = ticks * TS
    algorithm = {"type": "fixed-step", "size": size}
    rows = maestro(place, system, {"startTime": 0.0, "endTime": 30 * size, "algorithm": algorithm})
    read = [(float(r["{inverse}.i.voltage"]), float(r["{plant}.p.displacement"])) for r in rows]
    expected = closed_loop(unpacked, start, len(read) - 1, size)
    assert len(read) >= 30
    assert np.ptp(expected[:, 0]) > 0.1
    np.testing.assert_allclose(np.array(read), expected, rtol=1e-12)


# --- VDMCheck2 ---------------------------------------------------------------------------------

JARS = {
    "vdmj": "4.5.0",
    "annotations": "4.5.0",
    "xsd2vdm": "1.1.3",
    "fmuReader": "1.1.3",
    "vdmcheck2": "1.1.3",
    "static-model": "1.1.3",
    "rule-model": "1.1.3",
}


@pytest.fixture(scope="session")
def vdmcheck(tmp_path_factory):
    """Return a function that runs one of VDMCheck2's models and returns exit code and output."""
    root = Path(__file__).parents[2]
    jars = Path(os.environ.get("VDMCHECK_JARS", root / "build" / "vdmcheck"))
    java = shutil.which("java")
    if java is None:
        pytest.skip("VDMCheck2 needs java")
    missing = [f"{n}-{v}.jar" for n, v in JARS.items() if not (jars / f"{n}-{v}.jar").is_file()]
    if missing:
        pytest.skip(
            f"VDMCheck2 is not in {jars}: {', '.join(missing)} missing; `make build/vdmcheck/.fetched`"
        )
    home = tmp_path_factory.mktemp("vdmcheck")  # it wants its parts beside it, unpacked, so named
    for name, version in JARS.items():
        jar = jars / f"{name}-{version}.jar"
        shutil.copy(jar, home / f"{name}.jar")
        with zipfile.ZipFile(jar) as archive:
            archive.extractall(home, [n for n in archive.namelist() if n.startswith("fmi2")])

    def run(check: str, path: Path) -> tuple[int, str]:
        done = subprocess.run(
            [java, "-cp", "vdmcheck2.jar", check, str(path)],
            cwd=home,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=120,
            check=False,
        )
        return done.returncode, done.stdout

    return run


VDM_MODELS = {"static": "VDMCheck", "rule": "VDMCheckPlus"}


@pytest.mark.parametrize("which", ["plant", "inverse"])
@pytest.mark.parametrize("check", VDM_MODELS)
def test_vdmcheck_finds_nothing(vdmcheck, fmus, check, which):
    code, out = vdmcheck(VDM_MODELS[check], fmus[which])
    assert "No errors found." in out
    assert code == 0, out


@pytest.mark.parametrize("check", VDM_MODELS)
def test_vdmcheck_does_find_a_fault(vdmcheck, models, tmp_path, check):
    """A guard for the test above: a parameter that varies continuously."""
    text = (models["plant"].directory / "modelDescription.xml").read_text(encoding="utf-8")
    path = tmp_path / "modelDescription.xml"
    path.write_text(text.replace('variability="fixed"', 'variability="continuous"'), "utf-8")
    assert path.read_text(encoding="utf-8") != text
    code, out = vdmcheck(VDM_MODELS[check], path)
    assert code != 0
    assert "No errors found." not in out
