/* Time. Ticks are at k * sampleTime and counted as integers. fmi2DoStep(t, h) runs the ticks in
 * [t, t + h), each with the input at its own time; outputs hold their value from tick to tick. */
#include <math.h>
#include <string.h>

#include "fmu.h"

/* Masters add up floating-point time. A tick that lies this close behind a communication point (in
 * sample times, plus what rounding does to large times) is taken to lie at it. */
#define TIME_TOLERANCE 1e-3 /* a million additions of 1e-4 s end 2e-5 sample times late */

/* Beyond this, ticks are no longer exact in a double. */
#define LARGEST_TICK 9007199254740992.0

/* A derivative repeats the ticks of the last step, and a state that was not made here may claim any
 * number of them. */
#define LONGEST_DERIVATIVE 1000000

/* How much a time, in units of one sample time, may be off. */
static double tolerance(double ticks)
{
    return TIME_TOLERANCE + 1e-14 * fabs(ticks);
}

/* The first tick at or after a time in units of one sample time, not beyond LARGEST_TICK. ceil and its kin
 * are calls where the compiler may not assume a recent processor: written out. */
static int64_t first_tick(double ticks)
{
    const double due = ticks - tolerance(ticks);
    const int64_t whole = (int64_t)due;

    return whole + (due > (double)whole);
}

int64_t fmu_first_tick(double time, double sample_time)
{
    const double ticks = time / sample_time;

    if (!(ticks > -LARGEST_TICK && ticks < LARGEST_TICK))
        return ticks > 0.0 ? (int64_t)LARGEST_TICK : -(int64_t)LARGEST_TICK;
    return first_tick(ticks);
}

static struct fmu_inputs inputs_at(const struct fmu_span *step, double time)
{
    struct fmu_inputs input = step->input;
    const double elapsed = time - step->start;

    input.voltage += step->slope.voltage * elapsed;
    input.reference += step->slope.reference * elapsed;
    input.force += step->slope.force * elapsed;
    input.temperature += step->slope.temperature * elapsed;
    input.time = time;
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

/* Runs the ticks up to `end_tick` in place; returns findings. What a step of one tick costs is the way
 * from the state of the last tick to the next, and each copy between would lengthen it. */
static unsigned run(struct fmu *fmu, double start, int64_t end_tick)
{
    struct fmu_snapshot *now = &fmu->now;
    struct fmu_inputs *input = &now->values.input;
    const double sample_time = now->values.parameter.sampleTime;
    unsigned findings = 0;

    if (is_zero(&now->slope)) {
        for (int64_t tick = now->next_tick; tick < end_tick; tick++) {
            input->time = (double)tick * sample_time;
            findings |= fmu->model->tick(&fmu->chain, &now->chain, &now->values.parameter, input,
                                         &now->values.output);
        }
        return findings;
    }
    const struct fmu_span span = { .start = start, .input = *input, .slope = now->slope };
    for (int64_t tick = now->next_tick; tick < end_tick; tick++) {
        const struct fmu_inputs at_tick = inputs_at(&span, (double)tick * sample_time);
        findings |= fmu->model->tick(&fmu->chain, &now->chain, &now->values.parameter, &at_tick,
                                     &now->values.output);
    }
    return findings;
}

bool fmu_outputs_finite(const struct fmu_outputs *output)
{
    return isfinite(output->displacement) && isfinite(output->measured) && isfinite(output->voltage);
}

/* Logs findings that are new: each once in an instance's life, so that a log is not flooded. */
static fmi2Status warn(struct fmu *fmu, unsigned findings, double time)
{
    static const struct {
        unsigned finding;
        const char *text;
    } WARNINGS[] = {
        { FMU_VOLTAGE_RANGE, "the voltage left voltageMin..voltageMax, the range that the parameters "
                             "are valid for" },
        { FMU_DISPLACEMENT_RANGE, "the displacement left displacementMin..displacementMax, the range "
                                  "in which the model is contracting" },
        { FMU_OUT_OF_REACH, "the reference left displacementMin..displacementMax; the nearest "
                            "displacement within is aimed at (saturated is true)" },
        { FMU_AMPLIFIER_LIMIT, "the reference asks for more than slew.rate or saturation.minimum.."
                               "saturation.maximum let through; the nearest voltage is given "
                               "(saturated is true)" },
    };
    const struct chain_parameters *p = &fmu->now.values.parameter;
    const unsigned fresh = findings & ~fmu->now.warned;

    fmu->now.warned |= findings;
    if (fresh & FMU_VOLTAGE_LIMIT)
        fmu_say(fmu, fmi2Warning, "fmi2DoStep to %g s: the reference asks for a voltage outside voltageMin.."
                "voltageMax, %g V to %g V; the nearest is given (saturated is true). This is said once.",
                time, p->voltageMin, p->voltageMax);
    for (size_t i = 0; i < sizeof WARNINGS / sizeof WARNINGS[0]; i++)
        if (fresh & WARNINGS[i].finding)
            fmu_say(fmu, fmi2Warning, "fmi2DoStep to %g s: %s. This is said once.", time,
                    WARNINGS[i].text);
    return fmi2Warning;
}

/* A step as asked for, in units of one sample time where a name says ticks. */
struct request {
    double time;
    double step;
    double end;
    double end_ticks;
    double slack;
};

static struct request request_of(const struct fmu *fmu, double time, double step)
{
    const double sample_time = fmu->now.values.parameter.sampleTime;
    const double end = time + step;
    const double end_ticks = end / sample_time;

