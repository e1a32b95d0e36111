/* exp_scaled_pair against long double exp2l: below 1 unit in the last place. */
#include <float.h>

#include "check.h"
#include "exponential.h"
#include "sets.h"

CHECK_MAIN;

enum { ARGUMENTS = 400000 };

/* Both lanes compute the same. */
static double exp_scaled(double x)
{
    const double pair[2][2] = { { x, -1.0 }, { -1.0, x } };
    double first[2], second[2];

    exp_scaled_pair(pair[0], first);
    exp_scaled_pair(pair[1], second);
    CHECK(first[0] == second[1] || isnan(x));
    return first[0];
}

/* x is scaled: the exact value is 2^(x / 64). */
static double error_in_ulp(double x, double y)
{
    const long double exact = exp2l((long double)x / EXP_STEPS);
    int exponent;

    frexp((double)exact, &exponent);
    return (double)(fabsl((long double)y - exact) / ldexpl(1.0L, exponent - DBL_MANT_DIG));
}

static double worst_over(double low, double high, uint64_t seed)
{
    double worst = 0.0;

    for (int i = 0; i < ARGUMENTS; i++) {
        const double x = random_between(&seed, low, high);
        worst = fmax(worst, error_in_ulp(x, exp_scaled(x)));
    }
    return worst;
}

static void accuracy(void)
{
    const double low[] = { EXP_UNDERFLOW, -4000.0, -100.0, -1.0, -1e-3, -1e-9 };

    for (int i = 0; i < 6; i++) {
        const double worst = worst_over(low[i], 0.0, 1u + (uint64_t)i);
        printf("exp_scaled over [%g, 0]: worst error %.4f ulp\n", low[i], worst);
        CHECK(worst < 1.0);
    }
    for (int n = -1021 * EXP_STEPS; n < 0; n++) { /* either side of where n changes */
        const double middle = n + 0.5;
        CHECK(error_in_ulp(middle, exp_scaled(middle)) < 1.0);
        CHECK(error_in_ulp(nextafter(middle, 0.0), exp_scaled(nextafter(middle, 0.0))) < 1.0);
        CHECK(error_in_ulp(nextafter(middle, -1e6), exp_scaled(nextafter(middle, -1e6))) < 1.0);
    }
    CHECK_CLOSE(exp_scaled(-3.0 * EXP_SCALE), exp(-3.0), 1e-15);
}

static void ends(void)
{
    CHECK(exp_scaled(0.0) == 1.0);
    CHECK(exp_scaled(-0.0) == 1.0);
    CHECK(exp_scaled(-DBL_MIN) == 1.0);
    CHECK(exp_scaled(EXP_UNDERFLOW) > 0.0);
    CHECK(exp_scaled(nextafter(EXP_UNDERFLOW, -1e6)) == 0.0);
    CHECK(exp_scaled(-1e5) == 0.0);
    CHECK(exp_scaled(-1e18) == 0.0);
    CHECK(exp_scaled(-DBL_MAX) == 0.0);
    CHECK(exp_scaled(-INFINITY) == 0.0);
    CHECK(isnan(exp_scaled(NAN)));
}

int main(void)
{
    accuracy();
    ends();
    return check_report("exponential");
}
