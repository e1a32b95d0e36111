"""The library in OpenModelica: what only a Modelica tool can show.

    python tests/modelica/omc_acceptance.py [--msl 4.0.0] [--msl 4.1.0] [--only PART]

Run it where omc (1.25 or later), a C compiler and the Modelica Standard Library 4.0.0 or 4.1.0 are; MSL
may also be a directory that holds Modelica/package.mo. It checks every class with unit checking on,
simulates the examples and compares them with the stored results, compares plant and inverse with the
reference run that the FMUs carry, drives plants by their inverses at three rates in one model, provokes
the messages of bad input, builds models from defaults only, and times a tick. test_omc.py runs the same
in pytest. Exit code 0, or 1 with what was found.
"""

import argparse
import math
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.io import loadmat

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from combined import COMBINATIONS, PARTS, assert_physical, source_of  # noqa: E402
from compared import PACKAGE  # noqa: E402
from effects import with_effects  # noqa: E402
from library import (  # noqa: E402
    CLASSES,
    EXAMPLES,
    FMU_INVERSE,
    FMU_PLANT,
    INVERSE,
    LIBRARY,
    PLANT,
    differences,
    model,
)
from refused import BAD, parameters_of  # noqa: E402

from it2hys.export.modelica import format_record  # noqa: E402
from it2hys.fmu.reference_run import reference_run  # noqa: E402
from it2hys.model.chain import EFFECTS  # noqa: E402
from it2hys.model.parameters import ParameterSet, table_1  # noqa: E402

VERSIONS = ("4.0.0", "4.1.0")
OMC = shutil.which("omc")
BEGIN, END = "@@begin ", "@@end"
#: What a log says that must be silent.
LOUD = re.compile(r"\| *(?:warning|error|assert) *\||\b(?:Warning|Error):", re.IGNORECASE)
#: Share of the span.
EQUAL = 1e-12


class MissingError(Exception):
    """omc or a version of the standard library is not here."""


@dataclass
class Session:
    """One version of the standard library, and a directory to work in."""

    msl: str
    directory: Path

    def load(self) -> str:
        """Return the commands that load the standard library, this one and its test package."""
        if (Path(self.msl) / "Modelica" / "package.mo").is_file():
            first = f'loadFile("{(Path(self.msl) / "Modelica" / "package.mo").as_posix()}");'
        else:
            first = f'loadModel(Modelica, {{"{self.msl}"}});'
        files = (LIBRARY / "package.mo", PACKAGE)
        return "\n".join([first, *(f'loadFile("{file.as_posix()}");' for file in files), ""])

    def run(self, commands: dict[str, str], options: str = "") -> dict[str, str]:
        """Run commands in one omc; return what each printed, by name."""
        if not OMC:
            raise MissingError("no omc on the path")
        self.directory.mkdir(parents=True, exist_ok=True)
        script = [
            f'setCommandLineOptions("{options}");' if options else "",
            self.load(),
            "getErrorString();",
        ]
        for name, command in {"loaded": "getVersion(Modelica);", **commands}.items():
            script += [
                f'print("{BEGIN}{name}\\n");',
                command,
                "getErrorString();",
                f'print("{END}\\n");',
            ]
        path = self.directory / "session.mos"
        path.write_text("\n".join(script) + "\n", encoding="utf-8")
        done = subprocess.run(
            [OMC, path.name],
            cwd=self.directory,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            check=False,
        )
        printed = re.findall(rf"^{BEGIN}(.*?)\n(.*?)^{END}$", done.stdout, re.MULTILINE | re.DOTALL)
        answers = {name.strip(): text for name, text in printed}
        if set(answers) != {"loaded", *commands}:
            raise AssertionError(f"omc ended early: {done.stdout[-2000:]}{done.stderr[-2000:]}")
        # where the wanted version is not there, this library's `uses` has brought the other one
        version = re.search(r'"([\d.]*)', answers.pop("loaded"))
        if not version or not version[1] or (self.msl in VERSIONS and version[1] != self.msl):
            raise MissingError(
                f"the Modelica Standard Library {self.msl} is not installed; in omc: "
                f'installPackage(Modelica, "{self.msl}", exactMatch=true)'
            )
        return answers

    def simulate(self, source: str, name: str, settings: str = "") -> tuple[str, Path | None]:
        """Simulate a class, of a source text or of the library.

        Returns what was said, and the result, or None where the simulation has not finished. A MAT
        file: in a CSV, OpenModelica leaves out what does not change, such as a voltage that is 0.
        """
        prefix = re.sub(r"\W", "_", name)
        load = ""
        if source:
            (self.directory / f"{prefix}.mo").write_text(source, encoding="utf-8")
            load = f'loadFile("{prefix}.mo");\n'
        command = f'{load}simulate({name}, fileNamePrefix="{prefix}", outputFormat="mat"{settings});'
        said = self.run({"simulate": command})["simulate"]
        result = self.directory / f"{prefix}_res.mat"
        done = "simulation finished successfully" in said and result.is_file()
        return said, (result if done else None)


