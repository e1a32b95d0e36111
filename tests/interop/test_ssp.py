"""Our SSP packages in masters that we did not write.

All of them are Jacobi masters: every FMU steps with what the others gave at the step before. The same
algorithm is run here over FMPy's FMUs, so the results agree as far as arithmetic goes. `fmpy.ssp`
drives a system by its own connectors; libcosim and ecos, which refuse these, run the packages without.
"""

import re
import zipfile
from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest
from conftest import TS, UM, make_set
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import get_connections, read_ssd
from fmpy.ssp.ssd import read_ssv as fmpy_read_ssv
from lxml import etree
from masters import MASTERS, run_in

from it2hys.cli import main
from it2hys.cosimulation.slave import Slave
from it2hys.fmu.controller import controller_fmu, suitable_gains
from it2hys.fmu.packaging import fmu_archive, package_bytes
from it2hys.fmu.ssp import COMPONENTS_ALONE, SYSTEMS, format_controller_ssv, format_ssp, write_ssp
from it2hys.model import compiled
from it2hys.model.parameters import format_ssv, table_1, write_ssv

START = 5 * UM
OUTPUTS = {
    "feedforward": [("inverse", "voltage"), ("plant", "displacement")],
    "feedback": [("inverse", "voltage"), ("controller", "voltage"), ("plant", "displacement")],
}
DRIVEN = {
    "feedforward": [("inverse", "reference")],
    "feedback": [("inverse", "reference"), ("controller", "reference")],
}


@pytest.fixture(params=MASTERS)
def run_master(request, tmp_path):
    """Return a function from a package and a reference to the outputs after each step."""

    def run(name: str, ssp: bytes, chosen: str, reference: np.ndarray) -> np.ndarray:
        path = tmp_path / f"{name}{COMPONENTS_ALONE}.ssp"
        path.write_bytes(ssp)
        job = {
            "ssp": str(path), "set": chosen, "fmus": unpack(path, tmp_path / "unpacked"),
            "driven": DRIVEN[name], "outputs": OUTPUTS[name], "reference": reference.tolist(),
        }  # fmt: skip
        return run_in(request.param, job, tmp_path)

    return run


def unpack(ssp: Path, directory: Path) -> dict[str, str]:
    """Return the FMUs of a package by component."""
    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(directory)
    components = SYSTEMS[ssp.stem.removesuffix(COMPONENTS_ALONE)].components
    return {n: str(directory / "resources" / c.fmu()) for n, c in components.items()}


def jacobi(
    name: str, ssp: Path, sets: dict, reference: np.ndarray, directory: Path, late: bool = False
) -> np.ndarray:
    """Return what a Jacobi master reads after each step, run over FMPy.

    One that is late, as `fmpy.ssp` is, hands over what the steps before have given and the reference of
    the step before; before the first step all of that is 0.
    """
    system = SYSTEMS[name]
    slaves = {
        n: Slave(path, sets[system.components[n].parameters])
        for n, path in unpack(ssp, directory).items()
    }
    ends = [(a.split("."), b.split(".")) for a, b in system.inner]
    rows = []
    for k, desired in enumerate(np.concatenate([[0.0], reference[:-1]]) if late else reference):
        given = [(b, 0.0 if late and not k else slaves[a[0]].get(a[1])) for a, b in ends]
        given += [(target, desired) for target in DRIVEN[name]]
        for slave_name, slave in slaves.items():
            inputs = {v: value for (n, v), value in given if n == slave_name}
            slave.step(k * TS, TS, inputs)
        rows.append([slaves[n].get(v) for n, v in OUTPUTS[name]])
    for slave in slaves.values():
        slave.close()
    return np.array(rows)


def other_sets():
    """Return two parameter sets, SSV by file, and plain values by file, unlike what the FMUs hold."""
    parameters = make_set(33, 3, "another stage", initialDisplacement=START)
    gains = {**suitable_gains(parameters), "integralGain": 1e8, "proportionalGain": 1e5}
    texts = {
        "parameters.ssv": format_ssv(parameters),
        "controller.ssv": format_controller_ssv(gains, parameters.name),
    }
    return parameters, texts, {"parameters.ssv": dict(parameters), "controller.ssv": gains}


@cache
def default_fmus():
    """Return FMUs that hold Table 1 and no gains."""
    fmus = {f"{n}.fmu": content for n, content in package_bytes(table_1()).items()}
    return {**fmus, "PIController.fmu": controller_fmu()}


