"""The embedded form: compiled as a target would, it runs as the core does."""

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from compilers import compiler
from conftest import make_set

from it2hys import simulate, track
from it2hys.cli import main
from it2hys.fmu.single_precision import single_precision
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet, table_1, write_ssv
from it2hys.stand import excitations

SOURCES = Path(__file__).parents[2] / "fmu_src"
SETS = {"table_1": table_1(), "one_rule": make_set(1, 1), "sixteen_rules": make_set(16, 16, "*/ 16")}
STRICT = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off")

# a voltage per line in; displacement, voltage of the inverse and both in single precision out
RUN = r"""
#include <stdio.h>
#include "it2hys_model.h"

int main(void)
{
    struct chain chain;
    struct chain_state plant, inverse;
    struct it2_single single;
    double voltage;
    float y;

    it2hys_begin(&chain, &plant);
    it2hys_begin(&chain, &inverse);
    it2hys_begin_single(&single);
    y = (float)IT2HYS_PARAMETERS.initialDisplacement;
    while (scanf("%lf", &voltage) == 1) {
        const struct chain_surroundings around = { 0.0, 293.15, 0.0 };
        unsigned limits;
        const double displacement = chain_step(&chain, &plant, voltage, &around);
        const float previous = y;
        y = it2_single_step(&single, previous, (float)voltage);
        printf("%.17g %.17g %.9g %.9g\n", displacement,
               chain_inverse(&chain, &inverse, displacement, &around, &limits), (double)y,
               (double)it2_single_inverse(&single, previous, y));
    }
    return 0;
}
"""

# ticks in; largest differences of single precision from double out: displacement, reading, voltage of
# the inverse, inverse followed by plant; all but the voltage of the displacement's range, which is last
RUN_SINGLE = r"""
#include <stdio.h>
#include <stdlib.h>
#include "it2hys_model.h"
#include "it2hys_single.h"

static double larger(double than, double a, double b)
{
    return fmax(than, fabs(a - b));
}

int main(int count, char **argument)
{
    static struct chain chain;
    static struct chain_state plant, inverse;
    static struct single_chain single;
    static struct single_chain_state plant_1, inverse_1, follower;
    const long ticks = count > 1 ? atol(argument[1]) : 0;
    double error[4] = { 0.0, 0.0, 0.0, 0.0 }, low = 1.0, high = -1.0;

    it2hys_begin(&chain, &plant);
    it2hys_begin(&chain, &inverse);
    it2hys_single_begin(&single, &plant_1);
    it2hys_single_begin(&single, &inverse_1);
    it2hys_single_begin(&single, &follower);
    for (long k = 0; k < ticks; k++) {
        const double t = (double)k * IT2HYS_PARAMETERS.sampleTime;
        const double u = 45.0 + 25.0 * sin(6.3 * t) + 12.0 * sin(46.0 * t);
        const struct chain_surroundings around = { 2.0 * sin(3.0 * t), 293.15 + 2.0 * sin(0.5 * t), t };
        const struct single_chain_surroundings around_1 = { (float)around.force,
                                                            (float)around.temperature, (float)t };
        unsigned limits, limits_1;
        const double y = chain_step(&chain, &plant, u, &around);
        const float y_1 = single_chain_step(&single, &plant_1, (float)u, &around_1);
        const double x = chain_inverse(&chain, &inverse, y, &around, &limits);
        const float x_1 = single_chain_inverse(&single, &inverse_1, (float)y, &around_1, &limits_1);
        const float y_2 = single_chain_step(&single, &follower, x_1, &around_1);
        if (limits || limits_1)
            return 1;
        low = fmin(low, y);
        high = fmax(high, y);
        error[0] = larger(error[0], (double)y_1, y);
        error[1] = larger(error[1], (double)single_chain_measure(&single, y_1, (float)t),
                          chain_measure(&chain, y, t));
        error[2] = larger(error[2], (double)x_1, x);
        error[3] = larger(error[3], (double)y_2, y);
    }
    printf("%g %g %g %g %g\n", error[0] / (high - low), error[1] / (high - low), error[2],
           error[3] / (high - low), high - low);
    return 0;
}
"""
EFFECTS = {
    "saturation": {"saturation.minimum": -50.0, "saturation.maximum": 200.0},
    "load": {"load.compliance": 2e-8},
    "drift": {"drift.temperatureCoefficient": 1e-8, "drift.rate": 1e-9},
    "nonlinearity": {"nonlinearity.quadratic": 2e-7, "nonlinearity.cubic": 1e-7},
    "lag": {"lag.timeConstant": 3e-4},
    "play": {
        "play[1].threshold": 2.0, "play[1].weight": 0.1,
        "play[2].threshold": 6.0, "play[2].weight": -0.05,
    },
    "creep": {
        "creep[1].gain": 0.02, "creep[1].timeConstant": 0.1,
        "creep[2].gain": 0.02, "creep[2].timeConstant": 10.0,
    },
    "slow creep": {"creep[1].gain": 0.02, "creep[1].timeConstant": 1e3},
    "resonance": {"resonance.frequency": 900.0, "resonance.damping": 0.05},
    "hum": {"hum.amplitude": 2e-8, "hum.frequency": 50.0},
    "delay": {"delay.time": 5e-4},
    "slew": {"slew.rate": 2e4},
}  # fmt: skip
STATIC = ("saturation", "load", "drift", "nonlinearity")
SLOW = ("lag", "play", "load", "creep")
# what the generated header says, for each group of effects: displacement, voltage, inverse and plant
BOUNDS = {
    (): (1e-6, 0.5e-3, 1.5e-6),
    STATIC: (1e-6, 0.5e-3, 1.5e-6),
    SLOW: (2e-6, 2e-3, 2e-6),
    ("slow creep",): (1e-4, 10e-3, 2e-6),
    ("resonance",): (3e-6, 2e-3, 4e-6),
    (*STATIC, "lag", "play", "creep", "resonance", "slew", "hum"): (3e-6, 15e-3, 4e-6),
}

