/* exp of a non-positive argument, short enough to be inlined into a loop over rules.
 *
 * The argument comes multiplied by 64 / ln 2, which it2_prepare folds into its constants: then the
 * reduction is exact. exp(x) = 2^(n / 64) 2^(r / 64) with the integer n next to the scaled argument and
 * |r| <= 1/2; the first factor is from a table, with the part that its rounding left off, the second is
 * 1 + p(r) with p of degree 5, interpolated at Chebyshev nodes (error 1e-18). Without a call, the
 * exponentials of one step overlap, and every compiler gets the same bits.
 * Measured error below 1 unit in the last place (fmu_src/tests/test_exponential.c). */
#ifndef IT2HYS_EXPONENTIAL_H
#define IT2HYS_EXPONENTIAL_H

#include <stdint.h>

#define EXP_STEPS 64 /* per factor of two */

/* Factor of the arguments, 64 / ln 2. */
#define EXP_SCALE 92.332482616893656877

/* Scaled arguments below this give 0: the smallest power of two that is still a normal number. */
#define EXP_UNDERFLOW (-1022.0 * EXP_STEPS)

#include "exponential_table.h"

union exp_number {
    double value;
    uint64_t bits;
};

/* exp(x / EXP_SCALE) of two x <= 0, minus infinity included. Loops of two lanes become vector
 * instructions on every 64-bit machine; only the table is read lane by lane. */
static inline void exp_scaled_pair(const double x[2], double result[2])
{
    const double round_to_integer = 6755399441055744.0; /* 1.5 * 2^52: the sum's low bits hold n */
    union exp_number n[2], power[2];
    double tail[2];

    for (int i = 0; i < 2; i++)
        n[i].value = x[i] + round_to_integer;
    for (int i = 0; i < 2; i++) {
        const unsigned j = (unsigned)(n[i].bits % EXP_STEPS);
        power[i].bits = EXP_TABLE[j].bits + (n[i].bits << 46);
        tail[i] = EXP_TABLE[j].tail;
    }
    for (int i = 0; i < 2; i++) {
        const double r = x[i] - (n[i].value - round_to_integer);
        const double r2 = r * r;
        const double p01 = tail[i] + r * 0.010830424696249145;
        const double p23 = 5.864904955054418e-05 + r * 2.1173137155462066e-07;
        const double p45 = 5.732857292414682e-10 + r * 1.2417852371895379e-12;
        /* three short products beside each other, not one long chain: a step waits for the last one */
        result[i] = power[i].value + power[i].value * ((p01 + r2 * p23) + r2 * r2 * p45);
    }
    for (int i = 0; i < 2; i++)
        result[i] = x[i] < EXP_UNDERFLOW ? 0.0 : result[i];
}

#endif
