"""The FMU as a file: its parts agree, and checkers that we did not write accept it."""

import ctypes
import html
import re
import shutil
import struct
import subprocess
import sys
import zipfile
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlparse

import fmpy
import numpy as np
import pytest
from conftest import (
    MODELS,
    Instance,
    Master,
    Unpacked,
    make_set,
    moved_binary,
    package_models,
    percent_encoded,
    rewrite,
    run_python,
    trajectory,
)
from lxml import etree

from it2hys.cosimulation.slave import Slave
from it2hys.errors import InputError
from it2hys.fmu.model_description import IDENTIFIERS
from it2hys.fmu.packaging import package
from it2hys.fmu.platforms import PLATFORMS
from it2hys.model.parameters import ParameterSet, format_ssv, read_ssv, table_1
from it2hys.model.variables import load_table

SETS = ("table_1", "one_rule", "five_rules", "sixteen_rules")
ERROR = 3


@pytest.fixture(params=[f"{s}-{m}" for s in SETS for m in MODELS])
def any_fmu(request, packaged):
    """Return a parameter set and one of its FMUs: every set and model in turn."""
    name, model = request.param.split("-")
    parameters, unpacked = packaged[name]
    return parameters, unpacked[model]


def description_of(unpacked: Unpacked) -> etree._Element:
    return etree.parse(unpacked.directory / "modelDescription.xml").getroot()


def bits(value: float) -> bytes:
    return struct.pack("<d", value)


# --- checkers ----------------------------------------------------------------------------------


def fmutool_findings(path: Path, caplog: pytest.LogCaptureFixture, version: str = "2.0") -> list[str]:
    pytest.importorskip("fmu_manipulation_toolbox", reason="fmu-manipulation-toolbox is missing")
    from fmu_manipulation_toolbox.checker import get_checkers
    from fmu_manipulation_toolbox.operations import FMU

    fmu = FMU(str(path))
    checkers = [checker() for checker in get_checkers()]
    assert len(checkers) >= 2  # the schema and the rules that no schema can express
    with caplog.at_level("INFO", logger="fmu_manipulation_toolbox"):
        for checker in checkers:
            fmu.apply_operation(checker)
    assert f"This FMU seems to be compliant with FMI-{version}." in caplog.text
    return [r.getMessage() for r in caplog.records if r.levelname in ("WARNING", "ERROR")]


def test_fmutool_finds_nothing(any_fmu, capfd, caplog):
    assert fmutool_findings(any_fmu[1].path, caplog) == []


def test_fmutool_finds_nothing_in_the_controller(controller, capfd, caplog):
    assert fmutool_findings(controller.path, caplog) == []


# --- what no checker sees ----------------------------------------------------------------------


def test_model_identifier_is_the_binarys_name_on_every_platform(any_fmu):
    _, unpacked = any_fmu
    platforms = sorted((unpacked.directory / "binaries").iterdir())
    suffixes = {"linux": ".so", "win": ".dll", "darwin": ".dylib"}
    assert {p.name for p in platforms} <= {of_fmi2 for of_fmi2, _ in PLATFORMS.values()}
    assert fmpy.platform in [p.name for p in platforms]
    for platform in platforms:
        kind = next(k for k in ("linux", "darwin", "win") if k in platform.name)
        expected = unpacked.identifier + suffixes[kind]
        assert [p.name for p in platform.iterdir()] == [expected]
    assert unpacked.identifier in IDENTIFIERS.values()
    assert f"{unpacked.identifier}.c" in [p.name for p in (unpacked.directory / "sources").iterdir()]


def test_every_file_of_the_archive_has_its_place(any_fmu):
    _, unpacked = any_fmu
    with zipfile.ZipFile(unpacked.path) as archive:
        assert archive.testzip() is None
        names = archive.namelist()
        kinds = {info.compress_type for info in archive.infolist()}
    assert len(names) == len(set(names))
    assert {n.split("/")[0] for n in names} >= {
        "modelDescription.xml", "resources", "sources", "binaries", "documentation"
    }  # fmt: skip
    assert kinds <= {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}
    assert all("\\" not in n and not n.startswith("/") and ".." not in n for n in names)


