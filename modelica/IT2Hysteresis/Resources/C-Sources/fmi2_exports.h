/* The functions of FMI 2.0 for the model MODEL (a const struct fmu_model), under the prefix that
 * FMI2_FUNCTION_PREFIX sets. Included once by each model; several models can live in one program, and in
 * one translation unit too: file-scope names of the sources differ (the Modelica library needs it). */
#include "fmi2_prefix.h"
#include "fmu.h"

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
    return fmu_set_debug_logging(c, on, n, categories);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    (void)visible; /* there is nothing to show */
    return fmu_instantiate(&MODEL, name, type, guid, resources, functions, logging);
}

void fmi2FreeInstance(fmi2Component c)
{
    fmu_free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start_time, fmi2Boolean stop_time_defined, fmi2Real stop_time)
{
    return fmu_setup(c, tolerance_defined, tolerance, start_time, stop_time_defined, stop_time);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    return fmu_enter_initialization(c);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    return fmu_exit_initialization(c);
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    return fmu_terminate(c);
}

fmi2Status fmi2Reset(fmi2Component c)
{
    return fmu_reset(c);
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    return fmu_get_real(c, vr, n, value);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[])
{
    return fmu_get(c, "fmi2GetInteger", FMU_INTEGER, vr, n, value);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[])
{
    return fmu_get(c, "fmi2GetBoolean", FMU_BOOLEAN, vr, n, value);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[])
{
    return fmu_get(c, "fmi2GetString", FMU_STRING, vr, n, value);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    return fmu_set_real(c, vr, n, value);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          const fmi2Integer value[])
{
    return fmu_set(c, "fmi2SetInteger", FMU_INTEGER, vr, n, value);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          const fmi2Boolean value[])
{
    return fmu_set(c, "fmi2SetBoolean", FMU_BOOLEAN, vr, n, value);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                         const fmi2String value[])
{
    return fmu_set(c, "fmi2SetString", FMU_STRING, vr, n, value);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    return fmu_get_state(c, state);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    return fmu_set_state(c, state);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    return fmu_free_state(c, state);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    return fmu_state_size(c, state, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    return fmu_serialize(c, state, bytes, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state)
{
    return fmu_deserialize(c, bytes, size, state);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[],
                                        size_t unknown_count, const fmi2ValueReference knowns[],
                                        size_t known_count, const fmi2Real seeds[], fmi2Real values[])
{
    return fmu_directional_derivative(c, unknowns, unknown_count, knowns, known_count, seeds, values);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    return fmu_set_input_derivatives(c, vr, n, order, value);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)n, (void)order, (void)value;
    return fmu_get_output_derivatives(c);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_rollback)
{
    (void)no_rollback; /* states are copies that the host owns: keeping them costs nothing */
    return fmu_do_step(c, time, step);
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    return fmu_cancel_step(c);
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    return fmu_get_status(c, "fmi2GetStatus", kind, value);
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    return fmu_get_status(c, "fmi2GetRealStatus", kind, value);
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    return fmu_get_status(c, "fmi2GetIntegerStatus", kind, value);
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    return fmu_get_status(c, "fmi2GetBooleanStatus", kind, value);
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    return fmu_get_status(c, "fmi2GetStringStatus", kind, value);
}

#undef MODEL
