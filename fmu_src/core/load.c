#include "load.h"

#include "chain.h"

static bool load_check(const struct chain_parameters *p, char *message, size_t size)
{
    if (!(p->load.compliance >= 0))
        return refuse(message, size,
                      "load.compliance is %g m/N; it must not be negative (force is "
                      "compressive positive)",
                      (double)p->load.compliance);
    return true;
}

static bool load_is_on(const struct chain_parameters *p)
{
    return p->load.compliance != 0;
}

static void load_prepare(void *constants, const struct chain_parameters *p)
{
    struct load *load = constants;

    load->compliance = p->load.compliance;
}

static real load_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct load *load = constants;

    (void)state;
    return x - load->compliance * around->force;
}

static real load_inverse(const void *constants, void *state, real y, const struct stage_surroundings *around)
{
    const struct load *load = constants;

    (void)state;
    return y + load->compliance * around->force;
}

static void load_tangent(const void *constants, const void *state, real x,
                         const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                         int count, real *restrict d_state, real *restrict row)
{
    const struct load *load = constants;

    (void)around, (void)state, (void)x, (void)d_state;
    for (int c = 0; c < count; c++)
        row[c] -= load->compliance * d_around[c].force;
}

static real load_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                               const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct load *d = d_constants;

    (void)constants, (void)state, (void)x, (void)d_state, (void)stride;
    return -d->compliance * around->force;
}

static real load_inverse_tangent(const void *constants, const void *state, real x, void *d_state, real d_y,
                                 const struct stage_surroundings *around,
                                 const struct stage_surroundings *d_around)
{
    (void)around, (void)state, (void)x;
    return load_inverse(constants, d_state, d_y, d_around); /* it is linear */
}

const struct stage load_stage = {
    .is_on = load_is_on,
    .prepare = load_prepare,
    .step = load_step,
    .inverse = load_inverse,
};

const struct stage_analysis load_analysis = {
    .check = load_check,
    .tangent = load_tangent,
    .by_parameters = load_by_parameters,
    .inverse_tangent = load_inverse_tangent,
};
