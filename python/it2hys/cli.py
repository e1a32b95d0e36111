"""The command line `it2hys`."""

import argparse
import json
import os
import shutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from it2hys.errors import InputError
from it2hys.support.numerals import parse_number
from it2hys.support.processes import without_threads

# modules that take long to import are imported by the commands that need them

# units in the CSV files that `simulate` writes; lengths are in um
UNITS_WRITTEN = {
    "voltage": "V", "force": "N", "temperature": "K", "saturated": "1", "outOfRange": "1",
}  # fmt: skip
# parameters that say for what a plant FMU holds
ENDS = ("voltageMin", "voltageMax", "displacementMin", "displacementMax")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, 1 for a finding, or 2 for bad usage or input."""
    options = _parser().parse_args(arguments)
    options.typed = list(sys.argv[1:] if arguments is None else arguments)
    without_threads()
    try:
        return options.command(options)
    except InputError as error:
        print(f"it2hys: error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("it2hys: interrupted", file=sys.stderr)
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="it2hys",
        description="Piezo hysteresis: identify a model and its inverse from records, as FMUs.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    build = _command(commands, "build", _build, "write both FMUs with the paper's Table 1")
    _add_output(build)
    _add_contents(build)

    identify = _command(commands, "identify", _identify, "identify the paper's model from records")
    _add_records(identify)
    _add_output(identify)
    identify.add_argument("--rules", type=int, metavar="L", help="number of rules (default: chosen)")
    identify.add_argument("--seed", type=int, default=0, help="seed of the random starts")
    identify.add_argument("--starts", type=int, metavar="N", default=36, help="starts at most")
    identify.add_argument(
        "--solver",
        metavar="NAME",
        default="levenberg-marquardt",
        help="for the fits on the whole records: levenberg-marquardt (default), trust-region, "
        "quasi-newton, gradient-descent (the paper's), ipopt or evolution",
    )
    identify.add_argument(
        "--max-iterations", type=int, metavar="N", default=600, help="of a fit on the whole records"
    )

    diagnose = _command(
        commands, "diagnose", _diagnose, "find the effects that a model lacks, and add them to it"
    )
    _add_records(diagnose)
    _add_output(diagnose)
    diagnose.add_argument(
        "--model", metavar="P.ssv", type=Path, help="start from this model (default: the paper's)"
    )
    diagnose.add_argument(
        "--declared",
        default="",
        metavar="EFFECT,...",
        help="effects that are in the model from the start, such as play,creep",
    )
    diagnose.add_argument(
        "--exclude",
        default="",
        metavar="EFFECT,...",
        help="effects that are kept out of the model",
    )
    diagnose.add_argument(
        "--sensor-curve",
        action="store_true",
        help="a static curve, where one is found, is the sensor's: the FMUs are without it",
    )
    diagnose.add_argument("--rules", type=int, metavar="L", help="number of rules (default: 3)")
    diagnose.add_argument("--seed", type=int, default=0, help="seed of the random starts")
    _add_workers(diagnose)

    package = _command(commands, "package", _package, "write both FMUs from a parameter set")
    package.add_argument("parameters", metavar="PARAMETERS.ssv", type=Path)
    _add_output(package)
    _add_contents(package)
    package.add_argument(
        "--c-header", action="store_true", help="write the model as a C header too, into DIR/embedded"
    )
    package.add_argument(
        "--modelica", action="store_true", help="write the set as a record for the Modelica library too"
    )

    package.add_argument(
        "--ssp",
        action="store_true",
        help="write the systems of inverse, plant and controller as SSP too",
    )

    modelica = _command(
        commands, "modelica", _modelica, "write the Modelica library, as a folder or an archive"
    )
    modelica.add_argument(
        "path", metavar="PATH", type=Path, help="a directory, or an archive that ends in .zip"
    )

    simulate = _command(commands, "simulate", _simulate, "run an FMU over signals from a CSV")
    simulate.add_argument("fmu", metavar="FMU", type=Path)
    simulate.add_argument("--input", required=True, metavar="U.csv", type=Path)
    simulate.add_argument("-o", "--output", required=True, metavar="Y.csv", type=Path)
    simulate.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter in SI units, such as initialDisplacement=1e-6; may be repeated",
    )
    simulate.add_argument("--json", action="store_true", help="print the outcome as JSON, no progress")
    _add_columns(simulate)

    sweep = _command(commands, "sweep", _sweep, "run all cases of a sweep scenario, in parallel")
    sweep.add_argument(
        "scenario",
        metavar="SCENARIO",
        help="a TOML file, a scenario of scenarios/, or a results.parquet to draw the report of",
    )
    sweep.add_argument("-o", "--output", metavar="DIR", type=Path, help="default: out/NAME")
    workers = sweep.add_mutually_exclusive_group()
    _add_workers(workers)
    workers.add_argument("--dask", metavar="ADDRESS", help="a Dask scheduler, such as tcp://host:8786")
    sweep.add_argument("--json", action="store_true", help="print the outcome as JSON, no progress")
    sweep.add_argument("--restart", action="store_true", help="discard what DIR holds")

    report = _command(commands, "report", _report, "draw the page of a report again")
    report.add_argument(
        "directory", metavar="DIR", type=Path, help="where identify, diagnose, run or sweep left one"
    )

    run = _command(commands, "run", _run, "run a scenario by name")
    run.add_argument("name", metavar="NAME", help="a scenario of scenarios/, or a TOML file")
    run.add_argument("-o", "--output", metavar="DIR", type=Path, help="default: out/NAME")
    _add_workers(run)
    return parser


def _command(
    commands: argparse._SubParsersAction, name: str, function: Callable, text: str
) -> argparse.ArgumentParser:
    parser = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
    parser.set_defaults(command=function)
    parser.add_argument("--quiet", action="store_true", help="no progress, no summary")
    return parser


def _add_output(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", required=True, metavar="DIR", type=Path)


def _add_contents(parser: argparse.ArgumentParser) -> None:
    """Add what an FMU is packaged with."""
    parser.add_argument(
        "--fmi",
        type=int,
        choices=(2, 3),
        help="write the FMUs of FMI 2.0 or of FMI 3.0 (NAME_fmi3.fmu) alone (default: both)",
    )
    parser.add_argument(
        "--no-terminals",
        dest="terminals",
        action="store_false",
        help="leave terminals and icon out of the FMUs, for tools on FMILibrary 3, which refuses them",
    )


def _add_workers(parser: argparse._ActionsContainer) -> None:
    text = "processes (default: one a processor)"
    parser.add_argument("--workers", type=int, metavar="N", default=os.cpu_count(), help=text)


def _add_columns(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--column",
        action="append",
        default=[],
        metavar="QUANTITY=NAME[:UNIT]",
        help="name of a column in the CSV, such as voltage=Vin:V; may be repeated",
    )


def _add_records(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("train", nargs="+", metavar="TRAIN.csv", type=Path)
    parser.add_argument("--validate", nargs="+", default=[], metavar="V.csv", type=Path)
    parser.add_argument("--test", nargs="+", default=[], metavar="T.csv", type=Path)
    parser.add_argument("--resample", action="store_true", help="mend gaps and jitter of the time base")
    parser.add_argument(
        "--allow-lead", action="store_true", help="accept a displacement that leads the voltage"
    )
    parser.add_argument(
        "--invert-displacement",
        action="store_true",
        help="flip the sign of the displacement, of a sensor that counts the other way",
    )
    parser.add_argument("--json", action="store_true", help="print report.json")
    _add_columns(parser)


def _columns(options: argparse.Namespace) -> dict:
    from it2hys.records import parse_column_option

    parsed = (parse_column_option(text) for text in options.column)
    return {quantity: (column, unit) for quantity, column, unit in parsed}


def _read_records(options: argparse.Namespace) -> tuple[list, list, list]:
    """Return training, validation and test records under names of their own."""
    from it2hys.records import check_roles, read_record

    roles = (options.train, options.validate, options.test)
    paths = [path for role in roles for path in role]
    for path in paths:
        if sum(path.resolve() == other.resolve() for other in paths) > 1:
            raise InputError(f"{path}: is given twice; a record has one role")
    columns = _columns(options)
    stems = [path.stem for path in paths]

    def read(path: Path):
        record = read_record(
            path,
            columns,
            options.resample,
            check_swapped=not options.allow_lead,
            invert_displacement=options.invert_displacement,
        )
        name = path.stem if stems.count(path.stem) == 1 else f"{path.parent.name}_{path.stem}"
        return replace(record, name=name)

    records = tuple([read(path) for path in role] for role in roles)
    check_roles(*records)
    return records


def _say(options: argparse.Namespace, *texts: object) -> None:
    if not options.quiet:
        print(*texts)


def _versions(options: argparse.Namespace) -> tuple[int, ...]:
    return (options.fmi,) if options.fmi else (2, 3)


def _build(options: argparse.Namespace) -> int:
    from it2hys.fmu.packaging import package
    from it2hys.model.parameters import table_1

    for path in package(table_1(), options.output, fmi=_versions(options), terminals=options.terminals):
        _say(options, path)
    return 0


def _package(options: argparse.Namespace) -> int:
    from it2hys.export.embedded import HEADER, write_embedded
    from it2hys.fmu.packaging import make_directory, native_directory, package
    from it2hys.model.parameters import read_ssv

    parameters = read_ssv(options.parameters)
    for path in package(
        parameters, options.output, fmi=_versions(options), terminals=options.terminals
    ):
        _say(options, path)
    if options.c_header:
        directory = make_directory(options.output / "embedded")
        write_embedded(parameters, directory, native_directory())
        _say(options, directory / HEADER)
    if options.modelica:
        from it2hys.export.modelica import write_record

        _say(options, write_record(parameters, options.output))
    if options.ssp:
        from it2hys.fmu.ssp import write_ssp

        for path in write_ssp(parameters, options.output, _versions(options)):
            _say(options, path)
    return 0


def _modelica(options: argparse.Namespace) -> int:
    from it2hys.export.modelica_release import write_release

    _say(options, write_release(options.path))
    return 0


def _identify(options: argparse.Namespace) -> int:
    from it2hys.identification import Options, check_rule_count, identify
    from it2hys.reports.pair_report import write_report
    from it2hys.reports.provenance import Provenance
    from it2hys.support.progress import progress_bar

    check_rule_count(options.rules)
    settings = Options(options.seed, options.starts, options.max_iterations, options.solver)
    train, validate, test = _read_records(options)
    with progress_bar(quiet=options.quiet or options.json) as progress:
        identification = identify(train, validate, test, options.rules, settings, progress)
    records = [*train, *validate, *test]
    provenance = Provenance.of_command(options.typed, options.seed)
    write_report(identification, records, options.output, provenance=provenance)
    _tell_report(options)
    return 0


def _tell_report(options: argparse.Namespace) -> None:
    """Print what the report in the output's directory says, or its JSON."""
    from it2hys.reports.page import PAGE
    from it2hys.reports.pair_report import REPORT, read_report
    from it2hys.reports.printed import printed

    path = options.output / REPORT
    if options.json:
        print(path.read_text(encoding="utf-8"), end="")
        return
    _say(options, printed(read_report(path)))
    _say(options, f"\nreport: {options.output / PAGE}")