# arithmetic that counts itself, in place of TYPE in the core's sources
COUNT = r"""
#include <cfloat>
#include <climits>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
static long mul, add, compare, divide;
struct Counted {
    TYPE v;
    Counted() = default;
    Counted(TYPE x) : v(x) {}
    explicit operator int() const { return (int)v; }
    Counted &operator+=(Counted b) { add++; v += b.v; return *this; }
};
static Counted operator+(Counted a, Counted b) { add++; return a.v + b.v; }
static Counted operator-(Counted a, Counted b) { add++; return a.v - b.v; }
static Counted operator-(Counted a) { return -a.v; }
static Counted operator*(Counted a, Counted b) { mul++; return a.v * b.v; }
static Counted operator/(Counted a, Counted b) { divide++; return a.v / b.v; }
static bool operator<(Counted a, Counted b) { compare++; return a.v < b.v; }
static bool operator>(Counted a, Counted b) { compare++; return a.v > b.v; }
static bool operator>=(Counted a, Counted b) { compare++; return a.v >= b.v; }
static bool operator<=(Counted a, Counted b) { compare++; return a.v <= b.v; }
static Counted exp(Counted a) { return std::exp(a.v); }
static Counted sqrt(Counted a) { return std::sqrt(a.v); }
static bool isfinite(Counted a) { return std::isfinite(a.v); }
static Counted fmax(Counted a, Counted b) { return std::fmax(a.v, b.v); }
static Counted fmin(Counted a, Counted b) { return std::fmin(a.v, b.v); }
#define EXP_ONE_BY_ONE // there are no vectors of what counts
#define TYPE Counted
SOURCES
int main()
{
    static STAGE stage;
    it2_rule rule[IT2_MAX_RULES];
    for (int l = 0; l < COUNT_OF_RULES; l++)
        rule[l] = it2_rule{ 4e-6, 1e-5, 1e-6 * l, 0.5, 1e-8, 0.0 };
    STAGE_prepare(&stage, rule, COUNT_OF_RULES, { 0.0, 1.6e-5 });
    mul = add = compare = divide = 0;
    FUNCTION(&stage, Counted(5e-6), Counted(50.0));
    printf("%ld %ld %ld %ld\n", mul, add, compare, divide);
    mul = add = compare = divide = 0;
    FUNCTION(&stage, Counted(2e-5), Counted(50.0));
    printf("%ld %ld %ld %ld\n", mul, add, compare, divide);
}
"""
COUNTED = {
    "chain_step": {
        "TYPE": "double", "STAGE": "it2", "FUNCTION": "it2_evaluate",
        "SOURCES": "".join(
            f'#include "it2_{part}.c"\n' for part in ("model", "inverse", "gradient", "range")
        ),
    },
    "it2_single_step": {
        "TYPE": "float", "STAGE": "it2_single", "FUNCTION": "it2_single_step",
        "SOURCES": '#include "it2_single.c"\n',
    },
}  # fmt: skip


def embedded(parameters: ParameterSet, directory: Path) -> Path:
    write_ssv(parameters, directory / "set.ssv")
    assert (
        main(["package", str(directory / "set.ssv"), "-o", str(directory), "--c-header", "--quiet"])
        == 0
    )
    return directory / "embedded"


