#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fmu.h"
#include "fmu_table.h"

enum { VARIABLE_COUNT = sizeof FMU_TABLE / sizeof FMU_TABLE[0] };

static const char *const BASE_NAME[] = { "Real", "Integer", "Boolean", "String" };

const struct fmu_variable *fmu_find(const struct fmu_model *model, fmi2ValueReference reference)
{
    if (reference >= VARIABLE_COUNT || !(FMU_TABLE[reference].models & model->kind))
        return NULL;
    return &FMU_TABLE[reference];
}

const struct fmu_variable *fmu_find_parameter(const char *name, size_t length)
{
    for (int i = 0; i < VARIABLE_COUNT; i++)
        if (FMU_TABLE[i].causality == FMU_PARAMETER && strlen(FMU_TABLE[i].name) == length &&
            memcmp(FMU_TABLE[i].name, name, length) == 0)
            return &FMU_TABLE[i];
    return NULL;
}

void fmu_inputs_start(struct fmu_inputs *inputs)
{
    *inputs = FMU_INPUT_START;
}

static void *at(struct fmu_values *values, const struct fmu_variable *variable)
{
    return (char *)values + variable->offset;
}

/* Elements of a group beyond its count are in the table but not in use. */
static bool in_use(const struct fmu_variable *variable, const struct fmu_values *values)
{
    return variable->index == 0 || variable->index <= *(const int *)((const char *)values + variable->count);
}

bool fmu_within_bounds(const struct chain_parameters *parameters, char *message, size_t size)
{
    struct fmu_values values = { .parameter = *parameters };

    for (int i = 0; i < VARIABLE_COUNT; i++) {
        const struct fmu_variable *v = &FMU_TABLE[i];
        if (v->causality != FMU_PARAMETER || !in_use(v, &values))
            continue;
        const double value = v->base == FMU_REAL ? *(double *)at(&values, v) : *(int *)at(&values, v);
        if (!(value >= v->minimum && value <= v->maximum)) {
            snprintf(message, size, "%s is %g; it must be %g to %g", v->name, value, v->minimum,
                     v->maximum);
            return false;
        }
    }
    return true;
}

/* An Integer is the number of rules, play operators or creep terms: as many as the set that the FMU was
 * packaged with has, or fewer. Of more the XML lists nothing. */
static bool count_possible(const struct fmu *fmu, const struct fmu_variable *variable, int count,
                           char *message, size_t size)
{
    struct fmu_values own = { .parameter = fmu->start };
    const int most = *(const int *)at(&own, variable);

    if (count >= variable->minimum && count <= most)
        return true;
    if (count > most && most < variable->maximum)
        snprintf(message, size, "%s is %d, but this FMU was packaged with %d; for more, package a parameter "
                 "set that has more (it2hys package)", variable->name, count, most);
    else
        snprintf(message, size, "%s is %d; it must be %g to %d", variable->name, count, variable->minimum,
                 most);
    return false;
}

bool fmu_values_possible(const struct fmu *fmu, const struct fmu_values *values, char *message, size_t size)
{
    struct fmu_values copy = *values;

    for (int i = 0; i < VARIABLE_COUNT; i++) {
        const struct fmu_variable *v = &FMU_TABLE[i];
        const void *value = at(&copy, v);
        if (v->base == FMU_INTEGER && !count_possible(fmu, v, *(const int *)value, message, size))
            return false;
        if ((v->base == FMU_REAL && !isfinite(*(const double *)value)) ||
            (v->base == FMU_BOOLEAN && (unsigned)*(const int *)value > 1u)) {
            snprintf(message, size, "%s has no finite value", v->name);
            return false;
        }
    }
    return true;
}

/* The variable behind a reference, if it is one of the right type; otherwise says why not. */
static const struct fmu_variable *lookup(const struct fmu *fmu, const char *function,
                                         enum fmu_base base, fmi2ValueReference reference)
{
    const struct fmu_variable *variable = fmu_find(fmu->model, reference);

    if (!variable) {
        fmu_say(fmu, fmi2Error, "%s: %s has no variable with the value reference %u.", function,
                fmu->model->identifier, reference);
        return NULL;
    }
    if (variable->base != base) {
        fmu_say(fmu, fmi2Error, "%s: variable %s is of type %s, not %s.", function, variable->name,
                BASE_NAME[variable->base], BASE_NAME[base]);
        return NULL;
    }
    return variable;
}

/* The variable behind a reference that lookup has accepted. */
static const struct fmu_variable *accepted(fmi2ValueReference reference)
{
    return &FMU_TABLE[reference];
}

static bool null_arrays(const struct fmu *fmu, const char *function, const void *references,
                        const void *values, size_t count)
{
    if (count == 0 || (references && values))
        return false;
    fmu_say(fmu, fmi2Error, "%s: an array is a null pointer.", function);
    return true;
}

fmi2Status fmu_get(struct fmu *fmu, const char *function, enum fmu_base base,
                   const fmi2ValueReference references[], size_t count, void *values)
{
    if (!fmu_may(fmu, function, FMU_INITIALIZATION | FMU_STEP_COMPLETE | FMU_TERMINATED) ||
        null_arrays(fmu, function, references, values, count))
        return fmi2Error;
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = lookup(fmu, function, base, references[i]);
        if (!v)
            return fmi2Error;
        if (v->causality == FMU_OUTPUT && fmu_start_outputs(fmu, function) != fmi2OK)
            return fmi2Error;
        if (base == FMU_REAL)
            ((double *)values)[i] = *(double *)at(&fmu->now.values, v);
        else
            ((int *)values)[i] = *(int *)at(&fmu->now.values, v);
    }
    return fmi2OK;
}

