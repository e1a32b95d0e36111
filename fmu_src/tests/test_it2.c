/* Eq. (10): Table 1 under (22), a textbook implementation, and far from every centre. */
#include <stdlib.h>

#include "check.h"
#include "it2_membership.h"
#include "sets.h"

CHECK_MAIN;

/* (7) to (12) as they stand in the paper. */
static double textbook(const struct it2_rule *rules, int count, double y, double x)
{
    double numerator = 0.0;
    double denominator = 0.0;

    for (int l = 0; l < count; l++) {
        const struct it2_rule *r = &rules[l];
        const double d = y - r->centre;
        const double f = exp(-d * d / (2.0 * r->sigmaLower * r->sigmaLower));
        const double F = exp(-d * d / (2.0 * r->sigmaUpper * r->sigmaUpper));
        numerator += (r->q1 * y + r->q2 * x + r->q3) * (f + F);
        denominator += f + F;
    }
    return numerator / denominator;
}

/* How much the terms of the numerator cancel: the scale on which rounding is to be judged. */
static double size_of_terms(const struct it2_rule *rules, int count, double y, double x)
{
    double largest = 0.0;

    for (int l = 0; l < count; l++)
        largest = fmax(largest, fabs(rules[l].q1 * y) + fabs(rules[l].q2 * x) + fabs(rules[l].q3));
    return largest;
}

/* (22) */
static double excitation(int k)
{
    const double pi = 3.14159265358979323846;
    const double t = 1e-4 * k;

    return 40.0 * sin(2.0 * pi * 50.0 * t - pi / 2.0) + 22.5 * sin(2.0 * pi * 25.0 * t - pi / 2.0) + 62.5;
}

static void table_1_under_22(void)
{
    struct it2 stage;
    struct it2_state state;
    double expected = 0.0;
    double first = 0.0;
    double lowest = 1e9;
    double highest = -1e9;

    it2_prepare(&stage, TABLE_1, 3, IT2_EVERYWHERE);
    it2_reset(&state, 0.0);
    for (int k = 1; k < 4000; k++) {
        const double y = it2_step(&stage, &state, excitation(k));
        expected = textbook(TABLE_1, 3, expected, excitation(k));
        CHECK_CLOSE(y, expected, 1e-12);
        CHECK(y == state.y);
        if (k == 1)
            first = y;
        if (k >= 3200) {
            lowest = fmin(lowest, y);
            highest = fmax(highest, y);
        }
    }
    CHECK_NEAR(first, 0.0545671, 1.0, 1e-7); /* 0.05456705: rounds to either digit */
    CHECK_NEAR(lowest, 0.842742, 1.0, 0.5e-6);
    CHECK_NEAR(highest, 15.310268, 1.0, 0.5e-6);
}

static void random_sets_against_the_textbook(void)
{
    struct it2_rule rules[IT2_MAX_RULES];
    struct it2 stage;
    uint64_t seed = 7;

    for (int trial = 0; trial < 3000; trial++) {
        const int count = trial < IT2_MAX_RULES ? trial + 1 : random_count(&seed);
        random_rules(&seed, rules, count);
        it2_prepare(&stage, rules, count, IT2_EVERYWHERE);
        const double y = random_between(&seed, -5.0, 25.0);
        const double x = random_between(&seed, -10.0, 150.0);
        const double expected = textbook(rules, count, y, x);
        CHECK_NEAR(it2_evaluate(&stage, y, x), expected, size_of_terms(rules, count, y, x), 1e-13);
        CHECK_CLOSE(it2_evaluate(&stage, y, x), expected, 1e-11); /* after cancellation */
    }
}

/* The units do not matter: in metres the same values come out. */
static void si_units(void)
{
    struct it2_rule rules[3];
    struct it2 um, m;

    for (int l = 0; l < 3; l++) {
        const struct it2_rule *r = &TABLE_1[l];
        rules[l] = (struct it2_rule){ r->sigmaLower * 1e-6, r->sigmaUpper * 1e-6, r->centre * 1e-6, r->q1,
                                      r->q2 * 1e-6,         r->q3 * 1e-6 };
    }
    it2_prepare(&um, TABLE_1, 3, IT2_EVERYWHERE);
    it2_prepare(&m, rules, 3, IT2_EVERYWHERE);
    for (int k = 0; k <= 160; k++)
        CHECK_CLOSE(it2_evaluate(&m, 1e-7 * k, 60.0), 1e-6 * it2_evaluate(&um, 0.1 * k, 60.0), 1e-12);
}

/* Rule 3 has the widest upper membership: far away it is the only one that counts. */
static double rule_3(double y, double x)
{
    return TABLE_1[2].q1 * y + TABLE_1[2].q2 * x + TABLE_1[2].q3;
}

static void far_from_all_centres(void)
{
    const double far[] = { 1e3, -1e3, 1e6, -1e6, 1e20, -1e20, 1e100, -1e100, 1e150, -1e150, 1e200, -1e300 };
    struct it2 stage;

    it2_prepare(&stage, TABLE_1, 3, IT2_EVERYWHERE);
    for (size_t i = 0; i < sizeof far / sizeof far[0]; i++) {
        CHECK(isfinite(it2_evaluate(&stage, far[i], 50.0)));
        CHECK_CLOSE(it2_evaluate(&stage, far[i], 50.0), rule_3(far[i], 50.0), 1e-12);
        CHECK(isfinite(it2_solve(&stage, far[i], 1.0)));
    }
    CHECK(isnan(it2_evaluate(&stage, NAN, 50.0)));
    CHECK(!isfinite(it2_evaluate(&stage, INFINITY, 50.0)));
    CHECK(!isfinite(it2_evaluate(&stage, 1.0, INFINITY)));
}

