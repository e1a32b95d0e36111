#include "hum.h"

#include "chain.h"
#include "sine.h"

static bool hum_check(const struct chain_parameters *p, char *message, size_t size)
{
    if (!(p->hum.amplitude >= 0))
        return refuse(message, size, "hum.amplitude is %g m; it must be positive, or 0 for none",
                      (double)p->hum.amplitude);
    if (p->hum.amplitude > 0 && !(p->hum.frequency > 0))
        return refuse(message, size, "hum.frequency is %g Hz; with a hum.amplitude it must be positive",
                      (double)p->hum.frequency);
    return true;
}

static bool hum_is_on(const struct chain_parameters *p)
{
    return p->hum.amplitude > 0;
}

static void hum_prepare(void *constants, const struct chain_parameters *p)
{
    *(struct hum *)constants = (struct hum){ p->hum.amplitude, p->hum.frequency, p->hum.phase };
}

static real hum_step(const void *constants, void *state, real y, const struct stage_surroundings *around)
{
    const struct hum *hum = constants;

    (void)state;
    return y + hum->amplitude * sine(TWO_PI * hum->frequency * around->time + hum->phase);
}

static real hum_by_parameters(const void *constants, const void *d_constants, const void *state, real y,
                              const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct hum *hum = constants, *d = d_constants;
    const real phase = TWO_PI * hum->frequency * around->time + hum->phase;
    const real d_phase = TWO_PI * d->frequency * around->time + d->phase;

    (void)state, (void)y, (void)d_state, (void)stride;
    return d->amplitude * sine(phase) + hum->amplitude * real_cos(phase) * d_phase;
}

const struct stage hum_stage = {
    .is_on = hum_is_on,
    .prepare = hum_prepare,
    .step = hum_step,
};

const struct stage_analysis hum_analysis = {
    .check = hum_check,
    .by_parameters = hum_by_parameters,
};
