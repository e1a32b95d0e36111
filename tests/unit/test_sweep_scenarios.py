"""Scenario files, the plan they become, metrics: everything before and after the cases run."""

import copy
import doctest
import itertools
import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

import it2hys
from it2hys import api
from it2hys.cli import main
from it2hys.errors import InputError
from it2hys.model.parameters import table_1
from it2hys.records import read_record, write_record
from it2hys.stand import Stand, excitations
from it2hys.support.files import write_atomically
from it2hys.sweeps import parse_sweep, read_sweep
from it2hys.sweeps.cases import make_plan
from it2hys.sweeps.measures import KINDS, MetricData, bandwidth, loop_area
from it2hys.sweeps.plan import LARGEST_CASES, LARGEST_STEPS

SCENARIOS = Path(__file__).parents[2] / "scenarios"
SWEEPS = sorted(
    path for path in SCENARIOS.glob("*.toml") if "fmu" in tomllib.loads(path.read_text("utf-8"))
)
BASE = {
    "duration": 0.02,
    "fmu": {
        "inverse": {"source": "IT2Inverse", "start": {"initialDisplacement": 1e-6}},
        "plant": {"source": "IT2Plant", "start": {"initialDisplacement": 1e-6}},
    },
    "signal": {"reference": {"signal": "sine", "frequency": 50.0, "low": 1e-6, "high": 9e-6}},
    "connections": [
        {"from": "reference", "to": "inverse.reference"},
        {"from": "inverse.voltage", "to": "plant.voltage"},
    ],
    "vary": [{"name": "top", "of": "reference.high", "values": [5e-6, 9e-6]}],
    "metric": [{"kind": "e_mr", "of": "plant.displacement", "against": "reference"}],
}


def changed(path, value):
    """Return the base scenario with one thing changed; a path is keys and numbers."""
    table = copy.deepcopy(BASE)
    place = table
    for key in path[:-1]:
        place = place[key]
    if value is None:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return table


# --- bad input ---------------------------------------------------------------------------------