# --- XML, binary and resources agree -----------------------------------------------------------


def test_the_binary_starts_from_the_xmls_start_values_bit_for_bit(any_fmu):
    parameters, unpacked = any_fmu
    root = description_of(unpacked)
    starts = {}
    for variable in root.iterfind("ModelVariables/ScalarVariable"):
        start = variable[0].get("start")
        if start is not None:
            starts[variable.get("name")] = start
    assert set(parameters) < set(starts)
    with Instance(unpacked) as instance:
        assert instance.made, instance.messages
        instance.fmu.setupExperiment()
        instance.fmu.enterInitializationMode()
        for name, start in starts.items():
            value = instance.get(name)
            assert bits(value) == bits(float(start)), name
            assert name not in parameters or bits(value) == bits(parameters[name]), name


def test_the_xml_lists_exactly_the_tables_variables(any_fmu):
    parameters, unpacked = any_fmu
    expected = load_table().of_model(unpacked.model, parameters.counts)
    assert [
        (v.name, v.valueReference, v.causality, v.variability, v.type, v.declaredType.name)
        for v in unpacked.description.modelVariables
    ] == [
        (v.name, v.value_reference, v.causality, v.variability, v.type.base, v.type.name)
        for v in expected
    ]
    assert [n for n in unpacked.variables if n.startswith("rule[")] == [
        n for n in parameters if n.startswith("rule[")
    ]


def test_resources_hold_the_set_that_the_xml_starts_from(any_fmu):
    parameters, unpacked = any_fmu
    path = unpacked.directory / "resources" / "parameters.ssv"
    assert path.read_text(encoding="utf-8") == format_ssv(parameters)
    read = read_ssv(path)
    assert read.name == parameters.name
    starts = {n: unpacked.variables[n].start for n in read}
    assert {n: bits(float(s)) for n, s in starts.items()} == {n: bits(v) for n, v in read.items()}


def test_the_set_beside_the_fmus_is_the_one_inside(packaged):
    for parameters, unpacked in packaged.values():
        beside = unpacked["plant"].path.with_name("parameters.ssv")
        assert beside.read_text(encoding="utf-8") == format_ssv(parameters)


def test_guids_tell_models_and_sets_apart(packaged):
    guids = [u.description.guid for _, unpacked in packaged.values() for u in unpacked.values()]
    assert len(set(guids)) == len(guids)


# --- what the XML says of each variable --------------------------------------------------------


def test_every_variable_has_a_type_reals_a_unit_and_lengths_a_display_unit(any_fmu):
    _, unpacked = any_fmu
    units = {u.name: {d.name: d for d in u.displayUnits} for u in unpacked.description.unitDefinitions}
    for variable in unpacked.description.modelVariables:
        assert variable.description, variable.name
        declared = variable.declaredType
        assert declared is not None, variable.name
        if variable.type != "Real":
            continue
        assert variable.unit == declared.unit
        assert variable.unit in units, variable.name
        assert (variable.displayUnit or None) == declared.displayUnit
        assert None not in (declared.min, declared.max, declared.nominal), variable.name
        assert float(declared.min) < float(declared.max)
        if variable.start is not None:
            assert float(declared.min) <= float(variable.start) <= float(declared.max)
        expected = {"m": "um", "m/V": "um/V", "s": "ms", "K": "degC"}.get(variable.unit)
        assert variable.displayUnit == expected, variable.name
        assert expected is None or expected in units[variable.unit]


def test_display_units_convert_as_their_names_say(model):
    """FMI 2.0: display value = factor * value + offset."""
    units = {d.name: d for u in model.description.unitDefinitions for d in u.displayUnits}
    shown = {n: float(d.factor) * 1.0 + float(d.offset) for n, d in units.items()}
    assert shown == {"um": 1e6, "um/V": 1e6, "ms": 1e3, "degC": 1.0 - 273.15}


def test_the_default_experiment_is_complete_and_in_whole_sample_times(any_fmu):
    parameters, unpacked = any_fmu
    experiment = unpacked.description.defaultExperiment
    assert float(experiment.startTime) == 0.0
    assert float(experiment.stepSize) == parameters["sampleTime"]
    ticks = float(experiment.stopTime) / parameters["sampleTime"]
    assert ticks == pytest.approx(round(ticks), rel=1e-12)
    assert ticks >= 1000
    assert float(experiment.tolerance) > 0


