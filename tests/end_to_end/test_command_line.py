"""What every command does beside its work: help, names, what is refused first, how it ends."""

import gzip
import json
import os
import pty
import re
import resource
import shlex
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path

import numpy as np
import pytest

import it2hys
from it2hys.cli import main, make_parser
from it2hys.cli_help import EXAMPLES, completion
from it2hys.model.stages import EFFECTS
from it2hys.records import read_record, write_record
from it2hys.stand import Stand, excitations

SCENARIOS = Path(__file__).parents[2] / "scenarios"
COMMANDS = tuple(make_parser()._subparsers._group_actions[0].choices)
SWEEP = """
duration = {duration}
{more}
[fmu.plant]
source = "IT2Plant"
[signal.voltage]
signal = "sine"
frequency = 20.0
[[connections]]
from = "voltage"
to = "plant.voltage"
[[vary]]
of = "voltage.high"
range = [30.0, 60.0]
method = "random"
[[metric]]
kind = "max"
of = "plant.displacement"
"""


def it2hys_process(*arguments, cwd=None, **options):
    """Return a command in a process of its own, which can be ended from outside."""
    return subprocess.Popen(
        [sys.executable, "-m", "it2hys", *map(str, arguments)],
        cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options,
    )  # fmt: skip


def run(*arguments, cwd=None, **options):
    with it2hys_process(*arguments, cwd=cwd, **options) as process:
        out, error = process.communicate()
    return subprocess.CompletedProcess(arguments, process.returncode, out, error)


def refused(capsys, *arguments):
    """Return the one message of a command that is refused."""
    assert main([str(a) for a in arguments]) == 2
    said = capsys.readouterr()
    assert said.out == "" and len(said.err.splitlines()) == 1, said
    return said.err


def files(folder):
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*"))


def write_train(path, duration=0.06):
    time = excitations.time_grid(duration, 1e-4)
    write_record(path, Stand().record(excitations.identification(time), path.stem, seed=0))
    return path


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("built")
    assert main(["build", "-o", str(folder), "--quiet"]) == 0
    (folder / "u.csv").write_text("time_s,voltage_V\n0,1\n1e-4,2\n2e-4,3\n")
    return folder


# --- help, names, completion ----------------------------------------------------------------------


def test_the_version_is_printed_and_is_the_packages(capsys):
    with pytest.raises(SystemExit) as end:
        main(["--version"])
    assert end.value.code == 0
    assert capsys.readouterr().out == f"it2hys {it2hys.__version__}\n"
    assert re.fullmatch(r"\d+\.\d+\.\d+.*", it2hys.__version__)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_is_an_option_and_a_command_and_ends_with_examples(command, capsys):
    shown = []
    for arguments in ([command, "--help"], ["help", command]):
        with pytest.raises(SystemExit) as end:
            main(arguments)
        assert end.value.code == 0
        shown.append(capsys.readouterr().out)
    assert shown[0] == shown[1]
    assert re.search(rf"examples:\n(  .*it2hys {command}.*\n)+$", shown[0])
    # every argument says what it is for
    parser = make_parser()._subparsers._group_actions[0].choices[command]
    assert [a.dest for a in parser._actions if not a.help] == []


@pytest.mark.parametrize("line", [x for text in EXAMPLES.values() for x in text.strip().splitlines()])
def test_the_parser_takes_every_example(line):
    command = re.search(r"it2hys ([^>)]*)", line)[1]
    make_parser().parse_args(shlex.split(command))


def test_help_alone_is_that_of_the_program(capsys):
    with pytest.raises(SystemExit):
        main(["help"])
    assert "COMMAND" in capsys.readouterr().out


