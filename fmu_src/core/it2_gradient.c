/* Eqs. (13) to (18): the partial derivatives of (10), and those with respect to x_k and y_{k-1}. */
#include "it2.h"
#include "it2_membership.h"

/* (13) to (18) for one rule; `excess` is n_l - y_k, `share` 1 / D. Returns d(f_l + F_l)/dc_l, which is also
 * -d(f_l + F_l)/dy_{k-1}. Products with inverses: fits call this at every sample, and divisions were most of it. */
static real rule_gradient(const struct it2_rule *rule, real lower, real upper, real y_previous, real x,
                          real excess, real share, real *gradient)
{
    const real distance = y_previous - rule->centre;
    const real per_lower = 1 / rule->sigmaLower;
    const real per_upper = 1 / rule->sigmaUpper;
    const real lower_by_centre = lower * (per_lower * per_lower) * distance;
    const real upper_by_centre = upper * (per_upper * per_upper) * distance;
    const real weight = (lower + upper) * share;
    const real pull = excess * share;

    gradient[0] = lower_by_centre * distance * per_lower * pull;
    gradient[1] = upper_by_centre * distance * per_upper * pull;
    gradient[2] = (lower_by_centre + upper_by_centre) * pull;
    gradient[3] = y_previous * weight;
    gradient[4] = x * weight;
    gradient[5] = weight;
    return lower_by_centre + upper_by_centre;
}

real it2_gradient(const struct it2 *stage, real y_previous, real x, real *gradient,
                  struct it2_partials *partials)
{
    struct it2_memberships m;
    real consequent[IT2_MAX_RULES];
    real numerator = 0;
    real dx = 0;
    real dy = 0;

    const struct it2_end *end = it2_beyond(stage, y_previous);
    if (end)
        return it2_gradient_beyond(stage, end, y_previous, x, gradient, partials);
    it2_memberships(stage, y_previous, &m);
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        consequent[l] = rule->q1 * y_previous + (rule->q2 * x + rule->q3); /* as it2_evaluate */
        numerator += consequent[l] * m.weight[l];
    }
    const real y = numerator / m.sum;
    const real share = 1 / m.sum;
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        const real excess = consequent[l] - y;
        const real by_centre = rule_gradient(rule, m.lower[l], m.upper[l], y_previous, x, excess, share,
                                             gradient + IT2_RULE_PARAMETERS * l);
        dx += rule->q2 * m.weight[l];
        dy += rule->q1 * m.weight[l] - by_centre * excess;
    }
    if (partials)
        *partials = (struct it2_partials){ .dx = dx / m.sum, .dy = dy / m.sum, .end = 0 };
    return y;
}

struct it2_partials it2_partials(const struct it2 *stage, real y_previous, real x)
{
    real gradient[IT2_RULE_PARAMETERS * IT2_MAX_RULES];
    struct it2_partials partials;

    it2_gradient(stage, y_previous, x, gradient, &partials);
    return partials;
}

real it2_derivative(const struct it2 *stage, const struct it2_state *state, real x)
{
    return it2_partials(stage, state->y, x).dx;
}
