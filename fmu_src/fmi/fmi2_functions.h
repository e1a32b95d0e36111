/* The functions of FMI 2.0 for the model FMU_MODEL with the set FMU_SET compiled in (initialisers of a struct
 * fmu_set), under the prefix that FMI2_FUNCTION_PREFIX sets. They translate to the layer (fmu.h), and do
 * nothing else. Included once, by the file that makes an FMU of a model. */
#include "fmi2_prefix.h"
#include "fmu.h"
#include "fmu_plain.h"

static const struct fmu_set COMPILED_IN = FMU_SET;

/* The logger takes a printf format: a percent sign of the message must not act as one. */
static void fmi2_escape_percent(const char *text, char *escaped, size_t size)
{
    size_t n = 0;

    for (; *text && n + 2 < size; text++) {
        if (*text == '%')
            escaped[n++] = '%';
        escaped[n++] = *text;
    }
    escaped[n] = '\0';
}

static void fmi2_log(const struct fmu_host *host, const char *instance, enum fmu_status status,
                     const char *category, const char *text)
{
    char escaped[2048];

    fmi2_escape_percent(text, escaped, sizeof escaped);
    ((fmi2CallbackLogger)host->logger)(host->environment, instance, (fmi2Status)status, category, escaped);
}

static struct fmu_host fmi2_host(const fmi2CallbackFunctions *functions)
{
    if (!functions || !functions->logger)
        return (struct fmu_host){ .log = NULL };
    return (struct fmu_host){ .log = fmi2_log,
                              .logger = (void (*)(void))functions->logger,
                              .environment = functions->componentEnvironment };
}

/* Can a status of this kind be had now, and is there room for it? Otherwise sets `*refusal`. */
static bool fmi2_can_answer(const struct fmu *fmu, const char *function, fmi2StatusKind kind, bool known,
                            const void *value, fmi2Status *refusal)
{
    *refusal = fmi2Error;
    if (!fmu_may(fmu, function, FMU_STEP_COMPLETE | FMU_TERMINATED))
        return false;
    if (!value)
        fmu_say(fmu, FMU_ERROR, "%s: value is a null pointer.", function);
    else if (!known)
        *refusal =
            (fmi2Status)fmu_say(fmu, FMU_DISCARD, "%s: there is no status of kind %d.", function, (int)kind);
    return value && known;
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return "2.0";
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    return (fmi2Status)fmu_set_debug_logging(c, "fmi2SetDebugLogging", on, n, categories);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    const struct fmu_host host = fmi2_host(functions);

    (void)visible; /* there is nothing to show */
    if (type != fmi2CoSimulation) {
        fmu_say_early(&host, name ? name : "", "fmi2Instantiate: this FMU is for co-simulation only.");
        return NULL;
    }
    return fmu_instantiate(&FMU_MODEL, &COMPILED_IN, "fmi2Instantiate", name, guid, resources, &host, logging);
}

void fmi2FreeInstance(fmi2Component c)
{
    fmu_free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start_time, fmi2Boolean stop_time_defined, fmi2Real stop_time)
{
    return (fmi2Status)fmu_setup(c, "fmi2SetupExperiment", tolerance_defined, tolerance, start_time,
                                 stop_time_defined, stop_time);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    return (fmi2Status)fmu_enter_initialization(c, "fmi2EnterInitializationMode");
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    return (fmi2Status)fmu_exit_initialization(c, "fmi2ExitInitializationMode");
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    return (fmi2Status)fmu_terminate(c, "fmi2Terminate");
}

fmi2Status fmi2Reset(fmi2Component c)
{
    return (fmi2Status)fmu_reset(c, "fmi2Reset");
}

EVERY_STEP fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    return (fmi2Status)fmu_get_real(c, "fmi2GetReal", vr, n, value);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[])
{
    return (fmi2Status)fmu_get(c, "fmi2GetInteger", FMU_INTEGER, vr, n, value);
}

