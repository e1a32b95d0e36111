#include "drift.h"

#include "chain.h"

static bool drift_is_on(const struct chain_parameters *p)
{
    return p->drift.temperatureCoefficient != 0 || p->drift.rate != 0;
}

static void drift_prepare(void *constants, const struct chain_parameters *p)
{
    *(struct drift *)constants = (struct drift){ p->drift.temperatureCoefficient, p->drift.rate };
}

static real drift_offset(const struct drift *drift, const struct stage_surroundings *around)
{
    return drift->temperatureCoefficient * (around->temperature - DRIFT_REFERENCE_TEMPERATURE) +
           drift->rate * around->time;
}

static real drift_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    (void)state;
    return x + drift_offset(constants, around);
}

static real drift_inverse(const void *constants, void *state, real y, const struct stage_surroundings *around)
{
    (void)state;
    return y - drift_offset(constants, around);
}

static void drift_tangent(const void *constants, const void *state, real x,
                          const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                          int count, real *restrict d_state, real *restrict row)
{
    const struct drift *drift = constants;

    (void)around, (void)state, (void)x, (void)d_state;
    for (int c = 0; c < count; c++)
        row[c] += drift->temperatureCoefficient * d_around[c].temperature;
}

static real drift_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                                const struct stage_surroundings *around, real *d_state, int stride)
{
    (void)constants, (void)state, (void)x, (void)d_state, (void)stride;
    return drift_offset(d_constants, around);
}

static real drift_inverse_tangent(const void *constants, const void *state, real x, void *d_state, real d_y,
                                  const struct stage_surroundings *around,
                                  const struct stage_surroundings *d_around)
{
    const struct drift *drift = constants;

    (void)around, (void)state, (void)x, (void)d_state;
    return d_y - drift->temperatureCoefficient * d_around->temperature;
}

const struct stage drift_stage = {
    .is_on = drift_is_on,
    .prepare = drift_prepare,
    .step = drift_step,
    .inverse = drift_inverse,
};

const struct stage_analysis drift_analysis = {
    .tangent = drift_tangent,
    .by_parameters = drift_by_parameters,
    .inverse_tangent = drift_inverse_tangent,
};
