/* The inverse: the chain walked backwards, from a desired displacement to the voltage that yields it. */
#include <math.h>

#include "actuator.h"
#include "fmu_table_hash.h"

enum inverse_finding { INVERSE_OUT_OF_REACH = 1, INVERSE_AMPLIFIER_LIMIT = 2, INVERSE_VOLTAGE_LIMIT = 4 };

static size_t inverse_prepare(void *constants, const void *parameters)
{
    struct chain *chain = constants;

    chain_prepare(chain, parameters);
    chain_pass_by_idle(chain, parameters); /* arrays are not empty, for hosts that know arrays */
    return chain->retraced;
}

/* Before the first tick: the voltage that holds the plant at its initial displacement, so that a
 * master that hands values on one step late starts from rest. */
static bool inverse_start(const void *constants, void *state, const void *parameters,
                          struct fmu_outputs *output, char *message, size_t size)
{
    const struct chain_parameters *p = parameters;

    chain_reset(constants, state, parameters);
    output->real[OUT_VOLTAGE] = chain_equilibrium(constants, state);
    output->flag[OUT_SATURATED] = 0;
    if (isfinite(output->real[OUT_VOLTAGE])) /* a core that a voltage hardly moves may need an infinite one */
        return true;
    snprintf(message, size, "at initialDisplacement, %g m, the output is no finite number",
             p->initialDisplacement);
    return false;
}

static void inverse_start_tangent(const void *constants, const void *state, const void *parameters,
                                  const void *d_parameters, struct fmu_outputs *d_output)
{
    d_output->real[OUT_VOLTAGE] = chain_equilibrium_tangent(constants, state, parameters, d_parameters);
}

static unsigned inverse_tick(const void *constants, void *state, const void *parameters,
                             const double input[FMU_INPUTS], double time, struct fmu_outputs *output)
{
    const struct chain_surroundings around = actuator_surroundings(input, time);
    unsigned limits;
    const double voltage = chain_inverse(constants, state, input[IN_REFERENCE], &around, &limits);
    unsigned findings = 0;

    (void)parameters;
    if (!isfinite(voltage))
        return FMU_NOT_FINITE;
    output->real[OUT_VOLTAGE] = voltage;
    output->flag[OUT_SATURATED] = limits != 0;
    if (limits & CHAIN_REFERENCE_RANGE)
        findings |= INVERSE_OUT_OF_REACH;
    if (limits & CHAIN_AMPLIFIER)
        findings |= INVERSE_AMPLIFIER_LIMIT;
    if (limits & CHAIN_VOLTAGE_RANGE)
        findings |= INVERSE_VOLTAGE_LIMIT;
    return findings;
}

/* Within the ranges, by the table: a short way, in which nothing is called. */
static int64_t inverse_ticks(const void *constants, void *state, const double input[FMU_INPUTS], int64_t count,
                             struct fmu_outputs *output)
{
    const struct chain *chain = constants;
    const double reference = input[IN_REFERENCE];
    struct chain_state *s = state;
    int64_t done = 0;

    if (!it2_is_plain(&chain->core, reference) || !it2_is_plain(&chain->core, s->core.y))
        return 0;
    for (; done < count; done++) {
        const double voltage = it2_look_up_inverse(chain->core.table, s->core.y, reference);
        if (!(voltage >= chain->voltage.minimum && voltage <= chain->voltage.maximum))
            break;
        s->core.y = reference;
        output->real[OUT_VOLTAGE] = voltage;
        output->flag[OUT_SATURATED] = 0;
    }
    return done;
}

static unsigned inverse_short_tick(const void *constants, void *state, const void *parameters,
                                   const double input[FMU_INPUTS], double time, struct fmu_outputs *output)
{
    if (inverse_ticks(constants, state, input, 1, output) == 1)
        return 0;
    return inverse_tick(constants, state, parameters, input, time, output);
}

static void inverse_explain(unsigned finding, const void *state, const void *parameters,
                            const double input[FMU_INPUTS], double time, const struct fmu_outputs *output,
                            char *text, size_t size)
{
    const struct chain_parameters *p = parameters;
    const double reference = 1e6 * input[IN_REFERENCE];
    const double voltage = output->real[OUT_VOLTAGE];

    (void)state;
    if (finding == INVERSE_OUT_OF_REACH)
        snprintf(text, size,
                 "the reference, %g " MICROMETRES
                 " at %g s, is outside displacementMin..displacementMax, %g to "
                 "%g " MICROMETRES "; it is clamped (saturated is true).",
                 reference, time, 1e6 * p->displacementMin, 1e6 * p->displacementMax);
    else if (finding == INVERSE_AMPLIFIER_LIMIT)
        snprintf(text, size,
                 "the reference, %g " MICROMETRES " at %g s, needs a voltage beyond slew.rate or "
                 "saturation.minimum..saturation.maximum; it is clamped to %g V (saturated is true).",
                 reference, time, voltage);
    else
        snprintf(text, size,
                 "the reference, %g " MICROMETRES " at %g s, needs a voltage outside voltageMin..voltageMax, "
                 "%g to %g V; it is clamped to the nearer end (saturated is true).",
                 reference, time, p->voltageMin, p->voltageMax);
}

static void inverse_tick_tangent(const void *constants, const void *state, const double input[FMU_INPUTS],
                                 double time, void *d_state, const double d_input[FMU_INPUTS],
                                 struct fmu_outputs *d_output)
{
    const struct chain_surroundings around = actuator_surroundings(input, time);
    const struct chain_surroundings d_around = actuator_surroundings_tangent(d_input);
    struct chain_state *d = d_state;
    const struct chain_point next = chain_inverse_tangent(constants, state, input[IN_REFERENCE], &around, *d,
                                                          d_input[IN_REFERENCE], &d_around);

    d_output->real[OUT_VOLTAGE] = next.output;
    *d = next.state;
}

const struct fmu_model inverse_model = {
    ACTUATOR,
    .identifier = "IT2Inverse",
    .kind = FMU_INVERSE,
    .table_hash = FMU_TABLE_HASH_INVERSE,
    .input_start = FMU_INVERSE_INPUT_START,
    .diverging = "voltage",
    .prepare = inverse_prepare,
    .settle = actuator_settle,
    .start = inverse_start,
    .start_tangent = inverse_start_tangent,
    .tick = inverse_tick,
    .short_tick = inverse_short_tick,
    .ticks = inverse_ticks,
    .explain = inverse_explain,
    .tick_tangent = inverse_tick_tangent,
};
