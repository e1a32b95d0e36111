"""What each command of the command line does.

A command takes its options and returns the exit code: 0, or 1 for a finding.
"""

from __future__ import annotations

import argparse
import json
import shlex
import shutil
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from it2hys.cli_help import KINDS, listed
from it2hys.errors import InputError
from it2hys.support.files import check_directory, check_file, gathered, make_directory
from it2hys.support.numerals import parse_number
from it2hys.support.processes import check_workers
from it2hys.support.progress import Progress, part, progress_bar

if TYPE_CHECKING:
    from it2hys.model.parameters import ParameterSet
    from it2hys.records import Record

# modules that take long to import are imported by the commands that need them

# units in the CSV files that `simulate` writes; lengths are in um
UNITS_WRITTEN = {
    "voltage": "V", "force": "N", "temperature": "K", "saturated": "1", "outOfRange": "1",
}  # fmt: skip
# parameters that say for what a plant FMU holds
ENDS = ("voltageMin", "voltageMax", "displacementMin", "displacementMax")


def _columns(options: argparse.Namespace) -> dict:
    from it2hys.records import parse_column_option

    parsed = (parse_column_option(text) for text in options.column)
    return {quantity: (column, unit) for quantity, column, unit in parsed}


def _read_records(options: argparse.Namespace) -> tuple[list, list, list]:
    """Return training, validation and test records under names of their own."""
    from it2hys.records import check_roles, read_record, record_name

    roles = (options.train, options.validate, options.test)
    paths = [path for role in roles for path in role]
    for path in paths:
        if sum(path.resolve() == other.resolve() for other in paths) > 1:
            raise InputError(f"{path}: this file is given twice; a record has one role")
    columns = _columns(options)
    stems = [record_name(path) for path in paths]

    def read(path: Path) -> Record:
        record = read_record(
            path,
            columns,
            options.resample,
            check_swapped=not options.allow_lead,
            invert_displacement=options.invert_displacement,
        )
        stem = record_name(path)
        name = stem if stems.count(stem) == 1 else f"{path.parent.name}_{stem}"
        return replace(record, name=name)

    train, validate, test = ([read(path) for path in role] for role in roles)
    check_roles(train, validate, test)
    return train, validate, test


def _say(options: argparse.Namespace, *texts: object) -> None:
    if not options.quiet:
        print(*texts)


def _tell(options: argparse.Namespace, outcome: dict, lines: Sequence[object]) -> bool:
    """Print what came out: JSON for a script, lines for a reader; return whether it is a reader."""
    if options.json:
        print(json.dumps(outcome, indent=1, default=str))
        return False
    for line in lines:
        _say(options, line)
    return True


def _versions(options: argparse.Namespace) -> tuple[int, ...]:
    return (options.fmi,) if options.fmi else (2, 3)


def _progress(options: argparse.Namespace) -> AbstractContextManager[Progress]:
    """Return the bar of a command, or what stands for it."""
    quiet = options.quiet or getattr(options, "json", False)
    return progress_bar(quiet, "lines" if options.verbose else "terminal")


def _next(options: argparse.Namespace, text: str, *commands: str) -> None:
    """End a command with what to do next."""
    _say(options, f"\n{text}")
    for command in commands:
        _say(options, f"  {_program()} {command}")


def do_build(options: argparse.Namespace) -> int:
    """Write both FMUs with the paper's Table 1."""
    check_directory(options.output)
    from it2hys.fmu.packaging import package
    from it2hys.model.parameters import table_1

    paths = package(table_1(), options.output, fmi=_versions(options), terminals=options.terminals)
    _tell_packaged(options, paths)
    return 0


def do_package(options: argparse.Namespace) -> int:
    """Write both FMUs of a parameter set, and what else is asked for."""
    check_directory(options.output)
    from it2hys.model.parameters import read_ssv

    parameters = read_ssv(options.parameters)
    with gathered(options.output) as folder:
        written = _packaged(options, parameters, folder)
    _tell_packaged(options, [options.output / path.relative_to(folder) for path in written])
    return 0


