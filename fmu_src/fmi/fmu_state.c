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

static const char MAGIC[8] = "it2hys4";
static const uint64_t ORDER = 0x0102030405060708u;

uint64_t fmu_hash(const void *bytes, size_t size)
{
    const unsigned char *byte = bytes;
    uint64_t hash = 14695981039346656037u;

    for (size_t i = 0; i < size; i++)
        hash = (hash ^ byte[i]) * 1099511628211u;
    return hash;
}

/* The parts of a block that hold a snapshot and what is behind it. */
static const struct fmu_snapshot *snapshot_in(const void *block)
{
    return block;
}

static const void *parameters_in(const void *block)
{
    return snapshot_in(block) + 1;
}

static struct header header_of(const struct fmu_model *model, const void *block)
{
    const size_t size = fmu_snapshot_size(model);
    struct header header = {
        .order = ORDER, .table_hash = model->table_hash, .size = size, .checksum = fmu_hash(block, size)
    };

    memcpy(header.magic, MAGIC, sizeof MAGIC);
    return header;
}

static size_t serialized_size(const struct fmu *fmu)
{
    return sizeof(struct header) + fmu_snapshot_size(fmu->model);
}

enum fmu_status fmu_get_state(struct fmu *fmu, const char *function, void **state)
{
    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (!state)
        return fmu_say(fmu, FMU_ERROR, "%s: FMUstate is a null pointer.", function);
    const size_t size = fmu_snapshot_size(fmu->model);
    if (!*state)
        *state = malloc(size);
    if (!*state)
        return fmu_say(fmu, FMU_ERROR, "%s: out of memory.", function);
    fmu_gather(fmu);
    memcpy(*state, fmu->now, size);
    return FMU_OK;
}

static void adopt(struct fmu *fmu, const void *block)
{
    const struct fmu_model *model = fmu->model;
    /* a master that goes back to try again does so with the same parameters: they are prepared */
    const bool prepared =
        !fmu->outputs_stale && memcmp(fmu->parameters, parameters_in(block), model->parameters_size) == 0;

    fmu_gather(fmu);
    memcpy(fmu->now, block, fmu_snapshot_size(model));
    memcpy(fmu->before, fmu->last_state, model->state_size);
    fmu_note_ramps(fmu);
    /* before initialization is over the parameters are not checked yet: outputs are computed on demand */
    fmu->outputs_stale = !(fmu->now->phase & FMU_INITIALIZED);
    if (fmu->outputs_stale)
        return;
    if (!prepared)
        fmu->used = model->prepare(fmu->constants, fmu->parameters);
    fmu_settle(fmu); /* what was prepared last may have been in initialization */
}

enum fmu_status fmu_set_state(struct fmu *fmu, const char *function, const void *state)
{
    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (!state)
        return fmu_say(fmu, FMU_ERROR, "%s: FMUstate is a null pointer.", function);
    adopt(fmu, state);
    return FMU_OK;
}

enum fmu_status fmu_free_state(struct fmu *fmu, const char *function, void **state)
{
    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return FMU_OK;
}

enum fmu_status fmu_state_size(struct fmu *fmu, const char *function, const void *state, size_t *size)
{
    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (!state || !size)
        return fmu_say(fmu, FMU_ERROR, "%s: a null pointer.", function);
    *size = serialized_size(fmu);
    return FMU_OK;
}