class Result(dict[str, np.ndarray]):
    """The signals of a result by name."""

    def __missing__(self, name: str) -> np.ndarray:
        """Say what is not there as a finding, not as an error of this script."""
        raise AssertionError(f"{name} is not in the result")


def read_result(path: Path) -> Result:
    """Return the signals of a result: all of them as long as the time, the constant ones, too.

    A MAT file of version 4: names stand in columns; `dataInfo` says for each in which matrix its row
    is (1: constants, else signals) and, by the number's sign, whether it is negated.
    """
    content = loadmat(path, chars_as_strings=False)
    names = ["".join(column).rstrip("\0 ") for column in content["name"].T]
    signals, constants = content["data_2"], content["data_1"]
    result = Result()
    for name, (matrix, row) in zip(names, content["dataInfo"][:2].T, strict=True):
        place = abs(int(row)) - 1
        values = np.full(signals.shape[1], constants[place, 0]) if matrix == 1 else signals[place]
        result[name] = -values if row < 0 else values
    return result


def at_ticks(result: Result, ticks: int, sample_time: float) -> Callable[[str], np.ndarray]:
    """Return a function from a variable to its values at the ticks: an event's last ones."""
    rows = np.searchsorted(result["time"], (np.arange(ticks) + 0.1) * sample_time) - 1
    return lambda name: result[name][rows]


def tick_settings(ticks: int, sample_time: float) -> str:
    """Return the arguments of `simulate` for so many ticks."""
    return f", stopTime={(ticks - 1) * sample_time!r}, numberOfIntervals={ticks - 1}, tolerance=1e-8"


# --- the parts: each yields what is wrong -------------------------------------------------------------


def check_classes(session: Session) -> Iterator[str]:
    """Check every class of the library and of its test package, with unit checking on."""
    session.directory.mkdir(parents=True, exist_ok=True)
    tests = re.findall(r"^  (?:function|block|model) (\w+)", PACKAGE.read_text(encoding="utf-8"), re.M)
    classes = [*CLASSES, *(f"{PACKAGE.parent.name}.{name}" for name in tests)]
    commands = {name: f"checkModel({name});" for name in classes}
    for name, said in session.run(commands, "--unitChecking").items():
        if f"Check of {name} completed successfully" not in said or LOUD.search(said):
            yield f"checkModel({name}): {said.strip()}"


def simulate_examples(session: Session) -> Iterator[str]:
    """Simulate every example in silence, and compare it with its stored result."""
    session.directory.mkdir(parents=True, exist_ok=True)
    for name in EXAMPLES:
        said, path = session.simulate("", name)
        if path is None or LOUD.search(said):
            yield f"{name}: {said.strip()}"
            continue
        result = read_result(path)
        yield from differences(name, result["time"], result.__getitem__)


def compare_examples(session: Session) -> Iterator[str]:
    """Simulate the examples that compare themselves."""
    session.directory.mkdir(parents=True, exist_ok=True)
    for name in EXAMPLES:
        said, path = session.simulate("", f"{PACKAGE.parent.name}.{name.rsplit('.', 1)[-1]}")
        if path is None or LOUD.search(said):
            yield f"{name}, in the test package: {said.strip()}"


def reference_source(block: str, parameters: ParameterSet, inputs: dict[str, np.ndarray]) -> str:
    """Return a model that hands a block the inputs of the FMU's reference run."""
    ticks, sample_time = len(inputs["force"]), parameters["sampleTime"]
    names = list(inputs)
    # a segment begins half a tick before its tick: which of two events comes first does not matter
    rows = [
        f"{(k - 0.5) * sample_time!r}, " + ", ".join(repr(float(inputs[n][k])) for n in names)
        for k in range(ticks)
    ]
    table = "; ".join(rows)
    wires = " ".join(f"block1.{n} = table1.y[{i}];" for i, n in enumerate(names, 1))
    return format_record(parameters, "Mine") + model(
        f"parameter Mine p; {block} block1(parameters=p, useForce=true, useTemperature=true); "
        f"Modelica.Blocks.Sources.CombiTimeTable table1(table=[{table}], "
        "smoothness=Modelica.Blocks.Types.Smoothness.ConstantSegments, "
        "extrapolation=Modelica.Blocks.Types.Extrapolation.HoldLastPoint);",
        re.sub(r"block1\.(force|temperature) = (.*?);", r"connect(\2, block1.\1);", wires),
    )