REFERENCE = (5 + np.sin(np.arange(150) / 20)) * UM


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_package_runs_as_over_fmpy_with_its_parameters(name, run_master, tmp_path):
    """The FMUs hold Table 1; only a master that applies the sets of the package gets these numbers."""
    parameters, texts, values = other_sets()
    ssp = format_ssp(name + COMPONENTS_ALONE, default_fmus(), texts, TS)
    read = run_master(name, ssp, parameters.name, REFERENCE)
    path = tmp_path / f"{name}{COMPONENTS_ALONE}.ssp"
    expected = jacobi(name, path, values, REFERENCE, tmp_path / "again")
    np.testing.assert_allclose(read, expected, rtol=1e-9)
    # the voltage that this set's rules need, which Table 1 does not
    needed = compiled.solve(parameters.rules, np.concatenate([[START], REFERENCE[:-1]]), REFERENCE)
    np.testing.assert_allclose(read[:, 0], needed, rtol=1e-9)
    defaults = compiled.solve(table_1().rules, np.concatenate([[START], REFERENCE[:-1]]), REFERENCE)
    assert np.abs(read[:, 0] - defaults).max() > 1


def test_without_gains_the_loop_is_another(run_master, tmp_path):
    """A guard for the controller's set: had it not been applied, the test above would have seen it."""
    parameters, texts, values = other_sets()
    expected = {}
    for gain in (0.0, values["controller.ssv"]["integralGain"]):
        gains = {**values["controller.ssv"], "integralGain": gain}
        texts["controller.ssv"] = format_controller_ssv(gains, parameters.name)
        ssp = format_ssp("feedback" + COMPONENTS_ALONE, default_fmus(), texts, TS)
        expected[gain] = run_master("feedback", ssp, parameters.name, REFERENCE)
    with_gain, without = expected.values()
    assert np.abs(with_gain - without).max() > 1e-3


@pytest.mark.parametrize("run_master", ["ecospy"], indirect=True)
def test_ecos_runs_the_defaults_unless_it_is_told_the_name_of_the_set(run_master):
    """Why all sets of a package have one name, and the documentation says which."""
    parameters, texts, _ = other_sets()
    ssp = format_ssp("feedforward" + COMPONENTS_ALONE, default_fmus(), texts, TS)
    told, untold = (
        run_master("feedforward", ssp, chosen, REFERENCE)[:, 0] for chosen in (parameters.name, "")
    )
    assert np.abs(told - untold).max() > 1


@pytest.mark.parametrize("run_master", ["ecospy"], indirect=True)
@pytest.mark.parametrize("name", SYSTEMS)
def test_ecos_runs_the_package_of_fmi_3_as_that_of_fmi_2(name, run_master, tmp_path):
    """With its set: another start in it is another run."""
    parameters = make_set(33, 3, "another stage", initialDisplacement=START)
    write_ssp(parameters, tmp_path, (2, 3))

    def run(version: str) -> np.ndarray:
        ssp = (tmp_path / f"{name}{version}{COMPONENTS_ALONE}.ssp").read_bytes()
        return run_master(name, ssp, parameters.name, REFERENCE)

    read = run("_fmi3")
    np.testing.assert_array_equal(read, run(""))
    path = tmp_path / f"{name}_fmi3{COMPONENTS_ALONE}.ssp"
    with zipfile.ZipFile(path) as archive:
        contents = {n: archive.read(n) for n in archive.namelist()}
    old, new = (f'value="{v!r}"'.encode() for v in (START, 6 * UM))
    assert contents["resources/parameters.ssv"].count(old) == 1
    changed = {n: c.replace(old, new) if n.endswith(".ssv") else c for n, c in contents.items()}
    path.write_bytes(fmu_archive(changed))
    assert np.abs(run("_fmi3") - read)[:, -1].max() > 0.1 * UM


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """Return what is written for a stage whose sensor reads half a micrometre too much."""
    apart = {"hum.amplitude": 0.5 * UM, "hum.frequency": 1e-3, "hum.phase": np.pi / 2}
    parameters = table_1().replace(initialDisplacement=START, **apart)
    folder = tmp_path_factory.mktemp("packages")
    write_ssv(parameters, folder / "p.ssv")
    arguments = ["package", str(folder / "p.ssv"), "-o", str(folder / "systems"), "--ssp", "--quiet"]
    assert main(arguments) == 0
    return parameters, folder / "systems"


def test_the_feedback_package_as_written_holds_the_reference(run_master, packages):
    """The loop closes on what the sensor reads, which is not where the stage is."""
    parameters, folder = packages
    ssp = (folder / f"feedback{COMPONENTS_ALONE}.ssp").read_bytes()
    read = run_master("feedback", ssp, parameters.name, np.full(400, 7 * UM))
    assert abs(read[-1, 2] + 0.5 * UM - 7 * UM) < 1e-3 * UM


@pytest.mark.parametrize("run_master", MASTERS, indirect=True)
def test_masters_that_read_no_connectors_of_a_system_are_why_there_are_two_packages(
    run_master, packages
):
    """Where this fails, a master has learnt it, and the second package can go."""
    parameters, folder = packages
    with pytest.raises(AssertionError, match=r"Unable to create execution|No element named"):
        run_master("feedforward", (folder / "feedforward.ssp").read_bytes(), parameters.name, REFERENCE)


# --- systems with connectors of their own --------------------------------------------------------