NO_SCENARIO = [
    (("durations",), 1.0, r"unknown key 'durations'; did you mean 'duration'\?"),
    (("duration",), None, "key 'duration' is missing"),
    (("duration",), -1.0, "duration is -1.0; it must not be negative"),
    (("duration",), 0.0, "duration is 0.0; it must be positive"),
    (("duration",), {"periods": 2.0, "of": "ref"}, "duration: there is no signal 'ref'; known"),
    (("duration",), "long", "duration is 'long'; it must be a number or a table"),
    (("duration",), 1e9,
     r"^duration is 1e\+09 s \(case 0\): 1e\+13 steps of 0.0001 s need 1.6e\+05 GB of memory; at most "
     "100,000,000 can be run, so shorten duration or lengthen step$"),
    (("duration",), {"periods": 1e9, "of": "reference"}, r"duration is 2e\+07 s .case 0.: 2e\+11"),
    (("step",), 1e-300, r"duration is 0.02 s .case 0.: 2e\+298 steps of 1e-300 s.* or lengthen step$"),
    (("vary", 0), {"of": "duration", "values": [0.02, 3e8]}, r"duration is 3e\+08 s .case 1.: 3e\+12"),
    (("vary", 0), {"of": "step", "values": [1e-4, 1e-12]}, r"duration is 0.02 s .case 1.: 2e\+10"),
    (("samples",), 1e9, "samples is 1000000000.0; it must be a whole number"),
    (("vary", 0), {"of": "reference.high", "range": [5e-6, 9e-6], "count": 10**9},
     r"^vary 1: count = 1000000000: 1e\+09 cases, whose table needs 16 GB; at most 10,000,000 can be "
     "run, so lower it$"),
    (("step",), 0.0, "step is 0.0; it must be positive"),
    (("step",), True, "step is True; it must be a number"),
    (("samples",), 0, "samples is 0"),
    (("fmu", "plant", "sorce"), "x", r"fmu.plant: unknown key 'sorce'; did you mean 'source'\?"),
    (("fmu", "plant", "start", "initalDisplacement"), 1e-6,
     r"fmu.plant: start: the FMU 'plant' has no variable 'initalDisplacement'; did you mean 'initialD"),
    (("fmu", "plant", "start", "load.complience"), 1.0, r"did you mean 'load.compliance'\?.* more$"),
    (("fmu", "plant", "start", "initialDisplacement"), 1.0,
     r"fmu.plant: start: plant.initialDisplacement is 1; it must be -0.1 to 0.1"),
    (("fmu", "plant", "start", "initialDisplacement"), "much", "must be a finite number"),
    (("fmu", "plant", "start", "ruleCount"), 2.5, "ruleCount is 2.5; it must be a whole number"),
    (("fmu", "plant", "start", "displacement"), 1e-6, "displacement is output; it cannot be set"),
    (("fmu", "plant", "source"), "nothing.fmu", "fmu.plant: source: nothing.fmu: no such file"),
    (("fmu", "plant", "parameters"), "nothing.ssv", "fmu.plant: parameters: nothing.ssv: no"),
    (("signal", "reference", "signal"), "sinus", "signal is 'sinus'; it must be one"),
    (("signal", "reference", "frequncy"), 2.0, "'sine' has no argument 'frequncy'; did"),
    (("signal", "reference", "frequency"), None, "signal.reference: .*frequency"),
    (("signal", "reference", "frequency"), -2.0, "signal.reference: frequency must be positive"),
    (("signal", "reference"), {"signal": "csv", "file": "no.csv", "column": "reference"},
     "signal.reference: file: no.csv"),
    (("signal", "reference"), {"signal": "csv", "file": "no.csv", "column": "volts"},
     "signal.reference: column is 'volts'"),
    (("connections", 0, "to"), "inverse.refrence",
     r"connections: the FMU 'inverse' has no variable 'refrence'; did you mean 'reference'\?"),
    (("connections", 0, "to"), "invers.reference", r"no FMU 'invers'; did you mean 'inverse'\?"),
    (("connections", 0, "to"), "plant.displacement", "connections: plant.displacement is no input"),
    (("connections", 0, "from"), "refrence", r"no signal 'refrence'; did you mean 'reference'\?"),
    (("connections", 0, "form"), "x", r"connections 1: unknown key 'form'; did you mean 'from'\?"),
    (("connections", 1, "to"), "inverse.reference", "inverse.reference is connected twice"),
    (("vary", 0, "valus"), [1.0], r"vary 1: unknown key 'valus'; did you mean 'values'\?"),
    (("vary", 0, "values"), None, "vary 1: give one of values, range and normal"),
    (("vary", 0, "values"), ["a"], "vary 1: values has 'a'"),
    (("vary", 0, "values"), [5e-6, -1.0], "signal.reference: the range must have low < high"),
    (("vary", 0, "of"), "reference.hight", r"no argument 'hight'; did you mean 'high'\?"),
    (("vary", 0, "of"), "plant.rule[9].q1", r"vary 1: of: the FMU 'plant' has no variable 'rule\[9\]"),
    (("vary", 0, "of"), "step", None),
    (("vary", 0), {"of": "plant.load.compliance", "values": [0.0, 2.0]},
     "vary 1: plant.load.compliance is 2; it must"),
    (("vary", 0), {"of": "plant.load.compliance", "range": [0.0, 1.0]}, "vary 1: count is 0"),
    (("vary", 0), {"of": "plant.load.compliance", "normal": [0.0, 1.0]}, "normal needs the method"),
    (("vary", 0), {"of": "plant.load.compliance", "range": [0.0, 1.0], "count": 3, "scale": "log"},
     "vary 1: range must be positive where scale is 'log'"),
    (("vary", 0), {"of": "plant", "intervals": "no.json"}, "vary 1: intervals: no.json: no such file"),
    (("vary", 0), {"of": "plant", "intervals": {"rule[1].q2": [2e-8, 1e-8]}},
     r"vary 1: intervals.rule\[1\].q2 is \[2e-08, 1e-08\]; it must be \[low, high\]"),
    (("vary", 0), {"of": "plant", "intervals": {"rule[1].q2": [1e-8, 2e-8]}, "only": ["q3"]},
     "vary 1: only: no interval of 'q3'"),
    (("metric", 0, "kind"), "e_max", "metric 1: kind is 'e_max'; it must be one of e_mr, e_rms"),
    (("metric", 0, "against"), None, "metric 1: e_mr compares: key 'against' is missing"),
    (("metric", 0, "against"), "refrence", r"against: there is no signal 'refrence'; did"),
    (("metric", 0, "of"), "plant.displacment",
     r"of: the FMU 'plant' has no variable 'displacment'; did you mean 'displacement'\?"),
    (("metric", 0, "name"), "top", "two columns would be named 'top'"),
    (("metric", 0, "name"), "status", "two columns would be named 'status'"),
    (("keep",), ["plant.speed"], "keep: the FMU 'plant' has no variable 'speed'"),
    (("lead_in",), 0.02, "lead_in: leaves nothing of the 200 steps"),
    (("figure",), [{"kind": "lines", "x": "top", "value": "e_mrs"}],
     r"figure 1: value is 'e_mrs'; did you mean 'e_mr'\?"),
    (("figure",), [{"kind": "lines", "value": "e_mr"}], "figure 1: key 'x' is missing"),
    (("figure",), [{"kind": "lines", "x": "variant", "value": "e_mr"}],
     "figure 1: x is 'variant'; known are top, e_mr"),
    (("variant",), [{"name": "a"}, {"name": "a"}], "two variants have one name"),
    (("variant",), [{"name": "a"}, 3], "^variant 2 is 3; it must be a table$"),
    (("variant",), [{"name": "a", "connections": [{"from": "reference", "to": "x.y", "factor": "2"}]}],
     "^variant 1: connections 1: factor is '2'; it must be a number$"),
    (("variant",), {"name": "a"}, "^variant is {'name': 'a'}; it must be a list$"),
    (("fmu", "plant"), 3, "^fmu.plant is 3; it must be a table$"),
    (("fmu", "plant", "name"), "p", "^fmu.plant: unknown key 'name'; known are source"),
    (("fmu", "plant", "source"), None, "^fmu.plant: key 'source' is missing; other keys given: start$"),
    (("signal", "reference", "name"), "r", "^signal.reference: unknown key 'name'"),
    (("folder",), ".", "^unknown key 'folder'; known are title"),
    (("duration",), {"seconds": 1.0}, "^duration: unknown key 'seconds'; known are periods, of$"),
    (("duration",), {"periods": -1.0, "of": "reference"},
     "^duration: periods is -1.0; it must be at least 0$"),
    (("step",), float("inf"), "^step is inf; it must be finite$"),
    (("keep",), ["reference", 3], "^keep has 3; each must be a text$"),
    (("vary", 0, "of"), [], r"^vary 1: of is \[\]; name at least one target$"),
    (("vary", 0, "factor"), 1, "^vary 1: factor is 1; it must be true or false$"),
    (("vary", 0, "interval"), "r.json", r"unknown key 'interval'; did you mean 'intervals'\?"),
    (("vary", 0), {"of": "plant", "intervals": 3},
     "^vary 1: intervals is 3; it must be a text or a table$"),
    (("vary", 0), {"of": "plant", "intervals": {"q": [1.0]}},
     r"^vary 1: intervals: q is \[1.0\]; it must be a list of two numbers$"),
    (("vary", 0), {"of": "plant", "intervals": {}, "width": 0.0},
     "^vary 1: width is 0.0; it must be positive$"),
    (("variant",), [{"name": "a", "set": {"plant.mass": 1.0}}], "variant 'a': set: the FMU 'plant'"),
    (("variant",), [{"name": "a", "set": {"reference.high": 5e-6}}], "is set by the variant 'a'"),
    (("variant",), [{"name": "a", "connections": [{"from": "reference", "to": "inverse.reference"}]}],
     "plant.displacement does not exist in the variant 'a'"),
]  # fmt: skip