def equal_fmu(session: Session) -> Iterator[str]:
    """Compare plant and inverse, as FMU and pure, with the FMUs' reference run."""
    session.directory.mkdir(parents=True, exist_ok=True)
    sets = {"table_1": table_1(), "every effect": with_effects(tuple(EFFECTS), seed=11)}
    for label, parameters in sets.items():
        for kind, blocks in (("plant", (FMU_PLANT, PLANT)), ("inverse", (FMU_INVERSE, INVERSE))):
            inputs, outputs = reference_run(kind, parameters)
            for block in blocks:
                yield from unequal(session, f"{block}, {label}", block, parameters, inputs, outputs)


def unequal(
    session: Session, label: str, block: str, parameters: ParameterSet, inputs: dict, outputs: dict
) -> Iterator[str]:
    """Compare one block with the reference run; the FMU's master reads a tick at the next one."""
    ticks = len(inputs["force"])
    source = reference_source(block, parameters, inputs)
    said, path = session.simulate(source, "M", tick_settings(ticks, parameters["sampleTime"]))
    if path is None:
        yield f"{label}: {said.strip()}"
        return
    at = at_ticks(read_result(path), ticks, parameters["sampleTime"])
    for name, expected in outputs.items():
        found = at(f"block1.{name}")[:-1]
        apart = np.abs(found - expected[1:]).max() / max(float(np.ptp(expected)), 1e-300)
        if name in ("saturated", "outOfRange"):
            if np.count_nonzero(found != expected[1:]) > 1:
                yield f"{label}: {name} differs at {np.count_nonzero(found != expected[1:])} ticks"
        elif not apart <= EQUAL:
            yield f"{label}: {name} is {apart:.2g} of its span from the reference run"


#: Sample times of three pairs of inverse and plant in one model, and how long it runs.
RATES, PERIOD = (1e-4, 2e-4, 5e-4), 0.05


def pairs_source(inverse: str, plant: str) -> str:
    """Return a model of three pairs with effects, at different rates: the inverse drives the plant."""
    records, declarations, equations = "", "", ""
    for k, sample_time in enumerate(RATES, 1):
        parameters = with_effects(
            ("lag", "play", "creep", "resonance"), seed=11, sampleTime=sample_time
        )
        records += format_record(parameters, f"Mine{k}")
        declarations += (
            f"parameter Mine{k} p{k}; {inverse} inverse{k}(parameters=p{k}); "
            f"{plant} plant{k}(parameters=p{k}); "
        )
        equations += (
            f"inverse{k}.reference = p{k}.initialDisplacement + 1e-6*(1 - cos(40*time))^2; "
            f"connect(inverse{k}.voltage, plant{k}.voltage); "
        )
    return records + model(declarations, equations)


def pairs_apart(at: Callable[[float], Callable[[str], np.ndarray]]) -> Iterator[str]:
    """Compare reference and displacement of the three pairs at their ticks."""
    for k, sample_time in enumerate(RATES, 1):
        signal = at(sample_time)
        reference = signal(f"inverse{k}.reference")
        apart = np.abs(signal(f"plant{k}.displacement") - reference).max() / np.ptp(reference)
        if signal(f"inverse{k}.saturated").any() or not apart <= EQUAL:
            yield f"at {sample_time:g} s: displacement is {apart:.2g} of its span from the reference"


def identity(session: Session) -> Iterator[str]:
    """Drive plants by their inverses, FMU and pure in all pairs, at three rates in one model."""
    session.directory.mkdir(parents=True, exist_ok=True)
    for inverse in (FMU_INVERSE, INVERSE):
        for plant in (FMU_PLANT, PLANT):
            ticks = round(PERIOD / RATES[0]) + 1
            said, path = session.simulate(
                pairs_source(inverse, plant), "M", tick_settings(ticks, RATES[0])
            )
            if path is None:
                yield f"{inverse} and {plant}: {said.strip()[-600:]}"
                continue
            result = read_result(path)
            for finding in pairs_apart(
                lambda sample_time, r=result: at_ticks(r, round(PERIOD / sample_time), sample_time)
            ):
                yield f"{inverse} and {plant}, {finding}"


