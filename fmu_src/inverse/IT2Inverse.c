/* IT2Inverse: the chain walked backwards, from a desired displacement to the voltage that yields it. */
#include "fmu.h"
#include "fmu_table_hash.h"

/* Before the first tick: the voltage that holds the plant at its initial displacement, so that a
 * master that hands values on one step late starts from rest. */
static void inverse_start(const struct chain *chain, const struct chain_state *state,
                          const struct chain_parameters *parameters, struct fmu_outputs *outputs)
{
    (void)parameters;
    outputs->voltage = chain_equilibrium(chain, state);
    outputs->saturated = 0;
}

static void inverse_start_tangent(const struct chain *chain, const struct chain_state *state,
                                  const struct chain_parameters *parameters,
                                  const struct chain_parameters *d_parameters,
                                  struct fmu_outputs *d_outputs)
{
    d_outputs->voltage = chain_equilibrium_tangent(chain, state, parameters, d_parameters);
}

static unsigned inverse_tick(const struct chain *chain, struct chain_state *state,
                             const struct chain_parameters *parameters,
                             const struct fmu_inputs *inputs, struct fmu_outputs *outputs)
{
    const struct chain_surroundings around = fmu_surroundings(inputs);
    unsigned limits;
    unsigned findings = 0;

    (void)parameters;
    outputs->voltage = chain_inverse(chain, state, inputs->reference, &around, &limits);
    outputs->saturated = limits != 0;
    if (limits & CHAIN_REFERENCE_RANGE)
        findings |= FMU_OUT_OF_REACH;
    if (limits & CHAIN_AMPLIFIER)
        findings |= FMU_AMPLIFIER_LIMIT;
    if (limits & CHAIN_VOLTAGE_RANGE)
        findings |= FMU_VOLTAGE_LIMIT;
    return findings;
}

static struct chain_state inverse_tick_tangent(const struct chain *chain,
                                               const struct chain_state *state,
                                               const struct fmu_inputs *inputs,
                                               struct chain_state d_state,
                                               const struct fmu_inputs *d_inputs,
                                               struct fmu_outputs *d_outputs)
{
    const struct chain_surroundings around = fmu_surroundings(inputs);
    const struct chain_surroundings d_around = fmu_surroundings(d_inputs);
    const struct chain_point d = chain_inverse_tangent(chain, state, inputs->reference, &around, d_state,
                                                       d_inputs->reference, &d_around);

    d_outputs->voltage = d.output;
    return d.state;
}

static const struct fmu_model IT2_INVERSE = {
    .identifier = "IT2Inverse",
    .kind = FMU_INVERSE,
    .table_hash = FMU_TABLE_HASH_INVERSE,
    .start = inverse_start,
    .start_tangent = inverse_start_tangent,
    .tick = inverse_tick,
    .tick_tangent = inverse_tick_tangent,
};

#define MODEL IT2_INVERSE
#include "fmi2_exports.h"
