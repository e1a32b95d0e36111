/* The controller: a sampled PI controller with feedforward. It closes the loop around inverse and plant in
 * studies of feedback, and knows nothing of them.
 *
 * At every tick, with e = reference - displacement:
 *
 *     integral += integralGain * sampleTime * e
 *     voltage = feedforward + proportionalGain * e + integral, within voltageMin..voltageMax
 *
 * While the limit holds, the integral does not grow further into it. */
#include "controller.h"

#include <math.h>

#include "controller_table.h"

struct pi_state {
    double integral;
};

static bool pi_check(const struct fmu_model *model, const void *parameters, char *message, size_t size)
{
    const struct pi_parameters *p = parameters;

    (void)model;
    if (!(p->sampleTime >= 1e-9 && p->sampleTime <= 1e3))
        snprintf(message, size, "sampleTime is %g s; it must be 1e-9 to 1000 s", p->sampleTime);
    else if (!(p->voltageMin < p->voltageMax))
        snprintf(message, size, "voltageMin, %g V, must be below voltageMax, %g V", p->voltageMin,
                 p->voltageMax);
    else
        return true;
    return false;
}

static size_t pi_prepare(void *constants, const void *parameters)
{
    (void)constants, (void)parameters;
    return sizeof(struct pi_state);
}

/* Without fmin and fmax, which would be all that this FMU needs of libm. */
static double pi_limit(double voltage, const struct pi_parameters *p)
{
    return voltage < p->voltageMin ? p->voltageMin : voltage > p->voltageMax ? p->voltageMax : voltage;
}

static bool pi_start(const void *constants, void *state, const void *parameters, struct fmu_outputs *output,
                     char *message, size_t size)
{
    const struct pi_parameters *p = parameters;
    struct pi_state *s = state;

    (void)constants, (void)message, (void)size;
    s->integral = p->initialVoltage;
    output->real[OUT_VOLTAGE] = pi_limit(p->initialVoltage, p);
    output->flag[OUT_LIMITED] = 0;
    return true;
}

static unsigned pi_tick(const void *constants, void *state, const void *parameters,
                        const double input[FMU_INPUTS], double time, struct fmu_outputs *output)
{
    const struct pi_parameters *p = parameters;
    struct pi_state *s = state;
    const double error = input[IN_REFERENCE] - input[IN_DISPLACEMENT];
    const double integral = s->integral + p->integralGain * p->sampleTime * error;
    const double wanted = input[IN_FEEDFORWARD] + p->proportionalGain * error + integral;
    const double given = pi_limit(wanted, p);
    const bool deeper =
        (wanted > given && integral > s->integral) || (wanted < given && integral < s->integral);

    (void)constants, (void)time;
    if (!deeper)
        s->integral = integral;
    if (!isfinite(s->integral) || !isfinite(given))
        return FMU_NOT_FINITE;
    output->flag[OUT_LIMITED] = given != wanted;
    output->real[OUT_VOLTAGE] = given;
    return 0;
}

const struct fmu_model controller_model = {
    .identifier = "PIController",
    .table = CONTROLLER_TABLE,
    .rows = FMU_TABLE_ROWS,
    .kind = 1,
    .table_hash = FMU_TABLE_HASH,
    .input_start = FMU_INPUT_START,
    .parameters_size = sizeof(struct pi_parameters),
    .state_size = sizeof(struct pi_state),
    .diverging = "integral",
    .check = pi_check,
    .prepare = pi_prepare,
    .start = pi_start,
    .tick = pi_tick,
};
