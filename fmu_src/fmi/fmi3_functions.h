/* The functions of FMI 3.0 for the model FMU_MODEL with the set FMU_SET compiled in (initialisers of a struct
 * fmu_set), under the prefix that FMI3_FUNCTION_PREFIX sets. They translate to the layer (fmu.h), and do
 * nothing else. Included once, by the file that makes an FMU of a model. */
#include <limits.h>
#include <stdlib.h>

#include "fmi3Functions.h"
#include "fmu.h"

static const struct fmu_set COMPILED_IN = FMU_SET;

/* --- the host ------------------------------------------------------------------------------------ */

static void fmi3_log(const struct fmu_host *host, const char *instance, enum fmu_status status,
                     const char *category, const char *text)
{
    (void)instance; /* the environment tells instances apart */
    ((fmi3LogMessageCallback)host->logger)(host->environment, (fmi3Status)status, category, text);
}

/* Outputs are those of the last tick, and final. */
static bool fmi3_update(const struct fmu_host *host, double time, double *end)
{
    fmi3Boolean asked = fmi3False;

    ((fmi3IntermediateUpdateCallback)host->updater)(host->environment, time, fmi3True, fmi3True, fmi3True,
                                                    host->ends_early, &asked, end);
    return asked;
}

static struct fmu_host fmi3_host(fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    return (struct fmu_host){ .log = log ? fmi3_log : NULL,
                              .logger = (void (*)(void))log,
                              .environment = environment,
                              .resizes = true,
                              .reads = FMU_INSTANTIATED | FMU_CONFIGURATION };
}

/* --- life ---------------------------------------------------------------------------------------- */

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[])
{
    return (fmi3Status)fmu_set_debug_logging(c, "fmi3SetDebugLogging", on, n, categories);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events,
                                         fmi3Boolean early_return, const fmi3ValueReference intermediate[],
                                         size_t n, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    static const char function[] = "fmi3InstantiateCoSimulation";
    struct fmu_host host = fmi3_host(environment, log);

    (void)visible;               /* there is nothing to show */
    (void)intermediate, (void)n; /* all may be had in intermediate update mode */
    if (events) {
        fmu_say_early(&host, name ? name : "",
                      "fmi3InstantiateCoSimulation: this FMU has no event mode (eventModeUsed must be false).");
        return NULL;
    }
    host.ends_early = early_return;
    host.update = update ? fmi3_update : NULL;
    host.updater = (void (*)(void))update;
    return fmu_instantiate(&FMU_MODEL, &COMPILED_IN, function, name, token, resources, &host, logging);
}

static fmi3Instance fmi3_refuse(const char *function, fmi3InstanceEnvironment environment,
                                fmi3LogMessageCallback log)
{
    const struct fmu_host host = fmi3_host(environment, log);
    char text[128];

    snprintf(text, sizeof text, "%s: this FMU is for co-simulation only.", function);
    fmu_say_early(&host, "", text);
    return NULL;
}

void fmi3FreeInstance(fmi3Instance c)
{
    if (c && fmu_may(c, "fmi3FreeInstance", FMU_ANY_PHASE))
        fmu_free(c);
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c)
{
    return (fmi3Status)fmu_enter_configuration(c, "fmi3EnterConfigurationMode");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c)
{
    return (fmi3Status)fmu_exit_configuration(c, "fmi3ExitConfigurationMode");
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start_time, fmi3Boolean stop_time_defined,
                                       fmi3Float64 stop_time)
{
    static const char function[] = "fmi3EnterInitializationMode";
    const enum fmu_status status =
        fmu_setup(c, function, tolerance_defined, tolerance, start_time, stop_time_defined, stop_time);

    return (fmi3Status)(status == FMU_OK ? fmu_enter_initialization(c, function) : status);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    return (fmi3Status)fmu_exit_initialization(c, "fmi3ExitInitializationMode");
}

fmi3Status fmi3Terminate(fmi3Instance c)
{
    return (fmi3Status)fmu_terminate(c, "fmi3Terminate");
}

