/* (10) as a table, for runs of many ticks with the same rules. It is affine in the voltage,
 *     y_k = A(y_{k-1}) x_k + B(y_{k-1}),    A = sum q2 w / sum w,  B = sum (q1 y_{k-1} + q3) w / sum w,  w = f + F,
 * and A and B are smooth functions of one variable: polynomials on short intervals, interpolated at Chebyshev
 * nodes, hold them to rounding. A step is then one look-up and a few multiplications and additions, however
 * many rules there are: no exponential and no division. (30) is x = (y - B) / A of the same table.
 *
 * An interval's width is a power of two and its middle a multiple of it. So nothing is lost on the way to the
 * interval, and it takes three additions: with 1.5 * 2^52 widths added, less the first row's number, y is rounded
 * to a multiple of the width, and the row stands in the low bits of the sum. */
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
    real rounding;                                 /* what is added to y */
    real term[IT2_TABLE_ROWS][IT2_TABLE_TERMS][2]; /* of A and of B, by powers of the distance to the middle */
};

/* Within the range, where nothing can underflow either: neither exponentials nor their sum need be checked. */
static inline bool it2_is_plain(const struct it2 *stage, real y_previous)
{
    return y_previous >= stage->plain.minimum && y_previous <= stage->plain.maximum;
}

#if !defined IT2HYS_SINGLE

/* Where y is in its row, and the powers of that. */
struct it2_place {
    const real (*term)[2];
    real r, r2, r4;
};

static inline uint32_t it2_table_row(real rounded)
{
    union {
        real value;
        uint64_t bits;
    } sum = { rounded };

    return (uint32_t)sum.bits;
}

static inline struct it2_place it2_place(const struct it2_table *table, real y)
{
    const real rounded = y + table->rounding;
    const real r = y - (rounded - table->rounding);
    const real r2 = r * r;

    return (struct it2_place){ table->term[it2_table_row(rounded)], r, r2, r2 * r2 };
}

/* A pair of terms, without the power of r that they have in common. */
static inline real it2_pair(const struct it2_place *at, int i, int power)
{
    return at->term[power][i] + at->term[power + 1][i] * at->r;
}

/* A x + B: products beside each other, not one long chain, because a step waits for the slowest. */
static inline real it2_look_up_step(const struct it2_table *table, real y_previous, real x)
{
    const struct it2_place at = it2_place(table, y_previous);
    const real x2 = x * at.r2, x4 = x * at.r4, r6 = at.r2 * at.r4, x6 = x2 * at.r4;

    return ((it2_pair(&at, 0, 0) * x + it2_pair(&at, 1, 0)) +
            (it2_pair(&at, 0, 2) * x2 + it2_pair(&at, 1, 2) * at.r2)) +
           ((it2_pair(&at, 0, 4) * x4 + it2_pair(&at, 1, 4) * at.r4) +
            (it2_pair(&at, 0, 6) * x6 + it2_pair(&at, 1, 6) * r6));
}

/* A or B. */
static inline real it2_polynomial(const struct it2_place *at, int i)
{
    return (it2_pair(at, i, 0) + it2_pair(at, i, 2) * at->r2) +
           (it2_pair(at, i, 4) + it2_pair(at, i, 6) * at->r2) * at->r4;
}

/* (y - B) / A */
static inline real it2_look_up_inverse(const struct it2_table *table, real y_previous, real y)
{
    const struct it2_place at = it2_place(table, y_previous);

    return (y - it2_polynomial(&at, 1)) / it2_polynomial(&at, 0);
}

#else /* exact code only: a table to float's precision would be another one */

static inline real it2_look_up_step(const struct it2_table *table, real y_previous, real x)
{
    (void)table, (void)y_previous;
    return x;
}

static inline real it2_look_up_inverse(const struct it2_table *table, real y_previous, real y)
{
    (void)table, (void)y_previous;
    return y;
}

#endif

/* --- steps, in the places where they are taken ---------------------------------------------------- */

static inline real it2_evaluate(const struct it2 *stage, real y_previous, real x)
{
    return stage->table && it2_is_plain(stage, y_previous) ? it2_look_up_step(stage->table, y_previous, x)
                                                           : it2_evaluate_rules(stage, y_previous, x);
}

static inline real it2_solve(const struct it2 *stage, real y_previous, real y)
{
    return stage->table && it2_is_plain(stage, y_previous) ? it2_look_up_inverse(stage->table, y_previous, y)
                                                           : it2_solve_rules(stage, y_previous, y);
}

/* The core as a stage that the chain always has. Both advance the state. */
static inline real it2_step(const struct it2 *stage, struct it2_state *state, real x)
{
    state->y = it2_evaluate(stage, state->y, x);
    return state->y;
}

static inline real it2_inverse(const struct it2 *stage, struct it2_state *state, real y)
{
    const real x = it2_solve(stage, state->y, y);

    state->y = y;
    return x;
}

#endif