def test_outputs_depend_on_no_input_so_that_there_is_no_algebraic_loop(model):
    for unknown in model.description.outputs:
        assert unknown.dependencies == []


@pytest.fixture(params=["table_1", "with_history"])
def inverse_to_initialize(request, models, tmp_path):
    """Return an inverse without and one with memory that was somewhere before its first tick.

    The latter has a static curve, too.
    """
    if request.param == "table_1":
        return models["inverse"]
    # on its way to the start the voltage takes the first operator along, the second stays behind
    play = {"play[1].threshold": 2.0, "play[2].threshold": 30.0}
    play |= {"play[1].weight": 0.1, "play[2].weight": 0.1}
    history = {"initialDemagnetisation": -15.0, "initialExcursion": 60.0}
    history |= {"initialCreep": 1e-7, "initialCreepAge": 0.05}
    creep = {"creep[1].gain": 0.05, "creep[1].timeConstant": 0.1}
    curve = {f"nonlinearity.{n}": 2e-7 for n in ("quadratic", "cubic", "quartic")}
    curve |= {"displacementZero": 1e-7, "nonlinearity.minimum": -1e-6}
    values = {n: v for n, v in table_1().items() if n not in ("playCount", "creepCount")}
    values |= play | history | creep | curve
    parameters = ParameterSet(values, "with history").validate()
    return package_models(parameters, tmp_path)["inverse"]


def test_initial_outputs_depend_on_what_the_xml_says(inverse_to_initialize):
    """Each listed parameter moves the inverse's initial voltage; no other parameter does.

    Limits of the voltage do so only where they cut it off, the ends of the range only beyond them, the
    sensor's zero and the ends of a static curve only where an effect is there that counts from them.
    """
    unpacked = inverse_to_initialize
    (unknown,) = [u for u in unpacked.description.initialUnknowns if u.variable.name == "voltage"]
    listed = {v.name for v in unknown.dependencies}
    with Instance(unpacked) as instance:
        instance.fmu.setupExperiment()
        silent = {"saturation.minimum", "saturation.maximum", "voltageMin", "voltageMax"}
        silent |= {"displacementMin", "displacementMax"}
        if not float(unpacked.variables["nonlinearity.quadratic"].start):
            silent |= {"displacementZero", "nonlinearity.minimum", "nonlinearity.maximum"}
        instance.assign({"initialDisplacement": 3e-6, "resonance.damping": 0.1, "hum.frequency": 50.0})
        instance.assign({"saturation.minimum": -100.0, "saturation.maximum": 200.0})
        instance.fmu.enterInitializationMode()
        before = instance.get("voltage")
        moved = set()
        for variable in unpacked.description.modelVariables:
            if variable.causality != "output" and variable.type == "Real":
                value = instance.get(variable.name)
                other = {"resonance.frequency": 2500.0, "resonance.samplingZero": -0.1}
                tried = other.get(variable.name, value * 1.001 + 1e-12)
                instance.assign({variable.name: tried})
                if instance.get("voltage") != before:
                    moved.add(variable.name)
                instance.assign({variable.name: value})
    assert moved == listed - silent


@pytest.mark.parametrize(("start", "end"), [(-5e-6, "displacementMin"), (30e-6, "displacementMax")])
def test_beyond_the_range_the_initial_voltage_depends_on_its_end(models, start, end):
    unknowns = models["inverse"].description.initialUnknowns
    (unknown,) = [u for u in unknowns if u.variable.name == "voltage"]
    assert end in {v.name for v in unknown.dependencies}
    with Instance(models["inverse"]) as instance:
        instance.fmu.setupExperiment()
        instance.assign({"initialDisplacement": start, "voltageMin": -2000.0, "voltageMax": 2000.0})
        instance.fmu.enterInitializationMode()
        before, value = instance.get("voltage"), instance.get(end)
        instance.assign({end: value + 1e-8})
        assert instance.get("voltage") != before


# --- documentation -----------------------------------------------------------------------------

