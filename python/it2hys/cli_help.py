"""What the command line says of itself: examples, lists of names, shell completion.

A command of the parser has a row in `EXAMPLES`.
"""

import argparse
import inspect
from collections.abc import Callable

#: Examples that the help of a command ends with.
EXAMPLES = {
    "build": """
it2hys build -o out/table_1
it2hys build -o out/table_1 --fmi 2 --no-terminals
""",
    "identify": """
it2hys identify train.csv minor_loops.csv --test test.csv -o out/mystage
it2hys identify train.csv --column voltage=Vin:V --column displacement=gauge:um -o out/mystage
it2hys identify train.csv.gz --resample --rules 3 -o out/mystage
""",
    "diagnose": """
it2hys diagnose train.csv minor_loops.csv --test test.csv -o out/diagnosis
it2hys diagnose train.csv --validate holds.csv --exclude lag,delay -o out/diagnosis
it2hys diagnose today.csv --model out/mystage/parameters.ssv -o out/today
it2hys diagnose new.csv --model out/diagnosis/parameters.ssv --design out/next/design.json -o out/told
it2hys diagnose train.csv --test test.csv --effect mount.py -o out/diagnosis
""",
    "design": """
it2hys design out/diagnosis/report.json -o out/next
it2hys design out/mystage/parameters.ssv --between delay,lag,play --noise 0.006 -o out/next
it2hys design out/diagnosis/report.json --slew 20000 --current 0.1 --capacitance 2e-6 -o out/next
it2hys design out/diagnosis/report.json --band 1,200 --periods 4 --duration 1.6 -o out/next
""",
    "package": """
it2hys package out/mystage/parameters.ssv -o out/systems --ssp
it2hys package out/mystage/parameters.ssv -o out/firmware --c-header
it2hys package out/mystage/parameters.ssv -o out/systems --effect out/mystage/mount.py
""",
    "effect": """
it2hys effect new mount
it2hys effect check mount.py
it2hys effect check mount.py --records train.csv minor_loops.csv
""",
    "simulate": """
it2hys simulate out/mystage/IT2Plant.fmu --input voltage.csv -o displacement.csv
it2hys simulate out/mystage/IT2Inverse.fmu --input y.csv -o u.csv --set initialDisplacement=1e-6
""",
    "sweep": """
it2hys sweep loop_map
it2hys sweep my_sweep.toml -o out/my_sweep --workers 4
it2hys sweep out/my_sweep/results.parquet
""",
    "run": """
it2hys run demo
it2hys run loop_map --workers 4 -o out/loops
it2hys run my_experiment.toml
""",
    "report": """
it2hys report out/mystage
""",
    "modelica": """
it2hys modelica ~/Documents/Modelica
it2hys modelica IT2Hysteresis.zip
""",
    "list": """
it2hys list
it2hys list effects
it2hys list scenarios --json
""",
    "completion": """
source <(it2hys completion bash)
it2hys completion zsh > ~/.zsh/completions/_it2hys
""",
    "help": """
it2hys help
it2hys help diagnose
""",
    "": """
it2hys run demo
it2hys identify train.csv --test test.csv -o out/mystage
it2hys list scenarios
""",
}


def examples(command: str) -> str | None:
    """Return the examples of a command as the end of its help."""
    lines = EXAMPLES.get(command, "").strip().splitlines()
    return "examples:\n" + "\n".join(f"  {line}" for line in lines) if lines else None


def listed(kind: str) -> list[dict[str, str]]:
    """Return the names of a kind and what each is, as rows of ``name`` and ``text``."""
    return [{"name": name, **rest} for name, rest in sorted(KINDS[kind]().items())]


def _scenarios() -> dict[str, dict[str, str]]:
    from it2hys.experiments.scenario_files import scenario_paths
    from it2hys.support.keys import read_toml

    tables = {path.stem: read_toml(path) for path in scenario_paths()}
    return {
        name: {
            "text": str(table.get("title", name)),
            "kind": "sweep" if "fmu" in table else "experiment",
        }
        for name, table in tables.items()
    }


def _effects() -> dict[str, dict[str, str]]:
    from it2hys.model.stages import EFFECTS, STAGES

    return {
        name: {"text": _first_line(type(effect)), "place": STAGES[name].value}
        for name, effect in EFFECTS.items()
    }


def _excitations() -> dict[str, dict[str, str]]:
    from it2hys.stand.excitations import SIGNALS

    return {
        name: {
            "text": _first_line(function),
            "arguments": ", ".join(list(inspect.signature(function).parameters)[1:]),
        }
        for name, function in SIGNALS.items()
    }


def _first_line(thing: object) -> str:
    """Return what a thing is, in the first line of its docstring."""
    line = (inspect.getdoc(thing) or "").split("\n")[0].removeprefix("Return ").rstrip(".")
    return line[:1].upper() + line[1:]


#: Kinds of names that can be listed, and the functions that return them.
KINDS: dict[str, Callable[[], dict[str, dict[str, str]]]] = {
    "scenarios": _scenarios,
    "effects": _effects,
    "excitations": _excitations,
}


def completion(parser: argparse.ArgumentParser, shell: str) -> str:
    """Return the script by which a shell completes the commands and options of a parser.

    Arguments that are paths, by their metavar, are completed as such, scenarios by their names too.
    """
    import shtab

    names = " ".join(row["name"] for row in listed("scenarios"))
    for action in _actions(parser):
        metavar = action.metavar if isinstance(action.metavar, str) else ""
        if metavar in ("NAME", "SCENARIO") and not action.option_strings:
            action.complete = {"bash": "_it2hys_scenarios", "zsh": f"({names})"}  # type: ignore[attr-defined]
        elif metavar == "DIR":
            action.complete = shtab.DIRECTORY  # type: ignore[attr-defined]
        elif metavar == "FMU" or "." in metavar:
            action.complete = shtab.FILE  # type: ignore[attr-defined]
    begin = f'_it2hys_scenarios() {{ compgen -W \'{names}\' -- "$1"; compgen -f -- "$1"; }}\n'
    return str(shtab.complete(parser, shell=shell, preamble=begin if shell == "bash" else ""))


def _actions(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    found = []
    for action in parser._actions:
        found.append(action)
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                found += _actions(command)
    return found
