/* IT2Plant: the chain walked forwards, from voltage to displacement. */
#include "fmu.h"
#include "fmu_table_hash.h"

/* Before the first tick the reading is taken as the displacement: hum begins with the ticks. */
static void plant_start(const struct chain *chain, const struct chain_state *state,
                        const struct chain_parameters *parameters, struct fmu_outputs *outputs)
{
    (void)chain, (void)state;
    outputs->displacement = parameters->initialDisplacement;
    outputs->measured = parameters->initialDisplacement;
    outputs->outOfRange = 0;
}

static void plant_start_tangent(const struct chain *chain, const struct chain_state *state,
                                const struct chain_parameters *parameters,
                                const struct chain_parameters *d_parameters,
                                struct fmu_outputs *d_outputs)
{
    (void)parameters;
    plant_start(chain, state, d_parameters, d_outputs);
}

static unsigned plant_tick(const struct chain *chain, struct chain_state *state,
                           const struct chain_parameters *parameters, const struct fmu_inputs *inputs,
                           struct fmu_outputs *outputs)
{
    const double voltage = inputs->voltage;
    const struct chain_surroundings around = fmu_surroundings(inputs);
    const double displacement = chain_step(chain, state, voltage, &around);
    unsigned findings = 0;

    outputs->displacement = displacement;
    outputs->measured = chain_measure(chain, displacement, inputs->time);
    if (chain_outside(voltage, parameters->voltageMin, parameters->voltageMax))
        findings |= FMU_VOLTAGE_RANGE;
    if (chain_outside(state->core.y, parameters->displacementMin, parameters->displacementMax))
        findings |= FMU_DISPLACEMENT_RANGE;
    outputs->outOfRange = findings != 0;
    return findings;
}

static struct chain_state plant_tick_tangent(const struct chain *chain, const struct chain_state *state,
                                             const struct fmu_inputs *inputs,
                                             struct chain_state d_state,
                                             const struct fmu_inputs *d_inputs,
                                             struct fmu_outputs *d_outputs)
{
    const struct chain_surroundings around = fmu_surroundings(inputs);
    const struct chain_surroundings d_around = fmu_surroundings(d_inputs);
    const struct chain_point d = chain_step_tangent(chain, state, inputs->voltage, &around, d_state,
                                                    d_inputs->voltage, &d_around);

    d_outputs->displacement = d_outputs->measured = d.output; /* hum adds to it */
    return d.state;
}

static const struct fmu_model IT2_PLANT = {
    .identifier = "IT2Plant",
    .kind = FMU_PLANT,
    .table_hash = FMU_TABLE_HASH_PLANT,
    .start = plant_start,
    .start_tangent = plant_start_tangent,
    .tick = plant_tick,
    .tick_tangent = plant_tick_tangent,
};

#define MODEL IT2_PLANT
#include "fmi2_exports.h"