def messages(session: Session) -> Iterator[str]:
    """Provoke the messages of sets that are refused, of an input that is no number, of a left range."""
    session.directory.mkdir(parents=True, exist_ok=True)
    for name, (changes, message) in BAD.items():
        if any(math.isnan(v) for v in changes.values()) or name == "no sample time":
            continue  # no literal, and sample(0, 0)
        record = format_record(parameters_of(changes), "Mine")
        for block, who in ((FMU_PLANT, "stage (IT2Plant)"), (PLANT, "stage")):
            source = record + model(
                f"parameter Mine p; {block} stage(parameters=p);", "stage.voltage = 0;"
            )
            said, path = session.simulate(source, "M", ", stopTime=1e-3")
            if path is not None or f"{who}: {message}." not in " ".join(said.split()):
                yield f"{block}, {name}: {said.strip()[-600:]}"
    for block in (FMU_PLANT, PLANT):
        yield from input_messages(session, block)


def input_messages(session: Session, block: str) -> Iterator[str]:
    """Provoke the messages of a plant's input."""
    # by a parameter: the compiler would put an infinite literal into its C code
    source = model(
        f"parameter Real large=1e300; {block} stage;",
        "stage.voltage = if time > 1.5e-4 then large*large else 10;",
    )
    said, path = session.simulate(source, "M", ", stopTime=1e-3")
    if path is not None or "voltage must be a finite number" not in said:
        yield f"{block}, no number: {said.strip()[-600:]}"
    source = model(f"{block} stage;", "stage.voltage = 140*sin(300*time);")
    said, path = session.simulate(source, "M", ", stopTime=0.05")
    times = len(re.findall(r"M\.stage(?: \(IT2Plant\))?: the voltage left voltageMin", said))
    if path is None or times != 1:
        yield f"{block}, voltage left its range: said {times} times, with the block's name"


def defaults(session: Session) -> Iterator[str]:
    """Build every combination from defaults only, the plant and the inverse also as FMUs."""
    session.directory.mkdir(parents=True, exist_ok=True)
    for parts in COMBINATIONS:
        label = "-".join(p.name for p in parts)
        pure = source_of(parts)
        for source in dict.fromkeys((pure, pure.replace(".PureModelica", ""))):
            said, path = session.simulate(source, "M", tick_settings(30, 1e-4))
            if path is None:
                yield f"{label}: {said.strip()[-600:]}"
                continue
            try:
                assert_physical(parts, at_ticks(read_result(path), 30, 1e-4))
            except AssertionError as error:
                yield f"{label}: {error}"
    yield from full_range(session)


def full_range(session: Session) -> Iterator[str]:
    """Drive the default actuator by the default amplifier over 0..150 V."""
    parts = tuple(p for p in PARTS if p.name in ("amplifier", "actuator"))
    source = source_of(parts).replace("amplifier.u = 0;", "amplifier.u = 5 - 5*cos(125*time);")
    said, path = session.simulate(source, "M", tick_settings(600, 1e-4))
    if path is None:
        yield f"0..150 V: {said.strip()[-600:]}"
    elif read_result(path)["actuator.s_rel"].max() > 26e-6:
        yield f"0..150 V: {read_result(path)['actuator.s_rel'].max():g} m"


def modifications(session: Session) -> Iterator[str]:
    """Modify an element of the record in place, and hand over a record of another size."""
    session.directory.mkdir(parents=True, exist_ok=True)
    for block in (FMU_PLANT, PLANT):
        source = model(
            f"{block} quick; {block} slow(parameters(lagTimeConstant=1e-3));",
            "quick.voltage = 50; slow.voltage = 50;",
        )
        said, path = session.simulate(source, "M", tick_settings(20, 1e-4))
        if path is None:
            yield f"{block}, modified in place: {said.strip()[-600:]}"
            continue
        at = at_ticks(read_result(path), 20, 1e-4)
        if not (at("slow.displacement")[1:] < at("quick.displacement")[1:]).all():
            yield f"{block}: parameters(lagTimeConstant=1e-3) does not act"
        yield from vectors_without_counts(session, block)


