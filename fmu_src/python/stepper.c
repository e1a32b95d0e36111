/* Steps connected FMUs over arrays: the loop of a master, without an interpreter in it. The FMUs are
 * anyone's FMI 2.0 slaves, instantiated and initialised by the caller (python/it2hys/cosimulation/stepping.py), and
 * known here by their instances and the addresses of their functions.
 *
 * Values live in slots: first the signals, one slot each, then the outputs of the slaves in their order.
 * Every step loads the signals of its time into their slots and runs the slaves one after the other:
 * a slave gets what is in the slots by then, which is this step's output of a slave before it and the
 * last step's of one behind it. */
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>

#include "fmi2FunctionTypes.h"

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum base { REAL, INTEGER, BOOLEAN };

/* What an input gets: factor * slot + offset. */
struct stepper_source {
    double factor, offset;
    int32_t slot;
    int32_t unused;
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
    const struct stepper_source *sources; /* of inputs; NULL: one Real input gets a slot as it is */
    double *reals;                        /* room for what Real inputs get, */
    int *integers;                        /* and for variables of the other bases */
    int32_t kind, base, count;
    int32_t slot; /* of the first output, where the others follow, or of that input */
    int32_t slave;
    int32_t unused;
};

/* Where and why a run ended early. */
struct stepper_fault {
    int32_t slave;
    int32_t kind; /* of the call */
    int32_t status;
};

/* The calls are those of a step, in their order. */
EXPORT int64_t it2core_stepper_run(const struct stepper_call *calls, int32_t call_count, double *slots,
                                   const double *const *signals, int32_t signal_count, const int32_t *recorded,
                                   double *const *records, int32_t record_count, int64_t first_step,
                                   int64_t steps, double step_size, struct stepper_fault *fault);

/* Makes the calls of one kind for one slave, outside of a step; returns the status. */
EXPORT int32_t it2core_stepper_make(const struct stepper_call *calls, int32_t call_count, double *slots,
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

static double source_value(const struct stepper_source *source, const double *slots)
{
    const double value = source->factor * slots[source->slot];

    return source->offset == 0.0 ? value : value + source->offset; /* -0.0 stays what it is */
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

static fmi2Status set_computed(const struct stepper_call *call, const double *slots)
{
    const size_t count = (size_t)call->count;

    for (size_t i = 0; i < count; i++) {
        const double value = source_value(&call->sources[i], slots);
        if (call->base == REAL)
            call->reals[i] = value;
        else
            call->integers[i] = call->base == INTEGER ? to_integer(value) : value != 0.0;
    }
    if (call->base == REAL)
        return call->function.set_real(call->instance, call->references, count, call->reals);
    return call->function.set_integer(call->instance, call->references, count, call->integers);
}

static inline fmi2Status get_outputs(const struct stepper_call *call, double *slots)
{
    const size_t count = (size_t)call->count;
    double *output = slots + call->slot;

    if (call->base == REAL)
        return call->function.get_real(call->instance, call->references, count, output);
    const fmi2Status status =
        call->function.get_integer(call->instance, call->references, count, call->integers);
    for (size_t i = 0; i < count; i++)
        output[i] = call->integers[i];
    return status;
}

static inline fmi2Status make(const struct stepper_call *call, double *slots, double time, double step_size)
{
    if (call->kind == GET)
        return get_outputs(call, slots);
    if (call->kind == SET && call->sources)
        return set_computed(call, slots);
    if (call->kind == SET)
        return call->function.set_real(call->instance, call->references, 1, slots + call->slot);
    return call->function.step(call->instance, time, step_size, fmi2True);
}

int32_t it2core_stepper_make(const struct stepper_call *calls, int32_t call_count, double *slots, int32_t slave,
                             int32_t kind)
{
    fmi2Status worst = fmi2OK;

    for (int32_t i = 0; i < call_count && worst <= fmi2Warning; i++) {
        if (calls[i].slave != slave || calls[i].kind != kind)
            continue;
        const fmi2Status status = make(&calls[i], slots, 0.0, 0.0);
        worst = status > worst ? status : worst;
    }
    return (int32_t)worst;
}

/* Return the number of complete steps, which is less than asked for where a slave refused one. */
int64_t it2core_stepper_run(const struct stepper_call *calls, int32_t call_count, double *slots,
                            const double *const *signals, int32_t signal_count, const int32_t *recorded,
                            double *const *records, int32_t record_count, int64_t first_step, int64_t steps,
                            double step_size, struct stepper_fault *fault)
{
    for (int64_t k = 0; k < steps; k++) {
        const double time = (double)(first_step + k) * step_size;
        for (int32_t i = 0; i < signal_count; i++)
            slots[i] = signals[i][k];
        for (const struct stepper_call *call = calls; call < calls + call_count; call++) {
            const fmi2Status status = make(call, slots, time, step_size);
            if (status > fmi2Warning) {
                *fault = (struct stepper_fault){ call->slave, call->kind, (int32_t)status };
                return k;
            }
        }
        for (int32_t i = 0; i < record_count; i++)
            records[i][k] = slots[recorded[i]];
    }
    return steps;
}