@pytest.mark.parametrize(("path", "value", "said"), NO_SCENARIO)
def test_bad_input_is_named_by_its_key(path, value, said):
    if said is None:  # the base for `step` is right: 5e-6 s is a step
        make_plan(parse_sweep(changed(path, value)))
        return
    with pytest.raises(InputError, match=said) as caught:
        make_plan(parse_sweep(changed(path, value)))
    assert "\n" not in str(caught.value)


def test_more_cases_than_can_be_run_are_refused_before_they_are_drawn():
    """With every factor of their number, so that one sees what to lower."""
    drawn = {"of": "plant.force", "method": "random", "range": [0.0, 1.0]}
    grid = {"of": "reference.high", "range": [5e-6, 9e-6], "count": 2000}
    table = {**BASE, "samples": 10**9, "vary": [drawn]}
    with pytest.raises(
        InputError, match=r"^samples = 1000000000: 1e\+09 cases, whose table needs 16 GB"
    ):
        make_plan(parse_sweep(table))
    table = {
        **BASE,
        "samples": 4000,
        "vary": [drawn, grid, {**BASE["vary"][0], "of": "plant.temperature"}],
    }
    table["variant"] = [{"name": "a"}, {"name": "b"}]
    said = "vary 2: count = 2000 × vary 3: 2 values × samples = 4000 × 2 variants: 3.2e+07 cases"
    with pytest.raises(InputError, match=re.escape(said) + ".* so lower one of these$"):
        make_plan(parse_sweep(table))


