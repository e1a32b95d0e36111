/* Eqs. (13) to (18): the partial derivatives of (10), and those with respect to x_k and y_{k-1}. */
#include "it2.h"
#include "it2_membership.h"

/* (13) to (18) for one rule; `excess` is n_l - y_k. Returns d(f_l + F_l)/dc_l, which is also
 * -d(f_l + F_l)/dy_{k-1}. */
static double rule_gradient(const struct it2_rule *rule, double lower, double upper, double y_previous,
                            double x, double excess, double sum, double *gradient)
{
    const double distance = y_previous - rule->centre;
    const double variance_lower = rule->sigmaLower * rule->sigmaLower;
    const double variance_upper = rule->sigmaUpper * rule->sigmaUpper;
    const double weight = (lower + upper) / sum;
    const double by_centre = (lower / variance_lower + upper / variance_upper) * distance;

    gradient[0] = lower * distance * distance / (variance_lower * rule->sigmaLower) * excess / sum;
    gradient[1] = upper * distance * distance / (variance_upper * rule->sigmaUpper) * excess / sum;
    gradient[2] = by_centre * excess / sum;
    gradient[3] = y_previous * weight;
    gradient[4] = x * weight;
    gradient[5] = weight;
    return by_centre;
}

double it2_gradient(const struct it2 *stage, double y_previous, double x, double *gradient,
                    struct it2_partials *partials)
{
    struct it2_memberships m;
    double consequent[IT2_MAX_RULES];
    double numerator = 0.0;
    double dx = 0.0;
    double dy = 0.0;

    const struct it2_end *end = it2_beyond(stage, y_previous);
    if (end)
        return it2_gradient_beyond(stage, end, y_previous, x, gradient, partials);
    it2_memberships(stage, y_previous, &m);
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        consequent[l] = rule->q1 * y_previous + (rule->q2 * x + rule->q3); /* as it2_evaluate */
        numerator += consequent[l] * m.weight[l];
    }
    const double y = numerator / m.sum;
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        const double excess = consequent[l] - y;
        const double by_centre = rule_gradient(rule, m.lower[l], m.upper[l], y_previous, x, excess, m.sum,
                                               gradient + IT2_RULE_PARAMETERS * l);
        dx += rule->q2 * m.weight[l];
        dy += rule->q1 * m.weight[l] - by_centre * excess;
    }
    if (partials)
        *partials = (struct it2_partials){ .dx = dx / m.sum, .dy = dy / m.sum, .end = 0.0 };
    return y;
}

struct it2_partials it2_partials(const struct it2 *stage, double y_previous, double x)
{
    double gradient[IT2_RULE_PARAMETERS * IT2_MAX_RULES];
    struct it2_partials partials;

    it2_gradient(stage, y_previous, x, gradient, &partials);
    return partials;
}

double it2_derivative(const struct it2 *stage, const struct it2_state *state, double x)
{
    return it2_partials(stage, state->y, x).dx;
}
