/* The memberships (8), (9), (11), (12), evaluated for all rules at once. */
#ifndef IT2HYS_IT2_MEMBERSHIP_H
#define IT2HYS_IT2_MEMBERSHIP_H

#include <float.h>
#include <math.h>
#include <stdbool.h>

#include "exponential.h"
#include "it2.h"

struct it2_memberships {
    double lower[IT2_MAX_RULES];  /* f_l */
    double upper[IT2_MAX_RULES];  /* F_l */
    double weight[IT2_MAX_RULES]; /* f_l + F_l */
    double sum;                   /* D of (10) */
};

/* Below this sum some memberships have underflowed while others still count. */
#define IT2_SUM_UNDERFLOW 1e-280

/* A membership with a scaled exponent above this is above IT2_SUM_UNDERFLOW. */
#define IT2_NO_UNDERFLOW -59000.0

/* Within the range, where nothing can underflow either: neither exponentials nor their sum need be checked. */
static inline bool it2_is_plain(const struct it2 *stage, double y_previous)
{
    return y_previous >= stage->plain.minimum && y_previous <= stage->plain.maximum;
}

static inline void it2_exponents(const struct it2 *stage, int l, double y_previous, double scaled[2])
{
    const double distance = y_previous - stage->rule[l].centre;
    const double square = distance * distance;

    scaled[0] = square * stage->exponent[l][0];
    scaled[1] = square * stage->exponent[l][1];
}

/* (8), (11) and (9), (12) for one rule, where it2_is_plain; returns f_l + F_l. */
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

/* An end of the range at y, from a stage that is (10) there; of an infinite one only that. */
struct it2_end it2_end_at(const struct it2 *stage, double y);

/* it2_gradient for y_{k-1} beyond an end. */
double it2_gradient_beyond(const struct it2 *stage, const struct it2_end *end, double y_previous, double x,
                           double *gradient, struct it2_partials *partials);
HIDDEN_END

static inline void it2_memberships(const struct it2 *stage, double y_previous, struct it2_memberships *m)
{
    if (!it2_is_plain(stage, y_previous)) {
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
