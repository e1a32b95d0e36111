"""The command line `it2hys`: its options, and how it ends; `cli_commands` does the work."""

from __future__ import annotations

import argparse
import errno
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from it2hys.cli_commands import (
    do_build,
    do_check_effect,
    do_design,
    do_diagnose,
    do_identify,
    do_list,
    do_modelica,
    do_new_effect,
    do_package,
    do_report,
    do_run,
    do_simulate,
    do_sweep,
)
from it2hys.cli_help import KINDS, completion, examples
from it2hys.errors import InputError
from it2hys.support.numerals import parse_number
from it2hys.support.processes import (
    Terminated,
    ended_by_sigterm,
    temporary_files,
    without_threads,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, 1 for a finding, or 2 for bad usage or input."""
    try:
        try:
            return _execute(arguments)
        finally:
            sys.stdout.flush()  # else what nobody reads fails only when Python ends
    except OSError as error:
        if error.errno not in (errno.EPIPE, errno.ENOSPC):
            raise
        # what is left of the output goes nowhere: Python would fail again when it ends
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if error.errno == errno.EPIPE:  # as with `| head`: nobody reads on
            return 0
        print(
            f"{_red('it2hys: error:')} what it prints cannot be kept: the disk is full", file=sys.stderr
        )
        return 2


def _execute(arguments: Sequence[str] | None) -> int:
    options = make_parser().parse_args(arguments)
    options.typed = list(sys.argv[1:] if arguments is None else arguments)
    without_threads()
    try:
        with temporary_files(), ended_by_sigterm(), _own_effects(options):
            return options.command(options)
    except InputError as error:
        print(f"{_red('it2hys: error:')} {error}", file=sys.stderr)
        return 2
    except ModuleNotFoundError as error:
        if (missing := (error.name or "").partition(".")[0]) in ("", "it2hys"):
            raise
        print(
            f"{_red('it2hys: error:')} this needs the package {missing}, which is not installed: "
            f"pip install {missing}, or install it2hys with all that it needs",
            file=sys.stderr,
        )
        return 2
    except Terminated:
        print("it2hys: terminated", file=sys.stderr)
        return 143
    except KeyboardInterrupt:
        print("it2hys: interrupted", file=sys.stderr)
        return 130


@contextmanager
def _own_effects(options: argparse.Namespace) -> Iterator[None]:
    """Put the effects of `--effect` into the chain while a command runs."""
    if not getattr(options, "effect", None):
        yield
        return
    from it2hys.fmu.own_library import use_effects

    use_effects(options.effect)
    try:
        yield
    finally:
        use_effects(())


def _red(text: str) -> str:
    """Return a text in red on a terminal, unless NO_COLOR is set."""
    plain = not sys.stderr.isatty() or "NO_COLOR" in os.environ
    return text if plain else f"\033[31m{text}\033[0m"


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of all commands; the documentation's reference is made from it."""
    parser = argparse.ArgumentParser(
        prog="it2hys",
        description="Piezo hysteresis: identify a model and its inverse from records, as FMUs.",
        epilog=examples(""),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    build = _command(commands, "build", do_build, "write both FMUs with the paper's Table 1")
    _add_output(build)
    _add_effect(build)
    _add_contents(build)
    _add_json(build)

    identify = _command(commands, "identify", do_identify, "identify the paper's model from records")
    _add_records(identify)
    _add_output(identify)
    identify.add_argument("--rules", type=int, metavar="L", help="number of rules (default: chosen)")
    identify.add_argument("--seed", type=int, default=0, help="seed of the random starts")
    identify.add_argument(
        "--starts", type=int, metavar="N", default=36, help="largest number of starts"
    )
    identify.add_argument(
        "--solver",
        metavar="NAME",
        default="levenberg-marquardt",
        help="solver of the fits on whole records: levenberg-marquardt (default), trust-region, "
        "quasi-newton, gradient-descent (the paper's), ipopt or evolution",
    )
    identify.add_argument(
        "--max-iterations", type=int, metavar="N", default=600, help="most iterations of such a fit"
    )

    diagnose = _command(
        commands,
        "diagnose",
        do_diagnose,
        "find the effects that a model lacks, and add them to it",
    )
    _add_records(diagnose)
    _add_output(diagnose)
    diagnose.add_argument(
        "--model", metavar="P.ssv", type=Path, help="start from this model (default: the paper's)"
    )
    _add_effect(diagnose)
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
        help="attribute a static curve that is found to the sensor; the FMUs leave it out",
    )
    diagnose.add_argument(
        "--design",
        metavar="design.json",
        type=Path,
        help="that `design` wrote for this record: the effects that it is to tell apart are tested "
        "at a level of their own, and the report compares its promise with the result",
    )
    diagnose.add_argument("--rules", type=int, metavar="L", help="number of rules (default: 3)")
    diagnose.add_argument("--seed", type=int, default=0, help="seed of the random starts")
    _add_workers(diagnose)

    _add_design(commands)

    package = _command(commands, "package", do_package, "write both FMUs from a parameter set")
    package.add_argument(
        "parameters",
        metavar="PARAMETERS.ssv",
        type=Path,
        help="parameter set from `identify` or `diagnose`",
    )
    _add_output(package)
    _add_effect(package)
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
    _add_json(package)

    modelica = _command(
        commands,
        "modelica",
        do_modelica,
        "write the Modelica library, as a folder or an archive",
    )
    modelica.add_argument(
        "path", metavar="PATH", type=Path, help="a directory, or an archive that ends in .zip"
    )
    _add_effect(modelica)
    _add_json(modelica)

    _add_own(commands)

    simulate = _command(commands, "simulate", do_simulate, "run an FMU over signals from a CSV")
    simulate.add_argument(
        "fmu", metavar="FMU", type=Path, help="an FMU of FMI 2.0 or 3.0 with a sampleTime"
    )
    simulate.add_argument(
        "--input", required=True, metavar="U.csv", type=Path, help="signals at the FMU's sampleTime"
    )
    simulate.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="Y.csv",
        type=Path,
        help="CSV to write: signals and outputs",
    )
    simulate.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter in SI units, such as initialDisplacement=1e-6; may be repeated",
    )
    _add_json(simulate)
    _add_columns(simulate)

    _add_sweep(commands)

    report = _command(commands, "report", do_report, "draw the page of a report again")
    report.add_argument(
        "directory",
        metavar="DIR",
        type=Path,
        help="directory that identify, diagnose, design, run or sweep wrote",
    )
    _add_json(report)

    run = _command(commands, "run", do_run, "run a scenario by name, an experiment or a sweep")
    run.add_argument("name", metavar="NAME", help="a name from `it2hys list scenarios`, or a TOML file")
    run.add_argument("-o", "--output", metavar="DIR", type=Path, help="default: out/NAME")
    _add_workers(run)
    _add_json(run)

    names = _command(commands, "list", do_list, "list scenarios, effects and excitations by name")
    names.add_argument("kind", nargs="?", choices=tuple(KINDS), help="what is listed (default: all)")
    _add_json(names, "print the list as JSON")

    shell = _command(commands, "completion", _completion, "print the completion script for a shell")
    shell.add_argument("shell", choices=("bash", "zsh", "tcsh"), help="shell that the script is for")

    about = _command(commands, "help", _help, "show the help of a command")
    about.add_argument("topic", nargs="?", metavar="COMMAND", help="command to show the help of")
    return parser


