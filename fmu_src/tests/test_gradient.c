/* (13) to (18): against a transcription of the paper, complex steps and finite differences. */
#include "check.h"
#include "sets.h"
#include "textbook_complex.h"

CHECK_MAIN;

enum { MAX_PARAMETERS = IT2_RULE_PARAMETERS * IT2_MAX_RULES };

/* (13) to (18) as printed; order of struct it2_rule. */
static void transcription(const struct it2_rule *rules, int count, double y, double x, double *gradient)
{
    double D = 0.0;
    double numerator = 0.0;

    for (int pass = 0; pass < 2; pass++)
        for (int l = 0; l < count; l++) {
            const struct it2_rule *r = &rules[l];
            const double d = y - r->centre;
            const double s1 = r->sigmaLower, s2 = r->sigmaUpper;
            const double f = exp(-d * d / (2.0 * s1 * s1)), F = exp(-d * d / (2.0 * s2 * s2));
            const double n = r->q1 * y + r->q2 * x + r->q3;
            double *g = gradient + IT2_RULE_PARAMETERS * l;
            if (pass == 0) {
                D += f + F;
                numerator += n * (f + F);
                continue;
            }
            const double excess = n - numerator / D;
            g[0] = f * d * d / (s1 * s1 * s1) * excess / D;              /* (14) */
            g[1] = F * d * d / (s2 * s2 * s2) * excess / D;              /* (15) */
            g[2] = (f * d / (s1 * s1) + F * d / (s2 * s2)) * excess / D; /* (13) */
            g[3] = y * (f + F) / D;                                      /* (16) */
            g[4] = x * (f + F) / D;                                      /* (17) */
            g[5] = (f + F) / D;                                          /* (18) */
        }
}

static double largest(const double *values, int count)
{
    double size = 0.0;

    for (int i = 0; i < count; i++)
        size = fmax(size, fabs(values[i]));
    return size;
}

static void against_transcription_and_complex_step(const struct it2_rule *rules, int count, double y, double x)
{
    const int parameters = IT2_RULE_PARAMETERS * count;
    double gradient[MAX_PARAMETERS], printed[MAX_PARAMETERS];
    double complex p[MAX_PARAMETERS];
    struct it2_partials partials;
    struct it2 stage;

    it2_prepare(&stage, rules, count, IT2_EVERYWHERE);
    const double value = it2_gradient(&stage, y, x, gradient, &partials);
    transcription(rules, count, y, x, printed);
    complex_rules(rules, count, p);
    const double scale = largest(printed, parameters);
    CHECK(value == it2_evaluate(&stage, y, x));
    for (int i = 0; i < parameters; i++) {
        CHECK_NEAR(gradient[i], printed[i], scale, 1e-13);
        p[i] += COMPLEX_STEP * I;
        const double step = cimag(textbook_complex(p, count, y, x)) / COMPLEX_STEP;
        CHECK_NEAR(gradient[i], step, scale, 1e-12);
        p[i] = creal(p[i]);
    }
    CHECK_NEAR(partials.dx, cimag(textbook_complex(p, count, y, x + COMPLEX_STEP * I)) / COMPLEX_STEP,
               partials.dx, 1e-12);
    CHECK_NEAR(partials.dy, cimag(textbook_complex(p, count, y + COMPLEX_STEP * I, x)) / COMPLEX_STEP,
               fmax(1.0, fabs(partials.dy)), 1e-11);
    const struct it2_state state = { y };
    CHECK(it2_derivative(&stage, &state, x) == partials.dx);
    CHECK(it2_partials(&stage, y, x).dx == partials.dx);
    CHECK(it2_partials(&stage, y, x).dy == partials.dy);
}

static void random_points(void)
{
    struct it2_rule rules[IT2_MAX_RULES];
    uint64_t seed = 11;

    for (int trial = 0; trial < 500; trial++) {
        const int count = random_count(&seed);
        random_rules(&seed, rules, count);
        against_transcription_and_complex_step(rules, count, random_between(&seed, -5.0, 25.0),
                                               random_between(&seed, 1.0, 150.0));
    }
    for (int k = 0; k <= 32; k++)
        against_transcription_and_complex_step(TABLE_1, 3, 0.5 * k, 60.0);
}

/* Finite differences need no oracle but the model itself; they reach the fallback far away too. */
static void finite_differences(void)
{
    const double at[] = { 0.0, 0.0892, 3.0, 8.6067, 15.0, 18.0, 300.0, 900.0, -900.0, 2000.0 };
    struct it2 stage;

    it2_prepare(&stage, TABLE_1, 3, IT2_EVERYWHERE);
    for (size_t i = 0; i < sizeof at / sizeof at[0]; i++) {
        const double y = at[i], x = 60.0, h = 1e-5 * fmax(1.0, fabs(y));
        const struct it2_partials d = it2_partials(&stage, y, x);
        const double dx = it2_evaluate(&stage, y, x + 1.0) - it2_evaluate(&stage, y, x - 1.0);
        const double dy = it2_evaluate(&stage, y + h, x) - it2_evaluate(&stage, y - h, x);
        CHECK_NEAR(d.dx, dx / 2.0, d.dx, 1e-9);
        CHECK_NEAR(d.dy, dy / (2.0 * h), 1.0, 1e-8);
        CHECK_CLOSE(d.dx, it2_derivative(&stage, &(struct it2_state){ y }, x), 1e-15);
    }
}

int main(void)
{
    random_points();
    finite_differences();
    return check_report("gradient");
}
