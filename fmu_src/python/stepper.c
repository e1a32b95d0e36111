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

enum base { REAL, INTEGER, BOOLEAN, BASES };

/* What an input gets: factor * slot + offset. */
struct stepper_source {
    double factor, offset;
    int32_t slot;
    int32_t unused;
};

struct stepper_slave {
    fmi2Component instance;
    fmi2SetRealTYPE *set_real;
    fmi2SetIntegerTYPE *set_integer;
    fmi2SetBooleanTYPE *set_boolean;
    fmi2GetRealTYPE *get_real;
    fmi2GetIntegerTYPE *get_integer;
    fmi2GetBooleanTYPE *get_boolean;
    fmi2DoStepTYPE *do_step;
    const fmi2ValueReference *inputs, *outputs; /* all Real ones, then all Integer, then all Boolean */
    const struct stepper_source *sources;       /* of the inputs, in their order */
    double *reals;                              /* room for the most inputs of one base */
    int *integers;                              /* room for the most inputs or outputs of one base */
    int32_t input_counts[BASES], output_counts[BASES];
    int32_t first_output; /* slot */
    int32_t unused;
};

/* Where and why a run ended early. */
struct stepper_fault {
    int32_t slave;
    int32_t call; /* 0: setting inputs, 1: doStep, 2: getting outputs */
    int32_t status;
};

EXPORT int64_t it2core_stepper_run(const struct stepper_slave *slaves, int32_t slave_count, double *slots,
                                   const double *const *signals, int32_t signal_count, const int32_t *recorded,
                                   double *const *records, int32_t record_count, int64_t first_step,
                                   int64_t steps, double step_size, struct stepper_fault *fault);

/* Reads the outputs of a slave into their slots; returns the status. */
EXPORT int32_t it2core_stepper_read(const struct stepper_slave *slave, double *slots);

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

static fmi2Status worse(fmi2Status a, fmi2Status b)
{
    return a > b ? a : b;
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

static fmi2Status set_inputs(const struct stepper_slave *slave, const double *slots)
{
    const struct stepper_source *source = slave->sources;
    const fmi2ValueReference *reference = slave->inputs;
    fmi2Status status = fmi2OK;

    for (int base = 0; base < BASES; base++) {
        const int count = slave->input_counts[base];
        if (count == 0)
            continue;
        for (int i = 0; i < count; i++) {
            const double value = source_value(&source[i], slots);
            if (base == REAL)
                slave->reals[i] = value;
            else
                slave->integers[i] = base == INTEGER ? to_integer(value) : value != 0.0;
        }
        const size_t n = (size_t)count;
        if (base == REAL)
            status = worse(status, slave->set_real(slave->instance, reference, n, slave->reals));
        else if (base == INTEGER)
            status = worse(status, slave->set_integer(slave->instance, reference, n, slave->integers));
        else
            status = worse(status, slave->set_boolean(slave->instance, reference, n, slave->integers));
        source += count;
        reference += count;
    }
    return status;
}

static fmi2Status get_outputs(const struct stepper_slave *slave, double *slots)
{
    double *output = slots + slave->first_output;
    const fmi2ValueReference *reference = slave->outputs;
    fmi2Status status = fmi2OK;

    for (int base = 0; base < BASES; base++) {
        const size_t count = (size_t)slave->output_counts[base];
        if (count == 0)
            continue;
        if (base == REAL)
            status = worse(status, slave->get_real(slave->instance, reference, count, output));
        else {
            if (base == INTEGER)
                status = worse(status, slave->get_integer(slave->instance, reference, count, slave->integers));
            else
                status = worse(status, slave->get_boolean(slave->instance, reference, count, slave->integers));
            for (size_t i = 0; i < count; i++)
                output[i] = slave->integers[i];
        }
        output += count;
        reference += count;
    }
    return status;
}

int32_t it2core_stepper_read(const struct stepper_slave *slave, double *slots)
{
    return (int32_t)get_outputs(slave, slots);
}

/* One step of one slave; returns the call that ended the run, or -1. */
static int32_t step_slave(const struct stepper_slave *slave, double *slots, double time, double step_size,
                          fmi2Status *status)
{
    *status = set_inputs(slave, slots);
    if (*status > fmi2Warning)
        return 0;
    *status = slave->do_step(slave->instance, time, step_size, fmi2True);
    if (*status > fmi2Warning)
        return 1;
    *status = get_outputs(slave, slots);
    return *status > fmi2Warning ? 2 : -1;
}

/* Return the number of complete steps, which is less than asked for where a slave refused one. */
int64_t it2core_stepper_run(const struct stepper_slave *slaves, int32_t slave_count, double *slots,
                            const double *const *signals, int32_t signal_count, const int32_t *recorded,
                            double *const *records, int32_t record_count, int64_t first_step, int64_t steps,
                            double step_size, struct stepper_fault *fault)
{
    for (int64_t k = 0; k < steps; k++) {
        const double time = (double)(first_step + k) * step_size;
        for (int32_t i = 0; i < signal_count; i++)
            slots[i] = signals[i][k];
        for (int32_t i = 0; i < slave_count; i++) {
            fmi2Status status;
            const int32_t call = step_slave(&slaves[i], slots, time, step_size, &status);
            if (call >= 0) {
                *fault = (struct stepper_fault){ i, call, (int32_t)status };
                return k;
            }
        }
        for (int32_t i = 0; i < record_count; i++)
            records[i][k] = slots[recorded[i]];
    }
    return steps;
}