def _tell_packaged(options: argparse.Namespace, written: Sequence[Path]) -> None:
    """Print what was written, and how to run the plant among it."""
    if _tell(options, {"written": written}, written):
        plant = next(path for path in written if path.name.startswith("IT2Plant"))
        _next(
            options,
            "run the plant over a CSV of voltages:",
            f"simulate {shlex.quote(str(plant))} --input U.csv -o Y.csv",
        )


def do_modelica(options: argparse.Namespace) -> int:
    """Write the Modelica library."""
    from it2hys.export.modelica_release import write_release

    written = write_release(options.path)
    if _tell(options, {"written": [written]}, [written]):
        _next(
            options,
            "open it in a Modelica tool; to write a parameter set of your own for it:",
            "package PARAMETERS.ssv --modelica -o DIR",
        )
    return 0


def _packaged(options: argparse.Namespace, parameters: ParameterSet, folder: Path) -> list[Path]:
    """Write all that is asked for; return what to name of it."""
    from it2hys.fmu.packaging import package

    versions = _versions(options)
    written = package(parameters, folder, fmi=versions, terminals=options.terminals)
    if options.c_header:
        from it2hys.export.embedded import HEADER, write_embedded
        from it2hys.model.compiled import native_directory

        write_embedded(parameters, folder / "embedded", native_directory())
        written.append(folder / "embedded" / HEADER)
    if options.modelica:
        from it2hys.export.modelica import write_record

        written.append(write_record(parameters, folder))
    if options.ssp:
        from it2hys.fmu.ssp import write_ssp

        written += write_ssp(parameters, folder, versions)
    return written


def do_identify(options: argparse.Namespace) -> int:
    """Identify the paper's model from records, and write its report."""
    check_directory(options.output)
    train, validate, test = _read_records(options)
    # what takes long to load comes after what is refused most often
    from it2hys.identification import Options, check_rule_count, identify
    from it2hys.reports.pair_report import write_report
    from it2hys.reports.provenance import Provenance

    check_rule_count(options.rules)
    settings = Options(options.seed, options.starts, options.max_iterations, options.solver)
    records = [*train, *validate, *test]
    provenance = Provenance.of_command(options.typed, options.seed)
    with _progress(options) as progress:
        found = identify(train, validate, test, options.rules, settings, part(progress, 0.0, 0.9))
        with gathered(options.output) as folder:
            drawing = part(progress, 0.9, 1.0)
            write_report(found, records, folder, provenance=provenance, progress=drawing)
    if _tell_report(options):
        _next(options, "find what the model lacks:", f"diagnose {_given(options)} -o DIR")
    return 0


def _tell_report(options: argparse.Namespace) -> bool:
    """Print what the report in the output's directory says, or its JSON; tell which."""
    from it2hys.reports.page import PAGE
    from it2hys.reports.pair_report import REPORT, read_report
    from it2hys.reports.printed import printed

    path = options.output / REPORT
    if options.json:
        print(path.read_text(encoding="utf-8"), end="")
        return False
    _say(options, printed(read_report(path)))
    _say(options, f"\nreport: {options.output / PAGE}")
    return True


def _given(options: argparse.Namespace) -> str:
    """Return the records of a command as they are typed."""
    roles = (("", options.train), ("--validate", options.validate), ("--test", options.test))
    return " ".join(
        " ".join([*([option] if option else []), *(shlex.quote(str(path)) for path in paths)])
        for option, paths in roles
        if paths
    )


