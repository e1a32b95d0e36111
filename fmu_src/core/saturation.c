#include "saturation.h"

#include "chain.h"

static bool saturation_check(const struct chain_parameters *p, char *message, size_t size)
{
    const struct saturation_parameters *limits = &p->saturation;

    if (limits->minimum == 0 && limits->maximum == 0)
        return true;
    if (!(limits->minimum < limits->maximum))
        return refuse(message, size,
                      "saturation.minimum, %g V, must be below saturation.maximum, %g V "
                      "(both 0: no saturation)",
                      (double)limits->minimum, (double)limits->maximum);
    return true;
}

static bool saturation_is_on(const struct chain_parameters *p)
{
    return p->saturation.minimum < p->saturation.maximum;
}

static void saturation_prepare(void *constants, const struct chain_parameters *p)
{
    *(struct saturation *)constants = (struct saturation){ p->saturation.minimum, p->saturation.maximum };
}

static real saturation_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct saturation *limits = constants;

    (void)state, (void)around;
    return clamp(x, limits->minimum, limits->maximum);
}

static void saturation_tangent(const void *constants, const void *state, real x,
                               const struct stage_surroundings *around,
                               const struct stage_surroundings *d_around, int count, real *restrict d_state,
                               real *restrict row)
{
    const struct saturation *limits = constants;

    (void)around, (void)state, (void)d_around, (void)d_state;
    if (!(x < limits->minimum || x > limits->maximum))
        return;
    for (int c = 0; c < count; c++)
        row[c] = 0;
}

static real saturation_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                                     const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct saturation *limits = constants, *d = d_constants;

    (void)state, (void)around, (void)d_state, (void)stride;
    return x < limits->minimum ? d->minimum : x > limits->maximum ? d->maximum : 0;
}

const struct stage saturation_stage = {
    .limits = true,
    .is_on = saturation_is_on,
    .prepare = saturation_prepare,
    .step = saturation_step,
    .inverse = saturation_step,
};

const struct stage_analysis saturation_analysis = {
    .check = saturation_check,
    .tangent = saturation_tangent,
    .by_parameters = saturation_by_parameters,
};
