/* it2_free_run: (10) over a record, its forward sensitivities, and where it stops. */
#include <stdlib.h>

#include "check.h"
#include "sets.h"
#include "textbook_complex.h"

CHECK_MAIN;

enum { SAMPLES = 400, MAX_COLUMNS = IT2_RULE_PARAMETERS * IT2_MAX_RULES + 1 };

static double voltage[SAMPLES], y[SAMPLES], y_again[SAMPLES], sensitivity[SAMPLES * MAX_COLUMNS];

static void make_voltage(void)
{
    for (int k = 0; k < SAMPLES; k++)
        voltage[k] = 60.0 + 45.0 * sin(0.05 * k) + 15.0 * sin(0.21 * k);
}

/* Derivative of every y[k] with respect to one column by a complex step through the recurrence. */
static void column_by_complex_step(const struct it2_rule *rules, int count, double y_initial, int column,
                                   double *derivative)
{
    double complex p[IT2_RULE_PARAMETERS * IT2_MAX_RULES];
    double complex value = y_initial;

    complex_rules(rules, count, p);
    *(column < IT2_RULE_PARAMETERS * count ? &p[column] : &value) += COMPLEX_STEP * I;
    for (int k = 0; k < SAMPLES; k++) {
        value = textbook_complex(p, count, value, voltage[k]);
        derivative[k] = cimag(value) / COMPLEX_STEP;
    }
}

static void sensitivities(const struct it2_rule *rules, int count, double y_initial)
{
    const int columns = IT2_RULE_PARAMETERS * count + 1;
    double derivative[SAMPLES];

    CHECK(it2_free_run(rules, count, IT2_EVERYWHERE, voltage, SAMPLES, y_initial, y, sensitivity) == SAMPLES);
    CHECK(it2_free_run(rules, count, IT2_EVERYWHERE, voltage, SAMPLES, y_initial, y_again, NULL) == SAMPLES);
    CHECK(memcmp(y, y_again, sizeof y) == 0);
    for (int column = 0; column < columns; column++) {
        double scale = 0.0;
        column_by_complex_step(rules, count, y_initial, column, derivative);
        for (int k = 0; k < SAMPLES; k++)
            scale = fmax(scale, fabs(derivative[k]));
        for (int k = 0; k < SAMPLES; k++)
            CHECK_NEAR(sensitivity[k * columns + column], derivative[k], scale, 1e-10);
    }
}

static void steps_make_a_run(void)
{
    struct it2 stage;
    struct it2_state state;

    it2_prepare(&stage, TABLE_1, 3, IT2_EVERYWHERE);
    it2_reset(&state, 2.5);
    CHECK(it2_free_run(TABLE_1, 3, IT2_EVERYWHERE, voltage, SAMPLES, 2.5, y, NULL) == SAMPLES);
    for (int k = 0; k < SAMPLES; k++)
        CHECK(it2_step(&stage, &state, voltage[k]) == y[k]);
}

/* Above 18 um Table 1 no longer contracts: the run grows until a double overflows. */
static void divergence(void)
{
    enum { LONG = 20000 };
    double *x = malloc(LONG * sizeof *x);
    double *run = malloc(LONG * sizeof *run);
    double *rows = malloc(LONG * 19 * sizeof *rows);

    for (int k = 0; k < LONG; k++)
        x[k] = 500.0;
    const size_t n = it2_free_run(TABLE_1, 3, IT2_EVERYWHERE, x, LONG, 30.0, run, NULL);
    CHECK(n > 0 && n < LONG);
    CHECK(isfinite(run[n - 1]) && !isfinite(run[n]));
    const size_t with_rows = it2_free_run(TABLE_1, 3, IT2_EVERYWHERE, x, LONG, 30.0, run, rows);
    CHECK(with_rows > 0 && with_rows <= n);
    CHECK(it2_free_run(TABLE_1, 3, IT2_EVERYWHERE, x, 0, 30.0, run, rows) == 0);
    x[7] = NAN;
    CHECK(it2_free_run(TABLE_1, 3, IT2_EVERYWHERE, x, 100, 1.0, run, NULL) == 7);
    CHECK(it2_free_run(TABLE_1, 3, IT2_EVERYWHERE, x, 100, 1.0, run, rows) == 7);
    free(x);
    free(run);
    free(rows);
}

int main(void)
{
    struct it2_rule rules[IT2_MAX_RULES];
    uint64_t seed = 5;

    make_voltage();
    sensitivities(TABLE_1, 3, 0.0);
    sensitivities(TABLE_1, 3, 12.0);
    for (int trial = 0; trial < 8; trial++) {
        const int count = random_usable_rules(&seed, rules);
        sensitivities(rules, count, 1.0);
    }
    steps_make_a_run();
    divergence();
    return check_report("free run");
}
