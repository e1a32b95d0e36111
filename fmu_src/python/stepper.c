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

/* How the FMI functions of a base hold numbers: Real, Integer and Boolean. */
enum held { DOUBLE, INT, FLAG, HELD };

/* Where an input comes from, which gets factor * value + offset, or where an output goes. */
struct stepper_value {
    double factor, offset;
    double *values;    /* of the steps, found by `place` */
    int32_t course;    /* its number */
    int32_t this_step; /* of an output's course: 1 for what it is after the step, 0 before it */
};

/* Variables of one base that one call sets or gets; none where `count` is 0. */
struct stepper_transfer {
    union {
        fmi2SetRealTYPE *set_real;
        fmi2SetIntegerTYPE *set_integer; /* Booleans are ints, too */
        fmi2GetRealTYPE *get_real;
        fmi2GetIntegerTYPE *get_integer;
    } function;
    const fmi2ValueReference *references;
    struct stepper_value *values;
    void *room; /* for what is set or got; NULL: one double, as it is in its course */
    int64_t count;
};

/* What a slave does in a step: inputs set, a step, outputs got. Each call has a place of its own in the code, and
 * most often one target there: processors foresee that, which a loop over a list of calls costs them half of. */
struct stepper_turn {
    fmi2Component instance;
    fmi2DoStepTYPE *step;
    struct stepper_transfer set[HELD], get[HELD];
};

enum kind { SET, STEP, GET };

/* Where and why a run ended early. */
struct stepper_fault {
    int32_t slave;
    int32_t kind; /* of the call */
    int32_t status;
};

EXPORT int64_t it2core_stepper_run(struct stepper_turn *turns, int32_t slaves, double *const *courses,
                                   int64_t first_step, int64_t steps, double step_size,
                                   struct stepper_fault *fault);

/* Gets a slave's outputs outside of a step, where courses are a single value, and sets its inputs before if it is to.
 * Returns the status, and in `kind` which of the calls it is of. */
EXPORT int32_t it2core_stepper_exchange(struct stepper_turn *turn, double *const *courses, bool sets,
                                        int32_t *kind);

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

/* Return where the inputs of a call are, gathered from their courses. */
static INLINE const void *gathered(const struct stepper_transfer *inputs, enum held held, int64_t step)
{
    if (held == DOUBLE && !inputs->room)
        return inputs->values->values + step;
    for (int64_t i = 0; i < inputs->count; i++) {
        const double value = input_value(&inputs->values[i], step);
        if (held == DOUBLE)
            ((double *)inputs->room)[i] = value;
        else
            ((int *)inputs->room)[i] = held == INT ? to_integer(value) : value != 0.0;
    }
    return inputs->room;
}

/* Return where a call is to leave outputs. */
static INLINE void *receiver(const struct stepper_transfer *outputs, int64_t step)
{
    return outputs->room ? outputs->room : outputs->values->values + step;
}

/* Write what a call has left into the courses. */
static INLINE void scatter(const struct stepper_transfer *outputs, enum held held, int64_t step)
{
    for (int64_t i = 0; outputs->room && i < outputs->count; i++)
        outputs->values[i].values[step] =
            held == DOUBLE ? ((const double *)outputs->room)[i] : ((const int *)outputs->room)[i];
}

static INLINE fmi2Status set_ints(const struct stepper_turn *turn, enum held held, int64_t step)
{
    const struct stepper_transfer *const set = &turn->set[held];

    return set->function.set_integer(turn->instance, set->references, (size_t)set->count,
                                     gathered(set, held, step));
}

static INLINE fmi2Status set_inputs(const struct stepper_turn *turn, int64_t step)
{
    const struct stepper_transfer *const reals = &turn->set[DOUBLE];
    fmi2Status status = fmi2OK;

    if (reals->count > 0)
        status = reals->function.set_real(turn->instance, reals->references, (size_t)reals->count,
                                          gathered(reals, DOUBLE, step));
    if (turn->set[INT].count > 0 && status <= fmi2Warning)
        status = set_ints(turn, INT, step);
    if (turn->set[FLAG].count > 0 && status <= fmi2Warning)
        status = set_ints(turn, FLAG, step);
    return status;
}

static INLINE fmi2Status get_ints(const struct stepper_turn *turn, enum held held, int64_t step)
{
    const struct stepper_transfer *const get = &turn->get[held];
    const fmi2Status status =
        get->function.get_integer(turn->instance, get->references, (size_t)get->count, receiver(get, step));

    scatter(get, held, step);
    return status;
}

static INLINE fmi2Status get_outputs(const struct stepper_turn *turn, int64_t step)
{
    const struct stepper_transfer *const reals = &turn->get[DOUBLE];
    fmi2Status status = fmi2OK;

    if (reals->count > 0) {
        status = reals->function.get_real(turn->instance, reals->references, (size_t)reals->count,
                                          receiver(reals, step));
        scatter(reals, DOUBLE, step);
    }
    if (turn->get[INT].count > 0 && status <= fmi2Warning)
        status = get_ints(turn, INT, step);
    if (turn->get[FLAG].count > 0 && status <= fmi2Warning)
        status = get_ints(turn, FLAG, step);
    return status;
}

/* Tells a slave's calls where their values are. */
static void place(struct stepper_turn *turn, double *const *courses, bool stepping)
{
    for (struct stepper_transfer *set = turn->set, *get = turn->get; set < turn->set + HELD; set++, get++) {
        for (int64_t i = 0; i < set->count; i++)
            set->values[i].values = courses[set->values[i].course] + (stepping ? set->values[i].this_step : 0);
        for (int64_t i = 0; i < get->count; i++)
            get->values[i].values = courses[get->values[i].course] + (stepping ? 1 : 0);
    }
}

int32_t it2core_stepper_exchange(struct stepper_turn *turn, double *const *courses, bool sets, int32_t *kind)
{
    fmi2Status status = fmi2OK;

    place(turn, courses, false);
    *kind = SET;
    if (sets)
        status = set_inputs(turn, 0);
    if (status <= fmi2Warning) {
        *kind = GET;
        status = get_outputs(turn, 0);
    }
    return (int32_t)status;
}

/* Return the status of a slave's turn in a step, and in `kind` which of its calls it is of. */
static INLINE fmi2Status take_turn(const struct stepper_turn *turn, int64_t step, double time, double step_size,
                                   int32_t *kind)
{
    fmi2Status status = set_inputs(turn, step);

    *kind = SET;
    if (status <= fmi2Warning) {
        *kind = STEP;
        status = turn->step(turn->instance, time, step_size, fmi2True);
    }
    if (status <= fmi2Warning) {
        *kind = GET;
        status = get_outputs(turn, step);
    }
    return status;
}

/* Return the number of complete steps, which is less than asked for where a slave refused one. */
int64_t it2core_stepper_run(struct stepper_turn *turns, int32_t slaves, double *const *courses,
                            int64_t first_step, int64_t steps, double step_size, struct stepper_fault *fault)
{
    for (int32_t i = 0; i < slaves; i++)
        place(&turns[i], courses, true);
    for (int64_t k = 0; k < steps; k++) {
        const double time = (double)(first_step + k) * step_size;
        for (int32_t i = 0; i < slaves; i++) {
            int32_t kind;
            const fmi2Status status = take_turn(&turns[i], k, time, step_size, &kind);
            if (status > fmi2Warning) {
                *fault = (struct stepper_fault){ i, kind, (int32_t)status };
                return k;
            }
        }
    }
    return steps;
}