VOID = {"meta", "img", "br", "hr", "link", "input"}


class Page(HTMLParser):
    """Collects references and headings; complains about tags that do not match."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.references: list[str] = []
        self.text: list[str] = []

    def handle_starttag(self, tag, attrs):
        self.references += [value for name, value in attrs if name in ("href", "src")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def documentation_of(unpacked: Unpacked) -> str:
    """Return the text of an FMU's documentation, which is well-formed and whose links resolve."""
    folder = unpacked.directory / "documentation"
    page = Page()
    page.feed((folder / "index.html").read_text(encoding="utf-8"))
    page.close()
    assert page.open == []
    assert page.references
    for reference in page.references:
        url = urlparse(reference)
        assert not url.scheme, f"{reference} needs a network"
        assert (folder / unquote(url.path)).is_file(), reference
    for image in folder.glob("*.svg"):
        etree.parse(image)
    text = " ".join(page.text)
    assert [name for name in unpacked.variables if name not in text] == []
    return text


def test_the_documentation_is_well_formed_and_its_links_resolve(any_fmu):
    parameters, unpacked = any_fmu
    assert parameters.name in documentation_of(unpacked)


def rows_of(unpacked: Unpacked) -> dict[str, list[str]]:
    """Return the cells of the documentation's tables by the first one."""
    page = (unpacked.directory / "documentation/index.html").read_text(encoding="utf-8")
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", line) for line in page.splitlines()]
    return {re.sub("<.*?>", "", row[0]): row[1:] for row in rows if row}


def test_a_parameter_stands_in_the_unit_of_the_api_beside_the_one_that_is_shown(model):
    rows, variables = rows_of(model), model.variables
    shown = 0
    for name, variable in variables.items():
        if variable.causality != "parameter":
            continue
        value, unit, displayed, display_unit, _ = rows[name]
        if variable.type == "Real":
            assert float(value) == pytest.approx(float(variable.start), rel=1e-5), name
            declared = variable.declaredType.unit if variable.declaredType else None
            assert unit == (variable.unit or declared or "")
        if displayed:
            shown += 1
            assert display_unit in ("µm", "µm/V")
            assert float(displayed) == pytest.approx(1e6 * float(value), rel=1e-5)
    assert shown > 10


def test_the_example_in_the_documentation_runs(model):
    folder = model.directory / "documentation"
    page = (folder / "index.html").read_text(encoding="utf-8")
    code = html.unescape(re.search(r'<pre class="python">(.*?)</pre>', page, re.DOTALL)[1])
    name = model.description.coSimulation.modelIdentifier
    code = code.replace(f'"{name}.fmu"', repr(str(model.directory)))
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    value, unit = done.stdout.split()
    assert {"µm": 10 < float(value) < 17, "V": 50 < float(value) <= 110}[unit]
    assert "warning" not in (done.stdout + done.stderr).lower()


def test_the_picture_in_the_documentation_shows_loops(model):
    root = etree.parse(model.directory / "documentation/loop.svg").getroot()
    loops = root.findall("{*}polyline")
    assert len(loops) == 2
    for loop in loops:
        x, y = np.array([p.split(",") for p in loop.get("points").split()], dtype=float).T
        area = 0.5 * abs(np.sum(x[1:] * y[:-1] - x[:-1] * y[1:]))
        assert area > 0.02 * np.ptp(x) * np.ptp(y)  # not a line
        assert x.min() >= 70 and x.max() <= 400 and y.min() >= 15 and y.max() <= 265


def test_the_controllers_documentation_is_well_formed_and_names_all_variables(controller):
    assert "within voltageMin … voltageMax" in documentation_of(controller)


# --- packaging ---------------------------------------------------------------------------------


def test_packaging_twice_gives_the_same_bytes(tmp_path):
    for parameters in (table_1(), make_set(5, 5)):
        first = package(parameters, tmp_path / "a")
        second = package(parameters, tmp_path / "b")
        assert [p.name for p in first] == ["IT2Plant.fmu", "IT2Inverse.fmu", "parameters.ssv"]
        for one, other in zip(first, second, strict=True):
            assert one.read_bytes() == other.read_bytes()


