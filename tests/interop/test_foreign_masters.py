"""Masters that we did not write, on our FMUs.

libcosim and ecos are Jacobi masters: in one step every FMU runs with what was handed on after the
step before. The plant therefore gets the voltage of tick k at tick k + 1, and the one that the
inverse gives before its first tick at tick 0. Each master runs in a process of its own.
"""

import shutil
from collections.abc import Sequence

import numpy as np
import pytest
from conftest import TS, UM, Master, Unpacked
from masters import MASTERS, run_in

from it2hys.model import compiled
from it2hys.stand.excitations import tracking_reference


@pytest.fixture(params=MASTERS)
def run_master(request, tmp_path):
    """Return a function from a job to the voltage and the displacement after each step of each pair."""

    def run(job: dict, pairs: Sequence = (("inverse", "plant"),)) -> tuple[np.ndarray, np.ndarray]:
        job["driven"] = [(a, "reference") for a, _ in pairs]
        job["connections"] = [((a, "voltage"), (b, "voltage")) for a, b in pairs]
        job["outputs"] = [end for a, b in pairs for end in ((a, "voltage"), (b, "displacement"))]
        return tuple(run_in(request.param, job, tmp_path).reshape(-1, 2).T)

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
        "reference": reference.tolist(),
    }
    voltage, reached = run_master(job, pairs)
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
