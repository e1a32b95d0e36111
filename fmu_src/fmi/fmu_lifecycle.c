#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmu.h"

/* loggingOn is for debugging. What comes with a status is logged also without it: the standard says of
 * fmi2Warning that the logger was called, and a host that never asked still wants the reason of an error. */
enum { QUIET_CATEGORIES = FMU_LOG_WARNING | FMU_LOG_DISCARD | FMU_LOG_ERROR };

static void begin(struct fmu *fmu)
{
    const struct fmu_model *model = fmu->model;

    fmu_gather(fmu);
    memset(fmu->now, 0, fmu_snapshot_size(model));
    memset(fmu->before, 0, model->state_size);
    fmu->now->phase = FMU_INSTANTIATED;
    fmu->now->clock.stop_time = INFINITY;
    memcpy(fmu->parameters, fmu->start, model->parameters_size);
    memcpy(fmu->now->input, model->input_start, sizeof model->input_start);
    fmu_note_ramps(fmu);
    fmu->outputs_stale = true;
}

static size_t whole_words(size_t size)
{
    return (size + 7) / 8 * 8;
}

/* The next `size` bytes of an instance's memory. */
static void *take(char **memory, size_t size)
{
    void *taken = *memory;

    *memory += whole_words(size);
    return taken;
}

static size_t port_of(const struct fmu_variable *v)
{
    if (!v || v->causality == FMU_PARAMETER)
        return FMU_NO_PORT;
    if (v->causality == FMU_INPUT)
        return v->offset / sizeof(double);
    if (v->base == FMU_REAL)
        return FMU_REAL_PORT + (v->offset - offsetof(struct fmu_outputs, real)) / sizeof(double);
    return FMU_FLAG_PORT + (v->offset - offsetof(struct fmu_outputs, flag)) / sizeof(int);
}

struct fmu *fmu_create(const struct fmu_model *model, const char *name, const void *parameters,
                       const struct fmu_host *host, bool logging)
{
    const size_t block = fmu_snapshot_size(model);
    const size_t name_size = strlen(name) + 1;
    const size_t rest = whole_words(model->constants_size) + 2 * model->parameters_size + 2 * model->state_size;
    struct fmu *fmu = calloc(1, sizeof *fmu + block + rest + name_size);

    if (!fmu)
        return NULL;
    char *memory = (char *)(fmu->now + 1);
    fmu->model = model;
    fmu->parameters = take(&memory, model->parameters_size);
    fmu->state = take(&memory, model->state_size);
    fmu->last_state = take(&memory, model->state_size);
    fmu->constants = take(&memory, model->constants_size);
    fmu->before = take(&memory, model->state_size);
    fmu->d_state = take(&memory, model->state_size);
    fmu->d_parameters = take(&memory, model->parameters_size);
    fmu->start = take(&memory, model->parameters_size);
    memcpy(fmu->start, parameters, model->parameters_size);
    fmu->name = memcpy(memory, name, name_size);
    fmu->used = model->state_size;
    for (unsigned i = 0; i < FMU_PORTS; i++)
        fmu->port[i] = (unsigned char)port_of(fmu_find(model, i));
    fmu->host = *host;
    fmu->categories = logging ? FMU_LOG_ALL : QUIET_CATEGORIES;
    begin(fmu);
    return fmu;
}

/* {01234567-89ab-cdef-0123-456789abcdef} as two numbers. */
static bool read_token(const char *token, uint64_t half[2])
{
    int digits = 0;

    half[0] = half[1] = 0;
    for (; *token; token++) {
        if (isxdigit((unsigned char)*token) && digits < 32) {
            const int c = tolower((unsigned char)*token);
            half[digits / 16] = half[digits / 16] << 4 | (uint64_t)(c <= '9' ? c - '0' : c - 'a' + 10);
            digits++;
        } else if (*token != '{' && *token != '}' && *token != '-')
            return false;
    }
    return digits == 32;
}

static bool find_set(const struct fmu_model *model, const struct fmu_set *compiled_in, const char *token,
                     const char *resources, void *parameters, char *message, size_t size)
{
    uint64_t half[2];

    if (!read_token(token, half) || half[0] != model->table_hash ||
        (half[1] != compiled_in->hash && !compiled_in->find)) {
        snprintf(message, size,
                 "the GUID '%.64s' is not that of a modelDescription.xml for this binary "
                 "of %s.",
                 token, model->identifier);
        return false;
    }
    if (half[1] != compiled_in->hash)
        return compiled_in->find(model, half[1], resources, parameters, message, size);
    memcpy(parameters, compiled_in->parameters, model->parameters_size);
    return true;
}

