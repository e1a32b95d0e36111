#include "actuator.h"

#include "fmu_table.h"

bool actuator_check(const struct fmu_model *model, const void *parameters, char *message, size_t size)
{
    return fmu_within_bounds(model, parameters, message, size) && chain_check(parameters, message, size);
}

bool actuator_settle(void *constants)
{
    struct actuator *actuator = constants;

    return it2_tabulate(&actuator->chain.core, &actuator->table) && actuator->chain.all == 0;
}
