/* fmi2DoStep and its derivatives. Which ticks a step has is the clock's (fmu_clock.h); each runs with the
 * input at its own time, and outputs hold their value from tick to tick. */
#include <math.h>
#include <string.h>

#include "fmu.h"

/* A derivative repeats the ticks of the last step. */
#define LONGEST_DERIVATIVE 1000000

static struct fmu_inputs inputs_at(const struct fmu_span *span, int64_t tick, double sample_time)
{
    struct fmu_inputs input = span->input;
    const double elapsed = ((double)(tick - span->tick) - span->rest) * sample_time;

    input.voltage += span->slope.voltage * elapsed;
    input.reference += span->slope.reference * elapsed;
    input.force += span->slope.force * elapsed;
    input.temperature += span->slope.temperature * elapsed;
    input.time = (double)tick * sample_time;
    return input;
}

/* No bit but the signs': one comparison instead of four, at every step. */
static bool is_zero(const struct fmu_inputs *slope)
{
    const double value[] = { slope->voltage, slope->reference, slope->force, slope->temperature };
    uint64_t bits[4];

    memcpy(bits, value, sizeof bits);
    return (bits[0] | bits[1] | bits[2] | bits[3]) << 1 == 0;
}

/* Logs what a tick is the first to find: each finding once in an instance's life, so that a log is not
 * flooded. */
static fmi2Status warn(struct fmu *fmu, unsigned findings, const struct fmu_inputs *input)
{
    static const char once[] = "This is logged once.";
    const bool plant = fmu->model->kind == FMU_PLANT;
    const struct chain_parameters *p = &fmu->now.values.parameter;
    const double time = input->time;
    const double reference = 1e6 * input->reference;
    const double voltage = plant ? input->voltage : fmu->now.values.output.voltage;
    const double low = 1e6 * p->displacementMin;
    const double high = 1e6 * p->displacementMax;

    if (findings & FMU_VOLTAGE_RANGE)
        fmu_say(fmu, fmi2Warning, "fmi2DoStep: the voltage left voltageMin..voltageMax, %g to %g V, the range "
                "that the parameters are valid for: it is %g V at %g s%s. %s", p->voltageMin,
                p->voltageMax, voltage, time, plant ? "; outOfRange is true as long as it is outside" : "", once);
    if (findings & FMU_DISPLACEMENT_RANGE)
        fmu_say(fmu, fmi2Warning, "fmi2DoStep: the core's displacement left displacementMin..displacementMax, "
                "%g to %g um, the range that its rules hold for: it is %g um at %g s. Outside the model is "
                "extrapolated; outOfRange is true there. %s", low, high, 1e6 * fmu->now.chain.core.y, time,
                once);
    if (findings & FMU_OUT_OF_REACH)
        fmu_say(fmu, fmi2Warning, "fmi2DoStep: the reference, %g um at %g s, is outside displacementMin.."
                "displacementMax, %g to %g um; the nearest displacement within is aimed at (saturated is "
                "true). %s", reference, time, low, high, once);
    if (findings & FMU_AMPLIFIER_LIMIT)
        fmu_say(fmu, fmi2Warning, "fmi2DoStep: the reference, %g um at %g s, asks for more than slew.rate or "
                "saturation.minimum..saturation.maximum let through; the nearest voltage is given, %g V "
                "(saturated is true). %s", reference, time, voltage, once);
    if (findings & FMU_VOLTAGE_LIMIT)
        fmu_say(fmu, fmi2Warning, "fmi2DoStep: the reference, %g um at %g s, asks for a voltage outside "
                "voltageMin..voltageMax, %g to %g V; the nearest is given (saturated is true). %s", reference,
                time, p->voltageMin, p->voltageMax, once);
    fmu->now.warned |= findings;
    return fmi2Warning;
}

static inline void run_tick(struct fmu *fmu, const struct fmu_inputs *input, fmi2Status *status)
{
    struct fmu_snapshot *now = &fmu->now;
    const unsigned findings = fmu->model->tick(&fmu->chain, &now->chain, &now->values.parameter, input,
                                               &now->values.output);

    if (findings & ~now->warned)
        *status = warn(fmu, findings & ~now->warned, input);
}

/* Runs the ticks up to `end_tick` in place. What a step of one tick costs is the way from the state of the
 * last tick to the next, and each copy between would lengthen it. */
