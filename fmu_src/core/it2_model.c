/* Eqs. (7) and (10): the rules' consequents, weighted by the memberships, without type reduction. */
#include "it2.h"
#include "it2_membership.h"

/* Its square times an exponent is finite: the widest rule stays the nearest one. */
#define FARTHEST 1e140

/* Where the rule's memberships are above IT2_SUM_UNDERFLOW; empty where its parameters make no numbers. */
static struct it2_range rule_cannot_underflow(const struct it2_rule *rule, const double exponent[2])
{
    const double reach = fmin(sqrt(IT2_NO_UNDERFLOW / fmin(exponent[0], exponent[1])), FARTHEST);

    if (!(exponent[0] <= 0.0 && exponent[1] <= 0.0 && reach > 0.0 && isfinite(rule->centre)))
        return (struct it2_range){ HUGE_VAL, -HUGE_VAL };
    return (struct it2_range){ rule->centre - reach, rule->centre + reach };
}

static struct it2_range overlap(struct it2_range a, struct it2_range b)
{
    return (struct it2_range){ fmax(a.minimum, b.minimum), fmin(a.maximum, b.maximum) };
}

void it2_prepare(struct it2 *stage, const struct it2_rule *rules, int count, struct it2_range range)
{
    *stage = (struct it2){ .rules = count,
                           .plain = { -FARTHEST, FARTHEST },
                           .lower = { .y = -HUGE_VAL },
                           .upper = { .y = HUGE_VAL } };
    for (int l = 0; l < count; l++) {
        stage->rule[l] = rules[l];
        stage->exponent[l][0] = -0.5 * EXP_SCALE / (rules[l].sigmaLower * rules[l].sigmaLower);
        stage->exponent[l][1] = -0.5 * EXP_SCALE / (rules[l].sigmaUpper * rules[l].sigmaUpper);
        stage->plain = overlap(stage->plain, rule_cannot_underflow(&rules[l], stage->exponent[l]));
    }
    const struct it2_end lower = it2_end_at(stage, range.minimum);
    const struct it2_end upper = it2_end_at(stage, range.maximum);
    stage->lower = lower;
    stage->upper = upper;
    stage->plain = overlap(stage->plain, range);
}

/* exp of the differences of both scaled exponents to the largest, finite however narrow the rule is. */
static void relative(const double exponent[2], double square, double largest, double result[2])
{
    double difference[2];

    for (int i = 0; i < 2; i++)
        difference[i] = fmax(square * exponent[i], -DBL_MAX) - largest;
    exp_scaled_pair(difference, result);
}

/* Far from every centre all memberships underflow and (10) would be 0/0. Scaling all of them by the
 * largest leaves (10) as it is and finite; its limit is the nearest rule, the one whose distance in
 * units of its upper deviation is smallest. */
static void memberships_far(const struct it2 *stage, double y_previous, struct it2_memberships *m)
{
    double square[IT2_MAX_RULES];
    double largest = -DBL_MAX;

    for (int l = 0; l < stage->rules; l++) {
        const double distance = fmin(fmax(y_previous - stage->rule[l].centre, -FARTHEST), FARTHEST);
        square[l] = distance * distance;
        largest = fmax(largest, square[l] * stage->exponent[l][1]);
    }
    m->sum = 0.0;
    for (int l = 0; l < stage->rules; l++) {
        double membership[2];
        relative(stage->exponent[l], square[l], largest, membership);
        m->lower[l] = membership[0];
        m->upper[l] = membership[1];
        m->weight[l] = m->lower[l] + m->upper[l];
        m->sum += m->weight[l];
    }
}

void it2_memberships_anywhere(const struct it2 *stage, double y_previous, struct it2_memberships *m)
{
    m->sum = 0.0;
    for (int l = 0; l < stage->rules; l++) {
        double scaled[2], membership[2];
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

static double consequent(const struct it2_rule *rule, double y_previous, double x)
{
    return rule->q1 * y_previous + (rule->q2 * x + rule->q3);
}

static double evaluate_elsewhere(const struct it2 *stage, double y_previous, double x)
{
    const struct it2_end *end = it2_beyond(stage, y_previous);
    struct it2_memberships m;
    double numerator = 0.0;

    if (end)
        return end->y + end->dx * (x - end->x) + end->dy * (y_previous - end->y);
    it2_memberships_anywhere(stage, y_previous, &m);
    for (int l = 0; l < stage->rules; l++)
        numerator += consequent(&stage->rule[l], y_previous, x) * m.weight[l];
    return numerator / m.sum;
}

double it2_evaluate(const struct it2 *stage, double y_previous, double x)
{
    double lower, upper; /* not of interest here */
    double sum = 0.0;
    double numerator = 0.0;

    if (!it2_is_plain(stage, y_previous))
        return evaluate_elsewhere(stage, y_previous, x);
    for (int l = 0; l < stage->rules; l++) {
        const double weight = it2_membership(stage, l, y_previous, &lower, &upper);
        numerator += consequent(&stage->rule[l], y_previous, x) * weight;
        sum += weight;
    }
    return numerator / sum;
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