def _add_design(commands: argparse._SubParsersAction) -> None:
    design = _command(
        commands,
        "design",
        do_design,
        "design the record to measure next, which decides between models",
    )
    design.add_argument(
        "source",
        metavar="REPORT.json|P.ssv",
        type=Path,
        help="report.json of `diagnose`, or a parameter set",
    )
    _add_output(design)
    _add_effect(design)
    design.add_argument(
        "--between",
        default="",
        metavar="EFFECT,...",
        help="effects to decide between (default: those that the report cannot tell apart)",
    )
    limits = design.add_argument_group("limits of the rig")
    limits.add_argument("--voltage", type=_pair, metavar="LOW,HIGH", help="voltage range, V")
    limits.add_argument(
        "--slew", dest="rate", type=_number, metavar="V_PER_S", help="fastest change, V/s"
    )
    limits.add_argument("--bandwidth", type=_number, metavar="HZ", help="bandwidth of the amplifier")
    limits.add_argument("--current", type=_number, metavar="A", help="largest current of the amplifier")
    limits.add_argument("--capacitance", type=_number, metavar="F", help="capacitance of the actuator")
    limits.add_argument(
        "--sample-time", type=_number, metavar="S", help="sample time; it must be the model's"
    )
    limits.add_argument("--duration", type=_number, metavar="S", help="duration of the record")
    limits.add_argument(
        "--periods", type=int, default=1, metavar="N", help="number of equal periods, to average over"
    )
    limits.add_argument(
        "--band", type=_pair, metavar="LOW,HIGH", help="band of the references to come, Hz"
    )
    design.add_argument(
        "--noise",
        type=_number,
        metavar="UM",
        help="noise of the sensor, µm rms (default: the report's)",
    )
    design.add_argument(
        "--family",
        action="append",
        default=[],
        metavar="NAME",
        help="allow only this kind of voltage: steps, multisine, chirp, reversals ...; may be repeated",
    )
    design.add_argument(
        "--check",
        type=int,
        default=0,
        metavar="N",
        help="diagnose N simulated records of every model, 10 to 100 s each (default: 0)",
    )
    design.add_argument(
        "--seed", type=int, default=0, help="seed of the search; the same seed gives the same record"
    )
    _add_json(design, "print design.json")


