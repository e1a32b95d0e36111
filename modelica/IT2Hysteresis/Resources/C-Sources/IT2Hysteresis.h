/* What the external functions of the Modelica library call: plant and inverse in one translation unit.
 *
 * it2hys.c and it2hys.h are generated from fmu_src by `python -m it2hys.export.modelica`. A tool compiles them
 * through this header alone, which every external function includes. An external object holds one instance
 * of the FMUs' layer; FMI itself has no part in it. */
#ifndef IT2HYSTERESIS_H
#define IT2HYSTERESIS_H

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ModelicaUtilities.h"

#define IT2HYS_NO_RESOURCES /* parameters come from a Modelica record */
#include "it2hys.c"

/* --- objects ----------------------------------------------------------------------------------- */

enum { IT2M_INPUTS = 3 };

struct it2m_object {
    const struct fmu_model *model;
    struct fmu *fmu;
    struct chain_parameters parameters;
    char name[256]; /* of the block, which messages begin with */
    bool ticked;
    int64_t tick;            /* the last one */
    void *before;            /* the state before it */
    char warnings[2048];     /* said at it */
    char error[1024];        /* the last message that is no warning */
};

/* --- messages ---------------------------------------------------------------------------------- */

/* What the layer's messages begin with, for the name of an FMI function. */
#define IT2M_START "start"
#define IT2M_TICK "tick"

static const char *it2m_behind(const char *text, const char *start)
{
    const size_t length = strlen(start);

    return strncmp(text, start, length) == 0 && strncmp(text + length, ": ", 2) == 0 ? text + length + 2 : text;
}

static size_t it2m_word(const char *text)
{
    size_t length = 0;

    while (isalnum((unsigned char)text[length]))
        length++;
    return length;
}

/* Does the table have a group of this name, "rule[" or "lag."? */
static bool it2m_is_group(const char *text, size_t length)
{
    for (const struct fmu_variable *v = actuator_table; v < actuator_table + FMU_TABLE_ROWS; v++)
        if (strncmp(v->name, text, length) == 0 && (v->name[length] == '[' || v->name[length] == '.') &&
            (text[length] == '[' || text[length] == '.'))
            return true;
    return false;
}

struct it2m_text {
    char *next;
    char *end; /* the place of the terminating zero, at most */
};

static void it2m_append(struct it2m_text *text, const char *from, size_t length)
{
    const size_t room = (size_t)(text->end - text->next);
    const size_t count = length < room ? length : room;

    memcpy(text->next, from, count);
    text->next += count;
    *text->next = '\0';
}

/* rule[2].sigmaLower is ruleSigmaLower[2] in a record, and rule[].q2 is ruleQ2. Returns what is behind it. */
static const char *it2m_append_field(struct it2m_text *text, const char *name, size_t group)
{
    const char *next = name + group;
    const char *index = next;

    while (*next == '[' || *next == ']' || isdigit((unsigned char)*next))
        next++;
    const size_t index_length = (size_t)(next - index);
    it2m_append(text, name, group);
    while (*next == '.' && isalpha((unsigned char)next[1])) {
        const char initial = (char)toupper((unsigned char)next[1]);
        const size_t rest = it2m_word(next + 2);
        it2m_append(text, &initial, 1);
        it2m_append(text, next + 2, rest);
        next += 2 + rest;
    }
    if (index_length > 2)
        it2m_append(text, index, index_length);
    return next;
}

/* The FMU's names of parameters become those of the records. */
static void it2m_translate(const char *from, char *to, size_t size)
{
    struct it2m_text text = { to, to + size - 1 };

    *to = '\0';
    while (*from) {
        const size_t word = it2m_word(from);
        if (word > 0 && it2m_is_group(from, word)) {
            from = it2m_append_field(&text, from, word);
            continue;
        }
        const size_t length = word > 0 ? word : 1;
        it2m_append(&text, from, length);
        from += length;
    }
}

/* A warning goes to the tool's log; a tick that is evaluated once more does not say it once more. */
static void it2m_warn(struct it2m_object *object, const char *message)
{
    const size_t used = strlen(object->warnings);

    if (strstr(object->warnings, message))
        return;
    snprintf(object->warnings + used, sizeof object->warnings - used, "%s\n", message);
    ModelicaFormatWarning("%s (%s): %s\n", object->name, object->model->identifier, message);
}

/* The instance's log. Errors are kept: ModelicaFormatError does not return, and the layer has to. */
static void it2m_log(const struct fmu_host *host, const char *instance, enum fmu_status status,
                     const char *category, const char *text)
{
    struct it2m_object *object = host->environment;
    char message[1024];

    (void)instance, (void)category;
    it2m_translate(it2m_behind(it2m_behind(text, IT2M_START), IT2M_TICK), message, sizeof message);
    if (status == FMU_WARNING)
        it2m_warn(object, message);
    else if (status != FMU_OK)
        memcpy(object->error, message, sizeof message);
}

