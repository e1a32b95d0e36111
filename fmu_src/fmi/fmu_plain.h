/* Plain steps (struct fmu_plain), as most are: what any step does, in short, and in the very function that a host
 * calls. Everything else is in fmu_step.c. */
#ifndef IT2HYS_FMU_PLAIN_H
#define IT2HYS_FMU_PLAIN_H

#include "fmu.h"

HIDDEN_BEGIN

void fmu_copy_state(void *to, const void *from, size_t used);

/* Ends a step of one tick that has findings, which may have been logged before. */
enum fmu_status fmu_finish_with_findings(struct fmu *fmu, const char *function, double time, double step,
                                         unsigned findings);

/* A step that is not plain, or not known to be. */
enum fmu_status fmu_other_step(struct fmu *fmu, const char *function, double time, double step);

/* What directional derivatives repeat of every step: the state that it began with, */
static inline void fmu_note_state(struct fmu *fmu)
{
    void *last_state = fmu->last_state;

    fmu->last_state = fmu->before;
    fmu->before = last_state;
}

/* and its inputs. */
static inline void fmu_note_input(struct fmu_snapshot *now)
{
    const volatile double *input = now->input; /* one by one: as fmu_copy_state */

    for (int i = 0; i < FMU_INPUTS; i++)
        now->last_step.input[i] = input[i];
}

static inline enum fmu_status fmu_finish_tick(struct fmu_snapshot *now, enum fmu_status status, double end)
{
    fmu_note_input(now);
    fmu_clock_tick(&now->clock, end);
    return status;
}

/* From one tick to the next under constant inputs, */
static inline enum fmu_status fmu_one_tick(struct fmu *fmu, const char *function, double tick_time, double time,
                                           double step)
{
    struct fmu_snapshot *now = fmu->now;

    fmu_copy_state(fmu->before, fmu->state, fmu->used);
    const unsigned findings =
        fmu->tick(fmu->constants, fmu->state, fmu->parameters, now->input, tick_time, &now->output);
    if (!USUALLY(findings == 0))
        return fmu_finish_with_findings(fmu, function, time, step, findings);
    fmu_note_state(fmu);
    return fmu_finish_tick(now, FMU_OK, time + step);
}

/* and where the state is a single number, as most often: kept in a register, it saves a twentieth of what the layer
 * takes (measured). */
static inline enum fmu_status fmu_one_tick_of_one(struct fmu *fmu, const char *function, double tick_time,
                                                  double time, double step)
{
    struct fmu_snapshot *now = fmu->now;
    const double number = *(const double *)fmu->state, end = time + step;
    const unsigned findings =
        fmu->tick(fmu->constants, fmu->state, fmu->parameters, now->input, tick_time, &now->output);

    if (!USUALLY(findings == 0)) {
        *(double *)fmu->before = number;
        return fmu_finish_with_findings(fmu, function, time, step, findings);
    }
    *(double *)fmu->last_state = number;
    return fmu_finish_tick(now, FMU_OK, end);
}

/* Of what fmu_clock_is_tick asks that is left which a plain step can change. */
static inline bool fmu_is_plain(const struct fmu_plain *plain, double tick_time, double time, double step)
{
    return fabs(time - tick_time) <= plain->off && time + step <= plain->end;
}

/* fmu_do_step, where it is called. */
static inline enum fmu_status fmu_do_step_here(struct fmu *fmu, const char *function, double time, double step)
{
    if (USUALLY(fmu && step == fmu->plain.step)) {
        const double tick_time = (double)fmu->now->clock.tick * step;
        if (USUALLY(fmu_is_plain(&fmu->plain, tick_time, time, step)))
            return USUALLY(fmu->used == sizeof(double))
                       ? fmu_one_tick_of_one(fmu, function, tick_time, time, step)
                       : fmu_one_tick(fmu, function, tick_time, time, step);
    }
    return fmu_other_step(fmu, function, time, step);
}

HIDDEN_END

#endif