static fmi2Status run(struct fmu *fmu, int64_t end_tick)
{
    struct fmu_snapshot *now = &fmu->now;
    struct fmu_inputs *input = &now->values.input;
    const int64_t first_tick = now->clock.next_tick;
    const double sample_time = now->values.parameter.sampleTime;
    fmi2Status status = fmi2OK;

    if (is_zero(&now->slope)) {
        for (int64_t tick = first_tick; tick < end_tick; tick++) {
            input->time = (double)tick * sample_time;
            run_tick(fmu, input, &status);
        }
        return status;
    }
    const struct fmu_span span = {
        .tick = now->clock.tick, .rest = now->clock.rest, .input = *input, .slope = now->slope
    };
    for (int64_t tick = first_tick; tick < end_tick; tick++) {
        const struct fmu_inputs at_tick = inputs_at(&span, tick, sample_time);
        run_tick(fmu, &at_tick, &status);
    }
    return status;
}

bool fmu_outputs_finite(const struct fmu_outputs *output)
{
    return isfinite(output->displacement) && isfinite(output->measured) && isfinite(output->voltage);
}

fmi2Status fmu_do_step(struct fmu *fmu, double time, double step)
{
    struct chain_state before;
    struct fmu_clock end;
    char message[256];

    if (!fmu_may(fmu, "fmi2DoStep", FMU_STEP_COMPLETE))
        return fmi2Error;
    struct fmu_snapshot *now = &fmu->now;
    const double sample_time = now->values.parameter.sampleTime;
    if (!fmu_clock_step(&now->clock, sample_time, time, step, &end))
        return fmu_say(fmu, fmi2Error, "fmi2DoStep: %s.",
                       fmu_clock_refusal(&now->clock, sample_time, time, step, message, sizeof message));
    const struct fmu_outputs held = now->values.output;
    const double input_time = now->values.input.time;
    const unsigned warned = now->warned;

    chain_copy(&fmu->chain, &before, &now->chain);
    const fmi2Status status = run(fmu, end.next_tick);
    if (!fmu_outputs_finite(&now->values.output)) {
        chain_copy(&fmu->chain, &now->chain, &before);
        now->values.output = held;
        now->values.input.time = input_time;
        now->warned = warned;
        now->last_status = fmi2Discard;
        return fmu_say(fmu, fmi2Discard, "fmi2DoStep: the %s is no longer finite between %g s and %g s; "
                       "the step is not made and the state is that of %g s.",
                       fmu->model->kind == FMU_PLANT ? "displacement" : "voltage", time, end.time, time);
    }
    chain_copy(&fmu->chain, &now->last_step.chain, &before);
    now->last_step.span.tick = now->clock.tick;
    now->last_step.span.rest = now->clock.rest;
    now->last_step.span.first_tick = now->clock.next_tick;
    now->last_step.span.end_tick = end.next_tick;
    now->last_step.span.input = now->values.input;
    now->last_step.span.slope = now->slope;
    now->clock = end;
    now->last_status = (int)status;
    return status;
}

/* Adds seeds by value reference to a struct fmu_values of derivatives. */
static bool collect_seeds(const struct fmu *fmu, const fmi2ValueReference knowns[], size_t count,
                          const double seeds[], enum fmu_causality causality, struct fmu_values *d)
{
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, knowns[i]);
        const bool known = v && v->base == FMU_REAL &&
                           (v->causality == causality || v->causality == FMU_INPUT);
        if (!known) {
            fmu_say(fmu, fmi2Error, "fmi2GetDirectionalDerivative: %s is not a known here; knowns are "
                    "the inputs and, in initializationMode, the parameters.",
                    v ? v->name : "a value reference that does not exist");
            return false;
        }
        *(double *)((char *)d + v->offset) += seeds[i];
    }
    return true;
}

/* Derivatives of the outputs held now, with respect to the inputs that the last step ran with. */
static void last_step_tangent(const struct fmu *fmu, const struct fmu_inputs *d_input,
                              struct fmu_outputs *d_output)
{
    const struct fmu_span *step = &fmu->now.last_step.span;
    const struct chain_parameters *parameters = &fmu->now.values.parameter;
    struct chain_state state = fmu->now.last_step.chain;
    struct chain_state d_state = { 0 };
    struct fmu_outputs output;

