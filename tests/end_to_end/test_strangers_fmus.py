"""FMUs from strangers: `simulate` and `sweep` refuse bad ones in one message, before they run."""

import shutil
import stat
import zipfile
from pathlib import Path

import pytest

from it2hys.cli import main
from it2hys.cosimulation import archive, slave
from it2hys.errors import InputError

SIGNAL = "time_s,voltage_V\n0.0000,0\n0.0001,1\n0.0002,2\n"
SCENARIO = """
duration = 0.001
step = 1e-4
[fmu.stranger]
source = "stranger.fmu"
[signal.drive]
signal = "sine"
low = 0.0
high = 10.0
frequency = 100.0
[[connections]]
from = "drive"
to = "stranger.voltage"
[[metric]]
kind = "max"
of = "stranger.displacement"
"""


def link(name):
    entry = zipfile.ZipInfo(name)
    entry.create_system = 3  # Unix
    entry.external_attr = (stat.S_IFLNK | 0o777) << 16
    return entry


def named(name):
    entry = zipfile.ZipInfo("x")
    entry.filename = entry.orig_filename = name  # as it is: the constructor mends names
    return entry


# entries added to an FMU, and what is said of them
BAD_ENTRIES = {
    "absolute": ([named("/tmp/it2hys-escaped")], "'/tmp/it2hys-escaped' has an absolute path"),
    "drive": ([named("C:/escaped")], "'C:/escaped' has an absolute path"),
    "parent": ([named("resources/../../escaped")], "'resources/../../escaped' has a path that leaves"),
    "backslash": ([named("resources\\escaped")], "has a backslash in its path"),
    "link": ([link("resources/out")], "'resources/out' is a symbolic link"),
    "link to a folder": ([link("out"), named("out/escaped")], "'out' is a symbolic link"),
    "file as folder": ([named("blocked"), named("blocked/escaped")], "cannot be unpacked: "),
}


@pytest.fixture
def stranger(tmp_path, models, monkeypatch):
    """Return a copy of the plant FMU beside a signal and a scenario for it."""
    (tmp_path / "u.csv").write_text(SIGNAL, encoding="utf-8")
    (tmp_path / "sweep.toml").write_text(SCENARIO, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copy(models["plant"].path, tmp_path / "stranger.fmu"))


def simulate():
    return main(["simulate", "stranger.fmu", "--input", "u.csv", "-o", "y.csv", "--quiet"])


def sweep():
    return main(["sweep", "sweep.toml", "-o", "out", "--workers", "1", "--quiet"])


def edit_description(path, old, new):
    content = {}
    with zipfile.ZipFile(path) as fmu:
        content = {name: fmu.read(name) for name in fmu.namelist()}
    text = content["modelDescription.xml"].decode()
    assert old in text
    content["modelDescription.xml"] = text.replace(old, new).encode()
    with zipfile.ZipFile(path, "w") as fmu:
        for name, data in content.items():
            fmu.writestr(name, data)


def assert_refused(capsys, said):
    """Both commands end with code 2 and one message, and leave nothing."""
    for command in (simulate, sweep):
        assert command() == 2
        error = capsys.readouterr().err
        assert said in error and "stranger.fmu" in error
        assert len(error.strip().splitlines()) == 1
    assert {p.name for p in Path().iterdir()} == {"u.csv", "sweep.toml", "stranger.fmu"}


def test_these_commands_run_where_the_fmu_is_a_good_one(stranger, capsys):
    assert simulate() == 0 and sweep() == 0


@pytest.mark.parametrize("kind", BAD_ENTRIES)
def test_an_entry_that_leads_outside_is_refused(stranger, capsys, kind):
    entries, said = BAD_ENTRIES[kind]
    with zipfile.ZipFile(stranger, "a") as fmu:
        for entry in entries:
            fmu.writestr(entry, "../../outside")
    assert_refused(capsys, said)
    assert not Path("/tmp/it2hys-escaped").exists()


@pytest.mark.parametrize("name", ["../../..", "..", "a/b", r"a\b", "C:evil", ""])
def test_a_model_identifier_is_a_name_and_no_path(stranger, capsys, name):
    edit_description(stranger, 'modelIdentifier="IT2Plant"', f'modelIdentifier="{name}"')
    assert_refused(capsys, f"modelIdentifier is {name!r}; it must be the name of a binary")


def test_a_model_identifier_must_be_there(stranger, capsys):
    edit_description(stranger, 'modelIdentifier="IT2Plant"', "")
    assert_refused(capsys, "modelIdentifier is ''")


def test_a_library_outside_the_fmu_is_not_loaded(stranger, capsys, monkeypatch):
    monkeypatch.setattr(slave.fmi2, "FMU2Slave", lambda **_: pytest.fail("a library is loaded"))
    edit_description(stranger, 'modelIdentifier="', 'modelIdentifier="../../../../')
    assert simulate() == 2


def test_an_fmu_that_unpacks_to_too_much_is_refused_before(stranger, capsys):
    with zipfile.ZipFile(stranger, "a") as fmu:
        fmu.writestr("resources/bomb", b"")
        fmu.filelist[-1].file_size = 3 * 2**30  # as the directory of a bomb says
    assert_refused(capsys, "of 3.0 GiB together; 100000 files and 2 GiB are the limits")


def test_too_many_files_are_refused(stranger, capsys, monkeypatch):
    monkeypatch.setattr(archive, "MOST_FILES", 3)
    assert_refused(capsys, "3 files and 2 GiB are the limits")


def test_an_entry_that_is_longer_than_it_says_is_not_unpacked_beyond(stranger, tmp_path):
    """So that the sizes that an archive states are a bound."""
    with zipfile.ZipFile(stranger, "a", zipfile.ZIP_DEFLATED) as fmu:
        fmu.writestr("resources/bomb", bytes(10**7))
        fmu.filelist[-1].file_size = 10
    archive.check_archive(stranger)
    with pytest.raises(InputError, match=r"stranger\.fmu: cannot be unpacked: Bad CRC-32"):
        archive.unpack(stranger, tmp_path / "unpacked")
    assert (tmp_path / "unpacked" / "resources" / "bomb").stat().st_size <= 10


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('start="0.0001"', 'start="1_0e-5"', "variable 'sampleTime': start is '1_0e-5'"),
        ('start="0.0001"', 'start="٠.٠٠٠١"', "variable 'sampleTime': start is '٠.٠٠٠١'"),
        ('max="0.1"', 'max="much"', "max is 'much'; it must be a number"),
    ],
)
def test_numbers_of_a_description_are_numbers(stranger, capsys, old, new, said):
    edit_description(stranger, old, new)
    assert_refused(capsys, said)
