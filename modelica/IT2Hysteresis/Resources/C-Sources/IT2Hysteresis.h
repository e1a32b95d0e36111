/* What the external functions of the Modelica library call: plant and inverse in one translation unit.
 *
 * it2hys.c and it2hys.h are generated from fmu_src by `python -m it2hys.export.modelica`. A tool compiles them
 * through this header alone, which every external function includes. An external object holds one instance
 * of the FMUs' layer; FMI itself has no part in it. */
#ifndef IT2HYSTERESIS_H
#define IT2HYSTERESIS_H

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

/* A parameter record as the constructors get it: scalars in the order of the variable table. */
struct it2m_parameters {
    const double *scalars;
    size_t scalar_count;
    const double *rule[6];
    size_t rule_count;
    const double *play[2];
    size_t play_count;
    const double *creep[2];
    size_t creep_count;
};

struct it2m_object {
    const struct fmu_model *model;
    struct fmu *fmu;
    struct chain_parameters parameters;
    bool ticked;
    int64_t tick;            /* the last one */
    void *before;            /* the state before it */
    char warnings[2048];     /* said at it */
    char error[1024];        /* the last message that is no warning */
};

/* A warning goes to the tool's log; a tick that is evaluated once more does not say it once more. */
static void it2m_warn(struct it2m_object *object, const char *message)
{
    const size_t used = strlen(object->warnings);

    if (strstr(object->warnings, message))
        return;
    snprintf(object->warnings + used, sizeof object->warnings - used, "%s\n", message);
    ModelicaFormatWarning("%s: %s\n", object->model->identifier, message);
}

/* The instance's log. Errors are kept: ModelicaFormatError does not return, and the layer has to. */
static void it2m_log(const struct fmu_host *host, const char *instance, enum fmu_status status,
                     const char *category, const char *text)
{
    struct it2m_object *object = host->environment;

    (void)instance, (void)category;
    if (status == FMU_WARNING)
        it2m_warn(object, text);
    else if (status != FMU_OK)
        snprintf(object->error, sizeof object->error, "%s", text);
}

static void it2m_set(struct it2m_object *object, const struct fmu_variable *variable, double value)
{
    *(double *)((char *)&object->parameters + variable->offset) = value;
}

static bool it2m_set_scalars(struct it2m_object *object, const double *scalars, size_t count)
{
    size_t n = 0;

    for (unsigned i = 0; i < FMU_TABLE_ROWS; i++) {
        const struct fmu_variable *v = &actuator_table[i];
        if (v->causality == FMU_PARAMETER && v->base == FMU_REAL && v->index == 0 && n++ < count)
            it2m_set(object, v, scalars[n - 1]);
    }
    if (n != count)
        snprintf(object->error, sizeof object->error,
                 "the C sources have %d scalar parameters, the Modelica library hands over %d; they "
                 "belong to different versions", (int)n, (int)count);
    return n == count;
}

/* Elements beyond those that the table has are left out: their number is refused. */
static void it2m_set_columns(struct it2m_object *object, const char *group, const char *const *fields,
                             int field_count, const double *const *columns, size_t count)
{
    char name[64];

    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < field_count; k++) {
            const int length = snprintf(name, sizeof name, "%s[%d].%s", group, (int)i + 1, fields[k]);
            const struct fmu_variable *v = fmu_find_parameter(object->model, name, (size_t)length);
            if (v)
                it2m_set(object, v, columns[k][i]);
        }
}

/* From instantiated to before the first tick. */
static bool it2m_start(struct it2m_object *object, double time)
{
    return fmu_setup(object->fmu, "start", false, 0.0, time, false, 0.0) == FMU_OK &&
           fmu_enter_initialization(object->fmu, "start") == FMU_OK &&
           fmu_exit_initialization(object->fmu, "start") == FMU_OK;
}

static bool it2m_instantiate(struct it2m_object *object, const struct it2m_parameters *p)
{
    static const char *const RULE[] = { "sigmaLower", "sigmaUpper", "centre", "q1", "q2", "q3" };
    static const char *const PLAY[] = { "threshold", "weight" };
    static const char *const CREEP[] = { "gain", "timeConstant" };
    const struct fmu_host host = { .log = it2m_log, .environment = object };

    if (!it2m_set_scalars(object, p->scalars, p->scalar_count))
        return false;
    it2m_set_columns(object, "rule", RULE, 6, p->rule, p->rule_count);
    it2m_set_columns(object, "play", PLAY, 2, p->play, p->play_count);
    it2m_set_columns(object, "creep", CREEP, 2, p->creep, p->creep_count);
    object->parameters.ruleCount = (int)p->rule_count;
    object->parameters.playCount = (int)p->play_count;
    object->parameters.creepCount = (int)p->creep_count;
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

static void *it2m_construct(const struct fmu_model *model, const struct it2m_parameters *parameters)
{
    struct it2m_object *object = calloc(1, sizeof *object);
    char message[1024] = "out of memory";

    if (!object)
        ModelicaFormatError("%s: %s\n", model->identifier, message);
    object->model = model;
    if (it2m_instantiate(object, parameters))
        return object;
    if (object->error[0])
        memcpy(message, object->error, sizeof message);
    it2m_destruct(object);
    ModelicaFormatError("%s: %s\n", model->identifier, message);
    return NULL; /* not reached */
}

/* Begins at another tick than 0: the start time is not known to the constructor. */
static bool it2m_begin_at(struct it2m_object *object, int64_t tick)
{
    return fmu_reset(object->fmu, "start") == FMU_OK &&
           it2m_start(object, (double)tick * object->parameters.sampleTime);
}

/* A tool may evaluate one event more than once, and with other inputs: what counts is the last time. So
 * the tick starts again from the state before it. */
static bool it2m_go_to(struct it2m_object *object, int64_t tick)
{
    if (object->ticked && tick == object->tick)
        return fmu_set_state(object->fmu, "tick", object->before) == FMU_OK;
    if (!object->ticked && tick != 0 && !it2m_begin_at(object, tick))
        return false;
    object->ticked = true;
    object->tick = tick;
    object->warnings[0] = '\0';
    return fmu_get_state(object->fmu, "tick", &object->before) == FMU_OK;
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
            ok = fmu_set_real(object->fmu, "tick", &i, 1, &inputs[v->offset / sizeof *inputs]) == FMU_OK;
    }
    if (!ok || fmu_do_step(object->fmu, "tick", (double)tick * sample_time, sample_time) > FMU_WARNING)
        ModelicaFormatError("%s: %s\n", object->model->identifier, object->error);
}

/* --- what the external clauses call ------------------------------------------------------------- */

#define IT2M_CONSTRUCTOR(function, fmu) \
    static void *function(const double *scalars, size_t scalar_count, const double *sigma_lower, \
                          const double *sigma_upper, const double *centre, const double *q1, \
                          const double *q2, const double *q3, size_t rule_count, \
                          const double *threshold, const double *weight, size_t play_count, \
                          const double *gain, const double *time_constant, size_t creep_count) \
    { \
        const struct it2m_parameters parameters = { \
            scalars, scalar_count, { sigma_lower, sigma_upper, centre, q1, q2, q3 }, rule_count, \
            { threshold, weight }, play_count, { gain, time_constant }, creep_count \
        }; \
        return it2m_construct(&fmu, &parameters); \
    }

IT2M_CONSTRUCTOR(IT2Plant_construct, plant_model)
IT2M_CONSTRUCTOR(IT2Inverse_construct, inverse_model)

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