def _effects(text: str) -> list[str]:
    """Return the names in a list that is separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def do_diagnose(options: argparse.Namespace) -> int:
    """Find the effects that a model lacks, and write the report with the last model."""
    check_directory(options.output)
    check_workers(options.workers)
    if options.model is not None:
        check_file(options.output / "parameters.ssv", [options.model])
    train, validate, test = _read_records(options)
    from it2hys.diagnosis import RIVAL_FILES, RULES, diagnose
    from it2hys.identification import Options, check_rule_count
    from it2hys.model.parameters import read_ssv
    from it2hys.model.stages import own_effects
    from it2hys.reports.design_report import designed_voltage, read_design
    from it2hys.reports.pair_report import write_report
    from it2hys.reports.provenance import Provenance
    from it2hys.reports.summary import PAPER, START

    check_rule_count(options.rules)
    designed = None if options.design is None else read_design(options.design)
    settings = Options(seed=options.seed)
    model = None if options.model is None else read_ssv(options.model)
    records = [*train, *validate, *test]
    given = [path for path in (options.model, options.design) if path is not None]
    files = [*options.effect, *given]
    provenance = Provenance.of_command(options.typed, options.seed, files)
    promised = None if designed is None else (designed, designed_voltage(options.design, designed))
    rivals = options.output.glob(RIVAL_FILES)
    outdated = [rival for rival in rivals if not any(rival.samefile(path) for path in given)]
    start = PAPER if model is None else START
    with _progress(options) as progress:
        diagnosis = diagnose(
            train,
            validate,
            test,
            model,
            declared=_effects(options.declared),
            excluded=_effects(options.exclude),
            rules=RULES if options.rules is None else options.rules,
            options=settings,
            progress=part(progress, 0.0, 0.8),
            workers=options.workers,
            sensor_curve=options.sensor_curve,
            planned=() if designed is None else designed["names"],
        )
        with gathered(options.output, outdated) as folder:
            write_report(
                diagnosis,
                records,
                folder,
                provenance=provenance,
                start=start,
                progress=part(progress, 0.8, 1.0),
                promised=promised,
            )
    if _tell_report(options):
        if diagnosis.indistinguishable:
            _next(
                options,
                "design the record that tells them apart:",
                f"design {shlex.quote(str(options.output / 'report.json'))} -o DIR",
            )
        own = [options.output / f"{name}.py" for name in own_effects() if name in diagnosis.effects]
        needed = "".join(f" --effect {shlex.quote(str(path))}" for path in own)
        _next(
            options,
            "write systems of these FMUs, with feedforward and feedback:",
            f"package {shlex.quote(str(options.output / 'parameters.ssv'))}{needed} --ssp -o DIR",
        )
    return 0


def do_design(options: argparse.Namespace) -> int:
    """Design the record to measure next; 1 where none was found that decides."""
    check_directory(options.output)
    check_file(options.output / "voltage.csv", [options.source])
    from it2hys.designs.designing import design
    from it2hys.designs.hypotheses import question_of
    from it2hys.designs.limits import Wanted
    from it2hys.reports.courses import voltages_at_hand
    from it2hys.reports.design_report import DESIGN_JSON, DESIGN_PAGE, write_design
    from it2hys.reports.provenance import Provenance

    noise = None if options.noise is None else 1e-6 * options.noise
    question = question_of(options.source, _effects(options.between), noise)
    wanted = Wanted(
        options.voltage,
        options.rate,
        options.bandwidth,
        options.current,
        options.capacitance,
        options.sample_time,
        options.duration,
        options.periods,
        options.band,
    )
    with _progress(options) as progress:
        found = design(
            question,
            wanted,
            options.family,
            options.seed,
            voltages_at_hand(options.source, question.base["sampleTime"]),
            checked=options.check,
            progress=progress,
        )
    provenance = Provenance.of_command(options.typed, options.seed, [options.source])
    model = options.source if options.source.suffix == ".ssv" else options.source.with_name(
        "parameters.ssv"
    )  # fmt: skip
    with gathered(options.output) as folder:
        write_design(found, folder, provenance, shlex.quote(str(model)))
    if options.json:
        print((options.output / DESIGN_JSON).read_text(encoding="utf-8"), end="")
        return 0 if found.decides else 1
    for text in found.sentences:
        _say(options, text)
    for text in (*question.said, *found.limits.said):
        _say(options, f"  {text}")
    _say(options, f"\npage: {options.output / DESIGN_PAGE}")
    _next(
        options,
        f"play {options.output / 'voltage.csv'}, record the displacement, and:",
        f"diagnose NEW.csv --model {shlex.quote(str(model))} --design "
        f"{shlex.quote(str(options.output / DESIGN_JSON))} -o DIR",
    )
    return 0 if found.decides else 1


def do_report(options: argparse.Namespace) -> int:
    """Draw the page of a report again from what is in its directory."""
    check_directory(options.directory)
    from it2hys.sweeps.store import RESULTS

    if (options.directory / RESULTS).is_file():
        return _draw_sweep(options, options.directory / RESULTS, options.directory)
    from it2hys.reports.design_report import DESIGN_JSON, draw_design
    from it2hys.reports.pair_report import draw_report

    is_design = (options.directory / DESIGN_JSON).is_file()
    page = draw_design(options.directory) if is_design else draw_report(options.directory)
    _tell(options, {"report": page}, [f"report: {page}"])
    return 0


def do_new_effect(options: argparse.Namespace) -> int:
    """Write a working effect of the user's own to start from."""
    from it2hys.fmu.own_template import template
    from it2hys.model.own_loading import check_name
    from it2hys.model.stages import EFFECTS
    from it2hys.support.files import write_atomically

    check_name(options.name)
    if options.name in EFFECTS:
        raise InputError(f"{options.name}: there is an effect of this name already; choose another")
    path = options.output or Path(f"{options.name}.py")
    check_file(path)
    if path.exists():
        raise InputError(f"{path}: this file exists already; name another one with -o")
    make_directory(path.parent)
    write_atomically(path, template(options.name).encode())
    if _tell(options, {"written": [path]}, [path]):
        _next(options, "check whether it can be a stage:", f"effect check {shlex.quote(str(path))}")
    return 0


