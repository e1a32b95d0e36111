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
from it2hys.model import compiled
from it2hys.model.parameters import ParameterSet, table_1, write_ssv
from it2hys.stand import excitations

SOURCES = Path(__file__).parents[2] / "fmu_src"
SETS = {"table_1": table_1(), "one_rule": make_set(1, 1), "sixteen_rules": make_set(16, 16, "*/ 16")}
STRICT = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off")

SINGLE = ("-DIT2HYS_SINGLE", "-Wdouble-promotion", "-Wconversion")
PRECISIONS = {"double": (), "single": SINGLE}

# a voltage per line in; displacement, the inverse's voltage for it, and that of (30) alone out
RUN = r"""
#include <stdio.h>
#include "it2hys_model.h"

int main(void)
{
    struct chain chain;
    struct chain_state plant, inverse;
    double voltage;

    it2hys_begin(&chain, &plant);
    it2hys_begin(&chain, &inverse);
    while (scanf("%lf", &voltage) == 1) {
        const struct chain_surroundings around = { 0, REAL(293.15), 0 };
        unsigned limits;
        const real previous = plant.core.y;
        const real y = chain_step(&chain, &plant, (real)voltage, &around);
        printf("%.17g %.17g %.17g\n", (double)y,
               (double)chain_inverse(&chain, &inverse, y, &around, &limits),
               (double)it2_solve(&chain.core, previous, y));
    }
    return 0;
}
"""

# voltage, force, temperature, time and displacement wanted (NaN: the plant's own) in; displacement,
# reading, the inverse's voltage for what is wanted and the displacement under it out, all in binary
RUN_EFFECTS = r"""
#include <stdio.h>
#include "it2hys_model.h"

int main(void)
{
    static struct chain chain;
    static struct chain_state plant, inverse, follower;
    double in[5];

    it2hys_begin(&chain, &plant);
    it2hys_begin(&chain, &inverse);
    it2hys_begin(&chain, &follower);
    while (fread(in, sizeof in, 1, stdin) == 1) {
        const struct chain_surroundings around = { (real)in[1], (real)in[2], (real)in[3] };
        unsigned limits;
        const real y = chain_step(&chain, &plant, (real)in[0], &around);
        const real wanted = isnan(in[4]) ? y : (real)in[4];
        const real x = chain_inverse(&chain, &inverse, wanted, &around, &limits);
        const double out[] = { (double)y, (double)chain_measure(&chain, y, around.time), (double)x,
                               (double)chain_step(&chain, &follower, x, &around) };
        if (limits || fwrite(out, sizeof out, 1, stdout) != 1)
            return 1;
    }
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

# arithmetic that counts itself, in place of real.h
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
    Counted &operator*=(Counted b) { mul++; v *= b.v; return *this; }
    Counted &operator/=(Counted b) { divide++; v /= b.v; return *this; }
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
static bool operator==(Counted a, Counted b) { compare++; return a.v == b.v; }
static Counted real_exp(Counted a) { return std::exp(a.v); }
static Counted real_fabs(Counted a) { return std::fabs(a.v); }
static Counted real_sqrt(Counted a) { return std::sqrt(a.v); }
static bool isfinite(Counted a) { return std::isfinite(a.v); }
static Counted real_fmax(Counted a, Counted b) { return std::fmax(a.v, b.v); }
static Counted real_fmin(Counted a, Counted b) { return std::fmin(a.v, b.v); }
#define IT2HYS_REAL_H
#define REAL(literal) Counted((TYPE)literal)
#define REAL_MAX Counted(LARGEST)
#define REAL_EPSILON Counted(DBL_EPSILON)
#define REAL_INFINITY Counted(HUGE_VAL)
typedef Counted real;
#define EXP_ONE_BY_ONE // there are no vectors of what counts
SOURCES
int main()
{
    static it2 stage;
    it2_rule rule[IT2_MAX_RULES];
    for (int l = 0; l < COUNT_OF_RULES; l++)
        rule[l] = it2_rule{ 4e-6, 1e-5, TYPE(1e-6) * l, 0.5, 1e-8, 0.0 };
    it2_prepare(&stage, rule, COUNT_OF_RULES, { 0.0, 1.6e-5 });
    mul = add = compare = divide = 0;
    it2_evaluate(&stage, Counted(5e-6), Counted(50.0));
    printf("%ld %ld %ld %ld\n", mul, add, compare, divide);
    mul = add = compare = divide = 0;
    it2_evaluate(&stage, Counted(2e-5), Counted(50.0));
    printf("%ld %ld %ld %ld\n", mul, add, compare, divide);
    static it2_table table;
    it2_tabulate(&stage, &table);
    mul = add = compare = divide = 0;
    it2_evaluate(&stage, Counted(5e-6), Counted(50.0));
    printf("%ld %ld %ld %ld\n", mul, add, compare, divide);
}
"""
SOURCES_COUNTED = "".join(
    f'#include "it2_{part}.c"\n' for part in ("model", "inverse", "gradient", "range", "table")
)
COUNTED = {
    "chain_step": {"TYPE": "double", "LARGEST": "DBL_MAX", "SOURCES": SOURCES_COUNTED},
    "in single precision": {
        "TYPE": "float", "LARGEST": "FLT_MAX", "SOURCES": "#define IT2HYS_SINGLE\n" + SOURCES_COUNTED,
    },
}  # fmt: skip


