"""Scenarios: an experiment described in a TOML file, run by name.

A scenario makes records on the simulated test stand, identifies a model or takes Table 1, drives the
stand through the inverse FMU, and sets its errors beside the paper's. `scenarios/demo.toml` shows
every key.
"""

import tempfile
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path

import numpy as np

from it2hys import excitations, figures
from it2hys.errors import InputError
from it2hys.identification import Identification, Options, identify
from it2hys.identification_report import ROLES, write_identification
from it2hys.metrics import max_relative_error, rms_error
from it2hys.packaging import package
from it2hys.progress import progress_bar
from it2hys.records import Record
from it2hys.report import Picture, Section, Table
from it2hys.rig import Stand
from it2hys.simulation import track

UM = 1e6
STAND_PARTS = ("dac", "amplifier", "hysteresis", "creep", "mechanics", "thermal", "gauge", "adc")
KEYS = {
    "": {"title", "seed", "rules", "stand", "record", "tracking"},
    "stand": {"without", "noise"},
    "tracking": {"signal", "duration", "lead_in", "paper"},
}
RECORD_KEYS = {"name", "role", "signal", "duration", "paper"}
PAPER_KEYS = {"e_mr_percent", "e_rms_um", "proportional_e_mr_percent"}


@dataclass(frozen=True)
class Outcome:
    """What a scenario leaves: tables for the terminal and the path of its report."""

    tables: list[Table]
    report: Path


def find_scenario(name: str) -> Path:
    """Return the file of a scenario: a path, or a name in ./scenarios or among those installed.

    Raises
    ------
    InputError
        If there is none; lists the names that there are.
    """
    if name.endswith(".toml"):
        return Path(name)
    folders = [Path("scenarios"), Path(str(files("it2hys") / "scenarios"))]
    for folder in folders:
        if (folder / f"{name}.toml").is_file():
            return folder / f"{name}.toml"
    known = sorted({path.stem for folder in folders for path in folder.glob("*.toml")})
    raise InputError(f"no scenario {name!r}; there are: {', '.join(known) or 'none'}")


def read_scenario(path: Path) -> dict:
    """Read and validate a scenario file.

    Raises
    ------
    InputError
        If the file is missing, is not TOML, or has a key that is unknown or missing; names the key.
    """
    try:
        scenario = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError:
        raise InputError(f"{path}: no such file, or it cannot be read") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not TOML: {error}") from None
    try:
        _validate(scenario)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return scenario


def _validate(scenario: Mapping) -> None:
    for section, keys in KEYS.items():
        table = scenario.get(section, {}) if section else scenario
        _require_keys(section or "the file", table, keys)
    if not scenario.get("record"):
        raise InputError("key 'record' is missing: a scenario needs at least one [[record]]")
    for i, record in enumerate(scenario["record"], start=1):
        for key in ("name", "role", "signal", "duration"):
            if key not in record:
                raise InputError(f"record {i}: key {key!r} is missing")
        if record["role"] not in ROLES:
            raise InputError(f"record {i}: role is {record['role']!r}; it must be one of {list(ROLES)}")
        _signal(record)
        _require_keys(f"record {i}, paper", record.get("paper", {}), PAPER_KEYS)


def _require_keys(place: str, table: Mapping, known: set[str]) -> None:
    for key in set(table) - known:
        raise InputError(f"{place}: unknown key {key!r}; known are {', '.join(sorted(known))}")


def _signal(table: Mapping) -> np.ndarray:
    """Evaluate the excitation that a table names; its other keys are the arguments."""
    function = getattr(excitations, table["signal"], None)
    if function is None or table["signal"].startswith("_"):
        raise InputError(f"signal {table['signal']!r} is not one of it2hys.excitations")
    arguments = {k: v for k, v in table.items() if k not in RECORD_KEYS | {"lead_in"}}
    try:
        return function(_time(table), **arguments)
    except TypeError as error:
        raise InputError(f"signal {table['signal']!r}: {error}") from None


def _time(table: Mapping) -> np.ndarray:
    return excitations.time_grid(table["duration"], 1e-4)


def _stand(scenario: Mapping) -> Stand:
    options = scenario.get("stand", {})
    without = options.get("without", [])
    for part in set(without) - set(STAND_PARTS):
        raise InputError(f"stand.without: unknown part {part!r}; known are {', '.join(STAND_PARTS)}")
    changes = dict.fromkeys(without)
    if "noise" in options:
        changes["noise"] = options["noise"]
    return replace(Stand(), **changes)