def test_the_base_of_these_cases_is_a_good_one():
    assert make_plan(parse_sweep(BASE)).cases == 2


def test_a_bad_file_ends_the_command_with_code_2_before_anything_runs(tmp_path, capsys):
    path = tmp_path / "bad.toml"
    path.write_text('duration = 1.0\nstp = 1e-4\n[fmu.plant]\nsource = "IT2Plant"\n')
    assert main(["sweep", str(path), "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert f"{path}: unknown key 'stp'; did you mean 'step'?" in error
    assert not (tmp_path / "out").exists()
    assert main(["sweep", str(SCENARIOS / "demo.toml"), "-o", str(tmp_path / "out")]) == 2
    assert "not a sweep" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        (lambda text: text.replace('fmiVersion="2.0"', 'fmiVersion="1.0"'), "not an FMU|FMI 1.0"),
        (lambda text: text.replace("CoSimulation", "ModelExchange"),
         "not an FMU for co-simulation"),
        (lambda text: "no xml", "not an FMU"),
    ],
)  # fmt: skip
def test_an_fmu_of_another_kind_is_refused(edit, said, tmp_path, models):
    import zipfile

    path = tmp_path / "plant.fmu"
    with zipfile.ZipFile(models["plant"].path) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                content = edit(content.decode()).encode()
            new.writestr(name, content)
    with pytest.raises(InputError, match=f"fmu.plant: .*({said})"):
        make_plan(parse_sweep(changed(("fmu", "plant", "source"), str(path))))


def test_an_fmu_without_a_binary_for_this_platform_is_refused(tmp_path, models):
    import zipfile

    path = tmp_path / "plant.fmu"
    with zipfile.ZipFile(models["plant"].path) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            if not name.startswith("binaries/"):
                new.writestr(name, old.read(name))
    with pytest.raises(InputError, match="no binary for this platform"):
        make_plan(parse_sweep(changed(("fmu", "plant", "source"), str(path))))


# --- the cases ---------------------------------------------------------------------------------


def test_grids_are_crossed_lists_go_together_and_samples_are_crossed_with_both():
    table = {
        **BASE,
        "samples": 4,
        "vary": [
            {
                "name": "f",
                "of": "reference.frequency",
                "range": [10.0, 40.0],
                "count": 3,
                "scale": "log",
            },
            {"name": "a", "of": "plant.load.compliance", "method": "list", "values": [0.0, 1e-8]},
            {"name": "b", "of": "plant.force", "method": "list", "values": [5.0, 7.0]},
            {"name": "r", "of": "plant.rule[1].q2", "method": "random", "range": [1e-8, 2e-8]},
            {"name": "n", "of": "plant.rule[2].q2", "method": "random", "normal": [1e-8, 1e-10]},
        ],
    }
    plan = make_plan(parse_sweep(table))
    assert plan.cases == 3 * 2 * 4
    f, a, b, r, n = plan.matrix.T
    np.testing.assert_allclose(np.unique(f), [10, 20, 40])
    assert set(zip(a, b, strict=True)) == {(0.0, 5.0), (1e-8, 7.0)}
    assert len(np.unique(r)) == len(np.unique(n)) == 4 and r.min() >= 1e-8 and r.max() <= 2e-8
    again = make_plan(parse_sweep(table))
    assert again.matrix.tobytes() == plan.matrix.tobytes() and again.fingerprint == plan.fingerprint
    other = make_plan(parse_sweep({**table, "seed": 1}))
    assert other.matrix.tobytes() != plan.matrix.tobytes() and other.fingerprint != plan.fingerprint