fmi3Status fmi3Reset(fmi3Instance c)
{
    return (fmi3Status)fmu_reset(c, "fmi3Reset");
}

/* --- values -------------------------------------------------------------------------------------- */

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[],
                          size_t m)
{
    if (fmu_one_scalar(c, vr, n, m))
        return (fmi3Status)fmu_get_real(c, "fmi3GetFloat64", vr, n, values);
    return (fmi3Status)fmu_get_arrays(c, "fmi3GetFloat64", vr, n, values, m);
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[],
                          size_t m)
{
    if (fmu_one_scalar(c, vr, n, m))
        return (fmi3Status)fmu_set_real(c, "fmi3SetFloat64", vr, n, values);
    return (fmi3Status)fmu_set_arrays(c, "fmi3SetFloat64", vr, n, values, m);
}

/* Of types without arrays: are there as many values as references? */
static bool fmi3_scalars(const struct fmu *fmu, const char *function, const fmi3ValueReference vr[], size_t n,
                         const void *values, size_t m)
{
    if (fmu && n == m && (n == 0 || (vr && values)))
        return true;
    if (fmu)
        fmu_say(fmu, FMU_ERROR,
                n == m ? "%s: an array is a null pointer."
                       : "%s: there must be one value for each value reference.",
                function);
    return false;
}

fmi3Status fmi3GetUInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3UInt64 values[], size_t m)
{
    static const char function[] = "fmi3GetUInt64";
    enum fmu_status status = FMU_OK;
    int value;

    if (!fmi3_scalars(c, function, vr, n, values, m))
        return fmi3Error;
    if (n == 0)
        return (fmi3Status)fmu_get(c, function, FMU_INTEGER, vr, n, values);
    for (size_t i = 0; i < n && status == FMU_OK; i++) {
        status = fmu_get(c, function, FMU_INTEGER, vr + i, 1, &value);
        if (status == FMU_OK)
            values[i] = (fmi3UInt64)value;
    }
    return (fmi3Status)status;
}

fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Boolean values[],
                          size_t m)
{
    static const char function[] = "fmi3GetBoolean";
    enum fmu_status status = FMU_OK;
    int value;

    if (!fmi3_scalars(c, function, vr, n, values, m))
        return fmi3Error;
    if (n == 0)
        return (fmi3Status)fmu_get(c, function, FMU_BOOLEAN, vr, n, values);
    for (size_t i = 0; i < n && status == FMU_OK; i++) {
        status = fmu_get(c, function, FMU_BOOLEAN, vr + i, 1, &value);
        if (status == FMU_OK)
            values[i] = value != 0;
    }
    return (fmi3Status)status;
}

/* Sets ints, whatever the standard's type for them; takes the block. */
static fmi3Status fmi3_set_ints(fmi3Instance c, const char *function, enum fmu_base base,
                                const fmi3ValueReference vr[], size_t n, int *block)
{
    if (!block)
        return (fmi3Status)fmu_say(c, FMU_ERROR, "%s: out of memory.", function);
    const enum fmu_status status = fmu_set(c, function, base, vr, n, block);
    free(block);
    return (fmi3Status)status;
}

fmi3Status fmi3SetUInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 values[],
                         size_t m)
{
    static const char function[] = "fmi3SetUInt64";

    if (!fmi3_scalars(c, function, vr, n, values, m))
        return fmi3Error;
    int *block = malloc((n + 1) * sizeof *block);
    for (size_t i = 0; i < n && block; i++)
        block[i] = values[i] < INT_MAX ? (int)values[i] : INT_MAX;
    return fmi3_set_ints(c, function, FMU_INTEGER, vr, n, block);
}

fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Boolean values[],
                          size_t m)
{
    static const char function[] = "fmi3SetBoolean";

    if (!fmi3_scalars(c, function, vr, n, values, m))
        return fmi3Error;
    int *block = malloc((n + 1) * sizeof *block);
    for (size_t i = 0; i < n && block; i++)
        block[i] = values[i];
    return fmi3_set_ints(c, function, FMU_BOOLEAN, vr, n, block);
}

