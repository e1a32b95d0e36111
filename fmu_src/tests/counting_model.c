/* A model without physics that notes the voltage of every tick: it makes the ticks visible, and shows
 * that the FMI layer serves any model. With WITHOUT_TICK, a tick does nothing: what a step takes then, the layer
 * takes. */
#include "fmi2_api.h"
#include "fmu_start.h"
#include "fmu_table_hash.h"

double counting_voltage[COUNTING_CAPACITY];
long counting_ticks;

static bool counting_start(const void *constants, void *state, const void *parameters,
                           struct fmu_outputs *output, char *message, size_t size)
{
    (void)constants, (void)state, (void)parameters, (void)message, (void)size;
    *output = (struct fmu_outputs){ { 0.0 }, { 0 } };
    return true;
}

static unsigned counting_tick(const void *constants, void *state, const void *parameters,
                              const double input[FMU_INPUTS], double time, struct fmu_outputs *output)
{
    (void)constants, (void)state, (void)parameters, (void)input, (void)time, (void)output;
#ifndef WITHOUT_TICK
    if (counting_ticks < COUNTING_CAPACITY)
        counting_voltage[counting_ticks] = input[IN_VOLTAGE];
    output->real[OUT_DISPLACEMENT] = (double)++counting_ticks;
#endif
    return 0;
}

static size_t counting_prepare(void *constants, const void *parameters)
{
    (void)constants, (void)parameters;
    return sizeof(double);
}

static const struct fmu_model COUNTING_MODEL = {
    ACTUATOR,
    .identifier = "Counting",
    .kind = FMU_PLANT,
    .table_hash = FMU_TABLE_HASH_PLANT,
    .input_start = FMU_PLANT_INPUT_START,
    .diverging = "count",
    .prepare = counting_prepare,
    .start = counting_start,
    .tick = counting_tick,
};

#define FMU_MODEL COUNTING_MODEL
#define FMU_SET { FMU_START_HASH, &FMU_START, NULL }
#include "fmi2_functions.h"
