#include "resonance.h"

#include "chain.h"

/* A slower pair of poles would leave too few digits in 1 - a1 - a2. */
#define RESONANCE_SLOWEST REAL(1e-5) /* per sample time */
/* Nearer to -1 the inverse would ring for long. */
#define RESONANCE_LOWEST_ZERO REAL(-0.95)
/* A delay that is the longest but for rounding is taken as that. */
#define RESONANCE_ROUNDING REAL(1e-9)

static bool resonance_check(const struct chain_parameters *p, char *message, size_t size)
{
    const real frequency = p->resonance.frequency, damping = p->resonance.damping;
    const real sample_time = p->sampleTime;

    if (frequency == 0)
        return true;
    if (!(frequency >= RESONANCE_SLOWEST / sample_time && frequency < REAL(0.5) / sample_time))
        return refuse(message, size,
                      "resonance.frequency is %g Hz; at a sampleTime of %g s it must be "
                      "%g Hz to below %g Hz (Nyquist), or 0 for none",
                      (double)frequency, (double)sample_time, (double)(RESONANCE_SLOWEST / sample_time),
                      (double)(REAL(0.5) / sample_time));
    if (!(damping > 0 && damping < 1))
        return refuse(message, size, "resonance.damping is %g; it must be above 0 and below 1",
                      (double)damping);
    if (!(p->resonance.samplingZero >= RESONANCE_LOWEST_ZERO && p->resonance.samplingZero <= 0))
        return refuse(message, size, "resonance.samplingZero is %g; it must be %g to 0",
                      (double)p->resonance.samplingZero, (double)RESONANCE_LOWEST_ZERO);
    const real longest = RESONANCE_MAX_TICKS * sample_time;
    if (!(p->resonance.samplingDelay >= 0 && p->resonance.samplingDelay <= longest * (1 + RESONANCE_ROUNDING)))
        return refuse(message, size,
                      "resonance.samplingDelay is %g s; at a sampleTime of %g s it must be 0 to %g s, %d ticks",
                      (double)p->resonance.samplingDelay, (double)sample_time, (double)longest,
                      RESONANCE_MAX_TICKS);
    return true;
}

static bool resonance_is_on(const struct chain_parameters *p)
{
    return p->resonance.frequency > 0;
}

static void resonance_prepare(void *constants, const struct chain_parameters *p)
{
    const real angle = TWO_PI * p->resonance.frequency * p->sampleTime;
    const real damping = p->resonance.damping;
    const real radius = real_exp(-damping * angle);
    struct resonance *resonance = constants;

    resonance->a1 = 2 * radius * real_cos(angle * real_sqrt(1 - damping * damping));
    resonance->a2 = -radius * radius;
    resonance->b0 = (1 - resonance->a1 - resonance->a2) / (1 - p->resonance.samplingZero);
    resonance->b1 = -p->resonance.samplingZero * resonance->b0;
    resonance->per_b0 = 1 / resonance->b0;
    resonance->latency = p->resonance.samplingDelay;
    resonance->ticks = real_fmin(resonance->latency / p->sampleTime, RESONANCE_MAX_TICKS);
}

static real resonance_latency(const void *constants)
{
    const struct resonance *resonance = constants;

    return resonance->latency;
}

static void resonance_advance(struct resonance_state *state, real x, real y)
{
    state->y2 = state->y1;
    state->y1 = y;
    state->x1 = x;
}

/* What y was so many ticks ago. */
static real resonance_before(real ticks, real y, real y1, real y2)
{
    return ticks > 1 ? y1 + (ticks - 1) * (y2 - y1) : y + ticks * (y1 - y);
}

static real resonance_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct resonance *resonance = constants;
    struct resonance_state *s = state;
    const real y = resonance->a1 * s->y1 + resonance->a2 * s->y2 + resonance->b0 * x + resonance->b1 * s->x1;
    const real later = resonance->ticks > 0 ? resonance_before(resonance->ticks, y, s->y1, s->y2) : y;

    (void)around;
    resonance_advance(s, x, y);
    return later;
}