def test_a_latin_hypercube_has_one_sample_in_every_slice():
    vary = [
        {"name": name, "of": f"plant.rule[{i}].q2", "method": "latin hypercube", "range": [1e-8, 2e-8]}
        for i, name in ((1, "a"), (2, "b"))
    ]
    plan = make_plan(parse_sweep({**BASE, "samples": 50, "vary": vary}))
    for column in plan.matrix.T:
        slices = np.floor((column - 1e-8) / 1e-8 * 50).astype(int)
        assert sorted(slices) == list(range(50))


def test_intervals_of_an_identification_are_drawn_normally(tmp_path):
    report = {
        "parameters": {
            "rule[1].q2": {"value": 2e-8, "ci95": [1.9e-8, 2.1e-8]},
            "rule[2].q2": {"value": 1.3e-8, "ci95": [None, None]},
            "rule[3].centre": {"value": 18e-6, "ci95": [17e-6, 19e-6]},
        }
    }
    (tmp_path / "report.json").write_text(json.dumps(report))
    path = tmp_path / "s.toml"
    base = {
        **BASE,
        "samples": 2000,
        "vary": [{"of": ["plant"], "intervals": "report.json", "width": 0.5}],
    }
    scenario = parse_sweep(base, "s", tmp_path)
    assert path.parent == scenario.folder
    plan = make_plan(scenario)
    assert [axis.name for axis in plan.axes] == ["rule[1].q2", "rule[3].centre"]
    inside = np.abs(plan.matrix[:, 0] - 2e-8) <= 0.5e-9
    assert np.mean(inside) == pytest.approx(0.95, abs=0.01)
    assert plan.matrix[:, 1].mean() == pytest.approx(18e-6, rel=1e-3)


def test_a_factor_multiplies_what_the_target_is_without_it():
    vary = [{"name": "x", "of": ["plant.rule[1].q2", "inverse.initialDisplacement", "reference.high"],
             "values": [0.5, 2.0], "factor": True}]  # fmt: skip
    plan = make_plan(parse_sweep({**BASE, "vary": vary}))
    values = plan.values(1)
    assert values["plant.rule[1].q2"] == 2 * table_1()["rule[1].q2"]
    assert values["inverse.initialDisplacement"] == 2e-6
    assert values["reference.high"] == 18e-6


def test_times_in_periods_follow_the_frequency_that_is_varied():
    table = {
        **BASE,
        "duration": {"periods": 4.0, "of": "reference"},
        "lead_in": {"periods": 1.0, "of": "reference"},
        "vary": [{"of": "reference.frequency", "values": [10.0, 100.0]}],
    }
    plan = make_plan(parse_sweep(table))
    assert plan.steps(plan.values(0)) == (1e-4, 4000, 1000)
    assert plan.steps(plan.values(1)) == (1e-4, 400, 100)


def test_chunks_hold_every_case_once():
    vary = [{"of": "plant.force", "range": [0.0, 1.0], "count": 1001}]
    plan = make_plan(parse_sweep({**BASE, "vary": vary}))
    chunks = plan.chunks()
    assert [case for chunk in chunks for case in chunk] == list(range(1001))
    assert 5 < len(chunks) < 40


@pytest.mark.parametrize("path", SWEEPS, ids=lambda p: p.stem)
def test_the_scenarios_that_come_with_the_package_are_good(path):
    plan = make_plan(read_sweep(path))
    assert plan.cases >= 8 and plan.metrics and plan.figures


def test_the_readme_of_the_scenarios_lists_every_scenario_and_metric():
    text = (SCENARIOS / "README.md").read_text(encoding="utf-8")
    for path in SCENARIOS.glob("*.toml"):
        assert f"`{path.stem}`" in text, path.stem
    for kind in KINDS:
        assert f"`{kind}`" in text, kind
    assert f"at most {LARGEST_CASES // 10**6} million cases" in text
    assert f"at most {LARGEST_STEPS // 10**6} million steps" in text


