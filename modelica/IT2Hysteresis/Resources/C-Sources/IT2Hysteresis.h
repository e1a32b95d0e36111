/* What the external functions of the Modelica library call: both FMUs in one translation unit.
 *
 * The other files of this folder are copies of fmu_src, made by `python -m it2hys.modelica`. A tool
 * compiles them through this header alone, which every external function includes. The FMUs' functions
 * carry the prefixes IT2Plant_ and IT2Inverse_, so that both live in one program; an external object
 * holds one instance. fmu_parameters.c is not here: parameters come from a Modelica record. */
#ifndef IT2HYSTERESIS_H
#define IT2HYSTERESIS_H

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ModelicaUtilities.h"

/* --- the FMUs ---------------------------------------------------------------------------------- */

#include "it2_check.c"
#include "it2_gradient.c"
#include "it2_inverse.c"
#include "it2_model.c"
#include "it2_range.c"

#include "creep.c"
#include "delay.c"
#include "drift.c"
#include "hum.c"
#include "lag.c"
#include "load.c"
#include "nonlinearity.c"
#include "play.c"
#include "resonance.c"
#include "saturation.c"
#include "slew.c"

#include "chain.c"
#include "chain_check.c"
#include "chain_tangent.c"

#include "fmu_lifecycle.c"
#include "fmu_log.c"
#include "fmu_state.c"
#include "fmu_step.c"
#include "fmu_variables.c"

/* The constructor sets every parameter: there is no set to load, but room for as much as there can be. */
bool fmu_load_parameters(const struct fmu_model *model, const char *guid, const char *resources,
                         struct chain_parameters *parameters, char *message, size_t size)
{
    (void)model, (void)guid, (void)resources, (void)message, (void)size;
    memset(parameters, 0, sizeof *parameters);
    parameters->ruleCount = IT2_MAX_RULES;
    parameters->playCount = PLAY_MAX;
    parameters->creepCount = CREEP_MAX;
    return true;
}

#define FMI2_FUNCTION_PREFIX IT2Plant_
#include "IT2Plant.c"
#undef FMI2_FUNCTION_PREFIX

#define FMI2_FUNCTION_PREFIX IT2Inverse_
#include "IT2Inverse.c"
#undef FMI2_FUNCTION_PREFIX

/* --- objects ----------------------------------------------------------------------------------- */

enum {
    IT2M_INPUTS = 3,
    IT2M_GROUPS = 3 /* rules, play operators, creep terms */
};

/* The functions of one FMU that are called here, and its variables by name. */
struct it2m_fmu {
    const char *name;
    fmi2InstantiateTYPE *instantiate;
    fmi2FreeInstanceTYPE *free_instance;
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter_initialization;
    fmi2ExitInitializationModeTYPE *exit_initialization;
    fmi2TerminateTYPE *terminate;
    fmi2ResetTYPE *reset;
    fmi2SetRealTYPE *set_real;
    fmi2SetIntegerTYPE *set_integer;
    fmi2GetRealTYPE *get_real;
    fmi2GetBooleanTYPE *get_boolean;
    fmi2GetFMUstateTYPE *get_state;
    fmi2SetFMUstateTYPE *set_state;
    fmi2FreeFMUstateTYPE *free_state;
    fmi2DoStepTYPE *do_step;
    const char *input[IT2M_INPUTS];
};

/* clang-format off */
#define IT2M_FMU(prefix, first_input) { #prefix, prefix##_fmi2Instantiate, prefix##_fmi2FreeInstance, \
    prefix##_fmi2SetupExperiment, prefix##_fmi2EnterInitializationMode, \
    prefix##_fmi2ExitInitializationMode, prefix##_fmi2Terminate, prefix##_fmi2Reset, \
    prefix##_fmi2SetReal, prefix##_fmi2SetInteger, prefix##_fmi2GetReal, prefix##_fmi2GetBoolean, \
    prefix##_fmi2GetFMUstate, prefix##_fmi2SetFMUstate, prefix##_fmi2FreeFMUstate, \
    prefix##_fmi2DoStep, { first_input, "force", "temperature" } }
/* clang-format on */

static const struct it2m_fmu IT2M_PLANT = IT2M_FMU(IT2Plant, "voltage");
static const struct it2m_fmu IT2M_INVERSE = IT2M_FMU(IT2Inverse, "reference");

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

struct it2m_values {
    fmi2ValueReference reference[VARIABLE_COUNT];
    double value[VARIABLE_COUNT];
    size_t count;
};

struct it2m_object {
    const struct it2m_fmu *fmu;
    fmi2CallbackFunctions callbacks;
    fmi2Component component;
    struct it2m_values parameters; /* the Real ones */
    size_t element_count[IT2M_GROUPS];
    double sample_time;
    bool ticked;
    int64_t tick;            /* the last one */
    fmi2FMUstate before;     /* the state before it */
    char warnings[2048];     /* said at it */
    char error[1024];        /* the FMU's last message that is no warning */
};

