/* Eq. (30): the voltage that takes the model from y_{k-1} to the desired y_k. */
#include "it2.h"
#include "it2_membership.h"

real it2_solve_rules(const struct it2 *stage, real y_previous, real y)
{
    struct it2_memberships m;
    real free_response = 0;
    real slope = 0;

    if (!it2_is_plain(stage, y_previous)) {
        const struct it2_end *end = it2_beyond(stage, y_previous);
        if (end)
            return end->x + (y - end->y - end->dy * (y_previous - end->y)) / end->dx;
    }
    it2_memberships(stage, y_previous, &m);
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        free_response += (rule->q1 * y_previous + rule->q3) * m.weight[l];
        slope += rule->q2 * m.weight[l];
    }
    return (y * m.sum - free_response) / slope;
}
