/* PIController.fmu: the controller under FMI 2.0. */
#include "controller.h"
#include "controller_start.h"

#define FMU_MODEL controller_model
#define FMU_SET { FMU_START_HASH, &FMU_START, NULL }
#include "fmi2_functions.h"