EVERY_STEP fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                     fmi2Boolean value[])
{
    return (fmi2Status)fmu_get_boolean(c, "fmi2GetBoolean", vr, n, value);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[])
{
    return (fmi2Status)fmu_get(c, "fmi2GetString", FMU_STRING, vr, n, value);
}

EVERY_STEP fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                  const fmi2Real value[])
{
    return (fmi2Status)fmu_set_real(c, "fmi2SetReal", vr, n, value);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[])
{
    return (fmi2Status)fmu_set(c, "fmi2SetInteger", FMU_INTEGER, vr, n, value);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[])
{
    return (fmi2Status)fmu_set(c, "fmi2SetBoolean", FMU_BOOLEAN, vr, n, value);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[])
{
    return (fmi2Status)fmu_set(c, "fmi2SetString", FMU_STRING, vr, n, value);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    return (fmi2Status)fmu_get_state(c, "fmi2GetFMUstate", state);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    return (fmi2Status)fmu_set_state(c, "fmi2SetFMUstate", state);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    return (fmi2Status)fmu_free_state(c, "fmi2FreeFMUstate", state);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    return (fmi2Status)fmu_state_size(c, "fmi2SerializedFMUstateSize", state, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    return (fmi2Status)fmu_serialize(c, "fmi2SerializeFMUstate", state, bytes, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    return (fmi2Status)fmu_deserialize(c, "fmi2DeSerializeFMUstate", bytes, size, state);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[],
                                        size_t unknown_count, const fmi2ValueReference knowns[],
                                        size_t known_count, const fmi2Real seeds[], fmi2Real values[])
{
    return (fmi2Status)fmu_directional_derivative(c, "fmi2GetDirectionalDerivative", unknowns, unknown_count,
                                                  knowns, known_count, seeds, values);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    return (fmi2Status)fmu_set_input_derivatives(c, "fmi2SetRealInputDerivatives", vr, n, order, value);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[])
{
    static const char function[] = "fmi2GetRealOutputDerivatives";

    (void)vr, (void)n, (void)order, (void)value;
    if (!fmu_may(c, function, FMU_STEP_COMPLETE | FMU_TERMINATED))
        return fmi2Error;
    return (fmi2Status)fmu_say(c, FMU_ERROR,
                               "%s: outputs are held between ticks and have no derivatives "
                               "(maxOutputDerivativeOrder is 0).",
                               function);
}

EVERY_STEP fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_rollback)
{
    (void)no_rollback; /* states are copies that the host owns: keeping them costs nothing */
    return (fmi2Status)fmu_do_step_here(c, "fmi2DoStep", time, step);
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    if (!fmu_may(c, "fmi2CancelStep", FMU_ANY_PHASE))
        return fmi2Error;
    return (fmi2Status)fmu_say(c, FMU_ERROR,
                               "fmi2CancelStep: no step is in progress; fmi2DoStep returns "
                               "when its step is complete.");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    const struct fmu *instance = c;
    fmi2Status refusal;

    if (!fmi2_can_answer(c, "fmi2GetStatus", kind, kind == fmi2DoStepStatus, value, &refusal))
        return refusal;
    *value = (fmi2Status)instance->now->last_status;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    const struct fmu *instance = c;
    fmi2Status refusal;

    if (!fmi2_can_answer(c, "fmi2GetRealStatus", kind, kind == fmi2LastSuccessfulTime, value, &refusal))
        return refusal;
    *value = instance->now->clock.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    fmi2Status status;

    fmi2_can_answer(c, "fmi2GetIntegerStatus", kind, false, value, &status);
    return status;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    const struct fmu *instance = c;
    fmi2Status refusal;

    if (!fmi2_can_answer(c, "fmi2GetBooleanStatus", kind, kind == fmi2Terminated, value, &refusal))
        return refusal;
    *value = instance->now->last_status == FMU_DISCARD; /* nor would a second try succeed */
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    fmi2Status refusal;

    if (!fmi2_can_answer(c, "fmi2GetStringStatus", kind, kind == fmi2PendingStatus, value, &refusal))
        return refusal;
    *value = "";
    return fmi2OK;
}