/* A warning goes to the tool's log; a tick that is evaluated once more does not say it once more. */
static void it2m_warn(struct it2m_object *object, const char *message)
{
    const size_t used = strlen(object->warnings);

    if (strstr(object->warnings, message))
        return;
    snprintf(object->warnings + used, sizeof object->warnings - used, "%s\n", message);
    ModelicaFormatWarning("%s: %s\n", object->fmu->name, message);
}

/* The FMU's logger. Errors are kept: ModelicaFormatError does not return, and the FMU has to. */
static void it2m_log(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                     fmi2String category, fmi2String format, ...)
{
    struct it2m_object *object = environment;
    char message[1024];
    va_list arguments;

    (void)instance, (void)category;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (status == fmi2Warning)
        it2m_warn(object, message);
    else if (status != fmi2OK)
        memcpy(object->error, message, sizeof message);
}

static fmi2ValueReference it2m_reference(const struct fmu_variable *variable)
{
    return (fmi2ValueReference)(variable - FMU_TABLE);
}

/* Of a variable that the FMU has; plant and inverse have different ones of the name voltage. */
static fmi2ValueReference it2m_find(const struct it2m_fmu *fmu, const char *name)
{
    const unsigned kind = fmu == &IT2M_PLANT ? FMU_PLANT : FMU_INVERSE;
    int i = 0;

    while (strcmp(FMU_TABLE[i].name, name) != 0 || !(FMU_TABLE[i].models & kind))
        i++;
    return it2m_reference(&FMU_TABLE[i]);
}

static void it2m_add(struct it2m_values *values, const struct fmu_variable *variable, double value)
{
    values->reference[values->count] = it2m_reference(variable);
    values->value[values->count++] = value;
}

static bool it2m_add_scalars(struct it2m_object *object, const double *scalars, size_t count)
{
    size_t n = 0;

    for (int i = 0; i < VARIABLE_COUNT; i++) {
        const struct fmu_variable *v = &FMU_TABLE[i];
        if (v->causality == FMU_PARAMETER && v->base == FMU_REAL && v->index == 0 && n++ < count)
            it2m_add(&object->parameters, v, scalars[n - 1]);
    }
    if (n != count)
        snprintf(object->error, sizeof object->error,
                 "the C sources have %d scalar parameters, the Modelica library hands over %d; they "
                 "belong to different versions", (int)n, (int)count);
    return n == count;
}

/* Elements beyond those that the table has are left out: the FMU refuses their number. */
static void it2m_add_columns(struct it2m_object *object, const char *group, const char *const *fields,
                             int field_count, const double *const *columns, size_t count)
{
    char name[64];

    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < field_count; k++) {
            const int length = snprintf(name, sizeof name, "%s[%d].%s", group, (int)i + 1, fields[k]);
            const struct fmu_variable *v = fmu_find_parameter(name, (size_t)length);
            if (v)
                it2m_add(&object->parameters, v, columns[k][i]);
        }
}

static bool it2m_set_counts(struct it2m_object *object)
{
    static const char *const COUNT[IT2M_GROUPS] = { "ruleCount", "playCount", "creepCount" };
    fmi2ValueReference reference[IT2M_GROUPS];
    fmi2Integer value[IT2M_GROUPS];

    for (int i = 0; i < IT2M_GROUPS; i++) {
        reference[i] = it2m_find(object->fmu, COUNT[i]);
        value[i] = (fmi2Integer)object->element_count[i];
    }
    return object->fmu->set_integer(object->component, reference, IT2M_GROUPS, value) == fmi2OK;
}

/* From instantiated to before the first tick. */
static bool it2m_start(struct it2m_object *object, double time)
{
    const struct it2m_fmu *fmu = object->fmu;
    const struct it2m_values *p = &object->parameters;

    return it2m_set_counts(object) &&
           fmu->set_real(object->component, p->reference, p->count, p->value) == fmi2OK &&
           fmu->setup(object->component, fmi2False, 0.0, time, fmi2False, 0.0) == fmi2OK &&
           fmu->enter_initialization(object->component) == fmi2OK &&
           fmu->exit_initialization(object->component) == fmi2OK;
}

