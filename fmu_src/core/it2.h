/* The simplified interval type-2 Takagi-Sugeno fuzzy model: the core of the chain.
 *
 * One file per group of equations of the paper:
 *   it2_membership.h   (8), (9), (11), (12)   the memberships and their sum
 *   it2_model.c        (7), (10)              one step forward
 *   it2_inverse.c      (30)                   one step backward
 *   it2_gradient.c     (13) to (18)           partial derivatives
 *   it2_range.c        what (10) becomes beyond the ends of its range
 *   it2_table.c        (10) and (30) prepared for many ticks with the same rules
 *   it2_free_run.c     (10) over a record, with forward sensitivities
 *   it2_check.c        what makes a parameter set usable
 *
 * Units are the caller's; the FMUs use V and m. */
#ifndef IT2HYS_IT2_H
#define IT2HYS_IT2_H

#include <stdbool.h>
#include <stddef.h>

#include "hidden.h"
#include "real.h"

enum { IT2_MAX_RULES = 16, IT2_RULE_PARAMETERS = 6 };

/* One rule, in the order of the paper's Table 1: antecedent (s1, s2, c), consequent (q1, q2, q3). */
struct it2_rule {
    real sigmaLower;
    real sigmaUpper;
    real centre;
    real q1;
    real q2;
    real q3;
};

/* A range of displacement. */
struct it2_range {
    real minimum;
    real maximum;
};

/* For a core that is (10) everywhere: while it is fitted, nobody knows its range yet. */
static const struct it2_range IT2_EVERYWHERE = { -REAL_INFINITY, REAL_INFINITY };

/* An end of the range, and the equilibrium there: F(y, x) = y. */
struct it2_end {
    real y;
    real x;
    real dx; /* dF/dx */
    real dy; /* dF/dy */
};

struct it2_table;

/* The rules, and -1 / (2 s_l1^2), -1 / (2 s_l2^2) in the scale of exponential.h. Set by it2_prepare. */
struct it2 {
    int rules;
    struct it2_range plain; /* of y_{k-1}: within the range, and no membership comes close to underflow */
    struct it2_end lower, upper;
    const struct it2_table *table; /* for y_{k-1} in `plain`; NULL: the rules themselves */
    struct it2_rule rule[IT2_MAX_RULES];
    real exponent[IT2_MAX_RULES][2];
};

struct it2_state {
    real y; /* y_{k-1} */
};

/* Partial derivatives of a step with respect to its two arguments and to the end of the range. */
struct it2_partials {
    real dx;  /* dy_k / dx_k */
    real dy;  /* dy_k / dy_{k-1}: the contraction of a free run */
    real end; /* by the end that y_{k-1} lies beyond; 0 within the range */
};

/* The end that y_{k-1} lies beyond; NULL within the range. */
static inline const struct it2_end *it2_beyond(const struct it2 *stage, real y_previous)
{
    return y_previous < stage->lower.y ? &stage->lower : y_previous > stage->upper.y ? &stage->upper : NULL;
}

HIDDEN_BEGIN

void it2_prepare(struct it2 *stage, const struct it2_rule *rules, int count, struct it2_range range);

/* From now on, until it2_prepare, steps and inverses within the range look (10) and (30) up (it2_table.h): faster,
 * and the same but for rounding, less than 1e-15 of the range or of its farther end. Derivatives stay those of the
 * rules. `table`, the caller's, holds zeros or what this function has made: for the same rules and range it is
 * taken as it is. False where there can be none, because the range is infinite or the rules are too narrow for
 * it: then everything stays with the rules. */
bool it2_tabulate(struct it2 *stage, struct it2_table *table);

/* The core as a stage that the chain always has; it2_step and it2_inverse are in it2_table.h. */
void it2_reset(struct it2_state *state, real y);
real it2_derivative(const struct it2 *stage, const struct it2_state *state, real x);

/* F without a state, and what is derived from it: (10) for y_{k-1} within the range, and what goes on from
 * it beyond (it2_range.c). By the rules; it2_evaluate and it2_solve of it2_table.h take the table where there is
 * one. */
real it2_evaluate_rules(const struct it2 *stage, real y_previous, real x);
real it2_solve_rules(const struct it2 *stage, real y_previous, real y);
struct it2_partials it2_partials(const struct it2 *stage, real y_previous, real x);

/* Eqs. (13) to (18): gradient[6 l + i] = dy_k / d(parameter i of rule l), in the order of it2_rule.
 * Returns y_k and, where `partials` is given, the partial derivatives too. */
real it2_gradient(const struct it2 *stage, real y_previous, real x, real *gradient,
                  struct it2_partials *partials);

/* y[k] = F(y[k-1], x[k]), k = 0..n-1, y[-1] = y_initial. Where `sensitivity` (n rows of 6 L + 1,
 * row-major) is given: the derivatives of y[k] with respect to all parameters and y_initial.
 * Returns the number of samples computed: less than n if a value is not finite. */
size_t it2_free_run(const struct it2_rule *rules, int count, struct it2_range range, const real *x, size_t n,
                    real y_initial, real *y, real *sensitivity);

/* Is the parameter set usable over the range of displacement? On a grid of y that has both ends: the sum of
 * q_l2 memberships is positive (invertible) and |dy_k/dy_{k-1}| < 1 on the equilibrium curve (an equilibrium
 * is stable). With it at the ends, a free run cannot diverge: beyond them y_k moves by that share of what
 * y_{k-1} does, and from within them one step goes no farther than the voltage takes it.
 * Otherwise false, and `message` names the culprit and the mend. */
bool it2_check(const struct it2_rule *rules, int count, struct it2_range range, char *message, size_t size);

/* The largest |dy_k/dy_{k-1}| on the equilibrium curve and the displacement where it occurs. */
real it2_contraction(const struct it2 *stage, struct it2_range range, real *where);

HIDDEN_END

#endif
