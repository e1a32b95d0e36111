/* The memberships (8), (9), (11), (12), evaluated for all rules at once. */
#ifndef IT2HYS_IT2_MEMBERSHIP_H
#define IT2HYS_IT2_MEMBERSHIP_H

#include <float.h>
#include <math.h>
#include <stdbool.h>

#include "exponential.h"
#include "it2.h"

struct it2_memberships {
    double lower[IT2_MAX_RULES]; /* f_l */
    double upper[IT2_MAX_RULES]; /* F_l */
    double weight[IT2_MAX_RULES]; /* f_l + F_l */
    double sum; /* D of (10) */
};

/* Below this sum some memberships have underflowed while others still count. */
#define IT2_SUM_UNDERFLOW 1e-280

/* A membership with a scaled exponent above this is above IT2_SUM_UNDERFLOW. */
#define IT2_NO_UNDERFLOW -59000.0

/* Then nothing can underflow, and neither exponentials nor their sum need be checked. */
static inline bool it2_cannot_underflow(const struct it2 *stage, double y_previous)
{
    return y_previous >= stage->no_underflow.minimum && y_previous <= stage->no_underflow.maximum;
}

static inline void it2_exponents(const struct it2 *stage, int l, double y_previous, double scaled[2])
{
    const double distance = y_previous - stage->rule[l].centre;
    const double square = distance * distance;

    scaled[0] = square * stage->exponent[l][0];
    scaled[1] = square * stage->exponent[l][1];
}

/* (8), (11) and (9), (12) for one rule, where it2_cannot_underflow; returns f_l + F_l. */
static inline double it2_membership(const struct it2 *stage, int l, double y_previous, double *lower,
                                    double *upper)
{
    double scaled[2];
    double membership[2] = { 0.0, 0.0 }; /* gcc's analyzer cannot follow the lanes */

    it2_exponents(stage, l, y_previous, scaled);
    exp_scaled_normal_pair(scaled, membership);
    *lower = membership[0];
    *upper = membership[1];
    return *lower + *upper;
}

HIDDEN_BEGIN
/* it2_memberships for any y_{k-1}. */
void it2_memberships_anywhere(const struct it2 *stage, double y_previous, struct it2_memberships *m);
HIDDEN_END

static inline void it2_memberships(const struct it2 *stage, double y_previous,
                                   struct it2_memberships *m)
{
    if (!it2_cannot_underflow(stage, y_previous)) {
        it2_memberships_anywhere(stage, y_previous, m);
        return;
    }
    m->sum = 0.0;
    for (int l = 0; l < stage->rules; l++) {
        m->weight[l] = it2_membership(stage, l, y_previous, &m->lower[l], &m->upper[l]);
        m->sum += m->weight[l];
    }
}

#endif