/* May this variable be set now? Otherwise says why not. */
static bool settable(const struct fmu *fmu, const char *function, const struct fmu_variable *variable)
{
    if (variable->causality == FMU_OUTPUT) {
        fmu_say(fmu, fmi2Error, "%s: %s is an output; it cannot be set.", function, variable->name);
        return false;
    }
    if (variable->causality == FMU_PARAMETER && fmu->now.phase == FMU_STEP_COMPLETE) {
        fmu_say(fmu, fmi2Error,
                "%s: %s is a fixed parameter; set it before fmi2ExitInitializationMode.", function,
                variable->name);
        return false;
    }
    return true;
}

fmi2Status fmu_set(struct fmu *fmu, const char *function, enum fmu_base base,
                   const fmi2ValueReference references[], size_t count, const void *values)
{
    char message[256];

    if (!fmu_may(fmu, function, FMU_INSTANTIATED | FMU_INITIALIZATION | FMU_STEP_COMPLETE) ||
        null_arrays(fmu, function, references, values, count))
        return fmi2Error;
    for (size_t i = 0; i < count; i++) { /* all are checked before any is set */
        const struct fmu_variable *v = lookup(fmu, function, base, references[i]);
        if (!v || !settable(fmu, function, v))
            return fmi2Error;
        if (base == FMU_REAL && !isfinite(((const double *)values)[i]))
            return fmu_say(fmu, fmi2Discard,
                           "%s: %s must be a finite number, not %g; it keeps its last value.", function,
                           v->name, ((const double *)values)[i]);
        if (base == FMU_INTEGER &&
            !count_possible(fmu, v, ((const int *)values)[i], message, sizeof message))
            return fmu_say(fmu, fmi2Error, "%s: %s.", function, message);
    }
    for (size_t i = 0; i < count; i++) {
        void *target = at(&fmu->now.values, accepted(references[i]));
        if (base == FMU_REAL)
            *(double *)target = ((const double *)values)[i];
        else
            *(int *)target = ((const int *)values)[i];
    }
    fmu->outputs_stale |= fmu->now.phase != FMU_STEP_COMPLETE;
    return fmi2OK;
}

/* Is one Real asked for, of one of these causalities (bits), in one of these phases? Then nothing else can
 * be in the way. What an FMI layer costs a tick is in such checks, so here they are once more in short. */
static inline bool one_real(const struct fmu *fmu, unsigned phases, unsigned causalities,
                            const fmi2ValueReference references[], size_t count, const double values[])
{
    if (!fmu || count != 1 || !references || !values || !((unsigned)fmu->now.phase & phases))
        return false;
    const struct fmu_variable *v = fmu_find(fmu->model, references[0]);
    return v && v->base == FMU_REAL && causalities >> v->causality & 1u;
}

fmi2Status fmu_get_real(struct fmu *fmu, const fmi2ValueReference references[], size_t count,
                        double values[])
{
    if (!one_real(fmu, FMU_STEP_COMPLETE, 1u << FMU_OUTPUT, references, count, values))
        return fmu_get(fmu, "fmi2GetReal", FMU_REAL, references, count, values);
    *values = *(const double *)at(&fmu->now.values, accepted(references[0]));
    return fmi2OK;
}

fmi2Status fmu_set_real(struct fmu *fmu, const fmi2ValueReference references[], size_t count,
                        const double values[])
{
    if (!one_real(fmu, FMU_STEP_COMPLETE, 1u << FMU_INPUT, references, count, values) || !isfinite(*values))
        return fmu_set(fmu, "fmi2SetReal", FMU_REAL, references, count, values);
    *(double *)at(&fmu->now.values, accepted(references[0])) = *values;
    return fmi2OK;
}

fmi2Status fmu_set_input_derivatives(struct fmu *fmu, const fmi2ValueReference references[],
                                     size_t count, const fmi2Integer order[], const double values[])
{
    static const char function[] = "fmi2SetRealInputDerivatives";

    if (!fmu_may(fmu, function, FMU_INSTANTIATED | FMU_INITIALIZATION | FMU_STEP_COMPLETE) ||
        null_arrays(fmu, function, references, values, count) ||
        null_arrays(fmu, function, references, order, count))
        return fmi2Error;
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = lookup(fmu, function, FMU_REAL, references[i]);
        if (!v)
            return fmi2Error;
        if (v->causality != FMU_INPUT)
            return fmu_say(fmu, fmi2Error, "%s: %s is not an input.", function, v->name);
        if (order[i] != 1)
            return fmu_say(fmu, fmi2Error,
                           "%s: order %d of %s; inputs are interpolated linearly, from order 1 only.",
                           function, order[i], v->name);
        if (!isfinite(values[i]))
            return fmu_say(fmu, fmi2Discard,
                           "%s: the derivative of %s must be a finite number, not %g; it keeps its "
                           "last value.", function, v->name, values[i]);
    }
    for (size_t i = 0; i < count; i++) {
        const size_t place = accepted(references[i])->offset - offsetof(struct fmu_values, input);
        *(double *)((char *)&fmu->now.slope + place) = values[i];
    }
    return fmi2OK;
}

fmi2Status fmu_get_output_derivatives(struct fmu *fmu)
{
    if (!fmu_may(fmu, "fmi2GetRealOutputDerivatives", FMU_STEP_COMPLETE | FMU_TERMINATED))
        return fmi2Error;
    return fmu_say(fmu, fmi2Error,
                   "fmi2GetRealOutputDerivatives: outputs are held between ticks and have no "
                   "derivatives (maxOutputDerivativeOrder is 0).");
}
