"""The library in OpenModelica, where there is one: see omc_acceptance."""

import re
import sys
from pathlib import Path

import numpy as np
import omc_acceptance
import pytest
from library import CLASSES, EXAMPLES, INVERSE, PLANT, stored_result
from omc_acceptance import (
    OMC,
    PARTS_OF_ACCEPTANCE,
    PERIOD,
    RATES,
    VERSIONS,
    MissingError,
    Session,
    at_ticks,
    findings,
    pairs_apart,
    pairs_source,
    read_result,
)


@pytest.mark.slow
@pytest.mark.skipif(not OMC, reason="no omc, OpenModelica's compiler, on the path")
@pytest.mark.parametrize("msl", VERSIONS)
@pytest.mark.parametrize("part", PARTS_OF_ACCEPTANCE)
def test_openmodelica_finds_nothing(msl, part, tmp_path):
    try:
        found = findings(part, Session(msl, tmp_path))
    except MissingError as missing:
        pytest.skip(str(missing))
    assert not found, "\n".join(found)


def test_the_pairs_of_the_acceptance_are_the_identity_in_rumoca():
    """What OpenModelica is asked is a model, and the comparison finds a plant that is another."""
    rumoca = pytest.importorskip("test_simulation", reason="rumoca is not installed")
    result = rumoca.compile_model(pairs_source(INVERSE, PLANT)).simulate(
        t=(0.0, PERIOD), dt=RATES[0], config=rumoca.rumoca.SimConfig(solver="rk-like")
    )
    signals = {n: np.asarray(result[n]) for n in result.names if "." in n}
    signals["time"] = np.asarray(result.time)

    def at(sample_time: float):
        return at_ticks(signals, round(PERIOD / sample_time), sample_time)

    assert not list(pairs_apart(at))
    signals["plant2.displacement"] = signals["plant2.displacement"] + 1e-17
    (found,) = pairs_apart(at)
    assert found.startswith("at 0.0002 s: displacement is ")


#: As much of omc as shows what the script makes of its answers: what it prints, and its MAT files, are
#: of the form that OpenModelica 1.26 gives them. Examples give their stored results.
OMC_OF_PAPER = r"""
import re, sys
sys.path[:0] = PATH
import numpy as np
from library import stored_result

FAULT = "@fault"
SUCCESS = "LOG_SUCCESS       | info    | The {} finished successfully{}.\n"
WARNING = (
    "LOG_ASSERT        | warning | [/lib/Blocks/Plant.mo:9:3-9:70:writable]\n"
    "|                 | |       | The following assertion has been violated at time 0.000000\n"
    "|                 | |       | pre(plant.left) or not plant.left\n"
    "LOG_ASSERT        | warning | M.plant: the voltage left voltageMin..voltageMax\n"
)
RECORD = (
    'record SimulationResult\n    resultFile = "{}",\n    simulationOptions = "startTime = 0.0",\n'
    '    messages = "{}",\n    timeSimulation = @seconds,\n    timeTotal = 3.1\nend SimulationResult;'
)

def write(path, time, signals):
    names = ["time", *signals]
    # the first signal as the negated alias of a row, what does not change with the constants
    rows, constants, info = [time], [0.0], [[0, 1, 0, -1]]
    for k, values in enumerate(signals.values()):
        sign = -1 if k == 0 else 1
        if np.ptp(values) == 0:
            constants.append(sign * values[0])
            info.append([1, sign * len(constants), 0, 0])
        else:
            rows.append(sign * values)
            info.append([2, sign * len(rows), 0, -1])
    width = max(map(len, names)) + 1
    text = np.array([list(n.encode().ljust(width, b"\0")) for n in names], dtype=np.uint8).T
    with open(path, "wb") as file:
        for name, kind, matrix in (
            ("name", 51, text), ("description", 51, text),
            ("dataInfo", 20, np.array(info, dtype=np.int32).T),
            ("data_1", 0, np.repeat(np.array(constants)[:, None], 2, axis=1)),
            ("data_2", 0, np.array(rows)),
        ):
            header = np.array([kind, *matrix.shape, 0, len(name) + 1], dtype=np.int32)
            file.write(header.tobytes() + name.encode() + b"\0" + matrix.tobytes("F"))

def simulate(name, prefix):
    if FAULT == "slow":
        source = open("M.mo", encoding="utf-8").read()
        slow = 0.02 + 0.7 * ("PureModelica.Plant" in source) + 0.5 * ("PureModelica.Inverse" in source)
        return RECORD.replace("@seconds", str(slow)).format("", "")
    if FAULT == "stops":
        return RECORD.format("", f"Simulation execution failed for model: {name}\n" + WARNING)
    time, signals = stored_result(name)
    last = list(signals)[-1]
    if FAULT == "other":
        signals[last] = signals[last] + 0.1 * (np.ptp(signals[last]) + 1e-6)
    if FAULT == "lacks":
        del signals[last]
    write(f"{prefix}_res.mat", time, signals)
    said = SUCCESS.format("initialization", " without homotopy method")
    said += (WARNING if FAULT == "warns" else "") + SUCCESS.format("simulation", "")
    return RECORD.format(f"{prefix}_res.mat", said)

if sys.argv[1] == "--version":
    sys.exit(print("OpenModelica 1.26.0"))
for line in open(sys.argv[1], encoding="utf-8").read().splitlines():
    if match := re.match(r'print\("(.*)\\n"\);', line):
        print(match[1])
    elif match := re.match(r"checkModel\((.*)\);", line):
        print(f'"Check of {match[1]} completed successfully.\nClass {match[1]} has 0 equation(s)."')
        if match[1].endswith("Blocks.Plant"):
            print('"[f.mo:1:1-2:2:writable] Warning: units do not match"')
    elif match := re.match(r'simulate\(([\w.]+), fileNamePrefix="(\w+)", outputFormat="mat"', line):
        print(simulate(match[1], match[2]))
    elif line.startswith("getVersion"):
        print('"@version"')
    elif line.startswith("getErrorString"):
        print('""')
"""


