#include "creep.h"

#include <math.h>

bool creep_check(const struct creep_element *elements, int count, char *message, size_t size)
{
    double least = 1.0;

    if (count < 0 || count > CREEP_MAX)
        return refuse(message, size, "creepCount is %d; it must be 0 to %d", count, CREEP_MAX);
    for (int i = 0; i < count; i++) {
        if (!(elements[i].timeConstant > 0.0))
            return refuse(message, size, "creep[%d].timeConstant is %g s; it must be positive", i + 1,
                          elements[i].timeConstant);
        least += fmin(elements[i].gain, 0.0);
        if (!(least > 0.0))
            return refuse(message, size, "1 plus the negative gains up to creep[%d].gain is %g; it must "
                          "be positive: creep could not be inverted", i + 1, least);
    }
    return true;
}

void creep_prepare(struct creep *stage, const struct creep_element *elements, int count,
                   double sample_time)
{
    stage->count = count;
    stage->slope = 1.0;
    for (int i = 0; i < count; i++) {
        stage->gain[i] = elements[i].gain;
        stage->rate[i] = -expm1(-sample_time / elements[i].timeConstant);
        stage->slope += stage->gain[i] * stage->rate[i];
    }
}

static double sum_of_gains(const struct creep *stage)
{
    double sum = 0.0;

    for (int i = 0; i < stage->count; i++)
        sum += stage->gain[i];
    return sum;
}

double creep_reset(const struct creep *stage, struct creep_state *state, double y, double ahead)
{
    const double sum = sum_of_gains(stage);
    const double x = (y - sum * ahead) / (1.0 + sum);

    for (int i = 0; i < stage->count; i++)
        state->s[i] = x + ahead;
    return x;
}

double creep_step(const struct creep *stage, struct creep_state *state, double x)
{
    double y = x;

    for (int i = 0; i < stage->count; i++) {
        state->s[i] += stage->rate[i] * (x - state->s[i]);
        y += stage->gain[i] * state->s[i];
    }
    return y;
}

double creep_solve(const struct creep *stage, const struct creep_state *state, double y)
{
    for (int i = 0; i < stage->count; i++)
        y -= stage->gain[i] * (state->s[i] - stage->rate[i] * state->s[i]);
    return y / stage->slope;
}

double creep_inverse(const struct creep *stage, struct creep_state *state, double y)
{
    const double x = creep_solve(stage, state, y);

    creep_step(stage, state, x);
    return x;
}

double creep_reset_tangent(const struct creep *stage, double x, double ahead,
                           const struct creep_element *d, double d_y, double d_ahead)
{
    const double sum = sum_of_gains(stage);

    for (int i = 0; i < stage->count; i++)
        d_y -= (x + ahead) * d[i].gain;
    return (d_y - sum * d_ahead) / (1.0 + sum);
}
