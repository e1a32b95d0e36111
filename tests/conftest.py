"""What the tests share: packaged FMUs, instances run through FMPy, random parameter sets.

Import the classes and strategies with ``from conftest import ...``.
"""

import ctypes
import os
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from urllib.parse import quote

import fmpy
import numpy as np
import pytest
from fmpy import fmi2
from hypothesis import settings
from hypothesis import strategies as st
from lxml import etree

from it2hys.designs import designing
from it2hys.fmu.controller import controller_fmu
from it2hys.fmu.model_description import IDENTIFIERS
from it2hys.fmu.packaging import package
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet, table_1
from it2hys.model.variables import load_table

# examples that call into binaries vary in time with the machine's load; the same ones in every run,
# HYPOTHESIS=explore for others: a run is to fail by what was changed
explore = os.environ.get("HYPOTHESIS") == "explore"
settings.register_profile("it2hys", deadline=None, derandomize=not explore)
settings.load_profile("it2hys")

# output is buffered, as in a user's shell
os.environ.pop("PYTHONUNBUFFERED", None)

pytest_plugins = ["environments"]  # for the tests of the installation

MODELS = tuple(IDENTIFIERS)
INPUT = {"plant": "voltage", "inverse": "reference", "controller": "displacement"}
OUTPUT = {"plant": "displacement", "inverse": "voltage", "controller": "voltage"}
UM = 1e-6
TS = 1e-4
# an input at which Table 1 rests within its range
CALM = {"plant": 50.0, "inverse": 5 * UM, "controller": 5 * UM}
# measured records, which lie beside the project where they are at all
YAN9A = next(
    (p / "shared/data/yan9a" for p in Path(__file__).parents if (p / "shared/data/yan9a").is_dir()),
    None,
)
needs_measured_records = pytest.mark.skipif(
    YAN9A is None, reason="the measured data shared/data/yan9a are absent"
)


# --- the run -----------------------------------------------------------------------------------

