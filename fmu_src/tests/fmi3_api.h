/* The functions of one FMU of FMI 3.0 as a table, as fmi2_api.h has those of FMI 2.0. */
#ifndef IT2HYS_FMI3_API_H
#define IT2HYS_FMI3_API_H

#include "fmi3FunctionTypes.h"
#include "actuator.h"

/* clang-format off */
#define FMI3_API(X) \
    X(SetDebugLogging) X(InstantiateCoSimulation) X(InstantiateModelExchange) X(FreeInstance) \
    X(EnterConfigurationMode) X(ExitConfigurationMode) X(EnterInitializationMode) X(ExitInitializationMode) \
    X(Terminate) X(Reset) X(GetFloat64) X(SetFloat64) X(GetUInt64) X(SetUInt64) X(GetBoolean) X(SetBoolean) \
    X(GetInt32) X(SetFloat32) X(GetString) X(GetFMUState) X(SetFMUState) X(FreeFMUState) \
    X(SerializedFMUStateSize) X(SerializeFMUState) X(DeserializeFMUState) X(GetDirectionalDerivative) \
    X(GetAdjointDerivative) X(DoStep) X(EnterEventMode) X(GetOutputDerivatives)
/* clang-format on */

struct fmi3_api {
    unsigned kind;
    uint64_t table_hash;
#define FMI3_MEMBER(name) fmi3##name##TYPE *name;
    FMI3_API(FMI3_MEMBER)
#undef FMI3_MEMBER
};

extern const struct fmi3_api PLANT3, INVERSE3;

#endif
