#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fmu.h"

static const char *const BASE_NAME[] = { "Real", "Integer", "Boolean", "String" };

const struct fmu_variable *fmu_find_parameter(const struct fmu_model *model, const char *name, size_t length)
{
    for (unsigned i = 0; i < model->rows; i++) {
        const struct fmu_variable *v = fmu_find(model, i);
        if (v && v->causality == FMU_PARAMETER && strlen(v->name) == length &&
            memcmp(v->name, name, length) == 0)
            return v;
    }
    return NULL;
}

static void *at(const struct fmu *fmu, const struct fmu_variable *variable)
{
    char *const base = variable->causality == FMU_OUTPUT  ? (char *)&fmu->now->output
                       : variable->causality == FMU_INPUT ? (char *)fmu->now->input
                                                          : (char *)fmu->parameters;

    return base + variable->offset;
}

static int integer(const void *parameters, size_t offset)
{
    return *(const int *)((const char *)parameters + offset);
}

static double real_at(const void *parameters, size_t offset)
{
    return *(const double *)((const char *)parameters + offset);
}

/* Elements of a group beyond its count are in the table but not in use. */
static bool in_use(const struct fmu_variable *variable, const void *parameters)
{
    return variable->index == 0 || variable->index <= integer(parameters, variable->count);
}

bool fmu_within_bounds(const struct fmu_model *model, const void *parameters, char *message, size_t size)
{
    for (unsigned i = 0; i < model->rows; i++) {
        const struct fmu_variable *v = fmu_find(model, i);
        if (!v || v->causality != FMU_PARAMETER || !in_use(v, parameters))
            continue;
        const double value =
            v->base == FMU_REAL ? real_at(parameters, v->offset) : integer(parameters, v->offset);
        if (!(value >= v->minimum && value <= v->maximum)) {
            snprintf(message, size, "%s is %g; it must be %g to %g", v->name, value, v->minimum, v->maximum);
            return false;
        }
    }
    return true;
}

/* An Integer is the number of rules, play operators or creep terms: as many as the set that the FMU was
 * packaged with has, or fewer. Of more the XML lists nothing, unless it lists arrays. */
static bool count_possible(const struct fmu *fmu, const struct fmu_variable *variable, int count, char *message,
                           size_t size)
{
    const int most = fmu->host.resizes ? (int)variable->maximum : integer(fmu->start, variable->offset);

    if (count >= variable->minimum && count <= most)
        return true;
    if (count > most && most < variable->maximum)
        snprintf(message, size,
                 "%s is %d, but this FMU was packaged with %d; for more, package a parameter "
                 "set that has more (it2hys package)",
                 variable->name, count, most);
    else
        snprintf(message, size, "%s is %d; it must be %g to %d", variable->name, count, variable->minimum,
                 most);
    return false;
}

static bool outputs_possible(const struct fmu_outputs *output)
{
    bool possible = true;

    for (int i = 0; i < FMU_REAL_OUTPUTS; i++)
        possible &= isfinite(output->real[i]) != 0;
    for (int i = 0; i < FMU_FLAGS; i++)
        possible &= (unsigned)output->flag[i] <= 1u;
    return possible;
}

bool fmu_values_possible(const struct fmu *fmu, const struct fmu_snapshot *snapshot, const void *parameters,
                         char *message, size_t size)
{
    for (unsigned i = 0; i < fmu->model->rows; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, i);
        if (!v || v->causality != FMU_PARAMETER)
            continue;
        if (v->base == FMU_INTEGER && !count_possible(fmu, v, integer(parameters, v->offset), message, size))
            return false;
        if (v->base == FMU_REAL && !isfinite(real_at(parameters, v->offset))) {
            snprintf(message, size, "%s has no finite value", v->name);
            return false;
        }
    }
    if (outputs_possible(&snapshot->output))
        return true;
    snprintf(message, size, "an output has no finite value");
    return false;
}

/* The variable behind a reference, if it is one of the right type; otherwise says why not. */
static const struct fmu_variable *lookup(const struct fmu *fmu, const char *function, enum fmu_base base,
                                         unsigned reference)
{
    const struct fmu_variable *variable = fmu_find(fmu->model, reference);

    if (!variable) {
        fmu_say(fmu, FMU_ERROR, "%s: %s has no variable with the value reference %u.", function,
                fmu->model->identifier, reference);
        return NULL;
    }
    if (variable->base != base) {
        fmu_say(fmu, FMU_ERROR, "%s: variable %s is of type %s, not %s.", function, variable->name,
                BASE_NAME[variable->base], BASE_NAME[base]);
        return NULL;
    }
    return variable;
}

/* The variable behind a reference that lookup has accepted. */
static const struct fmu_variable *accepted(const struct fmu *fmu, unsigned reference)
{
    return &fmu->model->table[reference];
}

bool fmu_null_arrays(const struct fmu *fmu, const char *function, const void *references, const void *values,
                     size_t count)
{
    if (count == 0 || (references && values))
        return false;
    fmu_say(fmu, FMU_ERROR, "%s: an array is a null pointer.", function);
    return true;
}

