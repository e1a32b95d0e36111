/* IT2Inverse_fmi3.fmu: the inverse under FMI 3.0. */
#include "actuator.h"
#include "fmu_start.h"

#define FMU_MODEL inverse_model
#define FMU_SET { FMU_START_HASH, &FMU_START, fmu_load_parameters }
#include "fmi3_functions.h"
