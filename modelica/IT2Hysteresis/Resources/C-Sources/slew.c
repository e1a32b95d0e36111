#include "slew.h"

bool slew_check(const struct slew_parameters *parameters, char *message, size_t size)
{
    if (!(parameters->rate >= 0.0))
        return refuse(message, size, "slew.rate is %g V/s; it must be positive, or 0 for no limit",
                      parameters->rate);
    return true;
}

void slew_prepare(struct slew *stage, const struct slew_parameters *parameters, double sample_time)
{
    stage->step = parameters->rate * sample_time;
}

void slew_reset(struct slew_state *state, double y)
{
    state->y = y;
}

double slew_step(const struct slew *stage, struct slew_state *state, double x)
{
    state->y = clamp(x, state->y - stage->step, state->y + stage->step);
    return state->y;
}

double slew_step_tangent(const struct slew *stage, const struct slew_state *state, double x,
                         struct slew_state *d_state, double d_x)
{
    const bool limited = x < state->y - stage->step || x > state->y + stage->step;

    d_state->y = limited ? d_state->y : d_x;
    return d_state->y;
}

double slew_inverse(const struct slew *stage, struct slew_state *state, double y)
{
    return slew_step(stage, state, y);
}