def named_for_fmpy(system: str, ssp: Path):
    """Return all parameters of a package as `fmpy.ssp` takes them: it reads no parameter bindings."""
    every = None
    for label, component in SYSTEMS[system].components.items():
        found = fmpy_read_ssv(str(ssp), f"resources/{component.parameters}")
        for parameter in found.parameters:
            parameter.name = f"{label}.{parameter.name}"
        every = every or found
        if found is not every:
            every.parameters += found.parameters
    return every


@pytest.mark.parametrize("name", SYSTEMS)
def test_fmpy_runs_a_package_by_the_connectors_of_its_system(name, tmp_path):
    _, texts, values = other_sets()
    path = tmp_path / f"{name}.ssp"
    path.write_bytes(format_ssp(name, default_fmus(), texts, TS))
    read = simulate_ssp(
        str(path), stop_time=(len(REFERENCE) - 0.5) * TS, step_size=TS,
        parameter_set=named_for_fmpy(name, path),
        input={"reference": lambda t: REFERENCE[round(t / TS)]},
    )  # fmt: skip
    expected = jacobi(name, path, values, REFERENCE, tmp_path / "again", late=True)
    voltage, displacement = expected[:, -2], expected[:, -1]
    np.testing.assert_allclose(read["voltage"], voltage, rtol=1e-9)
    np.testing.assert_allclose(read["displacement"], displacement, rtol=1e-9)
    np.testing.assert_array_equal(read["measured"], read["displacement"])
    assert not read["saturated"][1:].any() and read["saturated"].dtype == bool
    if name == "feedforward":  # two steps later; the zeros before the first step are forgotten
        np.testing.assert_allclose(displacement[80:], REFERENCE[78:-2], rtol=1e-6)


def test_the_documentation_shows_how_fmpy_closes_the_loop(packages, tmp_path, monkeypatch):
    """Its gains come from the package: FMPy hands over no parameter set by itself."""
    page = Path(__file__).parents[2] / "docs" / "tutorials" / "fmpy_and_ssp.md"
    text = page.read_text(encoding="utf-8")
    block = next(
        b for b in re.findall(r"```{run} python\n(.*?)```", text, re.DOTALL) if "simulate_ssp" in b
    )
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "systems").symlink_to(packages[1])
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(block, names)
    result = names["result"]
    assert abs(result["measured"][-1] - 7 * UM) < 1e-3 * UM
    assert abs(result["displacement"][-1] + 0.5 * UM - 7 * UM) < 1e-3 * UM


OWN = {
    "feedforward": {
        "reference": ("input", "m"), "displacement": ("output", "m"), "measured": ("output", "m"),
        "voltage": ("output", "V"), "saturated": ("output", None),
    },
}  # fmt: skip
OWN["feedback"] = {**OWN["feedforward"], "limited": ("output", None)}


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_systems_have_connectors_with_units(name, packages):
    with zipfile.ZipFile(packages[1] / f"{name}.ssp") as archive:
        root = etree.fromstring(archive.read("SystemStructure.ssd"))
    space = {"d": root.nsmap["ssd"], "c": root.nsmap["ssc"]}
    found = {
        c.get("name"): (c.get("kind"), c[0].get("unit"))
        for c in root.findall("d:System/d:Connectors/d:Connector", space)
    }
    assert found == OWN[name]
    units = {u.get("name"): dict(u[0].attrib) for u in root.findall("d:Units/c:Unit", space)}
    assert units == {"m": {"m": "1"}, "V": {"kg": "1", "m": "2", "s": "-3", "A": "-1"}}
    used = {r.get("unit") for r in root.iter(f"{{{space['c']}}}Real")}
    assert used == set(units)


@pytest.mark.parametrize("end", ["", COMPONENTS_ALONE, f"_fmi3{COMPONENTS_ALONE}"])
@pytest.mark.parametrize("name", SYSTEMS)
def test_the_command_writes_packages_that_fmpy_accepts(name, end, packages, tmp_path):
    """FMPy holds them to the standard's schemas."""
    path, fmi = packages[1] / f"{name}{end}.ssp", 3 if "_fmi3" in end else 2
    system, expected = read_ssd(str(path)).system, SYSTEMS[name]
    assert {e.name for e in system.elements} == set(expected.components)
    ends = {
        tuple(
            ".".join(filter(None, pair))
            for pair in ((c.startElement, c.startConnector), (c.endElement, c.endConnector))
        )
        for c in system.connections
    }
    assert ends == set(expected.inner if end else expected.connections)
    assert end or len(get_connections(system)) == len(expected.connections)
    with zipfile.ZipFile(path) as archive:
        assert all(i.compress_type in (0, 8) for i in archive.infolist())
        archive.extractall(tmp_path)
    for component in expected.components.values():
        resources = tmp_path / "resources"
        known = {
            v.name
            for v in fmpy.read_model_description(str(resources / component.fmu(fmi))).modelVariables
        }
        given = {p.name for p in fmpy_read_ssv(str(resources / component.parameters)).parameters}
        assert given <= known
