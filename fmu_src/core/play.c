#include "play.h"

bool play_check(const struct play_element *elements, int count, char *message, size_t size)
{
    double slope = 1.0;

    if (count < 0 || count > PLAY_MAX)
        return refuse(message, size, "playCount is %d; it must be 0 to %d", count, PLAY_MAX);
    for (int j = 0; j < count; j++) {
        const double least = j > 0 ? elements[j - 1].threshold : 0.0;
        if (!(elements[j].threshold >= least))
            return refuse(message, size, "play[%d].threshold is %g V; thresholds must rise, so it must be "
                          "at least %g V", j + 1, elements[j].threshold, least);
        slope += elements[j].weight;
        if (!(slope > 0.0))
            return refuse(message, size, "1 plus the weights up to play[%d].weight is %g; it must be "
                          "positive: the play operators would not be monotone and could not be inverted",
                          j + 1, slope);
    }
    return true;
}

void play_prepare(struct play *stage, const struct play_element *elements, int count)
{
    stage->count = count;
    for (int j = 0; j < count; j++)
        stage->element[j] = elements[j];
}

/* Play operators know differences of voltages only: the history is walked with rest at 0. */
void play_recall(const struct play *stage, struct play_state *state, double x,
                 struct play_history history)
{
    *state = (struct play_state){ { 0.0 } };
    for (int j = 0; j < stage->count; j++)
        state->p[j] = history.offset;
    play_step(stage, state, history.offset + history.excursion);
    play_step(stage, state, 0.0);
    for (int j = 0; j < stage->count; j++)
        state->p[j] += x;
}

/* h = x + sum_j w_j (x + g_j), where the history leaves g_j above the input. */
double play_reset(const struct play *stage, struct play_state *state, double h,
                  struct play_history history)
{
    double slope = 1.0;

    play_recall(stage, state, 0.0, history);
    for (int j = 0; j < stage->count; j++) {
        h -= stage->element[j].weight * state->p[j];
        slope += stage->element[j].weight;
    }
    for (int j = 0; j < stage->count; j++)
        state->p[j] += h / slope;
    return h / slope;
}

double play_step(const struct play *stage, struct play_state *state, double x)
{
    double h = x;

    for (int j = 0; j < stage->count; j++) {
        const double r = stage->element[j].threshold;
        state->p[j] = clamp(state->p[j], x - r, x + r);
        h += stage->element[j].weight * state->p[j];
    }
    return h;
}

/* Walks from the segment in which no operator moves, upwards (side 1) or downwards (side -1), to the
 * segment that holds h. On a segment: slope x = sum. */
static double walk(const struct play *stage, const struct play_state *state, double sum, double side)
{
    double slope = 1.0;
    double x = sum;

    for (int j = 0; j < stage->count; j++) {
        const double corner = state->p[j] + side * stage->element[j].threshold;
        if (!(side * (x - corner) > 0.0))
            break;
        sum += stage->element[j].weight * corner;
        slope += stage->element[j].weight;
        x = sum / slope;
    }
    return x;
}

double play_solve(const struct play *stage, const struct play_state *state, double h)
{
    double sum = h;

    if (stage->count == 0)
        return h;
    for (int j = 0; j < stage->count; j++)
        sum -= stage->element[j].weight * state->p[j];
    return walk(stage, state, sum, sum > state->p[0] ? 1.0 : -1.0);
}

double play_inverse(const struct play *stage, struct play_state *state, double h)
{
    const double x = play_solve(stage, state, h);

    play_step(stage, state, x);
    return x;
}

/* Does x move operator j? */
static bool engaged(const struct play *stage, const struct play_state *state, int j, double x)
{
    const double r = stage->element[j].threshold;

    return state->p[j] < x - r || state->p[j] > x + r;
}

double play_step_tangent(const struct play *stage, const struct play_state *state, double x,
                         struct play_state *d_state, double d_x)
{
    double d_h = d_x;

    for (int j = 0; j < stage->count; j++) {
        if (engaged(stage, state, j, x))
            d_state->p[j] = d_x;
        d_h += stage->element[j].weight * d_state->p[j];
    }
    return d_h;
}

double play_solve_tangent(const struct play *stage, const struct play_state *state, double x,
                          const struct play_state *d_state, double d_h)
{
    double slope = 1.0;

    for (int j = 0; j < stage->count; j++) {
        if (engaged(stage, state, j, x))
            slope += stage->element[j].weight;
        else
            d_h -= stage->element[j].weight * d_state->p[j];
    }
    return d_h / slope;
}

/* An operator's output and its derivative. */
struct moved {
    double p;
    double d_p;
};

/* Once the input has come to x. */
static struct moved move(struct moved from, double threshold, double d_threshold, double x, double d_x)
{
    if (x - threshold > from.p)
        return (struct moved){ x - threshold, d_x - d_threshold };
    if (x + threshold < from.p)
        return (struct moved){ x + threshold, d_x + d_threshold };
    return from;
}

double play_reset_tangent(const struct play *stage, double h, struct play_history history,
                          const struct play_element *d, double d_h, struct play_history d_history)
{
    struct play_state state;
    const double x = play_reset(stage, &state, h, history);
    const struct moved rested = { history.offset, d_history.offset };
    double slope = 1.0;

    for (int j = 0; j < stage->count; j++) {
        const double r = stage->element[j].threshold;
        const struct moved turned = move(rested, r, d[j].threshold, history.offset + history.excursion,
                                         d_history.offset + d_history.excursion);
        const struct moved last = move(turned, r, d[j].threshold, 0.0, 0.0);
        d_h -= d[j].weight * (x + last.p) + stage->element[j].weight * last.d_p;
        slope += stage->element[j].weight;
    }
    return d_h / slope;
}