    return (struct request){ time, step, end, end_ticks, sample_time * tolerance(end_ticks) };
}

/* False where anything is not a number: fewer comparisons than reasons. */
static bool step_possible(const struct fmu_snapshot *now, const struct request *r)
{
    return r->step >= 0.0 && fabs(r->time - now->time) <= r->slack && fabs(r->end_ticks) < LARGEST_TICK &&
           !(now->stop_time_defined && r->end > now->stop_time + r->slack);
}

/* Says why a step is not possible. */
static fmi2Status refuse_step(const struct fmu *fmu, const struct request *r)
{
    const struct fmu_snapshot *now = &fmu->now;

    if (!isfinite(r->time) || !isfinite(r->step) || r->step < 0.0)
        return fmu_say(fmu, fmi2Error, "fmi2DoStep: a step of %g s from %g s is not possible; both must be "
                       "finite and the step not negative.", r->step, r->time);
    if (fabs(r->time - now->time) > r->slack)
        return fmu_say(fmu, fmi2Error, "fmi2DoStep: the step begins at %.17g s, but this instance is at "
                       "%.17g s; to go back, set an earlier FMU state.", r->time, now->time);
    if (now->stop_time_defined && r->end > now->stop_time + r->slack)
        return fmu_say(fmu, fmi2Error, "fmi2DoStep: the step ends at %.17g s, after stopTime, %.17g s.",
                       r->end, now->stop_time);
    return fmu_say(fmu, fmi2Error, "fmi2DoStep: at %g s ticks of %g s can no longer be counted.", r->end,
                   now->values.parameter.sampleTime);
}

fmi2Status fmu_do_step(struct fmu *fmu, double time, double step)
{
    struct chain_state before;

    if (!fmu_may(fmu, "fmi2DoStep", FMU_STEP_COMPLETE))
        return fmi2Error;
    struct fmu_snapshot *now = &fmu->now;
    const struct request request = request_of(fmu, time, step);
    if (!step_possible(now, &request))
        return refuse_step(fmu, &request);
    const struct fmu_outputs held = now->values.output;
    const double input_time = now->values.input.time;
    const int64_t due = first_tick(request.end_ticks);
    const int64_t end_tick = due < now->next_tick ? now->next_tick : due;

    chain_copy(&fmu->chain, &before, &now->chain);
    const unsigned findings = run(fmu, time, end_tick);
    if (!fmu_outputs_finite(&now->values.output)) {
        chain_copy(&fmu->chain, &now->chain, &before);
        now->values.output = held;
        now->values.input.time = input_time;
        now->last_status = fmi2Discard;
        return fmu_say(fmu, fmi2Discard, "fmi2DoStep: the %s is no longer finite between %g s and %g s; "
                       "the step is not made and the state is that of %g s.",
                       fmu->model->kind == FMU_PLANT ? "displacement" : "voltage", time, request.end,
                       time);
    }
    chain_copy(&fmu->chain, &now->last_step.chain, &before);
    now->last_step.span.start = time;
    now->last_step.span.first_tick = now->next_tick;
    now->last_step.span.end_tick = end_tick;
    now->last_step.span.input = now->values.input;
    now->last_step.span.slope = now->slope;
    now->next_tick = end_tick;
    now->time = request.end;
    const fmi2Status status = findings & ~now->warned ? warn(fmu, findings, now->time) : fmi2OK;
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
        const struct fmu_inputs input = inputs_at(step, (double)tick * parameters->sampleTime);
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
        *(double *)value = fmu->now.time;
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