def omc_of_paper(tmp_path, monkeypatch, version="4.0.0", fault=""):
    """Put the above in the place of omc."""
    script = tmp_path / "omc"
    path = repr([str(Path(__file__).parent), *sys.path])
    body = OMC_OF_PAPER.replace("PATH", path, 1).replace("@version", version).replace("@fault", fault)
    script.write_text(f"#!{sys.executable}\n{body}", encoding="utf-8")
    script.chmod(0o755)
    monkeypatch.setattr(omc_acceptance, "OMC", str(script))


def test_a_warning_of_the_unit_check_is_a_finding(tmp_path, monkeypatch):
    omc_of_paper(tmp_path, monkeypatch)
    found = findings("classes", Session("4.0.0", tmp_path / "work"))
    named = [re.match(r"checkModel\((.*?)\)", finding)[1] for finding in found]
    assert named == [name for name in CLASSES if name.endswith("Blocks.Plant")]
    assert "units do not match" in found[0]


@pytest.mark.parametrize("version", ["", "4.0.0"])
def test_a_standard_library_that_is_not_there_is_said(tmp_path, monkeypatch, version):
    """Nor is the other one taken for it, which the library's own `uses` brings."""
    omc_of_paper(tmp_path, monkeypatch, version)
    with pytest.raises(MissingError, match=re.escape("Standard Library 4.1.0 is not installed")):
        findings("classes", Session("4.1.0", tmp_path / "work"))


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("", None),
        ("warns", "left voltageMin"),
        ("stops", "Simulation execution failed"),
        ("other", "from the stored result"),
        ("lacks", "is not in the result"),
    ],
)
def test_examples_are_compared_with_their_stored_results(tmp_path, monkeypatch, fault, said):
    omc_of_paper(tmp_path, monkeypatch, fault=fault)
    # in one of them a signal that does not change
    chosen = [n for n in EXAMPLES if n.endswith(("HysteresisLoop", "DisturbanceForce"))]
    monkeypatch.setattr(omc_acceptance, "EXAMPLES", chosen)
    found = findings("examples", Session("4.0.0", tmp_path / "work"))
    assert bool(found) == bool(said)
    assert all(said in finding for finding in found)


def test_a_result_has_its_constants_and_its_negated_signals(tmp_path, monkeypatch):
    omc_of_paper(tmp_path, monkeypatch)
    name = EXAMPLES[0]
    time, signals = stored_result(name)
    _, path = Session("4.0.0", tmp_path / "work").simulate("", name)
    result = read_result(path)
    assert set(result) == {"time", *signals}
    assert np.array_equal(result["time"], time)
    for label, values in signals.items():
        assert np.array_equal(result[label], values)


def test_a_slow_tick_is_a_finding(tmp_path, monkeypatch):
    """0.7 s in 200,000 ticks is too slow, 0.5 s is not."""
    omc_of_paper(tmp_path, monkeypatch, fault="slow")
    (found,) = findings("speed", Session("4.0.0", tmp_path / "work"))
    assert found == f"{omc_acceptance.PLANT}: a tick takes 3.50 us beyond its event"


def test_the_script_says_why_it_skips_and_which_omc_it_asks(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["omc_acceptance.py", "--only", "classes", "--msl", "4.0.0"])
    monkeypatch.setattr(omc_acceptance, "OMC", None)
    assert omc_acceptance.main() == 0
    assert capsys.readouterr().out.startswith("skipped: no omc")
    omc_of_paper(tmp_path, monkeypatch)
    assert omc_acceptance.main() == 1
    first, second, *_ = capsys.readouterr().out.splitlines()
    assert first == f"{tmp_path / 'omc'}: OpenModelica 1.26.0"
    assert second == "MSL 4.0.0, classes: 1 finding"


def test_what_omc_does_not_answer_is_a_finding(tmp_path, monkeypatch):
    monkeypatch.setattr(omc_acceptance, "OMC", sys.executable)  # not omc: it prints a syntax error
    (found,) = findings("examples", Session("4.0.0", tmp_path / "work"))
    assert "examples ended early: omc ended early" in found