# --- signals and metrics -------------------------------------------------------------------------


def csv_reference(folder, **numbers):
    """Return a sweep that does nothing but keep a reference of 1, 3, 2 um at 5, 6, 7 ms of a CSV."""
    (folder / "r.csv").write_text("time_ms,reference_um\n5,1\n6,3\n7,2\n")
    source = {"signal": "csv", "file": "r.csv", "column": "reference", **numbers}
    table = changed(("signal", "reference"), source)
    return {**table, "vary": [], "keep": ["reference"], "duration": 0.004, "step": 5e-4}


def kept_um(folder, table):
    """Return the reference of every case, um."""
    frame = it2hys.sweep(write_scenario(folder, table))
    return [np.round(trace.to_numpy() * 1e6, 9).tolist() for trace in frame["reference"]]


def test_a_csv_signal_is_interpolated_and_held_beyond_its_end(tmp_path):
    assert kept_um(tmp_path, csv_reference(tmp_path)) == [[1, 2, 3, 2.5, 2, 2, 2, 2]]


def test_a_csv_signal_takes_a_factor_an_offset_and_another_time(tmp_path):
    """Half the time is twice the frequency."""
    half = csv_reference(tmp_path, factor=2, offset=-1e-6, time_factor=0.5)
    assert kept_um(tmp_path, half) == [[1, 5, 3, 3, 3, 3, 3, 3]]


@pytest.mark.parametrize(
    ("of", "values", "unit", "kept"),
    [
        ("factor", [0.5, 2.0], "1", [[0.5, 1, 1.5, 1.25, 1, 1, 1, 1], [2, 4, 6, 5, 4, 4, 4, 4]]),
        ("offset", [0.0, 1e-6], "m", [[1, 2, 3, 2.5, 2, 2, 2, 2], [2, 3, 4, 3.5, 3, 3, 3, 3]]),
        ("time_factor", [0.5, 2.0], "1",
         [[1, 3, 2, 2, 2, 2, 2, 2], [1, 1.5, 2, 2.5, 3, 2.75, 2.5, 2.25]]),
    ],
)  # fmt: skip
def test_what_a_csv_signal_takes_can_be_varied(of, values, unit, kept, tmp_path):
    table = {**csv_reference(tmp_path), "vary": [{"of": f"reference.{of}", "values": values}]}
    assert kept_um(tmp_path, table) == kept
    assert make_plan(parse_sweep(table, "s", tmp_path)).axes[0].unit == unit
    varied = {**table["vary"][0], "factor": True}
    again = kept_um(tmp_path, {**csv_reference(tmp_path), "vary": [varied]})
    assert again == (kept if of != "offset" else [kept[0], kept[0]])


def test_a_period_of_a_csv_signal_is_its_length(tmp_path):
    """Three samples of 1 ms, stretched; so a sweep over its frequency covers whole periods."""
    table = csv_reference(tmp_path, time_factor=2.0)
    table["duration"] = {"periods": 1.0, "of": "reference"}
    table["lead_in"] = {"periods": 0.5, "of": "reference"}
    plan = make_plan(parse_sweep(table, "s", tmp_path))
    assert plan.steps(plan.values(0)) == (5e-4, 12, 6)
    table["vary"] = [{"of": "reference.time_factor", "values": [1.0, 2.0, 4.0]}]
    plan = make_plan(parse_sweep(table, "s", tmp_path))
    assert plan.lengths().tolist() == [6, 12, 24]
    assert [len(trace) for trace in kept_um(tmp_path, table)] == [6, 12, 24]


@pytest.mark.parametrize(
    ("numbers", "vary", "said"),
    [
        ({"time_factor": 0.0}, [], "signal.reference: time_factor is 0; it must be positive"),
        ({"factor": float("nan")}, [], "signal.reference: factor is nan; it must be a finite number"),
        ({"offset": "1 um"}, [], "signal.reference: offset is '1 um'; it must be a number"),
        ({"facter": 2.0}, [], r"signal.reference: unknown key 'facter'; did you mean 'factor'\?"),
        ({}, [{"of": "reference.time_factor", "values": [1.0, -1.0]}],
         "signal.reference: time_factor is -1; it must be positive"),
        ({}, [{"of": "reference.frequency", "values": [1.0, 2.0]}],
         r"no argument 'frequency'; known are factor, offset, time_factor"),
    ],
)  # fmt: skip
def test_numbers_of_a_csv_signal_that_cannot_be_are_named(numbers, vary, said, tmp_path):
    with pytest.raises(InputError, match=said):
        make_plan(parse_sweep({**csv_reference(tmp_path, **numbers), "vary": vary}, "s", tmp_path))