def test_everything_that_has_a_name_is_listed(capsys):
    assert main(["list", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    names = {kind: [row["name"] for row in rows] for kind, rows in found.items()}
    assert names["scenarios"] == sorted(p.stem for p in SCENARIOS.glob("*.toml"))
    assert names["excitations"] == sorted(excitations.SIGNALS)
    assert {"play", "creep", "hum"} <= set(names["effects"]) and len(names["effects"]) == 11
    assert all(row["text"] for rows in found.values() for row in rows)
    assert main(["list", "effects"]) == 0
    assert capsys.readouterr().out.startswith("effects:\n  creep")


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_a_script_of_completion_knows_commands_and_scenarios(shell):
    script = completion(make_parser(), shell)
    for word in (*COMMANDS, "loop_map"):
        assert word in script or (shell == "tcsh" and word == "loop_map"), word


def test_bash_completes_commands_options_and_scenarios(tmp_path):
    (tmp_path / "c.bash").write_text(completion(make_parser(), "bash"))
    test = "source c.bash; COMP_WORDS=({0}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); "
    test += "_shtab_it2hys; echo ${{COMPREPLY[@]}}"
    for typed, wanted in (("diag", "diagnose"), ("run loop", "loop_map"), ("build --qui", "--quiet")):
        line = test.format(f"it2hys {typed}")
        done = subprocess.run(["bash", "-c", line], cwd=tmp_path, capture_output=True, text=True)
        assert done.stdout.split() == [wanted], (typed, done)


# --- what is refused, and when --------------------------------------------------------------------


def cpu_seconds(*arguments):
    """Return what a command costs; processor time, which other work hardly lengthens."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run(*arguments)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def test_help_takes_a_fifth_of_a_second_and_a_refused_file_less_than_one(tmp_path):
    (tmp_path / "bad.csv").write_text("a,b\n1,2\n")
    bad, out = tmp_path / "bad.csv", tmp_path / "out"
    assert min(cpu_seconds("--help") for _ in range(3)) < 0.2
    for arguments in (
        ["identify", bad, "-o", out],
        ["diagnose", bad, "-o", out],
        ["package", bad, "-o", out],
        ["run", "nosuch"],
        ["sweep", "nosuch"],
    ):
        assert min(cpu_seconds(*arguments) for _ in range(3)) < 1.0, arguments


#: Every command that writes, with input that would be refused after the output.
WRITING = {
    "build": [],
    "identify": ["none.csv"],
    "diagnose": ["none.csv"],
    "design": ["none.ssv"],
    "package": ["none.ssv"],
    "simulate": ["none.fmu", "--input", "none.csv"],
    "run": ["demo"],
    "sweep": ["loop_map"],
}


@pytest.mark.parametrize("command", WRITING)
def test_an_output_that_will_not_do_is_refused_before_the_work(command, tmp_path, capsys, monkeypatch):
    (tmp_path / "file").write_text("mine")
    arguments = [command, *WRITING[command], "-o"]
    assert "is a file" in refused(capsys, *arguments, tmp_path / "file" / "out")
    # root may write everywhere but there
    assert "cannot be written to" in refused(capsys, *arguments, "/proc/it2hys/out")
    usage = os.statvfs(tmp_path)
    assert usage.f_bavail > 0
    monkeypatch.setattr("shutil.disk_usage", lambda _: type("U", (), {"free": 1000})())
    if command != "simulate":  # it is not known what this needs
        assert "MB are free" in refused(capsys, *arguments, tmp_path / "out")
    assert files(tmp_path) == ["file"]
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize("command", [["modelica"], ["report"], ["effect", "new", "mount", "-o"]])
def test_so_is_one_that_has_no_option(command, tmp_path, capsys):
    (tmp_path / "file").write_text("mine")
    for place in (tmp_path / "file" / "out", Path("/proc/it2hys/out")):
        said = refused(capsys, *command, place)
        assert str(place if command[0] != "effect" else place.parent) in said
    assert files(tmp_path) == ["file"] and (tmp_path / "file").read_text() == "mine"


def test_every_command_that_does_something_has_json(built, tmp_path, capsys):
    """One JSON document on standard output, and nothing else on either."""
    (tmp_path / "s.toml").write_text(SWEEP.format(duration="0.01", more="samples = 3"))
    sweep, effect = tmp_path / "s", tmp_path / "mount.py"
    written = {
        "build": (["build", "--fmi", 3, "-o", tmp_path / "b"], "written", "IT2Plant_fmi3.fmu"),
        "package": (["package", built / "parameters.ssv", "--fmi", 2, "-o", tmp_path / "p"],
                    "written", "IT2Plant.fmu"),
        "modelica": (["modelica", tmp_path / "m.zip"], "written", "m.zip"),
        "effect": (["effect", "new", "mount", "-o", effect], "written", "mount.py"),
        "run": (["run", tmp_path / "s.toml", "--workers", 0, "-o", sweep], "report", "report.html"),
        "sweep": (["sweep", sweep / "results.parquet"], "report", "report.html"),
        "report": (["report", sweep], "report", "report.html"),
        "simulate": (["simulate", built / "IT2Plant.fmu", "--input", built / "u.csv", "-o",
                      tmp_path / "y.csv"], "output", "y.csv"),
    }  # fmt: skip
    for command, key, name in written.values():
        assert main([*map(str, command), "--json"]) == 0
        said = capsys.readouterr()
        found = json.loads(said.out)[key]
        paths = [Path(p) for p in ([found] if isinstance(found, str) else found)]
        assert said.err == "" and name in [p.name for p in paths]
        assert all(p.exists() for p in paths)
    without = {
        name
        for name, command in make_parser()._subparsers._group_actions[0].choices.items()
        if "--json" not in command.format_help()
    }
    assert without == {"effect", "completion", "help"}  # it has commands of its own, which have it


def test_an_output_is_not_written_onto_an_input(built, tmp_path, capsys):
    signals = (built / "u.csv").read_text()
    said = refused(capsys, "simulate", built / "IT2Plant.fmu", "--input", built / "u.csv",
                   "-o", built / ".." / built.name / "u.csv")  # fmt: skip
    assert "would overwrite an input of this command" in said
    assert (built / "u.csv").read_text() == signals
    train = write_train(tmp_path / "train.csv")
    said = refused(capsys, "diagnose", train, "--model", built / "parameters.ssv", "-o", built)
    assert "would overwrite an input of this command" in said


def test_simulate_makes_the_directory_of_its_output(built, tmp_path):
    output = tmp_path / "a" / "b" / "y.csv"
    arguments = ["simulate", built / "IT2Plant.fmu", "--input", built / "u.csv", "-o", output]
    assert main([*map(str, arguments), "--quiet"]) == 0
    assert len(output.read_text().splitlines()) == 4


@pytest.mark.parametrize(
    ("toml", "words"),
    [
        (SWEEP.format(duration="1e9", more=""), ["duration is 1e+09 s", "shorten duration"]),
        (SWEEP.format(duration="0.1", more="samples = 1000000000"), ["samples = 1000000000"]),
        ('[[record]]\nname="a"\nrole="train"\nsignal="triangle"\nduration=1e9',
         ["record 1: ", "duration is 1e+09 s: 1e+13 samples", "shorten it"]),
    ],
)  # fmt: skip
def test_what_no_memory_holds_is_refused_before_any_work(toml, words, tmp_path, capsys):
    (tmp_path / "s.toml").write_text(toml)
    said = refused(capsys, "run", tmp_path / "s.toml", "-o", tmp_path / "out")
    for word in [str(tmp_path / "s.toml"), *words]:
        assert word in said
    assert files(tmp_path) == ["s.toml"]


def test_the_same_number_of_workers_is_refused_everywhere(tmp_path, capsys):
    train = write_train(tmp_path / "train.csv")
    (tmp_path / "s.toml").write_text(SWEEP.format(duration="0.01", more="samples = 3"))
    for command in (["diagnose", train], ["sweep", tmp_path / "s.toml"], ["run", "demo"]):
        said = refused(capsys, *command, "--workers", -1, "-o", tmp_path / "out")
        assert "--workers -1: must not be negative; 0 is this process alone" in said
    assert main(["sweep", str(tmp_path / "s.toml"), "--workers", "0", "-o", str(tmp_path / "out"),
                 "--quiet"]) == 0  # fmt: skip


def test_a_variable_that_is_misspelled_gets_the_one_that_is_meant(built, tmp_path, capsys):
    arguments = ["simulate", built / "IT2Plant.fmu", "--input", built / "u.csv",
                 "-o", tmp_path / "y.csv"]  # fmt: skip
    said = refused(capsys, *arguments, "--set", "initialDisplacment=1e-6")
    assert "did you mean 'initialDisplacement'?" in said
    (tmp_path / "s.toml").write_text(
        SWEEP.format(duration="0.1", more="").replace("plant.displacement", "plant.displacment")
    )
    said = refused(capsys, "run", tmp_path / "s.toml", "-o", tmp_path / "o")
    assert "did you mean 'displacement'?" in said


# --- records as programs write them ---------------------------------------------------------------


def test_a_gzipped_record_is_read_and_named_after_its_file(tmp_path):
    plain = write_train(tmp_path / "train.csv")
    packed = tmp_path / "train.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    record = read_record(packed)
    assert record.name == "train"
    np.testing.assert_array_equal(record.displacement, read_record(plain).displacement)


def test_windows_text_and_units_in_a_row_of_their_own_are_read(tmp_path):
    plain = write_train(tmp_path / "train.csv")
    body = plain.read_text().split("\n", 1)[1]
    expected = read_record(plain).displacement
    latin = tmp_path / "latin.csv"
    latin.write_bytes(("time [s],voltage [V],displacement [µm]\r\n" + body).encode("cp1252"))
    below = tmp_path / "below.csv"
    below.write_text("time,voltage,displacement\ns,V,µm\n" + body)
    other = tmp_path / "other.csv"
    other.write_text("t,U,y\n[s],[V],[um]\n" + body)
    names = {"time": "t", "voltage": "U", "displacement": "y"}
    for path, columns in ((latin, None), (below, None), (other, names)):
        np.testing.assert_array_equal(read_record(path, columns).displacement, expected)


def test_a_fault_below_a_row_of_units_names_its_line(tmp_path):
    plain = write_train(tmp_path / "train.csv")
    lines = plain.read_text().splitlines()
    lines[0:1] = ["time,voltage,displacement", "s,V,um"]
    lines[9] = "0.0007,abc,1"
    (tmp_path / "bad.csv").write_text("\n".join(lines))
    with pytest.raises(it2hys.InputError, match="line 10: column 'voltage' has 'abc'"):
        read_record(tmp_path / "bad.csv")
    lines[1] = "s,V,furlong"
    (tmp_path / "bad.csv").write_text("\n".join(lines))
    with pytest.raises(it2hys.InputError, match="line 2: 'furlong' is neither a number nor a unit"):
        read_record(tmp_path / "bad.csv")


@pytest.mark.parametrize(
    ("content", "kind"),
    [
        (b"PK\x03\x04rest", r"an Excel workbook \(.xlsx\)"),
        (b"\xd0\xcf\x11\xe0rest", "an old Excel workbook"),
        (b"\x1f\x8bno gzip", "cannot be unpacked as gzip"),
    ],
)
def test_a_file_that_is_no_text_is_called_what_it_is(content, kind, tmp_path):
    (tmp_path / "r.csv").write_bytes(content)
    with pytest.raises(it2hys.InputError, match=kind):
        read_record(tmp_path / "r.csv")


def test_names_of_effects_and_voltages_that_are_misspelled_get_the_ones_that_are_meant(
    built, tmp_path, capsys
):
    train = write_train(tmp_path / "train.csv")
    said = refused(capsys, "diagnose", train, "--declared", "plya", "-o", tmp_path / "out")
    assert "--declared plya: no such effect; did you mean 'play'? known are delay, " in said
    said = refused(capsys, "design", built / "parameters.ssv", "--between", "delay,lag",
                   "--family", "stesp", "-o", tmp_path / "out")  # fmt: skip
    assert "no family of voltages 'stesp'; did you mean 'steps'?" in said
    said = refused(capsys, "design", tmp_path / "report.json", "-o", tmp_path / "out")
    assert said == f"it2hys: error: {tmp_path / 'report.json'}: no such file\n"


def test_a_byte_order_mark_is_read_over_in_csv_and_toml(built, tmp_path):
    """Editors on Windows begin a file with it, and end lines their own way."""
    plain, marked = built / "u.csv", tmp_path / "marked.csv"
    marked.write_bytes(b"\xef\xbb\xbf" + plain.read_bytes().replace(b"\n", b"\r\n"))
    for signals in (plain, marked):
        output = tmp_path / f"y_{signals.stem}.csv"
        arguments = ["simulate", built / "IT2Plant.fmu", "--input", signals, "-o", output, "--quiet"]
        assert main([*map(str, arguments)]) == 0
    assert (tmp_path / "y_marked.csv").read_text() == (tmp_path / "y_u.csv").read_text()
    text = SWEEP.format(duration="0.01", more="samples = 2")
    (tmp_path / "s.toml").write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    arguments = ["run", tmp_path / "s.toml", "--workers", 0, "-o", tmp_path / "out", "--quiet"]
    assert main([*map(str, arguments)]) == 0
    assert (tmp_path / "out" / "results.parquet").is_file()


# --- full disks, ends from outside ----------------------------------------------------------------


@pytest.mark.parametrize("command", ["build", "package", "identify"])
def test_a_disk_that_is_full_gets_nothing_half_written(command, built, tmp_path):
    """A file may grow to 100 kB: the parameter set fits, the FMUs do not."""
    arguments = {
        "build": ["build"],
        "package": ["package", built / "parameters.ssv", "--ssp", "--c-header"],
        "identify": ["identify", write_train(tmp_path / "train.csv"), "--rules", 1],
    }[command]

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

    # what was there stays as it was
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "IT2Plant.fmu").write_text("before")
    before = files(tmp_path)
    for name in ("new/er", "old"):
        done = run(*arguments, "-o", tmp_path / name, preexec_fn=limit)
        assert done.returncode == 2, done.stderr
        assert "cannot be written" in done.stderr and len(done.stderr.splitlines()) == 1
        assert re.search(rf"{re.escape(str(tmp_path / name))}/(IT2|embedded)", done.stderr)
        assert files(tmp_path) == before
    assert (tmp_path / "old" / "IT2Plant.fmu").read_text() == "before"


@pytest.fixture
def disk(tmp_path):
    """Return a function that mounts a small disk, or gives it other limits."""
    place = tmp_path / "disk"
    place.mkdir()

    def mount(**limits):
        again = ["remount"] if place.is_mount() else []
        options = ",".join([*again, *(f"{name}={value}" for name, value in limits.items())])
        done = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", options, "tmpfs", place], capture_output=True, text=True
        )
        if done.returncode:
            pytest.skip(f"no disk of a few kB can be mounted here: {done.stderr.strip()}")
        return place

    yield mount
    if place.is_mount():
        subprocess.run(["umount", place], check=True)


def assert_full(done, place, kept=()):
    """Assert that a command ended over a full disk as it should, and left only what was there."""
    assert done.returncode == 2 and done.stdout == "", done.stderr
    assert "Traceback" not in done.stderr and len(done.stderr.splitlines()) == 1, done.stderr
    assert "No space left on device" in done.stderr and str(place) in done.stderr
    assert files(place) == [*kept]


@pytest.mark.parametrize("command", ["build", "package", "modelica", "simulate"])
def test_a_disk_that_really_is_full_gets_nothing_half_written(command, built, disk, tmp_path):
    """It has bytes left and no room for another file, or the file is larger than what is left."""
    (tmp_path / "u.csv").write_text(
        "time_s,voltage_V\n" + "".join(f"{1e-4 * k:.4f},{k % 100}\n" for k in range(1000))
    )
    few_files = {"size": "40m", "nr_inodes": 5}
    arguments, limits = {
        "build": (["build", "-o", "new"], few_files),
        "package": (
            ["package", built / "parameters.ssv", "--ssp", "--c-header", "-o", "new"],
            few_files,
        ),
        "modelica": (["modelica", "library.zip"], {"size": "64k"}),
        "simulate": (
            ["simulate", built / "IT2Plant.fmu", "--input", tmp_path / "u.csv", "-o", "y.csv"],
            {"size": "16k"},
        ),
    }[command]
    place = disk(**limits)
    assert_full(run(*arguments[:-1], place / arguments[-1]), place)


def test_a_sweep_whose_disk_is_full_goes_on_where_it_ended_once_there_is_room(disk, tmp_path):
    (tmp_path / "s.toml").write_text(SWEEP.format(duration="0.02", more="samples = 3"))
    place = disk(size="40m", nr_inodes=4)
    command = ["sweep", tmp_path / "s.toml", "--workers", 0, "-o", place]
    assert_full(run(*command), place, ["parts", "parts/000000.arrow", "parts/sweep.json"])
    disk(nr_inodes=100)
    done = run(*command, "-v")
    assert done.returncode == 0 and "results.parquet" in done.stdout
    assert "parts" not in files(place)


@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_a_disk_that_fills_up_during_a_fit_gets_nothing_half_written(command, disk, tmp_path):
    train, place = write_train(tmp_path / "train.csv", 0.1), disk(size="24m")
    arguments = [command, train, "--rules", 1, "-v", "-o", place / "out"]
    if command == "diagnose":
        arguments += ["--workers", 0, "--exclude", ",".join(name for name in EFFECTS if name != "hum")]
    with it2hys_process(*arguments) as process:
        begun = process.stderr.readline()  # the room was checked
        process.send_signal(signal.SIGSTOP)
        with pytest.raises(OSError, match="No space left"):
            (place / "others.bin").write_bytes(bytes(30_000_000))
        process.send_signal(signal.SIGCONT)
        out, error = process.communicate()
    assert "Traceback" not in error and not begun.startswith("it2hys: error")
    last = error.splitlines()[-1]
    assert_full(
        subprocess.CompletedProcess(arguments, process.returncode, out, last), place, ["others.bin"]
    )


def test_a_disk_that_is_too_small_is_refused_before_the_work(disk, tmp_path):
    place = disk(size="64k")
    done = run("identify", write_train(tmp_path / "train.csv"), "-v", "-o", place / "out")
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert f"{place / 'out'}: 0 MB are free, 20 MB may be needed; make room" in done.stderr
    assert files(place) == []


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_an_end_from_outside_leaves_no_temporary_folders(number, code, tmp_path):
    (tmp_path / "s.toml").write_text(SWEEP.format(duration="20.0", more="samples = 2000"))
    (tmp_path / "tmp").mkdir()
    for workers in (0, 2):
        command = ["sweep", tmp_path / "s.toml", "--workers", workers, "-o", tmp_path / "out"]
        own = {**os.environ, "TMPDIR": str(tmp_path / "tmp")}
        with it2hys_process(*command, env=own) as process:
            until = time.monotonic() + 60
            while not list((tmp_path / "tmp").glob("it2hys-*")) and time.monotonic() < until:
                time.sleep(0.05)
            assert process.poll() is None
            process.send_signal(number)
            try:
                out, error = process.communicate(timeout=10)
            except subprocess.TimeoutExpired:
                # Python drops an interrupt that comes while it tidies up after an import
                process.send_signal(number)
                out, error = process.communicate(timeout=60)
        # interrupted while it executes text, as dataclasses do, Python 3.11 ends by that signal in the
        # end; a shell calls that 130, too
        assert process.returncode in (code, *([-number] if number == signal.SIGINT else [])), error
        assert error.splitlines()[-1] in ("it2hys: terminated", "it2hys: interrupted") and out == ""
        until = time.monotonic() + 20  # a worker removes its own when its parent has ended
        while files(tmp_path / "tmp") and time.monotonic() < until:
            time.sleep(0.1)
        assert files(tmp_path / "tmp") == []


def test_an_identification_that_is_ended_leaves_no_directory(tmp_path):
    train = write_train(tmp_path / "train.csv", 0.3)
    with it2hys_process("identify", train, "-o", tmp_path / "a" / "b", "-v") as process:
        process.stderr.readline()  # the work has begun
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
    assert process.returncode == 143
    assert files(tmp_path) == ["train.csv"]


# --- what is shown meanwhile, and in the end ------------------------------------------------------


def on_a_terminal(*arguments, **environment):
    """Return what a command shows where standard error is a terminal."""
    master, screen = pty.openpty()
    termios.tcsetwinsize(screen, (24, 100))
    command = [sys.executable, "-m", "it2hys", *map(str, arguments)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=screen, env={**os.environ, **environment}
    ) as process:
        os.close(screen)
        shown = b""
        try:
            while piece := os.read(master, 4096):
                shown += piece
        except OSError:  # how Linux says that the other side is closed
            pass
        process.communicate()
    os.close(master)
    return shown.decode()


def test_progress_is_one_bar_on_terminals_and_nothing_in_pipes(built, tmp_path):
    (tmp_path / "s.toml").write_text(SWEEP.format(duration="0.01", more="samples = 4"))
    simulate = [
        "simulate",
        built / "IT2Plant.fmu",
        "--input",
        built / "u.csv",
        "-o",
        tmp_path / "y.csv",
    ]
    sweep = ["sweep", tmp_path / "s.toml", "--workers", 0, "--restart", "-o", tmp_path / "out"]
    # what it shows in pipes is seen where its last lines are
    identify = ["identify", write_train(tmp_path / "train.csv"), "--rules", 1, "-o", tmp_path / "i"]
    for command in (simulate, sweep, identify):
        shown = on_a_terminal(*command)
        assert re.search(r"100%\|█+\| \d\d:\d\d done", shown) and "it/s" not in shown
    for command in (simulate, sweep):
        assert run(*command).stderr == ""
        assert on_a_terminal(*command, "--quiet") == ""
    lines = run(*sweep, "-v").stderr.splitlines()
    assert re.fullmatch(r" +\d+\.\d s 100%  s: 4 of 4 cases", lines[-1])


def test_only_a_terminal_gets_colours():
    assert "\033" not in run("run", "nosuch").stderr
    assert on_a_terminal("run", "nosuch").startswith("\033[31mit2hys: error:\033[0m no scenario")
    assert "\033" not in on_a_terminal("run", "nosuch", NO_COLOR="1")


def test_a_command_ends_with_what_was_written_and_what_to_do_next(tmp_path):
    train = write_train(tmp_path / "a train.csv")
    done = run("build", "-o", tmp_path / "b").stdout.splitlines()
    written = [str(tmp_path / "b" / name) for name in files(tmp_path / "b")]
    assert sorted(done[: done.index("")]) == written and len(written) >= 3
    assert (
        done[-1].strip() == f"it2hys simulate {tmp_path / 'b' / 'IT2Plant.fmu'} --input U.csv -o Y.csv"
    )
    done = run("identify", train, "--rules", 1, "-o", tmp_path / "i")
    assert done.stderr == ""
    done = done.stdout.splitlines()
    assert done[-4] == f"report: {tmp_path / 'i' / 'report.html'}"
    assert done[-1].strip() == f"it2hys diagnose '{train}' -o DIR"


def test_run_takes_a_sweep_too(tmp_path):
    """Nine of the sixteen scenarios are sweeps."""
    (tmp_path / "s.toml").write_text(SWEEP.format(duration="0.01", more="samples = 3"))
    done = run("run", "s.toml", "--workers", 0, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert {"report.html", "results.parquet"} <= {p.name for p in (tmp_path / "out" / "s").iterdir()}
    assert "report: out/s/report.html" in done.stdout


BUFFERED = pytest.mark.parametrize("unbuffered", ["", "1"], ids=["buffered", "unbuffered"])


@BUFFERED
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_output_that_a_full_disk_does_not_take_is_one_message(unbuffered):
    environment = {**os.environ, "PYTHONUNBUFFERED": unbuffered}
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "it2hys", "list", "effects"], stdout=full, stderr=subprocess.PIPE,
            text=True, check=False, env=environment,
        )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr == "it2hys: error: what it prints cannot be kept: the disk is full\n"


@BUFFERED
@pytest.mark.parametrize("command", ["list effects", "--help"])
def test_a_reader_that_stops_is_no_error(command, unbuffered):
    done = subprocess.run(
        f"{shlex.quote(sys.executable)} -m it2hys {command} | true; echo ${{PIPESTATUS[0]}}",
        shell=True, executable="/bin/bash", capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONUNBUFFERED": unbuffered},
    )  # fmt: skip
    assert "Traceback" not in done.stderr and done.stdout == "0\n", done
