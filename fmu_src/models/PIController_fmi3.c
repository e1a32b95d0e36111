/* PIController_fmi3.fmu: the controller under FMI 3.0. */
#include "controller.h"
#include "controller_start.h"

#define FMU_MODEL controller_model
#define FMU_SET { FMU_START_HASH, &FMU_START, NULL }
#include "fmi3_functions.h"
