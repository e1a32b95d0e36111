/* The memberships (8), (9), (11), (12), evaluated for all rules at once. */
#ifndef IT2HYS_IT2_MEMBERSHIP_H
#define IT2HYS_IT2_MEMBERSHIP_H

#include <float.h>
#include <math.h>

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

/* (8), (11) and (9), (12) for one rule; returns f_l + F_l. */
static inline double it2_membership(const struct it2 *stage, int l, double y_previous, double *lower,
                                    double *upper)
{
    const double distance = y_previous - stage->rule[l].centre;
    const double square = distance * distance;
    const double scaled[2] = { square * stage->exponent[l][0], square * stage->exponent[l][1] };
    double membership[2] = { 0.0, 0.0 }; /* gcc's analyzer cannot follow the lanes */

    exp_scaled_pair(scaled, membership);
    *lower = membership[0];
    *upper = membership[1];
    return *lower + *upper;
}

/* Far from every centre all memberships underflow and (10) would be 0/0. Scaling all of them by the
 * largest leaves (10) as it is and finite; its limit is the nearest rule, the one whose distance in
 * units of its upper deviation is smallest. */
HIDDEN_BEGIN
void it2_memberships_far(const struct it2 *stage, double y_previous, struct it2_memberships *m);
HIDDEN_END

static inline void it2_memberships(const struct it2 *stage, double y_previous,
                                   struct it2_memberships *m)
{
    m->sum = 0.0;
    for (int l = 0; l < stage->rules; l++) {
        m->weight[l] = it2_membership(stage, l, y_previous, &m->lower[l], &m->upper[l]);
        m->sum += m->weight[l];
    }
    if (!(m->sum >= IT2_SUM_UNDERFLOW))
        it2_memberships_far(stage, y_previous, m);
}

#endif