def compile_strictly(folder: Path, main: str = RUN) -> Path:
    (folder / "main.c").write_text(main)
    sources = [str(path) for path in sorted(folder.glob("*.c"))]
    program = folder / "main"
    subprocess.run([*compiler(), *STRICT, *sources, "-o", str(program), "-lm"], check=True)
    return program


def run(program: Path, voltage: np.ndarray) -> np.ndarray:
    text = "\n".join(f"{v:.17g}" for v in voltage)
    done = subprocess.run([program], input=text, capture_output=True, text=True, check=True)
    return np.array([line.split() for line in done.stdout.splitlines()], dtype=float).T


@pytest.mark.parametrize("name", SETS)
def test_runs_as_the_core(name, tmp_path):
    parameters = SETS[name]
    voltage = excitations.identification(excitations.time_grid(0.2, 1e-4))
    y, x, y_single, x_single = run(compile_strictly(embedded(parameters, tmp_path)), voltage)
    start, limits = parameters["initialDisplacement"], parameters.displacement_range
    expected = compiled.free_run(parameters.rules, voltage, start, limits)
    np.testing.assert_array_equal(y, expected)
    reached = (y >= parameters["displacementMin"]) & (y <= parameters["displacementMax"])
    assert reached.all() or name != "table_1"
    first_out = len(y) if reached.all() else int(np.argmin(reached))
    np.testing.assert_allclose(x[:first_out], voltage[:first_out], atol=1e-9)
    # single precision on (22): 24 bits against 53, summed up over a run that contracts
    error = np.abs(y_single - y).max() / np.ptp(y)
    print(f"{name}: single precision differs by {error:.2e} of the range on (22)")
    assert error < 1e-6
    assert np.abs(x_single - voltage).max() < 5e-2


@pytest.mark.parametrize("name", SETS)
def test_runs_as_the_core_beyond_the_range(name, tmp_path):
    """In both precisions, and out of the inverse comes what went into the plant."""
    parameters = SETS[name]
    limits = low, high = parameters.displacement_range
    voltage = 300.0 * np.sin(np.linspace(0.0, 30.0, 3000))
    y, _, y_single, x_single = run(compile_strictly(embedded(parameters, tmp_path)), voltage)
    expected = compiled.free_run(parameters.rules, voltage, parameters["initialDisplacement"], limits)
    np.testing.assert_array_equal(y, expected)
    assert y.min() < low - 0.1 * (high - low)
    assert y.max() > high + 0.1 * (high - low)
    error = np.abs(y_single - y).max() / np.ptp(y)
    print(f"{name}: single precision differs by {error:.2e} of the range")
    assert error < 1e-6
    assert np.abs(x_single - voltage).max() < 5e-2


@pytest.fixture(scope="module")
def core_objects(tmp_path_factory) -> list[str]:
    """Return the core, which is the same for every set, compiled."""
    folder = embedded(table_1(), tmp_path_factory.mktemp("core"))
    sources = sorted(folder.glob("*.c"))
    for source in sources:  # one by one: zig makes one object of one command
        command = [*compiler(), *STRICT, "-c", str(source), "-o", str(source.with_suffix(".o"))]
        subprocess.run(command, check=True)
    return [str(source.with_suffix(".o")) for source in sources]


def with_effects(*names: str) -> ParameterSet:
    values = {n: v for n, v in table_1().items() if n not in ("playCount", "creepCount")}
    values["initialDisplacement"] = 8e-6
    for name in names:
        values |= EFFECTS[name]
    return ParameterSet(values, "+".join(names) or "core").validate()


def example(header: Path) -> str:
    """Return the program in a header's first comment."""
    comment = header.read_text(encoding="utf-8").partition("*/")[0]
    found = re.search(r"^ \*     #include <stdio.h>\n(?: \*.*\n)*? \*     \}\n", comment, re.MULTILINE)
    return re.sub(r"^ \*(?:     )?", "", found[0], flags=re.MULTILINE)


