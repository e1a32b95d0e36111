#include "lag.h"

#include <math.h>

/* A slower pole would leave too few digits for the inverse. */
#define LAG_SLOWEST 1e9 /* sample times */

bool lag_check(const struct lag_parameters *parameters, double sample_time, char *message, size_t size)
{
    if (!(parameters->timeConstant >= 0.0))
        return refuse(message, size, "lag.timeConstant is %g s; it must be positive, or 0 for no lag",
                      parameters->timeConstant);
    if (!(parameters->timeConstant <= LAG_SLOWEST * sample_time))
        return refuse(message, size, "lag.timeConstant is %g s; at a sampleTime of %g s it must be at "
                      "most %g s", parameters->timeConstant, sample_time, LAG_SLOWEST * sample_time);
    return true;
}

void lag_prepare(struct lag *stage, const struct lag_parameters *parameters, double sample_time)
{
    stage->gain = -expm1(-sample_time / parameters->timeConstant);
}

void lag_reset(struct lag_state *state, double y)
{
    state->y = y;
}

double lag_step(const struct lag *stage, struct lag_state *state, double x)
{
    state->y += stage->gain * (x - state->y);
    return state->y;
}

double lag_inverse(const struct lag *stage, struct lag_state *state, double y)
{
    const double x = state->y + (y - state->y) / stage->gain;

    state->y = y;
    return x;
}