static real resonance_inverse(const void *constants, void *state, real y,
                              const struct stage_surroundings *around)
{
    const struct resonance *resonance = constants;
    struct resonance_state *s = state;
    const real past = resonance->a1 * s->y1 + resonance->a2 * s->y2 + resonance->b1 * s->x1;
    const real x = (y - past) * resonance->per_b0;

    (void)around;
    resonance_advance(s, x, y);
    return x;
}

static void resonance_prepare_tangent(void *d_constants, const void *constants,
                                      const struct chain_parameters *p, const struct chain_parameters *d)
{
    const real damping = p->resonance.damping, d_damping = d->resonance.damping;
    const real angle = TWO_PI * p->resonance.frequency * p->sampleTime;
    const real d_angle = TWO_PI * d->resonance.frequency * p->sampleTime;
    const real radius = real_exp(-damping * angle);
    const real d_radius = -radius * (d_damping * angle + damping * d_angle);
    const real root = real_sqrt(1 - damping * damping);
    const real d_phase = d_angle * root - angle * damping / root * d_damping;
    const struct resonance *at = constants;
    struct resonance *result = d_constants;

    result->a1 = 2 * (d_radius * real_cos(angle * root) - radius * real_sin(angle * root) * d_phase);
    result->a2 = -2 * radius * d_radius;
    const real past = 1 - p->resonance.samplingZero;
    result->b0 = (-result->a1 - result->a2 + at->b0 * d->resonance.samplingZero) / past;
    result->b1 = -d->resonance.samplingZero * at->b0 - p->resonance.samplingZero * result->b0;
    result->latency = d->resonance.samplingDelay;
    result->ticks = d->resonance.samplingDelay / p->sampleTime;
}

static void resonance_tangent(const void *constants, const void *state, real x,
                              const struct stage_surroundings *around,
                              const struct stage_surroundings *d_around, int count, real *restrict d_state,
                              real *restrict row)
{
    const struct resonance *resonance = constants;
    real *restrict d_y2 = d_state + count;
    real *restrict d_x1 = d_state + 2 * count;

    (void)around, (void)state, (void)x, (void)d_around;
    for (int c = 0; c < count; c++) {
        const real d_y1 = d_state[c], d_before = d_y2[c];
        const real d_y =
            resonance->a1 * d_y1 + resonance->a2 * d_before + resonance->b0 * row[c] + resonance->b1 * d_x1[c];
        d_y2[c] = d_y1;
        d_x1[c] = row[c];
        d_state[c] = d_y;
        row[c] = resonance_before(resonance->ticks, d_y, d_y1, d_before);
    }
}

/* Of `resonance_before` by the ticks; at a whole one, where it has a corner, the mean of both sides. */
static real resonance_by_ticks(real ticks, real y, real y1, real y2)
{
    if (ticks == 1)
        return REAL(0.5) * (y2 - y);
    return ticks > 1 ? y2 - y1 : y1 - y;
}

static real resonance_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                                    const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct resonance *resonance = constants, *d = d_constants;
    const struct resonance_state *s = state;
    const real moved = d->a1 * s->y1 + d->a2 * s->y2 + d->b0 * x + d->b1 * s->x1;
    const real ticks = resonance->ticks;

    (void)around, (void)stride;
    d_state[0] += moved;
    const real later = resonance_before(ticks, moved, 0, 0);
    if (d->ticks == 0)
        return later;
    const real y = resonance->a1 * s->y1 + resonance->a2 * s->y2 + resonance->b0 * x + resonance->b1 * s->x1;
    return later + d->ticks * resonance_by_ticks(ticks, y, s->y1, s->y2);
}

static real resonance_inverse_tangent(const void *constants, const void *state, real x, void *d_state, real d_y,
                                      const struct stage_surroundings *around,
                                      const struct stage_surroundings *d_around)
{
    (void)around, (void)state, (void)x;
    return resonance_inverse(constants, d_state, d_y, d_around); /* it is linear */
}

const struct stage resonance_stage = {
    .is_on = resonance_is_on,
    .prepare = resonance_prepare,
    .step = resonance_step,
    .inverse = resonance_inverse,
    .latency = resonance_latency,
};

const struct stage_analysis resonance_analysis = {
    .check = resonance_check,
    .prepare_tangent = resonance_prepare_tangent,
    .tangent = resonance_tangent,
    .by_parameters = resonance_by_parameters,
    .inverse_tangent = resonance_inverse_tangent,
};