def _effects(text: str) -> list[str]:
    """Return the names in a list that is separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def _diagnose(options: argparse.Namespace) -> int:
    from it2hys.diagnosis import RULES, diagnose
    from it2hys.identification import Options, check_rule_count
    from it2hys.model.parameters import read_ssv
    from it2hys.reports.pair_report import write_report
    from it2hys.reports.provenance import Provenance
    from it2hys.support.progress import progress_bar

    check_rule_count(options.rules)
    settings = Options(seed=options.seed)
    model = None if options.model is None else read_ssv(options.model)
    train, validate, test = _read_records(options)
    with progress_bar(quiet=options.quiet or options.json) as progress:
        diagnosis = diagnose(
            train,
            validate,
            test,
            model,
            declared=_effects(options.declared),
            excluded=_effects(options.exclude),
            rules=RULES if options.rules is None else options.rules,
            options=settings,
            progress=progress,
            workers=options.workers,
            sensor_curve=options.sensor_curve,
        )
    records = [*train, *validate, *test]
    files = [] if options.model is None else [options.model]
    provenance = Provenance.of_command(options.typed, options.seed, files)
    write_report(diagnosis, records, options.output, provenance=provenance)
    _tell_report(options)
    return 0


def _report(options: argparse.Namespace) -> int:
    from it2hys.sweeps.store import RESULTS

    if (options.directory / RESULTS).is_file():
        from it2hys.sweeps.report import write_sweep_report

        page, _ = write_sweep_report(options.directory / RESULTS, options.directory)
    else:
        from it2hys.reports.pair_report import draw_report

        page = draw_report(options.directory)
    _say(options, f"report: {page}")
    return 0


def _simulate(options: argparse.Namespace) -> int:
    from tqdm import tqdm

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
    outputs, messages = simulation.simulate(
        options.fmu,
        signals.values,
        start,
        lambda ticks: tqdm(ticks, disable=options.quiet or options.json),
    )
    columns = {
        name: (value, UNITS_WRITTEN.get(name, "um"))
        for name, value in {**signals.values, **outputs}.items()
    }
    write_signals(options.output, signals.time, columns)
    counts, sentences = _beyond(ends, signals.values, outputs)
    for message in [*messages, *sentences]:
        print(f"it2hys: {message}", file=sys.stderr)
    if options.json:
        said = {"output": str(options.output), "samples": len(signals.time), **counts}
        print(json.dumps({**said, "messages": [*messages, *sentences]}, indent=1))
        return 0
    _say(options, options.output)
    return 0


def _beyond(ends: dict, inputs: dict, outputs: dict) -> tuple[dict[str, int], list[str]]:
    """Return how many samples were out of range or out of reach, and sentences where any were."""
    from it2hys.reports.validity import out_of_range_sentence

    counts, sentences = {}, []
    if len(ends) == len(ENDS) and {"outOfRange", "displacement"} <= outputs.keys():
        outside, displacement = outputs["outOfRange"] != 0, outputs["displacement"]
        voltage = inputs.get("voltage", 0.0 * displacement)
        counts["samples_out_of_range"] = int(outside.sum())
        sentences.append(out_of_range_sentence(ends, outside, voltage, displacement, "um"))
    if "saturated" in outputs:
        saturated, samples = int((outputs["saturated"] != 0).sum()), len(outputs["saturated"])
        counts["samples_saturated"] = saturated
        if saturated:
            sentences.append(f"{saturated} of {samples} samples ask for more than can be reached.")
    return counts, [text for text in sentences if text]


def _assignment(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        return name, parse_number(value)
    except ValueError:
        raise InputError(f"--set {text}: must be NAME=VALUE with a number in SI units") from None


def _sweep(options: argparse.Namespace) -> int:
    from it2hys.experiments.scenario_files import find_scenario
    from it2hys.sweeps import read_sweep, run_sweep

    if options.scenario.endswith(".parquet"):
        from it2hys.sweeps.report import write_sweep_report

        path = Path(options.scenario)
        report, _ = write_sweep_report(path, options.output or path.parent)
        _say(options, f"report: {report}")
        return 0
    from it2hys.reports.provenance import Provenance

    file = find_scenario(options.scenario)
    scenario = read_sweep(file)
    outcome = run_sweep(
        scenario,
        options.output or Path("out") / scenario.name,
        options.workers,
        options.dask,
        options.restart,
        options.quiet or options.json,
        Provenance.of_command(options.typed, scenario.seed, [file, *scenario.fmu_files]),
    )
    if options.json:
        print(
            json.dumps(
                {name: str(v) if isinstance(v, Path) else v for name, v in vars(outcome).items()}
            )
        )
        return 0
    _say(options, outcome.summary)
    _say(options, f"table: {outcome.results}\nreport: {outcome.report}")
    return 0


def _run(options: argparse.Namespace) -> int:
    from it2hys.experiments.running import run_scenario

    outcome = run_scenario(options.name, options.output, options.quiet, options.workers)
    for table in outcome.tables:
        _say(options, f"\n{table.caption}\n{table.text()}")
    for text in outcome.conclusion:
        _say(options, f"\n{text}")
    _say(options, f"\nreport: {outcome.report}")
    _say(options, f"your own records, as CSV like those in {outcome.records}:")
    _say(options, f"  {_program()} {outcome.command}")
    return 0


def _program() -> str:
    """Return what to type for this command line: its path where it is not found by name."""
    path = Path(sys.argv[0])
    return str(path) if path.name == "it2hys" and not shutil.which(path.name) else "it2hys"
