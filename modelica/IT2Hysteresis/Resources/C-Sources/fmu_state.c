/* The FMU state is a plain value: copying it is saving it. Serialized, it is preceded by a header
 * that says which binary layout and model it belongs to and guards against damage. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmu.h"

struct header {
    char magic[8];
    uint64_t order; /* tells byte orders apart */
    uint64_t table_hash;
    uint64_t size;
    uint64_t checksum;
};

static const char MAGIC[8] = "it2hys2";
static const uint64_t ORDER = 0x0102030405060708u;

uint64_t fmu_hash(const void *bytes, size_t size)
{
    const unsigned char *byte = bytes;
    uint64_t hash = 14695981039346656037u;

    for (size_t i = 0; i < size; i++)
        hash = (hash ^ byte[i]) * 1099511628211u;
    return hash;
}

static struct header header_of(const struct fmu *fmu, const struct fmu_snapshot *snapshot)
{
    struct header header = { .order = ORDER,
                             .table_hash = fmu->model->table_hash,
                             .size = sizeof *snapshot,
                             .checksum = fmu_hash(snapshot, sizeof *snapshot) };

    memcpy(header.magic, MAGIC, sizeof MAGIC);
    return header;
}

fmi2Status fmu_get_state(struct fmu *fmu, fmi2FMUstate *state)
{
    if (!fmu_may(fmu, "fmi2GetFMUstate", FMU_ANY_PHASE))
        return fmi2Error;
    if (!state)
        return fmu_say(fmu, fmi2Error, "fmi2GetFMUstate: FMUstate is a null pointer.");
    if (!*state)
        *state = malloc(sizeof fmu->now);
    if (!*state)
        return fmu_say(fmu, fmi2Error, "fmi2GetFMUstate: out of memory.");
    memcpy(*state, &fmu->now, sizeof fmu->now);
    return fmi2OK;
}

static void adopt(struct fmu *fmu, const struct fmu_snapshot *snapshot)
{
    /* a master that goes back to try again does so with the same parameters: they are prepared */
    const bool prepared = !fmu->outputs_stale && memcmp(&fmu->now.values.parameter, &snapshot->values.parameter,
                                                        sizeof snapshot->values.parameter) == 0;

    memcpy(&fmu->now, snapshot, sizeof fmu->now);
    /* before initialization is over the parameters are not checked yet: outputs are computed on demand */
    fmu->outputs_stale = fmu->now.phase < FMU_STEP_COMPLETE;
    if (!fmu->outputs_stale && !prepared)
        chain_prepare(&fmu->chain, &fmu->now.values.parameter);
}

fmi2Status fmu_set_state(struct fmu *fmu, fmi2FMUstate state)
{
    if (!fmu_may(fmu, "fmi2SetFMUstate", FMU_ANY_PHASE))
        return fmi2Error;
    if (!state)
        return fmu_say(fmu, fmi2Error, "fmi2SetFMUstate: FMUstate is a null pointer.");
    adopt(fmu, state);
    return fmi2OK;
}

