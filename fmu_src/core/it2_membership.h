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

static inline int it2_lanes(const struct it2 *stage)
{
    return (2 * stage->rules + EXP_LANES - 1) / EXP_LANES * EXP_LANES;
}

static inline void it2_collect(const struct it2 *stage, const double *lane, struct it2_memberships *m)
{
    m->sum = 0.0;
    for (int l = 0; l < stage->rules; l++) {
        m->lower[l] = lane[2 * l];
        m->upper[l] = lane[2 * l + 1];
        m->weight[l] = lane[2 * l] + lane[2 * l + 1];
        m->sum += m->weight[l];
    }
}

/* Far from every centre all memberships underflow and (10) would be 0/0. Scaling all of them by the
 * largest leaves (10) as it is and finite; its limit is the nearest rule, the one whose distance in
 * units of its upper deviation is smallest. */
void it2_memberships_far(const struct it2 *stage, double y_previous, struct it2_memberships *m);

static inline void it2_memberships(const struct it2 *stage, double y_previous,
                                   struct it2_memberships *m)
{
    double exponent[IT2_MAX_LANES];
    double lane[IT2_MAX_LANES];
    const int lanes = it2_lanes(stage);

    for (int block = 0; block < lanes; block += EXP_LANES) {
        for (int i = block; i < block + EXP_LANES; i++) {
            const double distance = y_previous - stage->lane_centre[i];
            exponent[i] = distance * distance * stage->lane_exponent[i];
        }
        exp_block(exponent + block, lane + block);
    }
    it2_collect(stage, lane, m);
    if (!(m->sum >= IT2_SUM_UNDERFLOW))
        it2_memberships_far(stage, y_previous, m);
}

#endif