def do_check_effect(options: argparse.Namespace) -> int:
    """Check whether a file can be a stage; 1 where it cannot."""
    from it2hys.fmu.own_check import check_effect
    from it2hys.model.stages import own_effects
    from it2hys.records import read_record

    records = [read_record(path, _columns(options)) for path in options.records]
    (effect,) = own_effects().values()
    rows = check_effect(effect, records)
    width = max(len(row.what) for row in rows)
    good = all(row.good for row in rows)
    checks = [{"what": row.what, "good": bool(row.good), "found": row.found} for row in rows]
    lines = [f"{'ok  ' if row.good else 'FAIL'}  {row.what:{width}}  {row.found}" for row in rows]
    if _tell(options, {"effect": effect.name, "good": good, "checks": checks}, lines) and good:
        _next(
            options,
            "test it on records:",
            f"diagnose TRAIN.csv --effect {shlex.quote(str(options.effect[0]))} -o DIR",
        )
    return 0 if good else 1


def do_simulate(options: argparse.Namespace) -> int:
    """Run an FMU over the signals of a CSV file, and write its outputs."""
    check_file(options.output, [options.fmu, options.input])
    from it2hys.cosimulation import simulation
    from it2hys.cosimulation.slave import Slave
    from it2hys.records.signals import read_signals, write_signals

    start = dict(_assignment(text) for text in options.set)
    with Slave(options.fmu, start) as slave:
        names, sample_time = slave.names("input"), simulation.sample_time(slave)
        ends = {name: slave.get(name) for name in ENDS if name in slave.variables}
    signals = read_signals(options.input, names, columns=_columns(options))
    if abs(signals.sample_time / sample_time - 1) > 1e-3:
        raise InputError(
            f"{options.input}: sampled every {signals.sample_time:g} s, but the FMU's sampleTime is "
            f"{sample_time:g} s; resample the signals or identify a model at their rate"
        )
    with _progress(options) as progress:
        outputs, messages = simulation.simulate(options.fmu, signals.values, start, progress)
    columns = {
        name: (value, UNITS_WRITTEN.get(name, "um"))
        for name, value in {**signals.values, **outputs}.items()
    }
    make_directory(options.output.parent)
    write_signals(options.output, signals.time, columns)
    counts, sentences = _beyond(ends, signals.values, outputs)
    for message in [*messages, *sentences]:
        print(f"it2hys: {message}", file=sys.stderr)
    said = {"output": options.output, "samples": len(signals.time), **counts}
    _tell(options, {**said, "messages": [*messages, *sentences]}, [options.output])
    return 0