def _number(text: str) -> float:
    """Return a number of an option."""
    try:
        return parse_number(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None


def _pair(text: str) -> tuple[float, float]:
    """Return two numbers that a comma parts."""
    low, comma, high = text.partition(",")
    if not comma:
        raise argparse.ArgumentTypeError(f"{text!r} must be two numbers, LOW,HIGH")
    return _number(low), _number(high)


def _add_own(commands: argparse._SubParsersAction) -> None:
    own = commands.add_parser(
        "effect",
        help="begin or check an effect of your own",
        description="Begin or check an effect of your own: a Python file, which is code and is run.",
        epilog=examples("effect"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    actions = own.add_subparsers(required=True, metavar="ACTION", help="new or check")
    new = _command(actions, "new", do_new_effect, "write a working effect to start from", "effect")
    new.add_argument(
        "name", metavar="NAME", help="name of the effect: small letters, digits and underscores"
    )
    new.add_argument(
        "-o", "--output", metavar="FILE", type=Path, help="the file to write (default: NAME.py)"
    )
    _add_json(new)
    check = _command(actions, "check", do_check_effect, "check whether a file can be a stage", "effect")
    check.add_argument("effect", nargs=1, metavar="FILE", type=Path, help="the Python file; it is run")
    check.add_argument(
        "--records",
        nargs="+",
        default=[],
        metavar="CSV",
        type=Path,
        help="records over whose range it is checked (default: the range of the paper's stage)",
    )
    _add_columns(check)
    _add_json(check)


def _add_sweep(commands: argparse._SubParsersAction) -> None:
    sweep = _command(commands, "sweep", do_sweep, "run all cases of a sweep scenario, in parallel")
    sweep.add_argument(
        "scenario",
        metavar="SCENARIO",
        help="a TOML file, a name of `it2hys list scenarios`, or a results.parquet to draw again",
    )
    sweep.add_argument("-o", "--output", metavar="DIR", type=Path, help="default: out/NAME")
    workers = sweep.add_mutually_exclusive_group()
    _add_workers(workers)
    workers.add_argument("--dask", metavar="ADDRESS", help="a Dask scheduler, such as tcp://host:8786")
    _add_json(sweep)
    sweep.add_argument("--restart", action="store_true", help="discard what DIR holds")


def _command(
    commands: argparse._SubParsersAction,
    name: str,
    function: Callable,
    text: str,
    within: str | None = None,
) -> argparse.ArgumentParser:
    parser = commands.add_parser(
        name,
        help=text,
        description=text[0].upper() + text[1:] + ".",
        epilog=examples(within or name),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(command=function)
    how_much = parser.add_mutually_exclusive_group()
    how_much.add_argument("--quiet", action="store_true", help="print no progress and no summary")
    how_much.add_argument(
        "-v",
        "--verbose",
        action="store_true",
        help="print a line for every step instead of a bar, in pipes and files too",
    )
    return parser


class _Version(argparse.Action):
    """Prints the version; what knows it is loaded only then."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from it2hys import __version__

        print(f"it2hys {__version__}")
        parser.exit()


def _add_output(parser: argparse.ArgumentParser) -> None:
    text = "directory for the results; created if missing"
    parser.add_argument("-o", "--output", required=True, metavar="DIR", type=Path, help=text)


def _add_json(
    parser: argparse.ArgumentParser, text: str = "print the outcome as JSON, without progress"
) -> None:
    parser.add_argument("--json", action="store_true", help=text)


def _add_effect(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--effect",
        action="append",
        default=[],
        metavar="FILE",
        type=Path,
        help="an effect of your own (`it2hys effect`), a Python file, which is run; may be repeated",
    )


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
        help="leave terminals and icon out of the FMUs, which tools with FMILibrary 3 refuse",
    )


def _add_workers(parser: argparse._ActionsContainer) -> None:
    text = "worker processes (default: one per processor); 0: this process alone"
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
    parser.add_argument(
        "train", nargs="+", metavar="TRAIN.csv", type=Path, help="records that are fitted; .csv.gz too"
    )
    parser.add_argument(
        "--validate", nargs="+", default=[], metavar="V.csv", type=Path,
        help="records that are not fitted, and decide between models",
    )  # fmt: skip
    parser.add_argument(
        "--test", nargs="+", default=[], metavar="T.csv", type=Path,
        help="records that are only reported on: neither fitted nor used to decide",
    )  # fmt: skip
    parser.add_argument(
        "--resample",
        action="store_true",
        help="fill short gaps and remove jitter of the time base by interpolation",
    )
    parser.add_argument(
        "--allow-lead", action="store_true", help="accept a displacement that leads the voltage"
    )
    parser.add_argument(
        "--invert-displacement",
        action="store_true",
        help="invert the displacement's sign, for a sensor that counts the other way",
    )
    _add_json(parser, "print report.json")
    _add_columns(parser)


def _completion(options: argparse.Namespace) -> int:
    print(completion(make_parser(), options.shell))
    return 0


def _help(options: argparse.Namespace) -> int:
    topic = [] if options.topic is None else [options.topic]
    make_parser().parse_args([*topic, "--help"])
    return 0
