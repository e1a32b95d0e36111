/* The IT2 core in single precision, for processors whose floating-point unit is. The equations are those
 * of it2.h; only it2_single_prepare, called once, computes in double. No allocation, no branch that
 * depends on data but comparisons, no loop but those over rules.
 *
 * Memberships are taken relative to the largest one, which leaves (10) and (30) as they are: so none of
 * the sums underflows, however far the displacement is from every rule. */
#ifndef IT2HYS_IT2_SINGLE_H
#define IT2HYS_IT2_SINGLE_H

#include "it2.h"

struct it2_single_range {
    float minimum;
    float maximum;
};

/* As struct it2_end. */
struct it2_single_end {
    float y;
    float x;
    float dx;
    float dy;
};

struct it2_single {
    int rules;
    struct it2_single_end lower, upper;
    float centre[IT2_MAX_RULES];
    float exponent[IT2_MAX_RULES][2]; /* -1 / (2 s_l1^2), -1 / (2 s_l2^2), in powers of two */
    float q1[IT2_MAX_RULES];
    float q2[IT2_MAX_RULES];
    float q3[IT2_MAX_RULES];
};

void it2_single_prepare(struct it2_single *stage, const struct it2_rule *rules, int count,
                        struct it2_single_range range);

/* (10), and beyond the range what goes on from it: y_k from y_{k-1} and x_k. */
float it2_single_step(const struct it2_single *stage, float y_previous, float x);

/* (30): x_k that takes y_{k-1} to y. */
float it2_single_inverse(const struct it2_single *stage, float y_previous, float y);

/* The same as a stage of the chain: with a state that is advanced. */
struct it2_single_state {
    float y; /* y_{k-1} */
};

static inline void it2_single_reset(struct it2_single_state *state, float y)
{
    state->y = y;
}

static inline float it2_single_advance(const struct it2_single *stage, struct it2_single_state *state, float x)
{
    state->y = it2_single_step(stage, state->y, x);
    return state->y;
}

static inline float it2_single_retrace(const struct it2_single *stage, struct it2_single_state *state, float y)
{
    const float x = it2_single_inverse(stage, state->y, y);

    state->y = y;
    return x;
}

#endif