def test_packaging_replaces_what_was_there_and_leaves_nothing_else(tmp_path):
    package(make_set(5, 5), tmp_path)
    paths = package(table_1(), tmp_path)
    assert sorted(tmp_path.iterdir()) == sorted(paths)
    assert dict(read_ssv(paths[-1])) == dict(table_1())


def test_a_directory_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("kept", encoding="utf-8")
    for place in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(InputError, match="directory cannot be created"):
            package(table_1(), place)
    assert (tmp_path / "file").read_text(encoding="utf-8") == "kept"


# --- a set that does not belong ----------------------------------------------------------------


@pytest.mark.parametrize("which", MODELS)
def test_a_tampered_parameter_file_is_refused(tmp_path, five_rules, which):
    copy = rewrite(five_rules[which], tmp_path / "copy")
    path = copy.directory / "resources" / "parameters.ssv"
    text = path.read_text(encoding="utf-8")
    assert 'value="110.0"' in text
    path.write_text(text.replace('value="110.0"', 'value="160.0"'), encoding="utf-8")
    with Instance(copy) as instance:
        assert not instance.made
        (message,) = instance.said(ERROR)
    assert str(path) in message
    assert "package the FMU anew" in message


@pytest.mark.parametrize("damage", ["missing", "empty", "truncated", "other set", "directory"])
def test_a_damaged_parameter_file_is_refused_and_named(tmp_path, five_rules, damage):
    copy = rewrite(five_rules["plant"], tmp_path / "copy")
    path = copy.directory / "resources" / "parameters.ssv"
    content = path.read_bytes()
    path.unlink()
    if damage == "directory":
        path.mkdir()
    elif damage != "missing":
        other = format_ssv(make_set(6, 5)).encode()
        path.write_bytes({"empty": b"", "truncated": content[:-30], "other set": other}[damage])
    with Instance(copy) as instance:
        assert not instance.made
        (message,) = instance.said(ERROR)
    assert "parameters.ssv" in message


# --- where the resources are -------------------------------------------------------------------


LOCATIONS = {
    "uri": lambda p: percent_encoded(p),
    "trailing slash": lambda p: percent_encoded(p) + "/",
    "one slash": lambda p: percent_encoded(p).replace("file://", "file:"),
    "localhost": lambda p: percent_encoded(p).replace("file://", "file://localhost"),
    "lower case escapes": lambda p: percent_encoded(p).replace("%C3%A4", "%c3%a4"),
    "not encoded": lambda p: f"file://{p}",
    "plain path": str,
    "plain path with slash": lambda p: f"{p}/",
}


@pytest.fixture(scope="module")
def awkward(five_rules, tmp_path_factory):
    """Return a plant in a path with spaces, umlauts and a percent sign, and its binary apart."""
    base = tmp_path_factory.mktemp("base") / "Prüfstand für Aktor ä 100%25 #1"
    return rewrite(five_rules["plant"], base), moved_binary(five_rules["plant"], base)


@pytest.mark.parametrize("form", LOCATIONS)
def test_resources_are_found_in_whatever_form_a_host_gives_their_location(five_rules, awkward, form):
    unpacked, library = awkward
    location = LOCATIONS[form](unpacked.directory / "resources")
    if form == "not encoded":  # what is not encoded must not look as if it were
        location = location.replace("%25", "%2525")
    with Instance(unpacked, resources=location, library=library) as instance:
        assert instance.made, instance.messages
        instance.initialize()
        assert instance.get("ruleCount") == 5
        assert instance.get("rule[5].q1") == float(five_rules["plant"].variables["rule[5].q1"].start)


@pytest.mark.parametrize("location", [None, "", "file:///nowhere/resources", "http://example.org/"])
def test_where_the_location_is_of_no_use_the_binary_finds_its_own_resources(awkward, location):
    unpacked, library = awkward
    with Instance(unpacked, resources=location) as instance:
        assert instance.made, instance.messages
    with Instance(unpacked, resources=location, library=library) as instance:
        assert not instance.made
        (message,) = instance.said(ERROR)
    assert "cannot be read" in message