def write_scenario(folder, table):
    """Write a dictionary as TOML; JSON's inline tables differ from it in their colons alone."""

    def text(value):
        if isinstance(value, dict):
            return "{" + ", ".join(f"{json.dumps(k)} = {text(v)}" for k, v in value.items()) + "}"
        if isinstance(value, list):
            return "[" + ", ".join(map(text, value)) + "]"
        return json.dumps(value)

    path = folder / "scenario.toml"
    lines = [f"{json.dumps(k)} = {text(v)}" for k, v in table.items()]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@pytest.mark.parametrize("ticks", [1, 5])
def test_an_output_is_compared_with_the_signal_at_its_tick(ticks):
    """What is read at the end of a step of five ticks is the output of the fifth."""
    step = ticks * 1e-4
    start = changed(("fmu", "plant", "source"), "IT2Plant")
    keep = ["plant.displacement", "reference"]
    frame = it2hys.sweep({**start, "step": step, "vary": [], "keep": keep})
    y, given = (frame[name][0].to_numpy() for name in keep)
    begins = np.arange(200 // ticks) * step
    arguments = {k: v for k, v in BASE["signal"]["reference"].items() if k != "signal"}
    np.testing.assert_array_equal(given, excitations.sine(begins, **arguments))
    wanted = excitations.sine(begins + (ticks - 1) * 1e-4, **arguments)
    assert frame["e_mr"][0] == pytest.approx(np.abs(wanted - y).max() / np.ptp(wanted), rel=1e-9)
    assert (frame["e_mr"][0] < 1e-9) == (ticks == 1)


def test_metrics_are_what_they_are_called():
    y = np.array([1.0, -2.0, 3.0, 0.0, 5.0])
    r = np.array([1.0, -1.0, 3.0, 1.0, 4.0])
    expected = {
        "e_mr": 1 / 5, "e_rms": np.sqrt(3 / 5), "gain": 7 / 5, "time true": 0.4, "mean": 1.4,
        "std": np.std(y), "rms": np.sqrt(39 / 5), "min": -2.0, "max": 5.0, "range": 7.0, "final": 5.0,
        "change": 4.0,
    }  # fmt: skip
    assert set(expected) | {"bandwidth", "loop area"} == set(KINDS)
    for kind, value in expected.items():
        assert KINDS[kind].function(MetricData(y, r, 0.1)) == pytest.approx(value), kind


@pytest.mark.parametrize("length", [1, 7, 8, 9, 127, 128, 129, 1000, 8193, 10_000])
def test_what_metrics_are_made_of_in_one_pass_is_numpys_to_the_last_bit(length):
    y, r = np.random.default_rng(length).normal(size=(2, length))
    y[::3] = 0.0
    error = r - y
    expected = {
        "e_rms": np.sqrt(np.sum(error * error) / length), "min": y.min(), "max": y.max(),
        "range": np.ptp(y), "time true": 0.1 * np.count_nonzero(y),
    }  # fmt: skip
    if length > 1:
        expected["e_mr"] = np.abs(error).max() / np.ptp(r)
    for kind, value in expected.items():
        assert KINDS[kind].function(MetricData(y, r, 0.1)) == value, kind


@pytest.mark.parametrize("length", [5, 8, 200])
def test_what_is_not_finite_is_found_wherever_it_is(length):
    r = np.linspace(0.0, 1.0, length)
    for bad, value in itertools.product(range(length), (np.nan, np.inf, -np.inf)):
        y = r.copy()
        y[bad] = value
        for kind, text in {
            "max": f"sample {bad} of",
            "e_mr": f"sample {bad}",
            "e_rms": f"sample {bad}",
        }.items():
            with pytest.raises(InputError, match=f"not finite, first at {text}"):
                KINDS[kind].function(MetricData(y, r, 0.1))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "time true"])
