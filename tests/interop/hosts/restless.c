/* An FMU that stops at times of its own: a step beyond the next of them is discarded there, so that the
 * master has to take all others back and make a shorter one. Its output counts how often it was itself
 * taken back. */
#include <math.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h" /* not the declarations: see NOTHING */

#define STOP 3.5e-4 /* s, from one time to the next */

enum { INPUT, OUTPUT };

struct instance {
    double time, input;
    double restored; /* not part of the state */
};

const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

const char *fmi2GetVersion(void)
{
    return "2.0";
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    (void)name, (void)type, (void)guid, (void)resources, (void)functions, (void)visible, (void)logging;
    return calloc(1, sizeof(struct instance));
}

void fmi2FreeInstance(fmi2Component c)
{
    free(c);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != INPUT)
            return fmi2Error;
        ((struct instance *)c)->input = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    const struct instance *instance = c;

    for (size_t i = 0; i < n; i++)
        value[i] = vr[i] == INPUT ? instance->input : instance->restored;
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_rollback)
{
    struct instance *instance = c;
    const double stop = STOP * (floor(time / STOP + 1e-6) + 1.0);

    (void)no_rollback;
    if (fabs(time - instance->time) > 1e-9)
        return fmi2Error;
    instance->time = fmin(stop, time + step);
    return time + step > stop + 1e-9 ? fmi2Discard : fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    *value = ((struct instance *)c)->time;
    return kind == fmi2LastSuccessfulTime ? fmi2OK : fmi2Discard;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    if (!*state)
        *state = malloc(sizeof(struct instance));
    *(struct instance *)*state = *(struct instance *)c;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    struct instance *instance = c;
    const double restored = instance->restored + 1.0;

    *instance = *(struct instance *)state;
    instance->restored = restored;
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start_time, fmi2Boolean stop_time_defined, fmi2Real stop_time)
{
    (void)tolerance_defined, (void)tolerance, (void)stop_time_defined, (void)stop_time;
    ((struct instance *)c)->time = start_time;
    return fmi2OK;
}

/* Whatever the arguments: nothing is done. */
#define NOTHING(function) fmi2Status function(fmi2Component c) { (void)c; return fmi2OK; }
NOTHING(fmi2EnterInitializationMode) NOTHING(fmi2ExitInitializationMode) NOTHING(fmi2Terminate)
NOTHING(fmi2SetDebugLogging) NOTHING(fmi2GetInteger) NOTHING(fmi2GetBoolean) NOTHING(fmi2GetString)
NOTHING(fmi2SetInteger) NOTHING(fmi2SetBoolean) NOTHING(fmi2SetString) NOTHING(fmi2Reset)
NOTHING(fmi2SerializedFMUstateSize) NOTHING(fmi2SerializeFMUstate) NOTHING(fmi2DeSerializeFMUstate)
NOTHING(fmi2GetDirectionalDerivative) NOTHING(fmi2SetRealInputDerivatives)
NOTHING(fmi2GetRealOutputDerivatives) NOTHING(fmi2CancelStep) NOTHING(fmi2GetStatus)
NOTHING(fmi2GetIntegerStatus) NOTHING(fmi2GetBooleanStatus) NOTHING(fmi2GetStringStatus)