@pytest.mark.parametrize(
    ("header", "volts", "share"), [("it2hys_model.h", 1e-7, 1e-12), ("it2hys_single.h", 2e-3, 3e-6)]
)
@pytest.mark.parametrize("effects", [(), ("play", "creep", "lag", "hum")], ids=["core", "effects"])
def test_the_example_in_the_comment_runs_as_it_stands(
    effects, header, volts, share, core_objects, tmp_path
):
    """It prints what the FMUs of the same set give for its reference, tick for tick."""
    parameters = with_effects(*effects)
    folder = embedded(parameters, tmp_path)
    (folder / "main.c").write_text(example(folder / header))
    command = [
        *compiler(),
        *STRICT,
        str(folder / "main.c"),
        *core_objects,
        "-o",
        str(folder / "main"),
        "-lm",
    ]
    subprocess.run(command, check=True)
    done = subprocess.run([folder / "main"], capture_output=True, text=True, check=True)
    printed = np.array([line.split() for line in done.stdout.splitlines()], dtype=float).T
    reference, voltage, displacement, measured, limits = printed
    assert len(reference) == 100 and not limits.any()
    assert np.ptp(reference) > 3e-6
    paths = [tmp_path / "IT2Inverse.fmu", tmp_path / "IT2Plant.fmu"]
    expected = track(*paths, reference, {"initialDisplacement": parameters["initialDisplacement"]})
    read = simulate(paths[1], {"voltage": expected["voltage"]})["measured"]
    error = share * np.ptp(reference)
    np.testing.assert_allclose(voltage, expected["voltage"], atol=volts, rtol=0)
    np.testing.assert_allclose(displacement, reference, atol=error, rtol=0)
    np.testing.assert_allclose(measured, read, atol=error, rtol=0)
    assert (np.abs(measured - displacement).max() > 1e-9) == ("hum" in effects)


def run_single(effects: tuple, folder: Path, objects: list[str], ticks: int) -> np.ndarray:
    """Return what RUN_SINGLE prints for a set with these effects."""
    folder = embedded(with_effects(*effects), folder)
    (folder / "main.c").write_text(RUN_SINGLE)
    flags = [*STRICT, "-Wdouble-promotion", "-Wconversion"]
    command = [*compiler(), *flags, str(folder / "main.c"), *objects, "-o", str(folder / "main"), "-lm"]
    subprocess.run(command, check=True)
    done = subprocess.run([folder / "main", str(ticks)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, "the inverse met a limit"
    return np.array(done.stdout.split(), dtype=float)


@pytest.mark.parametrize("effects", BOUNDS, ids=lambda names: "+".join(names) or "core")
def test_the_chain_in_single_precision_stays_with_double(effects, core_objects, tmp_path):
    displacement, reading, voltage, both, covered = run_single(
        effects, tmp_path, core_objects, 1_000_000
    )
    assert covered > 8e-6
    measured = np.array([displacement, voltage, both])
    assert (measured > 0).all()
    assert (measured < BOUNDS[effects]).all(), measured
    hum = 3e-3 * EFFECTS["hum"]["hum.amplitude"] / covered if "hum" in effects else 0.0
    assert reading < BOUNDS[effects][0] + hum


def test_nothing_is_left_in_double():
    text = (compiled.native_directory() / "single_chain.h").read_text()
    assert text == single_precision(SOURCES / "core")
    assert not re.search(r"\bdouble\b|\b(exp|expm1|sin|cos|sqrt|fabs|fmin|fmax|floor)\(", text)
    assert not re.search(r"\d\.\d*(e-?\d+)?(?![\d.ef])", text)


def test_a_delay_in_single_precision_is_as_long(core_objects, tmp_path):
    """Five ticks, which no quotient of floats is exactly; its inverse has nothing to compare with."""
    displacement, _, voltage, _, _ = run_single(("delay",), tmp_path, core_objects, 20_000)
    assert 0 < displacement < 7e-7
    assert 0 < voltage < 2.5e-4


def test_nothing_is_allocated(tmp_path):
    folder = embedded(table_1(), tmp_path)
    text = "".join(path.read_text() for path in folder.glob("*.[ch]"))
    assert not any(f"{name}(" in text for name in ("malloc", "calloc", "realloc", "fopen", "alloca"))


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("function", COUNTED)
def test_the_header_counts_operations_right(name, function, tmp_path):
    folder = embedded(SETS[name], tmp_path)
    source = COUNT
    for word, replacement in {
        **COUNTED[function],
        "COUNT_OF_RULES": str(SETS[name].counts["rule"]),
    }.items():
        source = source.replace(word, replacement)
    (tmp_path / "count.cc").write_text(source)
    program = tmp_path / "count"
    places = [f"-I{SOURCES / name}" for name in ("core", "embedded")]
    command = [
        *compiler("c++"),
        "-std=c++20",
        "-w",
        *places,
        str(tmp_path / "count.cc"),
        "-o",
        str(program),
    ]
    subprocess.run(command, check=True)
    done = subprocess.run([program], capture_output=True, text=True, check=True)
    counted, beyond = (line.split() for line in done.stdout.splitlines())
    header = (folder / "it2hys_model.h").read_text().splitlines()
    row = next(i for i, line in enumerate(header) if line.startswith(f" *     {function}     "))
    assert counted == header[row + 1].split()[1:]
    comparisons = 4 if function == "chain_step" else 2
    assert beyond == ["2", "4", str(comparisons), "0"]
