/* (10) and (30) by the table: as exact as the rules themselves, against a long double reference over random
 * admissible sets; narrow rules get narrow intervals or none; and a table is that of its rules and range. */
#include "check.h"
#include "it2_table.h"
#include "sets.h"

CHECK_MAIN;

enum { SETS = 1000, POINTS = 200 };

/* A(y) and B(y) as they stand in the paper. */
static void reference(const struct it2_rule *rules, int count, double y, long double *a, long double *b)
{
    long double sum = 0.0L;

    *a = *b = 0.0L;
    for (int l = 0; l < count; l++) {
        const struct it2_rule *r = &rules[l];
        const long double d = (long double)y - r->centre, s1 = r->sigmaLower, s2 = r->sigmaUpper;
        const long double w = expl(-d * d / (2.0L * s1 * s1)) + expl(-d * d / (2.0L * s2 * s2));
        *a += r->q2 * w;
        *b += ((long double)r->q1 * y + r->q3) * w;
        sum += w;
    }
    *a /= sum;
    *b /= sum;
}

struct errors {
    double step, inverse; /* the largest, of the range */
};

static void compare(const struct it2 *stage, double y, double x, double next, struct errors *e)
{
    const double length = stage->upper.y - stage->lower.y;
    long double a, b;

    reference(stage->rule, stage->rules, y, &a, &b);
    const double step = (double)(it2_evaluate(stage, y, x) - (a * x + b));
    const double inverse = (double)((it2_solve(stage, y, next) - (next - b) / a) * a);
    e->step = fmax(e->step, fabs(step) / length);
    e->inverse = fmax(e->inverse, fabs(inverse) / length);
}

/* Random points of the range, both ends first. */
static void compare_all(const struct it2 *stage, struct errors *e)
{
    const double low = stage->lower.y, high = stage->upper.y;
    const double voltage = fmax(fabs(stage->lower.x), fabs(stage->upper.x));
    uint64_t seed = 11;

    for (int k = 0; k < POINTS; k++) {
        const double y = k == 0 ? low : k == 1 ? high : random_between(&seed, low, high);
        compare(stage, y, random_between(&seed, -0.1, 1.2) * voltage, random_between(&seed, low, high), e);
    }
}

static struct it2_table table;

static struct errors errors_of(const struct it2_rule *rules, int count, struct it2_range range, bool tabulated)
{
    struct errors e = { 0.0, 0.0 };
    struct it2 stage;

    it2_prepare(&stage, rules, count, range);
    CHECK(!tabulated || it2_tabulate(&stage, &table));
    compare_all(&stage, &e);
    return e;
}

/* --- accuracy ------------------------------------------------------------------------------------ */

#if LDBL_MANT_DIG > DBL_MANT_DIG

static struct errors largest(struct errors a, struct errors b)
{
    return (struct errors){ fmax(a.step, b.step), fmax(a.inverse, b.inverse) };
}

static void random_sets(void)
{
    struct it2_rule rules[IT2_MAX_RULES];
    struct errors table_errors = { 0.0, 0.0 }, rule_errors = { 0.0, 0.0 };
    uint64_t seed = 17;

    for (int i = 0; i < SETS; i++) {
        const int count = random_usable_rules(&seed, rules);
        table_errors = largest(table_errors, errors_of(rules, count, TABLE_1_RANGE, true));
        rule_errors = largest(rule_errors, errors_of(rules, count, TABLE_1_RANGE, false));
    }
    printf("table: of the range, step %.2g and inverse %.2g; the rules themselves %.2g and %.2g\n",
           table_errors.step, table_errors.inverse, rule_errors.step, rule_errors.inverse);
    CHECK(table_errors.step <= 1e-15);
    CHECK(table_errors.inverse <= 1e-15);
    CHECK(table_errors.step <= 1.25 * rule_errors.step);
    CHECK(table_errors.inverse <= 1.25 * rule_errors.inverse);
}

#else

static void random_sets(void)
{
    puts("table: long double is double here; compared with the same in double only");
}

#endif

/* A displacement may be counted from anywhere and in any unit: Table 1 in m, from 100 um on. */
static void other_units(void)
{
    struct it2_rule rules[3];
    const double zero = 100e-6;

    for (int l = 0; l < 3; l++) {
        const struct it2_rule *r = &TABLE_1[l];
        rules[l] = (struct it2_rule){ .sigmaLower = r->sigmaLower * 1e-6,
                                      .sigmaUpper = r->sigmaUpper * 1e-6,
                                      .centre = r->centre * 1e-6 + zero,
                                      .q1 = r->q1,
                                      .q2 = r->q2 * 1e-6,
                                      .q3 = r->q3 * 1e-6 + (1.0 - r->q1) * zero };
    }
    const struct it2_range range = { zero, zero + 16e-6 };
    const struct errors e = errors_of(rules, 3, range, true), by_rules = errors_of(rules, 3, range, false);
    const double farther = 116.0 / 16.0; /* what is rounded is as large as the farther end */
    CHECK(e.step <= 2.0 * by_rules.step && e.step < 0.5e-15 * farther);
    CHECK(e.inverse <= 2.0 * by_rules.inverse && e.inverse < 0.5e-15 * farther);
}

