#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmu.h"

/* loggingOn is for debugging. What comes with a status is logged also without it: the standard says of
 * fmi2Warning that the logger was called, and a host that never asked still wants the reason of an error. */
enum { QUIET_CATEGORIES = FMU_LOG_WARNING | FMU_LOG_DISCARD | FMU_LOG_ERROR };

static void begin(struct fmu *fmu)
{
    memset(&fmu->now, 0, sizeof fmu->now);
    fmu->now.phase = FMU_INSTANTIATED;
    fmu->now.clock.stop_time = INFINITY;
    fmu->now.values.parameter = fmu->start;
    fmu_inputs_start(&fmu->now.values.input);
    fmu->outputs_stale = true;
}

static char *copy_name(const char *name)
{
    const size_t size = strlen(name) + 1;
    char *copy = malloc(size);

    return copy ? memcpy(copy, name, size) : NULL;
}

struct fmu *fmu_instantiate(const struct fmu_model *model, fmi2String name, fmi2Type type,
                            fmi2String guid, fmi2String resources,
                            const fmi2CallbackFunctions *functions, bool logging)
{
    char message[1024];
    struct fmu early = { .model = model, .categories = FMU_LOG_ALL, .name = (char *)"" };
    struct fmu *fmu;

    if (functions) {
        early.logger = functions->logger;
        early.environment = functions->componentEnvironment;
    }
    if (!name || !*name || !guid) {
        fmu_say(&early, fmi2Error, "fmi2Instantiate: an instance needs a name and a GUID.");
        return NULL;
    }
    early.name = (char *)name;
    if (type != fmi2CoSimulation) {
        fmu_say(&early, fmi2Error, "fmi2Instantiate: %s is for co-simulation only.", model->identifier);
        return NULL;
    }
    if (!fmu_load_parameters(model, guid, resources, &early.start, message, sizeof message)) {
        fmu_say(&early, fmi2Error, "fmi2Instantiate: %s", message);
        return NULL;
    }
    fmu = calloc(1, sizeof *fmu);
    early.name = copy_name(name);
    if (!fmu || !early.name) {
        free(fmu);
        free(early.name);
        return NULL;
    }
    early.categories = logging ? FMU_LOG_ALL : QUIET_CATEGORIES;
    *fmu = early;
    begin(fmu);
    fmu_say(fmu, fmi2OK, "instantiated %s with %d rules.", model->identifier, fmu->start.ruleCount);
    return fmu;
}

void fmu_free(struct fmu *fmu)
{
    if (fmu)
        free(fmu->name);
    free(fmu);
}

fmi2Status fmu_setup(struct fmu *fmu, bool tolerance_defined, double tolerance, double start_time,
                     bool stop_time_defined, double stop_time)
{
    struct fmu_clock clock = { 0 };
    char message[128];

    if (!fmu_may(fmu, "fmi2SetupExperiment", FMU_INSTANTIATED))
        return fmi2Error;
    if (!fmu_clock_setup(&clock, start_time, stop_time_defined, stop_time, message, sizeof message))
        return fmu_say(fmu, fmi2Error, "fmi2SetupExperiment: %s.", message);
    /* a discrete model has no error to control: a tolerance has nothing to act on */
    if (tolerance_defined && !(isfinite(tolerance) && tolerance >= 0.0))
        return fmu_say(fmu, fmi2Error, "fmi2SetupExperiment: tolerance, %g, must not be negative.",
                       tolerance);
    fmu->now.clock = clock;
    return fmi2OK;
}

fmi2Status fmu_enter_initialization(struct fmu *fmu)
{
    if (!fmu_may(fmu, "fmi2EnterInitializationMode", FMU_INSTANTIATED))
        return fmi2Error;
    fmu->now.phase = FMU_INITIALIZATION;
    fmu->outputs_stale = true;
    return fmi2OK;
}

fmi2Status fmu_compute_start_outputs(struct fmu *fmu, const char *function)
{
    const struct chain_parameters *parameters = &fmu->now.values.parameter;
    struct fmu_outputs output = fmu->now.values.output;
    struct chain_state state = fmu->now.chain;
    char message[512];

    if (!fmu_within_bounds(parameters, message, sizeof message) ||
        !chain_check(parameters, message, sizeof message))
        return fmu_say(fmu, fmi2Error, "%s: %s.", function, message);
    chain_prepare(&fmu->chain, parameters);
    chain_reset(&fmu->chain, &state, parameters);
    fmu->model->start(&fmu->chain, &state, parameters, &output);
    if (!fmu_outputs_finite(&output)) /* a core that a voltage hardly moves may need an infinite one */
        return fmu_say(fmu, fmi2Error, "%s: at initialDisplacement, %g m, the output is no finite "
                       "number.", function, parameters->initialDisplacement);
    fmu->now.chain = state;
    fmu->now.values.output = output;
    fmu->outputs_stale = false;
    return fmi2OK;
}

fmi2Status fmu_exit_initialization(struct fmu *fmu)
{
    if (!fmu_may(fmu, "fmi2ExitInitializationMode", FMU_INITIALIZATION))
        return fmi2Error;
    if (fmu_start_outputs(fmu, "fmi2ExitInitializationMode") != fmi2OK)
        return fmi2Error;
    fmu_clock_start(&fmu->now.clock, fmu->now.values.parameter.sampleTime);
    fmu->now.phase = FMU_STEP_COMPLETE;
    return fmi2OK;
}

fmi2Status fmu_terminate(struct fmu *fmu)
{
    if (!fmu_may(fmu, "fmi2Terminate", FMU_STEP_COMPLETE))
        return fmi2Error;
    fmu->now.phase = FMU_TERMINATED;
    return fmi2OK;
}

fmi2Status fmu_reset(struct fmu *fmu)
{
    if (!fmu_may(fmu, "fmi2Reset", FMU_ANY_PHASE))
        return fmi2Error;
    begin(fmu);
    return fmi2OK;
}
