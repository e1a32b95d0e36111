/* What a step costs: nanoseconds, and ratios to what it cannot be faster than. */
#include "bench.h"

#include <math.h>
#include <stdio.h>

#include "bench_it2.h"
#include "fmi2Functions.h"
#include "fmu_table_hash.h"

#define TICKS_PER_LONG_STEP CHUNK_MULTIPLE

/* --- what is timed ----------------------------------------------------------------------------- */

static int count;
static double offset[2 * IT2_MAX_RULES];
static fmi2Component fmu;
static double fmu_time;

/* `rounds` of 2 L exponentials, each round's arguments following from the one before. */
static void exponentials(long rounds)
{
    double y = 0.5;

    for (long k = 0; k < rounds; k++) {
        double sum = 0.0;
        for (int i = 0; i < 2 * count; i++)
            sum += exp(offset[i] - y);
        y = sum;
    }
    sink = y;
}

/* A free run with sensitivities needs one gradient per step: y follows from y. */
static void core_gradients(long steps)
{
    double gradient[IT2_RULE_PARAMETERS * IT2_MAX_RULES];
    struct it2_partials partials;
    double y = 5e-6;

    for (long k = 0; k < steps; k++)
        y = it2_gradient(&core, y, voltage[k % SAMPLES], gradient, &partials);
    sink = y + gradient[0] + partials.dy;
}

static void fmu_steps(long steps)
{
    static const fmi2ValueReference in = 0, out = 4; /* voltage, displacement */
    double y = 0.0;

    for (long k = 0; k < steps; k++) {
        fmi2SetReal(fmu, &in, 1, &voltage[k % SAMPLES]);
        fmi2DoStep(fmu, fmu_time, FMU_START.sampleTime, fmi2True);
        fmi2GetReal(fmu, &out, 1, &y);
        fmu_time += FMU_START.sampleTime;
    }
    sink = y;
}

/* As many ticks, TICKS_PER_LONG_STEP of them per fmi2DoStep. */
static void fmu_long_steps(long ticks)
{
    static const fmi2ValueReference in = 0, out = 4;
    double y = 0.0;

    for (long k = 0; k < ticks; k += TICKS_PER_LONG_STEP) {
        fmi2SetReal(fmu, &in, 1, &voltage[k % SAMPLES]);
        fmi2DoStep(fmu, fmu_time, TICKS_PER_LONG_STEP * FMU_START.sampleTime, fmi2True);
        fmi2GetReal(fmu, &out, 1, &y);
        fmu_time += TICKS_PER_LONG_STEP * FMU_START.sampleTime;
    }
    sink = y;
}

/* --- set up ------------------------------------------------------------------------------------ */

static void choose_rules(int rule_count)
{
    count = rule_count;
    prepare_core(count);
    for (int i = 0; i < 2 * count; i++)
        offset[i] = -0.25 * i - log(2.0 * count); /* arguments between about -12 and 0, y below 1 */
}

static void open_fmu(void)
{
    static const fmi2ValueReference rule_count = 14, first_rule = 15;
    char guid[64];
    fmi2CallbackFunctions callbacks = { NULL, NULL, NULL, NULL, NULL };

    snprintf(guid, sizeof guid, "{%016llx%016llx}", (unsigned long long)FMU_TABLE_HASH_PLANT,
             (unsigned long long)FMU_START_HASH);
    fmu = fmi2Instantiate("bench", fmi2CoSimulation, guid, NULL, &callbacks, fmi2False, fmi2False);
    fmi2SetInteger(fmu, &rule_count, 1, &count);
    for (int i = 0; i < IT2_RULE_PARAMETERS * count; i++) {
        const fmi2ValueReference reference = first_rule + (fmi2ValueReference)i;
        fmi2SetReal(fmu, &reference, 1, (const double *)(const void *)rules + i);
    }
    fmu_time = 0.0;
    if (fmi2SetupExperiment(fmu, fmi2False, 0.0, 0.0, fmi2False, 0.0) != fmi2OK ||
        fmi2EnterInitializationMode(fmu) != fmi2OK || fmi2ExitInitializationMode(fmu) != fmi2OK) {
        fprintf(stderr, "bench: the FMU does not accept %d rules\n", count);
        exit(1);
    }
}

/* --- the table --------------------------------------------------------------------------------- */

static void row(const char *what, work *a, work *b)
{
    const struct comparison c = compare(a, b);

    printf("%-9s %4d %10.1f %10.1f %8.2f\n", what, count, c.a, c.b, c.ratio);
    fflush(stdout);
}

static void explain(void)
{
    puts("Each row: nanoseconds of A, nanoseconds of B, median of A/B over interleaved rounds.\n"
         "  step      A: it2_step, (10) by the rules, y fed back    B: 2 L calls of exp, fed back\n"
         "  inverse   A: it2_inverse, (30)                 B: it2_step\n"
         "  gradient  A: it2_gradient, (13) to (18)        B: it2_step\n"
         "  tick      A: fmi2SetReal + DoStep(Ts) + GetReal, by the table    B: it2_step\n"
         "  long      A: a tick of DoStep(100 Ts)              B: it2_step\n");
    printf("%-9s %4s %10s %10s %8s\n", "row", "L", "A ns", "B ns", "A/B");
}

int main(void)
{
    static const int rule_counts[] = { 1, 3, 8, 16 };

    for (int k = 0; k < SAMPLES; k++) {
        voltage[k] = 60.0 + 40.0 * sin(6.283185307179586 * k / SAMPLES);
        displacement[k] = 8e-6 + 6e-6 * sin(6.283185307179586 * k / SAMPLES);
    }
    explain();
    for (int i = 0; i < 4; i++) {
        choose_rules(rule_counts[i]);
        open_fmu();
        row("step", core_steps, exponentials);
        row("inverse", core_inverses, core_steps);
        row("gradient", core_gradients, core_steps);
        row("tick", fmu_steps, core_steps);
        row("long", fmu_long_steps, core_steps);
        fmi2FreeInstance(fmu);
    }
    return 0;
}
