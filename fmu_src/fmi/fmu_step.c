/* doStep. Which ticks a step has is the clock's (fmu_clock.h); each runs with the input at its own time, and
 * outputs hold their value from tick to tick. */
#include <math.h>
#include <string.h>

#include "fmu_plain.h"

enum { FEW = 16 };

/* Of functions: what hardly ever happens is out of the way of what happens at every step, and what is rarest need not
 * even be fast. */
#if defined __GNUC__
#define RARE __attribute__((noinline))
#define RAREST __attribute__((noinline, cold))
#else
#define RARE
#define RAREST
#endif

void fmu_inputs_at(const struct fmu_span *span, int64_t tick, double sample_time, double input[FMU_INPUTS])
{
    const double elapsed = ((double)(tick - span->tick) - span->rest) * sample_time;

    for (int i = 0; i < FMU_INPUTS; i++)
        input[i] = span->input[i] + span->slope[i] * elapsed;
}

/* Copies what is in use of a state. A few numbers go one by one: a processor that reads two at a time what was just
 * written one by one waits until it is in memory. */
RARE void fmu_copy_state(void *to, const void *from, size_t used)
{
    if (used > FEW * sizeof(double)) {
        memcpy(to, from, used);
        return;
    }
    for (size_t i = 0; i < used; i += sizeof(double))
        memcpy((char *)to + i, (const char *)from + i, sizeof(double));
}

/* Logs what a tick is the first to find: each finding once in an instance's life, so that a log is not
 * flooded. */
static enum fmu_status warn(struct fmu *fmu, const char *function, unsigned findings, const double input[],
                            double time)
{
    char text[512];

    for (unsigned finding = 1; finding && finding <= findings; finding <<= 1) {
        if (!(findings & finding))
            continue;
        fmu->model->explain(finding, fmu->state, fmu->parameters, input, time, &fmu->now->output, text,
                            sizeof text);
        fmu_say(fmu, FMU_WARNING, "%s: %s This is logged once.", function, text);
    }
    fmu->now->warned |= findings;
    return FMU_WARNING;
}

/* Makes a status of a tick's findings. */
static void report(struct fmu *fmu, const char *function, unsigned findings, const double input[], double time,
                   enum fmu_status *status)
{
    const unsigned warned = (unsigned)fmu->now->warned;

    if (!(findings & ~warned))
        return;
    if (findings & FMU_NOT_FINITE)
        *status = FMU_DISCARD;
    else if (*status != FMU_DISCARD)
        *status = warn(fmu, function, findings & ~warned, input, time);
}

static inline void run_tick(struct fmu *fmu, const char *function, const double input[], double time,
                            enum fmu_status *status)
{
    const unsigned findings =
        fmu->model->tick(fmu->constants, fmu->state, fmu->parameters, input, time, &fmu->now->output);

    if (findings)
        report(fmu, function, findings, input, time, status);
}

static inline int64_t run_ticks(struct fmu *fmu, int64_t count)
{
    struct fmu_snapshot *now = fmu->now;

    return fmu->short_way ? fmu->model->ticks(fmu->constants, fmu->state, now->input, count, &now->output) : 0;
}

/* Runs the ticks up to `end_tick` in place. What a step of one tick costs is the way from the state of the
 * last tick to the next, and each copy between would lengthen it. */
static enum fmu_status run(struct fmu *fmu, const char *function, int64_t end_tick)
{
    struct fmu_snapshot *now = fmu->now;
    const int64_t first_tick = now->clock.next_tick;
    const double sample_time = fmu_sample_time(fmu);
    enum fmu_status status = FMU_OK;
    double input[FMU_INPUTS];

    if (!fmu->ramps) {
        for (int64_t tick = first_tick; tick < end_tick && status != FMU_DISCARD; tick++) {
            tick += run_ticks(fmu, end_tick - 1 - tick);
            run_tick(fmu, function, now->input, (double)tick * sample_time, &status);
        }
        return status;
    }
    struct fmu_span span = { .tick = now->clock.tick, .rest = now->clock.rest };
    memcpy(span.input, now->input, sizeof span.input);
    memcpy(span.slope, now->slope, sizeof span.slope);
    for (int64_t tick = first_tick; tick < end_tick && status != FMU_DISCARD; tick++) {
        fmu_inputs_at(&span, tick, sample_time, input);
        run_tick(fmu, function, input, (double)tick * sample_time, &status);
    }
    return status;
}

