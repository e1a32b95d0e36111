#include "resonance.h"

#include <math.h>

/* A slower pair of poles would leave too few digits in 1 - a1 - a2. */
#define RESONANCE_SLOWEST 1e-5 /* per sample time */

bool resonance_check(const struct resonance_parameters *parameters, double sample_time, char *message,
                     size_t size)
{
    const double frequency = parameters->frequency;

    if (frequency == 0.0)
        return true;
    if (!(frequency >= RESONANCE_SLOWEST / sample_time && frequency < 0.5 / sample_time))
        return refuse(message, size, "resonance.frequency is %g Hz; at a sampleTime of %g s it must be "
                      "%g Hz to below %g Hz (Nyquist), or 0 for none", frequency, sample_time,
                      RESONANCE_SLOWEST / sample_time, 0.5 / sample_time);
    if (!(parameters->damping > 0.0 && parameters->damping < 1.0))
        return refuse(message, size, "resonance.damping is %g; it must be above 0 and below 1",
                      parameters->damping);
    return true;
}

void resonance_prepare(struct resonance *stage, const struct resonance_parameters *parameters,
                       double sample_time)
{
    const double angle = TWO_PI * parameters->frequency * sample_time;
    const double radius = exp(-parameters->damping * angle);

    stage->a1 = 2.0 * radius * cos(angle * sqrt(1.0 - parameters->damping * parameters->damping));
    stage->a2 = -radius * radius;
    stage->b = 1.0 - stage->a1 - stage->a2;
}

void resonance_reset(struct resonance_state *state, double y)
{
    state->y1 = state->y2 = y;
}

static void advance(struct resonance_state *state, double y)
{
    state->y2 = state->y1;
    state->y1 = y;
}

double resonance_step(const struct resonance *stage, struct resonance_state *state, double x)
{
    const double y = stage->a1 * state->y1 + stage->a2 * state->y2 + stage->b * x;

    advance(state, y);
    return y;
}

double resonance_inverse(const struct resonance *stage, struct resonance_state *state, double y)
{
    const double x = (y - stage->a1 * state->y1 - stage->a2 * state->y2) / stage->b;

    advance(state, y);
    return x;
}