SLOW = (
    "diagnosis/test_diagnosis.py",
    "end_to_end/",
    "interop/test_foreign_masters.py",
    "interop/test_maestro.py",
    "modelica/test_simulation.py",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that take long."""
    tests = Path(__file__).parent
    for item in items:
        own = {mark.name for mark in item.iter_markers()}
        if own & {"gate", "installation"} or item.path.relative_to(tests).as_posix().startswith(SLOW):
            item.add_marker(pytest.mark.slow)


#: Whole commands whose tests look at the record that a diagnosis designs; and at what moves on a page
#: and how its figures are laid out.
OF_DESIGNS = ("test_design.py", "test_next_experiment.py", "test_run.py")
OF_VIEWS = ("test_report_page.py", "test_sweep.py")
#: matplotlib's settings for the figures of the others, which are not laid out.
PLAIN = {"figure.constrained_layout.use": False, "figure.dpi": 50}


@pytest.fixture(scope="module", autouse=True)
def brief_reports(request: pytest.FixtureRequest) -> Iterator[None]:
    """Let the reports of other commands be made quickly.

    With records as short as the tests have, designing the next one takes longer than finding effects,
    the views of a page longer than identifying a model, and laying out the figures as long.
    """
    path = request.path
    if path.parent.name != "end_to_end":
        yield
        return
    with pytest.MonkeyPatch.context() as patch:
        if path.name not in OF_DESIGNS:
            patch.setattr(designing, "_COARSE_FEWEST", 4)
            patch.setattr(designing, "_COARSE_MOST", 4)
            patch.setattr(designing, "FAMILIES", {"steps": designing.FAMILIES["steps"]})
        if path.name not in OF_VIEWS:
            patch.setattr("it2hys.reports.pair_report._LOOKED_INTO", 0)
            from it2hys.reports.figures import STYLE  # matplotlib, which few tests need

            for name, value in PLAIN.items():
                patch.setitem(STYLE, name, value)
        yield


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say what was skipped, and why: how many tests, of which file."""
    skipped = Counter(
        (str(r.longrepr[2]).removeprefix("Skipped: "), r.nodeid.partition("::")[0])
        for r in terminalreporter.stats.get("skipped", [])
    )
    if not skipped:
        return
    terminalreporter.section("skipped, and why")
    for (reason, file), count in sorted(skipped.items()):
        terminalreporter.write_line(f"{count:5}  {file}: {reason}")


# --- parameter sets ----------------------------------------------------------------------------


def make_rules(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return random rules, shape (L, 6) in V and m, that are usable over 0..16 um.

    Every rule's own equilibrium is close to a straight line of one gain, so that any mixture of
    them contracts and can be inverted.
    """
    gain = rng.uniform(0.08, 0.25)
    lower = rng.uniform(1.0, 10.0, count)
    upper = lower * rng.uniform(1.0, 6.0, count)
    q1 = rng.uniform(0.3, 0.97, count)
    q2 = gain * (1 - q1) * rng.uniform(0.8, 1.25, count)
    q3 = (1 - q1) * rng.uniform(-0.2, 0.2, count)
    centre = rng.uniform(-1.0, 17.0, count)
    rules = np.column_stack([lower, upper, centre, q1, q2, q3])
    return rules * np.array([UM, UM, UM, 1.0, UM, UM])


def make_set(seed: int, count: int, name: str = "random", **scalars: float) -> ParameterSet:
    """Return a random usable set of `count` rules; the same for the same seed."""
    rules = make_rules(np.random.default_rng(seed), count)
    return ParameterSet.from_rules(rules, name, **scalars).validate()


def parameter_sets(max_rules: int = 16) -> st.SearchStrategy[ParameterSet]:
    """Return a strategy for usable sets."""
    return st.builds(make_set, st.integers(0, 2**32 - 1), st.integers(1, max_rules))


# --- instances ---------------------------------------------------------------------------------


class Unpacked:
    """An FMU, unpacked: many instances can be made of it.

    Attributes
    ----------
    path : Path
        The FMU file.
    directory : Path
        Where it is unpacked.
    description : fmpy.model_description.ModelDescription
    variables : dict
        FMPy's variables by name.
    """

    def __init__(self, path: Path, directory: Path) -> None:
        self.path = path
        self.directory = directory
        fmpy.extract(str(path), str(directory))
        self.description = fmpy.read_model_description(str(directory), validate=False)
        self.variables = {v.name: v for v in self.description.modelVariables}

    def find(self, name: str) -> tuple[str, int]:
        """Return base type and value reference of a variable.

        The binary has the parameters of sixteen rules, however few of them the XML lists.
        """
        if name in self.variables:
            return self.variables[name].type, self.variables[name].valueReference
        parameter = load_table().parameters()[name]
        return parameter.type.base, parameter.value_reference

    @property
    def identifier(self) -> str:
        """Model identifier."""
        return self.description.coSimulation.modelIdentifier

    @property
    def model(self) -> str:
        """`plant`, `inverse` or `controller`."""
        models = {identifier: model for model, identifier in IDENTIFIERS.items()}
        return models.get(self.identifier, "controller")

    @property
    def binary(self) -> Path:
        """Path of this platform's binary."""
        suffix = fmpy.sharedLibraryExtension
        return self.directory / "binaries" / fmpy.platform / f"{self.identifier}{suffix}"

    @property
    def flags(self) -> set[tuple[str, str]]:
        """What the XML says of co-simulation, as written there."""
        root = etree.parse(self.directory / "modelDescription.xml").getroot()
        attributes = root.find("CoSimulation").attrib
        return {(name, text) for name, text in attributes.items() if name != "modelIdentifier"}


class Instance:
    """One FMU instance behind FMPy's `FMU2Slave`, with its messages; frees itself.

    Parameters
    ----------
    unpacked : Unpacked
    resources : str or None, optional
        Resource location to hand over, verbatim; by default FMPy's.
    library : Path, optional
        Other than the FMU's own binary.
    logging : bool
        Value of `loggingOn`.
    """

    _DEFAULT = object()

    def __init__(
        self,
        unpacked: Unpacked,
        resources: object = _DEFAULT,
        library: Path | None = None,
        logging: bool = True,
    ) -> None:
        self.unpacked = unpacked
        self.messages: list[tuple[int, str, str]] = []
        self.fmu = fmi2.FMU2Slave(
            guid=unpacked.description.guid,
            unzipDirectory=str(unpacked.directory),
            modelIdentifier=unpacked.identifier,
            instanceName="instance",
            libraryPath=str(library or unpacked.binary),
        )
        self._callbacks = fmi2.fmi2CallbackFunctions()
        self._callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(self._log)
        if resources is Instance._DEFAULT:
            resources = (unpacked.directory / "resources").as_uri()
        self.fmu.callbacks = self._callbacks
        self.fmu.component = self.fmu.fmi2Instantiate(
            b"instance",
            fmi2.fmi2CoSimulation,
            self.fmu.guid.encode(),
            resources if resources is None else resources.encode(),
            fmi2.byref(self._callbacks),
            False,
            logging,
        )

    def _log(self, _env: object, _name: bytes, status: int, category: bytes, text: bytes) -> None:
        self.messages.append((status, category.decode(), text.decode().replace("%%", "%")))

    @property
    def made(self) -> bool:
        """Whether the instance was made, not refused."""
        return bool(self.fmu.component)

    def said(self, status: int) -> list[str]:
        """Return the messages of one status."""
        return [text for s, _, text in self.messages if s == status]

    def status_of(self, call: Callable, *arguments: object) -> int:
        """Return the status of an FMI call, which FMPy raises if it is above a warning."""
        try:
            return call(*arguments) or fmi2.fmi2OK
        except fmpy.fmi1.FMICallException as error:
            return error.status

    def references(self, names: Sequence[str]) -> list[int]:
        """Return value references by name."""
        return [self.unpacked.variables[name].valueReference for name in names]

    def assign(self, values: dict) -> None:
        """Set variables by name."""
        for name, value in values.items():
            base, reference = self.unpacked.find(name)
            getattr(self.fmu, f"set{base}")([reference], [value])

    def get(self, name: str) -> float | int | bool:
        """Return the value of a variable."""
        base, reference = self.unpacked.find(name)
        return getattr(self.fmu, f"get{base}")([reference])[0]

    def slope(self, name: str, value: float) -> None:
        """Set the derivative of an input."""
        self.fmu.setRealInputDerivatives(self.references([name]), [1], [value])

    def initialize(
        self, start: dict | None = None, start_time: float = 0.0, stop_time: float | None = None
    ) -> "Instance":
        """Go through initialization with start values; return self."""
        self.fmu.setupExperiment(startTime=start_time, stopTime=stop_time)
        self.assign(start or {})
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def step(self, time: float, size: float) -> int:
        """Make a step; return its status."""
        return self.status_of(self.fmu.fmi2DoStep, self.fmu.component, time, size, True)

    def deserialize(self, blob: bytes) -> int:
        """Make a state of bytes; return the status."""
        buffer, state = ctypes.create_string_buffer(blob, len(blob) or 1), ctypes.c_void_p()
        call = self.fmu.fmi2DeSerializeFMUstate
        return self.status_of(call, self.fmu.component, buffer, len(blob), ctypes.byref(state))

    def close(self) -> None:
        """Free the instance."""
        if self.made:
            self.fmu.freeInstance()
        self.fmu.component = None

    def __enter__(self) -> "Instance":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Master:
    """Steps one instance tick by tick, or over any communication steps.

    Parameters
    ----------
    unpacked : Unpacked
    start : dict, optional
        Start values by name.
    first_tick : int
        Where to begin.
    """

    def __init__(self, unpacked: Unpacked, start: dict | None = None, first_tick: int = 0) -> None:
        self.instance = Instance(unpacked)
        assert self.instance.made, self.instance.messages
        self.input, self.output = INPUT[unpacked.model], OUTPUT[unpacked.model]
        self.sample_time = float(unpacked.variables["sampleTime"].start)
        self.sample_time = (start or {}).get("sampleTime", self.sample_time)
        self.tick = first_tick
        self.instance.initialize(start, first_tick * self.sample_time)

    def run(self, signal: Sequence[float]) -> np.ndarray:
        """Return the output of every tick for the input at every tick."""
        return np.array([self.advance(value) for value in signal])

    def advance(self, value: float) -> float:
        """Run one tick."""
        self.instance.assign({self.input: float(value)})
        status = self.instance.step(self.tick * self.sample_time, self.sample_time)
        assert status <= fmi2.fmi2Warning, self.instance.messages
        self.tick += 1
        return self.instance.get(self.output)

    def run_steps(
        self, signal: Callable[[float], float], slope: Callable[[float], float], times: np.ndarray
    ) -> np.ndarray:
        """Return what is read at each of ``times[1:]``, with value and slope given at each step."""
        read = []
        for time, end in pairwise(times):
            self.instance.assign({self.input: float(signal(time))})
            self.instance.slope(self.input, float(slope(time)))
            assert self.instance.step(time, end - time) <= fmi2.fmi2Warning, self.instance.messages
            read.append(self.instance.get(self.output))
        return np.array(read)

    def __enter__(self) -> "Master":
        return self

    def __exit__(self, *_: object) -> None:
        self.instance.close()


def continue_run(instance: Instance, first: int, count: int = 30) -> bytes:
    """Run ticks with an input that slopes, if it can; return the outputs' bits."""
    model, values = instance.unpacked.model, []
    for k in range(first, first + count):
        instance.assign({INPUT[model]: CALM[model] * (1 + 0.01 * k)})
        if model != "controller":
            instance.slope(INPUT[model], CALM[model])
        assert instance.step(k * TS, TS) <= fmi2.fmi2Warning, instance.messages
        values.append(instance.get(OUTPUT[model]))
    return np.array(values).tobytes()


def ticks(count: int) -> np.ndarray:
    """Return the times of the first ticks."""
    return np.arange(count) * TS


def tick_values(model: str, signal, count: int) -> np.ndarray:
    """Return what the C core makes of a signal at every tick."""
    inputs = np.array([signal(k * TS) for k in range(count)])
    if model == "plant":
        return compiled.free_run(table_1().rules, inputs, 0.0, table_1().displacement_range)
    return compiled.chain_inverse_run(table_1(), inputs)[0]


def trajectory(unpacked: Unpacked, library: Path | None = None) -> bytes:
    """Return the bits of a run that visits the whole range and leaves it."""
    time = np.arange(600) * float(unpacked.variables["sampleTime"].start)
    swing = 0.55 - 0.55 * np.cos(2 * np.pi * time / time[-1] * 3)
    peak = {"plant": 80.0, "inverse": 15e-6}[unpacked.model]
    with Instance(unpacked, library=library) as instance:
        assert instance.made, instance.messages
        instance.initialize()
        values = []
        for t, s in zip(time, swing, strict=True):
            instance.assign({INPUT[unpacked.model]: float(s) * peak})
            assert instance.step(t, time[1]) <= 1, instance.messages
            values.append(instance.get(OUTPUT[unpacked.model]))
    return np.array(values).tobytes()


def moved_binary(unpacked: Unpacked, directory: Path) -> Path:
    """Return a copy of the binary that has no resources near it."""
    folder = directory / "elsewhere" / "binaries" / "here"
    folder.mkdir(parents=True, exist_ok=True)
    return Path(shutil.copy(unpacked.binary, folder))


def rewrite(unpacked: Unpacked, directory: Path) -> Unpacked:
    """Return a copy of an FMU in another directory, to be damaged."""
    return Unpacked(unpacked.path, directory)


def percent_encoded(path: Path) -> str:
    """Return the file URI of a path, percent-encoded, without a trailing slash."""
    return "file://" + quote(str(path))


def run_python(code: str, *arguments: object, timeout: float = 120, **environment: str) -> str:
    """Run code in a Python process of its own; return what it prints."""
    paths = [str(Path(__file__).parent), *filter(None, sys.path)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), **environment}
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        capture_output=True,
        text=True,
        env=environment,
        timeout=timeout,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


# --- fixtures ----------------------------------------------------------------------------------


def package_models(parameters: ParameterSet, directory: Path, version: int = 2) -> dict[str, Unpacked]:
    """Package a set and unpack both FMUs of a version of FMI; returns them by model."""
    package(parameters, directory, fmi=(version,))
    return unpacked_models(directory, version)


def unpacked_models(directory: Path, version: int = 2) -> dict[str, Unpacked]:
    """Unpack both FMUs of a version of FMI in a directory; returns them by model."""
    end = "_fmi3" if version == 3 else ""
    return {
        model: Unpacked(directory / f"{identifier}{end}.fmu", directory / f"{identifier}{end}")
        for model, identifier in IDENTIFIERS.items()
    }


@pytest.fixture(scope="session")
def models(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Unpacked]:
    """Both FMUs with Table 1, unpacked, by model."""
    return package_models(table_1(), tmp_path_factory.mktemp("table-1"))


@pytest.fixture(scope="session")
def fmus(models: dict[str, Unpacked]) -> dict[str, Path]:
    """Paths of both FMUs with Table 1, by model."""
    return {model: unpacked.path for model, unpacked in models.items()}


@pytest.fixture(scope="session")
def five_rules(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Unpacked]:
    """Both FMUs with five rules: their set is not compiled in but read from resources/."""
    return package_models(make_set(5, 5, "five rules"), tmp_path_factory.mktemp("five-rules"))


@pytest.fixture(scope="session")
def packaged(
    models: dict[str, Unpacked],
    five_rules: dict[str, Unpacked],
    tmp_path_factory: pytest.TempPathFactory,
) -> dict[str, tuple[ParameterSet, dict[str, Unpacked]]]:
    """Return sets and their FMUs, by name: Table 1, one rule, five rules, sixteen rules."""
    one = make_set(1, 1, "one rule", sampleTime=2e-4, initialDisplacement=1e-6)
    most = make_set(16, 16, "sixteen rules, <&> and \N{GREEK SMALL LETTER MU}m")
    return {
        "table_1": (table_1(), models),
        "one_rule": (one, package_models(one, tmp_path_factory.mktemp("one-rule"))),
        "five_rules": (make_set(5, 5, "five rules"), five_rules),
        "sixteen_rules": (most, package_models(most, tmp_path_factory.mktemp("sixteen-rules"))),
    }


@pytest.fixture(scope="session")
def controller(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PIController.fmu, unpacked."""
    directory = tmp_path_factory.mktemp("controller")
    path = directory / "PIController.fmu"
    path.write_bytes(controller_fmu())
    return Unpacked(path, directory / "PIController")


@pytest.fixture(scope="session")
def mounted(tmp_path_factory: pytest.TempPathFactory) -> tuple[ParameterSet, dict[str, Unpacked]]:
    """Return a set with an effect of the user's own, tests/unit/own/mount.py, and its FMUs.

    They are compiled for all platforms, which takes longest: once for all processes of the tests.
    """
    import fcntl

    from effects import with_effects
    from own_effects import NAMES, in_chain

    with in_chain(*NAMES):
        parameters = with_effects(("mount",), 42)
        own = tmp_path_factory.getbasetemp()
        shared = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
        with open(shared / "mounted.lock", "w", encoding="utf-8") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not (shared / "mounted").exists():
                package(parameters, own / "packaged", fmi=(2,))
                (own / "packaged").rename(shared / "mounted")
        mine = tmp_path_factory.mktemp("mounted")
        shutil.copytree(shared / "mounted", mine, dirs_exist_ok=True)
        return parameters, unpacked_models(mine)


@pytest.fixture(params=MODELS)
def model(request: pytest.FixtureRequest, models: dict[str, Unpacked]) -> Unpacked:
    """Each FMU with Table 1 in turn."""
    return models[request.param]


@pytest.fixture(params=(*MODELS, "controller"))
def fmu(request: pytest.FixtureRequest, models: dict[str, Unpacked], controller: Unpacked) -> Unpacked:
    """Each FMU with Table 1 in turn, and the controller."""
    return {**models, "controller": controller}[request.param]


@pytest.fixture
def plant(models: dict[str, Unpacked]) -> Iterator[Instance]:
    """Yield a plant instance, not yet initialized."""
    with Instance(models["plant"]) as instance:
        yield instance


@pytest.fixture
def inverse(models: dict[str, Unpacked]) -> Iterator[Instance]:
    """Yield an instance of the inverse, not yet initialized."""
    with Instance(models["inverse"]) as instance:
        yield instance