def embedded(parameters: ParameterSet, directory: Path) -> Path:
    write_ssv(parameters, directory / "set.ssv")
    assert (
        main(["package", str(directory / "set.ssv"), "-o", str(directory), "--c-header", "--quiet"])
        == 0
    )
    return directory / "embedded"


def run(program: Path, voltage: np.ndarray) -> np.ndarray:
    text = "\n".join(f"{v:.17g}" for v in voltage)
    done = subprocess.run([program], input=text, capture_output=True, text=True, check=True)
    return np.array([line.split() for line in done.stdout.splitlines()], dtype=float).T


def run_both(
    parameters: ParameterSet, folder: Path, objects: dict[str, str], voltage: np.ndarray
) -> list[np.ndarray]:
    folder = embedded(parameters, folder)
    (folder / "main.c").write_text(RUN)
    return [run(link(folder, precision, objects), voltage) for precision in PRECISIONS]


@pytest.mark.parametrize("name", SETS)
def test_runs_as_the_core(name, core_objects, tmp_path):
    parameters = SETS[name]
    voltage = excitations.identification(excitations.time_grid(0.2, 1e-4))
    (y, x, _), (y_single, _, x_single) = run_both(parameters, tmp_path, core_objects, voltage)
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
    assert 0 < error < 1e-6
    assert np.abs(x_single - voltage).max() < 5e-2


@pytest.mark.parametrize("name", SETS)
def test_runs_as_the_core_beyond_the_range(name, core_objects, tmp_path):
    """In both precisions, and out of (30) comes what went into the plant."""
    parameters = SETS[name]
    limits = low, high = parameters.displacement_range
    voltage = 300.0 * np.sin(np.linspace(0.0, 30.0, 3000))
    (y, _, x), (y_single, _, x_single) = run_both(parameters, tmp_path, core_objects, voltage)
    expected = compiled.free_run(parameters.rules, voltage, parameters["initialDisplacement"], limits)
    np.testing.assert_array_equal(y, expected)
    assert y.min() < low - 0.1 * (high - low)
    assert y.max() > high + 0.1 * (high - low)
    error = np.abs(y_single - y).max() / np.ptp(y)
    print(f"{name}: single precision differs by {error:.2e} of the range")
    assert 0 < error < 1e-6
    assert np.abs(x - voltage).max() < 1e-9
    assert np.abs(x_single - voltage).max() < 5e-2


def test_with_a_table_it_runs_as_the_fmus(core_objects, tmp_path):
    folder = embedded(table_1(), tmp_path)
    begin, call = "it2hys_begin(&chain, &inverse);", "it2_tabulate(&chain.core, &table);"
    assert call in (folder / "it2hys_model.h").read_text()
    text = RUN.replace(begin, f"static struct it2_table table; {begin} {call}")
    (folder / "main.c").write_text('#include "it2hys.h"\n' + text)
    voltage = excitations.identification(excitations.time_grid(0.2, 1e-4))
    y = run(link(folder, "double", core_objects), voltage)[0]
    np.testing.assert_array_equal(y, compiled.chain_free_run(table_1(), voltage)[0])
    exact = compiled.free_run(table_1().rules, voltage, 0.0, table_1().displacement_range)
    assert 0 < np.abs(y - exact).max() < 1e-14 * np.ptp(y)


@pytest.fixture(scope="module")
def core_objects(tmp_path_factory) -> dict[str, str]:
    """Return the core, which is the same for every set, compiled in each precision."""
    folder = embedded(table_1(), tmp_path_factory.mktemp("core"))
    for precision, flags in PRECISIONS.items():
        # where something is computed in double, single fails here
        command = [*compiler(), *STRICT, *flags, "-c", str(folder / "it2hys.c")]
        subprocess.run([*command, "-o", str(folder / f"{precision}.o")], check=True)
    return {precision: str(folder / f"{precision}.o") for precision in PRECISIONS}


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
    ("precision", "volts", "share"), [("double", 1e-7, 1e-12), ("single", 2e-3, 3e-6)]
)
@pytest.mark.parametrize("effects", [(), ("play", "creep", "lag", "hum")], ids=["core", "effects"])
def test_the_example_in_the_comment_runs_as_it_stands(
    effects, precision, volts, share, core_objects, tmp_path
):
    """It prints what the FMUs of the same set give for its reference, tick for tick."""
    parameters = with_effects(*effects)
    folder = embedded(parameters, tmp_path)
    (folder / "main.c").write_text(example(folder / "it2hys_model.h"))
    link(folder, precision, core_objects)
    done = subprocess.run([folder / precision], capture_output=True, text=True, check=True)
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


