/* The short sine: as exact as libm's, for phases of any size. */
#include "check.h"
#include "sets.h"
#include "sine.h"

CHECK_MAIN;

static void phases(double largest)
{
    uint64_t seed = 3;
    double off = 0.0;

    for (int i = 0; i < 200000; i++) {
        const double x = random_between(&seed, -largest, largest);
        off = fmax(off, fabs((double)(sine(x) - sinl(x))));
    }
    printf("sine: up to %g rad off by %.2g\n", largest, off);
    CHECK(off <= 3e-16);
}

/* Next to the multiples of pi / 2, where the rounding changes over and where hardly anything is left of x. */
static void near_quarters(void)
{
    for (int n = -4000; n <= 4000; n++)
        for (int i = -2; i <= 2; i++) {
            const double x = 1.5707963267948966 * n * (1.0 + i * 2.2e-16);
            CHECK_NEAR(sine(x), (double)sinl(x), 1.0, 3e-16);
        }
}

static void others(void)
{
    CHECK(sine(0.0) == 0.0);
    CHECK(isnan(sine(NAN)) && isnan(sine(INFINITY)) && isnan(sine(-INFINITY)));
    for (double x = 1e8; x < 1e300; x *= 1.7)
        CHECK_NEAR(sine(x), sin(x), 1.0, 3e-16);
}

int main(void)
{
    phases(1.6);
    phases(1e3);
    phases(1e6);
    phases(2e8);
    near_quarters();
    others();
    return check_report("sine");
}
