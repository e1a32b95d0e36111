/* Steps connected FMUs over arrays: the loop of a master, without an interpreter in it. The FMUs are
 * anyone's FMI 2.0 slaves, instantiated and initialised by the caller (python/it2hys/cosimulation/stepping.py), and
 * known here by their instances and the addresses of their functions.
 *
 * Every signal and every output has a course: its values step by step, those of an output after what it was before
 * the first step. Every step runs the slaves one after the other: a slave gets this step's output of a slave before it
 * and the last step's of one behind it. */
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "fmi2FunctionTypes.h"

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* What is in the innermost loop: a call of it would cost as much as it does. */
#if defined __GNUC__
#define INLINE inline __attribute__((always_inline))
#else
#define INLINE inline
#endif

enum base { REAL, INTEGER, BOOLEAN };

/* Where an input comes from, which gets factor * value + offset, or where an output goes. */
struct stepper_value {
    double factor, offset;
    double *values;    /* of the steps, found by `place` */
    int32_t course;    /* its number */
    int32_t this_step; /* of an output's course: 1 for what it is after the step, 0 before it */
};

enum kind { SET, STEP, GET };

/* One call of an FMI function: doStep, or one that sets or gets variables of one base. */
struct stepper_call {
    union {
        fmi2DoStepTYPE *step;
        fmi2SetRealTYPE *set_real;
        fmi2SetIntegerTYPE *set_integer; /* Booleans are ints, too */
        fmi2GetRealTYPE *get_real;
        fmi2GetIntegerTYPE *get_integer;
    } function;
    fmi2Component instance;
    const fmi2ValueReference *references;
    struct stepper_value *values;
    double *reals; /* room for what is set or got; NULL: one Real, as it is in its course */
    int *integers; /* and for variables of the other bases */
    int32_t kind, base, count, slave;
};

/* Where and why a run ended early. */
struct stepper_fault {
    int32_t slave;
    int32_t kind; /* of the call */
    int32_t status;
};

/* The calls are those of a step, in their order. */
EXPORT int64_t it2core_stepper_run(struct stepper_call *calls, int32_t call_count, double *const *courses,
                                   int64_t first_step, int64_t steps, double step_size,
                                   struct stepper_fault *fault);

/* Makes the calls of one kind for one slave outside of a step, where courses are a single value; returns the status. */
EXPORT int32_t it2core_stepper_make(struct stepper_call *calls, int32_t call_count, double *const *courses,
                                    int32_t slave, int32_t kind);

/* Who listens to an instance: its component environment. */
struct stepper_listener {
    void (*hear)(int status, const char *text);
};

EXPORT void it2core_stepper_log(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                                fmi2String category, fmi2String format, ...);

/* A logger takes a printf format and its arguments, which only compiled code can read. What is no
 * warning is dropped here, because some FMUs tell of every call. */
void it2core_stepper_log(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                         fmi2String category, fmi2String format, ...)
{
    char text[2048];
    va_list arguments;

    (void)name, (void)category;
    if (status == fmi2OK || !environment || !format)
        return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    ((const struct stepper_listener *)environment)->hear((int)status, text);
}

static double input_value(const struct stepper_value *input, int64_t step)
{
    const double value = input->factor * input->values[step];

    return input->offset == 0.0 ? value : value + input->offset; /* -0.0 stays what it is */
}

/* To the nearest integer, halves away from zero; what no int can hold becomes the nearest that one can. */
static int to_integer(double value)
{
    if (!(value > INT32_MIN)) /* NaN too */
        return INT32_MIN;
    if (value >= INT32_MAX)
        return INT32_MAX;
    return (int)(value < 0.0 ? value - 0.5 : value + 0.5);
}

static fmi2Status set_inputs(const struct stepper_call *call, int64_t step)
{
    const size_t count = (size_t)call->count;

    for (size_t i = 0; i < count; i++) {
        const double value = input_value(&call->values[i], step);
        if (call->base == REAL)
            call->reals[i] = value;
        else
            call->integers[i] = call->base == INTEGER ? to_integer(value) : value != 0.0;
    }
    if (call->base == REAL)
        return call->function.set_real(call->instance, call->references, count, call->reals);
    return call->function.set_integer(call->instance, call->references, count, call->integers);
}

static inline fmi2Status get_outputs(const struct stepper_call *call, int64_t step)
{
    const size_t count = (size_t)call->count;
    fmi2Status status;

    if (call->base == REAL) {
        status = call->function.get_real(call->instance, call->references, count, call->reals);
        for (size_t i = 0; i < count; i++)
            call->values[i].values[step] = call->reals[i];
    } else {
        status = call->function.get_integer(call->instance, call->references, count, call->integers);
        for (size_t i = 0; i < count; i++)
            call->values[i].values[step] = call->integers[i];
    }
    return status;
}

static INLINE fmi2Status make(const struct stepper_call *call, int64_t step, double time, double step_size)
{
    if (call->kind == STEP)
        return call->function.step(call->instance, time, step_size, fmi2True);
    if (!call->reals && call->kind == SET)
        return call->function.set_real(call->instance, call->references, 1, call->values->values + step);
    if (!call->reals)
        return call->function.get_real(call->instance, call->references, 1, call->values->values + step);
    return call->kind == GET ? get_outputs(call, step) : set_inputs(call, step);
}

/* Tells the calls where their values are. */
static void place(struct stepper_call *calls, int32_t call_count, double *const *courses, bool stepping)
{
    for (struct stepper_call *call = calls; call < calls + call_count; call++) {
        for (struct stepper_value *value = call->values; value < call->values + call->count; value++)
            value->values = courses[value->course] + (stepping ? value->this_step : 0);
    }
}

int32_t it2core_stepper_make(struct stepper_call *calls, int32_t call_count, double *const *courses,
                             int32_t slave, int32_t kind)
{
    fmi2Status worst = fmi2OK;

    place(calls, call_count, courses, false);
    for (int32_t i = 0; i < call_count && worst <= fmi2Warning; i++) {
        if (calls[i].slave != slave || calls[i].kind != kind)
            continue;
        const fmi2Status status = make(&calls[i], 0, 0.0, 0.0);
        worst = status > worst ? status : worst;
    }
    return (int32_t)worst;
}

/* Return the number of complete steps, which is less than asked for where a slave refused one. */
int64_t it2core_stepper_run(struct stepper_call *calls, int32_t call_count, double *const *courses,
                            int64_t first_step, int64_t steps, double step_size, struct stepper_fault *fault)
{
    const struct stepper_call *const end = calls + call_count;

    place(calls, call_count, courses, true);
    for (int64_t k = 0; k < steps; k++) {
        const double time = (double)(first_step + k) * step_size;
        for (const struct stepper_call *call = calls; call < end; call++) {
            const fmi2Status status = make(call, k, time, step_size);
            if (status > fmi2Warning) {
                *fault = (struct stepper_fault){ call->slave, call->kind, (int32_t)status };
                return k;
            }
        }
    }
    return steps;
}
