#include "delay.h"

#include <math.h>

/* Ticks: a time that is a whole number of them but for rounding is taken as whole. */
#define ROUNDING 1e-9

bool delay_check(const struct delay_parameters *parameters, double sample_time, char *message,
                 size_t size)
{
    if (!(parameters->time >= 0.0))
        return refuse(message, size, "delay.time is %g s; it must not be negative", parameters->time);
    if (!(parameters->time <= (DELAY_MAX_TICKS + ROUNDING) * sample_time))
        return refuse(message, size, "delay.time is %g s; at a sampleTime of %g s it must be at most %g s, "
                      "%d ticks", parameters->time, sample_time, DELAY_MAX_TICKS * sample_time,
                      DELAY_MAX_TICKS);
    return true;
}

void delay_prepare(struct delay *stage, const struct delay_parameters *parameters, double sample_time)
{
    const double ticks = parameters->time / sample_time;
    const double whole = floor(ticks + ROUNDING);
    const double fraction = ticks - whole;

    *stage = (struct delay){ .ticks = (int)whole,
                             .fraction = fraction > ROUNDING ? fraction : 0.0,
                             .time = parameters->time };
}

void delay_reset(struct delay_state *state, double u)
{
    for (int i = 0; i < DELAY_MAX_TICKS; i++)
        state->u[i] = u;
}

double delay_step(const struct delay *stage, struct delay_state *state, double u)
{
    const int last = stage->ticks + (stage->fraction > 0.0); /* oldest voltage that is needed */
    double y = stage->ticks > 0 ? state->u[stage->ticks - 1] : u;

    if (stage->fraction > 0.0)
        y += stage->fraction * (state->u[stage->ticks] - y);
    for (int i = last - 1; i > 0; i--)
        state->u[i] = state->u[i - 1];
    state->u[0] = u;
    return y;
}