def test_no_metric_takes_what_is_not_finite(kind):
    y = np.array([1.0, np.nan, 3.0, 2.0])
    with pytest.raises(InputError, match="not finite"):
        KINDS[kind].function(MetricData(y, np.array([1.0, 2.0, 4.0, 0.0]), 0.1))


@pytest.mark.parametrize("pole", [30.0, 100.0])
@pytest.mark.parametrize("kind", ["multisine", "chirp"])
def test_the_bandwidth_of_a_lag_is_its_corner(kind, pole):
    from scipy.signal import lfilter

    step = 1e-4
    time = np.arange(30_000) * step
    if kind == "multisine":
        r = excitations.multisine(time, [1, 2, 3, 5, 8, 13, 20, 32, 50, 80, 120, 200, 300, 500])
    else:
        r = excitations.chirp(time, 1.0, 600.0, 3.0)
    a = np.exp(-2 * np.pi * pole * step)
    y = lfilter([1 - a], [1, -a], r)
    kept = slice(10_000 if kind == "multisine" else 0, None)
    assert bandwidth(r[kept], y[kept], step) == pytest.approx(pole, rel=0.15)
    assert np.isnan(bandwidth(r[kept], r[kept], step))


def test_the_area_of_an_elliptic_loop():
    phase = np.linspace(0, 6 * np.pi, 3000, endpoint=False)
    area = loop_area(50 - 50 * np.cos(phase), 3 - 2 * np.cos(phase - 0.4))
    assert area == pytest.approx(np.pi / 4 * np.sin(0.4), rel=1e-3)
    assert np.isnan(loop_area(np.ones(10), np.arange(10.0)))


# --- the functions for notebooks ---------------------------------------------------------------


def test_the_examples_in_the_docstrings_run():
    result = doctest.testmod(api)
    assert result.failed == 0 and result.attempted > 20


def test_every_function_is_imported_from_the_package():
    assert set(api.__all__) == set(it2hys._API)
    for name in api.__all__:
        assert getattr(it2hys, name) is getattr(api, name)
        assert name in dir(it2hys)
    with pytest.raises(AttributeError):
        _ = it2hys.nothing


def test_a_frame_comes_out_as_it_went_in(fmus):
    import polars as pl

    voltage = 50 - 50 * np.cos(np.arange(200) / 30)
    as_arrays = it2hys.simulate(fmus["plant"], {"voltage": voltage})
    as_frame = it2hys.simulate(fmus["plant"], pl.DataFrame({"time": voltage, "voltage": voltage}))
    assert isinstance(as_frame, pl.DataFrame)
    for name, column in as_arrays.items():
        assert as_frame[name].to_numpy().tobytes() == column.tobytes()
    reference = np.full(20, 3e-6)
    tracked = it2hys.track(fmus["inverse"], fmus["plant"], pl.DataFrame({"reference": reference}))
    assert isinstance(tracked, pl.DataFrame)
    np.testing.assert_allclose(tracked["displacement"], reference, rtol=1e-12)
    with pytest.raises(InputError, match="no column 'reference'; there are ref"):
        it2hys.track(fmus["inverse"], fmus["plant"], {"ref": reference})


def test_a_record_may_be_a_frame_a_file_or_a_record(tmp_path):
    time = excitations.time_grid(0.05, 1e-4)
    record = Stand().record(excitations.validation_sine(time, 40.0), "r", seed=1)
    write_record(tmp_path / "r.csv", record)
    read = read_record(tmp_path / "r.csv")
    frame = {"time_s": read.time, "voltage_V": read.voltage, "displacement_m": read.displacement}
    found = [
        it2hys.identify(train, rules=1).parameters for train in (tmp_path / "r.csv", [read], frame)
    ]
    assert dict(found[0]) == dict(found[1])
    np.testing.assert_allclose(found[2].rules, found[0].rules, rtol=1e-6)
    with pytest.raises(InputError, match="train_1"):
        it2hys.identify({"time_s": time, "voltage_V": time}, rules=1)


def test_a_write_that_fails_leaves_nothing(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        write_atomically(tmp_path / "no" / "file", b"x")