/* --- steps --------------------------------------------------------------------------------------- */

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_rollback,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached)
{
    static const char function[] = "fmi3DoStep";
    struct fmu_ending ending;

    (void)no_rollback; /* states are copies that the host owns: keeping them costs nothing */
    if (!fmu_may(c, function, FMU_STEP_COMPLETE))
        return fmi3Error;
    if (!event || !terminate || !early || !reached)
        return (fmi3Status)fmu_say(c, FMU_ERROR, "%s: a null pointer.", function);
    const enum fmu_status status = fmu_do_updated_step(c, function, time, step, &ending);
    *event = fmi3False;
    *terminate = ending.diverged;
    *early = ending.early;
    *reached = ending.time;
    return (fmi3Status)status;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[],
                                        size_t unknown_count, const fmi3ValueReference knowns[],
                                        size_t known_count, const fmi3Float64 seeds[], size_t seed_count,
                                        fmi3Float64 values[], size_t value_count)
{
    return (fmi3Status)fmu_derivative_of_arrays(c, "fmi3GetDirectionalDerivative", fmu_directional_derivative,
                                                unknowns, unknown_count, knowns, known_count, seeds, seed_count,
                                                values, value_count);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t unknown_count,
                                    const fmi3ValueReference knowns[], size_t known_count,
                                    const fmi3Float64 seeds[], size_t seed_count, fmi3Float64 values[],
                                    size_t value_count)
{
    return (fmi3Status)fmu_derivative_of_arrays(c, "fmi3GetAdjointDerivative", fmu_adjoint_derivative, unknowns,
                                                unknown_count, knowns, known_count, seeds, seed_count, values,
                                                value_count);
}