/* A step that is not made: everything stays as it was. */
static RARE enum fmu_status give_up(struct fmu *fmu, const char *function, double time, double step)
{
    fmu_copy_state(fmu->state, fmu->before, fmu->used);
    return fmu_say(
        fmu, FMU_DISCARD,
        "%s: the %s is no longer finite between %g s and %g s; the step is not made and the state is "
        "that of %g s.",
        function, fmu->model->diverging, time, time + step, time);
}

/* What directional derivatives repeat of a step that is not from a tick to the next under constant inputs. */
static void note_span(struct fmu_snapshot *now, int64_t end_tick)
{
    now->one_tick = false;
    now->last_step.tick = now->clock.tick;
    now->last_step.rest = now->clock.rest;
    now->last_step.first_tick = now->clock.next_tick;
    now->last_step.end_tick = end_tick;
    memcpy(now->last_step.slope, now->slope, sizeof now->slope);
}

struct fmu_span fmu_last_step(const struct fmu_snapshot *now)
{
    struct fmu_span last = now->last_step;

    if (now->one_tick) {
        last.tick = last.first_tick = now->clock.tick - 1;
        last.end_tick = now->clock.tick;
        last.rest = 0.0;
        memset(last.slope, 0, sizeof last.slope);
    }
    return last;
}

RARE enum fmu_status fmu_finish_with_findings(struct fmu *fmu, const char *function, double time, double step,
                                              unsigned findings)
{
    struct fmu_snapshot *now = fmu->now;
    enum fmu_status status = FMU_OK;

    report(fmu, function, findings, now->input, (double)now->clock.tick * fmu_sample_time(fmu), &status);
    if (status != FMU_OK)
        fmu_leave_plain(fmu);
    now->last_status = (int)status;
    if (status == FMU_DISCARD)
        return give_up(fmu, function, time, step);
    fmu_note_state(fmu);
    return fmu_finish_tick(now, status, time + step);
}

static RARE enum fmu_status any_step(struct fmu *fmu, const char *function, double time, double step)
{
    struct fmu_snapshot *now = fmu->now;
    const double sample_time = fmu_sample_time(fmu);
    const struct fmu_outputs held = now->output;
    const uint64_t warned = now->warned;
    struct fmu_clock end;
    char message[256];

    if (!fmu_clock_step(&now->clock, sample_time, time, step, &end))
        return fmu_say(fmu, FMU_ERROR, "%s: %s.", function,
                       fmu_clock_refusal(&now->clock, sample_time, time, step, message, sizeof message));
    fmu_copy_state(fmu->before, fmu->state, fmu->used);
    const enum fmu_status status = run(fmu, function, end.next_tick);
    now->last_status = (int)status;
    if (status == FMU_DISCARD) {
        now->output = held;
        now->warned = warned;
        return give_up(fmu, function, time, step);
    }
    fmu_note_state(fmu);
    fmu_note_input(now);
    note_span(now, end.next_tick);
    now->clock = end;
    return status;
}

/* Plain steps follow; their clock is far from where its ticks are no longer counted. */
static void expect_plain(struct fmu *fmu)
{
    const double sample_time = fmu_sample_time(fmu), stop_time = fmu->now->clock.stop_time;
    const double countable = 0.5 * CLOCK_LARGEST_TICK * sample_time;

    fmu->plain = (struct fmu_plain){ sample_time, CLOCK_TOLERANCE * sample_time,
                                     stop_time < countable ? stop_time : countable };
}

RAREST enum fmu_status fmu_other_step(struct fmu *fmu, const char *function, double time, double step)
{
    if (!fmu_may(fmu, function, FMU_STEP_COMPLETE))
        return FMU_ERROR;
    struct fmu_snapshot *now = fmu->now;
    const double sample_time = fmu_sample_time(fmu);
    fmu_leave_plain(fmu);
    if (fmu->ramps || !fmu_clock_is_tick(&now->clock, sample_time, time, step))
        return any_step(fmu, function, time, step);
    const enum fmu_status status =
        fmu_one_tick(fmu, function, (double)now->clock.tick * sample_time, time, step);
    if (status == FMU_DISCARD)
        return status;
    now->last_status = (int)status;
    now->one_tick = true;
    if (status == FMU_OK)
        expect_plain(fmu);
    return status;
}

EVERY_STEP enum fmu_status fmu_do_step(struct fmu *fmu, const char *function, double time, double step)
{
    return fmu_do_step_here(fmu, function, time, step);
}
