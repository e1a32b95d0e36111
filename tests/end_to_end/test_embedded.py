"""The embedded form: compiled as a target would, it runs as the core does."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import make_set

from it2hys import core, excitations
from it2hys.cli import main
from it2hys.parameters import ParameterSet, table_1, write_ssv

CC = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
CXX = shutil.which("g++")
SETS = {"table_1": table_1(), "one_rule": make_set(1, 1), "sixteen_rules": make_set(16, 16, "*/ 16")}
STRICT = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off")

pytestmark = pytest.mark.skipif(CC is None, reason="no C compiler")

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
#include "SOURCE"
int main()
{
    static STAGE stage;
    it2_rule rule[IT2_MAX_RULES];
    for (int l = 0; l < COUNT_OF_RULES; l++)
        rule[l] = it2_rule{ 4e-6, 1e-5, 1e-6 * l, 0.5, 1e-8, 0.0 };
    STAGE_prepare(&stage, rule, COUNT_OF_RULES);
    mul = add = compare = divide = 0;
    FUNCTION(&stage, Counted(5e-6), Counted(50.0));
    printf("%ld %ld %ld %ld\n", mul, add, compare, divide);
}
"""
COUNTED = {
    "chain_step": {
        "TYPE": "double", "SOURCE": "it2_model.c", "STAGE": "it2", "FUNCTION": "it2_evaluate",
    },
    "it2_single_step": {
        "TYPE": "float", "SOURCE": "it2_single.c", "STAGE": "it2_single", "FUNCTION": "it2_single_step",
    },
}  # fmt: skip


def embedded(parameters: ParameterSet, directory: Path) -> Path:
    write_ssv(parameters, directory / "set.ssv")
    assert (
        main(["package", str(directory / "set.ssv"), "-o", str(directory), "--c-header", "--quiet"])
        == 0
    )
    return directory / "embedded"


def compile_strictly(folder: Path) -> Path:
    (folder / "main.c").write_text(RUN)
    sources = [str(path) for path in sorted(folder.glob("*.c"))]
    program = folder / "main"
    subprocess.run([CC, *STRICT, *sources, "-o", str(program), "-lm"], check=True)
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
    expected = core.free_run(parameters.rules, voltage, parameters["initialDisplacement"])
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


def test_nothing_is_allocated(tmp_path):
    folder = embedded(table_1(), tmp_path)
    text = "".join(path.read_text() for path in folder.glob("*.[ch]"))
    assert not any(f"{name}(" in text for name in ("malloc", "calloc", "realloc", "fopen", "alloca"))


@pytest.mark.skipif(CXX is None, reason="no g++")
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
    (folder / "count.cc").write_text(source)
    program = folder / "count"
    subprocess.run([CXX, "-std=c++20", "-w", str(folder / "count.cc"), "-o", str(program)], check=True)
    counted = subprocess.run([program], capture_output=True, text=True, check=True).stdout.split()
    header = (folder / "it2hys_model.h").read_text().splitlines()
    row = next(i for i, line in enumerate(header) if line.startswith(f" *     {function}     "))
    assert counted == header[row + 1].split()[1:]
