/* Groups of parameters as arrays. The table has a row for every element there may be; how many are in use is a
 * parameter, which a host that knows arrays sets before all others. */
#include <math.h>
#include <stdlib.h>

#include "fmu.h"

static bool has_structural_parameter(const struct fmu_model *model)
{
    for (unsigned i = 0; i < model->rows; i++) {
        const struct fmu_variable *v = fmu_find(model, i);
        if (v && v->base == FMU_INTEGER && v->causality == FMU_PARAMETER)
            return true;
    }
    return false;
}

enum fmu_status fmu_enter_configuration(struct fmu *fmu, const char *function)
{
    if (!fmu_may(fmu, function, FMU_INSTANTIATED))
        return FMU_ERROR;
    if (!has_structural_parameter(fmu->model))
        return fmu_say(fmu, FMU_ERROR, "%s: %s has no structural parameters.", function,
                       fmu->model->identifier);
    fmu->now->phase = FMU_CONFIGURATION;
    return FMU_OK;
}

enum fmu_status fmu_exit_configuration(struct fmu *fmu, const char *function)
{
    if (!fmu_may(fmu, function, FMU_CONFIGURATION))
        return FMU_ERROR;
    fmu->now->phase = FMU_INSTANTIATED;
    return FMU_OK;
}

/* How many values there are behind a reference: one of what is not there, too. */
static size_t length(const struct fmu *fmu, unsigned reference)
{
    const struct fmu_variable *v = fmu_find(fmu->model, reference);

    return v && v->index == 1 ? (size_t)*(const int *)((const char *)fmu->parameters + v->count) : 1;
}

/* Of what stands in an array, only the array has a reference that a host knows. */
static bool is_hidden(const struct fmu *fmu, unsigned reference)
{
    const struct fmu_variable *v = fmu_find(fmu->model, reference);

    return v && v->index > 1;
}

/* Do the references stand for so many values? */
static bool lengths_agree(const struct fmu *fmu, const char *function, const unsigned references[],
                          size_t count, size_t value_count)
{
    size_t total = 0;

    for (size_t i = 0; i < count; i++) {
        if (is_hidden(fmu, references[i])) {
            fmu_say(fmu, FMU_ERROR, "%s: %s has no variable with the value reference %u.", function,
                    fmu->model->identifier, references[i]);
            return false;
        }
        total += length(fmu, references[i]);
    }
    if (total == value_count)
        return true;
    fmu_say(fmu, FMU_ERROR, "%s: there are %zu values for variables that have %zu.", function, value_count,
            total);
    return false;
}

/* References of scalars: those given, or where arrays are among them the elements' in a block of their own. */
struct scalars {
    const unsigned *reference;
    size_t count;
    unsigned *block;
};

static bool expand(const struct fmu *fmu, const char *function, const unsigned references[], size_t count,
                   size_t value_count, struct scalars *scalars)
{
    *scalars = (struct scalars){ references, count, NULL };
    if (!lengths_agree(fmu, function, references, count, value_count))
        return false;
    if (value_count == 0)
        scalars->count = 0;
    bool arrays = false;
    for (size_t i = 0; i < count; i++)
        arrays |= length(fmu, references[i]) != 1;
    if (!arrays || value_count == 0)
        return true;
    unsigned *next = scalars->block = malloc(value_count * sizeof *next);
    if (!next) {
        fmu_say(fmu, FMU_ERROR, "%s: out of memory.", function);
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        const struct fmu_variable *v = fmu_find(fmu->model, references[i]);
        for (size_t k = 0; k < length(fmu, references[i]); k++)
            *next++ = references[i] + (v ? (unsigned)k * v->stride : 0);
    }
    scalars->reference = scalars->block;
    scalars->count = value_count;
    return true;
}

enum fmu_status fmu_get_arrays(struct fmu *fmu, const char *function, const unsigned references[], size_t count,
                               double values[], size_t value_count)
{
    if (!fmu_may(fmu, function, FMU_INITIALIZATION | FMU_INITIALIZED | (fmu ? fmu->host.reads : 0)) ||
        fmu_null_arrays(fmu, function, references, values, count) ||
        !lengths_agree(fmu, function, references, count, value_count))
        return FMU_ERROR;
    for (size_t i = 0; i < count; i++) {
        if (references[i] == fmu->model->rows) {
            *values++ = fmu->now->clock.time;
            continue;
        }
        const size_t elements = length(fmu, references[i]);
        for (size_t k = 0; k < elements; k++) {
            const unsigned element =
                references[i] + (k ? (unsigned)k * fmu->model->table[references[i]].stride : 0);
            if (fmu_get_real(fmu, function, &element, 1, values++) != FMU_OK)
                return FMU_ERROR;
        }
    }
    return FMU_OK;
}

enum fmu_status fmu_set_arrays(struct fmu *fmu, const char *function, const unsigned references[], size_t count,
                               const double values[], size_t value_count)
{
    struct scalars scalars;

    if (!fmu || fmu_null_arrays(fmu, function, references, values, count) ||
        !expand(fmu, function, references, count, value_count, &scalars))
        return FMU_ERROR;
    const enum fmu_status status = fmu_set_real(fmu, function, scalars.reference, scalars.count, values);
    free(scalars.block);
    return status;
}

enum fmu_status fmu_derivative_of_arrays(struct fmu *fmu, const char *function, fmu_derivative *derivative,
                                         const unsigned unknowns[], size_t unknown_count,
                                         const unsigned knowns[], size_t known_count, const double seeds[],
                                         size_t seed_count, double values[], size_t value_count)
{
    const bool adjoint = derivative == fmu_adjoint_derivative;
    struct scalars of, by = { 0 };
    enum fmu_status status = FMU_ERROR;

    if (!fmu || fmu_null_arrays(fmu, function, unknowns, adjoint ? seeds : values, unknown_count) ||
        fmu_null_arrays(fmu, function, knowns, adjoint ? values : seeds, known_count) ||
        !expand(fmu, function, unknowns, unknown_count, adjoint ? seed_count : value_count, &of))
        return FMU_ERROR;
    if (expand(fmu, function, knowns, known_count, adjoint ? value_count : seed_count, &by))
        status = derivative(fmu, function, of.reference, of.count, by.reference, by.count, seeds, values);
    free(of.block);
    free(by.block);
    return status;
}
