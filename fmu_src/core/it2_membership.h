/* The memberships (8), (9), (11), (12), evaluated for all rules at once. */
#ifndef IT2HYS_IT2_MEMBERSHIP_H
#define IT2HYS_IT2_MEMBERSHIP_H

#include <stdbool.h>

#include "exponential.h"
#include "it2_table.h"

struct it2_memberships {
    real lower[IT2_MAX_RULES];  /* f_l */
    real upper[IT2_MAX_RULES];  /* F_l */
    real weight[IT2_MAX_RULES]; /* f_l + F_l */
    real sum;                   /* D of (10) */
};

/* Below this sum some memberships have underflowed while others still count, or products with them have.
 * A membership with a scaled exponent above IT2_NO_UNDERFLOW is above it. The square of IT2_FARTHEST times an
 * exponent is finite: the widest rule stays the nearest one. */
#if defined IT2HYS_SINGLE
#define IT2_SUM_UNDERFLOW REAL(1e-12)
#define IT2_NO_UNDERFLOW (-39)
#define IT2_FARTHEST REAL(1e9)
#else
#define IT2_SUM_UNDERFLOW 1e-280
#define IT2_NO_UNDERFLOW (-59000)
#define IT2_FARTHEST 1e140
#endif

static inline void it2_exponents(const struct it2 *stage, int l, real y_previous, real scaled[2])
{
    const real distance = y_previous - stage->rule[l].centre;
    const real square = distance * distance;

    scaled[0] = square * stage->exponent[l][0];
    scaled[1] = square * stage->exponent[l][1];
}

/* (8), (11) and (9), (12) for one rule, where it2_is_plain; returns f_l + F_l. */
static inline real it2_membership(const struct it2 *stage, int l, real y_previous, real *lower, real *upper)
{
    real scaled[2];
    real membership[2] = { 0, 0 }; /* gcc's analyzer cannot follow the lanes */

    it2_exponents(stage, l, y_previous, scaled);
    exp_scaled_normal_pair(scaled, membership);
    *lower = membership[0];
    *upper = membership[1];
    return *lower + *upper;
}

HIDDEN_BEGIN
/* it2_memberships for any y_{k-1}. */
void it2_memberships_anywhere(const struct it2 *stage, real y_previous, struct it2_memberships *m);

/* An end of the range at y, from a stage that is (10) there; of an infinite one only that. */
struct it2_end it2_end_at(const struct it2 *stage, real y);

/* it2_gradient for y_{k-1} beyond an end. */
real it2_gradient_beyond(const struct it2 *stage, const struct it2_end *end, real y_previous, real x,
                         real *gradient, struct it2_partials *partials);
HIDDEN_END

static inline void it2_memberships(const struct it2 *stage, real y_previous, struct it2_memberships *m)
{
    if (!it2_is_plain(stage, y_previous)) {
        it2_memberships_anywhere(stage, y_previous, m);
        return;
    }
    m->sum = 0;
    for (int l = 0; l < stage->rules; l++) {
        m->weight[l] = it2_membership(stage, l, y_previous, &m->lower[l], &m->upper[l]);
        m->sum += m->weight[l];
    }
}

#endif
