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

#include "real.h"

#if defined IT2HYS_SINGLE

#include "exponential_single.h"

#else

#define EXP_STEPS 64 /* per factor of two */
#define EXP_SHIFT 46 /* from the low bits to the exponent, past log2(EXP_STEPS) of them */

/* Factor of the arguments, 64 / ln 2. */
#define EXP_SCALE 92.332482616893656877

/* Scaled arguments below this give 0: the smallest power of two that is still a normal number. */
#define EXP_UNDERFLOW (-1022.0 * EXP_STEPS)

#include "exponential_table.h"

/* 1.5 * 2^52: a sum with it is rounded to an integer, which stands in its low bits. */
#define EXP_ROUND 6755399441055744.0

/* 2^(r/64) - 1, and what the table's rounding left off: of doubles or of vectors of them. Short products
 * beside each other, not one long chain, and what is looked up comes last: a step waits for the slowest. */
#define EXP_REST(r, r2, tail) \
    ((tail) + (((r) * 0.010830424696249145 + (r2) * (5.864904955054418e-05 + (r) * 2.1173137155462066e-07)) + \
               (r2) * (r2) * (5.732857292414682e-10 + (r) * 1.2417852371895379e-12)))

/* exp(x / EXP_SCALE) of two x in EXP_UNDERFLOW..0. */
#if defined __GNUC__ && !defined EXP_ONE_BY_ONE

/* Two lanes beside each other, which compilers do not find by themselves in every surrounding; only the
 * table is read lane by lane. */
typedef double exp_lanes __attribute__((vector_size(16)));
typedef uint64_t exp_words __attribute__((vector_size(16)));

static inline void exp_scaled_normal_pair(const real x[2], real result[2])
{
    const exp_lanes scaled = { x[0], x[1] };
    const exp_lanes n = scaled + EXP_ROUND;
    const exp_words bits = (exp_words)n;
    const unsigned j = (unsigned)(bits[0] % EXP_STEPS);
    const unsigned k = (unsigned)(bits[1] % EXP_STEPS);
    const exp_words nearest = { EXP_BITS[j], EXP_BITS[k] };
    const exp_lanes tail = { EXP_TAIL[j], EXP_TAIL[k] };
    /* a shift, but of vectors gcc's analyzer takes none */
    const exp_lanes power = (exp_lanes)(nearest + bits * ((uint64_t)1 << EXP_SHIFT));
    const exp_lanes r = scaled - (n - EXP_ROUND);
    const exp_lanes r2 = r * r;
    const exp_lanes y = power + power * EXP_REST(r, r2, tail);

    result[0] = y[0];
    result[1] = y[1];
}

#else

static inline void exp_scaled_normal_pair(const real x[2], real result[2])
{
    for (int i = 0; i < 2; i++) {
        union {
            real value;
            uint64_t bits;
        } n = { x[i] + EXP_ROUND }, power;
        const unsigned j = (unsigned)(n.bits % EXP_STEPS);
        power.bits = EXP_BITS[j] + (n.bits << EXP_SHIFT);
        const real r = x[i] - (n.value - EXP_ROUND);
        const real r2 = r * r;
        result[i] = power.value + power.value * EXP_REST(r, r2, EXP_TAIL[j]);
    }
}

#endif

#endif

/* The same of any x <= 0, minus infinity included. */
static inline void exp_scaled_pair(const real x[2], real result[2])
{
#if defined IT2HYS_SINGLE /* an integer is made of it */
    const real normal[2] = { real_fmax(x[0], EXP_UNDERFLOW), real_fmax(x[1], EXP_UNDERFLOW) };
#else
    const real *normal = x;
#endif

    exp_scaled_normal_pair(normal, result);
    for (int i = 0; i < 2; i++)
        result[i] = x[i] < EXP_UNDERFLOW ? 0 : result[i];
}

#endif