def vectors_without_counts(session: Session, block: str) -> Iterator[str]:
    """Give vectors of other lengths in three ways: by name, in place, by a constructor."""
    vectors = "playThreshold={2,8}, playWeight={0.04,0.06}, creepGain={0.03}, creepTimeConstant={0.005}"
    table = "IT2Hysteresis.Parameters.Table1"
    source = model(
        f"parameter {table} stage({vectors}); {block} named(parameters=stage); {block} bare; "
        f"{block} placed(parameters({vectors})); {block} made(parameters={table}({vectors}));",
        " ".join(f"{n}.voltage = 50*sin(300*time)^2;" for n in ("named", "bare", "placed", "made")),
    )
    said, path = session.simulate(source, "M", tick_settings(60, 1e-4))
    if path is None:
        yield f"{block}, vectors without counts: {said.strip()[-600:]}"
        return
    found = {
        n: at_ticks(read_result(path), 60, 1e-4)(f"{n}.displacement")
        for n in ("named", "bare", "placed", "made")
    }
    apart = [n for n in ("placed", "made") if not np.allclose(found[n], found["named"], 1e-12, 1e-18)]
    if apart or np.allclose(found["bare"], found["named"], rtol=1e-3):
        yield f"{block}, vectors without counts: {apart or 'named'} does not act"


#: Ticks of a timed run, runs of which the quickest counts, seconds of a pure tick beyond its event.
TICKS, ROUNDS, LONGEST_TICK = 200_000, 3, 3e-6


def speed(session: Session) -> Iterator[str]:
    """Time the pure blocks beside a sample event with nothing in it, in turns."""
    session.directory.mkdir(parents=True, exist_ok=True)
    wave, event = (
        "50 + 45*sin(126*time)",
        "when sample(0, 1e-4) then y = 50 + 45*sin(126*time); end when;",
    )
    sources = {
        "event": model("discrete Real y(start=0, fixed=true);", event),
        PLANT: model(f"{PLANT} block1;", f"block1.voltage = {wave};"),
        INVERSE: model(f"{INVERSE} block1;", f"block1.reference = 1.4e-7*({wave});"),
    }
    settings = f', stopTime={TICKS * 1e-4!r}, numberOfIntervals=4, simflags="-noEventEmit"'
    took = dict.fromkeys(sources, math.inf)
    for name, source in list(sources.items()) * ROUNDS:
        said, _ = session.simulate(source, "M", settings)
        seconds = re.search(r"timeSimulation = ([\d.e+-]+)", said)
        if not seconds:
            yield f"{name}, timed: {said.strip()[-600:]}"
            return
        took[name] = min(took[name], float(seconds[1]))
    for block in (PLANT, INVERSE):
        tick = (took[block] - took["event"]) / TICKS
        if tick > LONGEST_TICK:
            yield f"{block}: a tick takes {tick * 1e6:.2f} us beyond its event"


PARTS_OF_ACCEPTANCE = {
    "classes": check_classes,
    "examples": simulate_examples,
    "test package": compare_examples,
    "equality": equal_fmu,
    "identity": identity,
    "messages": messages,
    "defaults": defaults,
    "modifications": modifications,
    "speed": speed,
}


def findings(part: str, session: Session) -> list[str]:
    """Return what a part finds; an answer that it cannot read is a finding, too."""
    found = []
    try:
        for finding in PARTS_OF_ACCEPTANCE[part](session):
            found.append(finding)  # those before an error are kept
    except AssertionError as error:
        found.append(f"{part} ended early: {error}")
    return found


def version() -> str:
    """Return what omc says that it is."""
    done = subprocess.run([OMC, "--version"], capture_output=True, encoding="utf-8", check=False)
    return done.stdout.strip() or f"no version: {done.stderr.strip()}"


def main() -> int:
    """Run all parts, and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--msl", action="append", help="version or directory; default: 4.0.0 and 4.1.0")
    parser.add_argument("--only", choices=PARTS_OF_ACCEPTANCE, action="append")
    arguments = parser.parse_args()
    if not OMC:
        print("skipped: no omc, OpenModelica's compiler, on the path; it must be 1.25 or later")
        return 0
    print(f"{OMC}: {version()}", flush=True)
    failed = False
    for msl in arguments.msl or VERSIONS:
        for part in arguments.only or PARTS_OF_ACCEPTANCE:
            with tempfile.TemporaryDirectory() as directory:
                try:
                    found = findings(part, Session(msl, Path(directory)))
                except MissingError as missing:
                    print(f"MSL {msl}, {part}: skipped, {missing}")
                    continue
            failed |= bool(found)
            outcome = f"{len(found)} finding{'s' * (len(found) > 1)}" if found else "passed"
            print(f"MSL {msl}, {part}: {outcome}", flush=True)
            for finding in found:
                print("  " + finding.replace("\n", "\n    "))
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