    for (int64_t tick = step->first_tick; tick < step->end_tick; tick++) {
        const struct fmu_inputs input = inputs_at(step, tick, parameters->sampleTime);
        d_state = fmu->model->tick_tangent(&fmu->chain, &state, &input, d_state, d_input, d_output);
        fmu->model->tick(&fmu->chain, &state, parameters, &input, &output);
    }
}

fmi2Status fmu_directional_derivative(struct fmu *fmu, const fmi2ValueReference unknowns[],
                                      size_t unknown_count, const fmi2ValueReference knowns[],
                                      size_t known_count, const double seeds[], double values[])
{
    static const char function[] = "fmi2GetDirectionalDerivative";
    struct fmu_values d = { 0 };

    if (!fmu_may(fmu, function, FMU_INITIALIZATION | FMU_STEP_COMPLETE | FMU_TERMINATED))
        return fmi2Error;
    if ((unknown_count && (!unknowns || !values)) || (known_count && (!knowns || !seeds)))
        return fmu_say(fmu, fmi2Error, "%s: an array is a null pointer.", function);
    const bool starting = fmu->now.phase == FMU_INITIALIZATION;
    if (!collect_seeds(fmu, knowns, known_count, seeds, starting ? FMU_PARAMETER : FMU_INPUT, &d))
        return fmi2Error;
    for (size_t i = 0; i < unknown_count; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, unknowns[i]);
        if (!v || v->base != FMU_REAL || v->causality != FMU_OUTPUT)
            return fmu_say(fmu, fmi2Error, "%s: %s is not an unknown; unknowns are the Real outputs.",
                           function, v ? v->name : "a value reference that does not exist");
    }
    const struct fmu_span *last = &fmu->now.last_step.span;
    if (!starting && (double)last->end_tick - (double)last->first_tick > LONGEST_DERIVATIVE)
        return fmu_say(fmu, fmi2Discard, "%s: the last step has more than %d ticks; derivatives are "
                       "those of shorter ones.", function, LONGEST_DERIVATIVE);
    if (!starting)
        last_step_tangent(fmu, &d.input, &d.output);
    else if (fmu_start_outputs(fmu, function) != fmi2OK)
        return fmi2Error;
    else
        fmu->model->start_tangent(&fmu->chain, &fmu->now.chain, &fmu->now.values.parameter,
                                  &d.parameter, &d.output);
    for (size_t i = 0; i < unknown_count; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, unknowns[i]);
        const double value = *(double *)((char *)&d + v->offset);
        if (!isfinite(value))
            return fmu_say(fmu, fmi2Discard, "%s: the derivative of %s is no finite number for these "
                           "seeds.", function, v->name);
        values[i] = value;
    }
    return fmi2OK;
}

fmi2Status fmu_get_status(struct fmu *fmu, const char *function, fmi2StatusKind kind, void *value)
{
    if (!fmu_may(fmu, function, FMU_STEP_COMPLETE | FMU_TERMINATED))
        return fmi2Error;
    if (!value)
        return fmu_say(fmu, fmi2Error, "%s: value is a null pointer.", function);
    if (kind == fmi2DoStepStatus && strcmp(function, "fmi2GetStatus") == 0)
        *(fmi2Status *)value = (fmi2Status)fmu->now.last_status;
    else if (kind == fmi2LastSuccessfulTime && strcmp(function, "fmi2GetRealStatus") == 0)
        *(double *)value = fmu->now.clock.time;
    else if (kind == fmi2Terminated && strcmp(function, "fmi2GetBooleanStatus") == 0)
        *(int *)value = fmu->now.last_status == fmi2Discard; /* nor would a second try succeed */
    else if (kind == fmi2PendingStatus && strcmp(function, "fmi2GetStringStatus") == 0)
        *(fmi2String *)value = "";
    else
        return fmu_say(fmu, fmi2Discard, "%s: there is no status of kind %d.", function, (int)kind);
    return fmi2OK;
}

fmi2Status fmu_cancel_step(struct fmu *fmu)
{
    if (!fmu_may(fmu, "fmi2CancelStep", FMU_ANY_PHASE))
        return fmi2Error;
    return fmu_say(fmu, fmi2Error, "fmi2CancelStep: no step is in progress; fmi2DoStep returns when "
                   "its step is complete.");
}
