#include "play.h"

#include <string.h>

#include "chain.h"

static bool play_check(const struct chain_parameters *p, char *message, size_t size)
{
    const struct play_element *elements = p->play;
    real slope = 1;

    if (p->playCount < 0 || p->playCount > PLAY_MAX)
        return refuse(message, size, "playCount is %d; it must be 0 to %d", p->playCount, PLAY_MAX);
    for (int j = 0; j < p->playCount; j++) {
        const real least = j > 0 ? elements[j - 1].threshold : 0;
        if (!(elements[j].threshold >= least))
            return refuse(message, size,
                          "play[%d].threshold is %g V; thresholds must rise, so it must be "
                          "at least %g V",
                          j + 1, (double)elements[j].threshold, (double)least);
        slope += elements[j].weight;
        if (!(slope > 0))
            return refuse(message, size,
                          "1 plus the weights up to play[%d].weight is %g; it must be "
                          "positive: the play operators would not be monotone and could not be inverted",
                          j + 1, (double)slope);
    }
    return true;
}

static bool play_is_on(const struct chain_parameters *p)
{
    return p->playCount > 0;
}

static bool play_is_idle(const struct chain_parameters *p)
{
    for (int j = 0; j < p->playCount; j++)
        if (p->play[j].weight != 0)
            return false;
    return true;
}

static void play_prepare(void *constants, const struct chain_parameters *p)
{
    struct play *play = constants;

    play->first = 0;
    play->count = p->playCount;
    for (int j = 0; j < play->count; j++)
        play->element[j] = p->play[j];
}

static size_t play_used(const void *constants)
{
    const struct play *play = constants;

    return (size_t)play->count * sizeof(real);
}

static real play_step(const void *constants, void *state, real x, const struct stage_surroundings *around)
{
    const struct play *play = constants;
    struct play_state *s = state;
    real h = x;

    (void)around;
    for (int j = 0; j < play->count; j++) {
        const real r = play->element[j].threshold;
        s->p[j] = clamp(s->p[j], x - r, x + r);
        h += play->element[j].weight * s->p[j];
    }
    return h;
}

/* Walks from the segment in which no operator moves, upwards (side 1) or downwards (side -1), to the
 * segment that holds h. On a segment: slope x = sum. */
static real play_walk(const struct play *play, const struct play_state *s, real sum, real side)
{
    real slope = 1;
    real x = sum;

    for (int j = 0; j < play->count; j++) {
        const real corner = s->p[j] + side * play->element[j].threshold;
        if (!(side * (x - corner) > 0))
            break;
        sum += play->element[j].weight * corner;
        slope += play->element[j].weight;
        x = sum / slope;
    }
    return x;
}

static real play_inverse(const void *constants, void *state, real h, const struct stage_surroundings *around)
{
    const struct play *play = constants;
    const struct play_state *s = state;
    real sum = h;

    (void)around;
    for (int j = 0; j < play->count; j++)
        sum -= play->element[j].weight * s->p[j];
    return play_walk(play, s, sum, sum > s->p[0] ? 1 : -1);
}

/* Demagnetised, driven to the turning point, and from there to where the output is h. */
static real play_rest(const void *constants, void *state, real h, const struct chain_parameters *p)
{
    const struct play *play = constants;
    struct play_state *s = state;

    *s = (struct play_state){ { 0 } };
    for (int j = 0; j < play->count; j++)
        s->p[j] = p->initialDemagnetisation;
    play_step(play, s, p->initialDemagnetisation + p->initialExcursion, NULL);
    const real x = play_inverse(play, s, h, NULL);
    play_step(play, s, x, NULL);
    return x;
}

/* Does x move operator j: upwards 1, downwards -1, or not? */
static int play_moves(const struct play *play, const struct play_state *s, int j, real x)
{
    const real r = play->element[j].threshold;

    return (s->p[j] < x - r) - (s->p[j] > x + r);
}

static void play_prepare_tangent(void *d_constants, const void *constants, const struct chain_parameters *p,
                                 const struct chain_parameters *d)
{
    const struct play *play = constants;
    struct play *result = d_constants;

    (void)p;
    for (int j = play->count - 1; j >= 0; j--) {
        result->element[j] = d->play[j];
        if (d->play[j].threshold == 0 && d->play[j].weight == 0)
            continue;
        result->first = j;
        result->count = result->count ? result->count : j + 1;
    }
}