/* Between two narrow rules, far from both: the nearest one wins, not 0/0. */
static void between_narrow_rules(void)
{
    const struct it2_rule rules[] = { { 1e-3, 1e-3, 0.0, 0.5, 0.01, 1.0 },
                                      { 1e-3, 1e-3, 10.0, 0.5, 0.02, 2.0 } };
    struct it2 stage;

    it2_prepare(&stage, rules, 2, IT2_EVERYWHERE);
    CHECK_CLOSE(it2_evaluate(&stage, 4.9, 10.0), 0.5 * 4.9 + 0.1 + 1.0, 1e-14);
    CHECK_CLOSE(it2_evaluate(&stage, 5.1, 10.0), 0.5 * 5.1 + 0.2 + 2.0, 1e-14);
    CHECK_CLOSE(it2_evaluate(&stage, 5.0, 10.0), 2.5 + 0.15 + 1.5, 1e-12);
}

static double sum_of_memberships(const struct it2 *stage, double y)
{
    struct it2_memberships m;

    it2_memberships(stage, y, &m);
    return m.sum;
}

/* Where the fallback takes over nothing jumps: (10) is invariant under scaling the memberships. */
static void continuous_across_the_fallback(void)
{
    struct it2 stage;
    double near = 19.0; /* sum above the threshold */
    double far = 5000.0;

    it2_prepare(&stage, TABLE_1, 3, IT2_EVERYWHERE);
    while (far - near > 1e-9 * near) { /* the fallback shows by a sum of order 1 */
        const double middle = 0.5 * (near + far);
        const double d = (middle - TABLE_1[2].centre) / TABLE_1[2].sigmaUpper;
        *(exp(-0.5 * d * d) >= IT2_SUM_UNDERFLOW ? &near : &far) = middle;
    }
    CHECK(sum_of_memberships(&stage, near) < 1e-270);
    CHECK(sum_of_memberships(&stage, far) >= 1.0);
    const double slope = TABLE_1[2].q1 * (far - near);
    CHECK_CLOSE(it2_evaluate(&stage, far, 50.0), it2_evaluate(&stage, near, 50.0) + slope, 1e-12);
    CHECK_CLOSE(it2_solve(&stage, far, 50.0), it2_solve(&stage, near, 50.0), 1e-6);
}

/* The checks that are left out where nothing can underflow change no bit. */
static void checks_change_nothing(void)
{
    struct it2 stage, checked;
    uint64_t seed = 7;

    for (int i = 0; i < 1000; i++) {
        const double narrow = random_between(&seed, 0.2, 3.0);
        const struct it2_rule rules[] = {
            { narrow, narrow * random_between(&seed, 1.0, 5.0), 0.0, 0.9, 0.02, 0.1 },
            { narrow, narrow * random_between(&seed, 1.0, 5.0), 16.0, 0.8, 0.03, 0.2 },
        };
        it2_prepare(&stage, rules, 2, IT2_EVERYWHERE);
        checked = stage;
        checked.plain = (struct it2_range){ 1.0, -1.0 };
        for (int k = 0; k < 100; k++) {
            const double y = random_between(&seed, -150.0, 150.0), x = random_between(&seed, 0.0, 150.0);
            CHECK(it2_evaluate(&stage, y, x) == it2_evaluate(&checked, y, x));
            CHECK(it2_solve(&stage, y, x) == it2_solve(&checked, y, x));
            CHECK(!it2_is_plain(&stage, y) || sum_of_memberships(&checked, y) > IT2_SUM_UNDERFLOW);
        }
    }
}

static void without_numbers_is_checked(void)
{
    static const double bad[] = { 0.0, 1e-200, NAN };

    for (int i = 0; i < 3; i++) {
        const struct it2_rule rules[] = { { bad[i], 1.0, 0.0, 0.9, 0.02, 0.1 } };
        struct it2 stage;
        it2_prepare(&stage, rules, 1, IT2_EVERYWHERE);
        CHECK(!it2_is_plain(&stage, 0.0));
    }
}

static void one_rule_is_linear(void)
{
    const struct it2_rule rule = { 1.0, 2.0, 3.0, 0.9, 0.02, 0.1 };
    struct it2 stage;

    it2_prepare(&stage, &rule, 1, IT2_EVERYWHERE);
    for (int y = -400; y <= 400; y++)
        CHECK_NEAR(it2_evaluate(&stage, y, 5.0), 0.9 * y + 0.2, 1.0 + abs(y), 4e-16);
}

int main(void)
{
    table_1_under_22();
    random_sets_against_the_textbook();
    si_units();
    far_from_all_centres();
    between_narrow_rules();
    continuous_across_the_fallback();
    checks_change_nothing();
    without_numbers_is_checked();
    one_rule_is_linear();
    return check_report("it2");
}
