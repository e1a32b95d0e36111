/* A model without physics that notes the voltage of every tick: it makes the ticks visible, and shows
 * that the FMI layer serves any model. */
#include "fmi2_api.h"
#include "fmu_table_hash.h"

double counting_voltage[COUNTING_CAPACITY];
long counting_ticks;

static void counting_start(const struct chain *chain, const struct chain_state *state,
                           const struct chain_parameters *parameters, struct fmu_outputs *outputs)
{
    (void)chain, (void)state, (void)parameters;
    *outputs = (struct fmu_outputs){ 0 };
}

static void counting_start_tangent(const struct chain *chain, const struct chain_state *state,
                                   const struct chain_parameters *parameters,
                                   const struct chain_parameters *d_parameters,
                                   struct fmu_outputs *d_outputs)
{
    (void)d_parameters;
    counting_start(chain, state, parameters, d_outputs);
}

static unsigned counting_tick(const struct chain *chain, struct chain_state *state,
                              const struct chain_parameters *parameters,
                              const struct fmu_inputs *inputs, struct fmu_outputs *outputs)
{
    (void)chain, (void)state, (void)parameters;
    if (counting_ticks < COUNTING_CAPACITY)
        counting_voltage[counting_ticks] = inputs->voltage;
    outputs->displacement = (double)++counting_ticks;
    return 0;
}

static struct chain_state counting_tangent(const struct chain *chain, const struct chain_state *state,
                                           const struct fmu_inputs *inputs, struct chain_state d_state,
                                           const struct fmu_inputs *d_inputs,
                                           struct fmu_outputs *d_outputs)
{
    (void)chain, (void)state, (void)inputs, (void)d_inputs, (void)d_outputs;
    return d_state;
}

static const struct fmu_model COUNTING_MODEL = {
    .identifier = "Counting",
    .kind = FMU_PLANT,
    .table_hash = FMU_TABLE_HASH_PLANT,
    .start = counting_start,
    .start_tangent = counting_start_tangent,
    .tick = counting_tick,
    .tick_tangent = counting_tangent,
};

#define MODEL COUNTING_MODEL
#include "fmi2_exports.h"
