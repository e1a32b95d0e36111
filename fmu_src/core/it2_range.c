/* Beyond the ends of the range that a core was identified for.
 *
 * (10) extrapolates there with memberships that tend to the widest rule, whose own feedback may be more than
 * 1: it would diverge. So beyond an end y_e the core goes on as its linearisation at the equilibrium there,
 *     F(y, x) = y_e + A (x - x_e) + s (y - y_e),    A = dF/dx and s = dF/dy at (y_e, x_e), F(y_e, x_e) = y_e,
 * which contracts by s. (10) is affine in x with the slope A(y): at y_e nothing jumps, whatever x is. */
#include "it2.h"
#include "it2_membership.h"

struct it2_end it2_end_at(const struct it2 *stage, real y)
{
    if (!isfinite(y))
        return (struct it2_end){ .y = y };
    const real x = it2_solve(stage, y, y);
    const struct it2_partials f = it2_partials(stage, y, x);
    return (struct it2_end){ .y = y, .x = x, .dx = f.dx, .dy = f.dy };
}

/* A rule at the equilibrium of an end: its weight w = f_l + F_l, and derivatives of w by y. */
struct rule_at_end {
    real weight;
    real slope;
    real curvature;
    real excess; /* n_l - y_e */
};

/* What a parameter of a rule changes there: w, dw/dy, n_l, and its coefficients of y and x. */
struct rule_change {
    real weight;
    real slope;
    real consequent;
    real q1;
    real q2;
};

/* Second derivatives of (10) there, and the sum of weights D with its derivative. */
struct curvature {
    real dxdy;
    real dydy;
    real sum;
    real slopes;
};

/* How far (y_{k-1}, x_k) is from it. */
struct distance {
    real y;
    real x;
};

static struct rule_at_end at_end(const struct it2_rule *rule, const struct it2_end *end, real lower, real upper)
{
    const real distance = end->y - rule->centre;
    const real square_lower = rule->sigmaLower * rule->sigmaLower;
    const real square_upper = rule->sigmaUpper * rule->sigmaUpper;
    const real ratio_lower = distance * distance / square_lower;
    const real ratio_upper = distance * distance / square_upper;

    return (struct rule_at_end){
        .weight = lower + upper,
        .slope = -distance * (lower / square_lower + upper / square_upper),
        .curvature = lower * (ratio_lower - 1) / square_lower + upper * (ratio_upper - 1) / square_upper,
        .excess = rule->q1 * end->y + (rule->q2 * end->x + rule->q3) - end->y,
    };
}

static struct rule_change by_deviation(real membership, real distance, real sigma)
{
    const real ratio = distance * distance / (sigma * sigma);

    return (struct rule_change){
        .weight = membership * ratio / sigma,
        .slope = membership * distance * (2 - ratio) / (sigma * sigma * sigma),
    };
}

/* In the order of struct it2_rule. */
static void rule_changes(const struct it2_rule *rule, const struct it2_end *end, real lower, real upper,
                         const struct rule_at_end *at, struct rule_change change[IT2_RULE_PARAMETERS])
{
    const real distance = end->y - rule->centre;

    change[0] = by_deviation(lower, distance, rule->sigmaLower);
    change[1] = by_deviation(upper, distance, rule->sigmaUpper);
    change[2] = (struct rule_change){ .weight = -at->slope, .slope = -at->curvature };
    change[3] = (struct rule_change){ .consequent = end->y, .q1 = 1 };
    change[4] = (struct rule_change){ .consequent = end->x, .q2 = 1 };
    change[5] = (struct rule_change){ .consequent = 1 };
}

/* dF/dp = dA/dp (x - x_e) - A dx_e/dp + ds/dp (y - y_e), where (10) changes by d at (y_e, x_e) and
 * dx_e/dp = -d / A brings it back to y_e. */
static real by_parameter(const struct it2_rule *rule, const struct it2_end *end, const struct curvature *f,
                         const struct rule_at_end *at, const struct rule_change *change, struct distance from)
{
    const real d = (change->consequent * at->weight + at->excess * change->weight) / f->sum;
    const real dA = (change->q2 * at->weight + (rule->q2 - end->dx) * change->weight) / f->sum;
    const real ds = (change->q1 * at->weight + (rule->q1 - end->dy) * change->weight +
                     change->consequent * at->slope + at->excess * change->slope - d * f->slopes) /
                    f->sum;

    return dA * from.x + d + (ds - f->dxdy * d / end->dx) * from.y;
}

real it2_gradient_beyond(const struct it2 *stage, const struct it2_end *end, real y_previous, real x,
                         real *gradient, struct it2_partials *partials)
{
    const struct distance from = { y_previous - end->y, x - end->x };
    struct it2_memberships m;
    struct rule_at_end at[IT2_MAX_RULES];
    struct rule_change change[IT2_RULE_PARAMETERS];

    it2_memberships(stage, end->y, &m);
    struct curvature f = { .sum = m.sum };
    for (int l = 0; l < stage->rules; l++) {
        const struct it2_rule *rule = &stage->rule[l];
        at[l] = at_end(rule, end, m.lower[l], m.upper[l]);
        f.slopes += at[l].slope;
        f.dxdy += (rule->q2 - end->dx) * at[l].slope / m.sum;
        f.dydy += (2 * (rule->q1 - end->dy) * at[l].slope + at[l].excess * at[l].curvature) / m.sum;
    }
    for (int l = 0; l < stage->rules; l++) {
        rule_changes(&stage->rule[l], end, m.lower[l], m.upper[l], &at[l], change);
        for (int i = 0; i < IT2_RULE_PARAMETERS; i++)
            gradient[IT2_RULE_PARAMETERS * l + i] =
                by_parameter(&stage->rule[l], end, &f, &at[l], &change[i], from);
    }
    if (partials)
        *partials = (struct it2_partials){
            .dx = end->dx,
            .dy = end->dy,
            .end = f.dxdy * from.x + (f.dydy + f.dxdy * (1 - end->dy) / end->dx) * from.y,
        };
    return end->y + end->dx * from.x + end->dy * from.y;
}