def _beyond(ends: dict, inputs: dict, outputs: dict) -> tuple[dict[str, int], list[str]]:
    """Return how many samples were out of range or out of reach, and sentences where any were."""
    from it2hys.reports.validity import out_of_range_sentence

    counts, sentences = {}, []
    if len(ends) == len(ENDS) and {"outOfRange", "displacement"} <= outputs.keys():
        outside, displacement = outputs["outOfRange"] != 0, outputs["displacement"]
        voltage = inputs.get("voltage", 0.0 * displacement)
        counts["samples_out_of_range"] = int(outside.sum())
        sentences.append(out_of_range_sentence(ends, outside, voltage, displacement))
    if "saturated" in outputs:
        saturated, samples = int((outputs["saturated"] != 0).sum()), len(outputs["saturated"])
        counts["samples_saturated"] = saturated
        if saturated:
            sentences.append(
                f"At {saturated} of {samples} samples the inverse was clamped (saturated)."
            )
    return counts, [text for text in sentences if text]


def _assignment(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        return name, parse_number(value)
    except ValueError:
        raise InputError(f"--set {text}: must be NAME=VALUE with a number in SI units") from None


def do_sweep(options: argparse.Namespace) -> int:
    """Run all cases of a sweep, or draw its page again from its table."""
    if options.scenario.endswith(".parquet"):
        table = Path(options.scenario)
        check_directory(options.output or table.parent)
        return _draw_sweep(options, table, options.output or table.parent)
    from it2hys.experiments.scenario_files import find_scenario

    path = find_scenario(options.scenario)
    directory = options.output or Path("out") / path.stem
    check_directory(directory)
    check_workers(options.workers)
    from it2hys.reports.provenance import Provenance
    from it2hys.sweeps import read_sweep, run_sweep

    scenario = read_sweep(path)
    with _progress(options) as progress:
        outcome = run_sweep(
            scenario,
            directory,
            options.workers,
            options.dask,
            options.restart,
            progress,
            Provenance.of_command(options.typed, scenario.seed, [path, *scenario.fmu_files]),
        )
    lines = [outcome.summary, f"table: {outcome.results}", f"report: {outcome.report}"]
    if _tell(options, vars(outcome), lines):
        drawn_from = shlex.quote(str(outcome.results))
        _next(options, "draw the report again from the table:", f"sweep {drawn_from}")
    return 0


def _draw_sweep(options: argparse.Namespace, table: Path, directory: Path) -> int:
    """Draw the page of a sweep again from its table."""
    from it2hys.sweeps.report import write_sweep_report

    page, _ = write_sweep_report(table, directory)
    _tell(options, {"report": page}, [f"report: {page}"])
    return 0


def do_run(options: argparse.Namespace) -> int:
    """Run a scenario: an experiment or a sweep."""
    from it2hys.experiments.scenario_files import find_scenario
    from it2hys.support.keys import read_toml

    path = find_scenario(options.name)
    if "fmu" in read_toml(path):  # as `it2hys.sweeps.is_sweep`, which takes a while to load
        more = {"scenario": options.name, "dask": None, "restart": False}
        return do_sweep(argparse.Namespace(**vars(options), **more))
    check_workers(options.workers)
    check_directory(options.output or Path("out") / path.stem)
    from it2hys.experiments.running import run_scenario

    with _progress(options) as progress:
        outcome = run_scenario(options.name, options.output, progress, options.workers)
    lines = [
        *(f"\n{table.caption}\n{table.text()}" for table in outcome.tables),
        *(f"\n{text}" for text in outcome.conclusion),
        f"\nreport: {outcome.report}",
    ]
    tables = [vars(table) for table in outcome.tables]
    if _tell(options, {**vars(outcome), "tables": tables}, lines):
        _next(
            options,
            f"do the same with your own records, CSVs like those in {outcome.records}:",
            outcome.command,
        )
    return 0


def do_list(options: argparse.Namespace) -> int:
    """List scenarios, effects and excitations."""
    kinds = KINDS if options.kind is None else [options.kind]
    found = {kind: listed(kind) for kind in kinds}
    if options.json:
        print(json.dumps(found, indent=1))
        return 0
    for kind, rows in found.items():
        print(f"{kind}:")
        width = max((len(row["name"]) for row in rows), default=0)
        for row in rows:
            more = row.get("kind") or row.get("arguments") or row.get("place")
            print(f"  {row['name']:{width}}  {row['text']}" + (f" ({more})" if more else ""))
    return 0


def _program() -> str:
    """Return what to type for this command line: its path where it is not found by name."""
    path = Path(sys.argv[0])
    return str(path) if path.name == "it2hys" and not shutil.which(path.name) else "it2hys"
