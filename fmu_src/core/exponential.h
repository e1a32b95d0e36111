/* exp of several non-positive arguments at once.
 *
 * Each step of the model needs 2 L exponentials whose arguments are known together, so they are
 * computed in one polynomial over lanes. The loops have constant length and no branch: a C99
 * compiler turns them into vector instructions, and every compiler gets the same bits.
 *
 * exp(x) = 2^k exp(r), k = round(x / ln 2), |r| <= ln(2)/2, ln 2 split in two parts (Cody and Waite);
 * exp(r) = 1 + r + r^2 q(r) with q of degree 9, interpolated at Chebyshev nodes (error 1.7e-17).
 * Measured error below 1 unit in the last place (fmu_src/tests/test_it2.c). */
#ifndef IT2HYS_EXPONENTIAL_H
#define IT2HYS_EXPONENTIAL_H

#include <stdint.h>

enum { EXP_LANES = 4 };

/* Arguments below this give 0: the smallest power of two that is still a normal number. */
#define EXP_UNDERFLOW (-708.0)

union exp_lanes {
    double value[EXP_LANES];
    uint64_t bits[EXP_LANES];
};

/* y[i] = exp(x[i]) for EXP_LANES arguments x[i] <= 0, minus infinity included. */
static inline void exp_block(const double *x, double *y)
{
    const double log2_e = 1.4426950408889634;
    const double ln2_high = 0.6931471803691238;
    const double ln2_low = 1.9082149292705877e-10;
    const double round_to_integer = 6755399441055744.0; /* 1.5 * 2^52: the sum's low bits hold k */
    union exp_lanes k, result;

    for (int i = 0; i < EXP_LANES; i++)
        k.value[i] = x[i] * log2_e + round_to_integer;
    for (int i = 0; i < EXP_LANES; i++) {
        const double n = k.value[i] - round_to_integer;
        const double r = (x[i] - n * ln2_high) - n * ln2_low;
        const double r2 = r * r;
        const double r4 = r2 * r2;
        const double q01 = 0.5 + r * 0.16666666666666669;
        const double q23 = 0.04166666666662413 + r * 0.008333333333330062;
        const double q45 = 0.0013888888917213717 + r * 0.00019841269863053618;
        const double q67 = 2.4801521295954376e-05 + r * 2.7557268459997064e-06;
        const double q89 = 2.7620088445409746e-07 + r * 2.510038549551032e-08;
        const double q = (q01 + r2 * q23) + r4 * ((q45 + r2 * q67) + r4 * q89);
        result.value[i] = 1.0 + (r + r2 * q);
    }
    for (int i = 0; i < EXP_LANES; i++)
        result.bits[i] += k.bits[i] << 52;
    for (int i = 0; i < EXP_LANES; i++)
        y[i] = x[i] < EXP_UNDERFLOW ? 0.0 : result.value[i];
}

#endif
