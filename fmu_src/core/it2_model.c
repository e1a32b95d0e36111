/* Eqs. (7) and (10): the rules' consequents, weighted by the memberships, without type reduction. */
#include "it2.h"
#include "it2_membership.h"

/* Where the rule's memberships are above IT2_SUM_UNDERFLOW; empty where its parameters make no numbers. */
static struct it2_range rule_cannot_underflow(const struct it2_rule *rule, const real exponent[2])
{
    const real reach =
        real_fmin(real_sqrt(IT2_NO_UNDERFLOW / real_fmin(exponent[0], exponent[1])), IT2_FARTHEST);

    if (!(exponent[0] <= 0 && exponent[1] <= 0 && reach > 0 && isfinite(rule->centre)))
        return (struct it2_range){ REAL_INFINITY, -REAL_INFINITY };
    return (struct it2_range){ rule->centre - reach, rule->centre + reach };
}

static struct it2_range overlap(struct it2_range a, struct it2_range b)
{
    return (struct it2_range){ real_fmax(a.minimum, b.minimum), real_fmin(a.maximum, b.maximum) };
}

void it2_prepare(struct it2 *stage, const struct it2_rule *rules, int count, struct it2_range range)
{
    *stage = (struct it2){ .rules = count,
                           .plain = { -IT2_FARTHEST, IT2_FARTHEST },
                           .lower = { .y = -REAL_INFINITY },
                           .upper = { .y = REAL_INFINITY } };
    for (int l = 0; l < count; l++) {
        stage->rule[l] = rules[l];
        stage->exponent[l][0] = -REAL(0.5) * EXP_SCALE / (rules[l].sigmaLower * rules[l].sigmaLower);
        stage->exponent[l][1] = -REAL(0.5) * EXP_SCALE / (rules[l].sigmaUpper * rules[l].sigmaUpper);
        stage->plain = overlap(stage->plain, rule_cannot_underflow(&rules[l], stage->exponent[l]));
    }
    const struct it2_end lower = it2_end_at(stage, range.minimum);
    const struct it2_end upper = it2_end_at(stage, range.maximum);
    stage->lower = lower;
    stage->upper = upper;
    stage->plain = overlap(stage->plain, range);
}

/* exp of the differences of both scaled exponents to the largest, finite however narrow the rule is. */
static void relative(const real exponent[2], real square, real largest, real result[2])
{
    real difference[2];

    for (int i = 0; i < 2; i++)
        difference[i] = real_fmax(square * exponent[i], -REAL_MAX) - largest;
    exp_scaled_pair(difference, result);
}

/* Far from every centre all memberships underflow and (10) would be 0/0. Scaling all of them by the
 * largest leaves (10) as it is and finite; its limit is the nearest rule, the one whose distance in
 * units of its upper deviation is smallest. */
static void memberships_far(const struct it2 *stage, real y_previous, struct it2_memberships *m)
{
    real square[IT2_MAX_RULES];
    real largest = -REAL_MAX;

    for (int l = 0; l < stage->rules; l++) {
        const real distance =
            real_fmin(real_fmax(y_previous - stage->rule[l].centre, -IT2_FARTHEST), IT2_FARTHEST);
        square[l] = distance * distance;
        largest = real_fmax(largest, square[l] * stage->exponent[l][1]);
    }
    m->sum = 0;
    for (int l = 0; l < stage->rules; l++) {
        real membership[2];
        relative(stage->exponent[l], square[l], largest, membership);
        m->lower[l] = membership[0];
        m->upper[l] = membership[1];
        m->weight[l] = m->lower[l] + m->upper[l];
        m->sum += m->weight[l];
    }
}

void it2_memberships_anywhere(const struct it2 *stage, real y_previous, struct it2_memberships *m)
{
    m->sum = 0;
    for (int l = 0; l < stage->rules; l++) {
        real scaled[2], membership[2];
        it2_exponents(stage, l, y_previous, scaled);
        exp_scaled_pair(scaled, membership);
        m->lower[l] = membership[0];
        m->upper[l] = membership[1];
        m->weight[l] = m->lower[l] + m->upper[l];
        m->sum += m->weight[l];
    }
    if (!(m->sum >= IT2_SUM_UNDERFLOW))
        memberships_far(stage, y_previous, m);
}

static real consequent(const struct it2_rule *rule, real y_previous, real x)
{
    return rule->q1 * y_previous + (rule->q2 * x + rule->q3);
}

static real evaluate_elsewhere(const struct it2 *stage, real y_previous, real x)
{
    const struct it2_end *end = it2_beyond(stage, y_previous);
    struct it2_memberships m;
    real numerator = 0;

    if (end)
        return end->y + end->dx * (x - end->x) + end->dy * (y_previous - end->y);
    it2_memberships_anywhere(stage, y_previous, &m);
    for (int l = 0; l < stage->rules; l++)
        numerator += consequent(&stage->rule[l], y_previous, x) * m.weight[l];
    return numerator / m.sum;
}

real it2_evaluate_rules(const struct it2 *stage, real y_previous, real x)
{
    real lower, upper; /* not of interest here */
    real sum = 0;
    real numerator = 0;

    if (!it2_is_plain(stage, y_previous))
        return evaluate_elsewhere(stage, y_previous, x);
    for (int l = 0; l < stage->rules; l++) {
        const real weight = it2_membership(stage, l, y_previous, &lower, &upper);
        numerator += consequent(&stage->rule[l], y_previous, x) * weight;
        sum += weight;
    }
    return numerator / sum;
}

void it2_reset(struct it2_state *state, real y)
{
    state->y = y;
}