/* --- FMU states ---------------------------------------------------------------------------------- */

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state)
{
    return (fmi3Status)fmu_get_state(c, "fmi3GetFMUState", state);
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state)
{
    return (fmi3Status)fmu_set_state(c, "fmi3SetFMUState", state);
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    return (fmi3Status)fmu_free_state(c, "fmi3FreeFMUState", state);
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    return (fmi3Status)fmu_state_size(c, "fmi3SerializedFMUStateSize", state, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    return (fmi3Status)fmu_serialize(c, "fmi3SerializeFMUState", state, (char *)bytes, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    return (fmi3Status)fmu_deserialize(c, "fmi3DeserializeFMUState", (const char *)bytes, size, state);
}

/* --- what these FMUs have not ---------------------------------------------------------------------- */

static fmi3Status fmi3_lacks(fmi3Instance c, const char *function)
{
    return fmu_may(c, function, FMU_ANY_PHASE | FMU_UPDATE) ? (fmi3Status)fmu_lacks(c, function) : fmi3Error;
}

/* There are no variables of these types: all that can be had is none. */
static fmi3Status fmi3_none(fmi3Instance c, const char *function, size_t n)
{
    if (!fmu_may(c, function, FMU_ANY_PHASE | FMU_UPDATE))
        return fmi3Error;
    return (fmi3Status)(n ? fmu_say(c, FMU_ERROR, "%s: there are no variables of this type.", function)
                          : FMU_OK);
}

#if defined __GNUC__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

/* clang-format off */
#define FMI3_NONE(type) \
    fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3##type values[], size_t m) \
    { \
        return fmi3_none(c, "fmi3Get" #type, n); \
    } \
    fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3##type values[], \
                             size_t m) \
    { \
        return fmi3_none(c, "fmi3Set" #type, n); \
    }
FMI3_NONE(Float32)
FMI3_NONE(Int8)
FMI3_NONE(UInt8)
FMI3_NONE(Int16)
FMI3_NONE(UInt16)
FMI3_NONE(Int32)
FMI3_NONE(UInt32)
FMI3_NONE(Int64)
FMI3_NONE(String)
#undef FMI3_NONE

#define FMI3_LACKS(name, ...) \
    fmi3Status fmi3##name(fmi3Instance c, __VA_ARGS__) \
    { \
        return fmi3_lacks(c, "fmi3" #name); \
    }
#define FMI3_LACKS_MODE(name) \
    fmi3Status fmi3##name(fmi3Instance c) \
    { \
        return fmi3_lacks(c, "fmi3" #name); \
    }
#define FMI3_OF_VARIABLES const fmi3ValueReference vr[], size_t n
FMI3_LACKS(GetBinary, FMI3_OF_VARIABLES, size_t sizes[], fmi3Binary values[], size_t m)
FMI3_LACKS(SetBinary, FMI3_OF_VARIABLES, const size_t sizes[], const fmi3Binary values[], size_t m)
FMI3_LACKS(GetClock, FMI3_OF_VARIABLES, fmi3Clock values[])
FMI3_LACKS(SetClock, FMI3_OF_VARIABLES, const fmi3Clock values[])
FMI3_LACKS(GetIntervalDecimal, FMI3_OF_VARIABLES, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
FMI3_LACKS(GetIntervalFraction, FMI3_OF_VARIABLES, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
           fmi3IntervalQualifier qualifiers[])
FMI3_LACKS(GetShiftDecimal, FMI3_OF_VARIABLES, fmi3Float64 shifts[])
FMI3_LACKS(GetShiftFraction, FMI3_OF_VARIABLES, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
FMI3_LACKS(SetIntervalDecimal, FMI3_OF_VARIABLES, const fmi3Float64 intervals[])
FMI3_LACKS(SetIntervalFraction, FMI3_OF_VARIABLES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
FMI3_LACKS(SetShiftDecimal, FMI3_OF_VARIABLES, const fmi3Float64 shifts[])
FMI3_LACKS(SetShiftFraction, FMI3_OF_VARIABLES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
FMI3_LACKS(GetNumberOfVariableDependencies, fmi3ValueReference vr, size_t *n)
FMI3_LACKS(GetVariableDependencies, fmi3ValueReference dependent, size_t elements[],
           fmi3ValueReference independents[], size_t elements_of_independents[], fmi3DependencyKind kinds[], size_t n)
FMI3_LACKS(GetOutputDerivatives, FMI3_OF_VARIABLES, const fmi3Int32 orders[], fmi3Float64 values[], size_t m)
FMI3_LACKS_MODE(EnterEventMode)
FMI3_LACKS_MODE(EnterStepMode)
FMI3_LACKS_MODE(EvaluateDiscreteStates)
FMI3_LACKS(UpdateDiscreteStates, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals,
           fmi3Boolean *values, fmi3Boolean *next_defined, fmi3Float64 *next)
FMI3_LACKS_MODE(EnterContinuousTimeMode)
FMI3_LACKS(CompletedIntegratorStep, fmi3Boolean no_rollback, fmi3Boolean *event, fmi3Boolean *terminate)
FMI3_LACKS(SetTime, fmi3Float64 time)
FMI3_LACKS(SetContinuousStates, const fmi3Float64 states[], size_t n)
FMI3_LACKS(GetContinuousStateDerivatives, fmi3Float64 derivatives[], size_t n)
FMI3_LACKS(GetEventIndicators, fmi3Float64 indicators[], size_t n)
FMI3_LACKS(GetContinuousStates, fmi3Float64 states[], size_t n)
FMI3_LACKS(GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t n)
FMI3_LACKS(GetNumberOfEventIndicators, size_t *n)
FMI3_LACKS(GetNumberOfContinuousStates, size_t *n)
FMI3_LACKS(ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)
#undef FMI3_LACKS
#undef FMI3_LACKS_MODE
#undef FMI3_OF_VARIABLES
/* clang-format on */

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    return fmi3_refuse("fmi3InstantiateModelExchange", environment, log);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock)
{
    return fmi3_refuse("fmi3InstantiateScheduledExecution", environment, log);
}

#if defined __GNUC__
#pragma GCC diagnostic pop
#endif
