/* IT2Plant_fmi3.fmu: the plant under FMI 3.0. */
#include "actuator.h"
#include "fmu_start.h"

#define FMU_MODEL plant_model
#define FMU_SET { FMU_START_HASH, &FMU_START, fmu_load_parameters }
#include "fmi3_functions.h"