/* An operator's output, its derivative, and whether it has moved. */
struct play_moved {
    real p;
    real d_p;
    bool moved;
};

/* Once the input has come to x. */
static struct play_moved play_move(struct play_moved from, real threshold, real d_threshold, real x, real d_x)
{
    if (x - threshold > from.p)
        return (struct play_moved){ x - threshold, d_x - d_threshold, true };
    if (x + threshold < from.p)
        return (struct play_moved){ x + threshold, d_x + d_threshold, true };
    return (struct play_moved){ from.p, from.d_p, false };
}

static real play_rest_tangent(const void *constants, const void *d_constants, const void *state, void *d_state,
                              real x, real d_h, const struct chain_parameters *p,
                              const struct chain_parameters *d)
{
    const struct play *play = constants, *by = d_constants;
    const struct play_moved new = { p->initialDemagnetisation, d->initialDemagnetisation, false };
    const real turn = p->initialDemagnetisation + p->initialExcursion;
    const real d_turn = d->initialDemagnetisation + d->initialExcursion;
    struct play_moved last[PLAY_MAX];
    struct play_state *s = d_state;
    real slope = 1;

    (void)state;
    for (int j = 0; j < play->count; j++) {
        const struct play_element *element = &play->element[j], *d_element = &by->element[j];
        const struct play_moved turned = play_move(new, element->threshold, d_element->threshold, turn, d_turn);
        last[j] = play_move(turned, element->threshold, d_element->threshold, x, 0);
        d_h -= d_element->weight * last[j].p + element->weight * last[j].d_p;
        if (last[j].moved)
            slope += element->weight;
    }
    const real d_x = d_h / slope;
    for (int j = 0; j < play->count; j++)
        s->p[j] = last[j].d_p + (last[j].moved ? d_x : 0);
    return d_x;
}

static void play_tangent(const void *constants, const void *state, real x,
                         const struct stage_surroundings *around, const struct stage_surroundings *d_around,
                         int count, real *restrict d_state, real *restrict row)
{
    const struct play *play = constants;
    real input[STAGE_CHUNK];

    (void)around, (void)d_around;
    for (int first = 0; first < count; first += STAGE_CHUNK) {
        const int n = count - first < STAGE_CHUNK ? count - first : STAGE_CHUNK;
        real *restrict output = row + first;
        memcpy(input, output, (size_t)n * sizeof *input);
        for (int j = 0; j < play->count; j++) {
            const real weight = play->element[j].weight;
            real *restrict p = d_state + (ptrdiff_t)j * count + first;
            if (play_moves(play, state, j, x))
                memcpy(p, input, (size_t)n * sizeof *input);
            for (int c = 0; c < n; c++)
                output[c] += weight * p[c];
        }
    }
}

static real play_by_parameters(const void *constants, const void *d_constants, const void *state, real x,
                               const struct stage_surroundings *around, real *d_state, int stride)
{
    const struct play *play = constants, *d = d_constants;
    const struct play_state *s = state;
    real d_h = 0;

    (void)around;
    for (int j = d->first; j < d->count; j++) {
        const real r = play->element[j].threshold;
        const real moved = (real)-play_moves(play, s, j, x) * d->element[j].threshold;
        d_state[(ptrdiff_t)j * stride] += moved;
        d_h += play->element[j].weight * moved + d->element[j].weight * clamp(s->p[j], x - r, x + r);
    }
    return d_h;
}

static real play_inverse_tangent(const void *constants, const void *state, real x, void *d_state, real d_h,
                                 const struct stage_surroundings *around,
                                 const struct stage_surroundings *d_around)
{
    const struct play *play = constants;
    const struct play_state *d = d_state;
    real slope = 1;

    (void)around, (void)d_around;
    for (int j = 0; j < play->count; j++) {
        if (play_moves(play, state, j, x))
            slope += play->element[j].weight;
        else
            d_h -= play->element[j].weight * d->p[j];
    }
    return d_h / slope;
}

const struct stage play_stage = {
    .is_on = play_is_on,
    .is_idle = play_is_idle,
    .prepare = play_prepare,
    .rest = play_rest,
    .step = play_step,
    .used = play_used,
    .inverse = play_inverse,
};

const struct stage_analysis play_analysis = {
    .check = play_check,
    .prepare_tangent = play_prepare_tangent,
    .rest_tangent = play_rest_tangent,
    .tangent = play_tangent,
    .by_parameters = play_by_parameters,
    .inverse_tangent = play_inverse_tangent,
};
