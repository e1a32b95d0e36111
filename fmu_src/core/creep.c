#include "creep.h"

#include <string.h>

#include "chain.h"

static bool creep_check(const struct chain_parameters *p, char *message, size_t size)
{
    real least = 1;

    if (p->creepCount < 0 || p->creepCount > CREEP_MAX)
        return refuse(message, size, "creepCount is %d; it must be 0 to %d", p->creepCount, CREEP_MAX);
    for (int i = 0; i < p->creepCount; i++) {
        const struct creep_element *element = &p->creep[i];
        if (!(element->timeConstant > 0))
            return refuse(message, size, "creep[%d].timeConstant is %g s; it must be positive", i + 1,
                          (double)element->timeConstant);
        least += real_fmin(element->gain, 0);
        if (!(least > 0))
            return refuse(message, size,
                          "1 plus the negative gains up to creep[%d].gain is %g; it must "
                          "be positive: creep could not be inverted",
                          i + 1, (double)least);
    }
    return true;
}

static bool creep_is_on(const struct chain_parameters *p)
{
    return p->creepCount > 0;
}

static bool creep_is_idle(const struct chain_parameters *p)
{
    for (int i = 0; i < p->creepCount; i++)
        if (p->creep[i].gain != 0)
            return false;
    return true;
}

static void creep_prepare(void *constants, const struct chain_parameters *p)
{
    struct creep *creep = constants;

    creep->first = 0;
    creep->count = p->creepCount;
    creep->zero = p->displacementZero;
    creep->slope = 1;
    for (int i = 0; i < creep->count; i++) {
        creep->gain[i] = p->creep[i].gain;
        creep->rate[i] = -real_expm1(-p->sampleTime / p->creep[i].timeConstant);
        creep->slope += creep->gain[i] * creep->rate[i];
    }
    creep->per_slope = 1 / creep->slope;
}

static size_t creep_used(const void *constants)
{
    const struct creep *creep = constants;

    return (size_t)creep->count * sizeof(real);
}

/* How far a term's state lies ahead of the input where initialCreep is 1. */
static real creep_kept(const struct chain_parameters *p, int i)
{
    return real_exp(-p->initialCreepAge / p->creep[i].timeConstant);
}

/* With states that lay initialCreep ahead of the input (by 0 after long rest), initialCreepAge ago. */
static real creep_rest(const void *constants, void *state, real y, const struct chain_parameters *p)
{
    const struct creep *creep = constants;
    struct creep_state *s = state;
    real sum = 1;

    y -= creep->zero;
    for (int i = 0; i < creep->count; i++) {
        sum += creep->gain[i];
        s->s[i] = p->initialCreep * creep_kept(p, i);
        y -= creep->gain[i] * s->s[i];
    }
    const real x = y / sum;
    for (int i = 0; i < creep->count; i++)
        s->s[i] += x;
    return creep->zero + x;
}

static real creep_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct creep *creep = constants;
    struct creep_state *s = state;
    const real above = x - creep->zero;
    real y = above;

    (void)around;
    for (int i = 0; i < creep->count; i++) {
        s->s[i] += creep->rate[i] * (above - s->s[i]);
        y += creep->gain[i] * s->s[i];
    }
    return creep->zero + y;
}

/* What of y above zero is left for the input, where the states are these. */
static real creep_solve(const struct creep *creep, const struct creep_state *s, real y)
{
    for (int i = 0; i < creep->count; i++)
        y -= creep->gain[i] * (s->s[i] - creep->rate[i] * s->s[i]);
    return y * creep->per_slope;
}

static real creep_inverse(const void *constants, void *state, real y, const struct stage_surroundings *around)
{
    const struct creep *creep = constants;

    (void)around;
    return creep->zero + creep_solve(creep, state, y - creep->zero);
}