/* In a long run nothing adds up: the core contracts. */
static void long_run(void)
{
    struct it2 by_table, by_rules;
    struct it2_state a = { 5.0 }, b = { 5.0 };
    double off = 0.0;

    it2_prepare(&by_rules, TABLE_1, 3, TABLE_1_RANGE);
    by_table = by_rules;
    CHECK(it2_tabulate(&by_table, &table));
    for (int k = 0; k < 300000; k++) {
        const double x = 55.0 + 60.0 * sin(6.3e-3 * k) * sin(1e-4 * k); /* beyond both ends too */
        off = fmax(off, fabs(it2_step(&by_table, &a, x) - it2_step(&by_rules, &b, x)));
    }
    CHECK(off > 0.0 && off <= 16.0 * 1e-14);
}

/* --- where there is one -------------------------------------------------------------------------- */

static int rows_of(double deviation)
{
    struct it2_rule rules[3];
    struct it2 stage;

    memcpy(rules, TABLE_1, sizeof rules);
    for (int l = 0; l < 3; l++)
        rules[l].sigmaLower = deviation;
    it2_prepare(&stage, rules, 3, TABLE_1_RANGE);
    CHECK(it2_tabulate(&stage, &table) == (table.rows > 0));
    return table.rows;
}

static void widths_follow_the_deviation(void)
{
    CHECK(rows_of(2.0) == 129);
    CHECK(rows_of(1.0) == 257);
    CHECK(rows_of(8.0) < 129);
    CHECK(rows_of(0.25) == 0); /* would be a thousand */
}

/* Without one, each bit is that of the rules. */
static void none(void)
{
    const struct it2_rule narrow[] = { { 0.1, 0.2, 4.0, 0.5, 0.01, 1.0 }, { 0.1, 0.2, 12.0, 0.5, 0.02, 2.0 } };
    struct it2 stage, same;

    it2_prepare(&stage, narrow, 2, TABLE_1_RANGE);
    same = stage;
    CHECK(!it2_tabulate(&same, &table) && !same.table);
    for (int k = 0; k <= 160; k++)
        CHECK(it2_evaluate(&stage, 0.1 * k, 50.0) == it2_evaluate(&same, 0.1 * k, 50.0));
    it2_prepare(&stage, TABLE_1, 3, IT2_EVERYWHERE);
    CHECK(!it2_tabulate(&stage, &table) && !stage.table);
    it2_prepare(&stage, &(struct it2_rule){ .sigmaUpper = 1.0 }, 1, TABLE_1_RANGE);
    CHECK(!it2_tabulate(&stage, &table) && !stage.table);
}

/* Beyond the ends the core is its linearisation, bit for bit, and at the ends nothing jumps. */
static void beyond_the_ends(void)
{
    struct it2 by_table, by_rules;

    it2_prepare(&by_rules, TABLE_1, 3, TABLE_1_RANGE);
    by_table = by_rules;
    CHECK(it2_tabulate(&by_table, &table));
    for (int k = -2; k <= 2; k++) {
        const double x = 60.0 * k, below = nextafter(0.0, -1.0), above = nextafter(16.0, 17.0);
        CHECK(it2_evaluate(&by_table, -3.0, x) == it2_evaluate(&by_rules, -3.0, x));
        CHECK(it2_solve(&by_table, 18.0, x) == it2_solve(&by_rules, 18.0, x));
        CHECK_NEAR(it2_evaluate(&by_table, 0.0, x), it2_evaluate(&by_table, below, x), 16.0, 1e-15);
        CHECK_NEAR(it2_evaluate(&by_table, 16.0, x), it2_evaluate(&by_table, above, x), 16.0, 1e-15);
    }
    CHECK(isnan(it2_evaluate(&by_table, NAN, 50.0)));
    CHECK(isnan(it2_evaluate(&by_table, 5.0, NAN)));
}

/* --- of what it is ------------------------------------------------------------------------------- */

static void tabulate_anew(struct it2_table *made, const struct it2_rule *rules, struct it2_range range)
{
    struct it2 stage;

    it2_prepare(&stage, rules, 3, range);
    CHECK(it2_tabulate(&stage, made));
}

/* A table that served other rules or another range is made anew, to the same bits. */
static void follows_rules_and_range(void)
{
    static struct it2_table once, again;
    const struct it2_range wider = { 0.0, 17.0 };
    struct it2_rule rules[3];

    memcpy(rules, TABLE_1, sizeof rules);
    rules[1].q2 = 0.013;
    tabulate_anew(&again, TABLE_1, TABLE_1_RANGE);
    tabulate_anew(&again, rules, TABLE_1_RANGE);
    tabulate_anew(&again, rules, wider);
    tabulate_anew(&once, rules, wider);
    CHECK(memcmp(&once, &again, offsetof(struct it2_table, term)) == 0);
    CHECK(memcmp(once.term, again.term, (size_t)once.rows * sizeof once.term[0]) == 0);
}

/* Preparing ends it, and derivatives are those of the rules. */
static void prepare_ends_it(void)
{
    struct it2 stage, by_rules;

    it2_prepare(&by_rules, TABLE_1, 3, TABLE_1_RANGE);
    stage = by_rules;
    CHECK(it2_tabulate(&stage, &table) && stage.table);
    const struct it2_partials a = it2_partials(&stage, 7.0, 50.0), b = it2_partials(&by_rules, 7.0, 50.0);
    CHECK(a.dx == b.dx && a.dy == b.dy);
    it2_prepare(&stage, TABLE_1, 3, TABLE_1_RANGE);
    CHECK(!stage.table);
}

int main(void)
{
    random_sets();
    other_units();
    long_run();
    widths_follow_the_deviation();
    none();
    beyond_the_ends();
    follows_rules_and_range();
    prepare_ends_it();
    return check_report("table");
}
