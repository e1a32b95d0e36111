/* Eq. (10) over complex numbers, written straight from the paper: with a step of 1e-30 along the
 * imaginary axis its imaginary part is a derivative without cancellation (complex step). */
#ifndef IT2HYS_TEXTBOOK_COMPLEX_H
#define IT2HYS_TEXTBOOK_COMPLEX_H

#include <complex.h>

#include "it2.h"

#define COMPLEX_STEP 1e-30

/* p: 6 numbers per rule, in the order of struct it2_rule. */
static inline double complex textbook_complex(const double complex *p, int count, double complex y,
                                              double complex x)
{
    double complex numerator = 0.0;
    double complex sum = 0.0;

    for (int l = 0; l < count; l++) {
        const double complex *r = p + IT2_RULE_PARAMETERS * l;
        const double complex d = y - r[2];
        const double complex weight = cexp(-d * d / (2.0 * r[0] * r[0])) + cexp(-d * d / (2.0 * r[1] * r[1]));
        numerator += (r[3] * y + r[4] * x + r[5]) * weight;
        sum += weight;
    }
    return numerator / sum;
}

static inline void complex_rules(const struct it2_rule *rules, int count, double complex *p)
{
    for (int l = 0; l < count; l++) {
        const double r[] = { rules[l].sigmaLower, rules[l].sigmaUpper, rules[l].centre,
                             rules[l].q1,         rules[l].q2,         rules[l].q3 };
        for (int i = 0; i < IT2_RULE_PARAMETERS; i++)
            p[IT2_RULE_PARAMETERS * l + i] = r[i];
    }
}

#endif