static void creep_prepare_tangent(void *d_constants, const void *constants, const struct chain_parameters *p,
                                  const struct chain_parameters *d)
{
    const struct creep *creep = constants;
    struct creep *result = d_constants;

    result->zero = d->displacementZero;
    for (int i = creep->count - 1; i >= 0; i--) {
        const real ratio = p->sampleTime / p->creep[i].timeConstant;
        result->gain[i] = d->creep[i].gain;
        result->rate[i] = -ratio / p->creep[i].timeConstant * real_exp(-ratio) * d->creep[i].timeConstant;
        if (result->gain[i] == 0 && result->rate[i] == 0)
            continue;
        result->first = i;
        result->count = result->count ? result->count : i + 1;
    }
}

static real creep_rest_tangent(const void *constants, const void *d_constants, const void *state, void *d_state,
                               real x, real d_y, const struct chain_parameters *p,
                               const struct chain_parameters *d)
{
    const struct creep *creep = constants, *by = d_constants;
    struct creep_state *s = d_state;
    real sum = 1;

    (void)state;
    d_y -= by->zero;
    for (int i = 0; i < creep->count; i++) {
        const real kept = creep_kept(p, i), tau = p->creep[i].timeConstant;
        const real d_age = d->initialCreepAge - p->initialCreepAge / tau * d->creep[i].timeConstant;
        sum += creep->gain[i];
        s->s[i] = kept * (d->initialCreep - p->initialCreep * d_age / tau);
        d_y -= creep->gain[i] * s->s[i] + by->gain[i] * (x - creep->zero + p->initialCreep * kept);
    }
    const real d_x = d_y / sum;
    for (int i = 0; i < creep->count; i++)
        s->s[i] += d_x;
    return by->zero + d_x;
}

static void creep_tangent(const void *constants, const void *state, real x,
                          const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                          int count, real *restrict d_state, real *restrict row)
{
    const struct creep *creep = constants;
    real input[STAGE_CHUNK];

    (void)around, (void)state, (void)x, (void)d_around;
    for (int first = 0; first < count; first += STAGE_CHUNK) {
        const int n = count - first < STAGE_CHUNK ? count - first : STAGE_CHUNK;
        real *restrict output = row + first;
        memcpy(input, output, (size_t)n * sizeof *input);
        for (int i = 0; i < creep->count; i++) {
            real *restrict s = d_state + (ptrdiff_t)i * count + first;
            for (int c = 0; c < n; c++) {
                s[c] += creep->rate[i] * (input[c] - s[c]);
                output[c] += creep->gain[i] * s[c];
            }
        }
    }
}

static real creep_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                                const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct creep *creep = constants, *d = d_constants;
    const struct creep_state *s = state;
    const real above = x - creep->zero;
    real d_y = 0;

    (void)around;
    for (int i = d->first; i < d->count; i++) {
        const real moved = d->rate[i] * (above - s->s[i]);
        d_state[(ptrdiff_t)i * stride] += moved;
        d_y += creep->gain[i] * moved + d->gain[i] * (s->s[i] + creep->rate[i] * (above - s->s[i]));
    }
    for (int i = 0; i < creep->count && d->zero != 0; i++) {
        d_state[(ptrdiff_t)i * stride] -= creep->rate[i] * d->zero;
        d_y -= creep->gain[i] * creep->rate[i] * d->zero;
    }
    return d_y;
}

static real creep_inverse_tangent(const void *constants, const void *state, real x, void *d_state, real d_y,
                                  const struct stage_surroundings *around,
                                  const struct stage_surroundings *d_around)
{
    (void)around, (void)state, (void)x, (void)d_around;
    return creep_solve(constants, d_state, d_y); /* it is linear */
}

const struct stage creep_stage = {
    .is_on = creep_is_on,
    .is_idle = creep_is_idle,
    .prepare = creep_prepare,
    .rest = creep_rest,
    .step = creep_step,
    .used = creep_used,
    .inverse = creep_inverse,
};

const struct stage_analysis creep_analysis = {
    .check = creep_check,
    .prepare_tangent = creep_prepare_tangent,
    .rest_tangent = creep_rest_tangent,
    .tangent = creep_tangent,
    .by_parameters = creep_by_parameters,
    .inverse_tangent = creep_inverse_tangent,
};
