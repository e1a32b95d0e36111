/* Directional derivatives: of the outputs held now by the inputs that the last step ran with, and in
 * initialization by the parameters. */
#include <math.h>
#include <string.h>

#include "fmu.h"

/* A derivative repeats the ticks of the last step. */
#define LONGEST_DERIVATIVE 1000000

/* Adds seeds by value reference to derivatives of the inputs, and in initialization of the parameters. */
static bool collect_seeds(const struct fmu *fmu, const char *function, const unsigned knowns[], size_t count,
                          const double seeds[], bool starting, double d_input[FMU_INPUTS])
{
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, knowns[i]);
        const bool input = v && v->causality == FMU_INPUT;
        if (!v || v->base != FMU_REAL || !(input || (starting && v->causality == FMU_PARAMETER))) {
            fmu_say(fmu, FMU_ERROR,
                    "%s: %s cannot be a known; knowns are the inputs and, in "
                    "initializationMode, the parameters.",
                    function, v ? v->name : "a value reference that does not exist");
            return false;
        }
        *(double *)((input ? (char *)d_input : (char *)fmu->d_parameters) + v->offset) += seeds[i];
    }
    return true;
}

/* Of the outputs held now, by the inputs that the last step ran with. */
static void last_step_tangent(const struct fmu *fmu, const double d_input[FMU_INPUTS],
                              struct fmu_outputs *d_output)
{
    const struct fmu_model *model = fmu->model;
    const struct fmu_span step = fmu_last_step(fmu->now);
    const double sample_time = fmu_sample_time(fmu);
    double input[FMU_INPUTS];
    struct fmu_outputs output;

    memcpy(fmu->before, fmu->last_state, model->state_size);
    memset(fmu->d_state, 0, model->state_size);
    for (int64_t tick = step.first_tick; tick < step.end_tick; tick++) {
        const double time = (double)tick * sample_time;
        fmu_inputs_at(&step, tick, sample_time, input);
        model->tick_tangent(fmu->constants, fmu->before, input, time, fmu->d_state, d_input, d_output);
        model->tick(fmu->constants, fmu->before, fmu->parameters, input, time, &output);
    }
}

static bool unknowns_are_outputs(const struct fmu *fmu, const char *function, const unsigned unknowns[],
                                 size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, unknowns[i]);
        if (v && v->base == FMU_REAL && v->causality == FMU_OUTPUT)
            continue;
        fmu_say(fmu, FMU_ERROR, "%s: %s is not an unknown; unknowns are the Real outputs.", function,
                v ? v->name : "a value reference that does not exist");
        return false;
    }
    return true;
}

enum fmu_status fmu_directional_derivative(struct fmu *fmu, const char *function, const unsigned unknowns[],
                                           size_t unknown_count, const unsigned knowns[], size_t known_count,
                                           const double seeds[], double values[])
{
    double d_input[FMU_INPUTS] = { 0.0 };
    struct fmu_outputs d_output = { { 0.0 }, { 0 } };

    if (!fmu_may(fmu, function, FMU_INITIALIZATION | FMU_STEP_COMPLETE | FMU_TERMINATED))
        return FMU_ERROR;
    if (!fmu->model->tick_tangent)
        return fmu_lacks(fmu, function);
    if ((unknown_count && (!unknowns || !values)) || (known_count && (!knowns || !seeds)))
        return fmu_say(fmu, FMU_ERROR, "%s: an array is a null pointer.", function);
    const bool starting = fmu->now->phase == FMU_INITIALIZATION;
    memset(fmu->d_parameters, 0, fmu->model->parameters_size);
    if (!collect_seeds(fmu, function, knowns, known_count, seeds, starting, d_input) ||
        !unknowns_are_outputs(fmu, function, unknowns, unknown_count))
        return FMU_ERROR;
    const struct fmu_span last = fmu_last_step(fmu->now);
    if (!starting && (double)last.end_tick - (double)last.first_tick > LONGEST_DERIVATIVE)
        return fmu_say(fmu, FMU_DISCARD,
                       "%s: the last step has more than %d ticks; derivatives are "
                       "those of shorter ones.",
                       function, LONGEST_DERIVATIVE);
    if (!starting)
        last_step_tangent(fmu, d_input, &d_output);
    else if (fmu_start_outputs(fmu, function) != FMU_OK)
        return FMU_ERROR;
    else
        fmu->model->start_tangent(fmu->constants, fmu->state, fmu->parameters, fmu->d_parameters, &d_output);
    for (size_t i = 0; i < unknown_count; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, unknowns[i]);
        const double value = *(const double *)((const char *)&d_output + v->offset);
        if (!isfinite(value))
            return fmu_say(fmu, FMU_DISCARD,
                           "%s: the derivative of %s is no finite number for these "
                           "seeds.",
                           function, v->name);
        values[i] = value;
    }
    return FMU_OK;
}