/* The numbers of a parameter record, in the order of the variable table (Internal.Values): a group of elements
 * as columns, each behind how many elements it has. The counts of the table are those numbers. */
struct it2m_values {
    const double *next;
    size_t left;
    size_t needed;                     /* by the table */
    const struct fmu_variable *first;  /* column of the group */
    const struct fmu_variable *uneven; /* column that is not as long as the first of its group, if any */
    int elements[2];                   /* of those two */
};

static double it2m_next(struct it2m_values *values)
{
    values->needed++;
    return values->left ? (values->left--, *values->next++) : 0.0;
}

static void *it2m_place(struct it2m_object *object, const struct fmu_variable *variable)
{
    return (char *)&object->parameters + variable->offset;
}

/* How many elements the next column has; the first column of a group counts them. */
static int it2m_length(struct it2m_object *object, const struct fmu_variable *column, bool is_first,
                       struct it2m_values *values)
{
    int *const counted = (int *)((char *)&object->parameters + column->count);
    const double number = it2m_next(values);
    const int length = number >= 0.0 && number <= (double)values->left ? (int)number : 0;

    if (is_first) {
        *counted = length;
        values->first = values->uneven ? values->first : column;
    } else if (length != *counted && !values->uneven) {
        values->uneven = column;
        values->elements[0] = *counted;
        values->elements[1] = length;
    }
    return length;
}

/* A column, from the row of its first element on; that of the next is `stride` rows further. Elements beyond
 * those that the table has are left out: their number is refused. */
static void it2m_set_column(struct it2m_object *object, const struct fmu_variable *first, size_t stride,
                            int count, struct it2m_values *values)
{
    size_t row = (size_t)(first - actuator_table);

    for (int i = 1; i <= count; i++, row += stride) {
        const double value = it2m_next(values);
        if (row < FMU_TABLE_ROWS && actuator_table[row].index == i && actuator_table[row].count == first->count)
            *(double *)it2m_place(object, &actuator_table[row]) = value;
    }
}

/* The vector's name in a record: that of rule[1].q2 is ruleQ2. */
static void it2m_column_name(const struct fmu_variable *column, char *name, size_t size)
{
    it2m_translate(column->name, name, size);
    name[strcspn(name, "[")] = '\0';
}

/* Rows from one element of a group to the next. */
static size_t it2m_stride(const struct fmu_variable *first)
{
    const struct fmu_variable *end = first;

    while (end < actuator_table + FMU_TABLE_ROWS && end->index == 1 && end->count == first->count)
        end++;
    return (size_t)(end - first);
}

/* Says what is wrong with the numbers as a whole, if anything is. */
static bool it2m_complete(struct it2m_object *object, const struct it2m_values *values, size_t count)
{
    char names[2][64];

    if (values->needed != count) {
        snprintf(object->error, sizeof object->error,
                 "the C sources have %d parameters, the Modelica library hands over %d; they "
                 "belong to different versions", (int)values->needed, (int)count);
        return false;
    }
    if (!values->uneven)
        return true;
    it2m_column_name(values->uneven, names[0], sizeof names[0]);
    it2m_column_name(values->first, names[1], sizeof names[1]);
    snprintf(object->error, sizeof object->error,
             "%s has %d elements and %s has %d; they must have the same number.", names[0],
             values->elements[1], names[1], values->elements[0]);
    return false;
}

static bool it2m_set(struct it2m_object *object, const double *numbers, size_t count)
{
    struct it2m_values values = { .next = numbers, .left = count };
    size_t stride = 0;

    for (const struct fmu_variable *v = actuator_table; v < actuator_table + FMU_TABLE_ROWS; v++) {
        if (v->causality != FMU_PARAMETER || v->index > 1)
            continue;
        if (v->index == 1) {
            const bool is_first = v[-1].index != 1 || v[-1].count != v->count;
            stride = is_first ? it2m_stride(v) : stride;
            it2m_set_column(object, v, stride, it2m_length(object, v, is_first, &values), &values);
        } else if (v->base != FMU_INTEGER)
            *(double *)it2m_place(object, v) = it2m_next(&values);
    }
    return it2m_complete(object, &values, count);
}

/* From instantiated to before the first tick. */
static bool it2m_start(struct it2m_object *object, double time)
{
    return fmu_setup(object->fmu, IT2M_START, false, 0.0, time, false, 0.0) == FMU_OK &&
           fmu_enter_initialization(object->fmu, IT2M_START) == FMU_OK &&
           fmu_exit_initialization(object->fmu, IT2M_START) == FMU_OK;
}

