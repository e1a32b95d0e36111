/* What the benchmarks have the core do. To be included after bench.h. */
#ifndef IT2HYS_BENCH_IT2_H
#define IT2HYS_BENCH_IT2_H

#include "actuator.h"
#include "fmu_start.h"

#define SAMPLES 256

static struct it2 core;
static struct it2_rule rules[IT2_MAX_RULES];
static double voltage[SAMPLES], displacement[SAMPLES];
static volatile double sink; /* keeps results alive */

/* Three rules are Table 1; other counts spread the antecedent of its rule 2 over the range and share
 * its consequent, so that the set is contracting, without its constant, so that it stays in the range. */
static void prepare_core(int count)
{
    for (int l = 0; l < count; l++) {
        rules[l] = FMU_START.rule[count == 3 ? l : 1];
        if (count != 3) {
            rules[l].centre = 16e-6 * (l + 0.5) / count;
            rules[l].q3 = 0.0;
        }
    }
    it2_prepare(&core, rules, count,
                (struct it2_range){ FMU_START.displacementMin, FMU_START.displacementMax });
}

static void core_steps(long steps)
{
    struct it2_state state;

    it2_reset(&state, 5e-6);
    for (long k = 0; k < steps; k++)
        it2_step(&core, &state, voltage[k % SAMPLES]);
    sink = state.y;
}

static void core_inverses(long steps)
{
    struct it2_state state;
    double sum = 0.0;

    it2_reset(&state, displacement[0]);
    for (long k = 0; k < steps; k++)
        sum += it2_inverse(&core, &state, displacement[k % SAMPLES]);
    sink = sum;
}

#endif