enum fmu_status fmu_serialize(struct fmu *fmu, const char *function, const void *state, char bytes[],
                              size_t size)
{
    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (!state || !bytes)
        return fmu_say(fmu, FMU_ERROR, "%s: a null pointer.", function);
    if (size < serialized_size(fmu))
        return fmu_say(fmu, FMU_ERROR, "%s: %zu bytes are too few; %zu are needed.", function, size,
                       serialized_size(fmu));
    const struct header header = header_of(fmu->model, state);
    memcpy(bytes, &header, sizeof header);
    memcpy(bytes + sizeof header, state, fmu_snapshot_size(fmu->model));
    return FMU_OK;
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
static bool ticks_plausible(const struct fmu_snapshot *s, double sample_time)
{
    if (!fmu_clock_plausible(&s->clock, sample_time) || s->one_tick > 1)
        return false;
    const struct fmu_span last = fmu_last_step(s);
    const double ticks = (double)last.end_tick - (double)last.first_tick;
    return ticks >= 0.0 && ticks <= 2.0 * CLOCK_LONGEST_STEP && fabs((double)last.tick) <= CLOCK_LARGEST_TICK &&
           last.rest >= 0.0 && last.rest < 1.0 && (ticks == 0.0 || last.end_tick == s->clock.next_tick);
}

/* What is neither a parameter, an output, nor the clock's. */
static bool all_finite(const struct fmu_model *model, const void *block)
{
    const struct fmu_snapshot *s = block;
    const struct fmu_span *last = &s->last_step;

    return doubles_finite(s->input, sizeof s->input) && doubles_finite(s->slope, sizeof s->slope) &&
           isfinite(last->rest) && doubles_finite(last->input, sizeof last->input) &&
           doubles_finite(last->slope, sizeof last->slope) &&
           doubles_finite(fmu_state_in(model, block), 2 * model->state_size);
}

/* A checksum stops damage, not invention: what a step relies on and what is handed out is checked too.
 * Returns what cannot be, or NULL; `message` is room for it. */
static const char *invented(const struct fmu *fmu, const void *block, char *message, size_t size)
{
    const struct fmu_snapshot *s = block;
    const void *parameters = parameters_in(block);
    const bool one_phase = s->phase == FMU_INSTANTIATED || s->phase == FMU_INITIALIZATION ||
                           s->phase == FMU_STEP_COMPLETE || s->phase == FMU_TERMINATED ||
                           (s->phase == FMU_CONFIGURATION && fmu->host.resizes);

    if (!one_phase || s->last_status < 0 || s->last_status > FMU_DISCARD || s->warned >= FMU_NOT_FINITE)
        return "no such phase, status or finding";
    if (!all_finite(fmu->model, block))
        return "a number is not finite";
    if (!fmu_values_possible(fmu, s, parameters, message, size))
        return message;
    if (!(s->phase & FMU_INITIALIZED))
        return isfinite(s->clock.time) && s->clock.stop_time > -INFINITY ? NULL : "no such time";
    if (!fmu->model->check(fmu->model, parameters, message, size))
        return message;
    return ticks_plausible(s, *(const double *)parameters) ? NULL : "the ticks are not those of the time";
}

enum fmu_status fmu_deserialize(struct fmu *fmu, const char *function, const char bytes[], size_t size,
                                void **state)
{
    char message[512];

    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    if (!bytes || !state)
        return fmu_say(fmu, FMU_ERROR, "%s: a null pointer.", function);
    const struct fmu_model *model = fmu->model;
    if (size != serialized_size(fmu))
        return fmu_say(fmu, FMU_ERROR, "%s: %zu bytes are no state of %s, which has %zu.", function, size,
                       model->identifier, serialized_size(fmu));
    void *block = malloc(fmu_snapshot_size(model));
    if (!block)
        return fmu_say(fmu, FMU_ERROR, "%s: out of memory.", function);
    memcpy(block, bytes + sizeof(struct header), fmu_snapshot_size(model));
    const struct header header = header_of(model, block);
    const char *reason = memcmp(&header, bytes, sizeof header) != 0
                             ? "header or checksum is wrong"
                             : invented(fmu, block, message, sizeof message);
    if (reason) {
        free(block);
        return fmu_say(fmu, FMU_ERROR,
                       "%s: these bytes are damaged or not a state of this version of "
                       "%s: %s.",
                       function, model->identifier, reason);
    }
    *state = block; /* never read before: masters pass it uninitialised */
    return FMU_OK;
}
