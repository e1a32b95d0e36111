#include "slew.h"

#include "chain.h"

static bool slew_check(const struct chain_parameters *p, char *message, size_t size)
{
    if (!(p->slew.rate >= 0))
        return refuse(message, size, "slew.rate is %g V/s; it must be positive, or 0 for no limit",
                      (double)p->slew.rate);
    return true;
}

static bool slew_is_on(const struct chain_parameters *p)
{
    return p->slew.rate > 0;
}

static void slew_prepare(void *constants, const struct chain_parameters *p)
{
    struct slew *slew = constants;

    slew->step = p->slew.rate * p->sampleTime;
}

static real slew_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct slew *slew = constants;
    struct slew_state *s = state;

    (void)around;
    s->y = clamp(x, s->y - slew->step, s->y + slew->step);
    return s->y;
}

static void slew_prepare_tangent(void *d_constants, const void *constants, const struct chain_parameters *p,
                                 const struct chain_parameters *d)
{
    struct slew *result = d_constants;

    (void)constants;
    result->step = d->slew.rate * p->sampleTime;
}

/* 1 above what it lets through, -1 below, 0 within. */
static int slew_limited(const struct slew *slew, const struct slew_state *s, real x)
{
    return (x > s->y + slew->step) - (x < s->y - slew->step);
}

static void slew_tangent(const void *constants, const void *state, real x,
                         const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                         int count, real *restrict d_state, real *restrict row)
{
    const bool limited = slew_limited(constants, state, x) != 0;

    (void)around, (void)d_around;
    for (int c = 0; c < count; c++)
        row[c] = d_state[c] = limited ? d_state[c] : row[c];
}

static real slew_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                               const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct slew *d = d_constants;
    const real moved = (real)slew_limited(constants, state, x) * d->step;

    (void)around, (void)stride;
    d_state[0] += moved;
    return moved;
}

const struct stage slew_stage = {
    .limits = true,
    .is_on = slew_is_on,
    .prepare = slew_prepare,
    .step = slew_step,
    .inverse = slew_step,
};

const struct stage_analysis slew_analysis = {
    .check = slew_check,
    .prepare_tangent = slew_prepare_tangent,
    .tangent = slew_tangent,
    .by_parameters = slew_by_parameters,
};
