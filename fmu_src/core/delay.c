#include "delay.h"

#include <string.h>

#include "chain.h"

/* Ticks: a time that is a whole number of them but for rounding is taken as whole. */
#define ROUNDING REAL(1e-9)

static bool delay_check(const struct chain_parameters *p, char *message, size_t size)
{
    if (!(p->delay.time >= 0))
        return refuse(message, size, "delay.time is %g s; it must not be negative", (double)p->delay.time);
    if (!(p->delay.time <= (DELAY_MAX_TICKS + ROUNDING) * p->sampleTime))
        return refuse(message, size,
                      "delay.time is %g s; at a sampleTime of %g s it must be at most %g s, "
                      "%d ticks",
                      (double)p->delay.time, (double)p->sampleTime, (double)(DELAY_MAX_TICKS * p->sampleTime),
                      DELAY_MAX_TICKS);
    return true;
}

static bool delay_is_on(const struct chain_parameters *p)
{
    return p->delay.time > 0;
}

static void delay_prepare(void *constants, const struct chain_parameters *p)
{
    const real ticks = p->delay.time / p->sampleTime;
    const real whole = real_floor(ticks + ROUNDING);
    const real fraction = ticks - whole;

    *(struct delay *)constants = (struct delay){ .ticks = (int)whole,
                                                 .fraction = fraction > ROUNDING ? fraction : 0,
                                                 .time = p->delay.time };
}

static real delay_latency(const void *constants)
{
    const struct delay *delay = constants;

    return delay->time;
}

static real delay_rest(const void *constants, void *state, real u, const struct chain_parameters *p)
{
    struct delay_state *s = state;

    (void)constants, (void)p;
    s->newest = 0;
    for (int i = 0; i < DELAY_MAX_TICKS; i++)
        s->u[i] = u;
    return u;
}

/* The number of voltages that are needed; one more than the output is made of, for its derivative. */
static int delay_needed(const struct delay *delay)
{
    return delay->ticks < DELAY_MAX_TICKS ? delay->ticks + 1 : DELAY_MAX_TICKS;
}

static size_t delay_used(const void *constants)
{
    return offsetof(struct delay_state, u) + (size_t)delay_needed(constants) * sizeof(real);
}

/* Where u_{k-1} is. A state that was not made here may say anything. */
static int delay_newest(const struct delay *delay, const struct delay_state *s)
{
    return s->newest >= 0 && s->newest < delay_needed(delay) ? (int)s->newest : 0;
}

/* Where, from there, the voltage of so many ticks before is. */
static int delay_before(const struct delay *delay, int newest, int ticks)
{
    const int place = newest + ticks, needed = delay_needed(delay);

    return place < needed ? place : place - needed;
}

static real delay_step(const void *constants, void *state, real u, const struct stage_surroundings *around)
{
    const struct delay *delay = constants;
    struct delay_state *s = state;
    const int newest = delay_newest(delay, s);
    const int oldest = delay_before(delay, newest, delay_needed(delay) - 1);
    real y = delay->ticks > 0 ? s->u[delay_before(delay, newest, delay->ticks - 1)] : u;

    (void)around;
    if (delay->fraction > 0)
        y += delay->fraction * (s->u[oldest] - y); /* of a whole tick more */
    s->u[oldest] = u;
    s->newest = (real)oldest;
    return y;
}

static void delay_prepare_tangent(void *d_constants, const void *constants, const struct chain_parameters *p,
                                  const struct chain_parameters *d)
{
    struct delay *result = d_constants;

    (void)constants;
    result->fraction = d->delay.time / p->sampleTime;
    result->time = d->delay.time;
}

static real delay_rest_tangent(const void *constants, const void *d_constants, const void *state, void *d_state,
                               real x, real d_y, const struct chain_parameters *p,
                               const struct chain_parameters *d)
{
    (void)state, (void)d_constants, (void)x, (void)d;
    return delay_rest(constants, d_state, d_y, p);
}

static void delay_tangent(const void *constants, const void *state, real x,
                          const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                          int count, real *restrict d_state, real *restrict row)
{
    const struct delay *delay = constants;
    const int newest = delay_newest(delay, state);
    const int oldest = delay_before(delay, newest, delay_needed(delay) - 1);
    /* the first row is that of `newest`, which nothing changes */
    real *const d_u = d_state + count;
    real *const d_oldest = d_u + (size_t)oldest * (size_t)count;
    const real *const d_here =
        delay->ticks > 0 ? d_u + (size_t)delay_before(delay, newest, delay->ticks - 1) * (size_t)count : row;

    (void)around, (void)x, (void)d_around;
    for (int c = 0; c < count; c++) {
        const real d_x = row[c], d_y = d_here[c];
        d_state[c] = 0;
        row[c] = delay->fraction > 0 ? d_y + delay->fraction * (d_oldest[c] - d_y) : d_y;
        d_oldest[c] = d_x;
    }
}

/* At a whole number of ticks the output has a corner; its derivative there is the mean of both sides. */
static real delay_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                                const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct delay *delay = constants, *d = d_constants;
    const struct delay_state *s = state;
    const int ticks = delay->ticks, newest = delay_newest(delay, s);
    const real here = ticks > 0 ? s->u[delay_before(delay, newest, ticks - 1)] : x;
    const real older = ticks < DELAY_MAX_TICKS ? s->u[delay_before(delay, newest, ticks)] : here;
    const real newer = ticks > 1 ? s->u[delay_before(delay, newest, ticks - 2)] : x;

    (void)around, (void)d_state, (void)stride;
    if (delay->fraction > 0)
        return d->fraction * (older - here);
    return d->fraction * (ticks < DELAY_MAX_TICKS ? REAL(0.5) * (older - newer) : here - newer);
}

const struct stage delay_stage = {
    .is_on = delay_is_on,
    .prepare = delay_prepare,
    .rest = delay_rest,
    .step = delay_step,
    .used = delay_used,
    .latency = delay_latency,
};

const struct stage_analysis delay_analysis = {
    .check = delay_check,
    .prepare_tangent = delay_prepare_tangent,
    .rest_tangent = delay_rest_tangent,
    .tangent = delay_tangent,
    .by_parameters = delay_by_parameters,
};
