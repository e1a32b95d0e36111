/* (10) as a table, for runs of many ticks with the same rules. It is affine in the voltage,
 *     y_k = A(y_{k-1}) x_k + B(y_{k-1}),    A = sum q2 w / sum w,  B = sum (q1 y_{k-1} + q3) w / sum w,  w = f + F,
 * and A and B are smooth functions of one variable: polynomials on short intervals, interpolated at Chebyshev
 * nodes, hold them to rounding. A step is then one look-up and a few multiplications and additions, however
 * many rules there are: no exponential and no division. (30) is x = (y - B) / A of the same table.
 *
 * An interval's width is a power of two and its middle a multiple of it. So nothing is lost on the way to the
 * interval, and it takes three additions: with 1.5 * 2^52 widths added, y is rounded to a multiple of the
 * width, whose number stands in the low bits of the sum. */
#ifndef IT2HYS_IT2_TABLE_H
#define IT2HYS_IT2_TABLE_H

#include <stdint.h>

#include "it2.h"

/* As many rows as fit into a processor's nearest memory beside other things, 33 KB; none in single precision. */
#if defined IT2HYS_SINGLE
enum { IT2_TABLE_ROWS = 1 };
#else
enum { IT2_TABLE_ROWS = 260 };
#endif
enum { IT2_TABLE_TERMS = 8 };

struct it2_table {
    int rules; /* what it was made of: rules and range */
    struct it2_rule rule[IT2_MAX_RULES];
    struct it2_range range;
    int rows;                                      /* 0 where there would be too many */
    real rounding;                                 /* 1.5 * 2^52 widths */
    uint32_t first;                                /* low bits of the sum in the first row */
    real term[IT2_TABLE_ROWS][IT2_TABLE_TERMS][2]; /* of A and of B, by powers of the distance to the middle */
};

#if !defined IT2HYS_SINGLE

static inline uint32_t it2_table_number(const struct it2_table *table, real y)
{
    union {
        real value;
        uint64_t bits;
    } sum = { y + table->rounding };

    return (uint32_t)sum.bits;
}

/* Short products beside each other, not one long chain: a step waits for the slowest. */
static inline real it2_polynomial(const real term[IT2_TABLE_TERMS][2], int i, real r, real r2, real r4)
{
    return ((term[0][i] + term[1][i] * r) + (term[2][i] + term[3][i] * r) * r2) +
           ((term[4][i] + term[5][i] * r) + (term[6][i] + term[7][i] * r) * r2) * r4;
}

/* A and B for y_{k-1} within the range. */
static inline void it2_look_up(const struct it2_table *table, real y_previous, real *a, real *b)
{
    const real(*term)[2] = table->term[it2_table_number(table, y_previous) - table->first];
    const real r = y_previous - ((y_previous + table->rounding) - table->rounding);
    const real r2 = r * r, r4 = r2 * r2;

    *a = it2_polynomial(term, 0, r, r2, r4);
    *b = it2_polynomial(term, 1, r, r2, r4);
}

#else /* exact code only: a table to float's precision would be another one */

static inline void it2_look_up(const struct it2_table *table, real y_previous, real *a, real *b)
{
    (void)table, (void)y_previous;
    *a = *b = 0;
}

#endif

#endif
