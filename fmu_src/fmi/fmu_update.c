/* doStep for a host that sets inputs within it, or takes it that it ends early: the step is made in pieces of one
 * tick each, each of them a step. A host that does neither gets its step in one piece. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmu.h"

/* A step in pieces. Tick k is at start + ((k - begin.tick) - begin.rest) sample times: by the host's time, which
 * need not be the ticks'. */
struct pieces {
    struct fmu *fmu;
    const char *function;
    double start;
    double end;
    struct fmu_clock begin;
    const void *begun; /* FMU state */
    bool updated;      /* the host was asked for inputs */
    enum fmu_status status;
};

static double time_of(const struct pieces *step, int64_t tick)
{
    const double ticks = (double)(tick - step->begin.tick) - step->begin.rest;

    return ticks > 0.0 ? step->start + ticks * fmu_sample_time(step->fmu) : step->start;
}

/* Goes on to `time`; false where it cannot. */
static bool go_to(struct pieces *step, double time)
{
    const double now = step->fmu->now->clock.time;

    if (time <= now)
        return true;
    const enum fmu_status status = fmu_do_step(step->fmu, step->function, now, time - now);

    if (status > step->status)
        step->status = status;
    return status <= FMU_WARNING;
}

/* Lets the host set inputs, and end the step sooner. */
static void ask_host(struct pieces *step)
{
    struct fmu *fmu = step->fmu;
    const double now = fmu->now->clock.time;
    double end = INFINITY;

    fmu_leave_plain(fmu);
    fmu->now->phase = FMU_UPDATE;
    const bool asked = fmu->host.update(&fmu->host, now, &end);
    fmu->now->phase = FMU_STEP_COMPLETE;
    step->updated = true;
    if (asked && fmu->host.ends_early && !(end >= step->end))
        step->end = end > now ? end : now; /* what is no number is now */
}

/* Is a flag true now that was not? */
static bool newly_outside(const struct fmu_outputs *before, const struct fmu_outputs *now)
{
    for (int i = 0; i < FMU_FLAGS; i++)
        if (now->flag[i] && !before->flag[i])
            return true;
    return false;
}

/* From tick to tick; returns whether all went well. */
static bool make_pieces(struct pieces *step)
{
    struct fmu *fmu = step->fmu;
    const double beginning = step->start + CLOCK_TOLERANCE * fmu_sample_time(fmu);

    for (int64_t tick = step->begin.next_tick; time_of(step, tick) < step->end; tick++) {
        const struct fmu_outputs before = fmu->now->output;
        const double time = time_of(step, tick);
        const double next = time_of(step, tick + 1);
        if (!go_to(step, time))
            return false;
        if (fmu->host.update && time > beginning) /* at the beginning, inputs were set before the step */
            ask_host(step);
        if (time >= step->end)
            return true;
        if (!go_to(step, next < step->end ? next : step->end))
            return false;
        if (fmu->host.ends_early && newly_outside(&before, &fmu->now->output))
            step->end = fmu->now->clock.time;
    }
    return go_to(step, step->end);
}

/* Derivatives are those of the whole step, where its inputs were the same throughout. */
static void join_pieces(const struct pieces *step)
{
    struct fmu *fmu = step->fmu;
    struct fmu_span last = fmu_last_step(fmu->now);

    last.tick = step->begin.tick;
    last.rest = step->begin.rest;
    last.first_tick = step->begin.next_tick;
    last.end_tick = fmu->now->clock.next_tick;
    fmu_leave_plain(fmu);
    fmu->now->last_step = last;
    fmu->now->one_tick = false;
    memcpy(fmu->last_state, fmu_state_in(fmu->model, step->begun), fmu->model->state_size);
    memcpy(fmu->before, fmu->last_state, fmu->model->state_size);
}

static enum fmu_status step_in_pieces(struct pieces *step, struct fmu_ending *ending)
{
    struct fmu *fmu = step->fmu;
    const double end = step->end;

    if (make_pieces(step)) {
        ending->early = step->end < end;
        if (!step->updated)
            join_pieces(step);
    } else if (fmu->host.ends_early && step->status == FMU_DISCARD && fmu->now->clock.time > step->start) {
        ending->early = ending->diverged = true; /* up to where it was finite */
        step->status = FMU_WARNING;
    } else {
        fmu_set_state(fmu, step->function, step->begun);
        fmu->now->last_status = (int)step->status;
        ending->diverged = step->status == FMU_DISCARD;
    }
    ending->time = step->status <= FMU_WARNING ? fmu->now->clock.time : step->start;
    return step->status;
}

/* Could the host's part make this step another one? It is asked at ticks behind the step's beginning only, and a
 * step with one tick cannot end sooner than it does. */
static bool has_pieces(struct pieces *step)
{
    const struct fmu *fmu = step->fmu;
    const struct fmu_clock *clock = &fmu->now->clock;
    const double sample_time = fmu_sample_time(fmu);
    struct fmu_clock end;

    if (fmu->now->phase != FMU_STEP_COMPLETE || !(fmu->host.update || fmu->host.ends_early) ||
        !fmu_clock_step(clock, sample_time, step->start, step->end - step->start, &end) ||
        !fmu_clock_step(clock, sample_time, step->start, 0.0, &step->begin))
        return false;
    const int64_t ticks = end.next_tick - step->begin.next_tick;
    return ticks > 1 || (ticks == 1 && fmu->host.update && time_of(step, step->begin.next_tick) > step->start);
}

enum fmu_status fmu_do_updated_step(struct fmu *fmu, const char *function, double time, double step,
                                    struct fmu_ending *ending)
{
    struct pieces pieces = { .fmu = fmu, .function = function, .start = time, .end = time + step };

    *ending = (struct fmu_ending){ .time = time };
    if (!fmu || !has_pieces(&pieces)) {
        const enum fmu_status status = fmu_do_step(fmu, function, time, step);
        if (status <= FMU_WARNING)
            ending->time = fmu->now->clock.time;
        ending->diverged = status == FMU_DISCARD;
        return status;
    }
    void *begun = NULL;
    if (fmu_get_state(fmu, function, &begun) != FMU_OK)
        return FMU_ERROR;
    fmu_leave_plain(fmu);
    fmu->now->clock = pieces.begin; /* and its time is the host's */
    pieces.begun = begun;
    const enum fmu_status status = step_in_pieces(&pieces, ending);
    free(begun);
    return status;
}
