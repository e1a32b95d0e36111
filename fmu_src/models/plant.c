/* The plant: the chain walked forwards, from voltage to displacement. */
#include <math.h>

#include "actuator.h"
#include "fmu_table_hash.h"

enum plant_finding { PLANT_VOLTAGE_RANGE = 1, PLANT_DISPLACEMENT_RANGE = 2 };

static size_t plant_prepare(void *constants, const void *parameters)
{
    struct chain *chain = constants;

    chain_prepare(chain, parameters);
    chain_pass_by_idle(chain, parameters); /* arrays are not empty, for hosts that know arrays */
    return chain->walked;
}

/* Before the first tick the reading is taken as the displacement: hum begins with the ticks. */
static bool plant_start(const void *constants, void *state, const void *parameters, struct fmu_outputs *output,
                        char *message, size_t size)
{
    const struct chain_parameters *p = parameters;

    (void)message, (void)size;
    chain_reset(constants, state, parameters);
    output->real[OUT_DISPLACEMENT] = output->real[OUT_MEASURED] = p->initialDisplacement;
    output->flag[OUT_OUT_OF_RANGE] = 0;
    return true;
}

static void plant_start_tangent(const void *constants, const void *state, const void *parameters,
                                const void *d_parameters, struct fmu_outputs *d_output)
{
    const struct chain_parameters *d = d_parameters;

    (void)constants, (void)state, (void)parameters;
    d_output->real[OUT_DISPLACEMENT] = d_output->real[OUT_MEASURED] = d->initialDisplacement;
}

static unsigned plant_tick(const void *constants, void *state, const void *parameters,
                           const double input[FMU_INPUTS], double time, struct fmu_outputs *output)
{
    const struct chain_parameters *p = parameters;
    const struct chain_state *s = state;
    const double voltage = input[IN_VOLTAGE];
    const struct chain_surroundings around = actuator_surroundings(input, time);
    const double displacement = chain_step(constants, state, voltage, &around);
    const double measured = chain_measure(constants, displacement, time);
    unsigned findings = 0;

    if (!isfinite(measured))
        return FMU_NOT_FINITE;
    output->real[OUT_DISPLACEMENT] = displacement;
    output->real[OUT_MEASURED] = measured;
    if (chain_outside(voltage, p->voltageMin, p->voltageMax))
        findings |= PLANT_VOLTAGE_RANGE;
    if (chain_outside(s->core.y, p->displacementMin, p->displacementMax))
        findings |= PLANT_DISPLACEMENT_RANGE;
    output->flag[OUT_OUT_OF_RANGE] = findings != 0;
    return findings;
}

/* Within the ranges, by the table: a short way, in which nothing is called. */
static int64_t plant_ticks(const void *constants, void *state, const double input[FMU_INPUTS], int64_t count,
                           struct fmu_outputs *output)
{
    const struct chain *chain = constants;
    const double voltage = input[IN_VOLTAGE];
    struct chain_state *s = state;
    double y = s->core.y;
    int64_t done = 0;

    if (!(voltage >= chain->voltage.minimum && voltage <= chain->voltage.maximum) ||
        !it2_is_plain(&chain->core, y))
        return 0;
    for (; done < count; done++) {
        const double next = it2_look_up_step(chain->core.table, y, voltage);
        if (!it2_is_plain(&chain->core, next))
            break;
        y = next;
    }
    if (done == 0)
        return 0;
    s->core.y = y;
    output->real[OUT_DISPLACEMENT] = output->real[OUT_MEASURED] = y;
    output->flag[OUT_OUT_OF_RANGE] = 0;
    return done;
}

static unsigned plant_short_tick(const void *constants, void *state, const void *parameters,
                                 const double input[FMU_INPUTS], double time, struct fmu_outputs *output)
{
    if (plant_ticks(constants, state, input, 1, output) == 1)
        return 0;
    return plant_tick(constants, state, parameters, input, time, output);
}

static void plant_explain(unsigned finding, const void *state, const void *parameters,
                          const double input[FMU_INPUTS], double time, const struct fmu_outputs *output,
                          char *text, size_t size)
{
    const struct chain_parameters *p = parameters;
    const struct chain_state *s = state;

    (void)output;
    if (finding == PLANT_VOLTAGE_RANGE)
        snprintf(text, size,
                 "the voltage left voltageMin..voltageMax, %g to %g V, the range that the "
                 "parameters are valid for: it is %g V at %g s; outOfRange is true as long as it is outside.",
                 p->voltageMin, p->voltageMax, input[IN_VOLTAGE], time);
    else
        snprintf(text, size,
                 "the core's displacement left displacementMin..displacementMax, %g to %g " MICROMETRES ", the "
                 "range that its rules are valid for: it is %g " MICROMETRES " at %g s; outOfRange is true, "
                 "and the model extrapolates, as long as it is outside.",
                 1e6 * p->displacementMin, 1e6 * p->displacementMax, 1e6 * s->core.y, time);
}

static void plant_tick_tangent(const void *constants, const void *state, const double input[FMU_INPUTS],
                               double time, void *d_state, const double d_input[FMU_INPUTS],
                               struct fmu_outputs *d_output)
{
    const struct chain_surroundings around = actuator_surroundings(input, time);
    const struct chain_surroundings d_around = actuator_surroundings_tangent(d_input);
    struct chain_state *d = d_state;
    const struct chain_point next =
        chain_step_tangent(constants, state, input[IN_VOLTAGE], &around, *d, d_input[IN_VOLTAGE], &d_around);

    d_output->real[OUT_DISPLACEMENT] = d_output->real[OUT_MEASURED] = next.output; /* hum adds to it */
    *d = next.state;
}

const struct fmu_model plant_model = {
    ACTUATOR,
    .identifier = "IT2Plant",
    .kind = FMU_PLANT,
    .table_hash = FMU_TABLE_HASH_PLANT,
    .input_start = FMU_PLANT_INPUT_START,
    .diverging = "displacement",
    .prepare = plant_prepare,
    .settle = actuator_settle,
    .start = plant_start,
    .start_tangent = plant_start_tangent,
    .tick = plant_tick,
    .short_tick = plant_short_tick,
    .ticks = plant_ticks,
    .explain = plant_explain,
    .tick_tangent = plant_tick_tangent,
};
