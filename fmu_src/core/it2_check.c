/* What makes a parameter set usable: 0 < s_l1 <= s_l2, invertible by (30), contracting. */
#include <stdarg.h>
#include <stdio.h>

#include "it2.h"
#include "it2_membership.h"

#define GRID 256
#define NEAR 5

/* A grid over the range with both its ends, and points at each rule's centre and one and two of its lower deviations
 * beside it: a narrow rule would hide between grid points. */
static int point_count(const struct it2 *stage)
{
    return GRID + 1 + NEAR * stage->rules;
}

static real point(const struct it2 *stage, struct it2_range range, int i)
{
    if (i == GRID)
        return range.maximum; /* the sum need not round to it */
    if (i < GRID)
        return range.minimum + (range.maximum - range.minimum) * (real)i / GRID;
    const struct it2_rule *rule = &stage->rule[(i - GRID - 1) / NEAR];
    const real y = rule->centre + (real)((i - GRID - 1) % NEAR - NEAR / 2) * rule->sigmaLower;
    return real_fmin(real_fmax(y, range.minimum), range.maximum);
}

static bool fail(char *message, size_t size, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(message, size, format, arguments);
    va_end(arguments);
    return false;
}

static bool check_rule(const struct it2_rule *rule, int number, char *message, size_t size)
{
    const real value[] = { rule->sigmaLower, rule->sigmaUpper, rule->centre, rule->q1, rule->q2, rule->q3 };
    static const char *const name[] = { "sigmaLower", "sigmaUpper", "centre", "q1", "q2", "q3" };

    for (int i = 0; i < IT2_RULE_PARAMETERS; i++)
        if (!isfinite(value[i]))
            return fail(message, size, "rule[%d].%s is not a finite number", number, name[i]);
    if (!(rule->sigmaLower > 0))
        return fail(message, size, "rule[%d].sigmaLower is %g; a standard deviation must be positive", number,
                    (double)rule->sigmaLower);
    if (!(rule->sigmaUpper >= rule->sigmaLower))
        return fail(message, size,
                    "rule[%d].sigmaUpper is %g, below rule[%d].sigmaLower, %g; the upper membership "
                    "must be the wider one (are the two swapped?)",
                    number, (double)rule->sigmaUpper, number, (double)rule->sigmaLower);
    return true;
}

/* dy_k/dx_k times the sum of memberships: the denominator of (30). */
static real denominator(const struct it2 *stage, real y)
{
    struct it2_memberships m;
    real slope = 0;

    it2_memberships(stage, y, &m);
    for (int l = 0; l < stage->rules; l++)
        slope += stage->rule[l].q2 * m.weight[l];
    return slope / m.sum;
}

real it2_contraction(const struct it2 *stage, struct it2_range range, real *where)
{
    real largest = -1;

    for (int i = 0; i < point_count(stage); i++) {
        const real y = point(stage, range, i);
        const real magnitude = real_fabs(it2_partials(stage, y, it2_solve(stage, y, y)).dy);
        if (!(magnitude <= largest)) { /* a NaN is the largest */
            largest = magnitude;
            *where = y;
        }
    }
    return largest;
}

bool it2_check(const struct it2_rule *rules, int count, struct it2_range range, char *message, size_t size)
{
    struct it2 stage;
    real where = range.minimum;

    if (count < 1 || count > IT2_MAX_RULES)
        return fail(message, size, "ruleCount is %d; it must be 1 to %d", count, IT2_MAX_RULES);
    if (!(isfinite(range.minimum) && isfinite(range.maximum) && range.minimum < range.maximum))
        return fail(message, size, "displacementMin, %g, must be below displacementMax, %g",
                    (double)range.minimum, (double)range.maximum);
    for (int l = 0; l < count; l++)
        if (!check_rule(&rules[l], l + 1, message, size))
            return false;
    it2_prepare(&stage, rules, count, IT2_EVERYWHERE);
    for (int i = 0; i < point_count(&stage); i++)
        if (!(denominator(&stage, point(&stage, range, i)) > 0))
            return fail(message, size,
                        "the sum of rule[].q2 times the memberships is not positive at a displacement "
                        "of %g: the model cannot be inverted there; raise q2 of the rules near it or "
                        "narrow displacementMin..displacementMax",
                        (double)point(&stage, range, i));
    const real contraction = it2_contraction(&stage, range, &where);
    if (!(contraction < 1))
        return fail(message, size,
                    "the contraction |dy_k/dy_{k-1}| is %.4g at a displacement of %g, where it must "
                    "be below 1: a free run diverges; lower rule[].q1 or narrow "
                    "displacementMin..displacementMax",
                    (double)contraction, (double)where);
    return true;
}