def link(folder: Path, precision: str, objects: dict[str, str]) -> Path:
    """Return the program of main.c and the compiled core."""
    program = folder / precision
    command = [*compiler(), *STRICT, *PRECISIONS[precision], str(folder / "main.c"), objects[precision]]
    subprocess.run([*command, "-o", str(program), "-lm"], check=True)
    return program


def run_effects(
    effects: tuple, folder: Path, objects: dict[str, str], ticks: int
) -> dict[str, np.ndarray]:
    """Return what RUN_EFFECTS gives in each precision, where single wants what double reaches."""
    folder = embedded(with_effects(*effects), folder)
    (folder / "main.c").write_text(RUN_EFFECTS)
    t = 1e-4 * np.arange(ticks)
    u = 45.0 + 25.0 * np.sin(6.3 * t) + 12.0 * np.sin(46.0 * t)
    surroundings = [2.0 * np.sin(3.0 * t), 293.15 + 2.0 * np.sin(0.5 * t), t]
    wanted, result = np.full(ticks, np.nan), {}
    for precision in PRECISIONS:
        records = np.column_stack([u, *surroundings, wanted]).tobytes()
        program = link(folder, precision, objects)
        done = subprocess.run([program], input=records, capture_output=True, check=False)
        assert done.returncode == 0, "the inverse met a limit"
        result[precision] = np.frombuffer(done.stdout).reshape(-1, 4).T
        wanted = result["double"][0]
    return result


@pytest.mark.parametrize("effects", BOUNDS, ids=lambda names: "+".join(names) or "core")
def test_single_precision_stays_with_double(effects, core_objects, tmp_path):
    result = run_effects(effects, tmp_path, core_objects, 1_000_000)
    displacement, reading, voltage, both = np.abs(result["single"] - result["double"]).max(axis=1)
    covered = np.ptp(result["double"][0])
    assert covered > 8e-6
    measured = np.array([displacement / covered, voltage, both / covered])
    print(effects, measured)
    assert (measured > 0).all()
    assert (measured < BOUNDS[effects]).all(), measured
    hum = 3e-3 * EFFECTS["hum"]["hum.amplitude"] / covered if "hum" in effects else 0.0
    assert reading / covered < BOUNDS[effects][0] + hum


def test_a_delay_in_single_precision_is_as_long(core_objects, tmp_path):
    """Five ticks, which no quotient of floats is exactly; off by no more than the core alone."""
    result = run_effects(("delay",), tmp_path, core_objects, 20_000)
    displacement, _, voltage, _ = np.abs(result["single"] - result["double"]).max(axis=1)
    assert 0 < displacement / np.ptp(result["double"][0]) < BOUNDS[()][0]
    assert 0 < voltage < BOUNDS[()][1]


def test_the_core_computes_in_real_alone():
    """What the compiler's -Wdouble-promotion does not see: a variable that is double."""
    for path in sorted((SOURCES / "core").glob("*.[ch]")):
        text = re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        text = text.replace("(double)", "")  # of what is printed
        if path.name not in ("real.h", "exponential.h", "exponential_table.h"):
            found = re.search(
                r"\bdouble\b|<math\.h>|\b(exp|expm1|sin|cos|sqrt|fabs|fmin|fmax|floor)\(", text
            )
            assert not found, (path, found)


def test_a_program_of_both_precisions_is_not_linked(core_objects, tmp_path):
    folder = embedded(table_1(), tmp_path)
    (folder / "main.c").write_text(RUN)
    command = [*compiler(), *STRICT, str(folder / "main.c"), core_objects["single"], "-lm"]
    done = subprocess.run(
        [*command, "-o", str(folder / "main")], capture_output=True, text=True, check=False
    )
    assert done.returncode != 0
    assert "chain_prepare" in done.stderr


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
    command = [
        *compiler("c++"),
        "-std=c++20",
        "-w",
        f"-I{SOURCES / 'core'}",
        str(tmp_path / "count.cc"),
        "-o",
        str(program),
    ]
    subprocess.run(command, check=True)
    done = subprocess.run([program], capture_output=True, text=True, check=True)
    counted, beyond, by_table = (line.split() for line in done.stdout.splitlines())
    header = (folder / "it2hys_model.h").read_text().splitlines()
    row = next(i for i, line in enumerate(header) if line.startswith(f" *     {function}  "))
    assert counted == header[row + 1].split()[1:]
    assert beyond == ["2", "4", "4", "0"]
    assert by_table == (["21", "18", "2", "0"] if function == "chain_step" else counted)
    assert "a step of the core then takes 21 multiplications, 18 additions and 2" in " ".join(header)