def test_a_location_longer_than_any_path_is_survived(awkward):
    unpacked, library = awkward
    for location in ("file:///" + 5000 * "a", 100_000 * "/", "file://" + 3000 * "%41"):
        with Instance(unpacked, resources=location, library=library) as instance:
            assert not instance.made
            assert len(instance.said(ERROR)) == 1


# --- the host's locale -------------------------------------------------------------------------

COMMA = """
import locale, sys
locale.setlocale(locale.LC_ALL, "de_DE.UTF-8")
assert locale.localeconv()["decimal_point"] == ","
from pathlib import Path
from conftest import Unpacked, Instance
unpacked = Unpacked(Path(sys.argv[1]), Path(sys.argv[2]))
with Instance(unpacked) as instance:
    instance.initialize()
    for name, variable in unpacked.variables.items():
        if variable.causality == "parameter":
            assert instance.get(name) == float(variable.start), name
print("same")
"""


def test_a_host_with_a_decimal_comma_reads_the_same_parameters(tmp_path, five_rules):
    localedef = shutil.which("localedef")
    if localedef is None:
        pytest.skip("needs localedef of the C library")
    made = subprocess.run(
        [localedef, "-i", "de_DE", "-f", "UTF-8", str(tmp_path / "de_DE.UTF-8")],
        capture_output=True,
        text=True,
        check=False,
    )
    if not (tmp_path / "de_DE.UTF-8").is_dir():
        pytest.skip(f"no German locale can be made here: {made.stderr.strip()}")
    path = five_rules["plant"].path
    assert run_python(COMMA, path, tmp_path / "fmu", LOCPATH=str(tmp_path)) == "same\n"


# --- two sets in one process -------------------------------------------------------------------


def test_fmus_of_different_sets_do_not_disturb_each_other(packaged, tmp_path):
    """One binary file name, loaded from several places at once."""
    alone = {name: trajectory(unpacked["plant"]) for name, (_, unpacked) in packaged.items()}
    masters = {name: Master(unpacked["plant"]) for name, (_, unpacked) in packaged.items()}
    try:
        together = {name: trajectory(unpacked["plant"]) for name, (_, unpacked) in packaged.items()}
    finally:
        for master in masters.values():
            master.instance.close()
    assert together == alone
    assert len(set(alone.values())) == len(alone)


def test_an_fmu_in_a_directory_with_umlauts_can_be_packaged_and_run(tmp_path):
    unpacked = package_models(make_set(7, 2), tmp_path / "Größe µm")["plant"]
    with Master(unpacked) as master:
        assert np.isfinite(master.run([10.0, 20.0])).all()


def test_the_library_can_be_loaded_without_fmpy(model):
    library = ctypes.CDLL(str(model.binary))
    library.fmi2GetVersion.restype = library.fmi2GetTypesPlatform.restype = ctypes.c_char_p
    assert library.fmi2GetVersion() == b"2.0"
    assert library.fmi2GetTypesPlatform() == b"default"


# --- the binary of this processor --------------------------------------------------------------


def with_binaries_moved(unpacked: Unpacked, path: Path, fallback: bytes | None) -> Path:
    """Return a copy whose binary is in the folder of the tuple; in that of FMI 2.0, what is given."""
    name = unpacked.binary.name
    with zipfile.ZipFile(unpacked.path) as old, zipfile.ZipFile(path, "w") as new:
        for entry in old.namelist():
            if not entry.startswith("binaries/"):
                new.writestr(entry, old.read(entry))
        new.write(unpacked.binary, f"binaries/{fmpy.platform_tuple}/{name}")
        if fallback is not None:
            new.writestr(f"binaries/{fmpy.platform}/{name}", fallback)
    return path


@pytest.mark.parametrize("fallback", [None, b"code of another processor"])
def test_a_run_takes_the_binary_for_this_very_processor(models, tmp_path, fallback):
    """FMI 2.0's names are for x86 only: elsewhere they are of what this processor cannot run."""
    path = with_binaries_moved(models["plant"], tmp_path / "moved.fmu", fallback)
    with Slave(path) as moved, Slave(models["plant"].path) as whole:
        for slave in (moved, whole):
            slave.tick(0, {"voltage": 50.0})
        assert moved.get("displacement") == whole.get("displacement") != 0.0
