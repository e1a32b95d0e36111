"""Maestro, a master on the JVM, runs loops of inverse and plant.

It is a Jacobi master: each FMU runs a step with what the others gave at its beginning. The same is done
here over FMPy, with the steps that Maestro made.
"""

import csv
import json
import shutil
import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from conftest import TS, UM, Instance, Unpacked
from foreign_fmu import build_restless

JAR = Path(__file__).parents[2] / "build" / "maestro" / "maestro-2.3.0-jar-with-dependencies.jar"
PAIRS = 2


@pytest.fixture(scope="session")
def maestro():
    """Return a function that runs Maestro in a directory and returns the rows of its outputs.csv."""
    java = shutil.which("java")
    if java is None:
        pytest.skip("Maestro needs java")
    if not JAR.is_file():
        pytest.skip(f"{JAR.name} is not in build/maestro; `make build/maestro/.fetched`")

    def run(directory: Path, system: dict, end: float, algorithm: dict) -> list[dict[str, str]]:
        (directory / "system.json").write_text(json.dumps(system), encoding="utf-8")
        steps = {"startTime": 0.0, "endTime": end, "algorithm": algorithm}
        (directory / "steps.json").write_text(json.dumps(steps), encoding="utf-8")
        command = [java, "-Xmx300m", "-Dfile.encoding=UTF-8", "-jar", str(JAR), "import", "Sg1", "-i"]
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


def starts(pair: int) -> dict[str, dict[str, float]]:
    """Return start values of a pair of FMUs, which are not at rest with each other."""
    return {
        "inverse": {"initialDisplacement": (5.2 + pair) * UM},
        "plant": {"initialDisplacement": (5.0 + pair) * UM},
    }


def loops(unpacked: dict[str, Unpacked], place: Path, pairs: int) -> dict:
    """Return a system of pairs of an inverse and a plant, copied to a place, that feed each other."""
    copies = {n: Path(shutil.copy(unpacked[n].path, place)) for n in ("inverse", "plant")}
    system = {"fmus": {f"{{{n}}}": p.as_uri() for n, p in copies.items()}}
    system |= {"connections": {}, "parameters": {}}
    for k in range(pairs):
        inverse, plant = f"{{inverse}}.i{k}", f"{{plant}}.p{k}"
        system["connections"] |= {
            f"{inverse}.voltage": [f"{plant}.voltage"],
            f"{plant}.displacement": [f"{inverse}.reference"],
        }
        for name, values in starts(k).items():
            prefix = {"inverse": inverse, "plant": plant}[name]
            system["parameters"] |= {f"{prefix}.{v}": x for v, x in values.items()}
    return system


def read(rows: list[dict[str, str]], pair: int) -> np.ndarray:
    """Return time, voltage and displacement of a pair."""
    columns = ("time", f"{{inverse}}.i{pair}.voltage", f"{{plant}}.p{pair}.displacement")
    return np.array([[float(row[c]) for c in columns] for row in rows])


def over_fmpy(
    unpacked: dict[str, Unpacked], pair: int, times: np.ndarray, tried: float = 0.0
) -> np.ndarray:
    """Return voltage and displacement of a pair in the hands of a Jacobi master with these steps.

    One that is shorter than what was ``tried`` is the second attempt. As Maestro does, the state before
    it is restored, but the inputs are what the first attempt gave.
    """
    with Instance(unpacked["inverse"]) as inverse, Instance(unpacked["plant"]) as plant:
        pair_of = {"inverse": inverse, "plant": plant}
        for name, instance in pair_of.items():
            instance.initialize(starts(pair)[name])

        def step(handed_on: tuple, time: float, size: float) -> tuple:
            inverse.assign({"reference": handed_on[1]})
            plant.assign({"voltage": handed_on[0]})
            assert max(inverse.step(time, size), plant.step(time, size)) <= 1
            return inverse.get("voltage"), plant.get("displacement")

        rows = [(inverse.get("voltage"), plant.get("displacement"))]
        for time, end in pairwise(times):
            handed_on = rows[-1]
            if end - time < tried * (1 - 1e-9):
                states = {n: instance.fmu.getFMUstate() for n, instance in pair_of.items()}
                handed_on = step(handed_on, time, tried)
                for name, state in states.items():
                    pair_of[name].fmu.setFMUstate(state)
                    pair_of[name].fmu.freeFMUstate(state)
            rows.append(step(handed_on, time, end - time))
    return np.array(rows)


def assert_same(
    unpacked: dict[str, Unpacked], rows: list[dict[str, str]], pairs: int = 1, tried: float = 0.0
) -> np.ndarray:
    """Compare all pairs with FMPy; return the steps in ticks."""
    for k in range(pairs):
        table = read(rows, k)
        expected = over_fmpy(unpacked, k, table[:, 0], tried)
        assert np.ptp(expected[:, 0]) > 0.1
        np.testing.assert_allclose(table[:, 1:], expected, rtol=1e-12)
    return np.diff(table[:, 0]) / TS


def make_place(directory: Path, name: str) -> Path:
    place = directory / name
    place.mkdir()
    return place


def test_fixed_steps_of_seven_ticks_from_a_path_with_a_space(packaged, maestro, tmp_path):
    _, unpacked = packaged["five_rules"]
    place = make_place(tmp_path, "two FMUs")
    algorithm = {"type": "fixed-step", "size": 7 * TS}
    rows = maestro(place, loops(unpacked, place, 1), 30 * 7 * TS, algorithm)
    assert len(rows) >= 30
    np.testing.assert_allclose(assert_same(unpacked, rows), 7.0)


def test_variable_steps_of_many_instances_from_a_path_with_umlauts(packaged, maestro, tmp_path):
    """At every multiple of two and of three ticks: steps of one and two ticks in turn."""
    _, unpacked = packaged["five_rules"]
    place = make_place(tmp_path, "Prüfstand ä")
    rates = {
        f"every {n}": {"type": "samplingrate", "base": -4, "rate": n, "startTime": 0} for n in (2, 3)
    }
    algorithm = {"type": "var-step", "size": [TS / 10, 10 * TS], "initsize": TS, "constraints": rates}
    rows = maestro(place, loops(unpacked, place, PAIRS), 30 * TS, algorithm)
    steps = assert_same(unpacked, rows, PAIRS)
    assert set(np.round(steps, 6)) == {1.0, 2.0}


def test_a_step_that_another_fmu_discards_is_taken_back(packaged, maestro, tmp_path):
    """Maestro gives all FMUs back the state before the step and makes a shorter one."""
    _, unpacked = packaged["five_rules"]
    place = make_place(tmp_path, "three FMUs")
    system = loops(unpacked, place, 1)
    system["fmus"]["{restless}"] = build_restless(place).as_uri()
    system["connections"]["{plant}.p0.displacement"].append("{restless}.r.input")
    system["logVariables"] = {"{restless}.r": ["restored"]}
    rows = maestro(place, system, 60 * TS, {"type": "fixed-step", "size": 2 * TS})
    steps = assert_same(unpacked, rows, tried=2 * TS)
    assert set(np.round(steps, 6)) == {2.0, 1.5}
    stops = np.flatnonzero(np.round(steps, 6) == 1.5)
    restored = [float(row["{restless}.r.restored"]) for row in rows]
    assert restored[-1] == len(stops) >= 5