static bool it2m_instantiate(struct it2m_object *object, const struct it2m_parameters *p)
{
    static const char *const RULE[] = { "sigmaLower", "sigmaUpper", "centre", "q1", "q2", "q3" };
    static const char *const PLAY[] = { "threshold", "weight" };
    static const char *const CREEP[] = { "gain", "timeConstant" };
    const struct it2m_fmu *fmu = object->fmu;

    if (!it2m_add_scalars(object, p->scalars, p->scalar_count))
        return false;
    it2m_add_columns(object, "rule", RULE, 6, p->rule, p->rule_count);
    it2m_add_columns(object, "play", PLAY, 2, p->play, p->play_count);
    it2m_add_columns(object, "creep", CREEP, 2, p->creep, p->creep_count);
    object->element_count[0] = p->rule_count;
    object->element_count[1] = p->play_count;
    object->element_count[2] = p->creep_count;
    object->sample_time = p->scalars[0]; /* the table's first parameter */
    object->callbacks.logger = it2m_log;
    object->callbacks.componentEnvironment = object;
    object->component = fmu->instantiate(fmu->name, fmi2CoSimulation, "", NULL, &object->callbacks,
                                         fmi2False, fmi2True);
    return object->component && it2m_start(object, 0.0);
}

static void it2m_free(struct it2m_object *object)
{
    const struct it2m_fmu *fmu = object->fmu;

    if (object->component && object->before)
        fmu->free_state(object->component, &object->before);
    if (object->component)
        fmu->free_instance(object->component);
    free(object);
}

static void *it2m_construct(const struct it2m_fmu *fmu, const struct it2m_parameters *parameters)
{
    struct it2m_object *object = calloc(1, sizeof *object);
    char message[1024] = "out of memory";

    if (!object)
        ModelicaFormatError("%s: %s\n", fmu->name, message);
    object->fmu = fmu;
    if (it2m_instantiate(object, parameters))
        return object;
    if (object->error[0])
        memcpy(message, object->error, sizeof message);
    it2m_free(object);
    ModelicaFormatError("%s: %s\n", fmu->name, message);
    return NULL; /* not reached */
}

static void it2m_destruct(struct it2m_object *object)
{
    if (!object)
        return;
    object->fmu->terminate(object->component);
    it2m_free(object);
}

/* Begins at another tick than 0: the start time is not known to the constructor. */
static bool it2m_begin_at(struct it2m_object *object, int64_t tick)
{
    return object->fmu->reset(object->component) == fmi2OK &&
           it2m_start(object, (double)tick * object->sample_time);
}

/* A tool may evaluate one event more than once, and with other inputs: what counts is the last time. So
 * the tick starts again from the state before it. */
static bool it2m_go_to(struct it2m_object *object, int64_t tick)
{
    const struct it2m_fmu *fmu = object->fmu;

    if (object->ticked && tick == object->tick)
        return fmu->set_state(object->component, object->before) == fmi2OK;
    if (!object->ticked && tick != 0 && !it2m_begin_at(object, tick))
        return false;
    object->ticked = true;
    object->tick = tick;
    object->warnings[0] = '\0';
    return fmu->get_state(object->component, &object->before) == fmi2OK;
}

static bool it2m_step(struct it2m_object *object, double time, const double inputs[])
{
    const struct it2m_fmu *fmu = object->fmu;
    const int64_t tick = (int64_t)floor(time / object->sample_time + 0.5);
    fmi2ValueReference reference[IT2M_INPUTS];

    for (int i = 0; i < IT2M_INPUTS; i++)
        reference[i] = it2m_find(fmu, fmu->input[i]);
    return it2m_go_to(object, tick) &&
           fmu->set_real(object->component, reference, IT2M_INPUTS, inputs) == fmi2OK &&
           fmu->do_step(object->component, (double)tick * object->sample_time, object->sample_time,
                         fmi2True) <= fmi2Warning;
}

static void it2m_tick(struct it2m_object *object, double time, const double inputs[])
{
    if (!it2m_step(object, time, inputs))
        ModelicaFormatError("%s: %s\n", object->fmu->name, object->error);
}

static double it2m_real(const struct it2m_object *object, const char *name)
{
    const fmi2ValueReference reference = it2m_find(object->fmu, name);
    double value = 0.0;

    object->fmu->get_real(object->component, &reference, 1, &value);
    return value;
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

IT2M_CONSTRUCTOR(IT2Plant_construct, IT2M_PLANT)
IT2M_CONSTRUCTOR(IT2Inverse_construct, IT2M_INVERSE)

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
    const double inputs[] = { voltage, force, temperature };
    const fmi2ValueReference flag = it2m_find(&IT2M_PLANT, "outOfRange");

    it2m_tick(object, time, inputs);
    *displacement = it2m_real(object, "displacement");
    *measured = it2m_real(object, "measured");
    IT2Plant_fmi2GetBoolean(((struct it2m_object *)object)->component, &flag, 1, out_of_range);
}

static void IT2Inverse_tick(void *object, double time, double reference, double force,
                            double temperature, double *voltage, int *saturated)
{
    const double inputs[] = { reference, force, temperature };
    const fmi2ValueReference flag = it2m_find(&IT2M_INVERSE, "saturated");

    it2m_tick(object, time, inputs);
    *voltage = it2m_real(object, "voltage");
    IT2Inverse_fmi2GetBoolean(((struct it2m_object *)object)->component, &flag, 1, saturated);
}

#endif
