/* The functions of one FMU as a table, so that a test runs the same code on several models that are
 * linked into one program under different prefixes. Members are named as in the standard. */
#ifndef IT2HYS_FMI2_API_H
#define IT2HYS_FMI2_API_H

#include "fmi2FunctionTypes.h"
#include "actuator.h"

struct fmi2_api {
    const char *identifier;
    unsigned kind;
    uint64_t table_hash;
    fmi2GetTypesPlatformTYPE *GetTypesPlatform;
    fmi2GetVersionTYPE *GetVersion;
    fmi2SetDebugLoggingTYPE *SetDebugLogging;
    fmi2InstantiateTYPE *Instantiate;
    fmi2FreeInstanceTYPE *FreeInstance;
    fmi2SetupExperimentTYPE *SetupExperiment;
    fmi2EnterInitializationModeTYPE *EnterInitializationMode;
    fmi2ExitInitializationModeTYPE *ExitInitializationMode;
    fmi2TerminateTYPE *Terminate;
    fmi2ResetTYPE *Reset;
    fmi2GetRealTYPE *GetReal;
    fmi2GetIntegerTYPE *GetInteger;
    fmi2GetBooleanTYPE *GetBoolean;
    fmi2GetStringTYPE *GetString;
    fmi2SetRealTYPE *SetReal;
    fmi2SetIntegerTYPE *SetInteger;
    fmi2SetBooleanTYPE *SetBoolean;
    fmi2SetStringTYPE *SetString;
    fmi2GetFMUstateTYPE *GetFMUstate;
    fmi2SetFMUstateTYPE *SetFMUstate;
    fmi2FreeFMUstateTYPE *FreeFMUstate;
    fmi2SerializedFMUstateSizeTYPE *SerializedFMUstateSize;
    fmi2SerializeFMUstateTYPE *SerializeFMUstate;
    fmi2DeSerializeFMUstateTYPE *DeSerializeFMUstate;
    fmi2GetDirectionalDerivativeTYPE *GetDirectionalDerivative;
    fmi2SetRealInputDerivativesTYPE *SetRealInputDerivatives;
    fmi2GetRealOutputDerivativesTYPE *GetRealOutputDerivatives;
    fmi2DoStepTYPE *DoStep;
    fmi2CancelStepTYPE *CancelStep;
    fmi2GetStatusTYPE *GetStatus;
    fmi2GetRealStatusTYPE *GetRealStatus;
    fmi2GetIntegerStatusTYPE *GetIntegerStatus;
    fmi2GetBooleanStatusTYPE *GetBooleanStatus;
    fmi2GetStringStatusTYPE *GetStringStatus;
};

/* All that an FMU state of plant or inverse holds: the layer's snapshot and what is behind it. */
struct block {
    struct fmu_snapshot s;
    struct chain_parameters parameter;
    struct chain_state state;
    struct chain_state last_state;
};

static inline struct block *block_of(fmi2Component c)
{
    fmu_gather(c);
    return (struct block *)(void *)((struct fmu *)c)->now;
}

extern const struct fmi2_api PLANT, INVERSE, COUNTING;

/* What the counting model (counting_model.c) saw: the voltage of each tick, in order. */
enum { COUNTING_CAPACITY = 1100000 };
extern double counting_voltage[COUNTING_CAPACITY];
extern long counting_ticks;

#endif