static bool it2m_instantiate(struct it2m_object *object, const double *values, size_t count)
{
    const struct fmu_host host = { .log = it2m_log, .environment = object };

    if (!it2m_set(object, values, count))
        return false;
    object->fmu = fmu_create(object->model, object->model->identifier, &object->parameters, &host, true);
    return object->fmu && it2m_start(object, 0.0);
}

static void it2m_destruct(struct it2m_object *object)
{
    if (!object)
        return;
    free(object->before);
    fmu_free(object->fmu);
    free(object);
}

static void *it2m_construct(const struct fmu_model *model, const double *values, size_t count, const char *name)
{
    struct it2m_object *object = calloc(1, sizeof *object);
    char message[1024] = "out of memory", label[sizeof object->name];

    if (!object)
        ModelicaFormatError("%s (%s): %s\n", name, model->identifier, message);
    snprintf(object->name, sizeof object->name, "%s", name);
    memcpy(label, object->name, sizeof label);
    object->model = model;
    if (it2m_instantiate(object, values, count))
        return object;
    if (object->error[0])
        memcpy(message, object->error, sizeof message);
    it2m_destruct(object);
    ModelicaFormatError("%s (%s): %s\n", label, model->identifier, message);
    return NULL; /* not reached */
}

/* Begins at another tick than 0: the start time is not known to the constructor. */
static bool it2m_begin_at(struct it2m_object *object, int64_t tick)
{
    return fmu_reset(object->fmu, IT2M_START) == FMU_OK &&
           it2m_start(object, (double)tick * object->parameters.sampleTime);
}

/* A tool may evaluate one event more than once, and with other inputs: what counts is the last time. So
 * the tick starts again from the state before it. */
static bool it2m_go_to(struct it2m_object *object, int64_t tick)
{
    if (object->ticked && tick == object->tick)
        return fmu_set_state(object->fmu, IT2M_TICK, object->before) == FMU_OK;
    if (!object->ticked && tick != 0 && !it2m_begin_at(object, tick))
        return false;
    object->ticked = true;
    object->tick = tick;
    object->warnings[0] = '\0';
    return fmu_get_state(object->fmu, IT2M_TICK, &object->before) == FMU_OK;
}

/* The first input is the voltage or the reference, the others are force and temperature. */
static void it2m_tick(struct it2m_object *object, double time, const double inputs[IT2M_INPUTS])
{
    const double sample_time = object->parameters.sampleTime;
    const int64_t tick = (int64_t)floor(time / sample_time + 0.5);
    bool ok = it2m_go_to(object, tick);

    for (unsigned i = 0; ok && i < FMU_TABLE_ROWS; i++) {
        const struct fmu_variable *v = fmu_find(object->model, i);
        if (v && v->causality == FMU_INPUT)
            ok = fmu_set_real(object->fmu, IT2M_TICK, &i, 1, &inputs[v->offset / sizeof *inputs]) == FMU_OK;
    }
    if (!ok || fmu_do_step(object->fmu, IT2M_TICK, (double)tick * sample_time, sample_time) > FMU_WARNING)
        ModelicaFormatError("%s (%s): at %g s: %s\n", object->name, object->model->identifier,
                            (double)tick * sample_time, object->error);
}

/* --- what the external clauses call ------------------------------------------------------------- */

static void *IT2Plant_construct(const double *values, size_t count, const char *name)
{
    return it2m_construct(&plant_model, values, count, name);
}

static void *IT2Inverse_construct(const double *values, size_t count, const char *name)
{
    return it2m_construct(&inverse_model, values, count, name);
}

static void IT2Plant_destruct(void *object)
{
    it2m_destruct(object);
}

static void IT2Inverse_destruct(void *object)
{
    it2m_destruct(object);
}

static void IT2Plant_tick(void *object, double time, double voltage, double force, double temperature,
                          double *displacement, double *measured, int *out_of_range)
{
    const double inputs[IT2M_INPUTS] = { voltage, force, temperature };
    const struct fmu_outputs *output = &((struct it2m_object *)object)->fmu->now->output;

    it2m_tick(object, time, inputs);
    *displacement = output->real[OUT_DISPLACEMENT];
    *measured = output->real[OUT_MEASURED];
    *out_of_range = output->flag[OUT_OUT_OF_RANGE];
}

static void IT2Inverse_tick(void *object, double time, double reference, double force,
                            double temperature, double *voltage, int *saturated)
{
    const double inputs[IT2M_INPUTS] = { reference, force, temperature };
    const struct fmu_outputs *output = &((struct it2m_object *)object)->fmu->now->output;

    it2m_tick(object, time, inputs);
    *voltage = output->real[OUT_VOLTAGE];
    *saturated = output->flag[OUT_SATURATED];
}

#endif
