/* What the plant and the inverse share: the table of their variables, and the chain as parameters make it. */
#ifndef IT2HYS_ACTUATOR_H
#define IT2HYS_ACTUATOR_H

#include "chain.h"
#include "fmu.h"
#include "fmu_places.h"

#define MICROMETRES "\xc2\xb5m" /* as UTF-8, whatever the compiler takes the source for */

enum { FMU_PLANT = 1, FMU_INVERSE = 2 };

HIDDEN_BEGIN

extern const struct fmu_model plant_model, inverse_model;

extern const struct fmu_variable actuator_table[];

/* The constants. */
struct actuator {
    struct chain chain; /* first: a pointer to it is one to the actuator */
    struct it2_table table;
};

bool actuator_settle(void *constants);

bool actuator_check(const struct fmu_model *model, const void *parameters, char *message, size_t size);

static inline struct chain_surroundings actuator_surroundings(const double input[FMU_INPUTS], double time)
{
    return (struct chain_surroundings){ input[IN_FORCE], input[IN_TEMPERATURE], time };
}

/* The derivative of it; time is none of the knowns. */
static inline struct chain_surroundings actuator_surroundings_tangent(const double d_input[FMU_INPUTS])
{
    return actuator_surroundings(d_input, 0.0);
}

HIDDEN_END

/* Initialisers of what their models have in common. */
#define ACTUATOR \
    .table = actuator_table, .rows = FMU_TABLE_ROWS, .parameters_size = sizeof(struct chain_parameters), \
    .constants_size = sizeof(struct actuator), .state_size = sizeof(struct chain_state), .interpolates = true, \
    .check = actuator_check

#endif
