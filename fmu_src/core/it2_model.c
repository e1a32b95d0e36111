/* Eqs. (7) and (10): the rules' consequents, weighted by the memberships, without type reduction. */
#include "it2.h"
#include "it2_membership.h"

void it2_prepare(struct it2 *stage, const struct it2_rule *rules, int count)
{
    *stage = (struct it2){ .rules = count };
    for (int l = 0; l < count; l++) {
        stage->rule[l] = rules[l];
        stage->lane_centre[2 * l] = stage->lane_centre[2 * l + 1] = rules[l].centre;
        stage->lane_exponent[2 * l] = -0.5 / (rules[l].sigmaLower * rules[l].sigmaLower);
        stage->lane_exponent[2 * l + 1] = -0.5 / (rules[l].sigmaUpper * rules[l].sigmaUpper);
    }
}

void it2_memberships_far(const struct it2 *stage, double y_previous, struct it2_memberships *m)
{
    double exponent[IT2_MAX_LANES];
    double lane[IT2_MAX_LANES] = { 0.0 };
    double largest = -DBL_MAX;

    for (int i = 0; i < 2 * stage->rules; i++) {
        const double distance = y_previous - stage->lane_centre[i];
        /* clamped, so that the difference below is finite however far away y is */
        exponent[i] = fmax(distance * distance * stage->lane_exponent[i], -DBL_MAX);
        largest = fmax(largest, exponent[i]);
    }
    for (int i = 0; i < 2 * stage->rules; i++)
        lane[i] = exp(exponent[i] - largest);
    it2_collect(stage, lane, m);
}

double it2_evaluate(const struct it2 *stage, double y_previous, double x)
{
    struct it2_memberships m;
    double numerator = 0.0;

    it2_memberships(stage, y_previous, &m);
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        numerator += (rule->q1 * y_previous + rule->q2 * x + rule->q3) * m.weight[l];
    }
    return numerator / m.sum;
}

void it2_reset(struct it2_state *state, double y)
{
    state->y = y;
}

double it2_step(const struct it2 *stage, struct it2_state *state, double x)
{
    state->y = it2_evaluate(stage, state->y, x);
    return state->y;
}