enum fmu_status fmu_get(struct fmu *fmu, const char *function, enum fmu_base base, const unsigned references[],
                        size_t count, void *values)
{
    if (!fmu_may(fmu, function, FMU_INITIALIZATION | FMU_INITIALIZED | (fmu ? fmu->host.reads : 0)) ||
        fmu_null_arrays(fmu, function, references, values, count))
        return FMU_ERROR;
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = lookup(fmu, function, base, references[i]);
        if (!v)
            return FMU_ERROR;
        if (v->causality == FMU_OUTPUT && fmu_start_outputs(fmu, function) != FMU_OK)
            return FMU_ERROR;
        if (base == FMU_REAL)
            ((double *)values)[i] = *(double *)at(fmu, v);
        else
            ((int *)values)[i] = *(int *)at(fmu, v);
    }
    return FMU_OK;
}

/* May this variable be set now? Otherwise says why not. */
static bool settable(const struct fmu *fmu, const char *function, const struct fmu_variable *variable)
{
    if (variable->causality == FMU_OUTPUT) {
        fmu_say(fmu, FMU_ERROR, "%s: %s is an output; it cannot be set.", function, variable->name);
        return false;
    }
    if (variable->causality == FMU_PARAMETER && fmu->now->phase & FMU_INITIALIZED) {
        fmu_say(fmu, FMU_ERROR, "%s: %s is a fixed parameter; set it before initialization ends.", function,
                variable->name);
        return false;
    }
    const bool structural = variable->base == FMU_INTEGER && fmu->host.resizes;
    if (structural == (fmu->now->phase == FMU_CONFIGURATION))
        return true;
    fmu_say(fmu, FMU_ERROR, "%s: %s is %s structural parameter; these alone are set in configurationMode.",
            function, variable->name, structural ? "a" : "no");
    return false;
}

enum fmu_status fmu_set(struct fmu *fmu, const char *function, enum fmu_base base, const unsigned references[],
                        size_t count, const void *values)
{
    char message[256];

    if (!fmu_may(fmu, function,
                 FMU_INSTANTIATED | FMU_CONFIGURATION | FMU_INITIALIZATION | FMU_STEP_COMPLETE | FMU_UPDATE) ||
        fmu_null_arrays(fmu, function, references, values, count))
        return FMU_ERROR;
    for (size_t i = 0; i < count; i++) { /* all are checked before any is set */
        const struct fmu_variable *v = lookup(fmu, function, base, references[i]);
        if (!v || !settable(fmu, function, v))
            return FMU_ERROR;
        if (base == FMU_REAL && !isfinite(((const double *)values)[i]))
            return fmu_say(fmu, FMU_DISCARD, "%s: %s must be a finite number, not %g; it keeps its last value.",
                           function, v->name, ((const double *)values)[i]);
        if (base == FMU_INTEGER && !count_possible(fmu, v, ((const int *)values)[i], message, sizeof message))
            return fmu_say(fmu, FMU_ERROR, "%s: %s.", function, message);
    }
    for (size_t i = 0; i < count; i++) {
        void *target = at(fmu, accepted(fmu, references[i]));
        if (base == FMU_REAL)
            *(double *)target = ((const double *)values)[i];
        else
            *(int *)target = ((const int *)values)[i];
    }
    fmu->outputs_stale |= !(fmu->now->phase & FMU_INITIALIZED);
    return FMU_OK;
}

enum fmu_status fmu_set_input_derivatives(struct fmu *fmu, const char *function, const unsigned references[],
                                          size_t count, const int order[], const double values[])
{
    if (!fmu_may(fmu, function, FMU_INSTANTIATED | FMU_INITIALIZATION | FMU_STEP_COMPLETE))
        return FMU_ERROR;
    if (!fmu->model->interpolates)
        return fmu_lacks(fmu, function);
    if (fmu_null_arrays(fmu, function, references, values, count) ||
        fmu_null_arrays(fmu, function, references, order, count))
        return FMU_ERROR;
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = lookup(fmu, function, FMU_REAL, references[i]);
        if (!v)
            return FMU_ERROR;
        if (v->causality != FMU_INPUT)
            return fmu_say(fmu, FMU_ERROR, "%s: %s is not an input.", function, v->name);
        if (order[i] != 1)
            return fmu_say(fmu, FMU_ERROR,
                           "%s: order %d of %s; inputs are interpolated linearly, from order 1 only.", function,
                           order[i], v->name);
        if (!isfinite(values[i]))
            return fmu_say(fmu, FMU_DISCARD,
                           "%s: the derivative of %s must be a finite number, not %g; it keeps its "
                           "last value.",
                           function, v->name, values[i]);
    }
    for (size_t i = 0; i < count; i++)
        *(double *)((char *)fmu->now->slope + accepted(fmu, references[i])->offset) = values[i];
    fmu_note_ramps(fmu);
    return FMU_OK;
}
