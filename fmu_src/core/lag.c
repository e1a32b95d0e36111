#include "lag.h"

#include "chain.h"

/* A slower pole would leave too few digits for the inverse. */
#define LAG_SLOWEST REAL(1e9) /* sample times */

static bool lag_check(const struct chain_parameters *p, char *message, size_t size)
{
    const real time_constant = p->lag.timeConstant;

    if (!(time_constant >= 0))
        return refuse(message, size, "lag.timeConstant is %g s; it must be positive, or 0 for no lag",
                      (double)time_constant);
    if (!(time_constant <= LAG_SLOWEST * p->sampleTime))
        return refuse(message, size,
                      "lag.timeConstant is %g s; at a sampleTime of %g s it must be at "
                      "most %g s",
                      (double)time_constant, (double)p->sampleTime, (double)(LAG_SLOWEST * p->sampleTime));
    return true;
}

static bool lag_is_on(const struct chain_parameters *p)
{
    return p->lag.timeConstant > 0;
}

static void lag_prepare(void *constants, const struct chain_parameters *p)
{
    struct lag *lag = constants;

    lag->gain = -real_expm1(-p->sampleTime / p->lag.timeConstant);
    lag->per_gain = 1 / lag->gain;
}

static real lag_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct lag *lag = constants;
    struct lag_state *s = state;

    (void)around;
    s->y += lag->gain * (x - s->y);
    return s->y;
}

static real lag_inverse(const void *constants, void *state, real y, const struct stage_surroundings *around)
{
    const struct lag *lag = constants;
    struct lag_state *s = state;
    const real x = s->y + (y - s->y) * lag->per_gain;

    (void)around;
    s->y = y;
    return x;
}

static void lag_prepare_tangent(void *d_constants, const void *constants, const struct chain_parameters *p,
                                const struct chain_parameters *d)
{
    const real time_constant = p->lag.timeConstant;
    const real ratio = p->sampleTime / time_constant;
    struct lag *result = d_constants;

    (void)constants;
    result->gain = -ratio / time_constant * real_exp(-ratio) * d->lag.timeConstant;
}

static void lag_tangent(const void *constants, const void *state, real x,
                        const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                        int count, real *restrict d_state, real *restrict row)
{
    const struct lag *lag = constants;

    (void)around, (void)state, (void)x, (void)d_around;
    for (int c = 0; c < count; c++) {
        d_state[c] += lag->gain * (row[c] - d_state[c]);
        row[c] = d_state[c];
    }
}

static real lag_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                              const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct lag *d = d_constants;
    const struct lag_state *s = state;
    const real moved = d->gain * (x - s->y);

    (void)constants, (void)around, (void)stride;
    d_state[0] += moved;
    return moved;
}

static real lag_inverse_tangent(const void *constants, const void *state, real x, void *d_state, real d_y,
                                const struct stage_surroundings *around,
                                const struct stage_surroundings *d_around)
{
    (void)around, (void)state, (void)x;
    return lag_inverse(constants, d_state, d_y, d_around); /* it is linear */
}

const struct stage lag_stage = {
    .is_on = lag_is_on,
    .prepare = lag_prepare,
    .step = lag_step,
    .inverse = lag_inverse,
};

const struct stage_analysis lag_analysis = {
    .check = lag_check,
    .prepare_tangent = lag_prepare_tangent,
    .tangent = lag_tangent,
    .by_parameters = lag_by_parameters,
    .inverse_tangent = lag_inverse_tangent,
};