fmi2Status fmu_free_state(struct fmu *fmu, fmi2FMUstate *state)
{
    if (!fmu_may(fmu, "fmi2FreeFMUstate", FMU_ANY_PHASE))
        return fmi2Error;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmu_state_size(struct fmu *fmu, fmi2FMUstate state, size_t *size)
{
    if (!fmu_may(fmu, "fmi2SerializedFMUstateSize", FMU_ANY_PHASE))
        return fmi2Error;
    if (!state || !size)
        return fmu_say(fmu, fmi2Error, "fmi2SerializedFMUstateSize: a null pointer.");
    *size = sizeof(struct header) + sizeof(struct fmu_snapshot);
    return fmi2OK;
}

fmi2Status fmu_serialize(struct fmu *fmu, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    if (!fmu_may(fmu, "fmi2SerializeFMUstate", FMU_ANY_PHASE))
        return fmi2Error;
    if (!state || !bytes)
        return fmu_say(fmu, fmi2Error, "fmi2SerializeFMUstate: a null pointer.");
    const struct header header = header_of(fmu, state);
    if (size < sizeof header + sizeof(struct fmu_snapshot))
        return fmu_say(fmu, fmi2Error, "fmi2SerializeFMUstate: %zu bytes are too few; %zu are needed.",
                       size, sizeof header + sizeof(struct fmu_snapshot));
    memcpy(bytes, &header, sizeof header);
    memcpy(bytes + sizeof header, state, sizeof(struct fmu_snapshot));
    return fmi2OK;
}

static bool doubles_finite(const void *first, size_t size)
{
    const double *value = first;

    for (size_t i = 0; i < size / sizeof *value; i++)
        if (!isfinite(value[i]))
            return false;
    return true;
}

/* A step or a derivative from invented ticks would not return. */
static bool ticks_plausible(const struct fmu_snapshot *s)
{
    const struct fmu_span *last = &s->last_step.span;
    const double ticks = (double)last->end_tick - (double)last->first_tick;

    return fmu_clock_plausible(&s->clock, s->values.parameter.sampleTime) && ticks >= 0.0 &&
           ticks <= 2.0 * CLOCK_LONGEST_STEP && fabs((double)last->tick) <= CLOCK_LARGEST_TICK &&
           last->rest >= 0.0 && last->rest < 1.0 &&
           (ticks == 0.0 || last->end_tick == s->clock.next_tick);
}

/* What is neither a variable nor the clock's. */
static bool all_finite(const struct fmu_snapshot *s)
{
    const struct fmu_span *last = &s->last_step.span;

    return isfinite(s->values.input.time) && doubles_finite(&s->slope, sizeof s->slope) &&
           doubles_finite(&s->chain, sizeof s->chain) && isfinite(last->rest) &&
           doubles_finite(&last->input, sizeof last->input) &&
           doubles_finite(&last->slope, sizeof last->slope) &&
           doubles_finite(&s->last_step.chain, sizeof s->last_step.chain);
}

/* A checksum stops damage, not invention: what a step relies on and what is handed out is checked too.
 * Returns what cannot be, or NULL; `message` is room for it. */
static const char *invented(const struct fmu *fmu, const struct fmu_snapshot *s, char *message, size_t size)
{
    const struct chain_parameters *p = &s->values.parameter;
    const bool one_phase = s->phase == FMU_INSTANTIATED || s->phase == FMU_INITIALIZATION ||
                           s->phase == FMU_STEP_COMPLETE || s->phase == FMU_TERMINATED;

    if (!one_phase || s->last_status < 0 || s->last_status > fmi2Discard)
        return "no such phase or status";
    if (!all_finite(s))
        return "a number is not finite";
    if (!fmu_values_possible(fmu, &s->values, message, size))
        return message;
    if (s->phase < FMU_STEP_COMPLETE)
        return isfinite(s->clock.time) && s->clock.stop_time > -INFINITY ? NULL : "no such time";
    if (!fmu_within_bounds(p, message, size) || !chain_check(p, message, size))
        return message;
    return ticks_plausible(s) ? NULL : "the ticks are not those of the time";
}

fmi2Status fmu_deserialize(struct fmu *fmu, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    static const char function[] = "fmi2DeSerializeFMUstate";
    struct fmu_snapshot *snapshot;
    struct header header;
    char message[512];

    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return fmi2Error;
    if (!bytes || !state)
        return fmu_say(fmu, fmi2Error, "%s: a null pointer.", function);
    if (size != sizeof header + sizeof *snapshot)
        return fmu_say(fmu, fmi2Error, "%s: %zu bytes are no state of %s, which has %zu.", function,
                       size, fmu->model->identifier, sizeof header + sizeof *snapshot);
    snapshot = malloc(sizeof *snapshot);
    if (!snapshot)
        return fmu_say(fmu, fmi2Error, "%s: out of memory.", function);
    memcpy(snapshot, bytes + sizeof header, sizeof *snapshot);
    header = header_of(fmu, snapshot);
    const char *reason = memcmp(&header, bytes, sizeof header) != 0
                             ? "header or checksum is wrong"
                             : invented(fmu, snapshot, message, sizeof message);
    if (reason) {
        free(snapshot);
        return fmu_say(fmu, fmi2Error, "%s: these bytes are damaged or not a state of this version of "
                       "%s: %s.", function, fmu->model->identifier, reason);
    }
    *state = snapshot; /* never read before: masters pass it uninitialised */
    return fmi2OK;
}
