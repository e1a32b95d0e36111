/* IT2Inverse.fmu: the inverse under FMI 2.0. */
#include "actuator.h"
#include "fmu_start.h"

#define FMU_MODEL inverse_model
#define FMU_SET { FMU_START_HASH, &FMU_START, fmu_load_parameters }
#include "fmi2_functions.h"