struct fmu *fmu_instantiate(const struct fmu_model *model, const struct fmu_set *compiled_in,
                            const char *function, const char *name, const char *token, const char *resources,
                            const struct fmu_host *host, bool logging)
{
    char message[1024], text[1100];
    struct fmu *fmu = NULL;

    if (!name || !*name || !token) {
        snprintf(text, sizeof text, "%s: an instance needs a name and a GUID.", function);
        fmu_say_early(host, "", text);
        return NULL;
    }
    void *parameters = malloc(model->parameters_size);
    if (!parameters)
        return NULL;
    if (find_set(model, compiled_in, token, resources, parameters, message, sizeof message))
        fmu = fmu_create(model, name, parameters, host, logging);
    else {
        snprintf(text, sizeof text, "%s: %s", function, message);
        fmu_say_early(host, name, text);
    }
    free(parameters);
    if (fmu)
        fmu_say(fmu, FMU_OK, "instantiated %s.", model->identifier);
    return fmu;
}

void fmu_free(struct fmu *fmu)
{
    free(fmu);
}

enum fmu_status fmu_setup(struct fmu *fmu, const char *function, bool tolerance_defined, double tolerance,
                          double start_time, bool stop_time_defined, double stop_time)
{
    struct fmu_clock clock = { 0 };
    char message[128];

    if (!fmu_may(fmu, function, FMU_INSTANTIATED))
        return FMU_ERROR;
    if (!fmu_clock_setup(&clock, start_time, stop_time_defined, stop_time, message, sizeof message))
        return fmu_say(fmu, FMU_ERROR, "%s: %s.", function, message);
    /* a discrete model has no error to control: a tolerance has nothing to act on */
    if (tolerance_defined && !(isfinite(tolerance) && tolerance >= 0.0))
        return fmu_say(fmu, FMU_ERROR, "%s: tolerance, %g, must not be negative.", function, tolerance);
    fmu->now->clock = clock;
    return FMU_OK;
}

enum fmu_status fmu_enter_initialization(struct fmu *fmu, const char *function)
{
    if (!fmu_may(fmu, function, FMU_INSTANTIATED))
        return FMU_ERROR;
    fmu->now->phase = FMU_INITIALIZATION;
    fmu->outputs_stale = true;
    return FMU_OK;
}

enum fmu_status fmu_compute_start_outputs(struct fmu *fmu, const char *function)
{
    const struct fmu_model *model = fmu->model;
    struct fmu_outputs output = fmu->now->output;
    char message[512];

    if (!model->check(model, fmu->parameters, message, sizeof message))
        return fmu_say(fmu, FMU_ERROR, "%s: %s.", function, message);
    fmu->used = model->prepare(fmu->constants, fmu->parameters);
    if (!model->start(fmu->constants, fmu->before, fmu->parameters, &output, message, sizeof message))
        return fmu_say(fmu, FMU_ERROR, "%s: %s.", function, message);
    memcpy(fmu->state, fmu->before, model->state_size);
    memcpy(fmu->before, fmu->last_state, model->state_size);
    fmu->now->output = output;
    fmu->outputs_stale = false;
    return FMU_OK;
}

enum fmu_status fmu_exit_initialization(struct fmu *fmu, const char *function)
{
    if (!fmu_may(fmu, function, FMU_INITIALIZATION) || fmu_start_outputs(fmu, function) != FMU_OK)
        return FMU_ERROR;
    fmu_settle(fmu);
    fmu_clock_start(&fmu->now->clock, fmu_sample_time(fmu));
    fmu->now->phase = FMU_STEP_COMPLETE;
    return FMU_OK;
}

enum fmu_status fmu_terminate(struct fmu *fmu, const char *function)
{
    if (!fmu_may(fmu, function, FMU_STEP_COMPLETE))
        return FMU_ERROR;
    fmu_leave_plain(fmu);
    fmu->now->phase = FMU_TERMINATED;
    return FMU_OK;
}

enum fmu_status fmu_reset(struct fmu *fmu, const char *function)
{
    if (!fmu_may(fmu, function, FMU_ANY_PHASE))
        return FMU_ERROR;
    begin(fmu);
    return FMU_OK;
}