def run_scenario(name: str, directory: Path | None = None, quiet: bool = False) -> Outcome:
    """Run a scenario and write its results.

    Parameters
    ----------
    name : str
        Name or path of the scenario.
    directory : path, optional
        `out/NAME` by default.
    quiet : bool
        Show no progress bar.

    Raises
    ------
    InputError
        If the scenario is not usable.
    """
    path = find_scenario(name)
    scenario = read_scenario(path)
    directory = Path(directory or Path("out") / path.stem)
    stand, seed = _stand(scenario), scenario.get("seed", 0)
    entries = sorted(scenario["record"], key=lambda r: list(ROLES).index(r["role"]))
    records = [
        stand.record(_signal(entry), entry["name"], seed=seed + i) for i, entry in enumerate(entries)
    ]
    roles = {
        role: [r for r, e in zip(records, entries, strict=True) if e["role"] == role] for role in ROLES
    }
    with progress_bar(quiet) as progress:
        identification = identify(*roles.values(), scenario.get("rules"), Options(seed=seed), progress)
    sections = [_comparison(entries, identification)]
    if "tracking" in scenario:
        sections.append(_tracking(scenario["tracking"], identification, stand, seed, records[0]))
    report = write_identification(
        identification, records, directory, scenario.get("title", path.stem), sections
    )
    return Outcome([table for section in sections for table in section.tables], report)


def _comparison(entries: Sequence[Mapping], identification: Identification) -> Section:
    """Set the errors beside the paper's figures."""
    rows = []
    for entry, result in zip(entries, identification.records, strict=True):
        paper = entry.get("paper", {})
        rows.append(
            [
                result.name, ROLES[result.role],
                _figure(paper, "e_mr_percent"), _figure(paper, "e_rms_um"),
                f"{100 * result.e_mr_one_step:.2f}", f"{UM * result.e_rms_one_step:.4f}",
                f"{100 * result.e_mr:.2f}", f"{UM * result.e_rms:.4f}",
                f"{UM * result.noise_rms:.4f}",
            ]
        )  # fmt: skip
    table = Table(
        [
            "record", "role", "paper e_mr %", "paper e_rms µm",
            "one-step e_mr %", "one-step e_rms µm", "free-run e_mr %", "free-run e_rms µm",
            "noise µm",
        ],
        rows,
        "Model errors on the simulated stand, beside the published figures",
    )  # fmt: skip
    text = [
        "The published figures were measured on the paper's rig; ours are from the simulated stand. "
        "The paper does not say whether its errors are one step ahead or free run."
    ]
    return Section("Beside the published figures", text, [table])


def _figure(paper: Mapping, key: str) -> str:
    return f"{paper[key]:g}" if key in paper else "–"


def _tracking(
    entry: Mapping, identification: Identification, stand: Stand, seed: int, record: Record
) -> Section:
    """Drive the stand, and the plant FMU, through the inverse FMU; compare with a straight line."""
    reference, time = _signal(entry), _time(entry)
    start = {"initialDisplacement": float(reference[0])}
    with tempfile.TemporaryDirectory() as folder:
        package(identification.parameters, folder)
        inverse = Path(folder, "IT2Inverse.fmu")
        model = track(inverse, Path(folder, "IT2Plant.fmu"), reference, start)
        driven = track(inverse, stand.start(seed).step, reference, start)
    slope, offset = np.polyfit(record.voltage, record.displacement, 1)
    proportional = stand.run((reference - offset) / slope, seed=seed).measured
    kept = slice(round(entry.get("lead_in", 0.0) / 1e-4), None)
    paper = entry.get("paper", {})
    courses = [
        ("inverse FMU → plant FMU", model["displacement"], "–", "–"),
        ("inverse FMU → stand", driven["displacement"], _figure(paper, "e_mr_percent"), _figure(paper, "e_rms_um")),
        ("proportional → stand", proportional, _figure(paper, "proportional_e_mr_percent"), "–"),
    ]  # fmt: skip
    rows = [
        [
            name, mr, rms,
            f"{100 * max_relative_error(reference[kept], y[kept]):.3g}",
            f"{UM * rms_error(reference[kept], y[kept]):.3g}",
        ]
        for name, y, mr, rms in courses
    ]  # fmt: skip
    table = Table(
        ["feedforward", "paper e_mr %", "paper e_rms µm", "e_mr %", "e_rms µm"],
        rows,
        f"Tracking of {entry['signal']}",
    )
    picture = Picture(
        "tracking_stand",
        figures.tracking(
            time[kept],
            reference[kept],
            {
                "inverse FMU → stand": driven["displacement"][kept],
                "proportional": proportional[kept],
            },
            driven["voltage"][kept],
            "Feedforward on the stand",
        ),
        "Reference, displacement, error and voltage (compare the paper's Figure 7).",
    )
    text = [
        "The reference goes through IT2Inverse.fmu; its voltage drives the simulated stand and, for "
        "comparison, IT2Plant.fmu. Proportional feedforward divides by the slope of a straight line "
        "fitted to the training record."
    ]
    return Section("Feedforward tracking", text, [table], [picture])
