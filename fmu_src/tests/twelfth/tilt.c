#include "chain.h"
static bool tilt_is_on(const struct chain_parameters *p)
{
    return p->tilt.gain != 0.0;
}
static void tilt_prepare(void *constants, const struct chain_parameters *p)
{
    ((struct tilt *)constants)->gain = p->tilt.gain;
}

static double tilt_step(const void *constants, void *state, double x, const struct stage_surroundings *around)
{
    struct tilt_state *s = state;
    const double y = x + ((const struct tilt *)constants)->gain * (x - s->x);
    (void)around;
    s->x = x;
    return y;
}

static double tilt_inverse(const void *constants, void *state, double y,
                           const struct stage_surroundings *around)
{
    const double gain = ((const struct tilt *)constants)->gain;
    struct tilt_state *s = state;
    (void)around;
    return s->x = (y + gain * s->x) / (1.0 + gain);
}

static bool tilt_check(const struct chain_parameters *p, char *message, size_t size)
{
    return p->tilt.gain > -1.0 || refuse(message, size, "tilt.gain is %g", p->tilt.gain);
}

static void tilt_tangent(const void *constants, const void *state, double x,
                         const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                         int count, double *restrict d_state, double *restrict row)
{
    (void)state, (void)x, (void)around, (void)d_around;
    for (int c = 0; c < count; c++) {
        const double d_x = row[c];
        row[c] += ((const struct tilt *)constants)->gain * (d_x - d_state[c]);
        d_state[c] = d_x;
    }
}

static double tilt_by_parameters(const void *constants, const void *d_constants, const void *state, double x,
                                 const struct stage_surroundings *around, double *d_state, int stride)
{
    (void)constants, (void)around, (void)d_state, (void)stride;
    return ((const struct tilt *)d_constants)->gain * (x - ((const struct tilt_state *)state)->x);
}

static double tilt_inverse_tangent(const void *constants, const void *state, double x, void *d_state,
                                   double d_y, const struct stage_surroundings *around,
                                   const struct stage_surroundings *d_around)
{
    (void)state, (void)x, (void)around;
    return tilt_inverse(constants, d_state, d_y, d_around);
}

const struct stage tilt_stage = {
    .is_on = tilt_is_on,
    .prepare = tilt_prepare,
    .step = tilt_step,
    .inverse = tilt_inverse,
};

const struct stage_analysis tilt_analysis = {
    .check = tilt_check,
    .tangent = tilt_tangent,
    .by_parameters = tilt_by_parameters,
    .inverse_tangent = tilt_inverse_tangent,
};
