/* The functions of FMI 2.0 under a prefix, so that several models can be linked into one program.
 *
 * The standard's header leaves the prefix to its user. Where FMI2_FUNCTION_PREFIX is defined, its names
 * are given that prefix here and declared again. It may be included once more with another prefix. */
#include "fmi2Functions.h"

#if defined FMI2_FUNCTION_PREFIX

#undef fmi2FullName
#undef fmi2Paste
#undef fmi2PasteExpanded
#define fmi2Paste(a, b) a##b
#define fmi2PasteExpanded(a, b) fmi2Paste(a, b)
#define fmi2FullName(name) fmi2PasteExpanded(FMI2_FUNCTION_PREFIX, name)

#define FMI2_DECLARE(name) extern name##TYPE name
FMI2_DECLARE(fmi2GetTypesPlatform);
FMI2_DECLARE(fmi2GetVersion);
FMI2_DECLARE(fmi2SetDebugLogging);
FMI2_DECLARE(fmi2Instantiate);
FMI2_DECLARE(fmi2FreeInstance);
FMI2_DECLARE(fmi2SetupExperiment);
FMI2_DECLARE(fmi2EnterInitializationMode);
FMI2_DECLARE(fmi2ExitInitializationMode);
FMI2_DECLARE(fmi2Terminate);
FMI2_DECLARE(fmi2Reset);
FMI2_DECLARE(fmi2GetReal);
FMI2_DECLARE(fmi2GetInteger);
FMI2_DECLARE(fmi2GetBoolean);
FMI2_DECLARE(fmi2GetString);
FMI2_DECLARE(fmi2SetReal);
FMI2_DECLARE(fmi2SetInteger);
FMI2_DECLARE(fmi2SetBoolean);
FMI2_DECLARE(fmi2SetString);
FMI2_DECLARE(fmi2GetFMUstate);
FMI2_DECLARE(fmi2SetFMUstate);
FMI2_DECLARE(fmi2FreeFMUstate);
FMI2_DECLARE(fmi2SerializedFMUstateSize);
FMI2_DECLARE(fmi2SerializeFMUstate);
FMI2_DECLARE(fmi2DeSerializeFMUstate);
FMI2_DECLARE(fmi2GetDirectionalDerivative);
FMI2_DECLARE(fmi2SetRealInputDerivatives);
FMI2_DECLARE(fmi2GetRealOutputDerivatives);
FMI2_DECLARE(fmi2DoStep);
FMI2_DECLARE(fmi2CancelStep);
FMI2_DECLARE(fmi2GetStatus);
FMI2_DECLARE(fmi2GetRealStatus);
FMI2_DECLARE(fmi2GetIntegerStatus);
FMI2_DECLARE(fmi2GetBooleanStatus);
FMI2_DECLARE(fmi2GetStringStatus);
#undef FMI2_DECLARE

#endif
